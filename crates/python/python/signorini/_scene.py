"""Worlds for every day: a floor, boxes, files, many of something."""

from __future__ import annotations

import os
from typing import Any, Callable, List, Optional, Sequence, Union

from signorini.model import Model
from signorini.spec import Spec, SpecPart

__all__ = ["Scene", "scene"]

PathLike = Union[str, "os.PathLike[str]"]


class Scene(Spec):
    """A :class:`Spec` with words for what worlds are mostly made of.

    >>> import signorini
    >>> world = signorini.scene()
    >>> floor = world.floor(friction=0.6)
    >>> table = world.box((0.4, 0.3, 0.02), pos=(0.5, 0, 0.4))
    >>> crates = world.grid(3, 2, spacing=0.15, at=(0.3, -0.1, 0.48), make=lambda name, pos: world.box(
    ...     (0.05, 0.05, 0.05), pos=pos, mass=0.4, name=name))
    >>> world.compile().nbody
    7
    """

    def floor(self, friction: Optional[float] = None, name: str = "floor", **attributes: Any) -> SpecPart:
        """The plane z = 0. Without a ``friction`` it has 0, so that the friction of what stands on it counts."""
        return self.add_geom("world", "plane", name, size=(0, 0, 1), friction=0.0 if friction is None else friction, **attributes)

    def box(self, half_extents: Sequence[float], **options: Any) -> SpecPart:
        """A box with these half-lengths, m; see :meth:`solid`."""
        return self.solid("box", half_extents, **options)

    def ball(self, radius: float, **options: Any) -> SpecPart:
        """A ball of this radius, m; see :meth:`solid`."""
        return self.solid("sphere", radius, **options)

    def cylinder(self, radius: float, half_length: float, **options: Any) -> SpecPart:
        """An upright cylinder, m; see :meth:`solid`."""
        return self.solid("cylinder", (radius, half_length), **options)

    def solid(
        self,
        type: str,
        size: Union[float, Sequence[float], None],
        *,
        pos: Sequence[float] = (0.0, 0.0, 0.0),
        quat: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        mass: Optional[float] = None,
        density: Optional[float] = None,
        name: Optional[str] = None,
        **attributes: Any,
    ) -> SpecPart:
        """A solid of one geom: with ``mass`` (kg) or ``density`` (kg/m³) a body that moves freely, otherwise fixed to the world.

        ``size`` is None for a mesh. Other attributes are those of the geom (``friction``, ``rgba``, ``mesh``, ``surface_velocity``, …).
        Gives the body, or the geom of the world.
        """
        if mass is None and density is None:
            return self.add_geom("world", type, name, size=size, pos=pos, quat=quat, **attributes)
        body = self.add_body(name if name is not None else self._free_name("body", None, type), pos=pos, quat=quat)
        self.add_joint(body, "free", f"{body.name} free")
        self.add_geom(body, type, body.name, size=size, mass=mass, density=density, **attributes)
        return body

    def load(
        self,
        source: Union[PathLike, Model, Spec],
        *,
        pos: Sequence[float] = (0.0, 0.0, 0.0),
        quat: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        prefix: str = "",
        body: Union[str, SpecPart] = "world",
        **options: Any,
    ) -> List[str]:
        """Puts a file of any format, its text, a model or a spec at a body; names get ``prefix`` before them. Other options are those of
        :meth:`Model.from_file`. Gives the names of the bodies that came.
        """
        if isinstance(source, (Model, Spec)):
            other: Union[Model, Spec] = source
        elif isinstance(source, str) and source.lstrip().startswith("<"):
            other = Model.from_string(source, **options)
        else:
            other = Model.from_file(source, **options)
        before = set(self.names("body"))
        self.attach(other, body, pos=pos, quat=quat, prefix=prefix)
        return [name for name in self.names("body") if name not in before]

    def grid(
        self,
        *counts: int,
        spacing: Union[float, Sequence[float]],
        make: Callable[[str, Sequence[float]], Any],
        at: Sequence[float] = (0.0, 0.0, 0.0),
        name: str = "grid",
    ) -> List[Any]:
        """Many of something on a grid of up to three ``counts``, from ``at`` on along x, y, z.

        Args:
            counts: how many along each axis.
            spacing: distance of neighbours, m, one number or one for each axis.
            make: makes one; is given a name of its own and the place, (3,), m.
            at: place of the first.
            name: what the names begin with.
        """
        steps = [float(spacing)] * 3 if isinstance(spacing, (int, float)) else [float(x) for x in spacing]
        nx, ny, nz = [*counts, 1, 1, 1][:3]
        places = [(i, j, k) for k in range(nz) for j in range(ny) for i in range(nx)]
        made = []
        for count, place in enumerate(places):
            pos = tuple(float(x) + step * k for x, step, k in zip(at, [*steps, 0.0, 0.0], place))
            made.append(make(f"{name} {count}", pos))
        return made


def scene(name: str = "scene") -> Scene:
    """An empty world to be filled; see :class:`Scene`."""
    return Scene(name=name)
