#!/usr/bin/env python3
"""Runs scenes that others published, and writes a line of JSON for each.

    run.py [--only REGEX] [--out FILE] [--patience SECONDS]     every scene, or those whose name matches
    run.py --table FILE                                         a table of the lines, in Markdown

The scenes are those of rigid-ipc, read from ../shared/data/assemblies/rigid_ipc (or `--rigid-ipc FOLDER`, a checkout of it), and houses of
cards of ../shared/peers/motion/scenes.py. Each run is a process of `model_run`, which has to be built:
cargo build --release -p signorini-benchmarks --bin model_run.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

import rigid_ipc

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared"
HOUSES = ["cards4", "cards4_struck", "cards10", "cards10_struck"]


def houses(folder, _):
    sys.path.insert(0, str(SHARED / "peers" / "motion"))
    import scenes

    for name in HOUSES:
        xml, seconds, _ = scenes.make(name, 0)
        model = folder / f"{name}.xml"
        model.write_text(xml)
        yield name, model, seconds, []


def assemblies(folder, given):
    """Meshes of mechanisms are not convex and touch triangle by triangle; all others are convex."""
    for fixture in sorted((given.rigid_ipc / "fixtures").rglob("*.json")):
        shape = "sdf" if "mechanisms" in fixture.parts else "mesh"
        model = rigid_ipc.convert(fixture, given.rigid_ipc.resolve() / "meshes", folder, shape)
        seconds = min(json.loads(fixture.read_text()).get("max_time", given.seconds), given.seconds)
        yield fixture.stem, model, seconds, ["--keyframe", "start", "--control", model.with_suffix(".control.json")]


def run(given, model, seconds, more):
    command = [given.program, model, "--duration", seconds, "--patience", given.patience, "--tolerance", given.tolerance, "--trace"]
    command += [model.with_suffix(".csv"), *more]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    row = {"end": "crash", "message": done.stderr[-300:]}
    for line in done.stdout.splitlines():
        row.update(json.loads(line))
    return {key: value for key, value in row.items() if key not in ("poses", "start", "left_out")}


def table(file):
    print("| scene | end | simulated, s | steps | missed | worst residual | deepest, m | contacts | median, ms | mean | p99 | longest | CPU, s |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    for row in map(json.loads, open(file)):
        if "steps" not in row:
            print(f"| {row['scene']} | {row['end']}: {row['message']} |" + " |" * 11)
            continue
        times = " | ".join(f"{row[key] / 1e3:.3g}" for key in ("median_us", "mean_us", "p99_us", "slowest_us"))
        print(f"| {row['scene']} | {row['end']} | {row['time']:.2f} of {row['seconds']:g} | {row['steps']} | {row['missed']} | {row['worst']:.1e} "
              f"| {row['deepest_mm'] / 1e3:.1e} | {row['contacts_max']} | {times} | {row['total_s']:.2f} |")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--only", metavar="REGEX", default="")
    options.add_argument("--seconds", type=float, default=5.0, help="simulated time at most")
    options.add_argument("--patience", type=float, default=150.0, help="CPU time of a run, s")
    options.add_argument("--tolerance", type=float, default=1e-9)
    options.add_argument("--rigid-ipc", type=pathlib.Path, default=SHARED / "data" / "assemblies" / "rigid_ipc")
    options.add_argument("--program", type=pathlib.Path, default=ROOT / "target" / "release" / "model_run")
    options.add_argument("--models", type=pathlib.Path, default=ROOT / "build" / "published", help="folder for the models and for what each step took")
    options.add_argument("--out", type=argparse.FileType("a"), default=sys.stdout)
    options.add_argument("--table", metavar="FILE")
    given = options.parse_args()
    if given.table:
        return table(given.table)
    given.models.mkdir(parents=True, exist_ok=True)
    for source, needed in ((houses, SHARED / "peers" / "motion"), (assemblies, given.rigid_ipc)):
        if not needed.is_dir():
            print(f"skipped: there are no scenes in {needed}")
            continue
        for name, model, seconds, more in source(given.models.resolve(), given):
            if re.search(given.only, name):
                print(json.dumps({"scene": name, "seconds": seconds, **run(given, model, seconds, more)}), file=given.out, flush=True)


if __name__ == "__main__":
    main()
