"""DART (dartpy), contact points of its ODE detector: its default detector gives one point for a box on a plane. No sleeping,
no matrix-free path, one thread. Variants:

dantzig  the boxed LCP and Dantzig solver that World installs
nsgs     nonsmooth Gauss-Seidel on the exact cone
"""

import os

import dartpy as dart
import numpy as np
from protocol import bodies, inertia, joint_of, rotation, row


def version():
    return dart.__version__


def transform(turn, at):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, at
    return dart.math.Isometry3(matrix)


class Peer:
    def __init__(self, scene, variant):
        self.scene, self.index, self.nodes = scene, {}, []
        self.world = world = dart.simulation.World()
        world.setGravity(np.array(scene["gravity"], float))
        world.setTimeStep(scene["dt"])
        world.setNumSimulationThreads(1)
        solver = world.getConstraintSolver()
        solver.setCollisionDetector(dart.collision.OdeCollisionDetector())
        if variant == "nsgs":
            solver.setBoxedLcpSolver(dart.constraint.NsgsFrictionSolver())
        matrix_free = solver.getMatrixFreeContactSolverOptions()
        matrix_free.mEnabled = False
        solver.setMatrixFreeContactSolverOptions(matrix_free)
        sleeping = world.getDeactivationOptions()
        sleeping.mEnabled = False
        world.setDeactivationOptions(sleeping)
        solver.getCollisionOption().maxNumContacts = max(1000, 12 * len(scene.get("bodies", [])))
        ground = dart.dynamics.Skeleton("ground")
        for plane in scene["planes"]:
            _, node = ground.createWeldJointAndBodyNodePair()
            self.give_shape(node, dart.dynamics.PlaneShape(np.array(plane[:3], float), float(plane[3])))
        if scene["planes"]:
            world.addSkeleton(ground)
        if "robot" in scene:
            self.load_robot(scene)
        else:
            self.add_bodies(scene)

    def give_shape(self, node, shape):
        shape_node = node.createShapeNode(shape)
        shape_node.createCollisionAspect()
        shape_node.createDynamicsAspect()
        self.set_friction(shape_node)

    def set_friction(self, shape_node):
        surface = shape_node.getDynamicsAspect()
        surface.setFrictionCoeff(self.scene["mu"])
        surface.setRestitutionCoeff(0.0)

    def add_bodies(self, scene):
        kind, size, mass, position, quaternion = bodies(scene)
        joints = joint_of(scene)
        for i in range(len(kind)):  # a parent comes before its children in every scene
            turn, hinge = rotation(quaternion[i]), joints.get(i)
            above = self.nodes[hinge["a"]] if hinge and hinge["a"] >= 0 else None
            skeleton = above.getSkeleton() if above is not None else dart.dynamics.Skeleton(f"skeleton{i}")
            arguments = [] if above is None else [above]
            if hinge is None:
                joint, node = skeleton.createFreeJointAndBodyNodePair()
                joint.setTransform(transform(turn, position[i]))
            else:
                revolute = hinge["type"] == "hinge"
                make = skeleton.createRevoluteJointAndBodyNodePair if revolute else skeleton.createPrismaticJointAndBodyNodePair
                joint, node = make(*arguments)
                anchor = np.array(hinge["anchor"], float)
                joint.setAxis(turn.T @ np.array(hinge["axis"], float))
                back, origin = (np.eye(3), np.zeros(3))
                if above is not None:
                    back, origin = rotation(quaternion[hinge["a"]]).T, position[hinge["a"]]
                joint.setTransformFromParentBodyNode(transform(back @ turn, back @ (anchor - origin)))
                joint.setTransformFromChildBodyNode(transform(np.eye(3), turn.T @ (anchor - position[i])))
            moments = np.diag(inertia(kind[i], size[i], mass[i]))
            node.setInertia(dart.dynamics.Inertia(float(mass[i]), np.zeros(3), moments))
            if scene["collide"]:
                box = kind[i] == "b"
                self.give_shape(node, dart.dynamics.BoxShape(2 * size[i]) if box else dart.dynamics.SphereShape(size[i][0]))
            node.setName(f"node{i}")
            self.index[f"node{i}"] = i
            self.nodes.append(node)
            if above is None:
                self.world.addSkeleton(skeleton)

    def load_robot(self, scene):
        robot = dart.utils.DartLoader().parseSkeleton(os.path.join(scene["robots"], scene["urdf"]))
        for k in range(robot.getNumBodyNodes()):
            for shape_node in robot.getBodyNode(k).getShapeNodes():
                try:
                    shape_node.getDynamicsAspect()
                except Exception:  # noqa: BLE001
                    shape_node.createDynamicsAspect()
                self.set_friction(shape_node)
        self.world.addSkeleton(robot)
        motors = [robot.getDof(name).getIndexInSkeleton() for name in scene["motors"]]
        q = np.array(robot.getPositions())
        q[motors] = np.tile(scene["stance"], 4)
        base = [k for k in range(robot.getNumDofs()) if k not in motors]
        q[base[5]] = scene["base_height"]
        robot.setPositions(q)
        self.nodes, torque = [robot.getBodyNode(0)], np.zeros(robot.getNumDofs())
        self.joints = lambda: (np.array(robot.getPositions())[motors], np.array(robot.getVelocities())[motors])

        def give(values):
            torque[motors] = values
            robot.setForces(torque)

        self.torque = give

    def step(self):
        for i, *force in self.scene.get("forces", []):
            self.nodes[i].addExtForce(force)
        self.world.step()

    def contacts(self):
        return self.world.getLastCollisionResult().getNumContacts()

    def state(self):
        rows = np.zeros((len(self.nodes), 13))
        for i, node in enumerate(self.nodes):
            pose = node.getWorldTransform()
            q = pose.quaternion()
            rows[i, :7] = [*np.ravel(pose.translation()), *np.ravel(q.wxyz() if hasattr(q, "wxyz") else (q.w(), q.x(), q.y(), q.z()))]
            rows[i, 7:] = [*np.ravel(node.getLinearVelocity()), *np.ravel(node.getAngularVelocity())]
        return rows

    def forces(self):
        result, rows = self.world.getLastCollisionResult(), []
        for k in range(result.getNumContacts()):
            contact = result.getContact(k)
            i, j = (self.body(o) for o in (contact.collisionObject1, contact.collisionObject2))
            normal, force = np.ravel(contact.normal), np.ravel(contact.force)
            if i < 0:
                i, j, normal, force = j, i, -normal, -force
            rows.append(row(i, j, np.ravel(contact.point), normal, force, self.scene["mu"]))
        return rows

    def body(self, collision_object):
        frame = collision_object.getShapeFrame()
        node = frame.asShapeNode().getBodyNodePtr() if hasattr(frame, "asShapeNode") else frame.getParentFrame()
        return self.index.get(node.getName(), -1)
