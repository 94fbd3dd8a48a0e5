"""Many simulations at once."""

import numpy as np
import pytest

import signorini
from conftest import SCENES, mjcf


@pytest.fixture
def quadruped():
    return signorini.Model.from_file(SCENES / "quadruped.xml")


@pytest.mark.parametrize("nthread", [1, 3])
def test_every_simulation_has_the_bits_that_it_has_alone(quadruped, nthread):
    batch = signorini.Batch(quadruped, 4, nthread=nthread)
    batch.qvel[:, 0] = [0.0, 0.1, 0.2, 0.3]
    batch.ctrl[:, 1] = [0.0, 0.1, 0.2, 0.3]
    qpos = batch.qpos
    batch.step(30)
    for i in range(len(batch)):
        data = signorini.Data(quadruped)
        data.qvel[0] = data.ctrl[1] = 0.1 * i if i < 3 else 0.3
        signorini.step(quadruped, data, nstep=30)
        assert np.array_equal(batch.qpos[i], data.qpos) and np.array_equal(batch.qvel[i], data.qvel)
        assert batch.time[i] == data.time and batch.residual[i] == data.certificate.worst
        assert batch.ncon[i] == data.report.contacts
    assert np.shares_memory(qpos, batch.qpos) and np.array_equal(qpos, batch.qpos)


def test_a_rollout_is_the_steps_with_its_controls(quadruped):
    rng = np.random.default_rng(5)
    ctrl = 0.2 * rng.normal(size=(2, 6, quadruped.nu))
    batch = signorini.Batch(quadruped, 2)
    qpos, qvel = batch.rollout(ctrl)
    assert qpos.shape == (2, 6, quadruped.nq) and qvel.shape == (2, 6, quadruped.nv)
    data = signorini.Data(quadruped)
    for k in range(6):
        data.ctrl = ctrl[1, k]
        signorini.step(quadruped, data)
        assert np.array_equal(qpos[1, k], data.qpos) and np.array_equal(qvel[1, k], data.qvel)
    again, _ = batch.rollout(nstep=2)
    assert again.shape[1] == 2 and np.array_equal(again[:, -1], batch.qpos)
    with pytest.raises(signorini.ProblemError, match="ctrl has shape"):
        batch.rollout(ctrl[:1])


def test_reset_of_some(pendulum):
    batch = signorini.Batch(pendulum, 3)
    batch.ctrl[:] = 1.0
    batch.step(5)
    before = batch.qpos.copy()
    batch.reset([1], keyframe="level")
    assert batch.qpos[1] == np.pi / 2 and batch.ctrl[:, 0].tolist() == [1.0, 3.0, 1.0] and batch.time[1] == 7.0
    assert np.array_equal(batch.qpos[[0, 2]], before[[0, 2]])
    batch.reset()
    assert not batch.qpos.any() and not batch.time.any() and not batch.ctrl.any()
    with pytest.raises(IndexError, match="simulation 3"):
        batch.reset([3])


def test_those_that_stop_are_named_and_the_others_go_on():
    model = mjcf("<geom type='plane'/><body pos='0 0 0.1'><freejoint name='free'/><geom size='0.1'/></body>")
    batch = signorini.Batch(model, 3)
    batch.qvel[1, 0] = np.nan
    with pytest.raises(signorini.BatchError, match="1 of 3 simulations stopped; simulation 1.*free") as error:
        batch.step(2)
    assert error.value.ids == [1] and len(error.value.reasons) == 1
    assert batch.time.tolist() == pytest.approx([0.004, 0.0, 0.004]) and "3 simulations" in repr(batch)
