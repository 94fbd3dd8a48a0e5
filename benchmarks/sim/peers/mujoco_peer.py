"""MuJoCo. Variants:

default   its defaults: Newton, pyramidal cone, solref .02 1, Euler; only the time step is set
cg        as default with conjugate gradients, its choice for thousands of contacts
cg-N      the same with N iterations and no early exit
elliptic  Newton, elliptic cone, impratio 10
stiff     elliptic, impratio 100, solref 2 dt, solimp .99 .999 .001, ten noslip iterations
"""

import os

import mujoco
import numpy as np
from protocol import bodies, inertia, joint_of, relative, rotation, velocities

ELLIPTIC = {"elliptic": 10, "stiff": 100}


def version():
    return mujoco.__version__


def numbers(values):
    return " ".join(f"{x:.12g}" for x in values)


def describe(scene, option, geom):
    """The scene as MJCF, and the order in which its bodies were written."""
    kind, size, mass, position, quaternion = bodies(scene)
    parent = {i: joint["a"] for i, joint in joint_of(scene).items()}
    hinge = joint_of(scene)
    inert = "" if scene["collide"] else 'contype="0" conaffinity="0"'
    lines = [
        f'<mujoco><compiler angle="radian" autolimits="false"/><option {option}/><size memory="2G"/>',
        f'<default><geom friction="{scene["mu"]} 0 0" condim="3" {geom} {inert}/></default><worldbody>',
    ]
    for plane in scene["planes"]:
        at = np.array(plane[:3]) * plane[3]
        lines.append(f'<geom type="plane" size="0 0 1" zaxis="{numbers(plane[:3])}" pos="{numbers(at)}"/>')
    order = []

    def emit(i):
        order.append(i)
        at, turn, frame = position[i], quaternion[i], rotation(quaternion[i])
        if parent.get(i, -1) >= 0:
            above = parent[i]
            at = rotation(quaternion[above]).T @ (at - position[above])
            turn = relative(turn, quaternion[above])
        lines.append(f'<body pos="{numbers(at)}" quat="{numbers(turn)}">')
        if i in hinge:
            axis, anchor = frame.T @ np.array(hinge[i]["axis"], float), frame.T @ (hinge[i]["anchor"] - position[i])
            sort = {"hinge": "hinge", "slider": "slide"}[hinge[i]["type"]]
            lines.append(f'<joint type="{sort}" axis="{numbers(axis)}" pos="{numbers(anchor)}"/>')
        else:
            lines.append("<freejoint/>")
        moments = numbers(inertia(kind[i], size[i], mass[i]))
        lines.append(f'<inertial pos="0 0 0" mass="{mass[i]:.12g}" diaginertia="{moments}"/>')
        shape = ("box", size[i]) if kind[i] == "b" else ("sphere", size[i][:1])
        lines.append(f'<geom type="{shape[0]}" size="{numbers(shape[1])}"/>')
        for child in [c for c in range(len(kind)) if parent.get(c, -1) == i]:
            emit(child)
        lines.append("</body>")

    for i in [i for i in range(len(kind)) if parent.get(i, -1) < 0]:
        emit(i)
    return "\n".join([*lines, "</worldbody></mujoco>"]), order


class Peer:
    def __init__(self, scene, variant):
        option, geom = f'timestep="{scene["dt"]}" gravity="{numbers(scene["gravity"])}"', ""
        if variant in ELLIPTIC:
            option += f' cone="elliptic" impratio="{ELLIPTIC[variant]}"'
        method, _, iterations = variant.partition("-")
        if method == "cg":
            option += ' solver="CG"'
        if iterations:
            option += f' iterations="{iterations}" tolerance="0"'
        if variant == "stiff":
            option += ' noslip_iterations="10"'
            geom = f'solref="{2 * scene["dt"]} 1" solimp=".99 .999 .001"'
        self.body = []
        if "robot" in scene:
            self.load_robot(scene, variant)
            return
        text, order = describe(scene, option, geom)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.body = np.argsort(order) + 1
        self.scene_body = np.array([-1, *order])
        for i, *force in scene["forces"]:
            self.data.xfrc_applied[self.body[i], :3] = force
        self.floats = not scene["joints"]
        if "velocities" in scene:
            for body, turn, twist in zip(self.body, bodies(scene)[4], velocities(scene)):
                first = 6 * (body - 1)  # of a free joint: linear in world axes, angular in those of the body
                self.data.qvel[first : first + 6] = [*twist[:3], *(rotation(turn).T @ twist[3:])]
        mujoco.mj_forward(self.model, self.data)

    def load_robot(self, scene, variant):
        path = os.path.join(scene["robots"], scene["mjcf"])
        self.model = model = mujoco.MjModel.from_xml_path(path)
        model.opt.timestep = scene["dt"]
        if variant in ELLIPTIC:
            model.opt.cone, model.opt.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, ELLIPTIC[variant]
        if variant == "stiff":
            model.opt.noslip_iterations = 10
            model.geom_solref[:], model.geom_solimp[:, :3] = (2 * scene["dt"], 1), (0.99, 0.999, 0.001)
        self.data = data = mujoco.MjData(model)
        self.body, self.floats = [1], False
        if "motors" in scene:
            angle = [model.joint(name).qposadr[0] for name in scene["motors"]]
            rate = [model.joint(name).dofadr[0] for name in scene["motors"]]
            data.qpos[angle] = np.tile(scene["stance"], 4)
            self.joints = lambda: (data.qpos[angle], data.qvel[rate])
            self.torque = lambda values: data.qfrc_applied.__setitem__(rate, values)
        mujoco.mj_forward(model, data)

    def step(self):
        mujoco.mj_step(self.model, self.data)

    def contacts(self):
        return self.data.ncon

    def state(self):
        data, rows = self.data, np.zeros((len(self.body), 13))
        if self.floats:
            # The derived quantities of `data` belong to the beginning of the step, so the state itself is read.
            q, v = data.qpos.reshape(-1, 7)[self.body - 1], data.qvel.reshape(-1, 6)[self.body - 1]
            rows[:, :7], rows[:, 7:10] = q, v[:, :3]
            twist = 2 * np.cross(q[:, 4:], v[:, 3:])
            rows[:, 10:] = v[:, 3:] + q[:, 3:4] * twist + np.cross(q[:, 4:], twist)
            return rows
        for refresh in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_comVel):
            refresh(self.model, data)
        velocity = np.zeros(6)
        for i, body in enumerate(self.body):
            mujoco.mj_objectVelocity(self.model, data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
            rows[i] = [*data.xpos[body], *data.xquat[body], *velocity[3:], *velocity[:3]]
        return rows

    def forces(self):
        rows, force = [], np.zeros(6)
        for k in range(self.data.ncon):
            contact = self.data.contact[k]
            mujoco.mj_contactForce(self.model, self.data, k, force)
            frame = np.array(contact.frame).reshape(3, 3)  # normal from the first geom to the second, two tangents
            j, i = (self.scene_body[self.model.geom_bodyid[g]] for g in (contact.geom1, contact.geom2))
            tangential = force[1] * frame[1] + force[2] * frame[2]
            corner = frame[1] if self.model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL else np.zeros(3)
            rows.append([int(i), int(j), *map(float, contact.pos), *map(float, frame[0]), float(force[0]),
                         *map(float, tangential), float(contact.friction[0]), float(contact.dist), *map(float, corner)])  # fmt: skip
        return rows
