"""Pictures: what is where, beside rays and formulas."""

import os
import pickle
import struct
import subprocess
import zlib

import numpy as np
import pytest
import signorini

MODEL = """
<mujoco>
  <worldbody>
    <camera name="side" pos="-2 0 1" xyaxes="0 -1 0 0 0 1" fovy="40"/>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="ball" pos="0 0 1"><freejoint/><geom name="ball" size="0.25" rgba="1 0 0 1"/></body>
  </worldbody>
</mujoco>"""


@pytest.fixture
def scene():
    model = signorini.Model.from_string(MODEL)
    return model, signorini.Data(model)


def test_a_ball_before_a_camera(scene):
    model, data = scene
    renderer = signorini.Renderer(model, 121, 121)
    picture, depth = renderer.render(data, "side"), renderer.depth(data, "side")
    geoms = renderer.segmentation(data, "side")
    assert picture.shape == (121, 121, 3) and picture.dtype == np.uint8
    assert geoms.dtype == np.int32 and model.geom(int(geoms[60, 60])).name == "ball"
    # The middle ray meets the ball at its front.
    assert depth[60, 60] == pytest.approx(1.75, abs=1e-12)
    # The ball covers the disc of half-angle asin(r / d): a share of the picture.
    radius = np.tan(np.arcsin(0.25 / 2.0)) / np.tan(np.radians(20.0)) * 60.5
    assert (geoms == 1).sum() == pytest.approx(np.pi * radius**2, rel=0.01)
    # It is red, and nothing above it is anything.
    red, green, _ = picture[geoms == 1].mean(axis=0)
    assert red > 2 * green and geoms[0, 60] == -1 and np.isinf(depth[0, 60])
    # Rays of the engine see the same.
    hit = signorini.cast_ray(model, data, [-2, 0, 1], [1, 0, 0])
    assert hit.distance == pytest.approx(depth[60, 60], abs=1e-12)


def test_a_renderer_without_pixels_is_not_made(scene):
    model, _ = scene
    for name, size in (("width", (0, 10)), ("height", (10, 0)), ("width", (16385, 10)), ("height", (10, 10**9))):
        with pytest.raises(ValueError, match=f"^{name} = .*: must be from 1 to 16384 pixels"):
            signorini.Renderer(model, *size)
    signorini.Renderer(model, 16384, 1)


def test_pictures_follow_the_state(scene):
    model, data = scene
    # Odd sizes have a pixel in the middle.
    renderer = signorini.Renderer(model, 65, 49)
    view = renderer.framing(data)
    before = renderer.segmentation(data, view)
    data.qpos[:3] = 0.5, 0.0, 0.25
    after = renderer.segmentation(data, view)
    assert not np.array_equal(before, after)
    assert renderer.segmentation(data)[24, 32] == 1
    above = signorini.View.looking([0.5, 0.0, 3.0], [0.5, 0.0, 0.0])
    assert renderer.depth(data, above).min() == pytest.approx(2.5, abs=1e-12)
    assert np.allclose(signorini.View.orbit([0, 0, 0], 2.0, 90.0, 0.0).position, [0, -2, 0])


def test_what_is_wrong_is_said(scene):
    model, data = scene
    renderer = signorini.Renderer(model, 8, 8)
    with pytest.raises(ValueError, match="'front'.*side"):
        renderer.render(data, "front")
    with pytest.raises(ValueError, match="'sky' or 'white'"):
        signorini.Renderer(model, background="blue")
    with pytest.raises(ValueError, match="fovy"):
        signorini.View.looking([0, 0, 1], [0, 0, 0], fovy=0.0)
    with pytest.raises(signorini.SignoriniError, match="even"):
        signorini.Film(63, 48)


