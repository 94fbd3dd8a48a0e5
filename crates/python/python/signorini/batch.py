"""Many simulations of one model at once."""

from __future__ import annotations

from typing import Any, Optional, Sequence, Tuple, Type, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from signorini import _core
from signorini._names import Key, Strict, index_of
from signorini._parameters import changes, check_name
from signorini.model import Model
from signorini.settings import Settings

__all__ = ["Batch"]


class Batch(Strict, _core.Batch):
    """Independent simulations of one model, stepped on threads; each makes the steps that it would make alone, bit for bit.

    ``time``, ``qpos``, ``qvel``, ``act``, ``ctrl``, ``mocap_pos`` and ``mocap_quat`` are live views with one row per simulation.

    A copy, or a pickle read in another process, goes on with the same bits: states, inputs, warm starts and changed parameters are in it, results and sums of
    past steps are not.

    Args:
        model: the model.
        nsim: number of simulations.
        settings: see :class:`Settings`.
        nthread: at most so many threads; 0 for as many as the machine runs at once. Results do not depend on it.
    """

    def __new__(cls, model: Model, nsim: int, settings: Settings = Settings(), nthread: int = 0) -> Batch:
        return super().__new__(cls, model, nsim, settings, nthread)

    def reset(self, ids: Optional[Sequence[int]] = None, keyframe: Optional[Key] = None) -> None:
        """Takes the simulations ``ids`` (all without it) to the reference configuration or to a keyframe (name or index)."""
        index = None if keyframe is None else index_of("keyframe", self.model.keyframe_names, keyframe)
        self._reset(ids, index)

    def parameter(self, name: str) -> NDArray[np.float64]:
        """Values of a parameter in every simulation, (nsim, …), read-only; names are those of ``PARAMETERS``."""
        check_name(name)
        return self._parameter(name)

    def change(self, ids: Optional[Sequence[int]] = None, **values: Any) -> None:
        """Goes on with other numbers of the model in the simulations ``ids`` (all without it); see :meth:`Data.change`.

        An array has one entry per simulation before those of a model, as ``parameter`` gives it, or none, for all alike:
        ``batch.change(geom_friction={"foot": rng.uniform(0.3, 1.2, nsim)})``, ``batch.change(body_mass=masses)`` with (nsim, nbody).

        Raises:
            ProblemError: there is no parameter of this name, or the numbers have another shape.
            ModelError: a part cannot have this number; simulations before the one that it names have changed.
        """
        chosen = self._simulations(ids)
        if chosen:
            self._change(chosen, changes(values, lambda name: self._parameter(name)[chosen], self.model._parameter_parts))

    def rollout(
        self,
        ctrl: Optional[ArrayLike] = None,
        nstep: Optional[int] = None,
        record: Union[str, Sequence[str]] = ("qpos", "qvel"),
    ) -> Tuple[NDArray[np.float64], ...]:
        """Makes steps and returns what was recorded after each, one array per name; the GIL is released meanwhile.

        Args:
            ctrl: control values of every step, (nsim, nstep, nu); without it, ``self.ctrl`` stays.
            nstep: number of steps, where ``ctrl`` does not say it.
            record: one or several of "qpos", (nsim, nstep, nq), "qvel", (nsim, nstep, nv), "act", (nsim, nstep, na), "sensordata",
                (nsim, nstep, nsensordata), "contact_wrench", (nsim, nstep, nbody, 6), and "residual", (nsim, nstep), each as the attribute of this name.

        Raises:
            BatchError: simulations stopped; the others made all their steps.
            ProblemError: ``ctrl`` has another shape, or nothing has a name in ``record``.
        """
        return tuple(self._rollout(ctrl, nstep, [record] if isinstance(record, str) else list(record)))

    def __reduce__(self) -> Tuple[Any, ...]:
        return _rebuild, (type(self), self.model, len(self), self.settings, self.nthread, self._save())

    def __repr__(self) -> str:
        return f"<signorini.Batch of {len(self)} simulations of '{self.model.name}'>"


def _rebuild(
    cls: Type[Batch],
    model: Model,
    nsim: int,
    settings: Settings,
    nthread: int,
    saved: Sequence[Tuple[bytes, Sequence[Tuple[str, Sequence[float]]]]],
) -> Batch:
    batch = cls(model, nsim, settings, nthread)
    batch._restore(saved)
    return batch
