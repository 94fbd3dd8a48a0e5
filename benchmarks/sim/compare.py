"""Runs the scenes in every engine, judges the runs, and writes results, tables and plot.

    build/peers/venv/bin/python benchmarks/sim/compare.py [SCENE ...] [--engines NAME ...] [--cap 10] [--repetitions 3]

Engines take turns scene by scene, repetition by repetition, each in a process of its own with one thread. A run that has used up
its `--cap` seconds of CPU time is cut off there and not repeated. `--judge` judges the runs that are there and runs nothing.
"""

import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys
import time

import report

HERE = pathlib.Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build" / "peers"
SCENES, ROBOTS, RAW = BUILD / "sim" / "scenes.json", BUILD / "robots", BUILD / "sim" / "raw"
ENGINES = ["signorini", "mujoco", "drake", "bullet", "dart", "ode", "rapier"]
PYTHON_PEERS = {"mujoco", "drake", "bullet", "dart"}
ROBOT_PEERS = {"signorini", "mujoco", "drake", "bullet", "dart"}
# A large pile that settles has steps whose last digit costs more than all the others.
PILES_TOLERANCE = 1e-8
LARGE = ("1000", "3000", "3038", "10000")
MIDDLING = ("300", "306")


def variants(engine, name, scene, budgets=()):
    """What of an engine makes sense on a scene."""
    large, pile = name.endswith(LARGE), name.startswith(("S4", "S5", "S13"))
    if "robot" in scene and engine not in ROBOT_PEERS:
        return []
    if "urdf" not in scene and "robot" in scene and engine not in ("signorini", "mujoco"):
        return []  # the humanoid is an MJCF file with parts that URDF has no words for
    if engine == "signorini":
        return [f"{sweeps} sweeps" for sweeps in budgets] or ["default"]
    if engine == "mujoco":
        return ["cg"] if large else (["default", "cg"] if pile else ["default", "elliptic", "stiff"])
    if engine == "drake":
        points = name.startswith(("S5", "S6", "S10"))
        return [] if large else (["sap"] if points else ["hydro"])
    if engine == "bullet":
        return ["default"] if large else ["default", "iter500"] + (["boxfloor"] if name.startswith("S1_") else [])
    if engine == "dart":  # dense direct solves: beyond some hundred bodies a step takes minutes
        return [] if large or name.endswith(MIDDLING) else (["dantzig"] if pile else ["dantzig", "nsgs"])
    if engine == "ode":
        return ["quick", "quick100"] + ([] if large or name.endswith(MIDDLING) else ["step"])
    return ["default", "it16"] + ([] if pile else ["it64-hz60"])


def command(engine, variant, name, out, options, scenes=SCENES):
    """What runs a scene of the file `scenes`; variants of ours are the default, a number of sweeps, or a tolerance."""
    cap = options.cap if engine != "signorini" else options.own_cap
    if engine == "signorini":
        settles = name.startswith(("S4_pile", "S4s_pile")) and not name.endswith("pile100")
        asked = ["--tolerance", PILES_TOLERANCE if settles else 1e-9]
        if variant.endswith("sweeps"):
            asked += ["--budget", variant.split()[0]]
        elif variant != "default":
            asked = ["--tolerance", variant]
        return [options.sim, name, "--raw", out, "--cap", cap, "--data", scenes, "--robots", ROBOTS, *asked]
    if engine in PYTHON_PEERS:
        script = HERE / "peers" / "protocol.py"
        return [sys.executable, script, engine, variant, name, out, "--scenes", scenes, "--robots", ROBOTS, "--cap", cap]
    if engine == "ode":
        return [BUILD / "ode_peer", flat_scene(name, scenes), out, name, variant, cap]
    return [BUILD / "rapier_peer", scenes, out, name, variant, cap]


def flat_scene(name, scenes):
    """The scene as numbers in the order in which ode.cpp reads them."""
    scene, path = json.loads(scenes.read_text())[name], BUILD / "sim" / f"{name}.txt"
    rows = [[scene["dt"], scene["duration"], *scene["gravity"], scene["mu"], int(scene["collide"]), scene["sample_every"]]]
    rows.append([len(scene.get(key, [])) for key in ("planes", "bodies", "joints", "forces", "velocities")])
    rows += scene["planes"]
    rows += [["bs".index(row[0]), *row[1:]] for row in scene["bodies"]]
    rows += [[["hinge", "slider"].index(j["type"]), j["a"], j["b"], *j["anchor"], *j["axis"]] for j in scene["joints"]]
    rows += scene["forces"] + scene.get("velocities", [])
    path.write_text("\n".join(" ".join(f"{x:.17g}" for x in row) for row in rows) + "\n")
    return path


