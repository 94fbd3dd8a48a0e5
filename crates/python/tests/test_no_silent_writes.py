"""What is written has an effect, or an error says why not."""

import numpy as np
import pytest

import signorini
from signorini import Data, Model

ARM = """<mujoco>
  <worldbody><geom name="floor" type="plane"/><site name="corner"/>
    <body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 1 0" range="-1 1"/><geom size=".1"/>
      <body name="lower" pos="0 0 -.4"><joint name="elbow" axis="0 1 0"/><geom size=".1"/></body></body></worldbody>
  <actuator><motor name="motor" joint="elbow" ctrlrange="-1 1"/></actuator>
  <sensor><clock/></sensor><keyframe><key name="home" qpos="0 1"/></keyframe>
</mujoco>"""


@pytest.fixture
def model():
    return Model.from_mjcf(ARM)


def test_arrays_of_a_model_are_read_only(model):
    arrays = [name for name in dir(Model) if not name.startswith("_") and isinstance(getattr(model, name), np.ndarray)]
    assert len(arrays) >= 11 and {"gravity", "body_mass", "qpos0", "jnt_range"} <= set(arrays)
    for name in arrays:
        with pytest.raises(ValueError, match="read-only"):
            getattr(model, name)[...] = 1
        with pytest.raises(AttributeError):
            setattr(model, name, 1)


def test_numbers_of_parts_are_tuples(model):
    parts = [model.body(1), model.joint(0), model.geom(1), model.actuator(0), model.keyframe(0)]
    kept = [getattr(part, name) for part in parts for name in dir(part) if not name.startswith("_")]
    assert not [value for value in kept if isinstance(value, list)] and sum(isinstance(v, tuple) for v in kept) >= 12


def test_numbers_of_a_spec_are_tuples(model):
    spec = signorini.Spec(model)
    parts = [spec.body(1), spec.joint(0), spec.geom(1), spec.site(0), spec.actuator(0), spec.part("keyframe", 0)]
    kept = [spec.gravity, *(getattr(part, name) for part in parts for name in spec._attributes(part.sort))]
    assert not [value for value in kept if isinstance(value, (list, np.ndarray))] and sum(isinstance(v, tuple) for v in kept) >= 15
    assert all(isinstance(row, tuple) for row in spec.body(1).inertia)


def test_results_of_a_data_are_read_only_and_go_on_changing(model):
    data = Data(model)
    results = ["qacc", "xpos", "xquat", "xmat", "xipos", "linear_velocity", "angular_velocity"]
    views = [getattr(data, name) for name in results]
    before = [view.copy() for view in views]
    for view in views:
        with pytest.raises(ValueError, match="read-only"):
            view[...] = 1
    data.qvel[:] = 1
    signorini.step(model, data, 5)
    assert all(not np.array_equal(view, old) for view, old in zip(views, before))


def test_whatever_can_be_written_to_is_what_it_belongs_to():
    """Every array of every object: an array that is made when it is asked for would take what is written and forget it."""
    ball = '<body pos="1 0 0.1"><freejoint/><geom size=".1"/></body></worldbody>'
    model = Model.from_mjcf(ARM.replace("</worldbody>", ball).replace('<keyframe><key name="home" qpos="0 1"/></keyframe>', ""))
    data, batch = Data(model), signorini.Batch(model, 2)
    signorini.step(model, data, 3)
    batch.step(3)
    assert len(data.contact) > 0
    things = [data, batch, data.contact, data.limit, data.problem, data.solution, data.body(1), data.joint(0), data.actuator(0)]
    seen = 0
    for thing in things:
        for name in (name for name in dir(thing) if not name.startswith("_")):
            array = getattr(thing, name)
            if not isinstance(array, np.ndarray):
                continue
            seen += 1
            if array.flags.writeable and array.size:
                old = array.flat[0]
                array.flat[0] = new = 0 if old == 1 else 1
                assert getattr(thing, name).flat[0] == new, f"{type(thing).__name__}.{name} forgets what is written to it"
                array.flat[0] = old
    assert seen > 50


def test_a_misspelt_attribute_is_named_with_the_nearest_one(model):
    data, batch = Data(model), signorini.Batch(model, 2)
    misspelt = [(signorini.Spec(model), "gravty", "gravity"), (signorini.scene(), "timestp", "timestep"), (data, "qps", "qpos"), (data, "crtl", "ctrl"), (batch, "qvell", "qvel"), (model, "gravty", "gravity"),
                (data.joint("elbow"), "qpost", "qpos"), (data.actuator("motor"), "control", "ctrl"), (data.body(1), "xposs", "xpos")]
    for thing, name, near in misspelt:
        with pytest.raises(AttributeError, match=f"no attribute '{name}'.*'{near}'"):
            setattr(thing, name, 1)
        assert not hasattr(thing, name)
    data.qpos = [0.1, 0.2]
    data.joint("elbow").qpos = 0.3
    assert data.qpos.tolist() == [0.1, 0.3]


def test_a_misspelt_attribute_of_a_file_is_named():
    text = "<mujoco><worldbody>\n<geom typ='plane'/></worldbody></mujoco>"
    with pytest.raises(signorini.ModelError, match="<geom> has no attribute 'typ'; did you mean 'type'") as error:
        Model.from_mjcf(text)
    assert error.value.line == 2


def test_a_body_is_asked_for_by_name_or_index(model):
    data = Data(model)
    for key in ("lower", 2, -1, np.int64(2)):
        linear, angular = signorini.jacobian(model, data, key)
        assert linear[:, 1].tolist() == [0, 0, 0] and angular[:, 1].tolist() == [0, 1, 0] and linear[0, 0] == pytest.approx(-0.4)
    with pytest.raises(KeyError, match="no body 'lowr'; valid names: 'lower'"):
        signorini.jacobian(model, data, "lowr")
    with pytest.raises(IndexError, match="body 3: the model has 3"):
        signorini.jacobian(model, data, 3)
    with pytest.raises(KeyError, match="no body 'lowr'"):
        data.contact.between("lowr", "upper")


def test_none_is_no_number(model):
    data = Data(model)
    for name in ("qpos", "qvel", "act", "ctrl", "qfrc_applied", "xfrc_applied", "mocap_pos", "mocap_quat"):
        before = getattr(data, name).copy()
        for value in (None, [None], [0.5, None]):
            with pytest.raises(TypeError, match=f"{name}: None"):
                setattr(data, name, value)
        assert np.array_equal(getattr(data, name), before)
    for part, names in ((data.joint("elbow"), ("qpos", "qvel", "qfrc_applied")), (data.actuator("motor"), ("ctrl",))):
        for name in names:
            with pytest.raises(TypeError, match=f"{name}: None"):
                setattr(part, name, None)
    data.qpos = [1, 2]
    assert data.qpos.tolist() == [1.0, 2.0]
