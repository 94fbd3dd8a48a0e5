"""Tasks as environments: one simulation, or many on threads."""

from __future__ import annotations

import warnings
from typing import Any, Dict, List, Optional, Sequence, Tuple, Type, Union

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box, Space
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from signorini import Batch, Data, Recording, Renderer, Settings, ToleranceWarning, step
from signorini.gymnasium.locomotion import Ant, HalfCheetah, Hopper
from signorini.gymnasium.push_box import PushBox
from signorini.gymnasium.task import Array, Judgement, Task

__all__ = ["TASKS", "Env", "VectorEnv"]

TASKS: Dict[str, Type[Task]] = {"Ant": Ant, "HalfCheetah": HalfCheetah, "Hopper": Hopper, "PushBox": PushBox}
"""The tasks of the package by name."""

SETTINGS = Settings(infeasible="clip_gaps")
"""Settings of environments: a state without solution is solved with its negative gaps taken as zero."""

RENDER_MODES = ("html", "rgb_array")

_Mask = NDArray[np.bool_]
Picture = NDArray[np.uint8]
_Info = Dict[str, Any]


class _Episodes:
    """The episodes of a batch: starts, actions and what is needed to show them again."""

    def __init__(self, task: Task, count: int, settings: Settings, nthread: int, render_mode: Optional[str]) -> None:
        if render_mode not in (None, *RENDER_MODES):
            raise ValueError(
                f"render_mode = {render_mode!r}: must be None, 'rgb_array' (a picture of the present state) or 'html' (the episode "
                "as a page that shows it in 3-D); signorini.viewer shows a running simulation"
            )
        self.task = task
        self.batch = Batch(task.model, count, settings, nthread)
        self._history: Optional[List[List[Array]]] = [[] for _ in range(count)] if render_mode == "html" else None
        self._renderer: Optional[Renderer] = None
        self._shown: Optional[Data] = None

    def __getstate__(self) -> Dict[str, Any]:
        """What goes into a pickle: the renderer is made anew where a picture is asked for."""
        return {**self.__dict__, "_renderer": None, "_shown": None}

    def begin(self, i: int, rng: np.random.Generator) -> None:
        """Begins an episode in simulation ``i``."""
        self.batch.reset([i])
        self.batch.qpos[i], self.batch.qvel[i] = self.task.start(rng)
        if self._history is not None:
            self._history[i] = [self.batch.qpos[i].copy(), self.batch.qvel[i].copy()]

    def advance(self, action: Array, running: _Mask) -> Judgement:
        """Acts, (n, action_size), in the simulations that are ``running``; rows of the others mean nothing."""
        before = self.batch.qpos.copy()
        self.batch.ctrl[:] = self.task.control(np.clip(action, -1.0, 1.0))
        ids = _ids(running)
        if self._history is not None:
            for i in ids:
                self._history[i].append(self.batch.ctrl[i].copy())
        self.batch.step(self.task.frame_skip, None if running.all() else ids)
        return self.task.judge(self.batch, before, action)

    def recording(self, i: int) -> Recording:
        """The episode of simulation ``i`` so far, made again step by step."""
        if self._history is None:
            raise ValueError("there is nothing to show: make the environment with render_mode='html'")
        if not self._history[i]:
            raise ResetNeeded("there is no episode to show: call reset first")
        qpos, qvel, *controls = self._history[i]
        data = Data(self.task.model, self.batch.settings)
        data.qpos[:], data.qvel[:] = qpos, qvel
        with data.record() as recorder, warnings.catch_warnings():
            warnings.simplefilter("ignore", ToleranceWarning)
            for ctrl in controls:
                data.ctrl[:] = ctrl
                step(self.task.model, data, self.task.frame_skip)
        return recorder.recording

    def picture(self, i: int) -> Picture:
        """What the task's camera sees of simulation ``i``, (height, width, 3)."""
        if self._renderer is None or self._shown is None:
            self._renderer = Renderer(self.task.model, *self.task.picture_size)
            self._shown = Data(self.task.model, self.batch.settings)
        self._shown.qpos[:] = self.batch.qpos[i]
        return self._renderer.render(self._shown, self.task.camera)

    def page(self, i: int) -> str:
        """The recording as an HTML page."""
        return self.recording(i).to_html(title=type(self.task).__name__)