def test_files(scene, tmp_path):
    model, data = scene
    renderer = signorini.Renderer(model, 64, 48)
    picture = renderer.render(data)
    signorini.save_png(tmp_path / "ball.png", picture)
    assert np.array_equal(read_png(tmp_path / "ball.png"), picture)
    film = signorini.Film(64, 48, fps=25)
    for _ in range(5):
        film.add(renderer.render(data))
        signorini.step(model, data, 10)
    film.save(tmp_path / "ball.mp4")
    assert len(film) == 5 and (tmp_path / "ball.mp4").read_bytes()[4:8] == b"ftyp"
    with pytest.raises(ValueError, match="64"):
        film.add(np.zeros((48, 32, 3), dtype=np.uint8))
    try:
        program = __import__("imageio_ffmpeg").get_ffmpeg_exe()
    except ImportError:
        pytest.skip("no imageio-ffmpeg here: the film was not decoded")
    out = subprocess.run(
        [program, "-v", "error", "-i", os.fspath(tmp_path / "ball.mp4"), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    ).stdout
    frames = np.frombuffer(out, dtype=np.uint8).reshape(-1, 48, 64, 3)
    assert len(frames) == 5 and np.abs(frames[0].astype(int) - picture).mean() < 4


def read_png(path):
    """The pixels of a PNG of 8-bit colours, by its specification."""
    content, at, data, size = path.read_bytes(), 8, b"", (0, 0)
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at : at + 8])
        if kind == b"IHDR":
            size = struct.unpack(">II", content[at + 8 : at + 16])
        if kind == b"IDAT":
            data += content[at + 8 : at + 8 + length]
        at += 12 + length
    width, height = size
    rows = np.frombuffer(zlib.decompress(data), dtype=np.uint8).reshape(height, 3 * width + 1).astype(int)
    out = np.zeros((height, 3 * width), dtype=int)
    for y, row in enumerate(rows):
        above = out[y - 1] if y else np.zeros(3 * width, dtype=int)
        for x, value in enumerate(row[1:]):
            a, b, c = (out[y, x - 3] if x >= 3 else 0), above[x], (above[x - 3] if x >= 3 else 0)
            p = a + b - c
            paeth = min((a, b, c), key=lambda q: abs(p - q))
            out[y, x] = (value + [0, a, b, (a + b) // 2, paeth][row[0]]) % 256
    return out.reshape(height, width, 3).astype(np.uint8)


def checkered(path, seed):
    """A picture file of random colours."""
    signorini.save_png(path, np.random.default_rng(seed).integers(0, 256, (8, 8, 3), dtype=np.uint8))


def test_images_stay_on_what_is_compiled_pickled_and_recorded(tmp_path):
    """Of a plane, a box and a mesh, from files that are gone when the pickle is read."""
    for k in range(2):
        checkered(tmp_path / f"{k}.png", k)
    (tmp_path / "roof.obj").write_text(
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0.5 1\n"
        + "".join(f"f {a}/1 {b}/2 5/3\n" for a, b in [(1, 2), (2, 3), (3, 4), (4, 1)])
        + "f 4/1 3/2 2/3\nf 4/1 2/2 1/3\n"
    )
    (tmp_path / "world.xml").write_text(
        """<mujoco><asset><texture name="a" type="2d" file="0.png"/><texture name="b" type="2d" file="1.png"/>
        <material name="a" texture="a" texrepeat="2 2"/><material name="b" texture="b"/><mesh name="roof" file="roof.obj"/></asset>
        <worldbody><geom type="plane" size="2 2 1" material="a"/>
        <body pos="0 0 .5"><freejoint/><geom type="box" size=".5 .5 .4" material="b"/></body>
        <body pos="0 0 1"><freejoint/><geom type="mesh" mesh="roof" material="a"/></body></worldbody></mujoco>"""
    )

    def seen(model):
        return signorini.Renderer(model, 96, 72).render(signorini.Data(model), signorini.View.orbit([0, 0, 0.8], 6.0))

    model = signorini.Model.from_file(tmp_path / "world.xml")
    picture = seen(model)
    plain = seen(signorini.Model.from_file(tmp_path / "world.xml", visuals=False))
    assert np.mean(picture != plain) > 0.1
    compiled = signorini.Spec(model).compile()
    pickled, spec = pickle.dumps(compiled), pickle.dumps(signorini.Spec(model))
    for file in tmp_path.iterdir():
        file.unlink()
    assert (seen(compiled) == picture).all()
    again = pickle.loads(pickled)
    assert (seen(again) == picture).all() and (seen(pickle.loads(pickle.dumps(again))) == picture).all()
    assert (seen(pickle.loads(spec).compile()) == picture).all()
    data = signorini.Data(again)
    with data.record() as recorder:
        signorini.step(again, data, 2)
    assert recorder.recording.check()
    page = recorder.recording.to_html()
    assert isinstance(page, str) and page.count("data:image/jpeg") + page.count("/9j/") >= 2


def test_a_film_is_there_before_its_first_frame():
    film = signorini.Film(64, 48)
    assert film and len(film) == 0
