"""Parameters changed without compiling: beside models compiled with them, and beside MuJoCo's where it is there."""

import copy
import pickle

import numpy as np
import pytest

import signorini

WORLD = """<mujoco model="world">
  <option timestep="0.002"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1"/>
    <body name="box" pos="0 0 {height}"><freejoint/><geom name="box" type="box" size="{size} {size} {size}" mass="{mass}" friction="{friction}"/></body>
    <body name="arm" pos="2 0 1"><joint name="hinge" axis="0 1 0" damping="{damping}"/>
      <geom name="arm" type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="0.5"/></body>
  </worldbody>
  <actuator><position name="servo" joint="hinge" kp="{kp}"/></actuator>
</mujoco>"""
PLAIN = {"height": 0.2, "size": 0.1, "mass": 1.0, "friction": 0.8, "damping": 0.1, "kp": 3}


def world(**numbers):
    return signorini.Model.from_string(WORLD.format(**{**PLAIN, **numbers}))


def run(model, data, steps=150):
    data.qvel[:2] = 1.0, 0.3
    data.ctrl[:] = 0.4
    signorini.step(model, data, nstep=steps)
    return np.concatenate([data.qpos, data.qvel])


@pytest.mark.parametrize(
    "numbers, change",
    [
        ({"friction": 0.3}, {"geom_friction": {"box": 0.3, "floor": 0.3}}),
        ({"damping": 0.7}, {"jnt_damping": {"hinge": 0.7}}),
        ({"kp": 9}, {"actuator_kp": 9.0}),
        ({"size": 0.07}, {"geom_size": {"box": (0.07, 0.07, 0.07)}, "body_inertia": {1: np.eye(3) * 2 * 0.07**2 / 3}}),
        ({"mass": 4.0}, {"body_mass": {"box": 4.0}, "body_inertia": {"box": np.eye(3) * 4 * 2 * 0.1**2 / 3}}),
    ],
)
def test_as_compiled(numbers, change):
    # The floor of MJCF has friction 1, so that a change of the box alone would not be felt.
    text = WORLD.replace('type="plane"', 'type="plane" friction="{friction}"') if "friction" in numbers else WORLD
    compiled = signorini.Model.from_string(text.format(**{**PLAIN, **numbers}))
    model = world()
    data = signorini.Data(model)
    data.change(**change)
    expected = run(compiled, signorini.Data(compiled))
    assert np.abs(run(model, data) - expected).max() < 1e-12
    assert model.parameter("body_mass")[1] == 1.0, "the model stays"


def test_values_are_shown_and_cannot_be_written():
    model = world()
    data = signorini.Data(model)
    for name, parameter in signorini.PARAMETERS.items():
        values = data.parameter(name)
        rows = () if parameter.sort == "model" else (len(values),)
        assert values.shape == rows + parameter.shape, name
        with pytest.raises(ValueError, match="read-only"):
            values[...] = 1.0
    data.change(gravity=(0, 0, -1.62), body_mass={"box": 2.0}, geom_friction=0.4)
    assert data.parameter("gravity").tolist() == [0, 0, -1.62]
    assert data.parameter("body_mass").tolist() == [0, 2, 0.5]
    assert data.parameter("geom_friction")[:, 0].tolist() == [0.4] * 3
    assert data.parameter("geom_friction")[0, 1] == model.parameter("geom_friction")[0, 1]


def test_questions_see_the_change():
    model = world()
    data = signorini.Data(model)
    before = signorini.mass_matrix(model, data)[0, 0]
    gap = signorini.distance(model, data, "floor", "box").distance
    data.change(body_mass={"box": 3.0}, geom_size={"box": (0.15, 0.15, 0.15)}, body_pos={"arm": (3, 0, 1)})
    assert (before, signorini.mass_matrix(model, data)[0, 0]) == (1.0, 3.0)
    assert signorini.distance(model, data, "floor", "box").distance == pytest.approx(gap - 0.05, abs=1e-12)
    assert data.body("arm").xpos[0] == 3.0
    signorini.step(model, data)
    data.change(body_mass=1.0)
    assert data.ncon == 0 and data.parameter("body_mass").tolist() == [0, 1, 1]


