"""Ctrl-C ends long work soon, and leaves what was computed until then."""

import os
import signal
import threading

import numpy as np
import pytest

import signorini

TURNING = """<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody>
  <body><joint name="hinge" axis="0 0 1"/><geom size="0.1" mass="1"/></body>
</worldbody></mujoco>"""
# More steps than anybody makes until the signal comes.
STEPS = 10**7


@pytest.fixture
def interrupted():
    """Calls something that a signal ends on its way."""
    # Whoever runs the tests in the background may have the signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def call(work):
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            timer.start()
            work()

    yield call
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("nthread", [0, 1, 2])
def test_steps_of_a_batch_end(interrupted, nthread):
    model = signorini.Model.from_string(TURNING)
    batch = signorini.Batch(model, 3, nthread=nthread)
    batch.qvel[:, 0] = [0.5, 1.0, 2.0]
    interrupted(lambda: batch.step(STEPS))
    # Each has turned as far as its time says, and one of them has made steps.
    assert 0.001 < batch.time.max() < 0.9e-3 * STEPS
    np.testing.assert_allclose(batch.qpos[:, 0], batch.qvel[:, 0] * batch.time, rtol=1e-9, atol=1e-12)
    time = batch.time.copy()
    assert (batch.residual[time > 0] < 1e-9).all() and (batch.residual[time == 0] == 0).all()
    batch.step(5)
    np.testing.assert_allclose(batch.time - time, 0.005, rtol=1e-6)


@pytest.mark.parametrize("nthread", [1, 2])
def test_a_rollout_ends(interrupted, nthread):
    model = signorini.Model.from_string(TURNING)
    batch = signorini.Batch(model, 2, nthread=nthread)
    batch.qvel[:, 0] = 1.0
    interrupted(lambda: batch.rollout(nstep=STEPS, record=["qpos"]))
    assert batch.time.max() < 0.9e-3 * STEPS
    np.testing.assert_allclose(batch.qpos[:, 0], batch.time, rtol=1e-9, atol=1e-12)


def test_steps_of_a_data_end(interrupted):
    model = signorini.Model.from_string(TURNING)
    data = signorini.Data(model)
    data.qvel[0] = 1.0
    interrupted(lambda: signorini.step(model, data, nstep=STEPS))
    assert 0 < data.steps < 0.9 * STEPS
    np.testing.assert_allclose(data.qpos[0], data.time, rtol=1e-9)
