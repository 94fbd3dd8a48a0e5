"""States: live arrays, stepping, snapshots, threads."""

import copy
import gc
import pathlib
import pickle
import threading
import time

import numpy as np
import pytest

import signorini
from conftest import mjcf

G = 9.81


def test_free_fall_is_the_symplectic_euler_sum():
    model = mjcf("<body pos='0 0 5'><freejoint/><geom size='0.1'/></body>")
    data = signorini.Data(model)
    signorini.step(model, data, nstep=100)
    h, n = 0.002, 100
    assert data.qpos[2] == pytest.approx(5 - G * h * h * n * (n + 1) / 2, abs=1e-12)
    assert data.qvel[2] == pytest.approx(-G * h * n, abs=1e-12)
    assert data.qacc[2] == pytest.approx(-G) and data.time == pytest.approx(n * h) and data.steps == n
    assert data.linear_velocity[1, 2] == data.qvel[2] and data.xpos[1, 2] == data.qpos[2]


def test_views_are_live_and_never_copies(ball):
    data = signorini.Data(ball)
    arrays = {name: getattr(data, name) for name in ("qpos", "qvel", "ctrl", "xpos", "xquat", "xmat", "qacc")}
    addresses = {name: a.__array_interface__["data"][0] for name, a in arrays.items()}
    slice_of_qpos = data.qpos[:3]
    data.qvel[0] = 1.0
    signorini.step(ball, data, nstep=10)
    for name, array in arrays.items():
        assert getattr(data, name) is array and array.__array_interface__["data"][0] == addresses[name]
        assert not array.flags.owndata
    assert slice_of_qpos[0] == data.qpos[0] > 0.01 and np.shares_memory(slice_of_qpos, data.qpos)
    assert np.array_equal(data.body("ball").xpos, data.xpos[1])


def test_what_is_written_to_a_view_is_the_state(ball):
    data = signorini.Data(ball)
    data.qpos[:3] = 1, 2, 3
    data.qvel = np.arange(6)
    assert data.xpos[1, 2] == 0.1
    signorini.kinematics(ball, data)
    assert data.body("ball").xpos.tolist() == [1, 2, 3]
    data.joint("free").qpos[2] = 4
    signorini.step(ball, data)
    assert data.qpos[0] == 1.0 and data.qpos[1] == pytest.approx(2.002) and data.qpos[2] > 3.9
    with pytest.raises(ValueError, match="broadcast"):
        data.qvel = np.zeros(5)


def test_views_outlive_their_data(ball):
    data = signorini.Data(ball)
    qpos = data.qpos
    signorini.step(ball, data, nstep=5)
    before = qpos.copy()
    del data
    gc.collect()
    assert np.array_equal(qpos, before)


def test_a_view_of_another_shape_harms_nobody(ball):
    data = signorini.Data(ball)
    with pytest.raises((ValueError, AttributeError)):
        data.qpos.resize((3,), refcheck=False)
    data.qpos.setflags(write=False)
    signorini.step(ball, data)
    assert data.qpos.shape == (7,)


def resident_bytes():
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return 4096 * pages


@pytest.mark.skipif(not pathlib.Path("/proc/self/statm").exists(), reason="reads /proc")
def test_memory_does_not_grow_over_a_million_steps(ball):
    data = signorini.Data(ball)

    def run():
        for _ in range(100_000):
            signorini.step(ball, data)
            data.qpos[0], data.xpos, data.time
        signorini.step(ball, data, nstep=400_000)

    run()
    gc.collect()
    before = resident_bytes()
    run()
    gc.collect()
    assert data.steps == 1_000_000
    assert resident_bytes() - before < 2_000_000


def test_control_and_applied_forces_act(pendulum):
    data = signorini.Data(pendulum)
    data.actuator("motor").ctrl = 1.5
    data.joint("hinge").qfrc_applied = 0.5
    signorini.step(pendulum, data)
    assert data.qvel[0] == pytest.approx(0.002 * 2.0 / (2 * 0.5**2), rel=1e-6)


