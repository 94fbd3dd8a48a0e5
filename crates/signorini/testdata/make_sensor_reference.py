"""Stores what MuJoCo's sensors show for sensors.xml (in motion, without contact) and resting.xml (at rest).

    python -m venv .venv && .venv/bin/pip install mujoco==4.0.0
    .venv/bin/python crates/signorini/testdata/make_sensor_reference.py

Written to sensor_reference.json beside this script: names and sizes of the sensors, and for every state qpos, qvel, ctrl
and sensordata.
"""

import json
import pathlib

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).parent


def sensors(model):
    kinds = [str(mujoco.mjtSensor(t).name)[len("mjSENS_") :].lower() for t in model.sensor_type]
    return [[kind, int(size)] for kind, size in zip(kinds, model.sensor_dim)]


def state(data):
    fields = ("qpos", "qvel", "ctrl", "sensordata")
    return {"time": data.time} | {field: getattr(data, field).tolist() for field in fields}


def moving():
    model = mujoco.MjModel.from_xml_path(str(HERE / "sensors.xml"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(model)
    random = np.random.default_rng(20261121)
    states = []
    for k in range(4):
        mujoco.mj_resetData(model, data)
        mujoco.mj_integratePos(model, data.qpos, random.uniform(-0.7, 0.7, model.nv), 1.0)
        data.qvel[:] = random.uniform(-1, 1, model.nv)
        data.ctrl[:] = random.uniform(-1.3, 1.3, model.nu)
        data.time = 0.25 * k
        mujoco.mj_forward(model, data)
        states.append(state(data))
    return {"sensors": sensors(model), "states": states}


def resting():
    model = mujoco.MjModel.from_xml_path(str(HERE / "resting.xml"))
    data = mujoco.MjData(model)
    data.ctrl[:] = [0.2, -0.1]
    for _ in range(20000):
        mujoco.mj_step(model, data)
    assert abs(data.qvel).max() < 1e-9, data.qvel
    mujoco.mj_forward(model, data)
    return {"sensors": sensors(model), "states": [state(data)]}


def main():
    reference = {"mujoco": mujoco.__version__, "moving": moving(), "resting": resting()}
    (HERE / "sensor_reference.json").write_text(json.dumps(reference, indent=1) + "\n")


if __name__ == "__main__":
    main()
