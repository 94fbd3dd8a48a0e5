#!/usr/bin/env python3
"""Runs the notebooks, or removes their outputs.

    notebooks.py                  every notebook in docs/notebooks from its first cell to its last, in a kernel of this Python; needs
                                  nbclient and ipykernel
    notebooks.py --save FOLDER    the same, and writes them there with their outputs, for the site
    notebooks.py --strip          leaves text and code of every notebook, without outputs; needs nothing
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "notebooks"


def strip(file):
    """Rewrites a notebook without what belongs to one run of it."""
    notebook = json.loads(file.read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        cell["metadata"] = {}
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
    notebook["metadata"] = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    file.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def run(file, saved):
    """Executes a notebook; a cell that raises ends the program."""
    import nbclient
    import nbformat

    begin = time.monotonic()
    notebook = nbformat.read(file, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": folder}})
        client.execute(stderr=subprocess.DEVNULL)  # errors of cells come as messages; this is the kernel's log
    if saved:
        saved.mkdir(parents=True, exist_ok=True)
        nbformat.write(notebook, saved / file.name)
    shown = sum(bool(cell.get("outputs")) for cell in notebook.cells)
    if shown == 0:
        sys.exit(f"{file.name} shows nothing")
    print(f"{file.name}: {len(notebook.cells)} cells, {shown} with outputs, {time.monotonic() - begin:.1f} s")


def main():
    folder = pathlib.Path(sys.argv[2]).resolve() if sys.argv[1:2] == ["--save"] else None
    for file in sorted(FOLDER.glob("*.ipynb")):
        strip(file) if sys.argv[1:2] == ["--strip"] else run(file, folder)


if __name__ == "__main__":
    main()
