#!/usr/bin/env python3
"""Runs scenes in motion to their ends, and writes a line of JSON for each run.

    run.py [NAME ...] [--seeds A..B] [--judge] [--out FILE]              whole runs
    run.py NAME --steps 1000000 [--bodies 12] [--seeds A..B] [--judge]   long runs in parts, with saved state between them
    run.py --table FILE                                                  a table of the lines, in Markdown

The scenes are those of ../shared/peers/motion/scenes.py (cards, a shaken bin, a drum, a mixer, a groove, necklaces, walls, piles); each run
is a process of `model_run`, which has to be built: cargo build --release -p signorini-benchmarks --bin model_run.
"""
import argparse
import itertools
import json
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SCENES = ROOT.parent / "shared" / "peers" / "motion"
FEW = 100  # Steady steps of a run, of which the slowest hundredth can be told.
PERIOD = 10.0  # s, after which every control of the scenes repeats itself or stands


def seeds(text):
    first, _, last = text.partition("..")
    return range(int(first), int(last) if last else int(first) + 1)


def thinned(xml, bodies):
    """The scene with its first `bodies` free bodies alone."""
    count = itertools.count()
    free = re.compile(r"<body [^>]*><freejoint/>.*?</body>", re.S)
    return free.sub(lambda found: found.group() if next(count) < bodies else "", xml)


def controls(control, first, steps, timestep):
    return [control((first + k) * timestep) for k in range(steps)] if control else []


def call(given, folder, xml, control, first, steps, timestep, snapshot=None):
    """One process of `model_run`: its last line."""
    model, numbers = folder / "scene.xml", folder / "control.json"
    model.write_text(xml)
    numbers.write_text(json.dumps(controls(control, first, steps, timestep)))
    command = [given.program, model, "--control", numbers, "--duration", f"{steps * timestep:.9g}", "--patience", str(given.patience)]
    command += ["--judge"] * given.judge + (["--snapshot", snapshot] if snapshot else [])
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode or not done.stdout.strip():
        return {"end": "crash", "message": done.stderr[-300:]}
    return {key: value for key, value in json.loads(done.stdout.splitlines()[-1]).items() if key not in ("poses", "start")}


def whole(given, xml, seconds, control, timestep, folder):
    return call(given, folder, xml, control, 0, round(seconds / timestep), timestep)


def in_parts(given, xml, control, timestep, folder):
    """`given.steps` steps, a period of the controls in each process, which goes on from the state that the one before it saved."""
    part, total = round(PERIOD / timestep), {}
    for first in range(0, given.steps, part):
        result = call(given, folder, xml, control, first, min(part, given.steps - first), timestep, folder / "state")
        parts = total.get("parts", 0) + 1
        total = {**merged(total, result), "parts": parts}
        if result["end"] != "finished":
            break
        if given.progress:
            pathlib.Path(given.progress).write_text(json.dumps(total))
    return total


def merged(total, part):
    if not total:
        return dict(part)
    out = dict(part)
    for key in ("steps", "steady_steps", "missed", "limited", "judged_wrong", "total_s", "factorizations", "correction_energy"):
        out[key] = total.get(key, 0) + part.get(key, 0)
    for key in ("worst", "judged_worst", "deepest_mm", "deepest_kept", "contacts_max", "slowest_us"):
        out[key] = max(total.get(key, 0), part.get(key, 0))
    out["smallest_theta"] = min(total.get("smallest_theta", 1), part.get("smallest_theta", 1))
    # The memory of every part, after its first steps and at its end.
    out["resident_kib"] = total["resident_kib"][:2] + [part.get("resident_kib", [0, 0])[1]] if "resident_kib" in total else []
    return out


def table(file):
    lines = [json.loads(line) for line in open(file)]
    print("| scene | runs | ended | steps | missed | θ < 1 | deepest overlap, mm | worst residual | p50, µs | p99 / p50 | max / p50 "
          "| steady | p99 / p50 | max / p50 |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name in dict.fromkeys(line["scene"] for line in lines):
        runs = [line for line in lines if line["scene"] == name and "steps" in line]
        ended = sum(run["end"] == "finished" for run in runs)
        total = lambda key: sum(run[key] for run in runs)
        most = lambda key: max(run[key] for run in runs)
        ratios = lambda key: " to ".join(f"{x:.1f}" for x in extremes(run[key] / run["median_us"] for run in runs))
        long = [run for run in runs if run["steady_steps"] >= FEW]
        steady = lambda key: " to ".join(f"{x:.1f}" for x in extremes(run["steady_" + key] / run["steady_median_us"] for run in long)) or "–"
        p50 = " to ".join(f"{x:.0f}" for x in extremes(run["median_us"] for run in runs))
        print(f"| {name} | {len(runs)} | {ended} | {total('steps')} | {total('missed')} | {total('limited')} | {most('deepest_mm'):.3g} "
              f"| {most('worst'):.1e} | {p50} | {ratios('p99_us')} | {ratios('slowest_us')} "
              f"| {total('steady_steps') / total('steps'):.0%} | {steady('p99_us')} | {steady('slowest_us')} |")


def extremes(numbers):
    numbers = list(numbers)
    return (min(numbers), max(numbers)) if len(numbers) > 1 else numbers


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("names", nargs="*")
    options.add_argument("--seeds", type=seeds, default=range(1))
    options.add_argument("--steps", type=int)
    options.add_argument("--bodies", type=int)
    options.add_argument("--patience", type=float, default=600.0, help="CPU time of one process, s")
    options.add_argument("--judge", action="store_true")
    options.add_argument("--out")
    options.add_argument("--progress", help="file for the sums of a long run so far")
    options.add_argument("--program", default=ROOT / "target" / "release" / "model_run")
    options.add_argument("--table")
    given = options.parse_args()
    if given.table:
        return table(given.table)
    if not SCENES.is_dir():
        print(f"skipped: there are no scenes in {SCENES}")
        return None
    sys.path.insert(0, str(SCENES))
    import scenes
    out = open(given.out, "a") if given.out else sys.stdout
    for name, seed in itertools.product(given.names or scenes.SCENES, given.seeds):
        xml, seconds, control = scenes.make(name, seed)
        timestep = float(re.search(r'timestep="([^"]*)"', xml).group(1))
        xml = thinned(xml, given.bodies) if given.bodies is not None else xml
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            run = in_parts(given, xml, control, timestep, folder) if given.steps else whole(given, xml, seconds, control, timestep, folder)
        print(json.dumps({"scene": name, "seed": seed, **run}), file=out, flush=True)


if __name__ == "__main__":
    main()
