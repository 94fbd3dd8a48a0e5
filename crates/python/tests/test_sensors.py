"""Sensors that ask about shapes and fields, beside MuJoCo's on random configurations."""

import numpy as np
import pytest

import signorini

WORLD = """<mujoco model="sensors">
  <option magnetic="0.2 -0.4 0.6"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="pillar" type="cylinder" size="0.2 1" pos="1.5 0 1"/>
    <geom name="ghost" type="box" size="3 3 0.1" pos="0 0 3" rgba="1 1 1 0"/>
    <body name="drone" pos="0 0 1.5"><freejoint/>
      <geom name="hull" type="sphere" size="0.1" mass="1"/><geom name="arm" type="capsule" size="0.03" fromto="0 0 0 0.4 0 0" mass="0.1"/>
      <site name="down" quat="0 1 0 0" pos="0 0 -0.05"/><site name="ahead" quat="0.7071 0 0.7071 0"/>
    </body>
    <body name="ball" pos="0 1 1"><freejoint/><geom name="ball" size="0.15" mass="1"/></body>
  </worldbody>
  <sensor>
    <magnetometer name="compass" site="ahead"/>
    <rangefinder name="height" site="down"/><rangefinder name="sight" site="ahead" cutoff="1.2"/>
    <distance name="gap" geom1="hull" geom2="ball" cutoff="2"/><normal name="way" geom1="hull" geom2="ball" cutoff="2"/>
    <fromto name="points" geom1="hull" geom2="ball" cutoff="2"/>
    <distance name="near" body1="drone" body2="ball" cutoff="0.7"/><fromto name="nearest" body1="drone" body2="ball" cutoff="0.7"/>
    <distance name="clear" geom1="ball" geom2="floor" cutoff="5"/>
  </sensor>
</mujoco>"""


def test_beside_mujoco():
    mujoco = pytest.importorskip("mujoco")
    theirs = mujoco.MjModel.from_xml_string(WORLD)
    peer, model = mujoco.MjData(theirs), signorini.Model.from_string(WORLD)
    assert model.import_report == []
    data, rng = signorini.Data(model), np.random.default_rng(8)
    missed = near = 0
    for _ in range(200):
        q = np.concatenate([rng.uniform(-1, 1, 3) + (0, 0, 1.5), rng.normal(size=4), rng.uniform(-1, 1, 3) + (0, 0, 1.5), rng.normal(size=4)])
        q[3:7] /= np.linalg.norm(q[3:7])
        q[10:14] /= np.linalg.norm(q[10:14])
        data.qpos, peer.qpos[:] = q, q
        signorini.forward(model, data)
        mujoco.mj_forward(theirs, peer)
        assert np.allclose(data.sensordata, peer.sensordata, rtol=1e-9, atol=1e-9)
        missed += data.sensor("sight")[0] == -1.0
        near += data.sensor("near")[0] < 0.7
    assert missed > 5 and near > 5


def test_closed_forms():
    model = signorini.Model.from_string(WORLD)
    data = signorini.Data(model)
    signorini.forward(model, data)
    assert data.sensor("height") == pytest.approx([1.45], abs=1e-12)
    assert data.sensor("gap") == pytest.approx([np.hypot(1, 0.5) - 0.25], abs=1e-12)
    assert data.sensor("clear") == pytest.approx([0.85], abs=1e-12)
    data.change(geom_size={"ball": (0.3, 0, 0)})
    signorini.forward(model, data)
    assert data.sensor("clear") == pytest.approx([0.7], abs=1e-12)
    assert signorini.Spec(model).compile().content_hash == model.content_hash


CONTACTS = """<mujoco><option gravity='0 0 0' timestep='1e-6'/><worldbody>
  <geom name='floor' type='plane' size='5 5 1' euler='10 20 0'/><site name='zone' type='box' size='0.4 0.4 0.4' pos='0 0 0.3'/>
  <body name='a'><freejoint/><geom name='a' size='0.1' mass='1'/></body>
  <body name='b'><freejoint/><geom name='b' size='0.12' mass='2'/>
    <body name='c' pos='0 0 0.2'><geom name='c' size='0.15' mass='0.5'/></body></body></worldbody><sensor>
  <contact geom1='floor' geom2='a' data='found dist pos normal tangent'/><contact geom1='a' geom2='floor' data='found dist pos normal tangent'/>
  <contact body1='b' geom2='floor' data='dist normal tangent'/><contact subtree1='b' body2='a' num='3' reduce='mindist' data='found dist pos normal'/>
  <contact geom1='floor' num='4' reduce='mindist' data='found dist pos'/><contact subtree2='b' data='found'/><contact data='found'/>
  <contact site='zone' num='2' reduce='mindist' data='found pos'/></sensor></mujoco>"""


