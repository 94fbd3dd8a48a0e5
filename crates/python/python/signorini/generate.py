"""Worlds to simulate, made by rule and by seed, as MJCF text.

>>> import signorini
>>> text = signorini.generate.heap(20, shapes="mixed", seed=3)
>>> model = signorini.Model.from_string(text)
>>> model.nv
120

The same arguments give the same text on every machine; its first line says how it was made. Write it to a file to keep it, or put it into
another model with :class:`signorini.Spec`. A ``ValueError`` names an argument that makes no world.
"""

from __future__ import annotations

from typing import Literal, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import ArrayLike

from signorini import _core

__all__ = ["arch", "heap", "pallet", "rough", "stack", "stairs", "terrain", "wall"]


def heap(
    count: int = 30,
    *,
    shapes: Literal["boxes", "spheres", "stones", "mixed"] = "boxes",
    radius: float = 0.05,
    friction: float = 0.6,
    bin: bool = True,
    seed: int = 0,
) -> str:
    """Random objects of about a radius (m) that fall into a bin, or onto the floor where there is none."""
    return _core.make_heap(count, shapes, radius, friction, bin, seed)


def stack(count: int = 10, *, size: float = 0.2, offset: float = 0.0, friction: float = 0.6, seed: int = 0) -> str:
    """Cubes of an edge (m) on top of each other, each off the one below by up to ``offset`` of its length."""
    return _core.make_stack(count, size, offset, friction, seed)


def pallet(layers: int = 4, *, friction: float = 0.5, free: bool = True) -> str:
    """Boxes in layers on a pallet that can move, or is part of the floor."""
    return _core.make_pallet(layers, friction, free)


def wall(
    columns: int = 8, courses: int = 10, *, brick: Sequence[float] = (0.24, 0.115, 0.071), friction: float = 0.7
) -> str:
    """Bricks of a length, width and height (m) in running bond."""
    return _core.make_wall(columns, courses, brick, friction)


def arch(
    count: int = 15, *, radius: float = 1.0, thickness: float = 0.26, depth: float = 0.3, friction: float = 0.7
) -> str:
    """A half-circle of wedges of an inner radius and a depth (m); ``thickness`` is a share of the mean radius, and below 0.108 none stands."""
    return _core.make_arch(count, radius, thickness, depth, friction)


def stairs(
    steps: int = 8,
    *,
    rise: float = 0.17,
    run: float = 0.29,
    width: float = 1.0,
    friction: float = 0.8,
    objects: int = 0,
    seed: int = 0,
) -> str:
    """Steps of a height, length and width (m) that lead up along x, with objects that fall onto them."""
    return _core.make_stairs(steps, rise, run, width, friction, objects, seed)


def rough(
    points: int = 64,
    *,
    size: float = 6.0,
    height: float = 0.4,
    roughness: float = 0.45,
    friction: float = 0.9,
    objects: int = 0,
    seed: int = 0,
) -> str:
    """Random hills on a grid of points by points, with sides and a height (m); ``roughness`` 0 gives smooth ones, 1 the roughest."""
    return _core.make_rough(points, size, height, roughness, friction, objects, seed)


def terrain(
    heights: ArrayLike,
    *,
    size: Optional[Tuple[float, float]] = None,
    height: float = 1.0,
    friction: float = 0.9,
    objects: int = 0,
    seed: int = 0,
) -> str:
    """A height field, as of the brightness of a picture.

    Args:
        heights: in any unit, (rows, columns), rows from the lowest y on: ``image[::-1]`` of a picture.
        size: lengths along x and y, m; 10 cm between points where it is not given.
        height: between the lowest and the highest point, m.
        friction: coefficient of friction.
        objects: number of objects that fall onto it.
        seed: which objects.
    """
    array = np.asarray(heights, dtype=np.float64)
    if array.ndim != 2:
        raise ValueError(f"heights have shape {array.shape}, expected (rows, columns)")
    rows, columns = array.shape
    return _core.make_terrain(array, size or (0.1 * max(columns - 1, 1), 0.1 * max(rows - 1, 1)), height, friction, objects, seed)
