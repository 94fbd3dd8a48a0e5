"""States that are brought to rest."""

import os
import signal
import threading

import numpy as np
import pytest

import signorini
from conftest import mjcf

G = 9.81
BOX = ("<geom type='plane' friction='0.5'/><body name='box' pos='0 0 0.6' quat='0.96 0.2 0.1 0.05'><freejoint/>"
       "<geom type='box' size='0.2 0.1 0.1' mass='4' friction='0.5'/></body>")


def test_a_box_falls_and_rests_exactly():
    model = mjcf(BOX)
    data = signorini.Data(model)
    data.time = 3.0
    qpos, qvel = data.qpos, data.qvel
    report = signorini.settle(model, data)
    assert report.steps > 10 and report.factorizations > 10
    assert report.at_rest.status == "solved" and report.at_rest.certificate.holds(1e-9) and report.at_rest.contacts == 4
    assert report.speed == 0
    assert repr(report).startswith(f"<signorini.SettleReport {report.steps} steps: at rest on 4 contacts")
    # A face of the box lies on the floor, which carries its weight.
    assert qpos[2] == pytest.approx(0.1, abs=1e-12) and np.all(qvel == 0)
    assert data.time == 3.0 and data.steps == 0 and data.body("box").xpos[2] == qpos[2]
    assert data.contact.force_world.sum(axis=0) == pytest.approx([0, 0, 4 * G], abs=1e-9 * 4 * G)
    rest = qpos.copy()
    signorini.step(model, data, nstep=100)
    assert np.all(data.qvel == 0) and np.array_equal(data.qpos, rest) and data.certificate.holds(1e-9)


def test_a_state_at_rest_stays(cards):
    data = signorini.Data(cards)
    start = data.qpos.copy()
    report = signorini.settle(cards, data)
    assert report.steps == 0 == report.factorizations and data.contact.force.size > 0
    assert data.qpos == pytest.approx(start, abs=1e-12)
    signorini.step(cards, data)
    assert np.all(data.qvel == 0)


def test_the_input_is_that_of_the_data(ball):
    """A ball with a force upwards rests with less load on the floor."""
    data = signorini.Data(ball)
    data.qpos[2] = 0.3
    data.qfrc_applied[2] = 4.0
    signorini.settle(ball, data, timestep=0.01, momentum=0.2)
    assert data.contact.force_world.sum(axis=0)[2] == pytest.approx(G - 4.0) and data.qfrc_applied[2] == 4.0


def test_what_slides_for_ever_is_not_settled(slope):
    data = signorini.Data(slope)
    with pytest.raises(signorini.SolveError, match="not at rest after 30 steps.*'box'") as caught:
        signorini.settle(slope, data, max_steps=30)
    assert caught.value.status == "not_settled"
    assert data.qpos[0] > 0.001 and data.qvel[0] > 0 and data.body("box").xpos[0] == data.qpos[0]
    signorini.step(slope, data)
    assert data.certificate.holds(1e-9)


@pytest.mark.parametrize("argument, message", [({"momentum": 1.0}, "settle.momentum"), ({"timestep": 0.0}, "settle.timestep")])
def test_arguments_are_checked(ball, argument, message):
    data = signorini.Data(ball)
    data.qvel[0] = 1.0
    signorini.step(ball, data)
    state, qacc = data.get_state(), data.qacc.copy()
    with pytest.raises(signorini.SettingError, match=message):
        signorini.settle(ball, data, **argument)
    assert np.array_equal(data.get_state(), state) and np.array_equal(data.qacc, qacc) and qacc[0] < 0


def test_the_circular_cone_is_refused(ball):
    with pytest.raises(signorini.ProblemError, match="friction_law and settle"):
        signorini.settle(ball, signorini.Data(ball, signorini.Settings(friction_law="circular")))


def test_a_signal_ends_it(slope):
    data = signorini.Data(slope)
    # Whoever runs the tests in the background may have the signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
            signorini.settle(slope, data, max_steps=10**6)
    finally:
        signal.signal(signal.SIGINT, before)
    assert data.qpos[0] > 0.001 and data.qvel[0] > 0 and data.steps == 0


def test_what_hangs_from_constraints_alone_rests():
    model = signorini.Model.from_string(
        "<mujoco><worldbody><body name='lamp' pos='0 0 1'><freejoint/><geom size='.1' mass='2'/></body></worldbody>"
        "<equality><weld body1='lamp'/></equality></mujoco>")
    data = signorini.Data(model)
    signorini.settle(model, data)
    assert not data.qvel.any() and data.qpos[2] == pytest.approx(1, abs=1e-9)
