"""Parameters from recorded motions."""

import numpy as np
import pytest

import signorini

XML = """<mujoco><worldbody><geom name='floor' type='plane' friction='{mu}'/><body name='box' pos='0 0 0.3'><freejoint/>
  <geom name='box' type='box' size='0.1 0.08 0.06' friction='{mu}'/></body></worldbody></mujoco>"""


def recordings(model, count, interval, substeps):
    rng = np.random.default_rng(3)
    out = []
    for _ in range(count):
        data = signorini.Data(model, signorini.Settings(timestep=interval / substeps))
        data.qvel[:] = rng.normal(size=6)
        q, v = [data.qpos.copy()], [data.qvel.copy()]
        for _ in range(25):
            signorini.step(model, data, nstep=substeps)
            q.append(data.qpos.copy())
            v.append(data.qvel.copy())
        out.append((np.array(q), np.array(v)))
    return out


def test_friction_is_found_with_progress_and_a_report():
    given = recordings(signorini.Model.from_string(XML.format(mu=0.3)), 4, 0.02, 4)
    told = []
    friction = signorini.Unknown([("geom_friction", ["box", "floor"])], bounds=(0.01, 1.0), name="friction")
    model = signorini.Model.from_string(XML.format(mu=0.5))
    found = signorini.identify(
        model, given, [friction], interval=0.02, substeps=4, window=8, tolerance=1e-10, progress=lambda *news: told.append(news)
    )
    assert found.values == pytest.approx([0.3], abs=1e-5) and found.determined == (True,)
    assert told and told[-1][1] < told[0][1]
    assert "friction" in found.report() and str(found) == found.report()
    assert found.model.geom("box").friction == pytest.approx(found.values[0])
    mapping = [{"qpos": q, "qvel": v} for q, v in given]
    stopped = signorini.identify(model, mapping, [friction], interval=0.02, substeps=4, progress=lambda *news: False)
    assert stopped.iterations == 1 and not stopped.converged


def test_faults_are_named():
    given = recordings(signorini.Model.from_string(XML.format(mu=0.3)), 1, 0.02, 1)
    model = signorini.Model.from_string(XML.format(mu=0.5))
    with pytest.raises(ValueError, match="no parameter 'friction'"):
        signorini.identify(model, given, ["friction"], interval=0.02)
    with pytest.raises(ValueError, match="outside its bounds"):
        signorini.identify(model, given, [signorini.Unknown(("body_mass", "box"), bounds=(0.0, 1e-3))], interval=0.02)
    with pytest.raises(ValueError, match="has the prior 1 ± 0"):
        signorini.identify(model, given, [signorini.Unknown(("body_mass", "box"), prior=(1, 0))], interval=0.02)
    with pytest.raises(ValueError, match="qvel"):
        signorini.identify(model, [(given[0][0], given[0][1][:-1])], [("body_mass", "box")], interval=0.02)


def test_recordings_count_the_same_and_several_starts_are_looked_at():
    given = recordings(signorini.Model.from_string(XML.format(mu=0.3)), 3, 0.02, 4)
    # The first recording is of another friction, and short.
    other = recordings(signorini.Model.from_string(XML.format(mu=0.6)), 1, 0.02, 4)
    short = [(other[0][0][:20], other[0][1][:20])]
    friction = signorini.Unknown([("geom_friction", ["box", "floor"])], bounds=(0.01, 1.0))
    model = signorini.Model.from_string(XML.format(mu=0.9))

    def found(**options):
        return signorini.identify(model, short + given, [friction], interval=0.02, substeps=4, window=8, tolerance=1e-8, **options).values[0]

    by_samples, by_recordings = found(), found(equal_recordings=True)
    assert 0.3 < by_samples < by_recordings < 0.6
    alone = signorini.identify(model, given, [friction], interval=0.02, substeps=4, window=8, tolerance=1e-10, starts=8)
    assert alone.values == pytest.approx([0.3], abs=1e-5)
    with pytest.raises(ValueError, match="bounds"):
        signorini.identify(model, given, [("geom_friction", "box")], interval=0.02, starts=3)


