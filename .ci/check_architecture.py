#!/usr/bin/env python3
"""Compares who imports whom with the table in ARCHITECTURE.md, keeps certificates apart from solvers, and finds circles inside crates.

The table's rows read: | `crates/NAME` | purpose | imports |, the last column a list of crate names or a dash.
What certifies may not import a crate that solves, directly or through others.
Development dependencies do not count. The modules of a crate know each other in one direction (`modules.py`, which is tested first).
"""

import json
import pathlib
import re
import subprocess
import sys
import unittest

import modules

import bars

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOLVES = {"lcp", "sparse", "solver", "laws"}
CERTIFIES = {"check", "contact"}


def allowed():
    table = {}
    for line in (ROOT / "ARCHITECTURE.md").read_text().splitlines():
        row = re.match(r"\| `((?:crates/)?\w+)` \|.*\| ([^|]*) \|$", line)
        if row:
            table[row[1]] = set(re.findall(r"[a-z]+", row[2]))
    return table


def reached(imports, start):
    """All crates that one imports, directly or through others."""
    found, ahead = set(), [start]
    while ahead:
        new = imports.get(ahead.pop(), set()) - found
        found |= new
        ahead += new
    return found


def circles():
    """The circles among the modules of every crate, in words."""
    found = []
    for source in sorted([*ROOT.glob("crates/*/src"), *ROOT.glob("benchmarks/src")]):
        crate = modules.Crate(source)
        for circle in crate.circles():
            found.append(f"{source.relative_to(ROOT)}: {len(circle)} files in a circle\n{modules.report(crate, circle, source)}")
    return found


def main():
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps", "--locked"]
    packages = json.loads(subprocess.check_output(command, cwd=ROOT))["packages"]
    folder = {p["name"]: str(pathlib.Path(p["manifest_path"]).parent.relative_to(ROOT)) for p in packages}
    table, wrong, imports = allowed(), [], {}
    for package in packages:
        name = folder[package["name"]]
        if name not in table:
            wrong.append(f"{name} has no row in ARCHITECTURE.md")
            continue
        used = {folder[d["name"]] for d in package["dependencies"] if d["name"] in folder and d["kind"] != "dev"}
        imports[pathlib.Path(name).name] = {pathlib.Path(other).name for other in used}
        for other in sorted(used):
            if pathlib.Path(other).name not in table[name]:
                wrong.append(f"{name} imports {other}, which ARCHITECTURE.md does not allow")
    missing = (SOLVES | CERTIFIES) - imports.keys()
    wrong += [f"{name}, which solves or certifies, is no crate: correct the names in {__file__}" for name in sorted(missing)]
    for name in sorted(CERTIFIES):
        solvers = reached(imports, name) & SOLVES
        wrong += [f"{name} certifies and must not import {other}, which solves" for other in sorted(solvers)]
    wrong += [f"ARCHITECTURE.md lists {name}, which does not exist" for name in table if not (ROOT / name).is_dir()]
    wrong += circles()
    exceeded, tuned = bars.check(ROOT)
    wrong += exceeded
    kept = f"{len(packages)} crates import what ARCHITECTURE.md allows, and none has a circle inside; {tuned} numbers are tuned"
    print("\n".join(wrong) or kept)
    sys.exit(bool(wrong))


if __name__ == "__main__":
    tested = unittest.TextTestRunner(verbosity=0).run(unittest.defaultTestLoader.loadTestsFromName("modules_test"))
    if not tested.wasSuccessful():
        sys.exit(1)
    main()