def available(engine):
    if engine in PYTHON_PEERS:
        module = {"drake": "pydrake", "bullet": "pybullet", "dart": "dartpy"}.get(engine, engine)
        return subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True).returncode == 0
    return engine == "signorini" or (BUILD / f"{engine}_peer").exists()


def run_all(scenes, options):
    engines = [engine for engine in options.engines if available(engine)]
    print("engines:", ", ".join(engines), "| left out:", ", ".join(set(options.engines) - set(engines)) or "none")
    cut = set()
    for repetition in range(options.repetitions):
        for name, scene in scenes.items():
            for engine in engines:
                for variant in variants(engine, name, scene, options.budget):
                    if (name, engine, variant) not in cut and not run_one(engine, variant, name, repetition, options):
                        cut.add((name, engine, variant))


def execute(command, out, cap, failed):
    """Runs an engine, which writes `out`; where it does not, that gets `failed` with what went wrong, which comes back."""
    out.unlink(missing_ok=True)
    wall = 60 + 12 * cap  # a single step can take minutes; the machine may be busy
    try:
        answer = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=wall)
        trouble = answer.stderr.strip()[-300:] if answer.returncode else ""
    except subprocess.TimeoutExpired:
        trouble = f"no answer within {wall:.0f} s"
    if not out.exists() or trouble:
        out.write_text(json.dumps(failed | dict(error=trouble or "no result")))
    return trouble


def run_one(engine, variant, name, repetition, options):
    """Runs once; whether it is worth repeating."""
    out = RAW / f"{name}__{engine}__{variant.replace(' ', '-')}__{repetition}.json"
    cap = options.own_cap if engine == "signorini" else options.cap
    failed = dict(engine=engine, variant=variant, scene=name, step_ns=[], samples=[], done=0)
    execute(command(engine, variant, name, out, options), out, cap, failed)
    run = json.loads(out.read_text()) | dict(variant=variant)
    out.write_text(json.dumps(run))
    times = sorted(run["step_ns"][len(run["step_ns"]) * 3 // 4 :]) or [0]
    note = run.get("error") or ""
    print(f"{repetition} {name:15} {engine:10} {variant:10} {run['done']:5} steps {times[len(times) // 2] / 1e3:12.1f} us {note}", flush=True)
    return run["done"] == run.get("planned")


def machine():
    """What the times were measured on."""
    model = "unknown"
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    if cpuinfo.exists():
        model = next((line.split(":")[1].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")), model)
    load = " ".join(f"{x:.1f}" for x in os.getloadavg())
    return dict(date=time.strftime("%Y-%m-%d"), processor=model, cores=os.cpu_count(), system=platform.platform(), load_at_the_end=load)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("scenes", nargs="*", help="names or their beginnings; all where none is given")
    options.add_argument("--engines", nargs="+", default=ENGINES, choices=ENGINES)
    options.add_argument("--cap", type=float, default=10.0, help="seconds of CPU time of a peer's run")
    options.add_argument("--own-cap", type=float, default=20.0, help="the same for our own runs")
    options.add_argument("--repetitions", type=int, default=3)
    options.add_argument("--sim", default="target/release/sim", help="the program `sim`")
    options.add_argument("--budget", type=int, nargs="+", default=[], help="contact sweeps of a step of ours, one run for each; the table is printed, the results stay")
    options.add_argument("--judge", action="store_true", help="run nothing")
    options = options.parse_args()
    import judge  # needs NumPy and SciPy, what is above does not

    scenes = json.loads(SCENES.read_text())
    begins = tuple(options.scenes) or ("S",)
    named = [name for name in begins if name in scenes]
    begun = tuple(name for name in begins if name not in scenes)
    chosen = {name: scene for name, scene in scenes.items() if name in named or name.startswith(begun)}
    RAW.mkdir(parents=True, exist_ok=True)
    if not options.judge:
        run_all(chosen, options)
    if options.budget:
        judge.judge_all(RAW, chosen, RAW / "judged", machine())
        return print(report.budget_table(RAW / "judged", RAW, chosen, options.budget))
    judge.judge_all(RAW, scenes, HERE / "results", machine())
    report.write(HERE / "results")


if __name__ == "__main__":
    main()
