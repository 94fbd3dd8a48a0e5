"""Specs edited part by part: beside models that were written by hand, and beside MuJoCo's reading of them."""

import copy
import pickle

import numpy as np
import pytest

import signorini

ARM = """<mujoco model="arm">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" range="-2 1" damping="0.2"/>
      <geom name="upper" type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="0.7"/>
      <body name="lower" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0"/>
        <geom name="lower" type="cylinder" size="0.02 0.15" pos="0.15 0 0" quat="0.7 0 0.7 0" density="800"/>
        <site name="tip" pos="0.3 0 0"/>
      </body>
    </body>
    <body name="box" pos="0.6 0 0.2"><freejoint name="box free"/><geom name="box" type="box" size="0.1 0.08 0.1" friction="0.4"/></body>
  </worldbody>
  <tendon><fixed name="cord" limited="true" range="-1 1"><joint joint="shoulder" coef="1"/><joint joint="elbow" coef="-0.5"/></fixed></tendon>
  <equality><connect name="held" body1="lower" body2="box" anchor="0.3 0 0"/></equality>
  <actuator><position name="servo" joint="shoulder" kp="12" kv="1"/><motor name="pull" tendon="cord" gear="2"/></actuator>
  <sensor><accelerometer name="imu" site="tip"/><jointpos name="angle" joint="elbow"/></sensor>
  <keyframe><key name="up" qpos="0.3 -0.2 1 0 0.5 1 0 0 0" ctrl="0.5 0"/></keyframe>
</mujoco>"""


def by_hand():
    world = signorini.scene("arm")
    world.floor(friction=1.0)
    upper = world.add_body("upper", pos=(0, 0, 1))
    shoulder = upper.add_joint("hinge", "shoulder", axis=(0, 1, 0), range=(-2, 1), damping=0.2)
    upper.add_geom("capsule", "upper", fromto=(0, 0, 0, 0.4, 0, 0), size=0.03, mass=0.7)
    lower = upper.add_body("lower", pos=(0.4, 0, 0))
    elbow = lower.add_joint("hinge", "elbow", axis=(0, 1, 0))
    lower.add_geom("cylinder", "lower", size=(0.02, 0.15), pos=(0.15, 0, 0), quat=(0.7, 0, 0.7, 0), density=800)
    lower.add_site("tip", pos=(0.3, 0, 0))
    box = world.box((0.1, 0.08, 0.1), pos=(0.6, 0, 0.2), density=1000, name="box", friction=0.4)
    cord = world.add_tendon({"shoulder": 1, "elbow": -0.5}, "cord", range=(-1, 1))
    world.add_equality("connect", "held", body1=lower, body2=box, anchor=(0.3, 0, 0))
    world.add_actuator("position", "servo", joint=shoulder, kp=12, kv=1)
    world.add_actuator("motor", "pull", tendon=cord, gear=2)
    world.add_sensor("accelerometer", "imu", site="tip")
    world.add_sensor("jointpos", "angle", joint=elbow)
    world.add_keyframe("up", qpos=(0.3, -0.2, 1, 0, 0.5, 1, 0, 0, 0), ctrl=(0.5, 0))
    return world


def trace(model, steps=60):
    data = signorini.Data(model, signorini.Settings(assembly_tolerance=1.0))
    data.ctrl[:] = 0.2
    signorini.step(model, data, nstep=steps)
    return np.concatenate([data.qpos, data.qvel, data.sensordata])


def test_built_part_by_part_it_is_the_model_of_the_file():
    world, expected = by_hand(), signorini.Model.from_string(ARM)
    model = world.compile()
    assert (model.body_names, model.joint_names, model.geom_names) == (expected.body_names, expected.joint_names, expected.geom_names)
    assert (model.actuator_names, model.sensor_names, model.tendon_names) == (expected.actuator_names, expected.sensor_names, expected.tendon_names)
    for name in signorini.PARAMETERS:
        assert np.allclose(model.parameter(name), expected.parameter(name), rtol=1e-12, atol=1e-14), name
    assert np.abs(trace(model) - trace(expected)).max() < 1e-9
    assert np.allclose(model.keyframe("up").qpos, expected.keyframe("up").qpos, atol=1e-15)


