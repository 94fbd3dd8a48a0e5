"""Exceptions and warnings of the package."""

from __future__ import annotations

from typing import Optional, Sequence

__all__ = [
    "BatchError",
    "ModelError",
    "ModelWarning",
    "OverlapWarning",
    "ProblemError",
    "RecordingError",
    "SettingError",
    "SignoriniError",
    "SolveError",
    "StateError",
    "ToleranceWarning",
]


class SignoriniError(Exception):
    """Base of the package's exceptions."""


class ModelError(SignoriniError, ValueError):
    """A model file that cannot become a model.

    Attributes:
        file: the file, or a label for text that came from memory; ``None`` where no file is to blame.
        line: line from 1, or ``None``.
        column: column from 1, or ``None``.
    """

    def __init__(
        self, message: str, file: Optional[str] = None, line: Optional[int] = None, column: Optional[int] = None
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column


class SettingError(SignoriniError, ValueError):
    """A setting outside its range, or a method that does not exist."""


class StateError(SignoriniError, ValueError):
    """A state or input that does not fit its model: wrong length, NaN, a quaternion that is not of unit length."""


class ProblemError(SignoriniError, ValueError):
    """Malformed data of a contact problem or of an LCP; the message names the array and the index."""


class SolveError(SignoriniError, RuntimeError):
    """A step whose contact problem has no solution, or none that was found, or whose motion has blown up; the state is the one before the step. Or a
    state that does not come to rest.

    Attributes:
        status: "unresolved" or "infeasible" (see ``StepReport.status``), or "diverged" where speeds have become so large that the next state is not
            finite; of :func:`signorini.settle` "not_settled".
        contacts: contacts that contradict each other, indices into the step's problem.
        time: time of the state, s.
    """

    def __init__(
        self, message: str, status: str = "", contacts: Sequence[int] = (), time: Optional[float] = None
    ) -> None:
        super().__init__(message)
        self.status = status
        self.contacts = list(contacts)
        self.time = time


class BatchError(SignoriniError, RuntimeError):
    """Simulations of a batch that stopped early; each is in the state before the step that failed, the others went on.

    Attributes:
        ids: numbers of the simulations that stopped.
        reasons: why, in the same order.
    """

    def __init__(self, message: str, ids: Sequence[int] = (), reasons: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.ids = list(ids)
        self.reasons = list(reasons)


class RecordingError(SignoriniError, OSError):
    """A recording that cannot be written or read."""


class ModelWarning(UserWarning):
    """Something in a model file that the model has not, or has in another form, and that can change the motion.

    It is issued at its place in the model file, so that a traceback shows file, line and text.

    Attributes:
        file, line, element, what, effect, count: as in ``ImportWarning``.
    """

    def __init__(
        self, message: str, file: str = "", line: int = 0, element: str = "", what: str = "", effect: str = "", count: int = 1
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.element = element
        self.what = what
        self.effect = effect
        self.count = count


class ToleranceWarning(UserWarning):
    """Steps whose residuals exceed the tolerance of the settings."""


class OverlapWarning(UserWarning):
    """A run that begins with shapes inside each other, or with violated constraints, by more than a step removes."""
