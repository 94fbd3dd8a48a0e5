"""Contact impulses are what acted on the bodies."""

import numpy as np
import pytest

import signorini
from conftest import mjcf

PILE = """<mujoco model='pile'><option timestep='0.002'/><worldbody><geom name='floor' type='plane' friction='0.4'/>
  <body name='a' pos='0 0 0.1'><freejoint/><geom type='box' size='0.1 0.1 0.1' mass='1' friction='0.4'/></body>
  <body name='b' pos='0.05 0 0.3'><freejoint/><geom type='box' size='0.1 0.1 0.1' mass='2' friction='0.4'/></body>
</worldbody></mujoco>"""

def acted(data):
    """M (v⁺ − v^f) of the step, and the same from the contacts' impulses."""
    problem, contact = data.problem(), data.contact
    gained = problem.M @ (data.qvel - problem.v_free)
    ncon = len(contact)
    from_contacts = problem.Jn[:ncon].T @ contact.impulse[:, 0]
    from_contacts = from_contacts + problem.Jt[: 2 * ncon].T @ contact.impulse[:, 1:].ravel()
    return gained, from_contacts


def test_impulses_of_a_pile_are_its_change_of_momentum():
    model = signorini.Model.from_string(PILE)
    data = signorini.Data(model)
    data.qvel[0] = 1.0
    for _ in range(40):
        signorini.step(model, data)
        gained, from_contacts = acted(data)
        assert gained == pytest.approx(from_contacts, abs=1e-13 + 1e-10 * np.abs(gained).max())


@pytest.mark.parametrize("law", ["newton", "poisson"])
def test_both_phases_of_an_impact_count(law):
    model = mjcf("<geom type='plane' friction='0.4'/><body pos='0 0 0.101'><freejoint/>"
                 "<geom size='0.1' mass='1' friction='0.4'/></body>",
                 rest="<custom><numeric name='signorini:restitution' data='0.6'/></custom>")
    data = signorini.Data(model, signorini.Settings(restitution=law))
    data.qvel[:3] = 0.3, 0, -2.0
    hits = 0
    for _ in range(10):
        signorini.step(model, data)
        gained, from_contacts = acted(data)
        assert gained == pytest.approx(from_contacts, abs=1e-12)
        hits += data.qvel[2] > 1.0 and np.abs(from_contacts).max() > 2.0
    assert hits == 1, "it strikes once and comes back with 0.6 of its speed"


def test_what_pairs_of_bodies_add_up_to():
    model = signorini.Model.from_string(PILE)
    data = signorini.Data(model)
    signorini.step(model, data, nstep=100)
    weight = 9.81 * np.array([0, 0, 1.0])
    on_b = data.contact.between("a", "b")
    assert on_b.force == pytest.approx(2 * weight, abs=1e-8) and on_b.ncon >= 4 and on_b.closed >= 1
    assert data.contact.between("b", "a").force == pytest.approx(-on_b.force)
    assert data.contact.between("world", "a").force == pytest.approx(3 * weight, abs=1e-8)
    assert data.contact.between(0, 1).impulse == pytest.approx(3 * 0.002 * weight, abs=1e-10)
    # The load of b acts where b's centre of mass is.
    assert on_b.torque == pytest.approx(np.cross(data.body("b").xipos, on_b.force), abs=1e-7)
    assert data.contact.between(0, 2).ncon == 0
    with pytest.raises(KeyError, match="'world', 'a', 'b'"):
        data.contact.between("a", "c")
    with pytest.raises(IndexError, match="the model has 3"):
        data.contact.between(0, 3)


def test_stabilization_is_the_part_that_lifts_a_body_out():
    depth, dt = 1e-3, 0.002
    model = mjcf("<geom type='plane'/><body name='ball' pos='0 0 0.099'><freejoint/><geom size='0.1' mass='1'/></body>")
    at_once = signorini.Settings(correction_speed=np.inf)
    data = signorini.Data(model, at_once)
    signorini.step(model, data)
    contact = data.contact
    # v⁺ = −φ/Δt asks for m (depth/Δt + gΔt); without the penetration the weight alone is carried.
    assert contact.impulse[:, 0].sum() == pytest.approx(depth / dt + 9.81 * dt, rel=1e-9)
    assert contact.stabilization[:, 0].sum() == pytest.approx(depth / dt, rel=1e-9)
    assert contact.stabilization.shape == (len(contact), 3)
    signorini.step(model, data, nstep=200)
    assert (data.contact.stabilization == 0).all() and len(data.contact) == 1
    assert contact.stabilization[:, 0].sum() == pytest.approx(depth / dt, rel=1e-9), "a snapshot"
    half = signorini.Data(model, signorini.Settings(stabilization=0.5, correction_speed=np.inf))
    with pytest.warns(signorini.OverlapWarning, match="1.000 mm"):
        signorini.step(model, half)
    assert half.contact.stabilization[:, 0].sum() == pytest.approx(0.5 * depth / dt, rel=1e-9)
    with half.record() as recorder:
        signorini.step(model, half)
    with pytest.raises(RuntimeError, match="recording"):
        recorder.recording.contact(0).stabilization
    assert recorder.recording.contact(0).between("world", "ball").ncon == 1
