"""Contacts, certificates, problems and smooth dynamics of a step."""

import numpy as np
import pytest

import signorini
from conftest import mjcf
from signorini import ContactMode


def test_forces_of_a_resting_body_carry_its_weight(ball):
    data = signorini.Data(ball)
    signorini.step(ball, data, nstep=20)
    contact = data.contact
    assert contact.force_world.sum(axis=0) == pytest.approx([0, 0, 9.81], abs=1e-9)
    assert ball.geom(int(contact.geom1[0])).name == "floor" and contact.body2.tolist() == [1]
    assert contact.frame[0, 0] == pytest.approx([0, 0, 1]) and contact.point[0] == pytest.approx([0, 0, 0], abs=1e-12)
    assert np.linalg.det(contact.frame[0]) == pytest.approx(1) and contact.gap == pytest.approx([0], abs=1e-12)
    assert contact.impulse / data.timestep == pytest.approx(contact.force)
    assert contact.mode.tolist() == [ContactMode.STICKING] and data.certificate.holds(1e-9)


def test_a_sliding_box_has_friction_at_the_bound_and_coulombs_acceleration(slope):
    data = signorini.Data(slope)
    signorini.step(slope, data, nstep=50)
    c = data.contact
    normal, tangential = c.force[:, 0], np.linalg.norm(c.force[:, 1:], axis=1)
    assert tangential == pytest.approx(0.3 * normal) and (c.mode[normal > 0] == ContactMode.SLIDING).all()
    assert data.qacc[0] == pytest.approx(9.81 * (0.5 - 0.3 * np.sqrt(0.75)), rel=1e-9)
    assert c.force_world.sum(axis=0) == pytest.approx([-0.3 * 2 * 9.81 * np.sqrt(0.75), 0, 2 * 9.81 * np.sqrt(0.75)], abs=1e-8)
    world = np.einsum("ni,nij->nj", c.force, c.frame)
    assert world == pytest.approx(c.force_world) and (c.sliding_velocity[:, 0] > 0).all()


def test_the_problem_of_a_step_has_the_step_as_its_solution(slope):
    data = signorini.Data(slope)
    signorini.step(slope, data, nstep=10)
    problem, v = data.problem(), data.qvel
    nc, offsets, D = problem.nc, problem.direction_offsets, problem.D
    alpha, lambda_n = data.solution().alpha, data.solution().lambda_n
    impulse = problem.Jn.T @ lambda_n
    for i in range(nc):
        k = slice(offsets[i], offsets[i + 1])
        impulse += problem.Jt[2 * i:2 * i + 2].T @ (D[k].T @ alpha[k])
    assert problem.M @ (v - problem.v_free) == pytest.approx(impulse, abs=1e-12)
    gap = problem.phi / problem.dt + problem.Jn @ v
    assert (gap > -1e-12).all() and np.minimum(gap, lambda_n) == pytest.approx(np.zeros(nc), abs=1e-9)
    for method in ("structured", "lemke"):
        assert problem.solve(method).v == pytest.approx(v, abs=1e-10)
    solution = data.solution()
    claimed = problem.certify(solution.v, lambda_n, alpha, solution.beta)
    assert claimed.worst == solution.certificate.worst
    assert not problem.certify(solution.v + 0.01, lambda_n, alpha, solution.beta).holds(1e-9)


def test_friction_of_joints_and_of_spinning_is_certified_with_its_own_impulses():
    model = signorini.Model.from_string("""<mujoco><worldbody><geom type="plane" condim="6" friction="0.8 0.01 0.01"/>
        <body pos="0 0 0.1"><freejoint/><geom size="0.1" condim="6" friction="0.8 0.01 0.01"/></body>
        <body pos="1 0 1"><joint axis="0 1 0" frictionloss="0.1"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/></body>
        </worldbody></mujoco>""")
    data = signorini.Data(model)
    data.qvel[:6] = [0.3, 0.1, 0, 1, 2, 3]
    signorini.step(model, data, nstep=5)
    problem, solution = data.problem(), data.solution()
    claimed = (solution.v, solution.lambda_n, solution.alpha, solution.beta)
    groups = {"alpha_f": solution.alpha_f, "beta_f": solution.beta_f}
    assert len(solution.beta_f) >= 3 and problem.certify(*claimed, **groups).worst == solution.certificate.worst < 1e-9
    assert not problem.certify(*claimed, alpha_f=groups["alpha_f"] + 1e-3, beta_f=groups["beta_f"]).holds(1e-9)
    for missing in groups:
        with pytest.raises(signorini.ProblemError, match="are missing"):
            problem.certify(*claimed, **{name: value for name, value in groups.items() if name != missing})


