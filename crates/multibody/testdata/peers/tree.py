"""A kinematic tree as plain numbers: read from Pinocchio and MuJoCo models, handed to both, and written to a file.

Conventions are those of NOTATION.md: quaternions w x y z; a body's frame sits at `placement` in its parent's, then its
joints move it in order, hinges and balls about their anchor. Body 0 is the world and is not listed.
"""

from dataclasses import dataclass, field

import mujoco
import numpy as np
import pinocchio as pin

SIZE = {"free": (7, 6), "ball": (4, 3), "hinge": (1, 1), "slide": (1, 1)}


@dataclass
class Joint:
    kind: str
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    anchor: np.ndarray = field(default_factory=lambda: np.zeros(3))
    reference: float = 0.0
    armature: float = 0.0


@dataclass
class Body:
    parent: int
    position: np.ndarray
    quaternion: np.ndarray
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    joints: list


@dataclass
class Tree:
    gravity: np.ndarray
    bodies: list

    def joints(self):
        return [joint for body in self.bodies for joint in body.joints]

    def nq(self):
        return sum(SIZE[joint.kind][0] for joint in self.joints())

    def nv(self):
        return sum(SIZE[joint.kind][1] for joint in self.joints())

    def armature(self):
        return np.concatenate([np.full(SIZE[j.kind][1], j.armature) for j in self.joints()] or [np.zeros(0)])

    def text(self):
        def numbers(*parts):
            flat = np.concatenate([np.atleast_1d(np.asarray(part, float)).ravel() for part in parts])
            return " ".join(repr(float(x)) if x != int(x) else str(int(x)) for x in flat)

        lines = ["gravity " + numbers(self.gravity)]
        for body in self.bodies:
            i = body.inertia
            i = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
            lines.append(f"body {body.parent} " + numbers(body.position, body.quaternion, body.mass, body.com, i))
            for j in body.joints:
                lines.append(f"joint {j.kind} " + numbers(j.axis, j.anchor, j.reference, j.armature))
        return "\n".join(lines) + "\n"


def quaternion_of(rotation):
    q = pin.Quaternion(rotation)
    return np.array([q.w, q.x, q.y, q.z])


def rotation_of(quaternion):
    w, x, y, z = quaternion
    return pin.Quaternion(w, x, y, z).toRotationMatrix()


def rotated(inertia, rotation):
    inertia = rotation @ inertia @ rotation.T
    return 0.5 * (inertia + inertia.T)


# Pinocchio's joints with a fixed axis; RUB are those without limits, whose q is (cos, sin).
AXES = {"X": [1.0, 0.0, 0.0], "Y": [0.0, 1.0, 0.0], "Z": [0.0, 0.0, 1.0]}


def joint_of_pinocchio(joint, armature):
    name = joint.shortname().removeprefix("JointModel")
    if name == "FreeFlyer":
        return Joint("free")
    if name == "Spherical":
        return Joint("ball", armature=armature)
    inner = joint.extract() if hasattr(joint, "extract") else joint
    if name.endswith("Unaligned"):
        kind = "slide" if name.startswith("Prismatic") else "hinge"
        return Joint(kind, axis=np.array(inner.axis), armature=armature)
    kind = "slide" if name.startswith("P") else "hinge"
    return Joint(kind, axis=np.array(AXES[name[-1]]), armature=armature)


def tree_of_pinocchio(model):
    """Bodies are Pinocchio's joints; what is welded to one is merged into it."""
    bodies = []
    for j in range(1, model.njoints):
        inertia, placement = model.inertias[j], model.jointPlacements[j]
        armature = float(model.armature[model.idx_vs[j]])
        joint = joint_of_pinocchio(model.joints[j], armature)
        bodies.append(
            Body(
                model.parents[j],
                np.array(placement.translation),
                quaternion_of(placement.rotation),
                inertia.mass,
                np.array(inertia.lever),
                np.array(inertia.inertia),
                [joint],
            )
        )
    return Tree(np.array(model.gravity.linear), bodies)


def tree_of_mujoco(model):
    kinds = ["free", "ball", "slide", "hinge"]
    bodies = []
    for b in range(1, model.nbody):
        joints = []
        for j in range(model.body_jntadr[b], model.body_jntadr[b] + model.body_jntnum[b]):
            kind = kinds[model.jnt_type[j]]
            scalar = kind in ("hinge", "slide")
            joints.append(
                Joint(
                    kind,
                    model.jnt_axis[j].copy() if scalar else np.array([0.0, 0.0, 1.0]),
                    np.zeros(3) if kind == "free" else model.jnt_pos[j].copy(),
                    float(model.qpos0[model.jnt_qposadr[j]]) if scalar else 0.0,
                    float(model.dof_armature[model.jnt_dofadr[j]]),
                )
            )
        inertia = rotated(np.diag(model.body_inertia[b]), rotation_of(model.body_iquat[b]))
        bodies.append(
            Body(
                int(model.body_parentid[b]),
                model.body_pos[b].copy(),
                model.body_quat[b].copy(),
                float(model.body_mass[b]),
                model.body_ipos[b].copy(),
                inertia,
                joints,
            )
        )
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY:
        model.opt.gravity[:] = 0.0
    return Tree(model.opt.gravity.copy(), bodies)


