"""Writes NAME.txt for every robot in ROBOTS: its kinematic tree as numbers, and what Pinocchio and MuJoCo compute on it at 100
random states. crates/multibody/tests/it/peers.rs compares the engine with them and needs neither.

    python -m venv .venv && .venv/bin/pip install pin==4.1.0 mujoco==4.0.0 example-robot-data==6.0.0 \
        dm_control==1.0.50 gymnasium==1.4.0
    .venv/bin/python crates/multibody/testdata/peers/make_numbers.py [NAME ...]

A URDF is loaded by Pinocchio, an MJCF by MuJoCo; the numbers are those of the engine that loaded it. The tree is then handed
to the other engine, whose numbers have to agree within AGREEMENT, so that the stored ones are those of both.

Of an array of numbers `a` the file holds `Σ w a` with random weights w in [−1, 1): an error of any entry shows in it.
"""

import importlib.metadata
import pathlib
import sys

import mujoco
import numpy as np
import pinocchio as pin
from splitmix import Random
from tree import SIZE, mujoco_of_tree, pinocchio_of_tree, random_tree, rotation_of, tree_of_mujoco, tree_of_pinocchio

HERE = pathlib.Path(__file__).resolve().parent
STATES = 100
AGREEMENT = 1e-9
QUANTITIES = (
    "position rotation jacobian jacobian_rate mass bias inverse_dynamics forward_dynamics center_of_mass "
    "centroidal_matrix kinetic_energy potential_energy"
).split()

SITE = pathlib.Path(pin.__file__).resolve().parents[1]
URDF = next(SITE.parents[i] / "share/example-robot-data/robots" for i in range(3)
            if (SITE.parents[i] / "share/example-robot-data/robots").is_dir())
MJCF = pathlib.Path(importlib.metadata.distribution("dm_control").locate_file(""))
SCENES = HERE.parents[3] / "scenes"

FLOATING = {
    "talos": "talos_data/robots/talos_full_v2.urdf",
    "alex": "alex_description/urdf/alex_nub_hands.urdf",
    "g1": "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "laikago": "laikago_description/urdf/laikago.urdf",
    "solo12": "solo_description/robots/solo12.urdf",
    "anymal_c": "anymal_c_simple_description/urdf/anymal.urdf",
    "go2": "go2_description/urdf/go2.urdf",
    "b1_z1": "b1_description/urdf/b1-z1.urdf",
    "hyq": "hyq_description/robots/hyq_no_sensors.urdf",
    "bolt": "bolt_description/robots/bolt.urdf",
    "simple_humanoid": "simple_humanoid_description/urdf/simple_humanoid.urdf",
    "hextilt": "hextilt_description/urdf/hextilt_flying_arm_5.urdf",
    "a1": "a1_description/urdf/a1.urdf",
    "centauro": "centauro_description/urdf/centauro.urdf",
}
FIXED = {
    "panda": "panda_description/urdf/panda.urdf",
    "ur10": "ur_description/urdf/ur10_robot.urdf",
    "kinova": "kinova_description/robots/kinova.urdf",
    "xarm7": "xarm_description/urdf/xarm7.urdf",
    "baxter": "baxter_description/urdf/baxter.urdf",
    "pr2": "pr2_description/urdf/pr2.urdf",
    "tiago": "tiago_description/robots/tiago.urdf",
    "allegro": "allegro_hand_description/urdf/allegro_right_hand.urdf",
    "so101": "so_arm_description/urdf/so101.urdf",
    "double_pendulum": "double_pendulum_description/urdf/double_pendulum_continuous.urdf",
}
XML = {
    "dm_humanoid": MJCF / "dm_control/suite/humanoid.xml",
    "dm_quadruped": MJCF / "dm_control/suite/quadruped.xml",
    "dm_humanoid_cmu": MJCF / "dm_control/suite/humanoid_CMU.xml",
    "dm_walker": MJCF / "dm_control/suite/walker.xml",
    "dm_cheetah": MJCF / "dm_control/suite/cheetah.xml",
    "dm_fish": MJCF / "dm_control/suite/fish.xml",
    "dm_swimmer": MJCF / "dm_control/suite/swimmer.xml",
    "gym_ant": MJCF / "gymnasium/envs/mujoco/assets/ant.xml",
    "gym_humanoid": MJCF / "gymnasium/envs/mujoco/assets/humanoid.xml",
    "gym_half_cheetah": MJCF / "gymnasium/envs/mujoco/assets/half_cheetah.xml",
    "gym_hopper": MJCF / "gymnasium/envs/mujoco/assets/hopper.xml",
    "gym_pusher": MJCF / "gymnasium/envs/mujoco/assets/pusher_v5.xml",
    "scene_quadruped": SCENES / "quadruped.xml",
    "scene_gripper": SCENES / "gripper.xml",
    "scene_spinning_top": SCENES / "spinning_top.xml",
}
RANDOM = {f"random_{i}": i for i in range(6)}
ROBOTS = [*FLOATING, *FIXED, *XML, *RANDOM]


