#!/usr/bin/env python3
"""Compares who imports whom with the table in ARCHITECTURE.md.

The table's rows read: | `crates/NAME` | purpose | imports |, the last column a list of crate names or a dash.
Development dependencies do not count.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def allowed():
    table = {}
    for line in (ROOT / "ARCHITECTURE.md").read_text().splitlines():
        row = re.match(r"\| `((?:crates/)?\w+)` \|.*\| ([^|]*) \|$", line)
        if row:
            table[row[1]] = set(re.findall(r"[a-z]+", row[2]))
    return table


def main():
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps", "--locked"]
    packages = json.loads(subprocess.check_output(command, cwd=ROOT))["packages"]
    folder = {p["name"]: str(pathlib.Path(p["manifest_path"]).parent.relative_to(ROOT)) for p in packages}
    table, wrong = allowed(), []
    for package in packages:
        name = folder[package["name"]]
        if name not in table:
            wrong.append(f"{name} has no row in ARCHITECTURE.md")
            continue
        used = {folder[d["name"]] for d in package["dependencies"] if d["name"] in folder and d["kind"] != "dev"}
        for other in sorted(used):
            if pathlib.Path(other).name not in table[name]:
                wrong.append(f"{name} imports {other}, which ARCHITECTURE.md does not allow")
    wrong += [f"ARCHITECTURE.md lists {name}, which does not exist" for name in table if not (ROOT / name).is_dir()]
    print("\n".join(wrong) or f"{len(packages)} crates import what ARCHITECTURE.md allows")
    sys.exit(bool(wrong))


main()