class Env(gymnasium.Env[Array, Array]):
    """A task as an environment of Gymnasium.

    Observations are ``float64``; actions beyond [-1, 1] are cut to it. A pickle goes on in the middle of an episode with the same bits.

    Args:
        task: a task, or a name of ``TASKS``.
        render_mode: ``None``; "rgb_array": :meth:`render` gives a picture; or "html": it gives the episode so far as a page.
        settings: of the engine.
        parameters: fields of the named task.

    Raises:
        ValueError: there is no such task or render mode.
        SettingError: a setting is out of its range.
    """

    metadata: Dict[str, Any] = {"render_modes": [*RENDER_MODES]}

    def __init__(
        self,
        task: Union[str, Task],
        render_mode: Optional[str] = None,
        settings: Settings = SETTINGS,
        **parameters: Any,
    ) -> None:
        self.task = _task(task, parameters)
        self.metadata = {**type(self).metadata, "render_fps": round(1.0 / self.task.dt)}
        self.render_mode = render_mode
        self.observation_space, self.action_space = _spaces(self.task)
        self._episodes = _Episodes(self.task, 1, settings, 1, render_mode)
        self._begun = False

    def reset(self, *, seed: Optional[int] = None, options: Optional[_Info] = None) -> Tuple[Array, _Info]:
        """Begins an episode; a ``seed`` makes it and those that follow the same, bit for bit. There are no ``options``."""
        if options:
            raise ValueError(f"options {sorted(options)}: there are none")
        super().reset(seed=seed)
        self._episodes.begin(0, self.np_random)
        self._begun = True
        batch = self._episodes.batch
        return self.task.observe(batch)[0], _first(self.task.describe(batch))

    def step(self, action: ArrayLike) -> Tuple[Array, float, bool, bool, _Info]:
        """Acts, (action_size,): observation, reward, whether the task ended the episode, ``False``, numbers."""
        if not self._begun:
            raise ResetNeeded("call reset before step")
        actions = _actions(action, (self.task.action_size,))[None]
        judgement = self._episodes.advance(actions, np.ones(1, dtype=np.bool_))
        observation = self.task.observe(self._episodes.batch)[0]
        return observation, float(judgement.reward[0]), bool(judgement.terminated[0]), False, _first(judgement.info)

    def recording(self) -> Recording:
        """The episode so far, with its contacts, forces and residuals; needs render mode "html"."""
        return self._episodes.recording(0)

    def render(self) -> Union[str, Picture, None]:
        """A picture, (height, width, 3), with render mode "rgb_array"; the episode so far as an HTML page, with "html"; else ``None``."""
        if self.render_mode is None:
            return None
        return self._episodes.picture(0) if self.render_mode == "rgb_array" else self._episodes.page(0)


