"""Whole rollouts over a `Ray <https://docs.ray.io>`_ cluster (``pip install signorini[ray]``).

A *program* is a function that is given a batch, reset, and one seed per simulation of it, and returns arrays with one row per
simulation::

    def program(batch, seeds):
        for i, seed in enumerate(seeds):
            batch.qvel[i] = np.random.default_rng(seed).normal(size=batch.model.nv)
        qpos, qvel = batch.rollout(nstep=500)
        return {"qpos": qpos, "qvel": qvel}

    results = signorini.ray.rollout(model, program, seeds=range(10_000), workers=16)
    results["qpos"]                              # (10000, 500, nq), rows in the order of the seeds

A program whose rows depend on their seeds alone has the bits that it has here, ``program(signorini.Batch(model, n), seeds)``, whatever
the number of workers and whichever of them were lost: simulations of a batch do not feel each other. Machines of different
kinds may round differently.
"""

from __future__ import annotations

import collections
import importlib
from dataclasses import dataclass
from typing import Any, Callable, Deque, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from signorini.batch import Batch
from signorini.errors import SignoriniError
from signorini.model import Model
from signorini.settings import Settings

__all__ = ["Program", "WorkerLostError", "rollout"]

Program = Callable[[Batch, Sequence[int]], Mapping[str, NDArray[Any]]]
"""Given a batch, reset, and a seed for each of its simulations: arrays with a row per simulation."""

ATTEMPTS = 3
"""Workers that may be lost over the same seeds."""


class WorkerLostError(SignoriniError, RuntimeError):
    """Workers were lost again and again.

    Attributes:
        seeds: the seeds that they were at; none where they were lost before they began.
    """

    def __init__(self, message: str, seeds: Sequence[int] = ()) -> None:
        super().__init__(message)
        self.seeds = list(seeds)


@dataclass
class _Part:
    """Seeds that one batch runs together."""

    index: int
    seeds: List[int]
    losses: int = 0


class _Worker:
    """What an actor holds: a batch for every size of part that it has met, made once."""

    def __init__(self, model: Model, settings: Settings, program: Program, nthread: int) -> None:
        self._model, self._settings, self._program, self._nthread = model, settings, program, nthread
        self._batches: Dict[int, Batch] = {}

    def ready(self) -> None:
        """Answers once the actor has a place."""

    def run(self, seeds: List[int]) -> Dict[str, NDArray[Any]]:
        """The program's arrays for these seeds."""
        count = len(seeds)
        if count not in self._batches:
            self._batches[count] = Batch(self._model, count, self._settings, self._nthread)
        batch = self._batches[count]
        batch.reset()
        return _checked(self._program(batch, seeds), count)


def rollout(
    model: Model,
    program: Program,
    seeds: Sequence[int],
    *,
    workers: int,
    nsim: int = 64,
    settings: Settings = Settings(),
    nthread: int = 1,
    options: Optional[Mapping[str, Any]] = None,
) -> Dict[str, NDArray[Any]]:
    """Runs a program for all seeds on actors of Ray, each with a batch of its own.

    Ray is started on this machine where it is not running; ``ray.init(address=...)`` before the call chooses a cluster. Seeds of
    an actor that is lost (its process or its machine died) are run again on another, and a new actor takes its place.

    Args:
        model: the model.
        program: see :data:`Program`; sent to the actors by pickling.
        seeds: the seeds, in any order.
        workers: number of actors.
        nsim: simulations of a batch: the seeds that an actor is given at once.
        settings: of the engine.
        nthread: threads of a batch, which are also the CPUs that an actor asks Ray for.
        options: of the actors, for ``ray.remote`` (``num_cpus``, ``resources``, ...).

    Returns:
        The program's arrays, with rows in the order of ``seeds``; nothing, {}, for no seeds.

    Raises:
        ModuleNotFoundError: Ray is not installed.
        ValueError: ``workers``, ``nsim`` or ``nthread`` is not positive, or arrays of the program have not one row per seed.
        WorkerLostError: ``ATTEMPTS`` workers in turn were lost over the same seeds, or before they began.
        Exception: what the program raised, as Ray reports it (an instance of the program's own exception, too).
    """
    for name, value in (("workers", workers), ("nsim", nsim), ("nthread", nthread)):
        if value < 1:
            raise ValueError(f"{name} = {value}: must be at least 1")
    numbers = [int(seed) for seed in seeds]
    starts = range(0, len(numbers), nsim)
    parts = [_Part(index, numbers[start : start + nsim]) for index, start in enumerate(starts)]
    if not parts:
        return {}
    crew = _Crew(min(workers, len(parts)), {"num_cpus": nthread, **(options or {})}, (model, settings, program, nthread))
    try:
        results = crew.run(parts)
    finally:
        crew.dismiss()
    return {name: np.concatenate([results[part.index][name] for part in parts]) for name in results[0]}