def test_attributes_are_read_and_set():
    world = by_hand()
    box = world.geom("box")
    assert (box.friction, box.size, box.type, box.condim) == (0.4, (0.1, 0.08, 0.1), "box", 3)
    box.friction, box.size, box.condim, box.surface_velocity = 0.9, np.array([0.2, 0.2, 0.1]), 4, (1, 0, 0)
    world.remove("equality", "held")
    world.joint("elbow").damping = 0.3
    world.joint("elbow").axis = (0, 2, 0)
    world.body("box").pos = (1, 0, 0.3)
    world.actuator("servo").kp = 20
    world.gravity = (0, 0, -1.62)
    world.timestep = 0.005
    world.sleeping = True
    model = world.compile()
    assert model.parameter("geom_friction")[model.geom("box").id, 0] == 0.9
    assert model.parameter("geom_surface_velocity")[model.geom("box").id].tolist() == [1, 0, 0]
    assert model.sleeping and world.sleeping
    assert (model.joint("elbow").damping, model.timestep, model.gravity[2]) == (0.3, 0.005, -1.62)
    assert model.joint("elbow").axis == (0.0, 1.0, 0.0)
    assert model.parameter("actuator_kp").tolist() == [20, 0]
    assert "friction" in dir(box)


@pytest.mark.parametrize(
    "edit, error, words",
    [
        (lambda w: w.geom("bux"), KeyError, "'box'"),
        (lambda w: setattr(w.geom("box"), "frictoin", 1), AttributeError, "it has pos, quat, size, friction"),
        (lambda w: setattr(w.geom("box"), "size", 0.1), signorini.ProblemError, "a box has not 1 sizes"),
        (lambda w: setattr(w.geom("box"), "pos", "high"), signorini.ProblemError, "pos of geom 'box'"),
        (lambda w: w.add_body("box"), signorini.ModelError, "there is a body 'box' already"),
        (lambda w: w.add_body("b", parent="tabel"), signorini.ModelError, "no body 'tabel'"),
        (lambda w: w.add_geom("box", "sphere", "ball", size=0.1, frictoin=0.3), signorini.ProblemError, "frictoin"),
        (lambda w: w.add_actuator("motor", "m", joint="elbw"), signorini.ModelError, "elbw"),
        (lambda w: w.add_sensor("accelerometer", "s", site="tap"), signorini.ModelError, "tap"),
        (lambda w: w.part("boddy", 0), signorini.ProblemError, "sorts: body"),
        (lambda w: w.joint("box free").__setattr__("axis", (1, 0, 0)), signorini.ProblemError, "only hinges and slides"),
        (lambda w: setattr(w.actuator("pull"), "kp", 1.0), signorini.ProblemError, "has no kp"),
        (lambda w: w.add_geom("world", "sphere", "g", size=0.1, restitution=7), signorini.ProblemError,
         "^restitution of geom 'g': .* between 0 and 1, found 7"),
        (lambda w: w.add_geom("upper", "sphere", "g", size=0.1, mass=1, grain=(1, 0)), signorini.ProblemError, "^grain of geom 'g': "),
        (lambda w: w.add_body(" lead"), signorini.ModelError, "cannot be called ' lead'"),
        (lambda w: w.add_body(""), signorini.ModelError, "cannot be called ''"),
        (lambda w: w.add_site("upper", 5), signorini.ModelError, "the name of a site is text, not 5"),
        (lambda w: w.add_keyframe("late "), signorini.ModelError, "cannot be called 'late '"),
        (lambda w: w.attach(signorini.Spec(), prefix=" x"), signorini.ModelError, "prefix ' x'"),
        (lambda w: w.add_pair("box", "box"), signorini.ModelError, "a contact pair is between geom 'box' and itself"),
        (lambda w: w.add_equality("connect", "c", body1="box", body2="box", anchor=(0, 0, 0)), signorini.ModelError,
         "equality constraint 'c' is between body 'box' and itself"),
        (lambda w: w.add_equality("weld", "c", body1="box", body2="box"), signorini.ModelError, "'box' and itself"),
        (lambda w: w.add_sensor("zz", site="tip"), signorini.ProblemError, "zz"),
    ],
)
def test_a_wrong_edit_is_named_and_changes_nothing(edit, error, words):
    world = by_hand()
    before = world.to_mjcf()
    with pytest.raises(error, match=words):
        edit(world)
    assert world.to_mjcf() == before


