"""What no input may do: end the interpreter, hang, or leave a message that is not true."""

import os
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest

import signorini
from signorini import Batch, Model, Settings

BALL = """<mujoco><worldbody><geom type="plane" size="1 1 1"/>
    <body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""


def test_sizes_are_bounded():
    with pytest.raises(signorini.SettingError, match="at most 4096"):
        signorini.Data(Model.from_string(BALL), Settings(directions=1_000_000_000))
    batch = Batch(Model.from_string(BALL), 2)
    with pytest.raises(MemoryError, match="one call gives back"):
        batch.rollout(nstep=10**15)
    with pytest.raises(MemoryError):
        batch.rollout(nstep=2**63 - 1)
    batch.step(3)
    assert (batch.time > 0.0).all()


def test_counts_are_named_where_they_are_none(tmp_path):
    model = Model.from_string(BALL)
    data, batch = signorini.Data(model), Batch(model, 2)
    signorini.step(model, data)
    with data.record() as recorder:
        signorini.step(model, data)
    calls = {
        "nstep": [lambda n: signorini.step(model, data, n), lambda n: batch.step(n), lambda n: batch.rollout(nstep=n)],
        "nsim": [lambda n: Batch(model, n)],
        "nthread": [lambda n: Batch(model, 2, nthread=n), lambda n: signorini.cast_rays(model, data, [[0, 0, 1]], [[0, 0, -1]], nthread=n)],
        "max_steps": [lambda n: signorini.settle(model, data, max_steps=n)],
        "enumeration": [lambda n: signorini.stability(model, data, enumeration=n)],
        "max_frames": [lambda n: recorder.recording.to_html(max_frames=n)],
        "count": [signorini.generate.heap, signorini.generate.stack],
        "seed": [lambda n: signorini.generate.heap(3, seed=n)],
        "width": [lambda n: signorini.Renderer(model, n, 10), lambda n: signorini.Film(n, 10)],
        "samples": [lambda n: signorini.Renderer(model, samples=n)],
    }
    for name, takers in calls.items():
        for take in takers:
            for count in (-1, -(2**70)):
                with pytest.raises(ValueError, match=f"^{name} = {count}: must not be negative"):
                    take(count)
            with pytest.raises(ValueError, match=f"^{name} = {2**70}: is too large"):
                take(2**70)
            with pytest.raises(TypeError, match=f"'{name}'"):
                take("three")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forking is POSIX")
def test_a_forked_child_makes_its_own_batch_and_is_told_of_the_parent_s():
    program = f"""
import os, sys
from signorini import Batch, Model
model = Model.from_string({BALL!r})
batch = Batch(model, 8)
batch.step(5)
child = os.fork()
if child == 0:
    try:
        batch.step()
        os._exit(1)
    except RuntimeError as error:
        if "forked" not in str(error):
            os._exit(2)
    own = Batch(model, 8)
    own.step(5)
    os._exit(0 if (own.qpos == batch.qpos).all() else 3)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
    ended = subprocess.run([sys.executable, "-W", "ignore", "-c", program], timeout=60)
    assert ended.returncode == 0


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a full disk is a device of Linux")
def test_a_full_disk_is_an_error_that_names_the_file(tmp_path):
    model = Model.from_string(BALL)
    data = signorini.Data(model)
    with data.record() as recorder:
        signorini.step(model, data, 3)
    recording, problem = recorder.recording, data.problem()
    picture, film = np.zeros((16, 16, 3), np.uint8), signorini.Film(16, 16)
    film.add(picture)
    stability = signorini.stability(model)
    limit = signorini.safety(model, what="tilt", direction=(1, 0, 0))

    def record(path):
        with data.record(path):
            signorini.step(model, data)

    outputs = [
        (recording.save, ".rec"), (recording.to_html, ".html"), (recording.to_npz, ".npz"), (recording.to_csv, ".csv"),
        (recording.to_mcap, ".mcap"), (problem.save, ".npz"), (stability.save, ".npz"), (film.save, ".mp4"),
        (lambda path: signorini.save_png(path, picture), ".png"), (record, ".rec"),
    ]
    for write, ending in outputs:
        old, full = tmp_path / f"old{ending}", tmp_path / f"full{ending}"
        write(old)
        size = old.stat().st_size
        assert size > 0
        if not full.exists():
            full.symlink_to("/dev/full")
        with pytest.raises((OSError, signorini.SignoriniError), match=f"full{ending}") as error:
            write(full)
        assert "No space left" in str(error.value)
        with pytest.raises((OSError, signorini.SignoriniError), match="nowhere"):
            write(tmp_path / "nowhere" / "a")
    (tmp_path / "limit-falls.npz").symlink_to("/dev/full")
    with pytest.raises((OSError, signorini.SignoriniError), match="limit-falls.npz"):
        limit.save(tmp_path / "limit")


def test_a_header_with_impossible_sizes_is_refused(tmp_path):
    model = Model.from_string(BALL)
    data = signorini.Data(model)
    path = tmp_path / "run.rec"
    with data.record(path):
        signorini.step(model, data, 3)
    content = path.read_bytes()
    version, length, _ = struct.unpack_from("<III", content, 8)
    header = content[20 : 20 + length].replace(b'"nq":7,', b'"nq":100000000007,')
    assert header != content[20 : 20 + length]
    damaged = tmp_path / "damaged.rec"
    damaged.write_bytes(
        content[:8] + struct.pack("<III", version, len(header), zlib.crc32(header)) + header + content[20 + length :]
    )
    with pytest.raises(signorini.SignoriniError, match="nq"):
        signorini.Recording.load(damaged)
    assert np.isfinite(signorini.Recording.load(path).qpos).all()