class _Crew:
    """The actors, and which of them is at which part."""

    def __init__(self, count: int, options: Mapping[str, Any], arguments: Tuple[Any, ...]) -> None:
        try:
            self._ray: Any = importlib.import_module("ray")
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError("signorini.ray needs Ray: pip install 'signorini[ray]'") from error
        if not self._ray.is_initialized():
            self._ray.init()
        self._actor = self._ray.remote(**options)(_Worker)
        self._arguments = [self._ray.put(argument) for argument in arguments]
        self._idle: List[Any] = []
        self._busy: Dict[Any, Tuple[Any, Optional[_Part]]] = {}
        self._stillborn = 0
        for _ in range(count):
            self._hire()

    def _hire(self) -> None:
        """Asks for a new actor. It gets no part before it has a place, so that none waits for a machine that never comes."""
        worker = self._actor.remote(*self._arguments)
        self._busy[worker.ready.remote()] = worker, None

    def run(self, parts: Sequence[_Part]) -> Dict[int, Dict[str, NDArray[Any]]]:
        """The arrays of every part."""
        results: Dict[int, Dict[str, NDArray[Any]]] = {}
        waiting: Deque[_Part] = collections.deque(parts)
        while len(results) < len(parts):
            while self._idle and waiting:
                worker, part = self._idle.pop(), waiting.popleft()
                self._busy[worker.run.remote(part.seeds)] = worker, part
            (done,), _ = self._ray.wait(list(self._busy), num_returns=1)
            worker, finished = self._busy.pop(done)
            try:
                arrays = self._ray.get(done)
            except (self._ray.exceptions.RayActorError, self._ray.exceptions.ObjectLostError) as error:
                self._lose(finished, error)
                if finished is not None:
                    waiting.appendleft(finished)
                self._hire()
                continue
            self._idle.append(worker)
            if finished is not None:
                results[finished.index] = arrays
        return results

    def _lose(self, part: Optional[_Part], error: Exception) -> None:
        """Counts a loss, and gives up where it is one too many."""
        if part is None:
            self._stillborn += 1
            if self._stillborn >= ATTEMPTS:
                raise WorkerLostError(f"{ATTEMPTS} workers were lost before they began: {error}") from error
            return
        part.losses += 1
        if part.losses >= ATTEMPTS:
            message = f"{ATTEMPTS} workers in turn were lost over the seeds {part.seeds}"
            raise WorkerLostError(message, part.seeds) from error

    def dismiss(self) -> None:
        """Ends the actors."""
        for worker in [*self._idle, *(worker for worker, _ in self._busy.values())]:
            self._ray.kill(worker)


def _checked(arrays: Mapping[str, NDArray[Any]], count: int) -> Dict[str, NDArray[Any]]:
    found = {name: np.asarray(array) for name, array in arrays.items()}
    for name, array in found.items():
        if array.ndim == 0 or array.shape[0] != count:
            raise ValueError(f"the program's array '{name}' has shape {array.shape}: expected {count} rows, one per seed")
    return found
