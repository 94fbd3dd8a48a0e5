"""The bars of the crates that state and solve contact problems: lines of files and functions, branch points, tuned numbers.

A branch point is an `if`, `for`, `while` or `loop`, an arm of a `match`, `&&` or `||`. Tests (`#[cfg(test)]`) count for the lines
of files alone. A tuned number is a field of a `struct Tuning`, whose one instance is a constant with a doc comment that says what
chose it. Outside of these the solver has no decimal numbers but plain ones, and no constants
that are a number but those of `EXACT`; what users may set is in `settings.rs`.
"""

import pathlib
import re

from modules import block_end, without_tests, without_texts

BARRED = ["contact", "solver", "sparse", "laws"]
FILE_LINES, FUNCTION_LINES, BRANCHES = 400, 60, 15
TUNED, MOST_TUNED = ["solver", "sparse"], 60
# Halves and small whole numbers belong to formulas.
PLAIN = {"0.0", "0.5", "1.0", "2.0", "3.0", "4.0"}
# Numbers that follow from arithmetic, from data or from the layout of memory.
EXACT = {
    "NONE": "no index",
    "SEPARATOR": "a name for one of three sides",
    "FREE": "degrees of freedom of a free body",
    "LIMB": "degrees of freedom of a limb, for code that is unrolled",
    "SUMS": "numbers in the widest vector",
    "FEW_COLUMNS": "numbers in a vector",
    "COMPARED": "numbers in a few lines of the cache",
}

FUNCTION = re.compile(r"\bfn\s+(\w+)")
BRANCH = re.compile(r"\b(?:if|for|while|loop)\b|=>|&&|\|\|(?=\s*[^{|\s])")
CLOSURE = re.compile(r"(?:[(,=]|\bmove|\breturn)\s*\|\|")
STRUCT = re.compile(r"\bstruct\s+Tuning\s*\{([^}]*)\}")
INSTANCE = re.compile(r"\bconst\s+\w+\s*:\s*Tuning\s*=\s*Tuning\s*\{")
FIELD = re.compile(r"(\w+)\s*:\s*([^,;\[\]]+|\[[^\]]*;\s*(\d+)\s*\])\s*(?:,|$)")
CONSTANT = re.compile(r"\b(?:const|static)\s+(\w+)\s*:\s*[\[\]\w;,() ]+=\s*-?(?:[\d_.e-]+;|[\[(]-?\d)")
DECIMAL = re.compile(r"(?<![\w.])\d[\d_]*\.\d[\d_]*(?:e-?\d+)?|(?<![\w.])\d[\d_]*e-?\d+")


def functions(code):
    """Name, lines and branch points of every function; one inside another counts for both."""
    for match in FUNCTION.finditer(code):
        arguments = block_end(code, code.index("(", match.end()))
        body = re.compile(r"[;{]").search(code, arguments)
        if body is None or body[0] == ";":
            continue
        end = block_end(code, body.start())
        text = CLOSURE.sub(" ", code[body.start() : end])
        yield match[1], code.count("\n", match.start(), end) + 1, len(BRANCH.findall(text))


def exceeded(name, text):
    """What a file exceeds of the bars of files and functions."""
    lines = text.count("\n")
    if lines > FILE_LINES:
        yield f"{name} has {lines} lines, more than {FILE_LINES}"
    for function, lines, branches in functions(without_tests(without_texts(text))[0]):
        if lines > FUNCTION_LINES:
            yield f"{name}: {function} has {lines} lines, more than {FUNCTION_LINES}"
        if branches > BRANCHES:
            yield f"{name}: {function} has {branches} branch points, more than {BRANCHES}"


def tuned(text):
    """The names of a file's tuned numbers, one of an array for each of its entries."""
    code = without_texts(text)
    for struct in STRUCT.finditer(code):
        for field in FIELD.finditer(re.sub(r"\bpub(?:\([^)]*\))?\s", " ", struct[1])):
            yield from [field[1]] * int(field[3] or 1)


def hidden(name, text):
    """Numbers of a file that look tuned and stand in no `Tuning`, and instances of it that do not say what chose them."""
    code = without_tests(without_texts(text))[0]
    for match in reversed(list(INSTANCE.finditer(code))):
        code = code[: match.start()] + code[block_end(code, match.end() - 1) :]
    for match in INSTANCE.finditer(text):
        comment = re.search(r"(?:[ \t]*///[^\n]*\n)+[^\n]*$", text[: match.start() + 5])
        if comment is None or "hosen by" not in comment[0]:
            yield f"{name}: a Tuning does not say what it was chosen by"
    for match in CONSTANT.finditer(code):
        if match[1] not in EXACT:
            yield f"{name}: the constant {match[1]} stands in no Tuning"
    for match in DECIMAL.finditer(code):
        if match[0].rstrip("_") not in PLAIN:
            yield f"{name}: the number {match[0]} stands in no Tuning"


def check(root):
    """Everything that exceeds a bar, and the count of tuned numbers."""
    wrong, names = [], []
    for crate in BARRED:
        for file in sorted((root / "crates" / crate / "src").rglob("*.rs")):
            name, text = file.relative_to(root), file.read_text()
            wrong += exceeded(name, text)
            if crate in TUNED and file.name != "settings.rs" and "tests" not in file.stem and file.stem != "testing":
                wrong += hidden(name, text)
                names.append(list(tuned(text)))
    count, once = sum(map(len, names)), [name for own in names for name in set(own)]
    wrong += [f"two tuned numbers are named {name}" for name in sorted(set(once)) if once.count(name) > 1]
    if count > MOST_TUNED:
        wrong.append(f"{count} numbers are tuned, more than {MOST_TUNED}")
    return wrong, count


if __name__ == "__main__":
    found, count = check(pathlib.Path(__file__).resolve().parent.parent)
    print("\n".join(found), f"{count} tuned numbers", sep="\n")
