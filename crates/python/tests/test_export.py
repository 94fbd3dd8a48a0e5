"""Recordings in other formats, read back by programs that are not ours; and recordings certified again."""

import copy
import csv
import json
import pickle

import numpy as np
import pytest

import signorini
from conftest import mjcf

SHAPES = """<geom name='floor' type='plane' friction='0.5'/>
  <body name='box' pos='0 0 0.1'><freejoint name='free'/><geom name='skin' type='box' size='.1 .1 .1' mass='2' rgba='1 0 0 1'/></body>
  <body name='arm' pos='1 0 1'><joint name='hinge' axis='0 1 0' range='-20 20'/>
    <geom type='capsule' fromto='0 0 0 .3 0 0' size='.02' mass='1'/>
    <body name='wrist' pos='.3 0 0'><joint name='ball' type='ball'/><geom type='ellipsoid' size='.03 .02 .01' mass='.1'/>
    </body></body>
  <body name='cart' pos='2 0 1'><joint name='rail' type='slide' axis='1 0 0'/><geom type='cylinder' size='.1 .05' mass='1'/></body>"""


@pytest.fixture(scope="module")
def run():
    """A recording of 30 steps in which a box slides and an arm hits its limit."""
    model = mjcf(SHAPES, rest="<actuator><motor name='push' joint='rail'/></actuator>")
    data = signorini.Data(model)
    data.qvel[:3] = 1.0, 0.3, 0.0
    data.ctrl[0] = 0.5
    with data.record() as recorder:
        signorini.step(model, data, nstep=150)
    return model, recorder.recording


def test_arrays(run, tmp_path):
    _, recording = run
    recording.to_npz(tmp_path / "run.npz")
    arrays = np.load(tmp_path / "run.npz")
    for name in ("time", "qpos", "qvel", "xpos", "xquat", "energy", "residuals", "iterations", "ncon"):
        assert np.array_equal(arrays[name], getattr(recording, name)), name
    assert [s.decode() for s in arrays["status"]] == recording.status
    assert [s.decode() for s in arrays["body_names"]] == recording.body_names
    assert int(arrays["model_hash"].item().decode(), 16) == recording.model_hash
    assert arrays["ctrl"][:-1, 0] == pytest.approx(0.5) and arrays["qfrc_applied"].shape == recording.qvel.shape
    start = arrays["contact_start"]
    for i in (0, 7, 149):
        contact, rows = recording.contact(i), slice(start[i], start[i + 1])
        for name in ("point", "frame", "gap", "friction", "impulse", "force_world", "sliding_velocity", "mode", "geom1", "body2"):
            assert np.array_equal(arrays[f"contact_{name}"][rows], getattr(contact, name)), name
    assert (arrays["limit_impulse"] > 0).any() and set(arrays["limit_tendon"]) == {-1}