PENDULUM = """<mujoco><worldbody><body pos='0 0 1'><joint name='hinge' type='hinge' axis='0 1 0' damping='{damping}'/>
  <geom type='capsule' fromto='0 0 0 0 0 -0.4' size='0.03' mass='1'/></body></worldbody></mujoco>"""


def swings(rng, count, interval, substeps):
    """Recordings of pendulums whose dampers differ, seen with noise."""
    out = []
    for _ in range(count):
        model = signorini.Model.from_string(PENDULUM.format(damping=0.05 + rng.uniform(-0.03, 0.03)))
        data = signorini.Data(model, signorini.Settings(timestep=interval / substeps))
        data.qpos[:], data.qvel[:] = rng.normal(size=1), rng.normal(size=1)
        q, v = [data.qpos.copy()], [data.qvel.copy()]
        for _ in range(25):
            signorini.step(model, data, nstep=substeps)
            q.append(data.qpos.copy())
            v.append(data.qvel.copy())
        out.append((np.array(q) + 1e-3 * rng.normal(size=(26, 1)), np.array(v)))
    return out


@pytest.mark.parametrize("seed", range(1, 5))
def test_drawn_sets_spread_as_the_gradients_say(seed):
    given = swings(np.random.default_rng(seed), 12, 0.02, 4)
    damping = signorini.Unknown(("dof_damping", "hinge"), bounds=(0.0, 1.0))
    model = signorini.Model.from_string(PENDULUM.format(damping=0.05))
    asked = dict(interval=0.02, substeps=4, window=8, tolerance=1e-8)
    by_gradients = signorini.identify(model, given, [damping], **asked)
    by_draws = signorini.identify(model, given, [damping], draws=40, **asked)
    assert by_gradients.values == by_draws.values
    # Both errors come of twelve recordings, one of them of forty draws: each is known to some 15 %.
    assert 0.6 < by_draws.standard_errors[0] / by_gradients.standard_errors[0] < 1.6


def test_windows_begin_with_the_recorded_activations():
    """A cart behind a slow actuator: with activations of zero at every window it would be taken for a heavier one."""
    xml = ("<mujoco><worldbody><body name='cart'><joint name='rail' type='slide' axis='1 0 0'/><geom size='0.1' mass='2'/></body></worldbody>"
           "<actuator><general joint='rail' dyntype='filter' dynprm='0.2' gainprm='10'/></actuator></mujoco>")
    model = signorini.Model.from_string(xml)
    data = signorini.Data(model, signorini.Settings(timestep=0.01))
    data.ctrl[:] = 1.0
    q, v, act = [data.qpos.copy()], [data.qvel.copy()], [data.act.copy()]
    for _ in range(60):
        signorini.step(model, data)
        q.append(data.qpos.copy())
        v.append(data.qvel.copy())
        act.append(data.act.copy())
    recorded = {"qpos": np.array(q), "qvel": np.array(v), "ctrl": np.ones((60, 1)), "act": np.array(act)}
    mass = signorini.Unknown(("body_mass", "cart"), bounds=(0.5, 8.0), start=3.0)
    ask = lambda given, window: signorini.identify(model, [given], [mass], interval=0.01, window=window, tolerance=1e-10).values
    assert ask(recorded, 5) == pytest.approx([2.0], rel=1e-5)
    without = {name: recorded[name] for name in ("qpos", "qvel", "ctrl")}
    assert ask(without, None) == pytest.approx([2.0], rel=1e-5)
    with pytest.raises(ValueError, match="1 activations of actuators.* 'act'"):
        ask(without, 5)
    with pytest.raises(ValueError, match="act"):
        ask({**recorded, "act": np.zeros((60, 1))}, 5)
