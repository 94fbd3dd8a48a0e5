"""Spatial tendons, tendon equalities and muscles: lengths, rates and forces beside MuJoCo, and closed forms."""

import numpy as np
import pytest

import signorini

mujoco = pytest.importorskip("mujoco", reason="compared with MuJoCo, which is not installed")


def random_world(rng):
    """Two arms of three joints with sites; spheres and cylinders on the world and on links; paths of all sorts."""

    def numbers(low, high, n=3):
        return " ".join(str(float(x)) for x in rng.uniform(low, high, n))

    def link(name, inner):
        return f"""<body name='{name}' pos='{numbers(-0.3, 0.3)}' euler='{numbers(-90, 90)}'>
          <joint name='{name}' axis='{numbers(-1, 1)}'/><geom type='capsule' size='0.02 0.1' contype='0' conaffinity='0'/>
          <site name='{name}_a' pos='{numbers(-0.3, 0.3)}'/><site name='{name}_b' pos='{numbers(-0.3, 0.3)}'/>{inner}</body>"""

    arms = "".join(link(f"{arm}0", link(f"{arm}1", link(f"{arm}2", ""))) for arm in "pq")
    links = [f"{arm}{k}" for arm in "pq" for k in range(3)]
    sites = [f"{link}_{end}" for link in links for end in "ab"] + ["fixed_a", "fixed_b"]
    shapes = "".join(
        f"<geom name='w{k}' type='{sort}' size='{size}' pos='{numbers(-0.3, 0.3)}' euler='{numbers(-90, 90)}' contype='0' conaffinity='0'/>"
        f"<site name='near{k}' pos='{numbers(-0.5, 0.5)}'/>"
        for k, (sort, size) in enumerate([("sphere", "0.15"), ("cylinder", "0.12 0.5"), ("sphere", "0.05"), ("cylinder", "0.25 1")])
    )
    inside = "<geom name='ring' type='cylinder' size='0.1 1' contype='0' conaffinity='0'/><site name='middle' pos='0.02 0.01 0'/>"
    tendons, sensors = "", ""
    for k in range(24):
        first, second, third = rng.choice(sites, 3, replace=False)
        wrap = ["", "<geom geom='w{0}'/>", "<geom geom='w{0}' sidesite='near{0}'/>", "<geom geom='ring' sidesite='middle'/>"][k % 4]
        path = f"<site site='{first}'/>{wrap.format(rng.integers(4))}<site site='{second}'/>"
        if k % 3 == 0:
            path += f"<pulley divisor='2'/><site site='{third}'/><site site='{first}'/>"
        tendons += f"<spatial name='t{k}'>{path}</spatial>"
        sensors += f"<tendonpos tendon='t{k}'/><tendonvel tendon='t{k}'/>"
    return f"""<mujoco><worldbody>{shapes}{inside}<site name='fixed_a' pos='0 0 0.4'/><site name='fixed_b' pos='0.4 0 0'/>{arms}
      </worldbody><tendon>{tendons}</tendon><sensor>{sensors}</sensor></mujoco>"""


@pytest.mark.parametrize("seed", range(6))
def test_lengths_and_rates_are_mujocos(seed):
    rng = np.random.default_rng(seed)
    world = random_world(rng)
    theirs = mujoco.MjModel.from_xml_string(world)
    peer, model = mujoco.MjData(theirs), signorini.Model.from_string(world)
    assert model.import_report == []
    data, around = signorini.Data(model), 0
    for _ in range(40):
        data.qpos, data.qvel = rng.uniform(-3, 3, model.nq), rng.normal(size=model.nv)
        peer.qpos[:], peer.qvel[:] = data.qpos, data.qvel
        signorini.forward(model, data)
        mujoco.mj_forward(theirs, peer)
        apart = np.abs(np.array(data.sensordata) - peer.sensordata).reshape(24, 2)
        assert apart[:, 0].max() < 1e-9
        # Where a tendon may run inside, MuJoCo ends its search for the point at 1e-6.
        assert apart[0::4, 1].max() < 1e-9 and apart[1::4, 1].max() < 1e-9 and apart[:, 1].max() < 1e-5
        around += np.count_nonzero(peer.wrap_obj >= 0)
    assert around > 100
    # Written and read again it is the same.
    again = signorini.Model.from_string(signorini.Spec(model).to_mjcf()[0])
    other = signorini.Data(again)
    other.qpos, other.qvel = data.qpos, data.qvel
    signorini.forward(again, other)
    assert np.allclose(other.sensordata, data.sensordata, rtol=1e-12, atol=1e-12)


MUSCLES = """<mujoco><option timestep='1e-12' gravity='0 0 0'/><worldbody>
  <site name='root' pos='0 0.05 0.3'/>
  <body name='thigh'><joint name='knee' axis='0 1 0' range='-60 80' limited='true'/>
    <geom type='capsule' size='0.03' fromto='0 0 0 0 0 -0.4' density='9000'/><site name='insertion' pos='0.04 0 -0.2'/></body>
  </worldbody>
  <tendon><spatial name='string'><site site='root'/><site site='insertion'/></spatial></tendon>
  <actuator>
    <muscle name='given' tendon='string' force='300' lengthrange='0.3 0.6' range='0.7 1.1' lmin='0.45' lmax='1.5' vmax='3' fpmax='1.1' fvmax='1.3'/>
    <muscle name='scaled' joint='knee' scale='50' gear='0.05' lengthrange='-0.06 0.07' timeconst='0.02 0.05' tausmooth='0.2'/>
    <general name='general' joint='knee' gear='-0.04' dyntype='muscle' gaintype='muscle' biastype='muscle' dynprm='0.01 0.03'
      gainprm='0.75 1.05 400 200 0.5 1.6 1.5 1.3 1.2' biasprm='0.75 1.05 400 200 0.5 1.6 1.5 1.3 1.2' lengthrange='-0.06 0.05'/>
  </actuator><sensor><actuatorfrc actuator='given'/><actuatorfrc actuator='scaled'/><actuatorfrc actuator='general'/></sensor></mujoco>"""


