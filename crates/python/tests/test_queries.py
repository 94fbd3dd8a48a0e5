"""What is asked of a configuration: against MuJoCo where it is installed, differences, and identities."""

import numpy as np
import pytest

import signorini
from signorini import Data, Model

WALKER = """<mujoco>
  <compiler angle="radian"/>
  <worldbody><geom name="floor" type="plane" size="5 5 .1"/>
    <geom name="post" type="box" pos=".9 .2 .5" euler=".1 .2 .3" size=".1 .2 .5"/>
    <body name="trunk" pos="0 0 .62"><freejoint name="base"/><geom name="trunk" type="box" size=".2 .1 .1" mass="4"/>
      <site name="head" pos=".2 0 .1" euler="0 .3 0"/>
      <body name="left" pos=".1 .15 -.1"><joint name="hip" type="ball"/><geom name="thigh" type="capsule" fromto="0 0 0 0 0 -.2" size=".04" mass="1"/>
        <body name="shin" pos="0 0 -.22"><joint name="knee" axis="0 1 0" range="-2 2"/>
          <geom name="shin" type="cylinder" fromto="0 0 0 0 0 -.2" size=".03" mass=".5"/><site name="toe" pos=".05 0 -.22"/></body></body>
      <body name="right" pos="-.1 -.15 -.1"><joint name="slide" type="slide" axis="0 0 1"/><geom name="ball" size=".1" mass="1"/></body>
    </body>
    <body name="egg" pos="-.7 .5 .4"><freejoint name="egg"/><geom name="egg" type="ellipsoid" size=".1 .15 .2" mass="1"/></body>
  </worldbody>
</mujoco>"""

GEOMS = ["floor", "post", "trunk", "thigh", "shin", "ball", "egg"]


def states(model, count=6):
    random = np.random.default_rng(3)
    for _ in range(count):
        data = Data(model)
        data.qvel = random.normal(size=model.nv)
        data.qpos = signorini.integrate(model, model.qpos0, random.normal(size=model.nv) * 0.3)
        yield data, random


def theirs(model, data):
    """The same state in MuJoCo."""
    mujoco = pytest.importorskip("mujoco")
    other = mujoco.MjModel.from_xml_string(WALKER)
    state = mujoco.MjData(other)
    state.qpos, state.qvel = data.qpos, data.qvel
    mujoco.mj_forward(other, state)
    return mujoco, other, state


@pytest.fixture(scope="module")
def model():
    return Model.from_mjcf(WALKER)


def test_distances_are_mujocos(model):
    for data, _ in states(model):
        mujoco, other, state = theirs(model, data)
        for i, first in enumerate(GEOMS):
            for j, second in enumerate(GEOMS[i + 1 :], i + 1):
                mine = signorini.distance(model, data, first, second)
                ends = np.zeros(6)
                wanted = mujoco.mj_geomDistance(other, state, i, j, 100.0, ends)
                assert np.allclose(mine.point2 - mine.point1, mine.normal * mine.distance, atol=1e-6)
                if wanted > 1e-3:  # Theirs is an iteration to 1e-6, and overlaps are not unique.
                    assert mine.distance == pytest.approx(wanted, abs=2e-5), (first, second)
                assert signorini.distance(model, data, second, first).distance == pytest.approx(mine.distance, abs=1e-9)


def test_rays_are_mujocos(model):
    met = 0
    for data, random in states(model):
        mujoco, other, state = theirs(model, data)
        origins, directions = random.normal(size=(200, 3)) * [1, 1, 0.5] + [0, 0, 1.5], random.normal(size=(200, 3))
        distances, geoms, normals = signorini.cast_rays(model, data, origins, directions)
        for k, (origin, direction) in enumerate(zip(origins, directions)):
            geom = np.zeros(1, np.int32)
            unit = direction / np.linalg.norm(direction)
            wanted = mujoco.mj_ray(other, state, origin, unit, None, 1, -1, geom)
            if geom[0] == 0 and np.abs(origin + wanted * unit)[:2].max() > 5:
                continue  # Their floor ends where it is drawn to.
            if distances[k] < np.inf and geoms[k] == 0 and np.abs(origin + distances[k] * unit)[:2].max() > 5:
                continue
            assert geoms[k] == geom[0]
            if wanted >= 0:
                met += 1
                assert distances[k] == pytest.approx(wanted, abs=1e-9) and np.linalg.norm(normals[k]) == pytest.approx(1)
                one = signorini.cast_ray(model, data, origin, direction)
                assert (one.geom, one.distance, one.name) == (geoms[k], distances[k], GEOMS[geoms[k]])
                assert np.allclose(one.point, origin + unit * wanted, atol=1e-9)
    assert met > 300