@pytest.mark.parametrize(
    "change, error, words",
    [
        ({"body_mas": 1.0}, signorini.ProblemError, "did you mean 'body_mass'"),
        ({"body_mass": {"bix": 1.0}}, KeyError, "'box'"),
        ({"body_mass": [1.0, 2.0]}, signorini.ProblemError, r"expected \(3,\)"),
        ({"body_mass": {"box": -1.0}}, signorini.ModelError, "body 'box': mass must be"),
        ({"body_mass": [1.0, 2.0, 3.0]}, signorini.ModelError, "body 'world'"),
        ({"geom_size": {"floor": (1, 1, 1)}}, signorini.ModelError, "geom 'floor': geom_size cannot be changed"),
        ({"gravity": {"x": 1.0}}, signorini.ProblemError, "as a whole"),
        ({"body_mass": "heavy"}, signorini.ProblemError, "cannot be read as numbers"),
    ],
)
def test_errors_name_what_is_wrong(change, error, words):
    model = world()
    data = signorini.Data(model)
    with pytest.raises(error, match=words):
        data.change(**change)
    assert data.parameter("body_mass").tolist() == model.parameter("body_mass").tolist()


def test_copies_and_pickles_keep_the_change():
    model = world()
    data = signorini.Data(model)
    data.change(body_mass={"box": 2.5}, gravity=(0, 0, -5))
    other = pickle.loads(pickle.dumps(data))
    again = copy.copy(data)
    expected = run(model, data)
    assert np.array_equal(run(other.model, other), expected)
    assert np.array_equal(run(model, again), expected)


def test_recordings_keep_the_change(tmp_path):
    model = world()
    data = signorini.Data(model)
    data.change(body_mass={"box": 2.5}, geom_friction=0.2, actuator_forcerange=[[-2, 2]])
    with data.record(tmp_path / "run.sgr"):
        run(model, data)
        with pytest.raises(RuntimeError, match="being recorded"):
            data.change(body_mass=1.0)
    check = signorini.load_recording(tmp_path / "run.sgr").check()
    assert check.ok and check.steps == 150
    assert signorini.load_recording(tmp_path / "run.sgr").check(model=model).ok


def test_batches_have_their_own():
    model = world()
    batch = signorini.Batch(model, 3, nthread=1)
    masses = np.tile(model.parameter("body_mass"), (3, 1))
    masses[:, 1] = 1.0, 2.0, 3.0
    batch.change(body_mass=masses, geom_friction={"box": [0.9, 0.5, 0.1]})
    batch.change([1], gravity=(0, 0, -3), geom_friction={"floor": 0.0})
    assert batch.parameter("body_mass").tolist() == masses.tolist()
    assert batch.parameter("geom_friction")[:, 1, 0].tolist() == [0.9, 0.5, 0.1]
    batch.qvel[:, :2] = 1.0, 0.3
    batch.ctrl[:] = 0.4
    batch.step(150)
    for i in range(3):
        data = signorini.Data(model)
        data.change(body_mass=masses[i], geom_friction={"box": [0.9, 0.5, 0.1][i]})
        if i == 1:
            data.change(gravity=(0, 0, -3), geom_friction={"floor": 0.0})
        assert np.array_equal(run(model, data)[: model.nq], batch.qpos[i])
    with pytest.raises(signorini.ModelError, match="simulation 2: body 'box'"):
        batch.change([0, 2], body_mass={"box": [1.0, -1.0]})
    with pytest.raises(IndexError):
        batch.change([3], body_mass={"box": 1.0})


def test_beside_mujoco():
    mujoco = pytest.importorskip("mujoco")
    text = WORLD.format(**PLAIN)
    theirs = mujoco.MjModel.from_xml_string(text)
    model, rng = signorini.Model.from_string(text), np.random.default_rng(5)
    data, peer = signorini.Data(model), mujoco.MjData(theirs)
    data.change(gravity=(1, 2, -3), body_mass=[0, 2, 3], body_ipos={"arm": (0.1, 0, 0)}, jnt_armature={"hinge": 0.3})
    theirs.opt.gravity[:] = 1, 2, -3
    theirs.body_mass[:] = 0, 2, 3
    theirs.body_ipos[2] = 0.1, 0, 0
    theirs.dof_armature[6] = 0.3
    mujoco.mj_setConst(theirs, peer)
    for _ in range(5):
        q = rng.normal(size=model.nq)
        q[3:7] /= np.linalg.norm(q[3:7])
        data.qpos[:], data.qvel[:] = q, rng.normal(size=model.nv)
        peer.qpos[:], peer.qvel[:] = data.qpos, data.qvel
        mujoco.mj_forward(theirs, peer)
        assert np.abs(signorini.bias_force(model, data) - peer.qfrc_bias).max() < 1e-12
        product, vector = np.zeros(model.nv), rng.normal(size=model.nv)
        mujoco.mj_mulM(theirs, peer, product, vector)
        assert np.abs(signorini.mass_matrix(model, data) @ vector - product).max() < 1e-12
