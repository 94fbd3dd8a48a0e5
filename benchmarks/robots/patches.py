"""How far models move apart that have at most eight points in a contact patch, and all of them.

    python3 benchmarks/robots/patches.py MODEL ... [--duration 0.1] [--points 8] [--program target/release/model_run]

What it prints: a line for every model with the largest distance between the places of a body, and the most contacts of a step.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys


def run(program, model, duration, points):
    keyframe = re.search(r'<key [^>]*name="(home)"', model.read_text())
    command = [program, model, "--duration", str(duration), "--contact-points", str(points)]
    command += ["--keyframe", "home"] if keyframe else []
    row = {}
    for line in subprocess.run(command, capture_output=True, text=True, check=False).stdout.splitlines():
        row.update(json.loads(line))
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    parser.add_argument("--duration", type=float, default=0.1)
    parser.add_argument("--points", type=int, default=8)
    parser.add_argument("--program", type=pathlib.Path, default=pathlib.Path("target/release/model_run"))
    options = parser.parse_args()
    print(f"| model | apart m | contacts with {options.points} | with all |")
    print("|---|---|---|---|")
    for model in options.models:
        few, all_points = (run(options.program, model, options.duration, points) for points in (options.points, 0))
        ends = {row["end"] for row in (few, all_points)}
        if ends != {"finished"}:
            print(f"| {model.parent.name}/{model.name} | {', '.join(sorted(ends))} | | |", flush=True)
            continue
        places = [(few["poses"][name][:3], all_points["poses"][name][:3]) for name in few["poses"]]
        apart = max((sum((a - b) ** 2 for a, b in zip(p, q)) ** 0.5 for p, q in places), default=0.0)
        print(f"| {model.parent.name}/{model.name} | {apart:.1e} | {few['contacts_max']} | {all_points['contacts_max']} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
