"""Environments of dm_env, beside those of Gymnasium and by dm_env's own tests."""

import unittest

import gymnasium
import numpy as np
import pytest
import signorini.gymnasium  # noqa: F401

dm_env = pytest.importorskip("dm_env")
from dm_env import test_utils  # noqa: E402
from signorini.dm_env import Environment  # noqa: E402


class TestProtocol(test_utils.EnvironmentTestMixin, unittest.TestCase):
    """What dm_env asks of every environment."""

    def make_object_under_test(self):
        return Environment("PushBox", max_episode_steps=5, seed=0)

    def make_action_sequence(self):
        spec, rng = self.environment.action_spec(), np.random.default_rng(0)
        for _ in range(12):
            yield rng.uniform(-1.0, 1.0, spec.shape)


def test_episodes_are_those_of_gymnasium():
    ours, theirs = Environment("Hopper", seed=3), gymnasium.make("signorini/Hopper-v0")
    timestep, (observation, _) = ours.reset(), theirs.reset(seed=3)
    assert timestep.first() and np.array_equal(timestep.observation, observation)
    rng = np.random.default_rng(1)
    for _ in range(200):
        action = rng.uniform(-1.0, 1.0, ours.action_spec().shape)
        timestep, (observation, reward, terminated, _, _) = ours.step(action), theirs.step(action)
        assert np.array_equal(timestep.observation, observation) and timestep.reward == reward
        assert timestep.last() == terminated
        if terminated:
            assert timestep.discount == 0.0 and ours.step(action).first()
            break
    else:
        raise AssertionError("a hopper that is not controlled falls")


def test_a_limit_is_no_end_of_the_task():
    environment = Environment("PushBox", max_episode_steps=2, seed=0)
    environment.reset()
    assert environment.step([0.0, 0.0]).mid()
    last = environment.step([0.0, 0.0])
    assert last.last() and last.discount == 1.0
    assert environment.picture().shape == (480, 480, 3)