def random_state(random, tree):
    """q, v, an acceleration and a force; scalars of q in [−1.5, 1.5)."""
    q = []
    for joint in tree.joints():
        if joint.kind == "free":
            q.append(random.uniform(-1.5, 1.5, 3))
        q.append(random.quaternion() if joint.kind in ("free", "ball") else random.uniform(-1.5, 1.5, 1))
    nv = tree.nv()
    return np.concatenate(q), random.uniform(-2, 2, nv), random.uniform(-5, 5, nv), random.uniform(-20, 20, nv)


class Pinocchio:
    """Its free joint has the velocity of the origin in body axes: `v_pin = Tᵀ v`, T = diag(R, 1)."""

    def __init__(self, tree, model=None):
        self.tree = tree
        if model is None:
            self.model, self.frames = pinocchio_of_tree(tree)
        else:
            self.model = model
            self.frames = [model.addFrame(pin.Frame(f"body of joint {j}", j, 0, pin.SE3.Identity(), pin.OP_FRAME))
                           for j in range(1, model.njoints)]
        self.data = self.model.createData()
        self.rotorless = self.model.copy()
        self.rotorless.armature = np.zeros(self.model.nv)
        self.rotorless_data = self.rotorless.createData()

    def kinetic_energy(self, x, u):
        """Pinocchio counts rotor inertia in some kinds of joints only, so it is added here for all."""
        model, data = self.rotorless, self.rotorless_data
        return pin.computeKineticEnergy(model, data, x, u) + 0.5 * (self.model.armature * u) @ u

    def configuration(self, q):
        """Its q, T, dT/dt without the angular velocity's place, and the places of free joints in v."""
        out, i, k, free = [], 0, 0, []
        T = np.eye(self.tree.nv())
        for joint, made in zip(self.tree.joints(), list(self.model.joints)[1:]):
            nq, nv = SIZE[joint.kind]
            x = q[i : i + nq]
            if joint.kind in ("free", "ball"):
                w = x[-4:]
                out += [*x[:-4], w[1], w[2], w[3], w[0]]
                if joint.kind == "free":
                    T[k : k + 3, k : k + 3] = rotation_of(w)
                    free.append(k)
            elif made.nq == 2:
                out += [np.cos(x[0]), np.sin(x[0])]
            else:
                out.append(x[0])
            i, k = i + nq, k + nv
        return np.array(out), T, free

    def evaluate(self, q, v, acceleration, force):
        model, data = self.model, self.data
        x, T, free = self.configuration(q)
        u = T.T @ v
        rate = np.zeros_like(T)
        shift = np.zeros(model.nv)
        for k in free:
            w = pin.skew(u[k + 3 : k + 6])
            rate[k : k + 3, k : k + 3] = T[k : k + 3, k : k + 3] @ w
            shift[k : k + 3] = w @ u[k : k + 3]
        # v̇_pin = Tᵀ v̇ + Ṫᵀ v, and Ṫᵀ v = −ω × v_pin.
        pin.computeJointJacobiansTimeVariation(model, data, x, u)
        pin.forwardKinematics(model, data, x, u)
        pin.updateFramePlacements(model, data)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        order = [3, 4, 5, 0, 1, 2]
        jacobians, rates = [], []
        for frame in self.frames:
            J = pin.getFrameJacobian(model, data, frame, aligned)[order]
            dJ = pin.getFrameJacobianTimeVariation(model, data, frame, aligned)[order]
            jacobians.append(J @ T.T)
            rates.append(dJ @ T.T + J @ rate.T)
        mass = pin.crba(model, data, x)
        mass = np.triu(mass) + np.triu(mass, 1).T
        out = {
            "position": np.array([data.oMf[f].translation for f in self.frames]),
            "rotation": np.array([data.oMf[f].rotation for f in self.frames]),
            "jacobian": np.array(jacobians),
            "jacobian_rate": np.array(rates),
            "mass": T @ mass @ T.T,
            "bias": T @ pin.rnea(model, data, x, u, -shift),
            "inverse_dynamics": T @ pin.rnea(model, data, x, u, T.T @ acceleration - shift),
            "forward_dynamics": T @ (pin.aba(model, data, x, u, T.T @ force) + shift),
            "center_of_mass": pin.centerOfMass(model, data, x, u),
            "centroidal_matrix": pin.ccrba(model, data, x, u)[order] @ T.T,
            "kinetic_energy": self.kinetic_energy(x, u),
            "potential_energy": pin.computePotentialEnergy(model, data, x),
        }
        return {name: np.array(value).ravel() for name, value in out.items()}


