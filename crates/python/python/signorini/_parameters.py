"""Parameters that change without compiling: from what a user writes to all values of an array."""

from __future__ import annotations

import difflib
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from signorini import _core
from signorini._names import index_of
from signorini.errors import ProblemError

__all__ = ["PARAMETERS", "Parameter", "changes", "check_name"]

Array = NDArray[np.float64]


class Parameter(NamedTuple):
    """A parameter that can change without compiling."""

    sort: str
    """The sort of part that has it: "body", "joint", "geom", …, or "model"."""
    shape: Tuple[int, ...]
    """Shape of one part's numbers; empty for a single one."""
    prepares_search: bool
    """Whether a change prepares the search for contacts anew, besides copying the model's numbers."""


PARAMETERS: Dict[str, Parameter] = {
    name: Parameter(sort, tuple(shape), search) for name, sort, shape, search in _core.parameter_table()
}
"""All parameters by name."""


def check_name(name: str) -> Parameter:
    """The parameter of this name.

    Raises:
        ProblemError: there is none; the message lists those there are.
    """
    if name in PARAMETERS:
        return PARAMETERS[name]
    near = difflib.get_close_matches(name, PARAMETERS, n=1)
    hint = f"; did you mean '{near[0]}'?" if near else "."
    raise ProblemError(f"there is no parameter '{name}'{hint} There are {', '.join(PARAMETERS)}")


def all_values(name: str, value: Any, present: Array, names: Sequence[str]) -> Array:
    """All values of a parameter after a change.

    Args:
        name: the parameter.
        value: numbers for all parts, or a mapping from parts (name or index) to their numbers.
        present: values now, with one axis for simulations before those of a single model.
        names: of the parts.
    """
    parameter = check_name(name)
    out = np.array(present)
    if isinstance(value, Mapping):
        if parameter.sort == "model":
            raise ProblemError(f"{name} belongs to the model as a whole: give its numbers")
        for key, numbers in value.items():
            part = index_of(parameter.sort, names, key)
            at = np.moveaxis(out, 1, 0)[part]
            at[...] = _fit(f"{name} of '{key}'", name, numbers, at)
        return out
    if parameter.sort == "body" and np.ndim(value) == 0:
        out[:, 1:] = _fit(name, name, value, out[:, 1:])  # The world has none.
        return out
    out[...] = _fit(name, name, value, out)
    return out


def _fit(what: str, name: str, value: Any, present: Array) -> Array:
    """Numbers in the shape of those there are; one number of friction is that of sliding."""
    try:
        given = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ProblemError(f"{what} cannot be read as numbers: {error}") from None
    out = np.array(present)
    try:
        if name in ("geom_friction", "pair_friction") and given.shape in ((), out.shape[:-1], out.shape[1:-1]):
            out[..., 0] = given
        else:
            out[...] = given
    except ValueError:
        shapes = f"{out.shape[1:]}" if len(out) == 1 else f"{out.shape[1:]}, or {out.shape} with one entry per simulation"
        raise ProblemError(f"{what} has shape {given.shape}, expected {shapes}") from None
    return out


def changes(
    values: Mapping[str, Any], present: Callable[[str], Array], parts: Callable[[str], Sequence[str]]
) -> List[Tuple[str, List[float]]]:
    """What the native half takes: names with all values, row after row.

    Args:
        values: what a user wrote, by name.
        present: values now, with an axis for simulations.
        parts: names of the parts that have a parameter.
    """
    for name in values:
        check_name(name)
    return [(name, all_values(name, value, present(name), parts(name)).ravel().tolist()) for name, value in values.items()]
