"""Loads one MJCF file in MuJoCo, lets it move, and prints as JSON what `model_run` prints of it.

    python mujoco_run.py FILE [--duration 1] [--keyframe NAME]
"""

import argparse
import json
import statistics
import time

import mujoco


def poses(model, data):
    named = ((mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i), i) for i in range(1, model.nbody))
    return {name or f"body {i}": [*map(float, data.xpos[i]), *map(float, data.xquat[i])] for name, i in named}


def call_cost(model):
    """What the clock and the call take for next to nothing, µs: `model_run` subtracts what its clock takes, too."""
    took = []
    for _ in range(101):
        clock = time.perf_counter()
        mujoco.mj_isSparse(model)
        took.append(1e6 * (time.perf_counter() - clock))
    return statistics.median(took)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.add_argument("--duration", type=float, default=1.0)
    parser.add_argument("--keyframe")
    options = parser.parse_args()
    begin = time.process_time()
    try:
        model = mujoco.MjModel.from_xml_path(options.file)
    except ValueError as error:
        print(json.dumps({"end": "refused", "message": " ".join(str(error).split())}))
        return
    data = mujoco.MjData(model)
    load = time.process_time() - begin
    if options.keyframe:
        mujoco.mj_resetDataKeyframe(model, data, model.key(options.keyframe).id)
    mujoco.mj_forward(model, data)
    start = poses(model, data)
    took, contacts, nothing = [], 0, call_cost(model)
    for _ in range(round(options.duration / model.opt.timestep)):
        clock = time.perf_counter()
        mujoco.mj_step(model, data)
        took.append(max(1e6 * (time.perf_counter() - clock) - nothing, 0.0))
        contacts = max(contacts, data.ncon)
    bad = any(data.warning[kind].number for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC))
    mujoco.mj_kinematics(model, data)
    result = {
        "end": "unstable" if bad else "finished",
        "load_s": load,
        "nv": model.nv,
        "steps": len(took),
        "median_us": statistics.median(took) if took else 0.0,
        "contacts_max": contacts,
        "contacts_end": data.ncon,
        "fastest": float(abs(data.qvel).max()) if model.nv else 0.0,
        "start": start,
        "poses": poses(model, data),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
