"""Many simulations at once."""

import copy
import multiprocessing
import pickle

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


def test_steps_of_some(quadruped):
    batch, together = signorini.Batch(quadruped, 3), signorini.Batch(quadruped, 3)
    batch.step(10)
    together.step(20)
    before = batch.qpos.copy()
    batch.step(10, ids=[0, 2])
    assert np.array_equal(batch.qpos[1], before[1]) and np.array_equal(batch.qpos[[0, 2]], together.qpos[[0, 2]])
    batch.step(10, ids=[1])
    assert np.array_equal(batch.qpos, together.qpos) and np.array_equal(batch.time, together.time)
    with pytest.raises(IndexError, match="simulation 7: the batch has 3"):
        batch.step(1, ids=[0, 7])


def test_a_rollout_records_what_is_asked_for():
    """Each record is what a simulation alone shows after that step."""
    model = mjcf("<geom type='plane'/><body pos='0 0 0.16' euler='5 10 0'><freejoint/><geom type='box' size='0.2 0.1 0.1' mass='2'/>"
                 "<site name='s' size='0.5'/></body>",
                 rest="<sensor><touch site='s'/><accelerometer site='s'/></sensor>")
    names = ("residual", "contact_wrench", "sensordata", "qvel")
    batch = signorini.Batch(model, 2, nthread=2)
    residual, wrench, sensors, qvel = batch.rollout(nstep=200, record=names)
    assert residual.shape == (2, 200) and wrench.shape == (2, 200, 2, 6) and sensors.shape == (2, 200, 4)
    data = signorini.Data(model)
    for k in range(200):
        signorini.step(model, data)
        assert residual[1, k] == data.certificate.worst and np.array_equal(qvel[1, k], data.qvel)
        assert np.array_equal(sensors[1, k], data.sensordata)
        on_box = np.where(data.contact.body2 == 1, 1.0, -1.0)[:, None] * data.contact.force_world
        assert np.allclose(wrench[1, k, 1, 3:], on_box.sum(axis=0), rtol=1e-12, atol=1e-9)
        assert np.allclose(wrench[1, k, 0, 3:], -wrench[1, k, 1, 3:])
    assert wrench[:, :, 1, 5].max() > 19.0
    for name, last in zip(names, (residual, wrench, sensors, qvel)):
        assert np.array_equal(getattr(batch, name), last[:, -1])
    batch.reset([0])
    assert not batch.contact_wrench[0].any() and not batch.sensordata[0].any() and batch.ncon.tolist()[0] == 0
    assert batch.contact_wrench[1].any() and batch.residual[0] == 0.0
    with pytest.raises(signorini.ProblemError, match="record = 'force'.*'contact_wrench'"):
        batch.rollout(nstep=1, record=["force"])


def test_simulations_with_parameters_of_their_own():
    """A sliding box slows down by μ g Δt in every step, whatever its mass, until gravity or friction is another."""
    model = mjcf("<geom type='plane' friction='0.3'/><body pos='0 0 0.1'><freejoint/>"
                 "<geom type='box' size='0.1 0.1 0.1' mass='2' friction='0.3'/></body>")
    batch = signorini.Batch(model, 4)
    batch.vary(1, friction=0.5)
    batch.vary(2, mass=4.0)
    batch.vary(3, gravity=(0.0, 0.0, -1.62))
    for _ in range(2):
        batch.qvel[:, 0] = 2.0
        batch.step(100)
        slowed = 2.0 - 100 * 0.002 * np.array([0.3 * 9.81, 0.15 * 9.81, 0.3 * 9.81, 0.3 * 1.62])
        assert np.allclose(batch.qvel[:, 0], slowed, atol=1e-9)
        assert np.allclose(batch.contact_wrench[:, 1, 5], [2 * 9.81, 2 * 9.81, 8 * 9.81, 2 * 1.62], atol=1e-6)
        batch.reset()
    with pytest.raises(signorini.SettingError, match="mass"):
        batch.vary(0, mass=0.0)
    with pytest.raises(IndexError, match="simulation 4"):
        batch.vary(4)