def test_reset_and_keyframes(pendulum):
    data = signorini.Data(pendulum)
    signorini.step(pendulum, data, nstep=3)
    data.reset(keyframe="level")
    assert (data.time, data.qpos[0], data.qvel[0], data.ctrl[0]) == (7.0, np.pi / 2, 0.25, 3.0)
    assert data.xipos[1, 0] == pytest.approx(-0.5) and len(data.contact) == 0
    data.reset(0)
    assert data.time == 7.0
    data.reset()
    assert (data.time, data.qpos[0], data.qvel[0], data.ctrl[0]) == (0.0, 0.0, 0.0, 0.0)
    with pytest.raises(KeyError, match="no keyframe 'levl'; valid names: 'level'"):
        data.reset("levl")


@pytest.mark.parametrize("restore", ["state", "copy", "pickle"])
def test_a_run_goes_on_with_the_same_bits(cards, restore):
    data = signorini.Data(cards)
    data.qvel[6:12] = 0.3  # a kick, so that contacts open, slide and close
    signorini.step(cards, data, nstep=40)
    if restore == "state":
        other = signorini.Data(cards)
        other.set_state(data.get_state())
    else:
        other = copy.copy(data) if restore == "copy" else pickle.loads(pickle.dumps(data))
    assert other.settings == data.settings
    for d in (data, other):
        signorini.step(d.model, d, nstep=40)
    assert np.array_equal(data.qpos, other.qpos) and np.array_equal(data.get_state(), other.get_state())
    cold = signorini.Data(cards)
    plain = data.get_state(warm_start=False)
    cold.set_state(plain)
    assert len(plain) == 1 + cards.nq + 2 * cards.nv + cards.nu + 6 * cards.nbody and len(data.get_state()) > len(plain)
    assert np.array_equal(cold.get_state(warm_start=False), plain)


def test_a_state_of_another_model_is_refused(ball, pendulum):
    data, state = signorini.Data(ball), signorini.Data(pendulum).get_state()
    with pytest.raises(signorini.StateError, match="at least 32"):
        data.set_state(state)
    damaged = data.get_state()
    damaged[-1] = 0.5
    with pytest.raises(signorini.StateError, match="not a warm start: pass what get_state gave"):
        data.set_state(damaged)
    with pytest.raises(ValueError, match="another model"):
        signorini.step(pendulum, data)


def test_a_state_that_is_not_finite_is_refused_by_name(pendulum):
    data = signorini.Data(pendulum)
    data.qvel[0] = np.nan
    with pytest.raises(signorini.StateError, match="hinge"):
        signorini.step(pendulum, data)
    assert np.isnan(data.qvel[0]) and data.steps == 0


def test_settings(ball):
    settings = signorini.Settings(timestep=0.01, directions=4, method="lemke")
    data = signorini.Data(ball, settings)
    signorini.step(ball, data, nstep=2)
    assert data.time == 0.02 and len(data.problem().D) == 4 * data.ncon and data.settings == settings
    for wrong in ({"directions": 3}, {"directions": 5}, {"timestep": -1.0}, {"tolerance": 2.0}, {"infeasible": "hope"}, {"stabilization": 0.0}):
        with pytest.raises(signorini.SettingError):
            signorini.Data(ball, signorini.Settings(**wrong))
    with pytest.raises(signorini.SettingError, match="lemke"):
        signorini.Data(ball, signorini.Settings(method="newton"))


def test_a_missed_tolerance_is_announced(cards):
    data = signorini.Data(cards, signorini.Settings(tolerance=1e-30))
    with pytest.warns(signorini.ToleranceWarning, match="3 steps missed"):
        signorini.step(cards, data, nstep=3)
    assert data.missed_steps == 3 and data.report.missed_tolerance


