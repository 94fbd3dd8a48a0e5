"""The examples with an arm: a mobile manipulator before a shelf, and cubes that are picked and stacked."""

import importlib.util
import inspect
import pathlib

import numpy as np
import pytest

import signorini

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("seed", [0, 4])
def test_a_mobile_manipulator_before_a_shelf(tmp_path, seed):
    program = example("mobile_manipulator")
    assert len(inspect.getsource(program.build).splitlines()) <= 40
    model = program.build(tmp_path, seed)
    film = signorini.Film(640, 360, fps=30) if seed == 0 else None
    data, _, certified = program.run(model, 1.0, film)
    assert certified and data.time == pytest.approx(1.0, abs=0.05)
    stones = np.array([data.body(f"stone {k}").xpos for k in range(30)])
    # Those on the shelf lie on its boards, those on the belt have gone with it.
    assert np.all(np.abs(stones[:27, 0] - 1.3) < 0.2) and np.all(stones[:27, 2] > 0.11)
    assert np.all(stones[27:, 1] > [-2.2 + 0.15 * k + 0.15 for k in (13 % 3, 14 % 3, 14 % 3)])
    # The platform goes as fast as it is told, up to what damps it.
    assert data.joint("along").qpos[0] == pytest.approx(0.2 * data.time, abs=0.03)
    if seed == 0:
        assert len(film) == 30
        film.save(tmp_path / "run.mp4")
        assert (tmp_path / "run.mp4").stat().st_size > 10_000


def test_cubes_are_picked_and_stacked():
    program = example("pick_and_stack")
    model = program.build()
    data = signorini.Data(model)
    program.stack(model, data)
    assert data.missed_steps == 0
    places = np.array([data.body(f"cube {k}").xpos for k in (1, 0, 2)])
    assert places[:, 2] == pytest.approx([0.02, 0.06, 0.10], abs=1e-6)
    assert np.abs(places[1:, :2] - places[0, :2]).max() < 0.005
