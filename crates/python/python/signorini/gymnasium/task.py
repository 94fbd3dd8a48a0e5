"""What an environment asks of a model: starts, observations, rewards."""

from __future__ import annotations

import functools
import pathlib
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Dict, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from signorini import Batch, Model

__all__ = ["Array", "Judgement", "Task"]

Array = NDArray[np.float64]

_MODELS = pathlib.Path(__file__).parent / "models"


class Judgement(NamedTuple):
    """What a task says about a step of each of n simulations."""

    reward: Array
    """(n,)."""
    terminated: NDArray[np.bool_]
    """Whether the episode has come to an end of the task's own, (n,)."""
    info: Dict[str, NDArray[np.generic]]
    """Numbers for ``info``, (n,) each."""


@dataclass(frozen=True)
class Task(ABC):
    """A task on a model, for any number of simulations at once; it keeps nothing between calls.

    Rows of its arrays belong to simulations, and a row depends on that simulation alone. Subclasses are dataclasses whose
    fields are the parameters of the environment; :class:`Env` and :class:`VectorEnv` take an instance or a name.
    """

    file: ClassVar[str]
    """MJCF file of the model; names without a folder are those of the package."""
    frame_skip: ClassVar[int]
    """Steps of the engine for one action."""
    picture_size: ClassVar[Tuple[int, int]] = (480, 480)
    """Width and height of pictures, pixels."""
    camera: ClassVar[Optional[str]] = None
    """Camera of the model for pictures; without one the scene fills them."""

    @functools.cached_property
    def model(self) -> Model:
        """The model."""
        return Model.from_file(_MODELS / self.file)

    @property
    def dt(self) -> float:
        """Duration of an action, s."""
        return self.frame_skip * self.model.timestep

    @property
    @abstractmethod
    def observation_size(self) -> int:
        """Number of entries of an observation."""

    @property
    def action_size(self) -> int:
        """Number of entries of an action, each in [-1, 1]."""
        return self.model.nu

    @abstractmethod
    def start(self, rng: np.random.Generator) -> Tuple[Array, Array]:
        """A state to begin an episode in: qpos, (nq,), and qvel, (nv,)."""

    def control(self, action: Array) -> Array:
        """Control values, (n, nu), of actions, (n, action_size), that are cut to [-1, 1]; here the actions themselves."""
        return action

    @abstractmethod
    def observe(self, batch: Batch) -> Array:
        """Observations, a new array (n, observation_size)."""

    @abstractmethod
    def judge(self, batch: Batch, before: Array, action: Array) -> Judgement:
        """What a step was worth that led from qpos ``before``, (n, nq), to the present state.

        ``action``, (n, action_size), is what was asked for, before it was cut to [-1, 1].
        """

    def describe(self, batch: Batch) -> Dict[str, NDArray[np.generic]]:
        """Numbers for the ``info`` of a reset, (n,) each."""
        return {}
