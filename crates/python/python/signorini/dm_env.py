"""Tasks as environments of `dm_env <https://github.com/google-deepmind/dm_env>`_ (``pip install dm-env``).

>>> from signorini.dm_env import Environment
>>> environment = Environment("Hopper", seed=0)
>>> timestep = environment.reset()
>>> timestep.observation.shape
(11,)

The tasks are those of :mod:`signorini.gymnasium`, which needs Gymnasium, too; an episode is the same step for step.
"""

from __future__ import annotations

from abc import ABCMeta
from importlib.util import find_spec
from typing import Any, Optional, Union

if find_spec("dm_env") is None:
    raise ModuleNotFoundError("signorini.dm_env needs dm_env: pip install dm-env gymnasium")

import dm_env  # type: ignore[import-untyped]
import numpy as np
from dm_env import specs
from numpy.typing import ArrayLike

from signorini import Settings
from signorini.gymnasium.env import SETTINGS, Env, Picture
from signorini.gymnasium.task import Task

__all__ = ["Environment"]


class Environment(dm_env.Environment, metaclass=ABCMeta):  # type: ignore[misc]
    """A task as an environment of dm_env.

    Observations are ``float64``, (observation_size,); actions, (action_size,), beyond [-1, 1] are cut to it. An end of the task's own has
    discount 0, a limit of steps discount 1.

    Args:
        task: a task, or a name of ``signorini.gymnasium.TASKS``.
        max_episode_steps: actions after which an episode ends; ``None`` for never.
        seed: of all episodes.
        settings: of the engine.
        parameters: fields of the named task.
    """

    def __init__(
        self,
        task: Union[str, Task],
        max_episode_steps: Optional[int] = 1000,
        seed: Optional[int] = None,
        settings: Settings = SETTINGS,
        **parameters: Any,
    ) -> None:
        self._env = Env(task, render_mode="rgb_array", settings=settings, **parameters)
        self._limit = max_episode_steps
        self._seed = seed
        self._elapsed: Optional[int] = None

    @property
    def task(self) -> Task:
        """The task."""
        return self._env.task

    def reset(self) -> dm_env.TimeStep:
        """Begins an episode."""
        observation, _ = self._env.reset(seed=self._seed)
        # The generator goes on from episode to episode.
        self._seed, self._elapsed = None, 0
        return dm_env.restart(observation)

    def step(self, action: ArrayLike) -> dm_env.TimeStep:
        """Acts; after the end of an episode it begins the next one and leaves the action aside."""
        if self._elapsed is None:
            return self.reset()
        observation, reward, terminated, _, _ = self._env.step(action)
        self._elapsed += 1
        if terminated:
            self._elapsed = None
            return dm_env.termination(reward, observation)
        if self._limit is not None and self._elapsed >= self._limit:
            self._elapsed = None
            return dm_env.truncation(reward, observation)
        return dm_env.transition(reward, observation)

    def observation_spec(self) -> specs.Array:
        """Any numbers, (observation_size,)."""
        return specs.Array((self.task.observation_size,), np.float64, "observation")

    def action_spec(self) -> specs.BoundedArray:
        """Numbers in [-1, 1], (action_size,)."""
        return specs.BoundedArray((self.task.action_size,), np.float64, -1.0, 1.0, "action")

    def picture(self) -> Picture:
        """What the task's camera sees now, (height, width, 3)."""
        picture = self._env.render()
        assert isinstance(picture, np.ndarray)
        return picture