def squeezed():
    """A box of 200 mm between walls that are 180 mm apart."""
    return mjcf("<geom name='left' type='plane' pos='-0.09 0 0' zaxis='1 0 0'/>"
                "<geom name='right' type='plane' pos='0.09 0 0' zaxis='-1 0 0'/>"
                "<body><freejoint/><geom name='box' type='box' size='.1 .1 .1'/></body>", option="gravity='0 0 0'")


def test_a_contradiction_stops_before_the_step_and_names_the_geoms():
    model = squeezed()
    data = signorini.Data(model, signorini.Settings(infeasible="stop"))
    with pytest.raises(signorini.SolveError, match="'box' on 'left'.*'box' on 'right'") as error:
        signorini.step(model, data, nstep=5)
    assert error.value.status in ("unresolved", "infeasible") and error.value.contacts and error.value.time == 0.0
    assert data.steps == 0 and data.report.blamed == error.value.contacts
    going_on = signorini.Data(model, signorini.Settings(infeasible="clip_gaps"))
    with pytest.warns(signorini.OverlapWarning, match="'left' and 'box'"):
        signorini.step(model, going_on)
    assert going_on.report.clipped_gaps and going_on.clipped_steps == 1


def test_a_run_goes_on_with_what_the_laws_permit():
    model = squeezed()
    data = signorini.Data(model)
    with pytest.warns(signorini.OverlapWarning, match="'left' and 'box' by 10.000 mm"):
        signorini.step(model, data, nstep=5)
    assert data.limited_steps == 5 and data.missed_steps == 0 and data.report.theta == 0.0
    kind, _, size = data.report.kept[0]
    assert kind == "contact" and size > 0.0 and data.correction_energy == 0.0


def test_the_gil_is_released(cards):
    data = signorini.Data(cards)
    start = time.perf_counter()
    signorini.step(cards, data, nstep=50)
    steps = int(50 * 0.6 / (time.perf_counter() - start))
    thread = threading.Thread(target=signorini.step, args=(cards, data, steps))
    start = last = time.perf_counter()
    longest = 0.0
    thread.start()
    refused = False
    while thread.is_alive():
        now = time.perf_counter()
        longest, last = max(longest, now - last), now
        try:
            data.time
        except RuntimeError as error:
            refused = "another thread" in str(error)
    thread.join()
    assert longest < 0.5 * (time.perf_counter() - start) and refused


def test_reprs_say_something(ball):
    data = signorini.Data(ball)
    signorini.step(ball, data)
    assert "1 of 0.002 s" in repr(data) and "<table>" in data._repr_html_()
    for part in (data.body("ball"), data.joint("free"), data.contact, data.certificate, data.report, data.limit):
        assert len(repr(part)) > 20


def test_bodies_moved_from_outside():
    text = """<mujoco><worldbody><body name="hand" mocap="true" pos="0 0 1"><geom size="0.1"/></body>
      <body name="tool" pos="0 0 1.5"><freejoint/><geom size="0.1" mass="1" contype="0" conaffinity="0"/></body></worldbody>
      <equality><weld body1="hand" body2="tool"/></equality>
      <keyframe><key name="away" mpos="1 2 3" mquat="1 0 0 0" qpos="1 2 3.5 1 0 0 0"/></keyframe></mujoco>"""
    model = signorini.Model.from_string(text)
    data = signorini.Data(model)
    assert model.nmocap == 1 and data.mocap_pos.shape == (1, 3) and data.mocap_quat.tolist() == [[1, 0, 0, 0]]
    for k in range(20):
        data.mocap_pos[0] = [1e-4 * k, 0, 1]
        signorini.step(model, data)
    assert data.qpos[:3] == pytest.approx([1e-4 * 19, 0, 1.5], abs=1e-9)
    stored = data.get_state()
    data.reset("away")
    assert data.mocap_pos.tolist() == [[1, 2, 3]] and data.xpos[1] == pytest.approx([1, 2, 3])
    data.set_state(stored)
    assert data.mocap_pos[0] == pytest.approx([1e-4 * 19, 0, 1])
    data.reset()
    assert data.mocap_pos.tolist() == [[0, 0, 1]]
