"""Limits of statics over all directions, under circular cones, with attractions, and where motion begins."""

import math

import numpy as np
import pytest

import signorini
from conftest import mjcf

BLOCK = ("<geom type='plane' friction='0.4'/><body name='block' pos='0 0 0.1'><freejoint/>"
             "<geom type='box' size='0.2 0.3 0.1' mass='2' friction='0.4'/></body>")
GRIPPER = ("<body name='left' pos='-0.06 0 1'><geom type='box' size='0.01 0.02 0.02' friction='0.8'/></body>"
               "<body name='right' pos='0.06 0 1'><geom type='box' size='0.01 0.02 0.02' friction='0.8'/></body>"
               "<body name='held' pos='0 0 1'><freejoint/>"
               "<geom type='box' size='0.05 0.05 0.05' mass='0.5' friction='0.8'/></body>")


def test_the_worst_of_all_directions():
    model = mjcf(BLOCK)
    worst = signorini.safety(model, what="tilt", direction="worst")
    # The polygon of friction is narrowest between two of its eight directions.
    expected = math.atan(0.4 * math.cos(math.pi / 8))
    assert worst.holds == pytest.approx(expected, rel=1e-8) and worst.at_least == pytest.approx(expected, rel=1e-8)
    assert abs(worst.direction[2]) < 1e-12 and np.linalg.norm(worst.direction) == pytest.approx(1)
    angle = math.degrees(math.atan2(worst.direction[1], worst.direction[0])) % 45
    assert angle == pytest.approx(22.5, abs=1e-3)
    with pytest.raises(signorini.SettingError, match="worst"):
        signorini.safety(model, what="friction", direction="worst")


def test_circles_lie_between_their_polygons(tmp_path):
    model = mjcf(BLOCK)
    found = signorini.safety(model, what="horizontal", direction=(1, 0.3, 0), circular=True, motion=True)
    low, high = found.polygons
    assert low < 0.4 < high
    assert found.circular == pytest.approx((0.4, 0.4), rel=1e-7)
    assert found.motion == pytest.approx((found.holds, found.falls), rel=1e-6)
    found.save(tmp_path / "limit")
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["limit-falls-proof.npz", "limit-falls.npz", "limit-holds-proof.npz", "limit-holds.npz"]


def test_a_gripper_holds_what_it_presses():
    model = mjcf(GRIPPER)
    # Pads that just touch press with nothing: friction could hold the box, and nothing makes it.
    assert signorini.stability(model).verdict == "may_do_either"
    # A grip is a force in the fingers; a pad that is glued bears tension itself.
    glued = {("left", "held"): 4.0}
    found = signorini.stability(model, attraction=glued)
    assert found.verdict in ("stays", "stands", "may_do_either") and found.proved
    one = ("<body name='pad' pos='0 0 1.06'><geom type='box' size='0.02 0.02 0.01' friction='0.8'/></body>"
               "<body name='held' pos='0 0 1'><freejoint/><geom type='box' size='0.05 0.05 0.05' mass='0.5'/></body>")
    suction = mjcf(one)
    weight = 0.5 * 9.81
    for force, verdict in [(weight * 1.001, "stays"), (weight * 0.999, "must_move")]:
        assert signorini.stability(suction, attraction={("pad", "held"): force}).verdict == verdict
    found = signorini.safety(suction, what="weight", body="held", attraction={("pad", "held"): 3 * weight})
    assert found.holds == pytest.approx(1.0, rel=1e-9)
    with pytest.raises(signorini.SettingError, match="nobody"):
        signorini.stability(suction, attraction={("pad", "nobody"): 1.0})


def test_bodies_and_forces_of_a_stack():
    bodies = "".join(f"<body name='b{k}' pos='0 0 {0.1 + 0.2 * k}'><freejoint/>"
                     "<geom type='box' size='0.1 0.1 0.1' mass='1' friction='0.3'/></body>" for k in range(3))
    model = mjcf(f"<geom type='plane' friction='0.3'/>{bodies}")
    found = signorini.critical_bodies(model)
    assert list(found) == ["b0", "b1", "b2"]
    force, direction = found["b2"]
    assert force == pytest.approx(0.3 * math.cos(math.pi / 8) * 9.81, rel=1e-7) and abs(direction[2]) < 1e-12
    assert force < found["b1"][0] < found["b0"][0]
    stability = signorini.stability(model)
    ranges = stability.force_ranges()
    assert ranges.shape == (12, 2)
    assert np.all(ranges[:, 0] <= stability.forces[:, 2] * np.sign(stability.forces[:, 2]) + 1e-9)
    assert ranges[:4, 1] == pytest.approx(np.full(4, 3 * 9.81 / 2), rel=1e-8)


def test_placements_tell_of_their_progress():
    model = mjcf(BLOCK)
    qpos = np.tile(signorini.Data(model).qpos, (6, 1))
    seen = []
    signorini.placements(model, qpos, progress=seen.append)
    assert sorted(seen) == [1, 2, 3, 4, 5, 6]
    with pytest.raises(ZeroDivisionError):
        signorini.placements(model, qpos, progress=lambda count: 1 / 0)


def test_bricks_hold_by_their_studs():
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]

    def brick(x, z):
        return [[x + (k & 1), k >> 1 & 1, z + 0.5 * (k >> 2)] for k in range(8)]

    def over(reach, tension):
        wall = signorini.Assembly(floor=0.0)
        wall.add("lower", brick(0, 0), faces)
        wall.add("upper", brick(reach, 0.5), faces)
        wall.join("lower", "upper", [[reach, 0.5, 0.5]], (0, 0, 1), tension=tension)
        return wall.stability().verdict

    # The upper brick turns about the edge at x = 1; the stud at its far end holds it with an arm of 1 − reach.
    weight, reach = 1000 * 0.5 * 9.81, 0.6
    need = weight * (reach + 0.5 - 1) / (1 - reach)
    assert over(reach, 0.0) == "must_move"
    assert over(reach, 0.999 * need) == "must_move" and over(reach, 1.001 * need) == "stays"