@pytest.mark.parametrize("joint", ['type="slide" axis="1 0 0"', 'axis="0 1 0"'])
def test_the_gap_of_a_limit_is_the_distance_to_it_where_it_is_crossed_at_the_beginning(joint):
    model = signorini.Model.from_string(f"""<mujoco><compiler angle="radian" autolimits="true"/><option gravity="0 0 0"/><worldbody>
        <body><joint {joint} range="-1 0"/><geom size="0.1" pos="0.2 0 0"/></body></worldbody></mujoco>""")
    data = signorini.Data(model)
    data.qpos[0] = 0.02
    signorini.step(model, data)
    assert list(data.limit.upper) == [True] and data.limit.gap == pytest.approx([-0.02], abs=1e-15)


def test_limits_have_forces(pendulum):
    data = signorini.Data(pendulum)
    data.qpos[0] = np.radians(170)
    data.ctrl[0] = 20.0
    signorini.step(pendulum, data, nstep=3)
    limit = data.limit
    torque = 20.0 - 2 * 9.81 * 0.5 * np.sin(np.radians(170))
    assert limit.joint.tolist() == [0] and limit.upper.tolist() == [True] and len(data.contact) == 0
    assert limit.force == pytest.approx([torque], rel=1e-9) and data.qvel[0] == pytest.approx(0, abs=1e-12)
    assert limit.gap == pytest.approx([0], abs=1e-12) and limit.impulse == pytest.approx([0.002 * torque])


def test_limits_of_tendons_are_limits():
    slides = "".join(f"<body name='{n}'><joint name='{n}' type='slide' axis='0 0 1'/><geom size='.1' mass='1'/></body>"
                     for n in "ab")
    rope = "<tendon><fixed name='rope' range='-.1 1'><joint joint='a' coef='1'/><joint joint='b' coef='2'/></fixed></tendon>"
    drive = "<actuator><motor name='winch' tendon='rope' gear='3'/></actuator>"
    model = mjcf(slides, rest="<contact><exclude body1='a' body2='b'/></contact>" + rope + drive)
    data = signorini.Data(model)
    signorini.step(model, data, nstep=200)
    limit = data.limit
    assert limit.joint.tolist() == [-1] and limit.tendon.tolist() == [0] and limit.upper.tolist() == [False]
    # From rest on, the rope takes g (1 + 2) / (1 + 4) of force.
    assert limit.force == pytest.approx([9.81 * 3 / 5], rel=1e-9)
    assert (model.ntendon, model.tendon_names) == (1, ["rope"])
    winch = model.actuator("winch")
    assert (winch.joint, winch.tendon, winch.site, winch.gear) == (None, 0, None, 3.0)


def test_sensors_show_the_beginning_of_the_step():
    model = mjcf("<geom type='plane' size='1 1 1'/><body pos='0 0 .1'><joint name='up' type='slide' axis='0 0 1'/>"
                 "<geom size='.1' mass='2'/><site name='s' size='.2'/></body>",
                 rest="<sensor><jointpos name='height' joint='up'/><touch name='foot' site='s'/>"
                      "<accelerometer name='imu' site='s'/></sensor>")
    data = signorini.Data(model)
    assert (model.nsensor, model.nsensordata, data.sensordata.tolist()) == (3, 5, [0.0] * 5)
    signorini.step(model, data, nstep=2)
    weight = [0, 2 * 9.81, 0, 0, 9.81]
    assert data.sensordata == pytest.approx(weight, abs=1e-9) and data.sensor("imu") == pytest.approx(weight[2:], abs=1e-9)
    assert model.sensor_names == ["height", "foot", "imu"]
    data.qpos[0] = 0.5
    signorini.forward(model, data)
    assert data.sensor("height").tolist() == [0.5] and data.sensor(1) == pytest.approx([0])
    signorini.step(model, data)
    assert data.sensor("height").tolist() == [0.5] and data.qpos[0] < 0.5


