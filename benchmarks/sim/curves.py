"""What a step leaves of the laws against the time it takes: every engine at several counts of iterations, from the same moments of the same piles.

    build/peers/venv/bin/python benchmarks/sim/curves.py [MOMENT ...] [--engines NAME ...] [--repetitions 3] [--sim target/release/sim]

From every moment all engines go on, with the bodies' positions and velocities, by `STEPS` steps of their own; the last three are timed (each by the
quickest of the repetitions, in which the engines take turns) and judged (`residual.py`). Writes results/curves.json, results/curves.svg, and the table on docs/performance.md.
`--judge` runs nothing. `--smoke` shows in seconds, without any peer and without NumPy, that ours runs and the plot can be drawn.
"""

import argparse
import json
import pathlib
import re
import subprocess
import tempfile

import compare
import curves_plot
import scenes

HERE = pathlib.Path(__file__).resolve().parent
FOLDER = compare.BUILD / "sim" / "curves"
MOMENTS_FILE = FOLDER / "moments.json"

# Moment → the scene and the time in it, s.
MOMENTS = {
    "boxes_falling": ("S4_pile1000", 0.5),
    "boxes_impact": ("S4_pile1000", 0.8),
    "boxes_settling": ("S4_pile1000", 1.2),
    "boxes_near_rest": ("S4_pile1000", 3.0),
    "spheres_falling": ("S5_spheres1000", 0.5),
    "spheres_impact": ("S5_spheres1000", 0.7),
    "spheres_settling": ("S5_spheres1000", 1.0),
    "spheres_near_rest": ("S5_spheres1000", 3.0),
}
# Sweeps a step of the run of ours in which the moments are; it leaves no overlaps that another engine would have to push out first.
SWEEPS = 50
# Steps of an engine's own from a moment on: long enough for its warm starts and for the depth in which its contacts carry.
STEPS = 20
JUDGED = 3

SIGNORINI = [f"{n} sweeps" for n in (1, 2, 5, 10, 20, 50, 100, 200, 500)] + [f"1e-{k}" for k in range(3, 9)]
# Of every engine from quick to slow.
VARIANTS = {
    "signorini": SIGNORINI,
    "mujoco": [*(f"cg-{n}" for n in (5, 10, 20, 50)), "cg", "cg-100"],  # Newton's method takes seconds a step of these piles
    "bullet": [*(f"iter{n}" for n in (2, 5, 10, 20)), "default", *(f"iter{n}" for n in (100, 200))],
    "ode": [*(f"quick{n}" for n in (5, 10)), "quick", *(f"quick{n}" for n in (50, 100, 200, 500))],
    "rapier": [f"it{n}-coulomb" for n in (1, 2, 4, 8, 16)],
}


def from_moment(scene, what, state):
    """The scene that begins with these states of its bodies."""
    bodies = [[*row[:5], *at[:7]] for row, at in zip(scene["bodies"], state)]
    run = dict(duration=STEPS * scene["dt"], sample_every=STEPS)
    return scene | run | dict(what=f"{scene['what']}, {what}", bodies=bodies, velocities=[at[7:] for at in state])


def make_moments(sim, piles, moments, path):
    """Runs ours through the scenes and writes the moments down as scenes of their own."""
    path.parent.mkdir(parents=True, exist_ok=True)
    found = {}
    for pile in dict.fromkeys(pile for pile, _ in moments.values()):
        times = {name: time for name, (scene, time) in moments.items() if scene == pile}
        every = round(0.1 / piles[pile]["dt"])
        scene = piles[pile] | dict(duration=max(times.values()), sample_every=every)
        data, out = path.with_name(f"{pile}.json"), path.with_name(f"{pile}_run.json")
        data.write_text(json.dumps({pile: scene}))
        command = [sim, pile, "--raw", out, "--cap", 1000, "--data", data, "--budget", SWEEPS]
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
        samples = json.loads(out.read_text())["samples"]
        for name, time in times.items():
            at, state = min(samples, key=lambda sample: abs(sample[0] - time))
            if abs(at - time) > 1e-6:
                raise SystemExit(f"{pile} ended at {samples[-1][0]} s, before the moment {name}")
            found[name] = from_moment(scene, f"from {time} s on", state)
    path.write_text(json.dumps({name: found[name] for name in moments}))


def raw(name, engine, variant, repetition):
    return FOLDER / f"{name}__{engine}__{variant.replace(' ', '-')}__{repetition}.json"


def run_all(names, options):
    engines = [engine for engine in options.engines if compare.available(engine)]
    print("engines:", ", ".join(engines), "| left out:", ", ".join(set(options.engines) - set(engines)) or "none")
    for name in names:
        for repetition in range(options.repetitions):
            for engine in engines:
                cut = set()  # lines of the plot of which a variant ran out of time: the next ones, which take longer, are not tried
                for variant in VARIANTS[engine]:
                    line = curves_plot.line_of(engine, variant)
                    if line not in cut and not run_one(name, engine, variant, repetition, options):
                        cut.add(line)


