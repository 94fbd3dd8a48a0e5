"""Parameters of a model from recorded motions."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from signorini import _core
from signorini._core import identify_parameters, parameter_values
from signorini.model import Model
from signorini.settings import Settings

_Array = NDArray[np.float64]


def with_parameters(model: Model, parameters: Sequence[Any], values: Any) -> Model:
    """The model with other values of parameters, (n,); numbers that change together change by their shares.

    Args:
        parameters: as for ``derivatives``.

    Raises:
        ValueError: a parameter is no number of the model, or a value is not finite.
        ModelError: a value is out of its range; the message names part, number and range.
    """
    numbers = [float(value) for value in values]
    return model._changed(_core.with_parameters(model, parameters, numbers), (list(parameters), numbers))


@dataclass(frozen=True)
class Unknown:
    """A number that is looked for.

    Attributes:
        parameter: what it is in the model, as for ``signorini.derivatives``: ``("body_mass", "cube")``, or a list of numbers that change
            together, such as ``[("geom_friction", "cube"), ("geom_friction", "floor")]``, or a dictionary of them with their shares.
        bounds: least and largest value; where a model may have less, such as no negative friction, that.
        prior: a value and its standard deviation that are known before; ``None`` for none.
        start: where to begin; ``None`` takes the model's value.
        name: in the report; ``None`` makes one of the parameter.
    """

    parameter: Any
    bounds: tuple[float, float] = (-math.inf, math.inf)
    prior: Optional[tuple[float, float]] = None
    start: Optional[float] = None
    name: Optional[str] = None

    @property
    def label(self) -> str:
        """The name, or one made of the parameter."""
        if self.name is not None:
            return self.name
        first = next(iter(self.parameter)) if isinstance(self.parameter, (list, dict)) else self.parameter
        if isinstance(first, str):
            return first
        name, *rest = first
        return f"{name}[{', '.join(str(part) for part in rest)}]"


@dataclass(frozen=True)
class Identification:
    """What :func:`identify` found.

    Attributes:
        names, values: of the unknowns.
        covariance: of the values, (n, n): how far another set of such recordings would move them, from the spread of the recordings' gradients, robust to a model that
            is not true and to samples that hang together, or from drawn sets (``draws``); infinite for what the data leave open.
        determined: whether the data determine each of them.
        at_bound: whether each ended at a bound.
        objective: per sample, at the beginning and at the end.
        deviation: root of the mean square of the weighted differences.
        iterations, converged: of the method.
        steps: steps that were differentiated at the end, and those of them that had no derivative.
        model: the model with these values.
    """

    names: tuple[str, ...]
    values: _Array
    covariance: _Array
    determined: tuple[bool, ...]
    at_bound: tuple[bool, ...]
    objective: tuple[float, float]
    deviation: float
    iterations: int
    converged: bool
    steps: tuple[int, int]
    model: Model

    @property
    def standard_errors(self) -> _Array:
        """Roots of the covariance's diagonal, (n,)."""
        return np.sqrt(np.diag(self.covariance))

    def report(self) -> str:
        """A table of the values, and what the data do not determine."""
        lines = [f"{'parameter':<32} {'value':>12} {'± error':>10}"]
        for name, value, error, determined, bound in zip(
            self.names, self.values, self.standard_errors, self.determined, self.at_bound
        ):
            note = "" if determined else "  not determined by these recordings"
            note += "  at its bound" if bound else ""
            lines.append(f"{name:<32} {value:>12.6g} {error:>10.2g}{note}")
        end = "converged" if self.converged else "not converged"
        before, after = self.objective
        lines.append(f"objective per sample {before:.4g} → {after:.4g}, deviation {self.deviation:.4g}, {end} after {self.iterations} steps")
        if self.steps[1]:
            lines.append(f"{self.steps[1]} of {self.steps[0]} steps have no derivative: differences took its place")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.report()


Recorded = Union[Mapping[str, Any], Sequence[Any]]


