"""Stores what Drake makes of the models of testdata/sdf.

    python -m venv .venv && .venv/bin/pip install drake
    .venv/bin/python crates/formats/testdata/make_sdf_reference.py

Written to testdata/reference/sdf.json: for every model the mass, centre of mass and rotational inertia about it of every
link, and for some positions of the joints the pose of every link in world and the kinetic energy at given rates.
"""

import importlib.metadata
import json
import pathlib

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

HERE = pathlib.Path(__file__).parent


def scoped(plant, element):
    name = plant.GetModelInstanceName(element.model_instance())
    inside = name.split("::")[1:]
    return "::".join([*inside, element.name()])


def reference(path):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    bodies = [plant.get_body(i) for i in plant.GetBodyIndices(plant.GetModelInstanceByName("arm"))]
    for name in ["arm::hand"]:
        bodies += [plant.get_body(i) for i in plant.GetBodyIndices(plant.GetModelInstanceByName(name))]
    joints = [plant.get_joint(i) for i in plant.GetJointIndices() if plant.get_joint(i).num_positions() > 0]
    links = {}
    for body in bodies:
        inertia = body.CalcSpatialInertiaInBodyFrame(context)
        about = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        links[scoped(plant, body)] = {"mass": inertia.get_mass(), "com": inertia.get_com().tolist(), "inertia": about.tolist()}
    random = np.random.default_rng(7)
    states = []
    for _ in range(3):
        positions, rates = {}, {}
        for joint in joints:
            n = joint.num_positions()
            q, v = random.uniform(-0.8, 0.8, n), random.uniform(-1, 1, n)
            plant.SetPositions(context, np.r_[tuple(set_part(plant.GetPositions(context), joint.position_start(), q))])
            plant.SetVelocities(context, np.r_[tuple(set_part(plant.GetVelocities(context), joint.velocity_start(), v))])
            positions[scoped(plant, joint)], rates[scoped(plant, joint)] = q.tolist(), v.tolist()
        poses = {}
        for body in bodies:
            pose = plant.EvalBodyPoseInWorld(context, body)
            poses[scoped(plant, body)] = {"pos": pose.translation().tolist(), "rotation": pose.rotation().matrix().tolist()}
        energy = plant.CalcKineticEnergy(context)
        states.append({"positions": positions, "rates": rates, "poses": poses, "kinetic": energy})
    return {"links": links, "states": states}


def set_part(values, start, part):
    values = np.array(values)
    values[start : start + len(part)] = part
    return values


def main():
    models = {path.stem: reference(path) for path in sorted((HERE / "sdf").glob("*.sdf"))}
    text = json.dumps({"drake": importlib.metadata.version("drake"), "models": models}, indent=1)
    (HERE / "reference" / "sdf.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
