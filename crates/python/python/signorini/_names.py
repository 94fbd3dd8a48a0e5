"""Lookup by name, with errors that help."""

from __future__ import annotations

import difflib
import operator
from typing import Any, Sequence, Union

Key = Union[str, int]


class Strict:
    """A class whose objects refuse attributes that it does not have, so that a misspelt one is no silent no-op."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and not hasattr(type(self), name):
            known = [word for word in dir(type(self)) if not word.startswith("_")]
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise AttributeError(f"{type(self).__name__} has no attribute '{name}'{hint}", name=name, obj=self)
        super().__setattr__(name, value)


def index_of(sort: str, names: Sequence[str], key: Key) -> int:
    """Index of a part by its name or index (negative counts from the end).

    Raises:
        KeyError: no part has this name; the message lists the names there are, the most similar first.
        IndexError: the index is out of range.
        TypeError: the key is neither a name nor an index.
    """
    if isinstance(key, str):
        try:
            return names.index(key)
        except ValueError:
            raise KeyError(_message(sort, names, key)) from None
    try:
        index = operator.index(key)
    except TypeError:
        raise TypeError(f"a {sort} is asked for by its name or its index, not by {key!r}") from None
    count = len(names)
    if -count <= index < count:
        return index % count
    raise IndexError(f"{sort} {index}: the model has {count}")


def _message(sort: str, names: Sequence[str], key: str) -> str:
    if not names:
        return f"there is no {sort} '{key}'; the model has none"
    similarity = {name: difflib.SequenceMatcher(None, key.lower(), name.lower()).ratio() for name in names}
    nearest = sorted(names, key=lambda name: -similarity[name])
    return f"there is no {sort} '{key}'; valid names: {', '.join(repr(name) for name in nearest)}"