class Mujoco:
    """Its conventions are ours. Passive forces, constraints and actuators are not part of any quantity."""

    def __init__(self, tree, model=None):
        self.model = mujoco_of_tree(tree) if model is None else model
        self.data = mujoco.MjData(self.model)
        self.armature = tree.armature()

    def evaluate(self, q, v, acceleration, force):
        m, d = self.model, self.data
        d.qpos[:], d.qvel[:], d.qacc[:] = q, v, acceleration
        for stage in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_crb, mujoco.mj_factorM, mujoco.mj_comVel):
            stage(m, d)
        jacobians, rates = [], []
        for b in range(1, m.nbody):
            linear, angular, d_linear, d_angular = (np.zeros((3, m.nv)) for _ in range(4))
            mujoco.mj_jac(m, d, linear, angular, d.xpos[b], b)
            mujoco.mj_jacDot(m, d, d_linear, d_angular, d.xpos[b], b)
            jacobians.append(np.vstack([angular, linear]))
            rates.append(np.vstack([d_angular, d_linear]))
        mass = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, d, mass)
        bias, inverse = np.zeros(m.nv), np.zeros(m.nv)
        mujoco.mj_rne(m, d, 0, bias)
        mujoco.mj_rne(m, d, 1, inverse)
        forward = np.zeros((1, m.nv))
        mujoco.mj_solveM(m, d, forward, (force - bias)[None])
        linear, angular = np.zeros((3, m.nv)), np.zeros((3, m.nv))
        mujoco.mj_jacSubtreeCom(m, d, linear, 0)
        mujoco.mj_angmomMat(m, d, angular, 0)
        mujoco.mj_energyVel(m, d)
        weight = -m.body_mass[1:, None] * d.xipos[1:]
        out = {
            "position": d.xpos[1:],
            "rotation": d.xmat[1:],
            "jacobian": np.array(jacobians),
            "jacobian_rate": np.array(rates),
            "mass": mass,
            "bias": bias,
            "inverse_dynamics": inverse + self.armature * acceleration,
            "forward_dynamics": forward,
            "center_of_mass": d.subtree_com[0],
            "centroidal_matrix": np.vstack([angular, linear * m.body_mass[1:].sum()]),
            "kinetic_energy": d.energy[1],
            "potential_energy": (weight @ m.opt.gravity).sum(),
        }
        return {name: np.array(value).ravel() for name, value in out.items()}


def load(name):
    """The tree, the engine that loaded it, and where it is from."""
    if name in RANDOM:
        seed = RANDOM[name]
        tree = random_tree(Random(seed), 4 + 3 * seed, armature=seed % 2 == 1)
        return tree, Mujoco(tree), f"splitmix.py, seed {seed}"
    if name in XML:
        path = XML[name]
        root = SCENES.parent if SCENES in path.parents else MJCF
        if root == MJCF:
            model = mujoco.MjModel.from_xml_path(str(path))
        else:
            # The scenes leave out the size of planes, which MuJoCo wants.
            text = path.read_text().replace('type="plane"', 'type="plane" size="1 1 1"')
            model = mujoco.MjModel.from_xml_string(text)
        tree = tree_of_mujoco(model)
        package = path.relative_to(root).parts[0]
        version = "" if root != MJCF else " " + importlib.metadata.version(package)
        return tree, Mujoco(tree, model), f"{path.relative_to(root)}{version}"
    if name in FLOATING:
        model = pin.buildModelFromUrdf(str(URDF / FLOATING[name]), pin.JointModelFreeFlyer())
    else:
        model = pin.buildModelFromUrdf(str(URDF / FIXED[name]))
    tree = tree_of_pinocchio(model)
    path = (FLOATING | FIXED)[name]
    version = importlib.metadata.version("example-robot-data")
    return tree, Pinocchio(tree, model), f"example-robot-data {version} {path}"


def largest(values):
    return np.abs(values).max(initial=0.0)


def make(name):
    tree, own, source = load(name)
    try:
        other = Mujoco(tree) if isinstance(own, Pinocchio) else Pinocchio(tree)
    except ValueError as error:
        other = None
        print(f"{name}: only one engine takes it: {str(error).splitlines()[0]}")
    random = Random(1000 + ROBOTS.index(name))
    lines, worst = [], dict.fromkeys(QUANTITIES, 0.0)
    for _ in range(STATES):
        state = random_state(random, tree)
        result = own.evaluate(*state)
        if other:
            for quantity, value in other.evaluate(*state).items():
                scale = largest(result[quantity])
                error = largest(value - result[quantity]) / scale if scale else largest(value)
                worst[quantity] = max(worst[quantity], error)
        sums = [random.uniform(-1.0, 1.0, result[name].size) @ result[name] for name in QUANTITIES]
        lines.append("state " + " ".join(f"{x:.15g}" for x in sums))
    engine = "pinocchio" if isinstance(own, Pinocchio) else "mujoco"
    version = (pin if engine == "pinocchio" else mujoco).__version__
    head = f"# {source}\nmade by {engine} {version}\nseed {1000 + ROBOTS.index(name)}\n"
    (HERE / f"{name}.txt").write_text(head + tree.text() + "\n".join(lines) + "\n")
    if other:
        bad = {q: f"{e:.1e}" for q, e in worst.items() if e > AGREEMENT}
        print(f"{name}: nv {tree.nv()}, the engines agree within {max(worst.values()):.1e}", bad or "")
        return not bad
    return True


def main():
    names = sys.argv[1:] or ROBOTS
    disagreeing = [name for name in names if not make(name)]
    if disagreeing:
        sys.exit(f"the engines do not agree on {', '.join(disagreeing)}")


if __name__ == "__main__":
    main()