def test_contacts_between_sides_are_mujocos():
    mujoco = pytest.importorskip("mujoco", reason="compared with MuJoCo, which is not installed")
    theirs, model = mujoco.MjModel.from_xml_string(CONTACTS), signorini.Model.from_string(CONTACTS)
    assert model.import_report == []
    again = signorini.Model.from_string(signorini.Spec(model).to_mjcf()[0])
    assert again.content_hash == model.content_hash
    peer, rng, touching = mujoco.MjData(theirs), np.random.default_rng(3), 0
    for _ in range(300):
        data = signorini.Data(model)
        q = np.concatenate([rng.uniform(-0.2, 0.2, 3), [1, 0, 0, 0], rng.uniform(-0.2, 0.2, 3), rng.normal(size=4)])
        q[10:14] /= np.linalg.norm(q[10:14])
        data.qpos, peer.qpos[:] = q, q
        signorini.forward(model, data)
        mujoco.mj_forward(theirs, peer)
        assert np.allclose(data.sensordata, peer.sensordata, rtol=1e-9, atol=1e-9)
        touching += peer.ncon
    assert touching > 300


def test_contacts_bear_what_lies_on_them():
    sort = "data='found force torque pos' reduce='{0}' num='{1}'"
    model = signorini.Model.from_string(f"""<mujoco><worldbody><geom name='floor' type='plane' size='5 5 1'/>
      <body name='box' pos='0.3 0 0.1'><freejoint/><geom name='box' type='box' size='0.1 0.2 0.1' mass='2'/></body></worldbody><sensor>
      <contact name='net' geom1='floor' body2='box' {sort.format("netforce", 1)}/>
      <contact name='up' body1='box' geom2='floor' {sort.format("netforce", 1)}/>
      <contact name='most' geom1='floor' geom2='box' {sort.format("maxforce", 5)}/></sensor></mujoco>""")
    data = signorini.Data(model)
    signorini.step(model, data, nstep=20)
    net, up, most = (data.sensor(name) for name in ("net", "up", "most"))
    weight = 2 * 9.81
    assert net == pytest.approx([4, 0, 0, weight, 0, 0, 0, 0.3, 0, 0], abs=1e-8)
    assert up[1:4] == pytest.approx([0, 0, -weight], abs=1e-8)
    slots = np.reshape(most, (5, 10))
    assert slots[:, 0].tolist() == [4, 4, 4, 4, 0] and np.all(np.diff(slots[:4, 1]) <= 1e-9)
    assert slots[:, 1].sum() == pytest.approx(weight, abs=1e-8) and np.all(slots[4] == 0)


CAMERAS = """<mujoco><option gravity='0 0 0' timestep='1e-6'/><worldbody>
  <camera name='fixed' pos='1 -2 3' xyaxes='0.8 0.6 0 0 0 1' resolution='640 480' fovy='50'/>
  <body name='a' pos='0.1 0 0.2'><freejoint/><geom size='0.1' mass='1'/><geom size='0.05' pos='0.3 0.1 0' mass='2'/><site name='s' pos='0.05 0.02 0.1'/>
    <camera name='carried' pos='0.3 0 0' euler='10 20 30' resolution='320 200' sensorsize='0.01 0.008' focal='0.012 0.013'/>
    <camera name='track' mode='track' pos='0 -2 1' euler='60 0 0' resolution='100 100'/>
    <camera name='trackcom' mode='trackcom' pos='0 -2 1' euler='60 0 0' resolution='100 100'/></body>
  <body name='b' pos='1 1 1'><freejoint/><geom size='0.1' mass='1'/><site name='t'/>
    <camera name='aimed' mode='targetbody' target='a' pos='0 0 1' resolution='64 64'/>
    <camera name='aimedcom' mode='targetbodycom' target='a' pos='0 0 1' resolution='64 32' fovy='90'/></body></worldbody>
  <sensor>""" + "".join(f"<camprojection site='{site}' camera='{camera}'/>" for site in "st"
    for camera in ("fixed", "carried", "track", "trackcom", "aimed", "aimedcom")) + "</sensor></mujoco>"


