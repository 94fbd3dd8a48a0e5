"""Derivatives of steps."""

import numpy as np
import pytest

import signorini

BALL = """<mujoco><option timestep='0.01'/><worldbody><geom type='plane' friction='0.4'/>
  <body name='ball' pos='0 0 {height}'><freejoint/><geom size='0.1' mass='2'/></body></worldbody></mujoco>"""

CART = """<mujoco><option timestep='0.01'/><worldbody><body name='cart'>
  <joint name='slide' type='slide' axis='1 0 0' damping='0.3'/><geom type='box' size='0.1 0.1 0.1' mass='1' contype='0'/>
  <body name='pole'><joint name='hinge' axis='0 1 0' range='-90 90'/><geom type='capsule' fromto='0 0 0 0 0 0.5' size='0.02' contype='0'/>
  </body></body></worldbody><actuator><motor joint='slide' gear='3'/></actuator></mujoco>"""


def differences(model, start, argument, h=1e-5):
    """Central differences of a step by one of its arguments, (2 nv, n)."""

    def end(k, sign):
        data = signorini.Data(model)
        data.set_state(start)
        change = np.zeros(model.nv if argument != "ctrl" else model.nu)
        change[k] = sign * h
        if argument == "qpos":
            data.qpos[:] = signorini.integrate(model, data.qpos, change)
        else:
            getattr(data, argument)[:] += change
        signorini.step(model, data)
        return data.qpos.copy(), data.qvel.copy()

    columns = []
    for k in range(model.nv if argument != "ctrl" else model.nu):
        (q1, v1), (q0, v0) = end(k, 1), end(k, -1)
        columns.append(np.concatenate([signorini.difference(model, q1, q0), v1 - v0]) / (2 * h))
    return np.array(columns).T


def test_a_sliding_ball_and_its_differences():
    model = signorini.Model.from_string(BALL.format(height=0.1))
    data = signorini.Data(model)
    data.qvel[:] = [1.0, 0.2, 0.0, 0.3, -0.2, 0.5]
    start = data.get_state(warm_start=False)
    signorini.step(model, data)
    found = signorini.derivatives(model, data)
    assert found.validity == "exact" and found.reason is None and found.deciding == []
    assert min(margin.value for margin in found.margins) > 0
    expected = np.hstack([differences(model, start, "qpos"), differences(model, start, "qvel")])
    assert np.allclose(found.A, expected, atol=1e-7)
    assert np.allclose(found.B_force, differences(model, start, "qfrc_applied"), atol=1e-7)


def test_controls_and_products():
    model = signorini.Model.from_string(CART)
    data = signorini.Data(model)
    data.qpos[1], data.qvel[:], data.ctrl[0] = 0.4, [0.5, -1.0], 2.0
    start = data.get_state(warm_start=False)
    signorini.step(model, data)
    data.ctrl[0] = -7.0  # What is written after the step is not of the step.
    found = signorini.derivatives(model, data)
    assert found.validity == "exact"
    assert np.allclose(found.B, differences(model, start, "ctrl"), atol=1e-8)
    rng = np.random.default_rng(0)
    dq, dv, du, df, gq, gv = (rng.normal(size=n) for n in (2, 2, 1, 2, 2, 2))
    end = np.concatenate(found.jvp(dq, dv, du, df))
    assert np.allclose(end, found.A @ np.concatenate([dq, dv]) + found.B @ du + found.B_force @ df, atol=1e-12)
    gradient = found.vjp(gq, gv)
    sums = sum(g @ d for g, d in zip(gradient, (dq, dv, du, df)))
    assert sums == pytest.approx(end @ np.concatenate([gq, gv]), rel=1e-12)


def test_a_tie_names_the_contact():
    model = signorini.Model.from_string(BALL.format(height=0.1))
    data = signorini.Data(model)
    data.qvel[2] = 9.81 * 0.01  # Gravity takes back in the step what would lift the ball: it touches without an impulse.
    signorini.step(model, data)
    found = signorini.derivatives(model, data)
    assert found.validity == "one_sided"
    assert [(margin.source, margin.index) for margin in found.deciding] == [("contact", 0)]


def test_a_tie_has_a_derivative_along_each_change():
    model = signorini.Model.from_string(BALL.format(height=0.1))
    data = signorini.Data(model)
    data.qvel[2] = 9.81 * 0.01
    signorini.step(model, data)
    found = signorini.derivatives(model, data)
    up, down = (found.directional(dv=[0, 0, sign, 0, 0, 0])[1][2] for sign in (1.0, -1.0))
    assert (up, down) == pytest.approx((1.0, 0.0), abs=1e-12)


