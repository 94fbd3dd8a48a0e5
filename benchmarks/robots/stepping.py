"""Steps MJCF files from Python, in this engine and in MuJoCo, in turn in one process, and prints what a step takes in both.

    python benchmarks/robots/stepping.py FILE ... [--duration 0.3] [--limit 20]

Needs the packages `signorini` and `mujoco`. Both engines begin at the keyframe `home`, else the first, else the reference configuration,
and make one call a step; the time is that of the call, the median of all. Blocks of steps take turns, so that both meet the same machine.
A file whose steps have taken `--limit` seconds ends early in both.
"""

import argparse
import statistics
import sys
import time
import warnings

import mujoco

import signorini

BLOCK = 25


def keyframe(names):
    return "home" if "home" in names else next(iter(names), None)


def our_step(path):
    """The model's time step, and a function that makes one step."""
    model = signorini.Model.from_mjcf(path)
    data = signorini.Data(model)
    start = keyframe(model.keyframe_names)
    if start is not None:
        data.reset(start)
    return model.timestep, lambda: signorini.step(model, data)


def their_step(path):
    model = mujoco.MjModel.from_xml_path(path)
    data = mujoco.MjData(model)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_KEY, k) for k in range(model.nkey)]
    start = keyframe([name for name in names if name])
    if start is not None:
        mujoco.mj_resetDataKeyframe(model, data, model.key(start).id)
    return model.opt.timestep, lambda: mujoco.mj_step(model, data)


def timed(step, count):
    """What each of `count` steps took, µs."""
    took = []
    for _ in range(count):
        begin = time.perf_counter()
        step()
        took.append(1e6 * (time.perf_counter() - begin))
    return took


def compare(path, duration, limit):
    """Median of a step in both, µs."""
    (dt, ours), (_, theirs) = our_step(path), their_step(path)
    left, took, spent = round(duration / dt), ([], []), 0.0
    while left > 0 and spent < limit:
        begin = time.perf_counter()
        for step, times in zip((ours, theirs), took, strict=True):
            times += timed(step, min(BLOCK, left))
        left -= BLOCK
        spent += time.perf_counter() - begin
    return [statistics.median(times) for times in took]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--duration", type=float, default=0.3, help="simulated time, s")
    parser.add_argument("--limit", type=float, default=20.0, help="time for a file, s")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    ratios, left_out = [], 0
    for path in options.files:
        try:
            ours, theirs = compare(path, options.duration, options.limit)
        except (ValueError, RuntimeError, OSError, signorini.SolveError) as error:
            left_out += 1
            print(f"{path}: left out: {str(error).splitlines()[0]}", file=sys.stderr)
            continue
        ratios.append(ours / theirs)
        print(f"{ours:9.1f} {theirs:9.1f} {ours / theirs:7.2f}  {path}", flush=True)
    ratios.sort()
    if ratios:
        at = lambda q: ratios[round(q * (len(ratios) - 1))]
        print(f"{len(ratios)} files ({left_out} left out): median {at(0.5):.2f}, 95 % at most {at(0.95):.2f}, worst {ratios[-1]:.2f}")


if __name__ == "__main__":
    main()
