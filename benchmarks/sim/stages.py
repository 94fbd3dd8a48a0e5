"""Where the instructions of a step go, stage by stage, counted by callgrind.

    python3 benchmarks/sim/stages.py [SCENE=FROM-TO ...] [--sim target/release/sim] [--data SCENES.json]

Needs valgrind, the program `sim` and its scenes. Only what happens inside a step counts, and of the steps those between two times (s):
each scene is run to the one and to the other, and the counts are subtracted, so that the first, cold steps are not in them.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile

BUILD = pathlib.Path(__file__).resolve().parents[2] / "build" / "peers"
USUAL = {
    "S1_stick": "0.2-1.0",
    "S2_stack10": "0.05-0.2",
    "S2_stack20": "0.05-0.2",
    "S3_wall10": "0.02-0.12",
    "S6_quadruped": "0.4-2.4",
    "S7_humanoid": "3.5-4.5",
    "S10_chain": "0.02-0.1",
    "S12_gripper": "0.1-0.4",
}
STEP = "signorini_simulation::step::step"
# Functions of the step, by how callgrind names them; what they call counts as theirs.
STAGES = {
    "kinematics": ["kinematics::forward_kinematics_beside", "kinematics::body_velocities_into"],
    "free motion": ["free_motion::free_motion_beside"],
    "collision": ["phases::<impl signorini_simulation::workspace::Workspace>::find_points"],
    "rows": ["builder::ProblemBuilder>::push_points"],
    "solve": ["permitted::<impl signorini_simulation::workspace::Workspace>::solve"],
    "certificate": ["certificate::certify_with"],
}


def require_names(program):
    """Ends where the program has no function of one of these names: its instructions would count as `rest`."""
    symbols = subprocess.run(["nm", "-C", program], check=True, capture_output=True, text=True).stdout.splitlines()
    lacking = [name for names in [[STEP], *STAGES.values()] for name in names if not any(line.endswith(name) for line in symbols)]
    if lacking:
        raise SystemExit(f"{program} has no function {', '.join(lacking)}: name in {__file__} those that are there")


def profile(program, scenes, name, seconds, folder):
    """Function → instructions of all steps of a run, with all that it calls, and the number of steps."""
    scene = json.loads(scenes.read_text())[name] | dict(duration=seconds)
    data, out = folder / f"{name}.json", folder / f"{name}.callgrind"
    data.write_text(json.dumps({name: scene}))
    tool = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", f"--toggle-collect={STEP}"]
    run = [*tool, program, name, "--data", data, "--robots", BUILD / "robots", "--cap", "100000"]
    environment = os.environ | {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX"}
    subprocess.run(list(map(str, run)), check=True, capture_output=True, env=environment)
    text = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", out], check=True, capture_output=True, text=True).stdout
    rows = re.findall(r"^\s*([\d,]+) \([ \d.]+%\)\s+\S*?:(.+?) \[", text, re.MULTILINE)
    return {function: int(count.replace(",", "")) for count, function in rows}, round(seconds / scene["dt"])


def between(program, scenes, name, start, end, folder):
    """Function → instructions of a step between two times, with all that it calls."""
    (first, few), (last, many) = (profile(program, scenes, name, until, folder) for until in (start, end))
    return {function: (count - first.get(function, 0)) / (many - few) for function, count in last.items()}


def split(functions):
    """Stage → instructions."""
    total = next(count for name, count in functions.items() if name == STEP)
    stages = {stage: sum(n for f, n in functions.items() if any(f.endswith(name) for name in names)) for stage, names in STAGES.items()}
    stages["solve"] -= stages["certificate"]
    return total, stages | {"rest": total - sum(stages.values())}


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("scenes", nargs="*", default=[f"{name}={times}" for name, times in USUAL.items()])
    options.add_argument("--sim", default="target/release/sim")
    options.add_argument("--data", type=pathlib.Path, default=BUILD / "sim" / "scenes.json", help="the file that scenes.py makes")
    options = options.parse_args()
    require_names(options.sim)
    print("| scene | instructions a step | " + " | ".join([*STAGES, "rest"]) + " |")
    print("|" + "---|" * (len(STAGES) + 3))
    with tempfile.TemporaryDirectory() as folder:
        for argument in options.scenes:
            name, times = argument.split("=")
            total, stages = split(between(options.sim, options.data, name, *map(float, times.split("-")), pathlib.Path(folder)))
            cells = [f"{stages[stage]:,.0f}" for stage in [*STAGES, "rest"]]
            print(f"| {name} | {total:,.0f} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
