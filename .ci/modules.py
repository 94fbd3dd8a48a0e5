"""Which modules of a crate know which: read from `use` items, paths, and methods that another module adds to a type.

A module is a file. An edge goes from the file that names something to the file that defines it; re-exports are followed to the
definition and are no edges by themselves, nor are `mod` items. A type can be given methods in a file other than its own; who calls
one of these, where the name is defined once in the crate, knows that file. Tests (`#[cfg(test)]`) do not count.
"""

import pathlib
import re

ITEM = re.compile(
    r"(?:^|[;{}\]])\s*(?:pub(?:\([^)]*\))?\s+)?(?:default\s+|const\s+|async\s+|unsafe\s+|extern\s+)*"
    r"(?:struct|enum|union|trait|type|fn|const|static|macro_rules!|mod)\s+(?:mut\s+)?(\w+)"
)
USE = re.compile(r"(pub(?:\([^)]*\))?\s+)?\buse\s+([^;]+);")
PATH = re.compile(r"(?<![\w:.])(?:\w+::)+\w+")
IMPL = re.compile(r"(?:^|[;{}\]])\s*impl\b\s*(?=[<\w&'(\[])")
CHILD = re.compile(r"(?:pub(?:\([^)]*\))?\s+)?\bmod\s+(\w+)\s*;")


def without_texts(text):
    """The code with comments, strings and characters blanked."""
    pattern = re.compile(
        r"""//[^\n]*|/\*.*?\*/|b?r(\#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?'(?:\\(?:x..|u\{[^}]*\}|.)|[^\\'])'""", re.S
    )
    return pattern.sub(lambda m: " " if m[0].startswith("/") else '""', text)


def block_end(text, start):
    """Behind the bracket that closes the one at `start`."""
    depth = 0
    for k in range(start, len(text)):
        if text[k] in "{[(":
            depth += 1
        elif text[k] in "}])":
            depth -= 1
            if depth == 0:
                return k + 1
    return len(text)


def without_tests(text):
    """The code without items that are compiled for tests only, and the names of the test modules in files of their own."""
    kept, at, files = [], 0, set()
    for match in re.finditer(r"#\[cfg\(test\)\]", text):
        if match.start() < at:
            continue
        kept.append(text[at : match.start()])
        rest = re.compile(r"[;{]").search(text, match.end())
        at = len(text) if rest is None else rest.start() + 1 if rest[0] == ";" else block_end(text, rest.start())
        child = re.match(r"\s*(?:#\[[^\]]*\]\s*)*mod\s+(\w+)\s*;", text[match.end() : at])
        if child:
            files.add(child[1])
    kept.append(text[at:])
    return "".join(kept), files


def split_inline(text):
    """The code outside of inline modules, and the code of each of these."""
    kept, at, inline = [], 0, {}
    for match in re.finditer(r"(?:pub(?:\([^)]*\))?\s+)?\bmod\s+(\w+)\s*\{", text):
        if match.start() >= at:
            end = block_end(text, match.end() - 1)
            kept.append(text[at : match.start()])
            inline[match[1]] = text[match.end() : end - 1]
            at = end
    kept.append(text[at:])
    return "".join(kept), inline


def leaves(tree):
    """(path, name bound) of every leaf of a `use` tree; the name is `*` for a glob."""
    tree = " ".join(tree.split())
    brace = tree.find("{")
    if brace < 0:
        path, _, name = tree.partition(" as ")
        segments = [s.strip() for s in path.split("::") if s.strip()]
        if segments and segments[-1] == "self":
            segments.pop()
        return [(segments, name.strip() or segments[-1])] if segments else []
    prefix = [s.strip() for s in tree[:brace].split("::") if s.strip()]
    parts, depth, start = [], 0, brace + 1
    for k in range(brace + 1, len(tree)):
        if tree[k] == "{":
            depth += 1
        elif tree[k] == "}" and depth:
            depth -= 1
        elif tree[k] in ",}" and depth == 0:
            parts.append(tree[start:k].strip())
            start = k + 1
    found = []
    for part in filter(None, parts):
        if part == "self":
            found.append((prefix, prefix[-1]))
        else:
            found += [(prefix + path, name) for path, name in leaves(part)]
    return found


def own_items(text):
    """Names of the items defined at any depth, which may be a few too many, and never one too few."""
    return {match[1] for match in ITEM.finditer(text)}


class Module:
    """One file, or an inline module in it."""

    def __init__(self, path, file, text):
        self.path, self.file = path, file
        self.children = set(CHILD.findall(text))
        self.uses = [(bool(m[1]), path, name) for m in USE.finditer(text) for path, name in leaves(m[2])]
        self.body = CHILD.sub("", USE.sub(";", text))
        self.items = own_items(self.body)
        self.bound = {name: path for _, path, name in self.uses if name != "*"}
        self.globs = [path[:-1] if path[-1] == "*" else path for _, path, name in self.uses if name == "*"]