def test_what_has_no_derivative_says_why():
    model = signorini.Model.from_string(BALL.format(height=0.05))
    data = signorini.Data(model)
    with pytest.raises(RuntimeError, match="no step"):
        signorini.derivatives(model, data)
    with pytest.warns(signorini.OverlapWarning):
        signorini.step(model, data)
    found = signorini.derivatives(model, data)
    assert found.validity == "refused" and "bounded speed" in found.reason
    with pytest.raises(ValueError, match="bounded speed"):
        found.A


ROD = """<mujoco><option timestep='0.001'/><worldbody><geom type='plane' friction='3'/>
  <body><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 0 1'/><joint type='hinge' axis='0 1 0'/>
  <geom type='capsule' size='0.001 0.5' mass='1' friction='3'/></body></worldbody></mujoco>"""


def test_a_second_look_finds_that_a_sliding_rod_may_go_on_or_be_caught():
    model = signorini.Model.from_string(ROD)
    data = signorini.Data(model)
    angle = 0.62

    def slide(turn):
        data.qpos[:] = [0.0, 0.5 * np.cos(angle) + 0.001, angle]
        data.qvel[:] = [-10.0, 0.5 * np.sin(angle) * turn, turn]
        signorini.step(model, data)

    # One that comes down fast is caught, and the next one starts from there.
    slide(-1.0)
    slide(1.0)
    assert data.qvel[0] > -9.0
    assert signorini.derivatives(model, data).validity == "exact"
    found = signorini.derivatives(model, data, twice=True)
    assert found.validity == "refused" and "not unique" in found.reason


def test_a_joint_at_its_limit_that_nothing_moves_is_at_a_tie():
    model = signorini.Model.from_string(
        "<mujoco><compiler angle='radian'/><worldbody><body><joint axis='0 0 1' frictionloss='0.1' limited='true' range='-0.6 0.6'/>"
        "<geom size='0.1' mass='1'/></body></worldbody></mujoco>"
    )
    data = signorini.Data(model)
    data.qpos[0] = -0.6 + 3e-16
    signorini.step(model, data)
    found = signorini.derivatives(model, data)
    assert [(margin.source, margin.index, margin.kind) for margin in found.deciding] == [("joint limit", 0, "gap")]


def test_a_tendon_at_its_length_at_rest_is_a_spring():
    """Where it has the one length at which it pulls nothing, as at the reference, it is stiff like the spring of a joint all the same."""
    world = ("<mujoco><option timestep='0.01'/><worldbody><body name='cart'><joint name='rail' type='slide' axis='1 0 0' {spring}/>"
             "<geom size='0.1' mass='2'/></body></worldbody>{tendon}</mujoco>")
    tendon = "<tendon><fixed stiffness='500' {rest}><joint joint='rail' coef='1'/></fixed></tendon>"
    ends = []
    for spring, rest in (("stiffness='500'", None), ("", ""), ("", "springlength='-1'"), ("", "springlength='0'"), ("", "springlength='0 0.1'")):
        model = signorini.Model.from_string(world.format(spring=spring, tendon="" if rest is None else tendon.format(rest=rest)))
        data = signorini.Data(model)
        data.qvel[0], data.qfrc_applied[0] = 1.0, 4.0
        signorini.step(model, data)
        slopes = signorini.derivatives(model, data)
        ends.append((data.qvel[0], slopes.A, slopes.validity))
    for velocity, slopes, validity in ends[1:4]:
        assert velocity == pytest.approx(ends[0][0], rel=1e-14) and validity == "exact"
        assert np.allclose(slopes, ends[0][1], rtol=1e-12, atol=1e-12)
    # m (v⁺ − v) = Δt (4 N − k q − ½ k Δt (v⁺ − v)).
    share = 500 * 0.01**2 / (2 * 2.0)
    assert ends[0][0] == pytest.approx(1 + 0.01 * 4 / 2.0 / (1 + share), rel=1e-12)
    assert ends[0][1][1, 0] == pytest.approx(-500 * 0.01 / 2.0 / (1 + share), rel=1e-12)
    # At the end of a range in which it is slack the two sides differ.
    assert ends[4][2] == "one_sided"
