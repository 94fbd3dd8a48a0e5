"""Writes mujoco_reference.txt: configuration, velocity and what MuJoCo computes from them for mujoco_reference.xml.

Run with `pip install mujoco numpy`, then `python mujoco_reference.py`. Made with MuJoCo 4.0.0.
Every line is a quantity's name and its numbers; `qpos` begins a new state.
"""

from pathlib import Path

import mujoco
import numpy as np

HERE = Path(__file__).parent
model = mujoco.MjModel.from_xml_path(str(HERE / "mujoco_reference.xml"))
data = mujoco.MjData(model)
random = np.random.default_rng(20260921)

lines = []
for _ in range(6):
    mujoco.mj_resetData(model, data)
    # Along a random velocity from the reference configuration, so that quaternions are unit.
    mujoco.mj_integratePos(model, data.qpos, random.uniform(-1.5, 1.5, model.nv), 1.0)
    data.qvel[:] = random.uniform(-3, 3, model.nv)
    data.ctrl[:] = random.uniform(-1, 1, model.nu)
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    energy = np.zeros(2)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    quantities = {
        "qpos": data.qpos,
        "qvel": data.qvel,
        "ctrl": data.ctrl,
        "mass": mass,
        "bias": data.qfrc_bias,
        "passive": data.qfrc_passive,
        "actuator": data.qfrc_actuator,
        "xpos": data.xpos,
        "xquat": data.xquat,
        "energy": data.energy,
    }
    for name, values in quantities.items():
        lines.append(" ".join([name, *(repr(float(x)) for x in values.ravel())]))
(HERE / "mujoco_reference.txt").write_text("\n".join(lines) + "\n")
