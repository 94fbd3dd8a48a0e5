"""Where the instructions of a step go, stage by stage, counted by callgrind.

    python3 benchmarks/sim/stages.py [SCENE=SECONDS ...] [--sim target/release/sim]

Needs valgrind, the program `sim` and its scenes. Only what happens inside a step counts; the scenes are cut to a few seconds or steps.
"""

import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile

BUILD = pathlib.Path(__file__).resolve().parents[2] / "build" / "peers"
USUAL = {"S1_stick": 1.0, "S2_stack10": 0.1, "S3_wall10": 0.05, "S6_quadruped": 2.4, "S7_humanoid": 5.0, "S10_chain": 0.1, "S12_gripper": 0.4}
# Functions of the step, by how callgrind names them; what they call counts as theirs.
STAGES = {
    "kinematics": ["kinematics::forward_kinematics_into", "reach::BodyReach::body_velocities"],
    "free motion": ["free_motion::free_motion_into"],
    "collision": ["collider::Collider::find"],
    "rows": ["jacobian::contact_rows_into"],
    "solve": ["step::Workspace::solve"],
    "certificate": ["certificate::certify_with"],
    "integration": ["configuration::integrate_into"],
}


def profile(program, name, seconds, folder):
    """Function → instructions with all that it calls, and the number of steps."""
    scene = json.loads((BUILD / "sim" / "scenes.json").read_text())[name] | dict(duration=seconds)
    data, out = folder / f"{name}.json", folder / f"{name}.callgrind"
    data.write_text(json.dumps({name: scene}))
    tool = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--toggle-collect=signorini::step::step"]
    run = [*tool, program, name, "--data", data, "--robots", BUILD / "robots", "--cap", "100000"]
    environment = os.environ | {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX"}
    subprocess.run(list(map(str, run)), check=True, capture_output=True, env=environment)
    text = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", out], check=True, capture_output=True, text=True).stdout
    rows = re.findall(r"^\s*([\d,]+) \([ \d.]+%\)\s+\S*?:(.+?) \[", text, re.MULTILINE)
    return {function: int(count.replace(",", "")) for count, function in rows}, round(seconds / scene["dt"])


def split(functions):
    """Stage → instructions."""
    total = next(count for name, count in functions.items() if name == "signorini::step::step")
    stages = {stage: sum(n for f, n in functions.items() if any(f.endswith(name) for name in names)) for stage, names in STAGES.items()}
    stages["solve"] -= stages["certificate"]
    return total, stages | {"rest": total - sum(stages.values())}


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("scenes", nargs="*", default=[f"{name}={seconds}" for name, seconds in USUAL.items()])
    options.add_argument("--sim", default="target/release/sim")
    options = options.parse_args()
    print("| scene | instructions a step | " + " | ".join([*STAGES, "rest"]) + " |")
    print("|" + "---|" * (len(STAGES) + 3))
    with tempfile.TemporaryDirectory() as folder:
        for argument in options.scenes:
            name, seconds = argument.split("=")
            functions, steps = profile(options.sim, name, float(seconds), pathlib.Path(folder))
            total, stages = split(functions)
            cells = [f"{100 * stages[stage] / total:.1f} %" for stage in [*STAGES, "rest"]]
            print(f"| {name} | {total / steps:,.0f} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