HELD = """<mujoco><worldbody><body name="a" pos="0 0 1"><freejoint/><geom name="b" size=".1" mass="1"/></body>
  <body name="hand" pos="0 1 0" mocap="true"/></worldbody><equality>%s</equality>
  <keyframe><key name="k" qpos="0 0 2 1 0 0 0" mpos="1 2 3"/></keyframe></mujoco>"""


@pytest.mark.parametrize("held", ["<weld body1='a'/>", "<connect body1='a' anchor='0 0 .2'/>"])
def test_what_is_held_in_the_world_is_held_where_it_was_put(held):
    spec = signorini.Spec()
    spec.attach(signorini.Model.from_string(HELD % held), pos=(5, 0, 0), prefix="x/")
    model = spec.compile()
    data = signorini.Data(model)
    signorini.step(model, data, nstep=200)
    assert data.body("x/a").xpos == pytest.approx([5, 0, 1], abs=1e-9)
    data.reset("x/k")
    signorini.kinematics(model, data)
    assert data.body("x/a").xpos == pytest.approx([5, 0, 2]) and data.body("x/hand").xpos == pytest.approx([6, 2, 3])


def test_recompiled_what_stayed_goes_on():
    world = by_hand()
    world.remove("keyframe", "up")
    model = world.compile()
    data = signorini.Data(model, signorini.Settings(assembly_tolerance=1.0))
    data.ctrl[:] = 0.3, 0.1
    data.change(jnt_damping={"elbow": 0.4})
    signorini.step(model, data, nstep=20)
    world.ball(0.05, pos=(2, 0, 0.5), mass=0.2, name="ball")
    world.actuator("pull").remove()
    again, moved = world.recompile(data)
    assert (again.nv, again.nu, moved.time) == (model.nv + 6, 1, data.time)
    for name in model.joint_names:
        assert np.array_equal(moved.joint(name).qpos, data.joint(name).qpos)
        assert np.array_equal(moved.joint(name).qvel, data.joint(name).qvel)
    assert moved.actuator("servo").ctrl == 0.3 and moved.joint("ball free").qpos[2] == 0.5
    assert moved.parameter("jnt_damping")[again.joint("elbow").id] == 0.4
    data.change(actuator_gear={"pull": 0.0})
    signorini.step(model, data, nstep=50)
    signorini.step(again, moved, nstep=50)
    assert np.abs(moved.joint("elbow").qpos - data.joint("elbow").qpos).max() < 1e-9


