"""A mobile manipulator before a shelf of thirty objects, and a conveyor: a world of two files and a few lines.

    python mobile_manipulator.py [FILM.mp4]

Builds the world, drives up to the shelf, certifies every step, and says how many seconds of the world one second of one core makes.
"""

import pathlib
import sys
import time
from typing import Optional, Tuple, Union

import numpy as np

import signorini

MODELS = pathlib.Path(__file__).parent / "models"


def stone(rng: np.random.Generator, radius: float, sides: int = 7) -> str:
    """A stone as the text of a mesh file: two tips over and under a ring."""
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = [(r * np.cos(a), r * np.sin(a), 0.2 * (radius - r)) for r, a in zip(radius * rng.uniform(0.8, 1.1, sides), angles)]
    corners = [*ring, (0, 0, 0.6 * radius), (0, 0, -0.6 * radius)]
    faces = [f"f {k + 1} {(k + 1) % sides + 1} {sides + 1}\nf {(k + 1) % sides + 1} {k + 1} {sides + 2}\n" for k in range(sides)]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(faces)


def build(folder: Union[str, pathlib.Path], seed: int = 0) -> signorini.Model:
    """The world; meshes are written into a folder."""
    rng, world = np.random.default_rng(seed), signorini.scene("mobile manipulator")
    world.timestep = 0.002
    world.floor(friction=0.8)
    world.load(MODELS / "base.xml")
    world.load(MODELS / "arm.xml", body="platform", pos=(0.15, 0, 0.15), prefix="arm ")
    for level in range(4):
        world.box((0.2, 0.6, 0.01), pos=(1.3, 0, 0.1 + 0.35 * level), rgba=(0.6, 0.45, 0.3, 1))
    for side in (-1, 1):
        world.box((0.2, 0.01, 0.65), pos=(1.3, 0.61 * side, 0.65), rgba=(0.5, 0.36, 0.24, 1))
    world.box((0.2, 1.0, 0.05), pos=(0, -1.5, 0.3), surface_velocity=(0, 0.3, 0), friction=0.9, rgba=(0.15, 0.15, 0.15, 1))
    for k in range(30):
        mesh = pathlib.Path(folder) / f"stone{k}.obj"
        mesh.write_text(stone(rng, 0.045))
        shelf = (1.3 + 0.1 * (k % 2) - 0.05, -0.5 + 0.125 * (k // 2 % 9), 0.155 + 0.35 * (k // 18))
        belt = (0.1 * (k % 2) - 0.05, -2.2 + 0.15 * (k // 2 % 3), 0.42)
        pos = shelf if k < 27 else belt
        world.solid("mesh", None, mesh=mesh, pos=pos, mass=0.3, name=f"stone {k}", friction=0.7, rgba=(*rng.uniform(0.3, 0.9, 3), 1))
    world.add_keyframe("start", ctrl=[0, 0, 0, 0, -0.6, 0, -2.2, 0, 1.6, 0.8, 0.04])
    return world.compile()


def run(model: signorini.Model, seconds: float, film: Optional[signorini.Film] = None) -> Tuple[signorini.Data, float, bool]:
    """Drives up to the shelf; the data, the seconds that took, and whether every step was certified."""
    data, renderer = signorini.Data(model), signorini.Renderer(model, 640, 360) if film is not None else None
    data.ctrl[:] = model.keyframe("start").ctrl
    data.qpos[3:10] = data.ctrl[3:10]
    certified, spent = True, 0.0
    for frame in range(round(30 * seconds)):
        data.ctrl[0] = 0.2 if frame < 45 else 0.0
        begin = time.perf_counter()
        signorini.step(model, data, nstep=round(1 / 30 / model.timestep))
        spent += time.perf_counter() - begin
        certified &= data.missed_steps == 0
        if film is not None and renderer is not None:
            film.add(renderer.render(data, signorini.View.orbit([0.6, -0.5, 0.5], 3.6, 35, -20)))
    return data, spent, certified


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        model = build(folder)
    film = signorini.Film(640, 360, fps=30) if len(sys.argv) > 1 else None
    data, spent, certified = run(model, 3.0, film)
    print(f"{model.nbody} bodies, {data.time:.1f} s in {spent:.2f} s of one core: {data.time / spent:.1f} times real time, certified: {certified}")
    if film is not None:
        film.save(sys.argv[1])