def identify(
    model: Model,
    recordings: Iterable[Recorded],
    parameters: Sequence[Any],
    *,
    interval: float,
    substeps: int = 1,
    window: Optional[int] = None,
    weights: Optional[Sequence[float]] = None,
    outlier: Optional[float] = None,
    equal_recordings: bool = False,
    starts: int = 0,
    draws: int = 0,
    iterations: int = 30,
    tolerance: float = 1e-4,
    settings: Optional[Settings] = None,
    progress: Union[bool, Callable[[int, float, _Array], Any]] = False,
) -> Identification:
    """Looks for the numbers of a model with which it moves as recorded: Gauss and Newton's method over trajectories, damped.

    Contact makes the objective rough; a step is taken only where it lowers the objective, and what is found is a minimum nearby.

    Args:
        recordings: samples at equal intervals, each as (qpos, qvel) or (qpos, qvel, ctrl), or as a mapping with these names: (n, nq),
            (n, nv), (n − 1, nu). A mapping may have activations of actuators as ``act``, (n, na); without, they are zero where a recording
            begins.
        parameters: :class:`Unknown`, or what ``signorini.derivatives`` takes as a parameter.
        interval: time between two samples, s.
        substeps: steps of the simulation between them.
        window: intervals after which the simulation begins again at a recorded state; ``None`` follows whole recordings.
        weights: factors on differences of qpos in tangent coordinates, (nv,).
        outlier: weighted difference of a sample from which on it counts by its size and not by its square; ``None`` for squares.
        equal_recordings: whether recordings count the same, however long they are; otherwise samples do.
        starts: places within the bounds, which have to be finite then, at which the objective is looked at before the method begins at the best of
            them and of the model's own values: contact makes objectives with many valleys.
        draws: sets of recordings to be drawn from those at hand and fitted, for the covariance (B. Efron's bootstrap); below 2 it comes from the spread of
            the recordings' gradients, which tell too little where trajectories are chaotic: their slopes are then those of single trajectories.
        iterations: steps of the method at most.
        tolerance: it ends where a step lowers the objective by less than this part.
        settings: of the simulation; its timestep is ``interval / substeps``.
        progress: ``True`` shows a line; a function gets iteration, objective per sample and values, and ends it with ``False``.

    Raises:
        ValueError: a parameter is no number of the model, or arrays do not fit.
    """
    unknowns = [p if isinstance(p, Unknown) else Unknown(p) for p in parameters]
    specs = [unknown.parameter for unknown in unknowns]
    present = parameter_values(model, specs)
    begin = [value if unknown.start is None else unknown.start for unknown, value in zip(unknowns, present)]
    if not np.array_equal(begin, present):
        model = with_parameters(model, specs, begin)
    given = [_samples(recording) for recording in recordings]
    if model.na and window and any(act is None for *_, act in given):
        raise ValueError(f"the model has {model.na} activations of actuators: where windows begin within recordings, these need 'act', (n, {model.na})")
    asked = [(u.label, u.parameter, list(u.bounds), None if u.prior is None else list(u.prior)) for u in unknowns]
    told = _show if progress is True else (progress or None)
    found = identify_parameters(
        model,
        given,
        asked,
        settings if settings is not None else Settings(),
        interval,
        substeps,
        window or 0,
        [] if weights is None else [float(w) for w in weights],
        outlier or 0.0,
        equal_recordings,
        starts,
        draws,
        iterations,
        tolerance,
        told,
    )
    if progress is True:
        print(file=sys.stderr)
    return Identification(
        names=tuple(u.label for u in unknowns),
        values=found.values,
        covariance=found.covariance,
        determined=tuple(found.determined),
        at_bound=tuple(found.at_bound),
        objective=found.objective,
        deviation=found.deviation,
        iterations=found.iterations,
        converged=found.converged,
        steps=found.steps,
        model=with_parameters(model, specs, found.values),
    )


def _samples(recording: Recorded) -> tuple[Any, Any, Any, Any]:
    if isinstance(recording, Mapping):
        return recording["qpos"], recording["qvel"], recording.get("ctrl"), recording.get("act")
    qpos, qvel, *rest = recording
    return qpos, qvel, rest[0] if rest else None, None


def _show(iteration: int, objective: float, values: _Array) -> bool:
    numbers = " ".join(f"{value:.5g}" for value in values)
    print(f"\rstep {iteration:3d}  objective {objective:.6g}  {numbers}", end="", file=sys.stderr, flush=True)
    return True