def test_simulations_are_asked_for_by_index():
    model = signorini.Model.from_string("<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>")
    batch = signorini.Batch(model, 3)
    batch.step(2)
    batch.reset([-1])
    assert batch.time.tolist() == [0.004, 0.004, 0]
    batch.step(1, ids=np.array([-1, 0]))
    batch.vary(-1, mass=2.0)
    batch.change([-2], gravity=(0, 0, -1))
    assert batch.time.tolist() == [0.006, 0.004, 0.002] and batch.parameter("gravity")[:, 2].tolist() == [-9.81, -1, -9.81]
    # A mask of Python's truth values would be 0s and 1s: the first two simulations.
    for mask in ([False, False, True], np.array([False, False, True])):
        for ask in (lambda: batch.step(1, ids=mask), lambda: batch.reset(mask), lambda: batch.change(mask, gravity=(0, 0, 0))):
            with pytest.raises(TypeError, match=r"flatnonzero\(mask\)"):
                ask()
    time = batch.time.copy()
    for ids in ([0, 3], [0, -4]):
        for ask in (lambda: batch.step(1, ids=ids), lambda: batch.reset(ids), lambda: batch.change(ids, gravity=(0, 0, 0))):
            with pytest.raises(IndexError, match=f"simulation {ids[1]}: the batch has 3"):
                ask()
    assert np.array_equal(batch.time, time) and batch.parameter("gravity")[0, 2] == -9.81


def test_bodies_moved_from_outside_and_what_corrections_leave():
    text = """<mujoco><worldbody><body name="hand" mocap="true" pos="0 0 1"><geom size="0.1" contype="0" conaffinity="0"/></body>
      <body name="tool" pos="0 0 1.5"><freejoint/><geom size="0.1" mass="1" contype="0" conaffinity="0"/></body></worldbody>
      <equality><weld body1="hand" body2="tool"/></equality>
      <keyframe><key name="away" mpos="1 2 3" mquat="0 1 0 0" qpos="1 2 3.5 0 1 0 0"/></keyframe></mujoco>"""
    model = signorini.Model.from_string(text)
    key = model.keyframe("away")
    assert key.mocap_pos == ((1, 2, 3),) and key.mocap_quat == ((0, 1, 0, 0),)
    batch = signorini.Batch(model, 3)
    assert batch.mocap_pos.shape == (3, 1, 3) and batch.mocap_quat[:, 0].tolist() == [[1, 0, 0, 0]] * 3
    assert batch.theta.tolist() == [1, 1, 1] and batch.limited_steps.tolist() == [0, 0, 0]
    data = signorini.Data(model)
    for k in range(20):
        batch.mocap_pos[1, 0] = data.mocap_pos[0] = [1e-4 * k, 0, 1]
        batch.step()
        signorini.step(model, data)
    assert np.array_equal(batch.qpos[1], data.qpos) and data.qpos[0] == pytest.approx(1e-4 * 19, abs=1e-9)
    assert batch.qpos[0, :3] == pytest.approx([0, 0, 1.5]) and batch.limited_steps[1] == data.limited_steps
    assert batch.correction_energy[0] == pytest.approx(0, abs=1e-12)
    batch.reset([2], "away")
    assert batch.mocap_pos[:, 0].tolist() == [[0, 0, 1], [1e-4 * 19, 0, 1], [1, 2, 3]]
    assert batch.mocap_quat[2, 0].tolist() == [0, 1, 0, 0]
    batch.reset()
    assert batch.mocap_pos[:, 0].tolist() == [[0, 0, 1]] * 3