def test_jacobians_and_frames_are_mujocos(model):
    for data, _ in states(model):
        mujoco, other, state = theirs(model, data)
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for name in ("head", "toe"):
            mujoco.mj_jacSite(other, state, linear, angular, other.site(name).id)
            mine = signorini.jacobian(model, data, site=name)
            assert np.allclose(mine[0], linear, atol=1e-12) and np.allclose(mine[1], angular, atol=1e-12)
            place, turn = signorini.frame_pose(model, data, site=name)
            assert np.allclose(place, state.site(name).xpos, atol=1e-12) and np.allclose(turn.ravel(), state.site(name).xmat, atol=1e-12)
            rates = np.zeros((3, model.nv)), np.zeros((3, model.nv))
            mujoco.mj_jacDot(other, state, *rates, state.site(name).xpos, other.site(name).bodyid[0])
            mine = signorini.jacobian_rate(model, data, site=name)
            assert np.allclose(mine[0], rates[0], atol=1e-10) and np.allclose(mine[1], rates[1], atol=1e-10)
        for body in ("world", "trunk", "left", "egg"):
            mujoco.mj_jacSubtreeCom(other, state, linear, other.body(body).id)
            mine, rate = signorini.center_of_mass_jacobian(model, data, body)
            center = signorini.center_of_mass(model, data, body)
            assert np.allclose(mine, linear, atol=1e-12) and np.allclose(center, state.subtree_com[other.body(body).id], atol=1e-12)
            after = Data(model)
            after.qpos, after.qvel = signorini.integrate(model, data.qpos, data.qvel, 1e-6), data.qvel
            moved = signorini.center_of_mass_jacobian(model, after, body)[0]
            assert np.allclose((moved - mine) / 1e-6, rate, atol=1e-4)


def test_forces_on_bodies_are_mujocos(model):
    for data, random in states(model, 3):
        data.qpos[2] += 3
        data.joint("egg").qpos[2] += 6
        mujoco, other, state = theirs(model, data)
        data.xfrc_applied = random.normal(size=(model.nbody, 6))
        wanted = np.zeros(model.nv)
        for body in range(1, model.nbody):
            force, torque = np.split(data.xfrc_applied[body], 2)
            mujoco.mj_applyFT(other, state, force, torque, state.xipos[body], body, wanted)
        pushed = Data(model)
        pushed.qpos, pushed.qvel, pushed.qfrc_applied = data.qpos, data.qvel, wanted
        signorini.step(model, data)
        signorini.step(model, pushed)
        assert np.allclose(data.qvel, pushed.qvel, rtol=0, atol=1e-11)
        saved = data.get_state()
        other_data = Data(model)
        other_data.set_state(saved)
        assert np.array_equal(other_data.xfrc_applied, data.xfrc_applied)
        signorini.step(model, data, 3)
        signorini.step(model, other_data, 3)
        assert np.array_equal(data.get_state(), other_data.get_state())
        data.reset()
        assert not data.xfrc_applied.any()


def test_a_recording_of_pushed_bodies_is_checked(model):
    data = Data(model)
    data.xfrc_applied[1, :3] = [3, 1, 0]
    with data.record() as recorder:
        signorini.step(model, data, 30)
    assert recorder.recording.check(tolerance=1e-9).ok


def test_contacts_of_a_configuration_are_those_of_a_step(model):
    data = Data(model)
    data.qpos[2] = 0.515  # The ball is 5 mm in the floor.
    before = data.get_state()
    asked = signorini.contacts_at(model, data)
    assert np.array_equal(before, data.get_state())
    signorini.forward(model, data)
    step = data.contact
    touching = [(g1, g2, gap) for g1, g2, gap in zip(step.geom1, step.geom2, step.gap) if gap <= 1e-9]
    assert len(asked) == len(touching) > 0
    assert np.allclose(sorted((p.geom1, p.geom2, p.gap) for p in asked), sorted(touching))
    assert {(a, b) for a, b, _ in signorini.overlaps(model, data)} == {(p.geom1, p.geom2) for p in asked if p.gap < 0}
    high = model.qpos0.copy()
    high[2] = 3.0
    assert not signorini.contacts_at(model, data, high) and signorini.contacts_at(model, data, high, within=4.0)
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(signorini.SettingError, match="within must be finite and not negative"):
            signorini.contacts_at(model, data, within=wrong)


def test_the_operational_space_inertia_is_what_a_force_feels(model):
    for data, _ in states(model, 3):
        linear, _ = signorini.jacobian(model, data, site="toe")
        inertia = signorini.operational_space_inertia(model, data, linear)
        mass = signorini.mass_matrix(model, data)
        assert np.allclose(np.linalg.inv(inertia), linear @ np.linalg.solve(mass, linear.T), atol=1e-9)
    with pytest.raises(signorini.SolveError, match="depend on each other"):
        signorini.operational_space_inertia(model, data, np.vstack([linear, linear[:1]]))


