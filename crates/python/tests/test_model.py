"""Models: loading, names, warnings, errors, pickles."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import signorini
from conftest import SCENES, mjcf

URDF = """<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
</robot>"""

SDF = """<sdf version="1.7"><model name="arm">
  <link name="base"/>
  <link name="upper"><inertial><mass>1</mass></inertial></link>
  <joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="shoulder" type="continuous"><parent>base</parent><child>upper</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>"""


def test_formats_are_told_apart(tmp_path):
    assert signorini.Model.from_string(URDF).joint_names == ["shoulder"]
    assert signorini.Model.from_urdf(URDF).name == "arm"
    path = tmp_path / "arm.urdf"
    path.write_text(URDF)
    fixed = signorini.Model.from_urdf(path)
    with pytest.warns(signorini.ModelWarning, match="'shoulder' moves nothing that other joints do not move"):
        floating = signorini.Model.from_file(str(path), floating_base=True)
    assert (fixed.nv, floating.nv) == (1, 7)
    with pytest.raises(signorini.ModelError, match="<mujoco>"):
        signorini.Model.from_mjcf("<world/>")
    path = tmp_path / "arm.sdf"
    path.write_text(SDF)
    for model in (signorini.Model.from_string(SDF), signorini.Model.from_sdf(SDF), signorini.Model.from_sdf(path)):
        assert (model.name, model.joint_names, model.nv) == ("arm", ["shoulder"], 1)


CUBE = """<robot name="cube"><link name="cube"><inertial><mass value="2"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link></robot>"""


def test_a_urdf_lies_on_the_floor_that_was_asked_for_and_slides_with_the_friction_that_was_asked_for():
    model = signorini.Model.from_urdf(CUBE, floating_base=True, floor=True, friction=0.25)
    assert model.geom_names == ["floor", "cube"] and model.geom("cube").friction == 0.25
    data = signorini.Data(model)
    data.joint("floating_base").qpos[2] = 0.1
    data.joint("floating_base").qvel[0] = 1.0
    signorini.step(model, data, nstep=10)
    force = data.body("cube").contact_force
    assert force == pytest.approx([-0.25 * 2 * 9.81, 0, 2 * 9.81], abs=1e-8)
    assert data.body("world").contact_force == pytest.approx(-force)
    assert data.contact.force_world.sum(axis=0) == pytest.approx(force)
    assert pickle.loads(pickle.dumps(model)) == model
    with pytest.raises(signorini.ModelError, match="friction"):
        signorini.Model.from_urdf(CUBE, friction=-1)


def test_a_start_inside_the_floor_is_announced_once():
    model = signorini.Model.from_urdf(CUBE, floating_base=True, floor=True)
    data = signorini.Data(model)
    with pytest.warns(signorini.OverlapWarning, match=r"no more than 0.25 m/s: 'floor' and 'cube' by 100.000 mm"):
        signorini.step(model, data)
    assert data.qvel[2] == pytest.approx(0.25)
    signorini.step(model, data, nstep=10)
    data.reset()
    data.joint("floating_base").qpos[2] = 0.1
    signorini.step(model, data, nstep=10)
    data.joint("floating_base").qpos[2] -= 0.0015
    signorini.step(model, data)


def test_a_floor_under_mjcf_is_reported_as_not_made():
    with pytest.warns(signorini.ModelWarning, match="floor"):
        model = signorini.Model.from_string("<mujoco><worldbody/></mujoco>", floor=True)
    assert model.ngeom == 0


def test_packages_are_found_from_a_file_named_without_its_folder(tmp_path, monkeypatch):
    (tmp_path / "cube" / "meshes").mkdir(parents=True)
    corners = [f"v {x} {y} {z}" for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = ["f 1 2 4 3", "f 5 7 8 6", "f 1 5 6 2", "f 3 4 8 7", "f 1 3 7 5", "f 2 6 8 4"]
    (tmp_path / "cube" / "meshes" / "cube.obj").write_text("\n".join(corners + faces))
    mesh = '<mesh filename="package://cube/meshes/cube.obj"/>'
    (tmp_path / "cube" / "cube.urdf").write_text(CUBE.replace('<box size="0.2 0.2 0.2"/>', mesh))
    monkeypatch.chdir(tmp_path / "cube")
    assert signorini.Model.from_urdf("cube.urdf").geom("cube").type == "convex mesh"


def test_urdf_options(tmp_path):
    hand = ('<link name="hand"/><joint name="wrist" type="fixed"><parent link="upper"/><child link="hand"/></joint>'
            '<transmission name="t"><type>x</type><joint name="shoulder"/><actuator name="m"/></transmission></robot>')
    text = URDF.replace("</robot>", hand)
    plain, merged = (signorini.Model.from_urdf(text, merge_fixed_joints=merge) for merge in (False, True))
    assert ("hand" in plain.body_names, "hand" in merged.body_names) == (True, False)
    assert plain.actuator("shoulder").joint == 0
    srdf = tmp_path / "arm.srdf"
    srdf.write_text("<robot name='arm'><disable_collisions link1='base' link2='upper'/></robot>")
    model = signorini.Model.from_urdf(text, srdf=srdf, self_collision=False)
    assert pickle.loads(pickle.dumps(model)) == model and model != plain


def test_sizes_and_parts(pendulum):
    assert (pendulum.nq, pendulum.nv, pendulum.nu, pendulum.nbody, pendulum.njnt, pendulum.nkey) == (1, 1, 1, 2, 1, 1)
    hinge, arm, motor = pendulum.joint("hinge"), pendulum.body("arm"), pendulum.actuator("motor")
    assert (hinge.type, hinge.qposadr, hinge.nv, hinge.body) == ("hinge", 0, 1, 1)
    assert hinge.range == pytest.approx(np.radians([-180, 170]))
    assert (arm.mass, arm.com, arm.parent, arm.joints) == (2.0, (0.0, 0.0, -0.5), "world", ("hinge",))
    assert (motor.type, motor.joint, motor.gear) == ("motor", 0, 1.0)
    assert pendulum.keyframe("level").ctrl == (3.0,)
    assert pendulum.body(-1).name == "arm" and pendulum.body_mass.tolist() == [0.0, 2.0]


def test_an_unknown_format_is_named():
    with pytest.raises(ValueError, match="format is 'xx': it must be one of auto, mjcf, urdf, sdf"):
        signorini.Model.from_string("<mujoco/>", format="xx")


def test_an_unknown_name_lists_the_names_that_exist_the_closest_first():
    model = mjcf("".join(f"<body name='{n}'><joint name='j_{n}'/><geom size='.1'/></body>" for n in ("trunk", "hip", "knee")))
    with pytest.raises(KeyError, match="no body 'trnk'; valid names: 'trunk', .*'world'"):
        model.body("trnk")
    with pytest.raises(KeyError, match="no joint 'knee'; valid names: 'j_knee'"):
        signorini.Data(model).joint("knee")
    with pytest.raises(KeyError, match="the model has none"):
        model.actuator("motor")
    for wrong in (1.0, None):
        with pytest.raises(TypeError, match="a body is asked for by its name or its index, not by"):
            model.body(wrong)
    with pytest.raises(TypeError, match=r"a part is asked for by its name or its index, not by 1\.5"):
        signorini.center_of_mass(model, signorini.Data(model), 1.5)
    with pytest.raises(IndexError, match="the model has 4"):
        model.body(4)


def test_what_changes_the_motion_is_a_warning_at_its_line(tmp_path):
    path = tmp_path / "soft.xml"
    path.write_text("<mujoco>\n<worldbody>\n<geom size='1' solref='.01 1'/>\n</worldbody>\n<visual/>\n</mujoco>")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = signorini.Model.from_file(path)
    [warning] = caught
    assert (warning.category, warning.lineno, warning.filename) == (signorini.ModelWarning, 3, str(path))
    assert isinstance(warning.message, signorini.ModelWarning) and warning.message.element == "geom"
    assert [(w.element, w.changes_motion) for w in model.import_report] == [("geom", True), ("visual", False)]


def test_errors_carry_file_and_line(tmp_path):
    path = tmp_path / "broken.xml"
    path.write_text("<mujoco>\n<worldbody>\n<geom size='one'/>\n</worldbody>\n</mujoco>")
    with pytest.raises(signorini.ModelError, match="size") as error:
        signorini.Model.from_file(path)
    assert (error.value.file, error.value.line) == (str(path), 3) and isinstance(error.value, ValueError)
    with pytest.raises(signorini.ModelError, match="cannot read") as error:
        signorini.Model.from_file(tmp_path / "absent.xml")
    assert error.value.line is None


def test_a_model_is_copied_as_itself_and_pickled_whole(tmp_path):
    text = (SCENES / "stack_of_ten.xml").read_text()
    path = tmp_path / "stack.xml"
    path.write_text(text)
    model = signorini.Model.from_file(path)
    assert copy.copy(model) is model and copy.deepcopy(model) is model
    path.unlink()
    pickled = pickle.dumps(model)
    again = pickle.loads(pickled)
    assert again == model and hash(again) == hash(model) and again is not model
    assert again.body_names == model.body_names and again != mjcf("")


def test_a_pickle_whose_files_have_changed_is_refused(tmp_path):
    part = tmp_path / "part.xml"
    body = "<mujoco><worldbody><body><freejoint/><geom size='{}'/></body></worldbody></mujoco>"
    part.write_text(body.format(0.1))
    main = tmp_path / "main.xml"
    main.write_text("<mujoco><include file='part.xml'/></mujoco>")
    pickled = pickle.dumps(signorini.Model.from_file(main))
    assert pickle.loads(pickled).geom(0).size == (0.1,)
    part.write_text(body.format(0.2))
    with pytest.raises(signorini.ModelError, match="load it anew"):
        pickle.loads(pickled)


def test_reprs_say_something(cards):
    assert "house of cards" in repr(cards) and "nv 105, 90" in repr(cards)
    assert "<table>" in cards._repr_html_() and "<script>" not in mjcf("")._repr_html_()


def test_meshes_with_points_along_their_edges_are_taken():
    """Three points of an edge, beside it by rounding, make triangles that look anywhere; boxes with such were refused as without volume."""
    places = np.linspace(-0.35, 0.35, 4)
    grid = np.stack(np.meshgrid(places, places, places), -1).reshape(-1, 3)
    grid = grid[np.abs(grid).max(axis=1) > 0.349]
    sin, cos = np.sin(0.3), np.cos(0.3)
    turned = grid @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    for seed in range(1000):
        points = turned + np.random.default_rng(seed).normal(scale=1e-15 if seed % 2 else 1e-16, size=grid.shape)
        model = signorini.Model.from_string(
            f"<mujoco><asset><mesh name='box' vertex='{' '.join(map(repr, points.ravel().tolist()))}'/></asset>"
            "<worldbody><geom type='plane'/><body><freejoint/><geom type='mesh' mesh='box'/></body></worldbody></mujoco>")
        signorini.Data(model)