def run_one(name, engine, variant, repetition, options):
    """Runs once; whether all steps were made."""
    out = raw(name, engine, variant, repetition)
    if repetition:
        times = json.loads(raw(name, engine, variant, 0).read_text())["step_ns"]
        if len(times) < STEPS or sum(times) > options.once * 1e9:
            out.unlink(missing_ok=True)
            return len(times) == STEPS
    command = compare.command(engine, variant, name, out, options, MOMENTS_FILE)
    trouble = compare.execute(command, out, options.cap, dict(engine=engine, variant=variant, version="", step_ns=[]))
    times = json.loads(out.read_text())["step_ns"]
    print(f"{repetition} {name:18} {engine:10} {variant:12} {len(times):3} steps {sum(times[-JUDGED:]) / JUDGED / 1e6:9.2f} ms {trouble}", flush=True)
    return len(times) == STEPS


def step_times(path):
    """CPU time of every step, ns, without reading the states."""
    return json.loads(re.search(r'"step_ns":\s*(\[[^\]]*\])', path.read_text())[1])


def judge_variant(judge, scale, name, engine, variant):
    """The point of one variant; none where it was not run."""
    import numpy as np
    from judge import MM
    from residual import BOUNDS, residuals

    first = raw(name, engine, variant, 0)
    if not first.exists():
        return None
    run, times = json.loads(first.read_text()), [step_times(path) for path in FOLDER.glob(raw(name, engine, variant, "*").name)]
    point = dict(engine=engine, variant=variant, version=run["version"])
    if len(run["step_ns"]) < STEPS:
        return point | dict(cut_off=len(run["step_ns"]))
    quickest = [min(step) for step in zip(*(row[-JUDGED:] for row in times if len(row) == STEPS))]
    snapshots = run["snapshots"][-JUDGED:]
    steps = [residuals(judge, snapshot, BOUNDS[engine], scale) for snapshot in snapshots]
    depth = max(judge.penetrations(np.array(snapshot["after"], float)).max(initial=0.0) for snapshot in snapshots)
    point |= dict(ms=sum(quickest) / JUDGED / 1e6, contacts=run["contacts"][-1], penetration_mm=float(depth) * MM)
    return point | {key: max(step[key] for step in steps) for key in steps[0]}


def judge_moment(name, scene):
    """One point for each engine and variant."""
    from judge import Judge, strict
    from residual import velocity_scale

    judge, scale = Judge(name, scene), velocity_scale(scene)
    points = [judge_variant(judge, scale, name, engine, variant) for engine, variants in VARIANTS.items() for variant in variants]
    return strict(dict(what=scene["what"], velocity_scale=scale, points=[point for point in points if point]))


def text_of(results):
    """The results as JSON, each point in a line of its own, numbers with four digits."""
    rounded = json.loads(json.dumps(results), parse_float=lambda text: float(f"{float(text):.4g}"))
    moments = rounded.pop("moments")
    lines = []
    for name, moment in moments.items():
        points = ",\n".join(json.dumps(point) for point in moment.pop("points"))
        lines.append(f'{json.dumps(name)}: {json.dumps(moment)[:-1]}, "points": [\n{points}\n]}}')
    return json.dumps(rounded)[:-1] + ', "moments": {\n' + ",\n".join(lines) + "\n}}\n"


def smoke(sim):
    """Ours from a moment of a small pile; and the plot of the results that are stored."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = pathlib.Path(folder) / "moments.json", pathlib.Path(folder) / "run.json"
        make_moments(sim, {"pile": scenes.pile(10, 1.0, 7) | dict(what="a small pile")}, {"pile_falling": ("pile", 0.1)}, path)
        options = argparse.Namespace(sim=sim, cap=10.0, own_cap=10.0)
        for variant in ("5 sweeps", "1e-6"):
            command = compare.command("signorini", variant, "pile_falling", out, options, path)
            subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
            run = json.loads(out.read_text())
            rows = [row for snapshot in run["snapshots"] for row in snapshot["forces"]]
            if run["done"] != STEPS or any(len(row) != 17 for row in rows):
                raise SystemExit(f"{variant}: {run['done']} steps, {len(rows)} contacts")
            print(f"{variant}: {run['done']} steps")
    if not curves_plot.draw(json.loads((HERE / "results" / "curves.json").read_text())["moments"]).startswith("<svg"):
        raise SystemExit("no plot")


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("moments", nargs="*", help="names; all where none is given")
    options.add_argument("--engines", nargs="+", default=list(VARIANTS), choices=VARIANTS)
    options.add_argument("--cap", type=float, default=20.0, help="seconds of CPU time of a run; one that is cut off by it has no point")
    options.add_argument("--once", type=float, default=6.0, help="runs that take more seconds are not repeated")
    options.add_argument("--repetitions", type=int, default=3)
    options.add_argument("--sim", default="target/release/sim", help="the program `sim`")
    options.add_argument("--judge", action="store_true", help="run nothing")
    options.add_argument("--smoke", action="store_true", help="ours alone, for seconds")
    options = options.parse_args()
    options.own_cap = options.cap
    if options.smoke:
        return smoke(options.sim)
    if not MOMENTS_FILE.exists():
        make_moments(options.sim, scenes.all_scenes(), MOMENTS, MOMENTS_FILE)
    moments = json.loads(MOMENTS_FILE.read_text())
    if not options.judge:
        run_all(options.moments or list(moments), options)
    judged = {name: judge_moment(name, scene) for name, scene in moments.items()}
    text = text_of(dict(machine=compare.machine(), moments=judged))
    (HERE / "results" / "curves.json").write_text(text)
    curves_plot.write(json.loads(text), HERE)


if __name__ == "__main__":
    main()