def test_the_operational_space_inertia_of_a_body_is_that_of_its_jacobians():
    rotor = "<body name='{0}' pos='{1}'><freejoint/><geom size='0.1 0.05 0.02' type='box'/></body>"
    model = Model.from_mjcf("<mujoco><worldbody>" + rotor.format("a", "0 0 1") + rotor.format("b", "1 0 1") + "</worldbody></mujoco>")
    for data, _ in states(model, 3):
        both = np.vstack(signorini.jacobian(model, data, "b"))
        asked = [
            signorini.operational_space_inertia(model, data, "b"),
            signorini.operational_space_inertia(model, data, body=2),
            signorini.operational_space_inertia(model, data, both),
        ]
        # A body alone feels its own inertia: mass, and rotational inertia about its centre, turned.
        turn, size = signorini.frame_pose(model, data, body="b")[1], np.array([0.2, 0.1, 0.04])
        mass = 1000.0 * size.prod()
        rotational = turn @ np.diag(mass / 12.0 * (np.sum(size**2) - size**2)) @ turn.T
        expected = np.block([[mass * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), rotational]])
        assert all(np.allclose(one, expected, rtol=1e-9, atol=1e-12) for one in asked)
    with pytest.raises(KeyError, match="no body 'c'"):
        signorini.operational_space_inertia(model, data, "c")
    with pytest.raises(TypeError, match="either a Jacobian or one of body, geom and site"):
        signorini.operational_space_inertia(model, data)


def test_inverse_kinematics_puts_a_site_where_it_is_wanted(model):
    for data, random in states(model, 4):
        goal = Data(model)
        goal.qpos = signorini.integrate(model, data.qpos, 0.4 * random.normal(size=model.nv))
        place, turn = signorini.frame_pose(model, goal, site="toe")
        answer = signorini.inverse_kinematics(model, data, place, site="toe")
        assert answer.converged and answer.position_error < 1e-9
        found = Data(model)
        found.qpos = answer.qpos
        assert np.allclose(signorini.frame_pose(model, found, site="toe")[0], place, atol=1e-9)
        only = signorini.inverse_kinematics(model, data, place, site="toe", joints=["hip", "knee"])
        assert np.array_equal(np.delete(only.qpos, range(7, 12)), np.delete(data.qpos, range(7, 12)))
        turned = signorini.inverse_kinematics(model, data, place, turn, site="toe")
        data.qpos = turned.qpos
        assert turned.converged and np.allclose(signorini.frame_pose(model, data, site="toe")[1], turn, atol=1e-8)
    with pytest.raises(ValueError, match="one of body, geom and site"):
        signorini.inverse_kinematics(model, data, place)
    with pytest.raises(KeyError, match="no site 'tow'; valid names: 'toe'"):
        signorini.inverse_kinematics(model, data, place, site="tow")
    for wrong in (-np.eye(3), 2 * np.eye(3), np.array([[1, 0.1, 0], [0, 1, 0], [0, 0, 1.0]]), np.full((3, 3), np.nan)):
        with pytest.raises(signorini.ProblemError, match="quat is no rotation"):
            signorini.inverse_kinematics(model, data, quat=wrong, site="toe")


def test_what_stands_presses_inside_its_polygon():
    model = Model.from_mjcf("""<mujoco><worldbody><geom type="plane"/><body name="table" pos=".3 .1 .5"><freejoint/>
      <geom type="box" size=".4 .3 .5" mass="3"/><geom size=".1" pos=".2 .1 .6" mass="1"/></body></worldbody></mujoco>""")
    data = Data(model)
    signorini.step(model, data, 50)
    corners = signorini.support_polygon(model, data)
    assert sorted(np.round(corners[:, :2], 6).tolist()) == [[-0.1, -0.2], [-0.1, 0.4], [0.7, -0.2], [0.7, 0.4]]
    pressure = signorini.zero_moment_point(model, data)
    assert np.allclose(pressure[:2], signorini.center_of_mass(model, data)[:2], atol=1e-9) and abs(pressure[2]) < 1e-9
    data.xfrc_applied[1, 0] = 5.0
    signorini.step(model, data)
    com = signorini.center_of_mass(model, data)
    tipped = com[0] + 5.0 * com[2] / (4 * 9.81)  # The moment of the push about the ground; it stands on friction.
    assert signorini.zero_moment_point(model, data, "table")[0] == pytest.approx(tipped, abs=1e-9)
    assert signorini.zero_moment_point(model, Data(model)) is None