def test_muscles_are_mujocos():
    theirs = mujoco.MjModel.from_xml_string(MUSCLES)
    peer, model = mujoco.MjData(theirs), signorini.Model.from_string(MUSCLES)
    assert model.import_report == []
    data, rng, pulled = signorini.Data(model), np.random.default_rng(5), 0
    for _ in range(300):
        mujoco.mj_resetData(theirs, peer)
        data.reset()
        data.qpos, data.qvel, data.act, data.ctrl = rng.uniform(-1, 1.3, 1), rng.normal(size=1), rng.uniform(size=3), rng.uniform(-0.2, 1.2, 3)
        peer.qpos[:], peer.qvel[:], peer.act[:], peer.ctrl[:] = data.qpos, data.qvel, data.act, data.ctrl
        signorini.step(model, data)
        mujoco.mj_step(theirs, peer)
        assert np.allclose(data.sensordata, peer.sensordata, rtol=1e-9, atol=1e-7)
        pulled += np.count_nonzero(peer.sensordata < -1)
    assert pulled > 300


def test_activations_are_mujocos():
    world = MUSCLES.replace("1e-12", "0.002")
    theirs = mujoco.MjModel.from_xml_string(world)
    peer, model = mujoco.MjData(theirs), signorini.Model.from_string(world)
    data, rng = signorini.Data(model), np.random.default_rng(6)
    for _ in range(50):
        data.ctrl = peer.ctrl[:] = rng.uniform(-0.2, 1.2, 3)
        signorini.step(model, data)
        mujoco.mj_step(theirs, peer)
        assert np.allclose(data.act, peer.act, atol=1e-12)


def test_coupled_tendons():
    world = """<mujoco><option gravity='0 0 0'/><worldbody><site name='o'/>
      <body><joint name='a' type='slide' axis='1 0 0' damping='0.1'/><geom size='0.1' pos='1 0 0'/><site name='s' pos='1 0 0'/></body>
      <body><joint name='b' type='slide' axis='0 1 0' damping='0.1'/><geom size='0.1' pos='0 2 0'/><site name='t' pos='0.5 2 0'/></body>
      </worldbody>
      <tendon><fixed name='f'><joint joint='a' coef='2'/></fixed><spatial name='p'><site site='o'/><site site='t'/></spatial></tendon>
      <equality><tendon tendon1='p' tendon2='f' polycoef='0 0.5 0.25 0 0'/></equality>
      <actuator><motor joint='a'/></actuator></mujoco>"""
    model = signorini.Model.from_string(world)
    assert model.import_report == []
    data = signorini.Data(model)
    data.ctrl = [30.0]
    for _ in range(200):
        signorini.step(model, data)
    a, b = data.qpos
    leading = 2 * a
    assert leading > 0.1
    assert np.hypot(0.5, 2 + b) - np.hypot(0.5, 2) == pytest.approx(0.5 * leading + 0.25 * leading**2, abs=1e-4)
    theirs = mujoco.MjModel.from_xml_string(world)
    peer = mujoco.MjData(theirs)
    peer.qpos[:] = data.qpos
    mujoco.mj_forward(theirs, peer)
    assert abs(peer.efc_pos[0]) < 1e-4


def test_what_actuators_pull_tendons_with_is_mujocos():
    """Motors, a servo and a damper with gears on a spatial and a fixed tendon, and one on a joint, which pulls no tendon."""
    world = """<mujoco><option timestep='1e-9'/><worldbody><site name='root' pos='0 0.1 0.3'/>
      <body><joint name='a' axis='0 1 0'/><geom size='0.1' pos='0 0 -0.2'/><site name='end' pos='0.05 0 -0.2'/>
        <body pos='0 0 -0.4'><joint name='b' axis='0 1 0'/><geom size='0.1' pos='0 0 -0.2'/></body></body></worldbody>
      <tendon><spatial name='string'><site site='root'/><site site='end'/></spatial>
        <fixed name='sum'><joint joint='a' coef='0.3'/><joint joint='b' coef='-0.7'/></fixed></tendon>
      <actuator><motor tendon='string' gear='3'/><motor tendon='sum' gear='-2'/><position tendon='string' kp='40' gear='0.5'/>
        <motor joint='a' gear='5'/><velocity tendon='sum' kv='7'/></actuator>
      <sensor><tendonactuatorfrc tendon='string'/><tendonactuatorfrc tendon='sum' cutoff='2'/></sensor></mujoco>"""
    theirs, model = mujoco.MjModel.from_xml_string(world), signorini.Model.from_string(world)
    assert model.import_report == [] and model.nsensor == 2
    again = signorini.Model.from_string(signorini.Spec(model).to_mjcf()[0])
    rng, peer, cut = np.random.default_rng(0), mujoco.MjData(theirs), 0
    for _ in range(30):
        q, v, u = rng.uniform(-1, 1, 2), rng.normal(size=2), rng.normal(size=5)
        peer.qpos[:], peer.qvel[:], peer.ctrl[:] = q, v, u
        mujoco.mj_forward(theirs, peer)
        cut += abs(peer.sensordata[1]) == 2
        for own in (model, again):
            data = signorini.Data(own)
            data.qpos, data.qvel, data.ctrl = q, v, u
            signorini.step(own, data)
            # The servo and the damper act with the velocity at the end of the step of a nanosecond.
            assert np.allclose(data.sensordata, peer.sensordata, rtol=1e-6, atol=1e-6)
    assert 0 < cut < 30
