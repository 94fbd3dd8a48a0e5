"""Assemblies of blocks, and many placements of one model."""

import math

import numpy as np
import pytest

import signorini
from conftest import mjcf

FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]


def brick(corner, size):
    return [[corner[i] + size[i] * (k >> i & 1) for i in range(3)] for k in range(8)]


def test_a_brick_over_an_edge():
    for over, verdict in [(0.499, "stays"), (0.501, "must_move")]:
        wall = signorini.Assembly(floor=0.0)
        wall.add("lower", brick([0, 0, 0], [1, 1, 0.5]), FACES)
        wall.add("upper", brick([over, 0, 0.5], [1, 1, 0.5]), FACES)
        found = wall.stability()
        assert len(wall) == 2 and found.verdict == verdict and found.proved
    assert found.motion and "upper" in found.motion
    with pytest.raises(signorini.SettingError, match="no volume"):
        wall.add("open", brick([0, 0, 0], [1, 1, 1]), FACES[:1])
    with pytest.raises(signorini.SettingError, match="vertex"):
        wall.add("wrong", brick([0, 0, 0], [1, 1, 1]), [[0, 1, 9]])


def test_a_block_that_is_not_convex_hangs_on_a_rail():
    """A block with a notch from below sits on a rail that is narrower than the notch; its hull would overlap the rail."""
    outline = [(-1, 0), (-0.5, 0), (-0.5, 0.5), (0.5, 0.5), (0.5, 0), (1, 0), (1, 1), (-1, 1)]
    n = len(outline)
    vertices = [[x, y, z] for y in (0, 1) for x, z in outline]
    faces = [list(range(n)), [n + k for k in reversed(range(n))]]
    faces += [[(k + 1) % n, k, k + n, (k + 1) % n + n] for k in range(n)]
    hung = signorini.Assembly()
    hung.add("rail", brick([-0.2, 0, -1], [0.4, 1, 1.5]), FACES, fixed=True)
    hung.add("block", vertices, faces, density=500.0)
    found = hung.stability()
    assert found.verdict == "stays"
    # Volume 1.5 m³ at 500 kg/m³, on the rail's top alone.
    assert found.forces[:, 2].sum() == pytest.approx(500 * 1.5 * 9.81)
    assert found.points[:, 2] == pytest.approx(0.5) and np.abs(found.points[:, 0]).max() == pytest.approx(0.2)
    tilt = hung.safety(what="tilt", direction=(1, 0, 0))
    mass_height = (2 * 1 * 0.5 - 0.5 * 0.25) / 1.5
    expected = min(math.atan(0.6), math.atan(0.2 / abs(mass_height - 0.5)))
    assert tilt.holds == pytest.approx(expected, rel=1e-8) and tilt.falls == pytest.approx(expected, rel=1e-8)


def test_placements_of_a_box_on_a_box():
    model = mjcf("<geom type='plane'/><body name='lower' pos='0 0 0.1'><freejoint/><geom type='box' size='0.1 0.1 0.1'/></body>"
                 "<body name='upper' pos='0 0 0.3'><freejoint/><geom type='box' size='0.1 0.1 0.1' friction='0.5'/></body>")
    qpos = np.tile(signorini.Data(model).qpos, (9, 1))
    qpos[:, 7] = np.linspace(-0.12, 0.12, 9)
    found = signorini.placements(model, qpos, what="tilt", direction=(1, 0, 0))
    inside = np.abs(qpos[:, 7]) < 0.1
    assert [v == "stays" for v in found.verdict] == list(inside) and found.proved and len(found) == 9
    # The upper one tips about the lower one's edge, or both about the floor; or it slides.
    expected = [math.atan(min(1.0, (0.1 - x) / 0.1, (0.1 - x / 2) / 0.2)) for x in qpos[inside, 7]]
    assert found.margin[inside] == pytest.approx(expected, rel=1e-7)
    assert np.isnan(found.margin[~inside]).all() and found.overlap.max() < 1e-12
    alone = [signorini.stability(model, _at(model, row), enumeration=0).verdict for row in qpos]
    assert found.verdict == alone


def _at(model, qpos):
    data = signorini.Data(model)
    data.qpos = qpos
    return data


def test_a_weight_on_a_box():
    model = mjcf("<geom type='plane'/><body name='lower' pos='0 0 0.1'><freejoint/><geom type='box' mass='1' size='0.1 0.1 0.1'/></body>"
                 "<body name='middle' pos='0.04 0 0.3'><freejoint/><geom type='box' mass='2' size='0.1 0.1 0.1'/></body>"
                 "<body name='upper' pos='0.12 0 0.5'><freejoint/><geom type='box' mass='1' size='0.1 0.1 0.1'/></body>")
    found = signorini.safety(model, what="weight", body="upper")
    assert found.holds == pytest.approx(5, rel=1e-8) and found.falls == pytest.approx(5, rel=1e-8)
    with pytest.raises(signorini.SettingError, match="nobody"):
        signorini.safety(model, what="weight", body="nobody")


def test_motors_hold_a_posture():
    model = signorini.Model.from_string(
        "<mujoco><worldbody><body name='arm'><joint name='elbow' axis='0 -1 0'/>"
        "<geom type='sphere' size='0.05' pos='0.5 0 0' mass='2'/></body></worldbody>"
        "<actuator><motor joint='elbow' ctrlrange='-12 12'/></actuator></mujoco>")
    assert signorini.stability(model).verdict == "must_move"
    assert signorini.stability(model, hold=True).verdict == "stays"
    margin = signorini.safety(model, what="motors", hold=True)
    assert margin.holds == pytest.approx(9.81 / 12, rel=1e-7)


def test_places_of_a_grasp_are_judged_with_motors_that_hold():
    finger = ("<body pos='{x} 0 1'><joint type='slide' axis='{a} 0 0'/><geom type='box' size='.01 .02 .02' mass='.1' friction='.5'/></body>")
    model = signorini.Model.from_string(
        f"<mujoco><worldbody>{finger.format(x=-0.06, a=1)}{finger.format(x=0.06, a=-1)}"
        "<body name='box' pos='0 0 1'><freejoint/><geom type='box' size='.05 .05 .1' mass='.4' friction='.5'/></body></worldbody>"
        "<actuator><motor joint='joint0' forcerange='-9 9'/><motor joint='joint1' forcerange='-9 9'/></actuator></mujoco>")
    low = np.zeros((3, model.nq))
    low[:] = signorini.Data(model).qpos
    # In the middle, at the edge of the fingers, and beside them.
    low[1, 3] += 0.0701
    low[2, 3] += 0.0901
    held = signorini.placements(model, low, what="weight", body="box", hold=True, search=False)
    # Two fingers of 9 N with a friction of 0.5.
    assert held.margin[0] == pytest.approx(9 / 9.81 - 0.4, rel=1e-6)
    # What holds still need not press: the box may fall between fingers that do not.
    assert held.verdict[0] == "may_do_either" and held.proved
    for row, verdict in zip(low, held.verdict):
        data = signorini.Data(model)
        data.qpos[:] = row
        assert (signorini.stability(model, data, hold=True).verdict == "must_move") == (verdict == "must_move")
    assert signorini.placements(model, low).verdict == ["must_move"] * 3
