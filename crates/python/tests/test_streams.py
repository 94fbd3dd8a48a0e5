"""Live streams, read by programs of the viewers' makers."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import signorini
from signorini.streams import FoxgloveStream, RerunStream

WORLD = """<mujoco model="falling"><worldbody><geom name="floor" type="plane" size="0 0 1"/>
  <body name="ball" pos="0 0 0.12"><freejoint/><geom size="0.1" mass="1"/></body>
  <body name="rod" pos="1 0 0.5"><joint type="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0.1 0" size="0.02"/>
    <geom type="box" size="0.02 0.03 0.04"/><geom type="cylinder" size="0.02 0.1"/><geom type="ellipsoid" size="0.02 0.1 0.05"/></body></worldbody></mujoco>"""
STEPS = 60


@pytest.fixture
def world():
    model = signorini.Model.from_string(WORLD)
    return model, signorini.Data(model)


def run(model, data, stream):
    poses = []
    for _ in range(STEPS):
        signorini.step(model, data)
        stream.log(data)
        poses.append((data.time, data.xpos[1:].copy(), data.xquat[1:].copy()))
    return poses


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_rerun_shows_every_step(world, tmp_path):
    chunk = pytest.importorskip("rerun.chunk", reason="reads what a viewer got with the package rerun-sdk")
    path = tmp_path / "got.rrd"
    with RerunStream(world[0], port=0) as stream:
        env = {**os.environ, "RERUN_ANALYTICS_ENABLED": "false"}
        viewer = subprocess.Popen(
            [sys.executable, "-m", "rerun", "--port", "auto", "--save", str(path), stream.url],
            env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        try:
            poses = run(*world, stream)
            stream._stream.flush()
            deadline = time.monotonic() + 60
            while time.monotonic() < deadline and not complete(chunk, path):
                time.sleep(0.2)
        finally:
            viewer.send_signal(signal.SIGINT)
            try:
                viewer.wait(30)
            except subprocess.TimeoutExpired:  # What a shell has started in the background ignores interrupts.
                viewer.kill()
                viewer.wait()
    found = columns(chunk, path)
    for row, body in enumerate(("ball", "rod")):
        entity = f"/world/bodies/{body}"
        order = np.argsort(np.array(found[entity, "sim_time"], dtype="timedelta64[ns]"), kind="stable")
        times = np.array(found[entity, "sim_time"], dtype="timedelta64[ns]").astype(float)[order] * 1e-9
        assert times == pytest.approx([pose[0] for pose in poses], abs=1e-9)
        translation = np.array(found[entity, "Transform3D:translation"])[order, 0]
        assert np.array_equal(translation, np.float32([pose[1][row] for pose in poses]))
        turned = np.array(found[entity, "Transform3D:quaternion"])[order, 0]
        assert np.array_equal(turned, np.roll(np.float32([pose[2][row] for pose in poses]), -1, axis=1))
    assert len(found["/world/contacts", "Arrows3D:vectors"]) == STEPS
    assert found["/world/bodies/rod/geom3", "Boxes3D:half_sizes"] == [[pytest.approx([0.02, 0.03, 0.04])]]


def columns(chunk, path):
    found = {}
    for part in chunk.RrdReader(path).stream().to_chunks():
        batch = part.to_record_batch()
        for name in set(batch.schema.names) - {"log_time"}:  # Wall time, which datetime cannot hold.
            found.setdefault((str(part.entity_path), name), []).extend(batch.column(name).to_pylist())
    return found


def complete(chunk, path):
    """Whether the last number of the last step has come."""
    try:
        return path.exists() and len(columns(chunk, path).get(("/certificate/worst", "Scalars:scalars"), [])) >= STEPS
    except (OSError, RuntimeError, ValueError):
        return False  # A part of a file that is being written.


def test_foxglove_shows_every_step(world):
    pytest.importorskip("foxglove", reason="streams to Foxglove with the package foxglove-sdk")
    websockets = pytest.importorskip("websockets", reason="speaks Foxglove's protocol over the package websockets")
    definitions = "foxglove_schemas_protobuf"
    pytest.importorskip(definitions, reason="has Foxglove's definitions of messages in the package foxglove-schemas-protobuf")
    from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
    from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

    async def watch(stream):
        """What a client of the protocol gets that subscribes to everything: messages by topic."""
        async with websockets.connect(stream.url, subprotocols=["foxglove.sdk.v1"]) as client:
            channels = {}
            while len(channels) < 4:
                message = json.loads(await client.recv())
                channels.update({c["id"]: c for c in message.get("channels", [])})
            wanted = [{"id": number, "channelId": number} for number in channels]
            await client.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
            got = {c["topic"]: [] for c in channels.values()}
            poses = None
            while poses is None or min(len(got[t]) for t in ("/tf", "/numbers", "/contact_forces")) < STEPS:
                message = await asyncio.wait_for(client.recv(), 20)
                if isinstance(message, str) or message[0] != 1:
                    continue
                number = int.from_bytes(message[1:5], "little")
                got[channels[number]["topic"]].append((int.from_bytes(message[5:13], "little"), message[13:]))
                if poses is None and got["/scene"]:
                    # The shapes come with the subscription.
                    poses = await asyncio.get_running_loop().run_in_executor(None, run, *world, stream)
            return poses, got

    with FoxgloveStream(world[0], port=0) as stream:
        poses, got = asyncio.run(watch(stream))
    scene = SceneUpdate.FromString(got["/scene"][0][1])
    assert [len(e.cubes) + len(e.spheres) + len(e.cylinders) for e in scene.entities] == [1, 1, 3, 1, 1, 1]
    assert {entity.frame_id for entity in scene.entities} == {"world", "ball", "rod"}
    for (at, message), (when, place, turn) in zip(got["/tf"], poses):
        frames = FrameTransforms.FromString(message).transforms
        assert at == round(when * 1e9) and [f.child_frame_id for f in frames] == ["ball", "rod"]
        for frame, p, q in zip(frames, place, turn):
            assert [frame.translation.x, frame.translation.y, frame.translation.z] == list(p)
            assert [frame.rotation.w, frame.rotation.x, frame.rotation.y, frame.rotation.z] == list(q)
    arrow = SceneUpdate.FromString(got["/contact_forces"][-1][1]).entities[0].arrows[0]
    assert arrow.shaft_length + arrow.head_length > 0 and abs(arrow.pose.position.z) < 1e-6
    numbers = json.loads(got["/numbers"][-1][1])
    assert numbers["energy/kinetic"] >= 0 and numbers["certificate/worst"] < 1e-9


def test_errors_say_what_to_do(world, monkeypatch):
    with pytest.raises((ValueError, ImportError), match="either port|pip install"):
        RerunStream(world[0])
    for module, stream in (("rerun", lambda: RerunStream(world[0], port=0)), ("foxglove", lambda: FoxgloveStream(world[0]))):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(ImportError, match=rf"pip install 'signorini\[{module}\]'"):
            stream()
