"""Generated worlds load, run and are certified."""

import numpy as np
import pytest
import signorini
from signorini import generate


@pytest.mark.parametrize(
    "text",
    [
        generate.heap(6, shapes="mixed", seed=5),
        generate.stack(3),
        generate.pallet(1),
        generate.wall(2, 2),
        generate.arch(5),
        generate.stairs(3, objects=2),
        generate.rough(12, objects=2),
        generate.terrain(np.arange(12.0).reshape(3, 4), size=(2.0, 1.0), objects=1),
    ],
    ids=["heap", "stack", "pallet", "wall", "arch", "stairs", "rough", "terrain"],
)
def test_worlds_run(text):
    model = signorini.Model.from_string(text)
    data = signorini.Data(model)
    for _ in range(10):
        signorini.step(model, data)
        assert data.certificate.holds(1e-9)
    assert model.nv > 0


def test_a_seed_decides_everything():
    assert generate.heap(4, seed=1) == generate.heap(4, seed=1) != generate.heap(4, seed=2)


def test_what_makes_no_world_is_named():
    with pytest.raises(ValueError, match="'cubes'"):
        generate.heap(3, shapes="cubes")
    with pytest.raises(ValueError, match="thickness"):
        generate.arch(5, thickness=-1.0)
    with pytest.raises(ValueError, match=r"\(3,\)"):
        generate.terrain([1.0, 2.0, 3.0])
