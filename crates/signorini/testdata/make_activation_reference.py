"""Stores what MuJoCo's actuators with activation do in activation.xml.

    python -m venv .venv && .venv/bin/pip install mujoco==4.0.0
    .venv/bin/python crates/signorini/testdata/make_activation_reference.py

Written to activation_reference.json beside this script. "run": from the keyframe, 100 steps with the controls given there; act,
qpos and qvel after each. "rest": act and qpos after 4000 further steps with the last control.
"""

import json
import pathlib

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).parent
STEPS = 100


def main():
    model = mujoco.MjModel.from_xml_path(str(HERE / "activation.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    random = np.random.default_rng(20261121)
    run = {"control": [], "act": [], "qpos": [], "qvel": []}
    for k in range(STEPS):
        if k % 10 == 0:
            control = random.uniform(-1.4, 1.4, model.nu)
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        run["control"].append(control.tolist())
        for field in ("act", "qpos", "qvel"):
            run[field].append(getattr(data, field).tolist())
    for _ in range(4000):
        mujoco.mj_step(model, data)
    reference = {"mujoco": mujoco.__version__, "run": run, "rest": {"act": data.act.tolist(), "qpos": data.qpos.tolist()}}
    (HERE / "activation_reference.json").write_text(json.dumps(reference) + "\n")


if __name__ == "__main__":
    main()