class VectorEnv(gymnasium.vector.VectorEnv[Array, Array, NDArray[Any]]):
    """A task in many simulations at once, on threads; each is what :class:`Env` would make of it, bit for bit.

    With a seed s simulation i has the seed s + i.

    Args:
        task: a task, or a name of ``TASKS``.
        num_envs: number of simulations.
        max_episode_steps: actions after which an episode is truncated; ``None`` for never.
        autoreset_mode: what happens after an episode has ended: "NextStep" (the next step begins a new one and ignores the
            action), "SameStep" (the same step begins a new one, with the end in ``final_obs`` and ``final_info``) or
            "Disabled" (``reset(options={"reset_mask": ...})`` must).
        nthread: at most so many threads; 0 for as many as the machine runs at once. Results do not depend on it.
        render_mode, settings, parameters: as in :class:`Env`.

    Raises:
        ValueError: there is no such task, render mode or autoreset mode.
        SettingError: a setting is out of its range.
    """

    metadata: Dict[str, Any] = {"render_modes": [*RENDER_MODES]}

    def __init__(
        self,
        task: Union[str, Task],
        num_envs: int = 1,
        max_episode_steps: Optional[int] = None,
        autoreset_mode: Union[str, AutoresetMode] = AutoresetMode.NEXT_STEP,
        render_mode: Optional[str] = None,
        settings: Settings = SETTINGS,
        nthread: int = 0,
        **parameters: Any,
    ) -> None:
        self.task = _task(task, parameters)
        self.num_envs = num_envs
        self.max_episode_steps = max_episode_steps
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        fps = round(1.0 / self.task.dt)
        self.metadata = {**type(self).metadata, "render_fps": fps, "autoreset_mode": self.autoreset_mode}
        self.render_mode = render_mode
        self.single_observation_space, self.single_action_space = _spaces(self.task)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._episodes = _Episodes(self.task, num_envs, settings, nthread, render_mode)
        self._generators: List[Optional[np.random.Generator]] = [None] * num_envs
        self._elapsed = np.zeros(num_envs, dtype=np.int64)
        self._ended = np.zeros(num_envs, dtype=np.bool_)
        self._begun = False

    def reset(
        self,
        *,
        seed: Optional[Union[int, Sequence[Optional[int]]]] = None,
        options: Optional[_Info] = None,
    ) -> Tuple[Array, _Info]:
        """Begins episodes in all simulations, or in those of ``options["reset_mask"]``, (num_envs,) booleans.

        Args:
            seed: of simulation 0, with the following numbers for the others, or one for each (``None`` leaves its generator).
            options: nothing but ``reset_mask``.

        Raises:
            ValueError: the seeds or the options do not fit, or the first reset is not one of all.
        """
        if isinstance(seed, (int, np.integer)):
            seed = [int(seed) + i for i in range(self.num_envs)]
        seeds: Sequence[Optional[int]] = [None] * self.num_envs if seed is None else seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed has {len(seeds)} entries, expected one for each of {self.num_envs} simulations")
        mask = _reset_mask(options, self.num_envs)
        if not (self._begun or mask.all()):
            raise ValueError("the first reset must be one of all simulations")
        for i in _ids(mask):
            if seeds[i] is not None or self._generators[i] is None:
                self._generators[i], _ = np_random(seeds[i])
        self._begun = True
        self._begin(mask)
        infos: _Info = {}
        _put(infos, self.task.describe(self._episodes.batch), mask)
        return self.task.observe(self._episodes.batch), infos

    def step(self, actions: ArrayLike) -> Tuple[Array, Array, _Mask, _Mask, _Info]:
        """Acts, (num_envs, action_size): observations, rewards, terminations, truncations, (num_envs, ...), and infos."""
        if not self._begun:
            raise ResetNeeded("call reset before step")
        array = _actions(actions, (self.num_envs, self.task.action_size))
        running = ~self._ended
        if self.autoreset_mode is not AutoresetMode.NEXT_STEP and self._ended.any():
            raise ResetNeeded(f"the episodes of simulations {_ids(self._ended)} have ended: reset them by options['reset_mask']")
        reward, terminated, numbers = self._episodes.advance(array, running)
        self._elapsed[running] += 1
        reward, terminated = np.where(running, reward, 0.0), terminated & running
        limit = np.inf if self.max_episode_steps is None else self.max_episode_steps
        truncated: _Mask = running & (self._elapsed >= limit)
        ended = terminated | truncated
        infos: _Info = {}
        if self.autoreset_mode is AutoresetMode.SAME_STEP and ended.any():
            self._finish(infos, numbers, ended)
            _put(infos, numbers, ~ended)
            self._begin(ended)
            _put(infos, self.task.describe(self._episodes.batch), ended)
            ended = np.zeros_like(ended)
        else:
            _put(infos, numbers, running)
            self._begin(~running)
            _put(infos, self.task.describe(self._episodes.batch), ~running)
        self._ended = ended
        return self.task.observe(self._episodes.batch), reward, terminated, truncated, infos

    def recording(self, i: int) -> Recording:
        """The episode of simulation ``i`` so far; see :meth:`Env.recording`."""
        return self._episodes.recording(i)

    def render(self) -> Union[Tuple[str, ...], Tuple[Picture, ...], None]:
        """Pictures, with render mode "rgb_array", or the episodes so far as HTML pages, with "html"; otherwise ``None``."""
        if self.render_mode is None:
            return None
        if self.render_mode == "rgb_array":
            return tuple(self._episodes.picture(i) for i in range(self.num_envs))
        return tuple(self._episodes.page(i) for i in range(self.num_envs))

    def _begin(self, mask: _Mask) -> None:
        for i in _ids(mask):
            generator = self._generators[i]
            assert generator is not None
            self._episodes.begin(i, generator)
        self._elapsed[mask], self._ended[mask] = 0, False

    def _finish(self, infos: _Info, numbers: Dict[str, NDArray[np.generic]], ended: _Mask) -> None:
        """Keeps how episodes ended before new ones begin."""
        last = np.full(self.num_envs, None, dtype=object)
        observations = self.task.observe(self._episodes.batch)
        for i in _ids(ended):
            last[i] = observations[i]
        final: _Info = {}
        _put(final, numbers, ended)
        infos.update(final_obs=last, _final_obs=ended.copy(), final_info=final, _final_info=ended.copy())