@pytest.mark.parametrize("scene", ["quadruped", "gripper"])
def test_urdf_has_the_same_mechanics(scene, tmp_path):
    import pathlib

    file = pathlib.Path(__file__).resolve().parents[3] / "scenes" / f"{scene}.xml"
    model = signorini.Model.from_file(file)
    text, left_out, files = signorini.Spec(model).to_urdf()
    (tmp_path / "robot.urdf").write_text(text)
    for name, content in files:
        (tmp_path / name).write_text(content)
    again = signorini.Model.from_urdf(tmp_path / "robot.urdf")
    assert again.nv == model.nv and all(isinstance(line, str) for line in left_out)
    rng, data, other = np.random.default_rng(3), signorini.Data(model), signorini.Data(again)
    armature = np.zeros(model.nv)
    for i, name in enumerate(model.joint_names):
        joint = model.joint(i)
        armature[joint.dofadr : joint.dofadr + joint.nv] = joint.armature
    for _ in range(5):
        for name in model.joint_names:
            q = rng.normal(size=model.joint(name).nq)
            if len(q) >= 4:
                q[-4:] /= np.linalg.norm(q[-4:])
            data.joint(name).qpos, other.joint(name).qpos = q, q
            v = rng.normal(size=model.joint(name).nv)
            data.joint(name).qvel, other.joint(name).qvel = v, v
        order = np.concatenate([np.arange(again.joint(n).dofadr, again.joint(n).dofadr + again.joint(n).nv) for n in model.joint_names])
        mass = signorini.mass_matrix(again, other)[np.ix_(order, order)]
        # URDF has no armature, which is said; a joint that would move no mass gets one with a warning.
        assert np.abs(mass + np.diag(armature) - signorini.mass_matrix(model, data)).max() < 1e-12
        assert np.abs(signorini.bias_force(again, other)[order] - signorini.bias_force(model, data)).max() < 1e-11


def test_urdf_of_a_joint_beside_its_body_and_of_two_joints():
    world = signorini.Spec()
    body = world.add_body("slider", pos=(0.1, 0.2, 0.3), quat=(0.9, 0.1, 0.3, -0.2))
    body.add_joint("slide", "rail", axis=(1, 0, 0), pos=(0.1, 0, 0), ref=0.2, range=(-2, 2))
    body.add_joint("hinge", "turn", axis=(0, 1, 1), pos=(0, 0.3, 0.1), ref=-0.4, range=(-1, 1))
    body.add_geom("box", "block", size=(0.1, 0.2, 0.05), pos=(0, 0, 0.2), quat=(0.7, 0.1, 0, 0.7), mass=2)
    arm = body.add_body("arm", pos=(0.3, 0, 0))
    arm.add_joint("hinge", "elbow", axis=(0, 0, 1), pos=(-0.1, 0, 0))
    arm.add_geom("capsule", "arm", size=(0.02, 0.1), pos=(0.1, 0, 0), mass=1)
    model = world.compile()
    text, left_out, _ = world.to_urdf()
    assert left_out == []
    again = signorini.Model.from_string(text)
    data, other = signorini.Data(model), signorini.Data(again)
    rng = np.random.default_rng(1)
    for _ in range(5):
        data.qpos[:] = other.qpos[:] = rng.normal(size=3)
        data.qvel[:] = other.qvel[:] = rng.normal(size=3)
        assert np.abs(signorini.mass_matrix(again, other) - signorini.mass_matrix(model, data)).max() < 1e-12
        assert np.abs(signorini.bias_force(again, other) - signorini.bias_force(model, data)).max() < 1e-11
        for geom in ("block", "arm"):
            mine, theirs = (signorini.frame_pose(m, d, geom=geom) for m, d in ((model, data), (again, other)))
            assert np.abs(mine[0] - theirs[0]).max() < 1e-12 and np.abs(mine[1] - theirs[1]).max() < 1e-12


def test_scene_helpers():
    world = signorini.scene()
    world.floor(friction=0.5)
    world.box((0.4, 0.3, 0.02), pos=(0, 0, 0.4), name="table")
    made = world.grid(2, 2, 3, spacing=0.15, at=(-0.1, -0.1, 0.5), make=lambda name, pos: world.ball(0.05, pos=pos, mass=0.1, name=name))
    assert len(made) == 12
    bodies = world.load(ARM, pos=(2, 0, 0), prefix="left ")
    assert bodies == ["left upper", "left lower", "left box"]
    model = world.compile()
    assert model.nbody == 1 + 12 + 3
    data = signorini.Data(model)
    assert data.body("grid 11").xpos == pytest.approx([0.05, 0.05, 0.8])
    assert data.body("left upper").xpos == pytest.approx([2, 0, 1])