def test_cameras_see_sites_where_mujocos_do():
    mujoco = pytest.importorskip("mujoco", reason="compared with MuJoCo, which is not installed")
    theirs, model = mujoco.MjModel.from_xml_string(CAMERAS), signorini.Model.from_string(CAMERAS)
    assert model.import_report == []
    assert signorini.Model.from_string(signorini.Spec(model).to_mjcf()[0]).content_hash == model.content_hash
    peer, data, rng = mujoco.MjData(theirs), signorini.Data(model), np.random.default_rng(5)
    for _ in range(100):
        q = np.concatenate([rng.uniform(-1, 1, 3), rng.normal(size=4), rng.uniform(-1, 1, 3), rng.normal(size=4)])
        q[3:7] /= np.linalg.norm(q[3:7])
        q[10:14] /= np.linalg.norm(q[10:14])
        data.qpos, peer.qpos[:] = q, q
        signorini.forward(model, data)
        mujoco.mj_forward(theirs, peer)
        # MuJoCo keeps focal lengths in single precision.
        single = [k for k in range(24) if k // 2 in (1, 7)]
        double = [k for k in range(24) if k not in single]
        scale = 1.0 + np.abs(peer.sensordata)
        off = np.abs(data.sensordata - peer.sensordata) / scale
        assert off[double].max() < 1e-9 and off[single].max() < 1e-6


def test_cameras_of_a_spec_stay_those_of_their_sensors():
    spec = signorini.Spec(signorini.Model.from_string(CAMERAS))
    before = signorini.Data(spec.compile())
    signorini.forward(before.model, before)
    spec.body("a").remove()
    model = spec.compile()
    after = signorini.Data(model)
    signorini.forward(model, after)
    assert model.nsensor == 1 and np.allclose(after.sensordata, before.sensordata[12:14], rtol=1e-12)


ADHESION = """<mujoco><option timestep='0.001'/><worldbody>
  <geom name='floor' type='plane' size='5 5 1' euler='4 -3 0'/><geom name='pole' type='capsule' size='0.1' fromto='1 -1 0.3 1 1 0.3'/>
  <body name='arm' pos='0 0 0.5'><joint name='yaw' axis='0 0 1'/><joint name='pitch' axis='0 1 0'/>
    <geom type='capsule' size='0.03' fromto='0 0 0 0.5 0 0' mass='1'/>
    <body name='cup' pos='0.55 0 0'><joint name='wrist' axis='0 1 0.3'/><geom name='cup' size='0.06' mass='0.2'/><geom name='lip' size='0.05' pos='0.05 0 0' mass='0.2'/></body></body>
  <body name='b' pos='0.7 0.3 0.5'><freejoint/><geom name='b' size='0.12' mass='2'/></body></worldbody>
  <actuator><adhesion name='cup' body='cup' ctrlrange='0 2' gain='7'/><general name='b' body='b' gear='3' ctrlrange='0 1' gainprm='2'/>
    <adhesion name='strong' body='b' ctrlrange='0 2' gain='7' forcerange='0 4'/></actuator>
  <sensor><actuatorfrc actuator='cup'/><actuatorfrc actuator='b'/><actuatorfrc actuator='strong'/>
    <jointactuatorfrc joint='yaw'/><jointactuatorfrc joint='pitch'/><jointactuatorfrc joint='wrist'/>
    <actuatorpos actuator='cup'/><actuatorvel actuator='cup'/><actuatorvel actuator='b'/></sensor></mujoco>"""


@pytest.mark.filterwarnings("ignore:shapes overlap")
def test_what_sticks_pulls_as_mujocos_does():
    mujoco = pytest.importorskip("mujoco", reason="compared with MuJoCo, which is not installed")
    theirs, model = mujoco.MjModel.from_xml_string(ADHESION), signorini.Model.from_string(ADHESION)
    assert model.import_report == [] and model.actuator("cup").body == model.body("cup").id
    peer, data, rng = mujoco.MjData(theirs), signorini.Data(model), np.random.default_rng(3)
    pulled = 0
    for _ in range(300):
        q = np.concatenate([rng.uniform((-0.5, 0.2, -1), (0.5, 0.9, 1)), rng.uniform((0.4, -0.2, 0), (0.9, 0.3, 0.3)), rng.normal(size=4)])
        q[6:10] /= np.linalg.norm(q[6:10])
        data.qpos, peer.qpos[:] = q, q
        data.qvel, peer.qvel[:] = (v := rng.normal(size=9)), v
        data.ctrl, peer.ctrl[:] = (u := rng.uniform(0, 2, 3)), u
        mujoco.mj_forward(theirs, peer)
        own = {theirs.body("cup").id, theirs.body("b").id}
        near = [c.dist for c in peer.contact if own & {theirs.geom_bodyid[g] for g in c.geom}]
        # What overlaps deeply has other points, and what is about to touch does so here and not there.
        if not near or min(near) < -0.02 or max(near) > -1e-4:
            continue
        signorini.step(model, data)
        pulled += 1
        assert np.allclose(data.sensordata, peer.sensordata, rtol=1e-9, atol=1e-9), (data.sensordata, peer.sensordata, near)
    assert pulled > 20
