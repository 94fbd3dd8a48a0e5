"""Drake, discrete MultibodyPlant with the SAP solver. Variants:

hydro  boxes compliant hydroelastic (5e7 Pa) on rigid planes: many points per pair
sap    point contact: one point per pair, so boxes rock; for spheres, robots and mechanisms
"""

import os

import numpy as np
from protocol import bodies, inertia, joint_of, rotation, row
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    CollisionFilterDeclaration,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    RoleAssign,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.common.eigen_geometry import Quaternion
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder


def version():
    from importlib.metadata import version as installed

    return installed("drake")


class Peer:
    def __init__(self, scene, variant):
        self.scene, self.hydro, self.frames, self.count = scene, variant == "hydro", 0, 0
        contact = "hydroelastic_with_fallback" if self.hydro else "point"
        config = MultibodyPlantConfig(time_step=scene["dt"], discrete_contact_approximation="sap", contact_model=contact)
        self.builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlant(config, self.builder)
        self.plant.mutable_gravity_field().set_gravity_vector(scene["gravity"])
        self.friction = CoulombFriction(scene["mu"], scene["mu"])
        for k, plane in enumerate(scene["planes"]):
            normal = np.array(plane[:3], float)
            pose = RigidTransform(HalfSpace.MakePose(normal, normal * plane[3]).rotation(), normal * plane[3])
            world = self.plant.world_body()
            self.plant.RegisterCollisionGeometry(world, pose, HalfSpace(), f"plane{k}", self.material(None))
        if "robot" in scene:
            self.load_robot(scene)
        else:
            self.add_bodies(scene)
        self.index = {int(body.index()): i for i, body in enumerate(self.bodies)}
        self.simulator.Initialize()

    def material(self, size):
        """Surface of a moving geom of this size, or of a plane."""
        properties = ProximityProperties()
        AddContactMaterial(friction=self.friction, properties=properties)
        if self.hydro and size is None:
            AddRigidHydroelasticProperties(resolution_hint=1.0, properties=properties)
        elif self.hydro:
            AddCompliantHydroelasticProperties(resolution_hint=size, hydroelastic_modulus=5e7, properties=properties)
        return properties

    def start(self):
        self.simulator = Simulator(self.builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())

    def frame(self, body, turn, at):
        self.frames += 1
        pose = RigidTransform(RotationMatrix.ProjectToRotationMatrix(turn), at)
        return self.plant.AddFrame(FixedOffsetFrame(f"frame{self.frames}", body.body_frame(), pose))

    def add_bodies(self, scene):
        plant, (kind, size, mass, position, quaternion) = self.plant, bodies(scene)
        self.bodies = []
        for i in range(len(kind)):
            moments = inertia(kind[i], size[i], mass[i]) / mass[i]
            body = plant.AddRigidBody(f"body{i}", SpatialInertia(mass[i], [0, 0, 0], UnitInertia(*moments)))
            self.bodies.append(body)
            if scene["collide"]:
                shape = Box(*(2 * size[i])) if kind[i] == "b" else Sphere(size[i][0])
                smallest = float(size[i][size[i] > 0].min())
                plant.RegisterCollisionGeometry(body, RigidTransform(), shape, f"geom{i}", self.material(smallest))
        joints = joint_of(scene)
        for i, joint in joints.items():
            above, turn, anchor = joint["a"], rotation(quaternion[i]), np.array(joint["anchor"], float)
            parent = self.frame(plant.world_body(), turn, anchor)
            if above >= 0:
                back = rotation(quaternion[above]).T
                parent = self.frame(self.bodies[above], back @ turn, back @ (anchor - position[above]))
            child = self.frame(self.bodies[i], np.eye(3), turn.T @ (anchor - position[i]))
            sort = RevoluteJoint if joint["type"] == "hinge" else PrismaticJoint
            plant.AddJoint(sort(f"joint{i}", parent, child, turn.T @ np.array(joint["axis"], float)))
        plant.Finalize()
        for i in set(range(len(kind))) - set(joints):
            unit = Quaternion(quaternion[i] / np.linalg.norm(quaternion[i]))
            plant.SetDefaultFloatingBaseBodyPose(self.bodies[i], RigidTransform(unit, position[i]))
        self.start()
        forces = []
        for i, *force in scene["forces"]:
            applied = ExternallyAppliedSpatialForce()
            applied.body_index, applied.p_BoBq_B = self.bodies[i].index(), np.zeros(3)
            applied.F_Bq_W = SpatialForce(np.zeros(3), np.array(force, float))
            forces.append(applied)
        if forces:
            plant.get_applied_spatial_force_input_port().FixValue(self.context, forces)

    def load_robot(self, scene):
        plant = self.plant
        robot = Parser(plant).AddModels(os.path.join(scene["robots"], scene["urdf"]))[0]
        for name in scene["motors"]:
            if not plant.HasJointActuatorNamed("motor_" + name, robot):
                plant.AddJointActuator("motor_" + name, plant.GetJointByName(name))
        geoms = [g for k in plant.GetBodyIndices(robot) for g in plant.GetCollisionGeometriesForBody(plant.get_body(k))]
        for geom in geoms:
            source = plant.get_source_id()
            self.scene_graph.AssignRole(source, geom, self.material(0.02), RoleAssign.kReplace)
        plant.Finalize()
        own = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(geoms))
        self.scene_graph.collision_filter_manager().Apply(own)
        base = plant.get_body(plant.GetBodyIndices(robot)[0])
        plant.SetDefaultFloatingBaseBodyPose(base, RigidTransform([0, 0, scene["base_height"]]))
        self.bodies = [base]
        self.start()
        joints = [plant.GetJointByName(name) for name in scene["motors"]]
        for joint, angle in zip(joints, np.tile(scene["stance"], 4)):
            joint.set_angle(self.context, angle)
        motors = [plant.get_joint_actuator(k) for k in plant.GetJointActuatorIndices(robot)]
        start = {motor.joint().name(): motor.input_start() for motor in motors}
        entry = [start[name] for name in scene["motors"]]
        angle = [joint.position_start() for joint in joints]
        rate = [plant.num_positions() + joint.velocity_start() for joint in joints]
        values = np.zeros(plant.num_actuators())
        port = plant.get_actuation_input_port()
        port.FixValue(self.context, values)

        def measure():
            x = plant.GetPositionsAndVelocities(self.context)
            return x[angle], x[rate]

        def torque(wanted):
            values[entry] = wanted
            port.FixValue(self.context, values)

        self.joints, self.torque = measure, torque

    def step(self):
        self.count += 1
        self.simulator.AdvanceTo(self.count * self.scene["dt"])

    def results(self):
        return self.plant.get_contact_results_output_port().Eval(self.context)

    def contacts(self):
        results = self.results()
        patches = [results.hydroelastic_contact_info(k).contact_surface() for k in range(results.num_hydroelastic_contacts())]
        return results.num_point_pair_contacts() + sum(surface.num_faces() for surface in patches)

    def state(self):
        rows = np.zeros((len(self.bodies), 13))
        for i, body in enumerate(self.bodies):
            pose = self.plant.EvalBodyPoseInWorld(self.context, body)
            velocity, q = self.plant.EvalBodySpatialVelocityInWorld(self.context, body), pose.rotation().ToQuaternion()
            rows[i] = [*pose.translation(), q.w(), q.x(), q.y(), q.z(), *velocity.translational(), *velocity.rotational()]
        return rows

    def forces(self):
        """Of point contacts; hydroelastic patches report no force per point."""
        results, rows = self.results(), []
        for k in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(k)
            i, j = self.index.get(int(info.bodyB_index()), -1), self.index.get(int(info.bodyA_index()), -1)
            normal, force = -np.array(info.point_pair().nhat_BA_W), np.array(info.contact_force())
            if i < 0:
                i, j, normal, force = j, i, -normal, -force
            rows.append(row(i, j, info.contact_point(), normal, force, self.scene["mu"]))
        return rows
