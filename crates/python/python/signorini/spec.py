"""Models that can be edited."""

from __future__ import annotations

import os
from typing import Any, Optional, Sequence, Union

from signorini import _core
from signorini.model import Model

__all__ = ["Spec"]


class Spec(_core.Spec):
    """A model that can be edited: others attached to it, parts removed, compiled into a :class:`Model`.

    >>> from signorini import Spec
    >>> world = Spec.from_string("<mujoco><worldbody><geom type='plane'/></worldbody></mujoco>")
    >>> ball = Spec.from_string(
    ...     "<mujoco><worldbody><body name='ball'><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    >>> for k in range(3):
    ...     world.attach(ball, pos=(0, 0, 0.1 + 0.3 * k), prefix=f"{k} ")
    >>> world.compile().nbody
    4

    Args:
        model: the model to begin with; an empty world without one.
        name: the name of an empty world.
    """

    def __new__(cls, model: Optional[Model] = None, name: str = "world") -> Spec:
        return super().__new__(cls, model, name)

    @classmethod
    def from_file(cls, path: Union[str, "os.PathLike[str]"], **options: Any) -> Spec:
        """A copy of what a file describes; options as of :meth:`Model.from_file`."""
        return cls(Model.from_file(path, **options))

    @classmethod
    def from_string(cls, text: str, **options: Any) -> Spec:
        """A copy of what a text describes; options as of :meth:`Model.from_string`."""
        return cls(Model.from_string(text, **options))

    def attach(
        self,
        other: Union[Spec, Model, str],
        body: str = "world",
        *,
        pos: Sequence[float] = (0.0, 0.0, 0.0),
        quat: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        prefix: str = "",
    ) -> None:
        """Puts a spec, a model or the text of one at a body: what is fixed to its world is fixed to that body, at ``pos`` (m) and turned by
        ``quat`` (w, x, y, z). Names get ``prefix`` before them.

        Raises:
            ModelError: there is no such body, a name is taken, or a floating body would hang on something that is not the world; nothing has
                changed then.
        """
        if isinstance(other, str):
            other = Spec.from_string(other)
        elif isinstance(other, Model):
            other = Spec(other)
        self._attach(other, body, pos=tuple(map(float, pos)), quat=tuple(map(float, quat)), prefix=prefix)

    def compile(self) -> Model:
        """The model: what :meth:`to_mjcf` writes, read again.

        Raises:
            ModelError: the parts are no mechanism, or MJCF cannot say all of it; the message names the part.
        """
        text, left_out = self.to_mjcf()
        if left_out:
            from signorini.errors import ModelError

            raise ModelError("MJCF cannot say all of this model: " + "; ".join(left_out))
        return Model.from_string(text, format="mjcf")