def test_forward_shows_the_step_and_leaves_the_state(cards):
    data, other = signorini.Data(cards), signorini.Data(cards)
    for d in (data, other):
        signorini.step(cards, d, nstep=5)
    state, v = data.get_state(), data.qvel.copy()
    signorini.forward(cards, data)
    assert np.array_equal(data.get_state(), state)
    shown, problem_v = data.contact.force_world, data.solution().v
    signorini.step(cards, data)
    signorini.step(cards, other)
    assert np.array_equal(data.qvel, problem_v) and np.array_equal(data.contact.force_world, shown)
    assert np.array_equal(data.get_state(), other.get_state())
    assert data.qacc == pytest.approx((data.qvel - v) / data.timestep, abs=1e-9)


def test_snapshots_need_a_step(ball):
    data = signorini.Data(ball)
    assert len(data.contact) == 0 and data.contact.force_world.shape == (0, 3) and data.contact.frame.shape == (0, 3, 3)
    for get in (data.problem, data.solution):
        with pytest.raises(RuntimeError, match="signorini.forward first"):
            get()
    signorini.forward(ball, data)
    contact = data.contact
    data.reset()
    assert len(contact) == 1 and len(data.contact) == 0


def test_inverse_dynamics_of_a_pendulum(pendulum):
    data = signorini.Data(pendulum)
    data.qpos[0], data.qvel[0] = 0.7, 2.0
    inertia, torque = 2 * 0.25, 2 * 9.81 * 0.5 * np.sin(0.7)
    assert signorini.inverse(pendulum, data, [3.0]) == pytest.approx([3 * inertia + torque], rel=1e-7)
    assert signorini.bias_force(pendulum, data) == pytest.approx([torque], rel=1e-9)
    assert signorini.mass_matrix(pendulum, data) == pytest.approx(np.array([[inertia]]), rel=1e-7)
    signorini.step(pendulum, data)
    data.qpos[0], data.qvel[0] = 0.7, 2.0
    assert signorini.inverse(pendulum, data) == pytest.approx([0], abs=1e-9)


def test_jacobians_are_slopes_of_the_motion(cards):
    data, rng = signorini.Data(cards), np.random.default_rng(1)
    data.qvel = rng.normal(size=cards.nv)
    signorini.kinematics(cards, data)
    point = data.xpos[3] + 0.1
    linear, angular = signorini.jacobian(cards, data, 3, point)
    omega = data.angular_velocity[3]
    assert angular @ data.qvel == pytest.approx(omega)
    assert linear @ data.qvel == pytest.approx(data.linear_velocity[3] + np.cross(omega, [0.1] * 3))
    at_origin, _ = signorini.jacobian(cards, data, 3)
    assert at_origin @ data.qvel == pytest.approx(data.linear_velocity[3])


def test_integrate_and_difference_are_inverse(cards):
    rng = np.random.default_rng(2)
    v = rng.normal(size=cards.nv)
    moved = signorini.integrate(cards, cards.qpos0, v, 0.5)
    assert signorini.difference(cards, moved, cards.qpos0) == pytest.approx(0.5 * v)
    assert np.linalg.norm(moved.reshape(-1, 7)[:, 3:], axis=1) == pytest.approx(np.ones(cards.njnt))


def test_energy_of_a_fall(ball):
    data = signorini.Data(ball)
    data.qvel[2] = 2.0
    assert data.energy == pytest.approx((2.0, 0.981))


@pytest.mark.parametrize("is_struck", [False, True])
def test_what_a_pair_finds_does_not_depend_on_what_is_struck_elsewhere(is_struck):
    # A box falls past the corner of another one, 1.2 mm beside it; far away a ball strikes one that rests and outruns its reach.
    model = signorini.Model.from_string(
        "<mujoco><option timestep='0.004' gravity='0 0 0'/><worldbody><geom type='box' size='.1 .1 .1'/>"
        "<body name='box' pos='0.2012 0 0.2007'><freejoint/><geom type='box' size='.1 .1 .1'/></body>"
        "<body name='left' pos='5 0 0'><freejoint/><geom size='.1'/></body>"
        "<body name='right' pos='5.2005 0 0'><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    data = signorini.Data(model)
    data.qvel[2] = -2.8
    data.qvel[6] = 1.0 if is_struck else 0.0
    signorini.step(model, data)
    assert (data.qvel[12] > 0.4) == is_struck
    assert data.qvel[:6] == pytest.approx([0, 0, -2.8, 0, 0, 0], abs=1e-12)
