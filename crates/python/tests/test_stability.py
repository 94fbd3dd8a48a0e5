"""Does it stand: verdicts and their proofs."""

import math

import numpy as np
import pytest

import signorini
from conftest import mjcf


def slope(angle, friction):
    return signorini.Model.from_string(
        f"<mujoco><option gravity='{9.81 * math.sin(angle)} 0 {-9.81 * math.cos(angle)}'/><worldbody>"
        f"<geom type='plane' friction='{friction}'/><body name='box' pos='0 0 0.1'><freejoint/>"
        f"<geom type='box' size='0.1 0.1 0.1' friction='{friction}'/></body></worldbody></mujoco>")


def test_a_box_on_a_slope():
    moves = signorini.stability(slope(0.3, math.tan(0.3) - 1e-9))
    assert moves.verdict == "must_move" and moves.proved and moves.required_force > 1e6
    linear, angular = moves.motion["box"]
    assert linear[0] > 0.9 and np.abs(angular).max() < 0.1
    stays = signorini.stability(slope(0.3, math.tan(0.3) + 0.1))
    assert stays.verdict == "stays" and stays.proved and stays.required_force is None
    mass = 8.0
    assert stays.forces.sum(axis=0) == pytest.approx([-mass * 9.81 * math.sin(0.3), 0, mass * 9.81 * math.cos(0.3)])
    assert stays.points.shape == (4, 3) and stays.friction_use.max() <= 1 + 1e-9


def test_tolerances_have_a_range():
    box = slope(0.1, 0.5)
    for wrong in (-1.0, 0.0, 1.0, math.nan):
        for ask in (lambda: signorini.stability(box, tolerance=wrong), lambda: signorini.safety(box, what="friction", tolerance=wrong)):
            with pytest.raises(signorini.SettingError, match="tolerance"):
                ask()
    with pytest.raises(signorini.SettingError, match="contact_tolerance"):
        signorini.stability(box, touching=-1e-3)


def test_walls_that_just_touch_leave_both_open():
    model = mjcf("<geom type='plane' pos='-0.1 0 0' zaxis='1 0 0' friction='0.5'/><geom type='plane' pos='0.1 0 0' zaxis='-1 0 0'/>"
                 "<body name='box' pos='0 0 1'><freejoint/><geom type='box' size='0.1 0.1 0.1'/></body>")
    both = signorini.stability(model)
    assert both.verdict == "may_do_either" and both.proved
    assert both.motion["box"][0][2] < 0 and any(end == "moves" for _, end in both.search)


def test_the_data_say_where(tmp_path):
    """Lifted from the floor it falls; its proof can be stored."""
    model = mjcf("<geom type='plane'/><body name='ball' pos='0 0 0.1'><freejoint/><geom size='0.1'/></body>")
    data = signorini.Data(model)
    assert signorini.stability(model, data).verdict == "stays"
    data.qpos[2] = 0.2
    falls = signorini.stability(model, data)
    assert falls.verdict == "must_move" and falls.required_force == math.inf
    falls.save(tmp_path / "proof.npz")
    assert np.load(tmp_path / "proof.npz")["verdict"] == b"must_move"
    with pytest.raises(signorini.SettingError):
        signorini.stability(model, data, touching=-1.0)


def test_limits_lie_between_two_proofs():
    model = mjcf("<geom type='plane' friction='0.5'/><body name='box' pos='0 0 0.1'><freejoint/>"
                 "<geom type='box' size='0.1 0.2 0.1' friction='0.5'/></body>")
    tilt = signorini.safety(model, what="tilt", direction=(1, 0, 0))
    assert tilt.holds == pytest.approx(math.atan(0.5), rel=1e-7) and tilt.falls == pytest.approx(tilt.holds, rel=1e-7)
    assert max(tilt.residuals) <= 1e-9
    load = np.zeros(6)
    load[0] = 1
    pushed = signorini.safety(model, what="load", load=load)
    mass = 1000 * 0.2 * 0.4 * 0.2
    assert pushed.holds == pytest.approx(0.5 * mass * 9.81, rel=1e-7)
    for wrong in ({"what": "tilt"}, {"what": "load"}, {"what": "tilt", "direction": (0, 0, 1)}, {"what": "load", "load": [1.0]}):
        with pytest.raises(signorini.SettingError):
            signorini.safety(model, **wrong)


def test_mechanisms_open_their_contacts_at_every_scale():
    """A block that overhangs tips, of centimetres and of kilometres, and neither block sinks into anything where it is shown."""
    for scale in (0.01, 1.0, 100.0, 1000.0, 3000.0):
        blocks = signorini.Assembly(floor=0.0, touching=1e-6 * scale)
        places = {"lower": ((0.0, 0.0, 0.0), (0.2, 0.2, 0.3)), "upper": ((0.15, 0.05, 0.3), (0.5, 0.3, 0.6))}
        for (name, (low, high)), density, friction in zip(places.items(), (100.0, 900.0), (1.0, 0.3)):
            corners = [[(low, high)[k >> axis & 1][axis] * scale for axis in range(3)] for k in range(8)]
            faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
            blocks.add(name, corners, faces, density=density, friction=friction)
        found = blocks.stability(enumeration=0)
        assert found.verdict == "must_move" and found.proved
        still = (np.zeros(3), np.zeros(3))
        motion = [found.motion.get(name, still) for name in places]
        centres = [scale * np.mean(ends, axis=0) for ends in places.values()]

        def velocity(block, point):
            linear, angular = motion[block]
            return linear + np.cross(angular, point - centres[block])

        fastest = max(np.linalg.norm(velocity(k, scale * np.array(ends))) for k, box in enumerate(places.values()) for ends in box)
        for point in found.points:
            above, below = (1, 0) if point[2] > 0.1 * scale else (0, None)
            opens = velocity(above, point) - (np.zeros(3) if below is None else velocity(below, point))
            assert opens[2] >= -1e-6 * fastest, scale
        weights = [density * np.prod(np.subtract(*ends[::-1])) for density, ends in zip((100.0, 900.0), places.values())]
        assert sum(w * linear[2] for w, (linear, _) in zip(weights, motion)) < 0
