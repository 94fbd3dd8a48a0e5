"""Stores what Pinocchio makes of the robots that benchmarks/robots/fetch.py fetches, for the test of the URDF reader.

    python -m venv .venv && .venv/bin/pip install pin==4.1.0
    .venv/bin/python benchmarks/robots/fetch.py
    .venv/bin/python crates/formats/testdata/make_robot_reference.py

Written to testdata/reference/robots.json: for every robot the total mass, nv with a fixed base, and for every movable
joint its limits, its place and its axis in world at the zero configuration; for every link its place, and the inertia of
the robot about the origin of the world.
"""

import importlib.util
import json
import pathlib

import numpy as np
import pinocchio

HERE = pathlib.Path(__file__).resolve().parent
FETCH = HERE.parents[2] / "benchmarks" / "robots" / "fetch.py"


def describe(path):
    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    zero = np.zeros(model.nv)
    pinocchio.computeJointJacobians(model, data, zero)
    pinocchio.updateFramePlacements(model, data)
    joints = {}
    for j in range(1, model.njoints):
        jacobian = pinocchio.getJointJacobian(model, data, j, pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        column = jacobian[:, model.idx_vs[j]]
        rotates = np.linalg.norm(column[3:]) > 0.5
        q = model.idx_qs[j]
        joints[model.names[j]] = {
            "rotates": bool(rotates),
            "axis": (column[3:] if rotates else column[:3]).tolist(),
            "range": [float(model.lowerPositionLimit[q]), float(model.upperPositionLimit[q])],
        }
    links = {}
    for k, frame in enumerate(model.frames):
        if frame.type == pinocchio.FrameType.BODY and frame.name != "universe":
            placement = data.oMf[k]
            links[frame.name] = {"pos": placement.translation.tolist(), "rotation": placement.rotation.tolist()}
    whole = model.inertias[0].copy()
    for j in range(1, model.njoints):
        whole += data.oMi[j].act(model.inertias[j])
    about_origin = whole.inertia - whole.mass * pinocchio.skew(whole.lever) @ pinocchio.skew(whole.lever)
    return {
        "nv": model.nv,
        "mass": whole.mass,
        "com": whole.lever.tolist(),
        "inertia": about_origin.tolist(),
        "joints": joints,
        "links": links,
    }


def main():
    spec = importlib.util.spec_from_file_location("fetch", FETCH)
    fetch = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fetch)
    robots = {name: {"path": path} | describe(fetch.FOLDER / path) for name, path in fetch.ROBOTS.items()}
    robots = {"pinocchio": pinocchio.__version__, "robots": robots}
    (HERE / "reference" / "robots.json").write_text(json.dumps(robots, indent=1) + "\n")


if __name__ == "__main__":
    main()
