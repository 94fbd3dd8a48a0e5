"""Every setting of the engine can be set, and does what it says."""

import dataclasses
import pickle

import numpy as np
import pytest

import signorini
from conftest import mjcf
from signorini import Settings, SolverSettings

BALL = "<geom type='plane' friction='0.5'/><body pos='0 0 0.1'><freejoint/><geom size='0.1' mass='1' friction='0.5'/></body>"
TABLE = ("<geom type='plane' friction='0.5'/><body pos='0 0 0.1'><freejoint/>"
         "<geom type='box' size='0.2 0.1 0.1' mass='4' friction='0.5'/></body>")


def slid_direction(settings):
    """How far the friction of a body that slides is from being opposite to the slip, rad."""
    model = mjcf(TABLE)
    data = signorini.Data(model, settings)
    angle = 0.3
    data.qvel[:2] = 2 * np.cos(angle), 2 * np.sin(angle)
    signorini.step(model, data)
    force = data.contact.force_world.sum(axis=0)
    assert np.linalg.norm(force[:2]) == pytest.approx(0.5 * 4 * 9.81, rel=0.1)
    return abs(np.arctan2(-force[1], -force[0]) - angle)


def test_friction_laws():
    assert slid_direction(Settings(directions=4)) > 0.1
    assert slid_direction(Settings(friction_law="circular")) < 1e-6
    assert 1e-13 < slid_direction(Settings(friction_law="refined", cone_tolerance=1e-4)) < 0.05
    with pytest.raises(signorini.SettingError, match="friction_law = 'round': must be 'polygon' or 'circular' or 'refined'"):
        signorini.Data(mjcf(BALL), Settings(friction_law="round"))
    with pytest.raises(signorini.SettingError, match="cone_tolerance|friction_law.tolerance"):
        signorini.Data(mjcf(BALL), Settings(friction_law="refined", cone_tolerance=2.0))
    with pytest.raises(signorini.SignoriniError, match="friction_law"):
        signorini.Data(mjcf(BALL), Settings(friction_law="circular", method="lemke"))


def test_impulses_of_least_norm_are_equal_on_four_legs():
    model = mjcf(TABLE)
    least = signorini.Data(model, Settings(impulses="least_norm"))
    signorini.step(model, least, nstep=20)
    assert least.contact.force[:, 0] == pytest.approx(4 * [9.81], rel=1e-9)
    with pytest.raises(signorini.SettingError, match="impulses"):
        signorini.Data(model, Settings(impulses="most_norm"))


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_restitution(law):
    text = BALL.replace("pos='0 0 0.1'", "pos='0 0 0.1005'")
    model = mjcf(text, option="gravity='0 0 0'", rest="<custom><numeric name='signorini:restitution' data='0.5'/></custom>")
    data = signorini.Data(model, Settings(restitution=law))
    data.qvel[2] = -1.0
    signorini.step(model, data)
    assert data.qvel[2] == pytest.approx(0.5)
    with pytest.raises(signorini.SettingError, match="restitution"):
        signorini.Data(model, Settings(restitution="perfect"))


def test_position_iterations_hold_a_loop_together():
    loop = mjcf("<body name='a' pos='0 0 0'><joint type='hinge' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 1 0 0' size='.02'"
                " mass='1' contype='0' conaffinity='0'/></body>"
                "<body name='b' pos='1 0 0'><freejoint/><geom size='.05' mass='1' contype='0' conaffinity='0'/></body>",
                rest="<equality><connect body1='a' body2='b' anchor='1 0 0'/></equality>")

    def drift(settings):
        data = signorini.Data(loop, settings)
        signorini.step(loop, data, nstep=200)
        tip = data.body("a").xpos + data.body("a").xmat @ [1, 0, 0]
        return np.linalg.norm(tip - data.body("b").xpos)

    assert drift(Settings(position_iterations=3)) < 1e-12 < 1e-8 < drift(Settings())


def test_assembly_tolerance_is_taken():
    with pytest.raises(signorini.SettingError, match="assembly_tolerance"):
        signorini.Data(mjcf(BALL), Settings(assembly_tolerance=-1.0))


def test_sleeping_leaves_islands_unsolved_with_the_same_motion():
    model = mjcf(TABLE)
    awake, asleep = signorini.Data(model), signorini.Data(model, Settings(sleeping=True))
    for data in (awake, asleep):
        signorini.step(model, data, nstep=100)
    assert asleep.qpos == pytest.approx(awake.qpos, abs=1e-12) and asleep.certificate.holds(1e-9)
    assert asleep.report.iterations <= awake.report.iterations


def test_bodies_that_stand_sleep_beside_what_moves():
    model = mjcf('''<geom type="plane" size="0 0 1"/>
        <body name="box" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
        <body name="pendulum" pos="2 0 2"><joint type="hinge" axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body>''')
    data = signorini.Data(model, Settings(sleeping=True))
    assert not data.body_asleep.any()
    signorini.step(model, data, nstep=10)
    assert dict(zip(model.body_names, data.body_asleep)) == {"world": False, "box": True, "pendulum": False}
    assert data.ncon == 4 and data.contact.impulse[:, 0].sum() == pytest.approx(model.body_mass[1] * 9.81 * model.timestep)
    data.qvel[0] = 0.1
    signorini.step(model, data)
    assert not data.body_asleep.any() and data.qpos[0] > 0


def test_settings_of_the_solver_are_taken_and_checked():
    model = mjcf(TABLE)
    data = signorini.Data(model, Settings(solver=SolverSettings(newton_iterations=0, threads=2)))
    signorini.step(model, data, nstep=5)
    assert data.certificate.holds(1e-9)
    for field in dataclasses.fields(SolverSettings):
        wrong = {"polish": 0.0, "proximal_weight": -1.0, "smallest_proximal_weight": 1.5,
                 "mode_tolerance": 0.0, "max_rounds": 0, "max_proximal_iterations": 0}.get(field.name)
        if wrong is not None:
            with pytest.raises(signorini.SettingError, match=field.name):
                signorini.Data(model, Settings(solver=SolverSettings(**{field.name: wrong})))


@pytest.mark.parametrize(
    "settings, error, told",
    [
        (Settings(timestep="fast"), TypeError, "^settings.timestep: must be real number, not str"),
        (Settings(directions=4.5), TypeError, "^settings.directions: .*float"),
        (Settings(directions=-4), signorini.SettingError, "^settings.directions: "),
        (Settings(solver=SolverSettings(polish=None)), TypeError, "^settings.solver.polish: "),
        (7, TypeError, "^settings: .*'int' object has no attribute 'timestep'"),
    ],
)
def test_settings_of_a_wrong_type_are_named(settings, error, told):
    with pytest.raises(error, match=told):
        signorini.Data(mjcf(TABLE), settings)


def test_settings_travel():
    settings = Settings(friction_law="refined", cone_tolerance=1e-5, solver=SolverSettings(max_rounds=1))
    assert pickle.loads(pickle.dumps(settings)) == settings and hash(settings) == hash(dataclasses.replace(settings))
    data = pickle.loads(pickle.dumps(signorini.Data(mjcf(TABLE), settings)))
    assert data.settings == settings