def test_derivatives_of_a_batch_are_those_of_each_alone(quadruped):
    batch = signorini.Batch(quadruped, 4)
    rng = np.random.default_rng(5)
    batch.reset(keyframe=0)
    batch.qvel[:] = 0.01 * rng.normal(size=batch.qvel.shape)
    start = batch.qpos.copy(), batch.qvel.copy()
    parameters = ["timestep", ("gravity", 2)]
    found = batch.step_with_derivatives(parameters)
    assert len(found) == 4
    for i, slopes in enumerate(found):
        data = signorini.Data(quadruped)
        data.qpos[:], data.qvel[:], data.ctrl[:] = start[0][i], start[1][i], batch.ctrl[i]
        signorini.step(quadruped, data)
        alone = signorini.derivatives(quadruped, data, parameters)
        assert slopes.validity == alone.validity
        assert np.array_equal(batch.qpos[i], data.qpos)
        if alone.validity != "refused":
            assert np.array_equal(slopes.A, alone.A) and np.array_equal(slopes.B, alone.B) and np.array_equal(slopes.P, alone.P)
    assert any(slopes.validity != "refused" for slopes in found)


def test_a_simulation_that_stops_has_no_derivative(quadruped):
    batch = signorini.Batch(quadruped, 2)
    batch.qpos[1, 0] = np.nan
    good, bad = batch.step_with_derivatives()
    assert good.validity != "refused" or good.reason
    assert bad.validity == "refused" and "not made" in bad.reason


def went_on(batch):
    """Where a batch comes to; at the top of the module, for other processes."""
    batch.step(20)
    return batch.qpos.copy(), batch.qvel.copy(), batch.time.copy()


@pytest.mark.parametrize("way", ["copy", "deepcopy", "pickle", "process"])
def test_a_batch_goes_on_elsewhere_with_the_same_bits(quadruped, way):
    batch = signorini.Batch(quadruped, 3, signorini.Settings(timestep=0.004), nthread=2)
    batch.vary(1, friction=0.5, mass=1.2, gravity=(0.1, 0.0, -9.0))
    batch.change([2], geom_friction=0.3)
    batch.qvel[:, 0] = [0.0, 0.1, 0.2]
    batch.step(25)
    batch.ctrl[:] = 0.1
    if way == "process":
        saved = pickle.dumps(batch)
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            found = pool.apply(went_on, (batch,))
        batch = pickle.loads(saved)
    else:
        copies = {"copy": copy.copy, "deepcopy": copy.deepcopy, "pickle": lambda batch: pickle.loads(pickle.dumps(batch))}
        other = copies[way](batch)
        assert other is not batch and type(other) is type(batch)
        assert other.nthread == 2 and other.settings == batch.settings and other.model == batch.model
        assert np.array_equal(other.ctrl, batch.ctrl) and np.array_equal(other.qpos, batch.qpos)
        for name in ("body_mass", "geom_friction", "gravity"):
            assert np.array_equal(other.parameter(name), batch.parameter(name))
        found = went_on(other)
    for own, others in zip(went_on(batch), found):
        assert np.array_equal(own, others)


def test_a_copy_of_a_batch_keeps_the_bodies_that_are_moved_from_outside():
    model = mjcf("<body name='hand' mocap='true' pos='0 0 1'/><body pos='0 0 2'><freejoint/><geom size='0.1'/></body>")
    batch = signorini.Batch(model, 2)
    batch.mocap_pos[1, 0] = [1.0, 2.0, 3.0]
    other = pickle.loads(pickle.dumps(batch))
    assert np.array_equal(other.mocap_pos, batch.mocap_pos) and np.array_equal(other.mocap_quat, batch.mocap_quat)
    with pytest.raises(ValueError, match="2 simulations were saved, the batch has 1"):
        signorini.Batch(model, 1)._restore(batch._save())
    with pytest.raises(signorini.SignoriniError, match="damaged"):
        other._restore([(data[:20] + bytes([data[20] ^ 1]) + data[21:], rest) for data, rest in batch._save()])


def test_a_rollout_records_one_quantity_by_its_name():
    model = signorini.Model.from_string(
        "<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>"
    )
    one, listed = signorini.Batch(model, 2), signorini.Batch(model, 2)
    (alone,), (among,) = one.rollout(nstep=3, record="qvel"), listed.rollout(nstep=3, record=["qvel"])
    assert alone.shape == (2, 3, 6)
    np.testing.assert_array_equal(alone, among)