def test_table(run, tmp_path):
    model, recording = run
    recording.to_csv(tmp_path / "run.csv")
    with open(tmp_path / "run.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(recording) == 151 and None not in rows[0] and len(rows[0]) == 2 + model.nq + model.nv + 14
    column = lambda name: np.array([float(row[name]) for row in rows])
    assert np.array_equal(column("time [s]"), recording.time)
    for name, part in (("q free.x [m]", 0), ("q free.qw", 3), ("q hinge [rad]", 7), ("q ball.qz", 11), ("q rail [m]", 12)):
        assert np.array_equal(column(name), recording.qpos[:, part]), name
    for name, part in (("v free.z [m/s]", 2), ("v free.wx [rad/s]", 3), ("v ball.wz [rad/s]", 9), ("v rail [m/s]", 10)):
        assert np.array_equal(column(name), recording.qvel[:, part]), name
    assert np.array_equal(column("signorini residual"), recording.residuals[:, 2])
    assert column("normal impulses [N s]")[:-1] == pytest.approx(2 * 9.81 * 0.002, rel=1e-6)
    assert [row["status"] for row in rows] == recording.status and rows[-1]["smallest gap [m]"] == ""


def test_messages(run, tmp_path):
    reader = pytest.importorskip("mcap.reader", reason="reads MCAP with the package mcap")
    model, recording = run
    recording.to_mcap(tmp_path / "run.mcap")
    found = {}
    with open(tmp_path / "run.mcap", "rb") as file:
        source = reader.make_reader(file, validate_crcs=True)
        counts = source.get_summary().statistics.channel_message_counts
        metadata = {m.name: m.metadata for m in source.iter_metadata()}
        for schema, channel, message in source.iter_messages():
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
            value = json.loads(message.data)
            described = json.loads(schema.data)
            assert described["title"] == schema.name and set(value) == set(described["properties"])
            found.setdefault((channel.topic, schema.name), []).append((message.log_time, value))
    assert sum(counts.values()) == 5 * len(recording) + 1
    assert metadata["recording"]["model_hash"] == f"{recording.model_hash:016x}"
    moved = found["/tf", "foxglove.FrameTransforms"]
    assert [time for time, _ in moved] == np.round(1e9 * recording.time).astype(int).tolist()
    for i in (0, 20, 150):
        for body, transform in enumerate(moved[i][1]["transforms"], 1):
            assert transform["child_frame_id"] == recording.body_names[body] and transform["parent_frame_id"] == "world"
            assert [transform["translation"][k] for k in "xyz"] == recording.xpos[i, body].tolist()
            assert [transform["rotation"][k] for k in "wxyz"] == recording.xquat[i, body].tolist()
    (_, scene), = found["/scene", "foxglove.SceneUpdate"]
    kinds = {entity["id"]: [kind for kind in ("cubes", "spheres", "cylinders", "triangles") if entity[kind]]
             for entity in scene["entities"]}
    assert kinds == {"world": ["cubes"], "box": ["cubes"], "arm": ["spheres", "cylinders"], "wrist": ["spheres"], "cart": ["cylinders"]}
    box = next(entity for entity in scene["entities"] if entity["id"] == "box")
    assert box["cubes"][0]["size"] == {"x": 0.2, "y": 0.2, "z": 0.2} and box["frame_locked"] and box["cubes"][0]["color"]["r"] == 1
    contacts = found["/contacts", "signorini.Contacts"][10][1]["contacts"]
    recorded = recording.contact(10)
    assert [[c["force"][k] for k in "xyz"] for c in contacts] == recorded.force_world.tolist()
    assert {(c["body1"], c["geom2"]) for c in contacts} == {("world", "skin")}
    arrows = found["/contact_forces", "foxglove.SceneUpdate"][10][1]["entities"][0]["arrows"]
    assert len(arrows) == (recorded.impulse[:, 0] > 0).sum()
    certificate = found["/certificate", "signorini.Certificate"][10][1]
    assert certificate["natural_map"] == recording.residuals[10, 1] and certificate["worst"] == recording.residuals[10].max()
    assert found["/state", "signorini.State"][10][1]["q"] == recording.qpos[10].tolist()


def messages_of(path):
    """Every message of an MCAP file, in the order of the file: topic, its schema's name and text, time in ns, content."""
    reader = pytest.importorskip("mcap.reader", reason="reads MCAP with the package mcap")
    with open(path, "rb") as file:
        source = reader.make_reader(file, validate_crcs=True)
        return [(channel.topic, schema.name, json.loads(schema.data), message.log_time, json.loads(message.data))
                for schema, channel, message in source.iter_messages(log_time_order=False)]


def without_unnamed_fields(schema):
    """The schema, refusing what it does not name, and demanding what it does."""
    if isinstance(schema, list):
        return [without_unnamed_fields(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    strict = {key: without_unnamed_fields(part) for key, part in schema.items()}
    if schema.get("type") == "object":
        strict |= {"additionalProperties": False, "required": list(schema["properties"])}
    return strict


def test_messages_are_what_their_schemas_say(run, tmp_path):
    jsonschema = pytest.importorskip("jsonschema", reason="checks JSON schemas with the package jsonschema")
    _, recording = run
    recording.to_mcap(tmp_path / "run.mcap")
    checkers = {}
    for _, name, schema, _, value in messages_of(tmp_path / "run.mcap"):
        if name not in checkers:
            jsonschema.Draft202012Validator.check_schema(schema)
            checkers[name] = jsonschema.Draft202012Validator(without_unnamed_fields(schema))
        checkers[name].validate(value)
    assert len(checkers) == 5
    with pytest.raises(jsonschema.ValidationError):
        checkers["signorini.State"].validate({**value, "q": ["1"]})


def as_protobuf(value, key=None):
    """Times as protobuf's JSON has them, otherwise the same."""
    if key == "timestamp":
        return f"{np.datetime64(value['sec'], 's')}.{value['nsec']:09d}Z"
    if key == "lifetime":
        return f"{value['sec']}.{value['nsec']:09d}s"
    if isinstance(value, dict):
        return {name: as_protobuf(part, name) for name, part in value.items()}
    return [as_protobuf(part) for part in value] if isinstance(value, list) else value


def fields_of(descriptor):
    """Fields of a protobuf message, and of those within it, as JSON schemas have them: "name" or "name[]"."""
    found = set()
    for field in descriptor.fields:
        name = field.name + ("[]" if field.is_repeated else "")
        inner = field.message_type
        times = inner is not None and inner.full_name.startswith("google.protobuf")
        found |= {f"{name}.{part}" for part in fields_of(inner)} if inner and not times else {name}
    return found


def fields_of_schema(schema):
    found = set()
    for name, part in schema["properties"].items():
        if part["type"] == "array":
            name, part = name + "[]", part["items"]
        times = part.get("title") in ("time", "duration")
        inner = part["type"] == "object" and not times
        found |= {f"{name}.{inside}" for inside in fields_of_schema(part)} if inner else {name}
    return found


def test_messages_are_those_of_foxglove(run, tmp_path):
    """Foxglove's own definitions, from its package, know every field, and read every message with nothing left over."""
    package = "foxglove_schemas_protobuf"
    pytest.importorskip(package, reason="has Foxglove's definitions of messages in the package foxglove-schemas-protobuf")
    import importlib

    from google.protobuf import json_format

    _, recording = run
    recording.to_mcap(tmp_path / "run.mcap")
    read = {}
    for topic, name, schema, time, value in messages_of(tmp_path / "run.mcap"):
        if name.startswith("foxglove."):
            kind = getattr(importlib.import_module(f"{package}.{name[9:]}_pb2"), name[9:])
            assert fields_of_schema(schema) == fields_of(kind.DESCRIPTOR), name
            message = json_format.ParseDict(as_protobuf(value), kind())
            read.setdefault(topic, []).append((time, message))
    assert [len(read[topic]) for topic in ("/tf", "/scene", "/contact_forces")] == [len(recording), 1, len(recording)]
    for (time, message), frame in zip(read["/tf"], range(len(recording))):
        for body, transform in enumerate(message.transforms, 1):
            assert transform.timestamp.ToNanoseconds() == time
            moved, turned = transform.translation, transform.rotation
            assert [moved.x, moved.y, moved.z] == recording.xpos[frame, body].tolist()
            assert [turned.w, turned.x, turned.y, turned.z] == recording.xquat[frame, body].tolist()
    (_, scene), = read["/scene"]
    assert {entity.frame_id for entity in scene.entities} == set(recording.body_names)
    assert all(entity.lifetime.ToNanoseconds() == 0 for entity in scene.entities)


def test_times_grow_and_poses_follow_from_the_states(run, tmp_path):
    """What one topic says, a simulation set to the state of another topic says, too."""
    model, recording = run
    recording.to_mcap(tmp_path / "run.mcap")
    times, poses, states = {}, {}, {}
    for topic, _, _, time, value in messages_of(tmp_path / "run.mcap"):
        times.setdefault(topic, []).append(time)
        if topic == "/tf":
            poses[time] = value["transforms"]
        elif topic == "/state":
            states[time] = value
    for topic, stamps in times.items():
        assert (np.diff(stamps) > 0).all() and stamps[0] == 0, topic
    every = [stamp for _, _, _, stamp, _ in messages_of(tmp_path / "run.mcap")]
    assert every == sorted(every) and poses.keys() == states.keys()
    data = signorini.Data(model)
    for time, state in states.items():
        assert state["step"] * 0.002 == pytest.approx(1e-9 * time, abs=1e-9) and state["time"] == pytest.approx(1e-9 * time, abs=1e-9)
        data.qpos[:] = state["q"]
        signorini.forward(model, data)
        for transform in poses[time]:
            body = data.body(transform["child_frame_id"])
            assert [transform["translation"][k] for k in "xyz"] == pytest.approx(body.xpos, abs=1e-12)
            assert [transform["rotation"][k] for k in "wxyz"] == pytest.approx(body.xquat, abs=1e-12)


def areas_and_heights(points, faces):
    """Areas of triangles seen from above, positive where they are counter-clockwise, and the range of heights."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)[:, 2] / 2, (points[:, 2].min(), points[:, 2].max())


def test_surfaces_of_triangles(tmp_path):
    reader = pytest.importorskip("mcap.reader", reason="reads MCAP with the package mcap")
    model = mjcf("<geom type='hfield' hfield='h'/><body name='tetrahedron' pos='0 0 2'><freejoint/><geom type='mesh' mesh='t'/></body>",
                 rest="<asset><hfield name='h' nrow='2' ncol='3' size='1 2 .5 .1' elevation='0 1 0 1 0 1'/>"
                      "<mesh name='t' vertex='0 0 0  .3 0 0  0 .3 0  0 0 .3' face='0 2 1  0 1 3  0 3 2  1 2 3'/></asset>")
    data = signorini.Data(model)
    with data.record() as recorder:
        signorini.step(model, data)
    recorder.recording.to_mcap(tmp_path / "run.mcap")
    with open(tmp_path / "run.mcap", "rb") as file:
        messages = [json.loads(m.data) for _, channel, m in reader.make_reader(file).iter_messages(topics=["/scene"])]
    surfaces = {}
    for entity in messages[0]["entities"]:
        (triangles,) = entity["triangles"]
        points = np.array([[p[k] for k in "xyz"] for p in triangles["points"]])
        surfaces[entity["id"]] = points, np.array(triangles["indices"]).reshape(-1, 3)
    points, faces = surfaces["world"]
    areas, heights = areas_and_heights(points, faces)
    assert len(faces) == 4 and (areas > 0).all() and areas.sum() == pytest.approx(2 * 4) and heights == pytest.approx((0, 0.5))
    # A ball that is let down near the middle of either edge meets the surface that is drawn there.
    for y in (-1.99, 1.99):
        drawn = points[np.argmin(np.linalg.norm(points[:, :2] - [0, y], axis=1)), 2]
        ball = mjcf(f"<geom type='hfield' hfield='h'/><body pos='0 {y} {drawn + 0.02}'><freejoint/><geom size='.01'/></body>",
                    rest="<asset><hfield name='h' nrow='2' ncol='3' size='1 2 .5 .1' elevation='0 1 0 1 0 1'/></asset>")
        falling = signorini.Data(ball)
        signorini.step(ball, falling, nstep=30)
        assert falling.qpos[2] == pytest.approx(drawn + 0.01, abs=3e-3) and falling.ncon > 0
    points, faces = surfaces["tetrahedron"]
    a, b, c = (points[faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(0.3**3 / 6, rel=1e-6)


def test_rerun(run, tmp_path):
    chunk = pytest.importorskip("rerun.chunk", reason="writes and reads recordings of Rerun with the package rerun-sdk")
    model, recording = run
    recording.to_rerun(tmp_path / "run.rrd")
    found = {}
    reader = chunk.RrdReader(tmp_path / "run.rrd")
    (stored,) = reader.recordings()
    assert stored.application_id == "signorini" and stored.recording_id == f"{model.name}-{recording.model_hash:016x}"
    for part in reader.stream().to_chunks():
        batch = part.to_record_batch()
        for name in batch.schema.names:
            found.setdefault((str(part.entity_path), name), []).extend(batch.column(name).to_pylist())
    for k, law in enumerate(("momentum", "natural_map", "signorini", "friction", "dissipation")):
        assert np.array_equal(np.ravel(found[f"/certificate/{law}", "Scalars:scalars"]), recording.residuals[:, k])
    for k, kind in enumerate(("kinetic", "potential")):
        assert np.array_equal(np.ravel(found[f"/energy/{kind}", "Scalars:scalars"]), recording.energy[:, k])
    for body in (1, 2, 3, 4):
        entity = f"/world/bodies/{recording.body_names[body]}"
        times = np.array(found[entity, "sim_time"], dtype="timedelta64[ns]").astype(float) * 1e-9
        assert times == pytest.approx(recording.time, abs=1e-9) and (np.diff(times) > 0).all()
        translation = np.array(found[entity, "Transform3D:translation"])[:, 0]
        assert np.array_equal(translation, recording.xpos[:, body].astype(np.float32))
        quaternion = np.array(found[entity, "Transform3D:quaternion"])[:, 0]
        assert np.array_equal(quaternion, np.roll(recording.xquat[:, body], -1, axis=1).astype(np.float32))
    arrows = found["/world/contacts", "Arrows3D:vectors"]
    assert [len(frame) for frame in arrows] == recording.ncon.tolist()
    origins = found["/world/contacts", "Arrows3D:origins"]
    assert np.array_equal(origins[20], recording.contact(20).point.astype(np.float32))
    forces = [recording.contact(i).force_world for i in range(len(recording))]
    longest = max(np.linalg.norm(f, axis=1).max() for f in forces if len(f))
    assert np.array(arrows[20]) == pytest.approx(forces[20] * 0.3 / longest, rel=1e-6, abs=1e-9)
    assert found["/world/bodies/box/geom1", "Boxes3D:half_sizes"] == [[pytest.approx([0.1, 0.1, 0.1])]]


def test_without_rerun_the_error_says_what_to_install(run, tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(ImportError, match=r"pip install 'signorini\[rerun\]'"):
        run[1].to_rerun(tmp_path / "run.rrd")


def test_every_step_is_certified_again(run, tmp_path):
    model, recording = run
    check = recording.check(tolerance=1e-9)
    assert check and check.ok and check.steps == 150 and check.violated == 0 and check.law == "polygon"
    assert check.restarts == [] and check.violations == [] and 0 < check.worst.worst < 1e-9 and "every law" in repr(check)
    assert recording.check(model)
    with pytest.raises(signorini.RecordingError, match="hashes differ"):
        recording.check(mjcf("<body><freejoint/><geom size='1'/></body>"))
    # One flipped bit of a stored impulse, its record's checksum made to fit.
    import zlib

    stored = bytearray(recording._to_bytes())
    at = 20 + int.from_bytes(stored[12:16], "little")
    for _ in range(40):
        at += 8 + int.from_bytes(stored[at : at + 4], "little")
    length = int.from_bytes(stored[at : at + 4], "little")
    impulse = np.float64(recording.contact(40).impulse[0, 0]).tobytes()
    where = stored.rindex(impulse, at, at + 8 + length)
    stored[where + 5] ^= 0x10
    stored[at + 4 : at + 8] = zlib.crc32(bytes(stored[at + 8 : at + 8 + length])).to_bytes(4, "little")
    tampered = signorini.Recording._from_bytes(bytes(stored)).check()
    assert not tampered and tampered.violated == 1 and tampered.violations[0][0] == 40


def test_states_set_from_outside_are_restarts_and_no_violations(ball):
    data = signorini.Data(ball)
    with data.record() as recorder:
        signorini.step(ball, data, nstep=3)
        data.qpos[0] += 0.5
        signorini.step(ball, data, nstep=3)
    check = recorder.recording.check()
    assert check and check.restarts == [3]


def test_recordings_travel(run):
    _, recording = run
    for other in (pickle.loads(pickle.dumps(recording)), copy.deepcopy(recording)):
        assert np.array_equal(other.qpos, recording.qpos) and other.ending == recording.ending
        assert other.check().steps == 150 and repr(other) == repr(recording)