def _task(task: Union[str, Task], parameters: Dict[str, Any]) -> Task:
    if isinstance(task, Task):
        if parameters:
            raise ValueError(f"{sorted(parameters)} are fields of the task: give them to {type(task).__name__}")
        return task
    if task not in TASKS:
        raise ValueError(f"task = {task!r}: must be a Task or of {sorted(TASKS)}")
    return TASKS[task](**parameters)


def _spaces(task: Task) -> Tuple[Space[Any], Space[Any]]:
    observation = Box(-np.inf, np.inf, (task.observation_size,), np.float64)
    return observation, Box(-1.0, 1.0, (task.action_size,), np.float32)


def _actions(action: ArrayLike, shape: Tuple[int, ...]) -> Array:
    array = np.asarray(action, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"the action has shape {array.shape}, expected {shape}")
    if not np.isfinite(array).all():
        raise ValueError("the action has entries that are not finite")
    return array


def _reset_mask(options: Optional[_Info], count: int) -> _Mask:
    unknown = set(options or ()) - {"reset_mask"}
    if unknown:
        raise ValueError(f"options {sorted(unknown)}: there is only 'reset_mask'")
    if not options:
        return np.ones(count, dtype=np.bool_)
    mask: _Mask = np.asarray(options["reset_mask"])
    if mask.dtype != np.bool_ or mask.shape != (count,) or not mask.any():
        raise ValueError(f"options['reset_mask'] must be {count} booleans of which at least one is true")
    return mask


def _ids(mask: _Mask) -> List[int]:
    return [int(i) for i in np.flatnonzero(mask)]


def _first(numbers: Dict[str, NDArray[np.generic]]) -> _Info:
    return {name: values[0].item() for name, values in numbers.items()}


def _put(infos: _Info, numbers: Dict[str, NDArray[np.generic]], mask: _Mask) -> None:
    """Adds the rows of ``mask`` to infos in Gymnasium's layout: an array and, under "_name", which of its rows count."""
    if not mask.any():
        return
    for name, values in numbers.items():
        array = infos.setdefault(name, np.zeros(len(mask), dtype=values.dtype))
        array[mask] = values[mask]
        infos["_" + name] = infos.get("_" + name, np.zeros(len(mask), dtype=np.bool_)) | mask
