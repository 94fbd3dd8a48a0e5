"""A task of contact: a finger pushes a box over a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Tuple

import numpy as np
from numpy.typing import NDArray

from signorini import Batch
from signorini.gymnasium.task import Array, Judgement, Task

__all__ = ["PushBox"]

_FINGER, _BOX, _TURN, _GOAL = slice(0, 2), slice(2, 4), slice(5, 9), slice(9, 11)
_BEHIND = 0.07
"""From the middle of the box to that of the finger that touches its face, m."""


@dataclass(frozen=True)
class PushBox(Task):
    """A finger, moved in a plane, pushes a box of 10 cm and 0.4 kg over a table (μ = 0.5) to a goal.

    Actions, (2,), are velocities of the finger in units of ``finger_speed``, held by servos of at most 20 N; an action lasts
    0.05 s. The observation, (15,), has, in m, m/s and rad/s:

    ===== =====================================
    0:2   place of the finger
    2:4   velocity of the finger
    4:6   place of the box less the finger's
    6:8   place of the goal less the box's
    8:10  place to push from less the finger's
    10:12 cosine and sine of the box's yaw
    12:14 velocity of the box
    14    yaw rate of the box
    ===== =====================================

    Box and goal start anywhere in squares of ±0.15 m and ±0.2 m, the finger on a circle of 0.12 m about the box. reward =
    progress_weight · (how much nearer the box came to the goal) + finger_weight · (how much nearer the finger came to the place
    to push from) − ctrl_cost_weight · |action|², and success_reward more where the box is within ``success_distance`` of the goal.
    The place to push from is 0.07 m behind the middle of the box, seen from the goal. Episodes end by time alone.
    """

    file = "push_box.xml"
    frame_skip = 10

    finger_speed: float = 0.4
    """Speed for an action of 1, m/s."""
    progress_weight: float = 10.0
    """Reward per m that the box comes nearer to the goal."""
    finger_weight: float = 2.0
    """Reward per m that the finger comes nearer to the place to push from."""
    ctrl_cost_weight: float = 1e-3
    """Cost of the squared action."""
    success_distance: float = 0.03
    """Where the box has arrived, m."""
    success_reward: float = 0.2
    """Reward of every action after which the box is at the goal."""

    @property
    def observation_size(self) -> int:
        return 15

    def start(self, rng: np.random.Generator) -> Tuple[Array, Array]:
        box, goal = rng.uniform(-0.15, 0.15, 2), rng.uniform(-0.2, 0.2, 2)
        yaw, side = rng.uniform(-np.pi, np.pi, 2)
        finger = box + 0.12 * np.array([np.cos(side), np.sin(side)])
        turn = [np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]
        return np.concatenate([finger, box, [0.05], turn, goal]), np.zeros(self.model.nv)

    def control(self, action: Array) -> Array:
        return self.finger_speed * action

    def observe(self, batch: Batch) -> Array:
        qpos, qvel = batch.qpos, batch.qvel
        w, x, y, z = qpos[:, _TURN].T
        heading = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (w * z + x * y)], axis=1)
        finger, box, goal = qpos[:, _FINGER], qpos[:, _BOX], qpos[:, _GOAL]
        places = [finger, qvel[:, :2], box - finger, goal - box, _behind(qpos) - finger]
        return np.concatenate([*places, heading, qvel[:, 2:4], qvel[:, 7:8]], axis=1)

    def judge(self, batch: Batch, before: Array, action: Array) -> Judgement:
        (away, reach), (away_before, reach_before) = _distances(batch.qpos), _distances(before)
        arrived = away < self.success_distance
        progress = self.progress_weight * (away_before - away) + self.finger_weight * (reach_before - reach)
        effort = self.ctrl_cost_weight * np.square(action).sum(axis=1)
        reward = progress + self.success_reward * arrived - effort
        info: Dict[str, NDArray[np.generic]] = {"distance": away, "is_success": arrived}
        return Judgement(reward, np.zeros(len(batch), dtype=np.bool_), info)

    def describe(self, batch: Batch) -> Dict[str, NDArray[np.generic]]:
        away, _ = _distances(batch.qpos)
        return {"distance": away, "is_success": away < self.success_distance}


def _behind(qpos: Array) -> Array:
    """The place to push from, (n, 2), m."""
    away = qpos[:, _GOAL] - qpos[:, _BOX]
    place: Array = qpos[:, _BOX] - _BEHIND * away / np.maximum(_length(away), 1e-9)[:, None]
    return place


def _distances(qpos: Array) -> Tuple[Array, Array]:
    """Of box and goal, and of the finger and the place to push from, (n,) each, m."""
    return _length(qpos[:, _GOAL] - qpos[:, _BOX]), _length(_behind(qpos) - qpos[:, _FINGER])


def _length(rows: Array) -> Array:
    squares: Array = np.square(rows).sum(axis=1)
    return np.sqrt(squares)