def pinocchio_of_tree(tree):
    """The model and the frame of every body. A body with several joints becomes a chain of joints without mass."""
    model = pin.Model()
    model.gravity.linear = tree.gravity
    link, offset, frames = [0], [pin.SE3.Identity()], []
    for b, body in enumerate(tree.bodies):
        parent = link[body.parent]
        placement = offset[body.parent] * pin.SE3(rotation_of(body.quaternion), body.position)
        for j, joint in enumerate(body.joints):
            place = placement * pin.SE3(np.eye(3), joint.anchor)
            if joint.kind == "free":
                made, place = pin.JointModelFreeFlyer(), pin.SE3.Identity()
            elif joint.kind == "ball":
                made = pin.JointModelSpherical()
            elif joint.kind == "hinge":
                made = pin.JointModelRevoluteUnaligned(joint.axis)
                place = place * pin.SE3(pin.AngleAxis(-joint.reference, joint.axis).toRotationMatrix(), np.zeros(3))
            else:
                made = pin.JointModelPrismaticUnaligned(joint.axis)
                place = place * pin.SE3(np.eye(3), -joint.reference * joint.axis)
            parent = model.addJoint(parent, made, place, f"b{b}j{j}")
            first = model.idx_vs[parent]
            armature = model.armature
            armature[first : first + SIZE[joint.kind][1]] = joint.armature
            model.armature = armature
            placement = pin.SE3(np.eye(3), -joint.anchor)
        inertia = pin.Inertia(body.mass, body.com, body.inertia)
        if parent != 0:
            model.appendBodyToJoint(parent, inertia, placement)
        link.append(parent)
        offset.append(placement)
        frames.append(model.addFrame(pin.Frame(f"b{b}", parent, 0, placement, pin.FrameType.OP_FRAME)))
    return model, frames


def mujoco_of_tree(tree):
    def numbers(values):
        return " ".join(repr(float(x)) for x in np.atleast_1d(values))

    children = {b: [] for b in range(len(tree.bodies) + 1)}
    for b, body in enumerate(tree.bodies):
        children[body.parent].append(b + 1)

    def element(b):
        body = tree.bodies[b - 1]
        i = body.inertia
        full = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
        text = f'<body name="b{b}" pos="{numbers(body.position)}" quat="{numbers(body.quaternion)}">'
        if body.mass > 0:
            text += f'<inertial pos="{numbers(body.com)}" mass="{body.mass!r}" fullinertia="{numbers(full)}"/>'
        for joint in body.joints:
            text += f'<joint type="{joint.kind}" armature="{joint.armature!r}"'
            if joint.kind != "free":
                text += f' pos="{numbers(joint.anchor)}"'
            if joint.kind in ("hinge", "slide"):
                text += f' axis="{numbers(joint.axis)}" ref="{joint.reference!r}"'
            text += "/>"
        return text + "".join(element(child) for child in children[b]) + "</body>"

    world = "".join(element(b) for b in children[0])
    return mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian" inertiafromgeom="false"/>'
        f'<option gravity="{numbers(tree.gravity)}"/><worldbody>{world}</worldbody></mujoco>'
    )


def random_tree(random, size, armature):
    """Bodies with joints of all kinds, parents at random, in depth-first order as MuJoCo numbers them."""

    def vector(half):
        return random.uniform(-half, half, 3)

    def body(parent, joints):
        a, b, c = random.uniform(0.1, 1.0, 3)
        mass = random.uniform(0.3, 3.0, 1)[0]
        principal = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * 0.2 * mass
        inertia = rotated(principal, rotation_of(random.quaternion()))
        return Body(parent, vector(0.7), random.quaternion(), float(mass), vector(0.3), inertia, joints)

    def joint(kind):
        axis = vector(1.0)
        axis /= np.linalg.norm(axis)
        # Rotor inertia of a free joint means another force in Pinocchio, whose linear velocity is in turning axes.
        rotor = float(random.uniform(0.0, 0.2, 1)[0]) if armature and kind != "free" else 0.0
        reference = float(random.uniform(-0.8, 0.8, 1)[0]) if kind in ("hinge", "slide") else 0.0
        return Joint(kind, axis, np.zeros(3) if kind == "free" else vector(0.4), reference, rotor)

    bodies, path = [], []
    for b in range(size):
        if not path or random.uniform(0.0, 1.0, 1)[0] < 0.1:
            path, joints = [], [joint("free")]
        else:
            path = path[: 1 + int(random.uniform(0.0, len(path), 1)[0])]
            joints = []
            for _ in range(int(random.uniform(0.0, 4.0, 1)[0]) if armature else 1):
                joints.append(joint(["hinge", "hinge", "slide", "ball"][int(random.uniform(0.0, 4.0, 1)[0])]))
                # MuJoCo wants a ball to be the last one.
                if joints[-1].kind == "ball":
                    break
        bodies.append(body(path[-1] if path else 0, joints))
        path.append(b + 1)
    return Tree(vector(10.0), bodies)
