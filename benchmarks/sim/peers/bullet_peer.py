"""PyBullet. Variants:

default   rigid bodies in maximal coordinates (robots and chains: multibodies), 50 iterations of sequential impulses
iterN     N iterations without early exit
boxfloor  as default, the floor a thick box: Bullet's plane gives a sliding box one point per step
dantzig   as default with the direct boxed LCP of Bullet
"""

import numpy as np
import pybullet as p
from protocol import bodies, inertia, joint_of, relative, rotation, row, velocities



def solver(variant):
    if variant == "dantzig":
        return dict(constraintSolverType=p.CONSTRAINT_SOLVER_LCP_DANTZIG, globalCFM=1e-6)
    if variant.startswith("iter"):
        return dict(numSolverIterations=int(variant.removeprefix("iter")), solverResidualThreshold=0)
    return {}


def version():
    from importlib.metadata import version as installed

    return installed("pybullet")


def xyzw(q):
    return [q[1], q[2], q[3], q[0]]


class Peer:
    def __init__(self, scene, variant):
        if p.isConnected():
            p.disconnect()  # the functions of the module act on the first connection
        p.connect(p.DIRECT)
        p.setGravity(*scene["gravity"])
        p.setTimeStep(scene["dt"])
        p.setPhysicsEngineParameter(deterministicOverlappingPairs=1, **solver(variant))
        self.scene, self.place = scene, []
        # Bullet multiplies the coefficients of two bodies.
        self.surface = dict(lateralFriction=float(np.sqrt(scene["mu"])), spinningFriction=0, rollingFriction=0, restitution=0,
                            linearDamping=0, angularDamping=0, jointDamping=0)  # fmt: skip
        for plane in scene["planes"]:
            self.add_plane(plane, variant == "boxfloor")
        if "robot" in scene:
            self.load_robot(scene)
            return
        self.shape, self.joint = bodies(scene), joint_of(scene)
        self.place = [None] * len(scene["bodies"])
        for i in range(len(self.place)):
            if i not in self.joint:
                self.add_free(i)
            elif self.joint[i]["a"] < 0:
                self.add_tree(i)
        if not scene["collide"]:
            for body, link in self.place:
                p.setCollisionFilterGroupMask(body, link, 0, 0)
        if "velocities" in scene:
            for (body, _), twist in zip(self.place, velocities(scene).tolist()):
                p.resetBaseVelocity(body, twist[:3], twist[3:])
        self.index = {place: i for i, place in enumerate(self.place)}

    def add_plane(self, plane, thick):
        normal, offset = plane[:3], plane[3]
        if thick and normal == [0, 0, 1]:
            shape, at = p.createCollisionShape(p.GEOM_BOX, halfExtents=[20, 20, 1]), [0, 0, offset - 1]
        else:
            shape, at = p.createCollisionShape(p.GEOM_PLANE, planeNormal=normal), [x * offset for x in normal]
        p.changeDynamics(p.createMultiBody(0, shape, basePosition=at), -1, **self.surface)

    def collision_shape(self, i):
        kind, size, *_ = self.shape
        if kind[i] == "b":
            return p.createCollisionShape(p.GEOM_BOX, halfExtents=list(size[i]))
        return p.createCollisionShape(p.GEOM_SPHERE, radius=size[i][0])

    def moments(self, i):
        kind, size, mass, *_ = self.shape
        return list(inertia(kind[i], size[i], mass[i]))

    def add_free(self, i):
        _, _, mass, position, quaternion = self.shape
        maximal = not self.joint
        at = dict(basePosition=position[i], baseOrientation=xyzw(quaternion[i]), useMaximalCoordinates=int(maximal))
        body = p.createMultiBody(float(mass[i]), self.collision_shape(i), **at)
        extra = {} if maximal else dict(localInertiaDiagonal=self.moments(i))
        p.changeDynamics(body, -1, **self.surface, **extra)
        self.place[i] = (body, -1)

    def add_tree(self, root):
        """A tree of joints on a fixed base without mass, the link frames in the joints' anchors."""
        _, _, mass, position, quaternion = self.shape
        tree = [root]
        for i in tree:
            tree += [k for k, joint in self.joint.items() if joint["a"] == i]
        names = ("Masses", "CollisionShapeIndices", "VisualShapeIndices", "Positions", "Orientations", "InertialFramePositions",
                 "InertialFrameOrientations", "ParentIndices", "JointTypes", "JointAxis")  # fmt: skip
        links = {f"link{name}": [] for name in names}
        for i in tree:
            joint, frame, anchor = self.joint[i], rotation(quaternion[i]), np.array(self.joint[i]["anchor"], float)
            above, at, turn = joint["a"], anchor, quaternion[i]
            if above >= 0:
                at = rotation(quaternion[above]).T @ (anchor - np.array(self.joint[above]["anchor"], float))
                turn = relative(turn, quaternion[above])
            sort = p.JOINT_REVOLUTE if joint["type"] == "hinge" else p.JOINT_PRISMATIC
            shape = self.collision_shape(i) if self.scene["collide"] else -1
            values = (float(mass[i]), shape, -1, list(at), xyzw(turn), list(frame.T @ (position[i] - anchor)), [0, 0, 0, 1],
                      tree.index(above) + 1 if above >= 0 else 0, sort, list(frame.T @ np.array(joint["axis"], float)))  # fmt: skip
            for name, value in zip(names, values):
                links[f"link{name}"].append(value)
        body = p.createMultiBody(0, -1, basePosition=[0, 0, 0], **links)
        p.changeDynamics(body, -1, linearDamping=0, angularDamping=0)
        for link, i in enumerate(tree):
            p.changeDynamics(body, link, localInertiaDiagonal=self.moments(i), **self.surface)
            p.setJointMotorControl2(body, link, p.VELOCITY_CONTROL, force=0)
            self.place[i] = (body, link)

    def load_robot(self, scene):
        import os

        path = os.path.join(scene["robots"], scene["urdf"])
        robot = p.loadURDF(path, [0, 0, scene["base_height"]], flags=p.URDF_USE_INERTIA_FROM_FILE)
        links = {p.getJointInfo(robot, k)[1].decode(): k for k in range(p.getNumJoints(robot))}
        motors = [links[name] for name in scene["motors"]]
        for k in range(-1, p.getNumJoints(robot)):
            p.changeDynamics(robot, k, **self.surface)
            if k >= 0:
                p.setJointMotorControl2(robot, k, p.VELOCITY_CONTROL, force=0)
        for k, angle in zip(motors, np.tile(scene["stance"], 4)):
            p.resetJointState(robot, k, angle)
        center = np.array(p.getDynamicsInfo(robot, -1)[3])
        p.resetBasePositionAndOrientation(robot, np.array([0, 0, scene["base_height"]]) + center, [0, 0, 0, 1])

        def joints():
            states = p.getJointStates(robot, motors)
            return np.array([s[0] for s in states]), np.array([s[1] for s in states])

        def state():
            at, q = p.getBasePositionAndOrientation(robot)
            turn = [q[3], *q[:3]]
            velocity, spin = p.getBaseVelocity(robot)
            return np.array([[*(np.array(at) - rotation(turn) @ center), *turn, *velocity, *spin]])

        self.joints, self.state = joints, state
        self.torque = lambda values: p.setJointMotorControlArray(robot, motors, p.TORQUE_CONTROL, forces=list(values))

    def step(self):
        for i, *force in self.scene.get("forces", []):
            body, link = self.place[i]
            at = p.getLinkState(body, link)[0] if link >= 0 else p.getBasePositionAndOrientation(body)[0]
            p.applyExternalForce(body, link, force, at, p.WORLD_FRAME)
        p.stepSimulation()

    def contacts(self):
        return len(p.getContactPoints())

    def state(self):
        rows = np.zeros((len(self.place), 13))
        for i, (body, link) in enumerate(self.place):
            if link < 0:
                at, q = p.getBasePositionAndOrientation(body)
                velocity, spin = p.getBaseVelocity(body)
            else:
                state = p.getLinkState(body, link, computeLinkVelocity=1, computeForwardKinematics=1)
                at, q, velocity, spin = state[0], state[1], state[6], state[7]
            rows[i] = [*at, q[3], *q[:3], *velocity, *spin]
        return rows

    def forces(self):
        rows = []
        for c in p.getContactPoints():
            i, j = self.index.get((c[1], c[3]), -1), self.index.get((c[2], c[4]), -1)
            normal = np.array(c[7])  # on the second body, towards the first
            force = c[9] * normal + c[10] * np.array(c[11]) + c[12] * np.array(c[13])
            if i < 0:
                i, j, normal, force = j, i, -normal, -force
            # Between two bodies each of its two friction directions has a bound of its own, against planes they share a circle.
            corner = np.array(c[11]) + np.array(c[13]) if j >= 0 else np.zeros(3)
            rows.append(row(i, j, (np.array(c[5]) + np.array(c[6])) / 2, normal, force, self.scene["mu"], c[8], corner))
        return rows
