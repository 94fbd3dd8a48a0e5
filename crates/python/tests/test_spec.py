"""Models that are edited: what is attached, removed and written is the mechanism it was."""

import doctest

import numpy as np
import pytest

import signorini
import signorini.spec
from signorini import Data, Model, Spec

ARM = """<mujoco><worldbody><body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 1 0"/><geom name="upper" size=".1"/>
  <body name="lower" pos="0 0 -.3"><joint name="elbow" axis="0 1 0"/><geom name="lower" size=".05"/></body></body></worldbody>
  <actuator><motor name="motor" joint="elbow"/></actuator></mujoco>"""


def test_what_is_compiled_is_the_model():
    model = Model.from_string(ARM)
    again = Spec(model).compile()
    assert again == model and np.array_equal(again.body_mass, model.body_mass)


def test_attaching_and_removing():
    spec = Spec(name="two")
    spec.attach(ARM, prefix="a ")
    spec.attach(Model.from_string(ARM), pos=(0, 1, 0), quat=(0, 0, 0, 1), prefix="b ")
    two = spec.compile()
    data, single = Data(two), Data(Model.from_string(ARM))
    data.qpos, single.qpos = [0.3, -0.7, 0.3, -0.7], [0.3, -0.7]
    one = signorini.mass_matrix(single.model, single)
    assert np.allclose(signorini.mass_matrix(two, data), np.kron(np.eye(2), one), atol=1e-14)
    assert spec.remove("body", "a lower") == ["body 'a lower'", "joint 'a elbow'", "geom 'a lower'", "actuator 'a motor'"]
    assert spec.compile().nv == 3
    with pytest.raises(signorini.ModelError, match="no joint 'b elbw'; did you mean 'b elbow'"):
        spec.remove("joint", "b elbw")
    with pytest.raises(signorini.ModelError, match="'b upper' already"):
        spec.attach(ARM, prefix="b ")
    with pytest.raises(signorini.ProblemError, match="no sort of part 'wheel'"):
        spec.remove("wheel", "b elbow")


def test_the_example_of_the_docstring():
    assert doctest.testmod(signorini.spec).failed == 0
