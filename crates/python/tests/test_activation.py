"""Actuators that remember: activations in arrays, states, keyframes and batches."""

import numpy as np
import signorini

MODEL = """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody><body>
  <joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1" mass="2"/></body></worldbody>
  <actuator><motor joint="rail"/><general name="lag" joint="rail" dyntype="filterexact" dynprm="0.05"/></actuator>
  <keyframe><key name="wound" act="0.5" ctrl="0 0.25"/></keyframe></mujoco>"""


def test_activations_are_a_live_view_and_part_of_the_state():
    model = signorini.Model.from_mjcf(MODEL)
    data = signorini.Data(model)
    assert (model.nu, model.na, data.act.shape) == (2, 1, (1,))
    data.ctrl[1] = 1.0
    signorini.step(model, data)
    wanted = 1 - np.exp(-0.2)
    np.testing.assert_allclose(data.act, wanted, rtol=1e-14)
    assert data.qvel[0] == 0.0  # The force of the step was made with the activation before it.
    saved = data.get_state(warm_start=False)
    signorini.step(model, data)
    np.testing.assert_allclose(data.qvel, wanted / 2 * 0.01, rtol=1e-14)
    after = data.get_state()
    data.set_state(saved)
    np.testing.assert_array_equal(data.act, saved[3:4])
    signorini.step(model, data)
    np.testing.assert_array_equal(data.get_state()[:7], after[:7])
    data.act[0] = 0.0
    signorini.step(model, data)
    np.testing.assert_allclose(data.act, wanted, rtol=1e-14)


def test_keyframes_and_batches_have_activations():
    model = signorini.Model.from_mjcf(MODEL)
    assert model.keyframe("wound").act == (0.5,)
    data = signorini.Data(model)
    data.reset("wound")
    batch = signorini.Batch(model, 3)
    batch.reset(keyframe="wound")
    np.testing.assert_array_equal(batch.act, np.full((3, 1), 0.5))
    batch.act[1] = 0.25
    batch.step()
    signorini.step(model, data)
    np.testing.assert_array_equal(batch.act[:, 0], [data.act[0], 0.25, data.act[0]])
    (recorded,) = batch.rollout(nstep=4, record=["act"])
    assert recorded.shape == (3, 4, 1)
    np.testing.assert_array_equal(recorded[:, -1], batch.act)
