"""Tasks in which a body learns to run: the customary ones of Gymnasium, on models of this package.

Observations, rewards, ends of episodes and their parameters are those of the MuJoCo environments v5 of Gymnasium
(https://gymnasium.farama.org/environments/mujoco). What differs is listed with each task; common to all: contacts are hard,
and a start that noise pushes into the floor is lifted until it touches.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import ClassVar, Dict, Tuple

import numpy as np
from numpy.typing import NDArray

from signorini import Batch, Data, Settings, forward
from signorini.gymnasium.task import Array, Judgement, Task

__all__ = ["Ant", "HalfCheetah", "Hopper"]


@dataclass(frozen=True)
class _Runner(Task):
    """What the runners have in common: they are paid for the speed of their trunk along x."""

    height: ClassVar[int]
    """Where the trunk's height is in qpos."""

    forward_reward_weight: float = 1.0
    """Reward per m/s."""
    ctrl_cost_weight: float = 0.0
    """Cost of the squared action."""
    reset_noise_scale: float = 0.0
    """Size of the noise on the state at the start, m, rad, m/s, rad/s."""
    exclude_current_positions_from_observation: bool = True
    """Whether the observation leaves out the place on the floor."""

    @property
    def hidden(self) -> int:
        """Leading entries of qpos that the observation leaves out: those before the height."""
        return self.height if self.exclude_current_positions_from_observation else 0

    @property
    def observation_size(self) -> int:
        return self.model.nq - self.hidden + self.model.nv

    @functools.cached_property
    def _scratch(self) -> Data:
        data = Data(self.model, Settings(infeasible="clip_gaps"))
        if self.model.nkey:
            data.reset(keyframe=0)
        return data

    @functools.cached_property
    def _rest(self) -> Array:
        return np.array(self._scratch.qpos)

    def noise(self, rng: np.random.Generator) -> Tuple[Array, Array]:
        """Noise on qpos, uniform, and on qvel, normal."""
        scale = self.reset_noise_scale
        return rng.uniform(-scale, scale, self.model.nq), scale * rng.standard_normal(self.model.nv)

    def start(self, rng: np.random.Generator) -> Tuple[Array, Array]:
        dq, qvel = self.noise(rng)
        qpos = self._rest + dq
        if self.model.nq != self.model.nv:
            qpos[3:7] /= np.linalg.norm(qpos[3:7])
        data = self._scratch
        data.reset()
        data.qpos[:] = qpos
        forward(self.model, data)
        on_floor = data.contact.body1 * data.contact.body2 == 0
        qpos[self.height] -= min(0.0, data.contact.gap[on_floor].min(initial=0.0))
        return qpos, qvel

    def observe(self, batch: Batch) -> Array:
        return np.concatenate([batch.qpos[:, self.hidden :], batch.qvel], axis=1)

    def speed(self, batch: Batch, before: Array) -> Array:
        """Mean speed along x over the step, (n,), m/s."""
        return (batch.qpos[:, 0] - before[:, 0]) / self.dt

    def effort(self, action: Array) -> Array:
        """Cost of the action, (n,)."""
        cost: Array = self.ctrl_cost_weight * np.square(action).sum(axis=1)
        return cost


@dataclass(frozen=True)
class HalfCheetah(_Runner):
    """Half of a running animal in a plane; episodes end by time alone.

    The observation, (17,), is qpos without x and qvel; actions, (6,), are torques in units of the motors' gear (120, 90, 60,
    120, 60, 30 N·m); an action lasts 0.05 s. reward = forward_reward_weight · speed − ctrl_cost_weight · |action|².

    Against ``HalfCheetah-v5``: a model of its own with proportions like that one's, 14 kg.
    """

    file = "half_cheetah.xml"
    frame_skip = 5
    height = 1

    ctrl_cost_weight: float = 0.1
    reset_noise_scale: float = 0.1

    def judge(self, batch: Batch, before: Array, action: Array) -> Judgement:
        speed, effort = self.speed(batch, before), self.effort(action)
        gain = self.forward_reward_weight * speed
        info: Dict[str, NDArray[np.generic]] = {
            **self.describe(batch), "x_velocity": speed, "reward_forward": gain, "reward_ctrl": -effort
        }
        return Judgement(gain - effort, np.zeros(len(batch), dtype=np.bool_), info)

    def describe(self, batch: Batch) -> Dict[str, NDArray[np.generic]]:
        return {"x_position": batch.qpos[:, 0].copy()}