class Crate:
    """The modules of a crate and the edges between them."""

    def __init__(self, source):
        self.modules = {}
        root = next((source / name for name in ("lib.rs", "main.rs") if (source / name).exists()), None)
        if root:
            self.read(root, (), source)
        self.edges = {}
        for module in self.modules.values():
            for target, name in self.targets(module):
                self.connect(module.file, target.file, name)
        self.add_methods()

    def connect(self, file, other, name):
        """An edge, and what it comes from."""
        if file != other:
            self.edges.setdefault(file, {}).setdefault(other, set()).add(name)

    def read(self, file, path, folder):
        text, tests = without_tests(without_texts(file.read_text()))
        text, inline = split_inline(text)
        self.add(path, file, text, inline)
        for name in self.modules[path].children - tests:
            below = folder / name
            child = next((f for f in (folder / f"{name}.rs", below / "mod.rs") if f.exists()), None)
            if child:
                self.read(child, path + (name,), below)

    def add(self, path, file, text, inline):
        module = self.modules[path] = Module(path, file, text)
        for name, code in inline.items():
            module.children.add(name)
            own, deeper = split_inline(code)
            self.add(path + (name,), file, own, deeper)

    def absolute(self, module, segments):
        """A path from the root of the crate, or nothing where it leads out of it."""
        at, rest = module.path, list(segments)
        if rest[0] == "crate":
            return (), rest[1:]
        if rest[0] == "self":
            return at, rest[1:]
        if rest[0] == "super":
            while rest and rest[0] == "super":
                at, rest = at[:-1], rest[1:]
            return at, rest
        if rest[0] in module.children:
            return at, rest
        return None

    def resolve(self, module, segments, seen=frozenset()):
        """The module that defines what a path names, or nothing."""
        if not segments or (module.path, tuple(segments)) in seen:
            return None
        seen = seen | {(module.path, tuple(segments))}
        start = self.absolute(module, segments)
        if start is None:
            if segments[0] in module.bound:
                return self.resolve(module, module.bound[segments[0]] + list(segments[1:]), seen)
            return None
        at, rest = start
        while rest and at + (rest[0],) in self.modules:
            at, rest = at + (rest[0],), rest[1:]
        found = self.modules.get(at)
        if found is None or not rest:
            return found
        # What a module names without defining it is another crate's, or a macro's and then its own.
        return self.lookup(found, rest, seen) or (None if rest[0] in found.bound else found)

    def lookup(self, module, segments, seen):
        """The module that defines a name which `module` defines or re-exports."""
        name = segments[0]
        if name in module.bound and module.bound[name] != list(segments):
            return self.resolve(module, module.bound[name] + list(segments[1:]), seen)
        if name in module.items:
            return module
        for path in module.globs:
            target = self.resolve(module, path, seen)
            if target and (name in target.items or name in target.bound):
                return self.lookup(target, segments, seen)
        return None

    def targets(self, module):
        for public, path, name in module.uses:
            path = path[:-1] if path[-1] == "*" else path
            if public and not (name != "*" and re.search(rf"\b{name}\b", module.body)):
                continue
            target = self.resolve(module, path)
            if target:
                yield target, path[-1]
        for match in PATH.finditer(module.body):
            segments = match[0].split("::")
            if self.absolute(module, segments) is not None or segments[0] in module.bound:
                target = self.resolve(module, segments)
                if target:
                    yield target, match[0]

    def add_methods(self):
        """Edges to the files that add methods to types of other files."""
        written, added = {}, {}
        for module in self.modules.values():
            for name in re.findall(r"\bfn\s+(\w+)", module.body):
                written.setdefault(name, []).append(module.file)
            for match in IMPL.finditer(module.body):
                brace = module.body.find("{", match.end())
                head = module.body[match.end() : brace]
                if re.search(r"\bfor\b(?!\s*<)", head):
                    continue
                named = re.sub(r"^<[^{]*?>\s*(?=\w)", "", head).strip()
                owner = self.resolve(module, re.match(r"[\w:]+", named)[0].split("::")) if named else None
                if owner and owner.file != module.file:
                    body = module.body[brace : block_end(module.body, brace)]
                    for name, rest in re.findall(r"\bfn\s+(\w+)[^(]*\(((?:[^,)]*\bself\b\s*,?)?\s*\)?)", body):
                        added[name] = module.file, rest.endswith(")")
        added = {name: end for name, end in added.items() if len(written[name]) == 1}
        for module in self.modules.values():
            for name, end in set(re.findall(r"[.:](\w+)(?:::<[^>]*>)?\(\s*(\)?)", module.body)):
                # A call without arguments of a method that takes some is one of another type.
                if name in added and added[name][1] == bool(end):
                    self.connect(module.file, added[name][0], f".{name}()")

    def circles(self):
        """Sets of files that reach each other (Tarjan's components of more than one), the smallest first."""
        index, low, stack, found = {}, {}, [], []

        def visit(node):
            index[node] = low[node] = len(index)
            stack.append(node)
            for other in sorted(self.edges.get(node, ())):
                if other not in index:
                    visit(other)
                    low[node] = min(low[node], low[other])
                elif other in stack:
                    low[node] = min(low[node], index[other])
            if low[node] == index[node]:
                component = set()
                while True:
                    component.add(stack.pop())
                    if node in component:
                        break
                if len(component) > 1:
                    found.append(component)

        for node in sorted(self.edges):
            if node not in index:
                visit(node)
        return sorted(found, key=len)


def report(crate, circle, root):
    """The edges within a circle, for a message."""
    lines = []
    for file in sorted(circle):
        for other, names in sorted(crate.edges.get(file, {}).items()):
            if other in circle:
                lines.append(f"    {file.relative_to(root)} knows {other.relative_to(root)}: {', '.join(sorted(names))}")
    return "\n".join(lines)


if __name__ == "__main__":
    import sys

    for source in sys.argv[1:]:
        root = pathlib.Path(source).resolve()
        crate = Crate(root)
        circles = crate.circles()
        print(f"{source}: {len(crate.modules)} modules, {sum(map(len, crate.edges.values()))} edges, {len(circles)} circles")
        for circle in circles:
            print(f"  {len(circle)} files\n{report(crate, circle, root)}")
