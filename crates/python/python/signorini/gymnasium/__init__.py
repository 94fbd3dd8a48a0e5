"""Environments for reinforcement learning with `Gymnasium <https://gymnasium.farama.org>`_ (``pip install signorini[gymnasium]``).

>>> import gymnasium
>>> import signorini.gymnasium
>>> env = gymnasium.make("signorini/Hopper-v0")
>>> observation, info = env.reset(seed=0)
>>> envs = gymnasium.make_vec("signorini/Hopper-v0", num_envs=64, vectorization_mode="vector_entry_point")
>>> observations, infos = envs.reset(seed=0)
>>> observations.shape
(64, 11)

Importing this module registers ``signorini/Ant-v0``, ``signorini/HalfCheetah-v0``, ``signorini/Hopper-v0`` and
``signorini/PushBox-v0``. A task of one's own is a subclass of :class:`Task`, and ``Env(task)`` and ``VectorEnv(task, num_envs)`` make
environments of it.
"""

from __future__ import annotations

from importlib.util import find_spec

if find_spec("gymnasium") is None:
    raise ModuleNotFoundError("signorini.gymnasium needs Gymnasium: pip install 'signorini[gymnasium]'")

from gymnasium.envs.registration import register

from signorini.gymnasium.env import TASKS, Env, VectorEnv
from signorini.gymnasium.locomotion import Ant, HalfCheetah, Hopper
from signorini.gymnasium.push_box import PushBox
from signorini.gymnasium.task import Judgement, Task

__all__ = ["TASKS", "Ant", "Env", "HalfCheetah", "Hopper", "Judgement", "PushBox", "Task", "VectorEnv"]

_EPISODE_STEPS = {"Ant": 1000, "HalfCheetah": 1000, "Hopper": 1000, "PushBox": 100}

for _name, _steps in _EPISODE_STEPS.items():
    register(
        id=f"signorini/{_name}-v0",
        entry_point="signorini.gymnasium:Env",
        vector_entry_point="signorini.gymnasium:VectorEnv",
        kwargs={"task": _name},
        max_episode_steps=_steps,
    )