def test_a_spatial_tendon_along_a_path_is_mujocos():
    mujoco = pytest.importorskip("mujoco", reason="compared with MuJoCo, which is not installed")
    spec = signorini.Spec()
    spec.add_site(name="anchor", pos=(0, 0, 1))
    spec.add_geom(name="drum", type="cylinder", size=(0.1, 0.1), pos=(0.3, 0, 1), quat=(0.7071, 0.7071, 0, 0), contype=0, conaffinity=0)
    above = spec.add_site(name="above", pos=(0.3, 0, 1.2))
    arm = spec.add_body("arm", pos=(0.6, 0, 0.6))
    hinge = arm.add_joint("hinge", axis=(0, 1, 0))
    arm.add_geom("capsule", fromto=(0, 0, 0, 0.3, 0, 0), size=0.02, mass=1)
    tip = arm.add_site(name="tip", pos=(0.25, 0, 0.02))
    cord = spec.add_tendon(path=["anchor", ("drum", above), tip, 2.0, "anchor", "tip"], stiffness=30, range=(0, 2))
    plain = spec.add_tendon({"arm joint": 2.0}, name="plain")
    spec.add_tendon(path=["anchor", spec.geom("drum"), "tip"], name="short")
    spec.add_sensor("tendonpos", tendon=cord)
    spec.add_sensor("tendonpos", tendon=plain)
    spec.add_sensor("tendonpos", tendon="short")
    model = spec.compile()
    theirs = mujoco.MjModel.from_xml_string(spec.to_mjcf()[0])
    data, peer = signorini.Data(model), mujoco.MjData(theirs)
    assert hinge.name == "arm joint"
    for angle in np.linspace(-1.5, 1.5, 13):
        data.qpos, peer.qpos[:] = [angle], angle
        signorini.forward(model, data)
        mujoco.mj_forward(theirs, peer)
        assert np.allclose(data.sensordata, peer.sensordata, rtol=1e-12, atol=1e-12)
    with pytest.raises(signorini.ModelError, match="no site or geom 'tipp'"):
        spec.add_tendon(path=["anchor", "tipp"])
    with pytest.raises(signorini.ModelError, match="either joints"):
        spec.add_tendon()
    assert len(spec.names("tendon")) == 3


def test_what_sticks_is_added_to_a_body():
    spec = signorini.Spec.from_string(
        "<mujoco><worldbody><geom type='box' size='1 1 .1' pos='0 0 1.1'/><body name='b' pos='0 0 .9'><freejoint/><geom name='b' size='.1' mass='1'/>"
        "<site name='s'/></body><camera name='c' pos='0 -2 1' euler='90 0 0' resolution='100 100'/></worldbody></mujoco>"
    )
    spec.add_actuator("adhesion", body="b", ctrlrange=(0, 1), gain=20, name="hold")
    spec.add_sensor("camprojection", site="s", camera="c", name="seen")
    model = spec.compile()
    data = signorini.Data(model)
    data.ctrl[0] = 1.0
    signorini.step(model, data, nstep=20)
    assert abs(data.qpos[2] - 0.9) < 1e-9 and data.body("b").contact_force[2] == pytest.approx(-(20 - 9.81))
    assert data.sensor("seen").shape == (2,)


def test_numbers_that_no_model_has_are_refused_at_once():
    spec = signorini.Spec()
    ball = spec.add_body("ball")
    joint = ball.add_joint("hinge", name="turn")
    geom = ball.add_geom("sphere", name="skin", size=0.1)
    for part, attribute, value in [
        (geom, "friction", -0.1),
        (geom, "size", -1.0),
        (geom, "restitution", 1.5),
        (geom, "margin", float("nan")),
        (joint, "damping", -1.0),
        (joint, "range", (1.0, -1.0)),
        (ball, "mass", -2.0),
    ]:
        before = getattr(part, attribute)
        with pytest.raises(signorini.ProblemError, match=f"^{attribute} of {part.sort} '{part.name}': "):
            setattr(part, attribute, value)
        assert getattr(part, attribute) == before
    spec.compile()