@dataclass(frozen=True)
class Hopper(_Runner):
    """A leg that hops in a plane, and ends its episode when it falls.

    The observation, (11,), is qpos without x and qvel cut to [-10, 10]; actions, (3,), are torques in units of 200 N·m; an
    action lasts 0.008 s. reward = healthy_reward + forward_reward_weight · speed − ctrl_cost_weight · |action|².

    Against ``Hopper-v5``: a model of its own with proportions like that one's, 15.3 kg. A step that ends the episode earns
    no healthy_reward, as there.
    """

    file = "hopper.xml"
    frame_skip = 4
    height = 1

    ctrl_cost_weight: float = 1e-3
    reset_noise_scale: float = 5e-3
    healthy_reward: float = 1.0
    """Reward of a step that does not end in a fall."""
    terminate_when_unhealthy: bool = True
    """Whether a fall ends the episode."""
    healthy_state_range: Tuple[float, float] = (-100.0, 100.0)
    """Where every coordinate but x and z must be, and every velocity."""
    healthy_z_range: Tuple[float, float] = (0.7, np.inf)
    """Where the trunk's height must be, m."""
    healthy_angle_range: Tuple[float, float] = (-0.2, 0.2)
    """Where the trunk's pitch must be, rad."""

    def noise(self, rng: np.random.Generator) -> Tuple[Array, Array]:
        scale = self.reset_noise_scale
        return rng.uniform(-scale, scale, self.model.nq), rng.uniform(-scale, scale, self.model.nv)

    def observe(self, batch: Batch) -> Array:
        return np.concatenate([batch.qpos[:, self.hidden :], np.clip(batch.qvel, -10.0, 10.0)], axis=1)

    def healthy(self, batch: Batch) -> NDArray[np.bool_]:
        """Whether it has not fallen, (n,)."""
        state = np.concatenate([batch.qpos[:, 2:], batch.qvel], axis=1)
        calm = _within(state, self.healthy_state_range).all(axis=1)
        upright = _within(batch.qpos[:, 2], self.healthy_angle_range)
        return calm & upright & _within(batch.qpos[:, 1], self.healthy_z_range)

    def judge(self, batch: Batch, before: Array, action: Array) -> Judgement:
        speed, effort, healthy = self.speed(batch, before), self.effort(action), self.healthy(batch)
        gain, alive = self.forward_reward_weight * speed, self.healthy_reward * healthy
        info: Dict[str, NDArray[np.generic]] = {
            **self.describe(batch),
            "x_velocity": speed,
            "reward_forward": gain,
            "reward_ctrl": -effort,
            "reward_survive": alive,
        }
        return Judgement(alive + gain - effort, ~healthy & self.terminate_when_unhealthy, info)

    def describe(self, batch: Batch) -> Dict[str, NDArray[np.generic]]:
        return {"x_position": batch.qpos[:, 0].copy(), "z_distance_from_origin": batch.qpos[:, 1] - self._rest[1]}


@dataclass(frozen=True)
class Ant(_Runner):
    """A trunk on four legs in space, which ends its episode when it leaves the healthy heights.

    The observation, (105,), is qpos without x and y, (13,), qvel, (14,), and the wrenches of the contacts on the 13 bodies
    but the world, cut to ``contact_force_range``, (78,); actions, (8,), are torques in units of 150 N·m; an action lasts
    0.05 s. reward = healthy_reward + forward_reward_weight · speed − ctrl_cost_weight · |action|² − contact_cost_weight ·
    |wrenches|².

    Against ``Ant-v5``: a model of its own with proportions like that one's, all knees bending down at positive angles; legs
    in the order front left, hind left, hind right, front right; moments of the wrenches about the bodies' own centres of mass
    instead of the whole ant's.
    """

    file = "ant.xml"
    frame_skip = 5
    height = 2

    ctrl_cost_weight: float = 0.5
    reset_noise_scale: float = 0.1
    contact_cost_weight: float = 5e-4
    """Cost of the squared wrenches of contacts."""
    healthy_reward: float = 1.0
    """Reward of a step that ends at a healthy height."""
    terminate_when_unhealthy: bool = True
    """Whether an unhealthy height ends the episode."""
    healthy_z_range: Tuple[float, float] = (0.2, 1.0)
    """Where the trunk's height must be, m."""
    contact_force_range: Tuple[float, float] = (-1.0, 1.0)
    """What wrenches are cut to, N and N·m."""
    include_cfrc_ext_in_observation: bool = True
    """Whether the observation has the wrenches."""

    @property
    def observation_size(self) -> int:
        return super().observation_size + (6 * (self.model.nbody - 1) if self.include_cfrc_ext_in_observation else 0)

    def wrenches(self, batch: Batch) -> Array:
        """What contacts do to the bodies, cut, (n, 78)."""
        return np.clip(batch.contact_wrench[:, 1:].reshape(len(batch), -1), *self.contact_force_range)

    def observe(self, batch: Batch) -> Array:
        state = super().observe(batch)
        if not self.include_cfrc_ext_in_observation:
            return state
        return np.concatenate([state, self.wrenches(batch)], axis=1)

    def judge(self, batch: Batch, before: Array, action: Array) -> Judgement:
        speed, effort = self.speed(batch, before), self.effort(action)
        finite = np.isfinite(batch.qpos).all(axis=1) & np.isfinite(batch.qvel).all(axis=1)
        healthy = finite & _within(batch.qpos[:, 2], self.healthy_z_range, closed=True)
        contact = self.contact_cost_weight * np.square(self.wrenches(batch)).sum(axis=1)
        gain, alive = self.forward_reward_weight * speed, self.healthy_reward * healthy
        info: Dict[str, NDArray[np.generic]] = {
            **self.describe(batch),
            "x_velocity": speed,
            "y_velocity": (batch.qpos[:, 1] - before[:, 1]) / self.dt,
            "reward_forward": gain,
            "reward_ctrl": -effort,
            "reward_contact": -contact,
            "reward_survive": alive,
        }
        return Judgement(gain + alive - effort - contact, ~healthy & self.terminate_when_unhealthy, info)

    def describe(self, batch: Batch) -> Dict[str, NDArray[np.generic]]:
        x, y = batch.qpos[:, 0].copy(), batch.qpos[:, 1].copy()
        return {"x_position": x, "y_position": y, "distance_from_origin": np.sqrt(x * x + y * y)}


def _within(values: Array, bounds: Tuple[float, float], closed: bool = False) -> NDArray[np.bool_]:
    if closed:
        return (bounds[0] <= values) & (values <= bounds[1])
    return (bounds[0] < values) & (values < bounds[1])
