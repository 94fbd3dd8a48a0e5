#!/usr/bin/env python3
"""mdBook's preprocessor: what the chapters need that mdBook does not do.

- `{{#include FILE}}` takes a file of the repository over. Links of a Markdown file are meant from where it lies: they become links to the
  chapter that has the file, or else to the repository.
- `{{#notebook FILE}}` shows a notebook's text and code, `{{#python-reference}}` every public name of the Python package.
- TeX between `$` or `$$` becomes an element that Markdown leaves alone and the page gives to KaTeX.
"""

import base64
import html
import json
import os
import pathlib
import re
import sys

import python_reference

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SOURCE = ROOT / "docs" / "src"
EXECUTED = ROOT / "build" / "notebooks"
REPOSITORY = re.search(r'^repository = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.M).group(1)
MIME = {".svg": "image/svg+xml", ".png": "image/png"}

DIRECTIVE = re.compile(r"^\{\{#(include|notebook|python-reference)(?: (\S+))?\}\}$", re.M)
CODE = re.compile(r"(^(```+|~~~+).*?^\2\s*?$|(?<!`)(`+)(?!`).+?(?<!`)\3(?!`))", re.M | re.S)
MATHS = re.compile(r"(?<![\\$\w])(\$\$?)(?!\s)([^$]+?)(?<!\s)\1(?![$\w])|(?<!\S)\$\$\n(.+?)\n\$\$", re.S)
LINK = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")


def outside_code(change, text):
    """The text with `change` applied to what is neither a code block nor inline code."""
    parts = CODE.split(text)
    # The pattern has three groups: every fourth part is text, the one after it the code.
    return "".join(change(parts[i]) + (parts[i + 1] or "" if i + 1 < len(parts) else "") for i in range(0, len(parts), 4))


def formulas(text):
    """The TeX of every formula in a chapter, with whether it is displayed."""
    found = []
    outside_code(lambda part: found.extend((tex_of(m), is_display(m)) for m in MATHS.finditer(part)) or part, text)
    return found


def is_display(match):
    return match.group(3) is not None or match.group(1) == "$$"


def tex_of(match):
    return match.group(3) or match.group(2)


def protect_formula(match):
    """An element whose text is the TeX, every sign that Markdown could read written as a number."""
    tex = re.sub(r"[^\w\s]", lambda sign: f"&#{ord(sign.group())};", tex_of(match), flags=re.A)
    tex = re.sub(r"_", "&#95;", " ".join(tex.split()))
    return f'\n\n<div class="math">{tex}</div>\n\n' if is_display(match) else f'<span class="math">{tex}</span>'


def protected(text):
    return outside_code(lambda part: MATHS.sub(protect_formula, part), text)


def chapters_of_files():
    """Which chapter takes which file of the repository over."""
    found = {}
    for chapter in sorted(SOURCE.rglob("*.md")):
        for kind, name in DIRECTIVE.findall(chapter.read_text(encoding="utf-8")):
            if kind != "python-reference":
                found[(chapter.parent / name).resolve()] = chapter
    return found


def resolved(target, file, chapter, chapters):
    """The link `target` of `file` as it must stand in `chapter`."""
    if re.match(r"[a-z]+:|#", target):
        return target
    path, _, anchor = target.partition("#")
    place = (file.parent / path).resolve()
    anchor = f"#{anchor}" if anchor else ""
    if place in chapters:
        place = chapters[place]
    if SOURCE in place.parents:
        return pathlib.Path(os.path.relpath(place, chapter.parent)).as_posix() + anchor
    if place.suffix in MIME:
        return f"data:{MIME[place.suffix]};base64,{base64.b64encode(place.read_bytes()).decode()}"
    kind = "tree" if place.is_dir() else "blob"
    return f"{REPOSITORY}/{kind}/main/{place.relative_to(ROOT).as_posix()}{anchor}"


def with_links(text, file, chapter, chapters):
    return outside_code(lambda part: LINK.sub(lambda m: resolved(m.group(), file, chapter, chapters), part), text)


def notebook(file):
    """Text and code of a notebook as Markdown; with its outputs where `notebooks.py --save` has left them for the same cells."""
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    executed = EXECUTED / file.name
    if executed.exists():
        run = json.loads(executed.read_text(encoding="utf-8"))["cells"]
        if [cell["source"] for cell in run] == [cell["source"] for cell in cells]:
            cells = run
    return "\n\n".join(part for cell in cells for part in notebook_cell(cell))


def notebook_cell(cell):
    text = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        yield text
        return
    yield f"```python\n{text}\n```"
    for output in cell["outputs"]:
        data = output.get("data", {"text/plain": output.get("text", [])})
        if "image/png" in data:
            yield f"![](data:image/png;base64,{''.join(data['image/png']).strip()})"
        elif "InlineReport" in "".join(data["text/plain"]):
            yield "*(Here the notebook shows the run in 3-D.)*"
        else:
            yield f"```text\n{''.join(data['text/plain']).rstrip()}\n```"


def expanded(text, chapter, chapters):
    """A chapter's source with its directives carried out."""

    def directive(match):
        if match.group(1) == "python-reference":
            return python_reference.reference(ROOT / "crates/python/python/signorini")
        file = (chapter.parent / match.group(2)).resolve()
        if match.group(1) == "notebook":
            return protected(with_links(notebook(file), file, chapter, chapters))
        taken = file.read_text(encoding="utf-8")
        if file.suffix != ".md":
            return taken.rstrip()
        # Tables of programs name elements like <mesh>, which are text and no tags.
        return outside_code(lambda part: re.sub(r"<(?=\w+>)", "&lt;", part), with_links(taken, file, chapter, chapters))

    text = with_links(text, chapter, chapter, chapters)
    return DIRECTIVE.sub(directive, protected(text))


def each_chapter(items):
    for item in items:
        if "Chapter" in item:
            yield item["Chapter"]
            yield from each_chapter(item["Chapter"]["sub_items"])


def main():
    if sys.argv[1:2] == ["supports"]:
        sys.exit(sys.argv[2] != "html")
    _, book = json.load(sys.stdin)
    chapters = chapters_of_files()
    for chapter in each_chapter(book.get("items") or book["sections"]):
        if chapter["source_path"]:
            chapter["content"] = expanded(chapter["content"], SOURCE / chapter["source_path"], chapters)
    json.dump(book, sys.stdout)


if __name__ == "__main__":
    main()