def test_a_body_that_is_not_there_is_the_first_thing_to_say():
    spec = signorini.Spec()
    spec.add_body("ball")
    for add in (spec.add_geom, spec.add_joint):
        with pytest.raises(signorini.ModelError, match="there is no body 'bal'; did you mean 'ball'"):
            add("bal", "no such type")
    with pytest.raises(signorini.ModelError, match="there is no body 'bal'; did you mean 'ball'"):
        spec.add_geom("bal", "sphere", size="wide", frction=1)


def test_keyframes_are_read_and_changed_in_their_place():
    world = by_hand()
    place = np.array(world.compile().qpos0)
    place[:3] += 0.1
    world.add_keyframe("late", qpos=place, time=2)
    world.add_keyframe("last", ctrl=[0.3, 0.4])
    late = world.part("keyframe", "late")
    assert late.time == 2 and np.allclose(late.qpos, place, atol=1e-15)
    late.qpos, late.ctrl = world.compile().qpos0, (0.5, -0.5)
    model = world.compile()
    assert list(model.keyframe_names)[-2:] == ["late", "last"]
    assert model.keyframe("late").ctrl == (0.5, -0.5) and np.allclose(model.keyframe("late").qpos, model.qpos0, atol=1e-15)
    assert (model.keyframe("late").time, model.keyframe("last").ctrl) == (2, (0.3, 0.4))
    before = world.to_mjcf()
    with pytest.raises(signorini.SignoriniError, match="ctrl"):
        late.ctrl = (1, 2, 3)
    with pytest.raises(AttributeError, match="it has time, qpos"):
        late.qposs = (1, 2)
    with pytest.raises(AttributeError, match="remove the part and add another"):
        world.part("equality", 0).solref = 1
    assert world.to_mjcf() == before


def test_what_is_kept_from_touching_is_listed_and_may_touch_again():
    world = by_hand()
    before = world.excludes
    world.add_body("stone", pos=(2, 0, 1)).add_freejoint()
    world.body("stone").add_geom("sphere", size=0.1)
    world.add_exclude("stone", "box")
    assert world.excludes == [*before, ("stone", "box")]
    assert {frozenset(pair) for pair in signorini.Spec(world.compile()).excludes} == {frozenset(pair) for pair in world.excludes}
    world.remove_exclude("box", "stone")
    assert world.excludes == before
    with pytest.raises(signorini.ModelError, match="not kept from touching"):
        world.remove_exclude("box", "stone")
    with pytest.raises(signorini.ModelError, match="stnoe"):
        world.remove_exclude("box", "stnoe")


def test_a_copy_is_edited_alone():
    world = by_hand()
    for other in (copy.deepcopy(world), pickle.loads(pickle.dumps(world))):
        assert other.compile() == world.compile()
        other.geom("box").friction = 0.123
        assert world.geom("box").friction == 0.4
    assert isinstance(copy.copy(signorini.scene()), type(signorini.scene()))


def test_a_body_begins_asleep_or_not():
    def fallen(begins_asleep):
        world = signorini.Spec(name="sleepy")
        world.sleeping = True
        body = world.add_body("ball", pos=(0, 0, 2))
        body.add_joint("free")
        body.add_geom("sphere", size=0.1, mass=1.0)
        assert body.begins_asleep is False
        body.begins_asleep = begins_asleep
        data = signorini.Data(world.compile())
        assert data.model.body("ball").begins_asleep == begins_asleep
        signorini.step(data.model, data, nstep=50)
        assert bool(data.body_asleep[1]) == begins_asleep
        return 2 - data.qpos[2]

    assert fallen(True) == 0 and fallen(False) > 0.01
