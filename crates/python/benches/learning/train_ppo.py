"""Trains PPO of Stable-Baselines3 on one of the package's environments, on the CPU, and keeps the curve of its returns.

    pip install 'signorini[gymnasium]' stable-baselines3
    python train_ppo.py Hopper --steps 1500000 --gamma 0.995
    python train_ppo.py HalfCheetah --steps 2000000 --gamma 0.98 --gae-lambda 0.92 --log-std -1
    python train_ppo.py Ant --steps 1500000 --log-std -1
    python train_ppo.py PushBox --steps 1500000 --log-std -0.7

Writes NAME.csv (a row per update: environment steps, seconds by the clock and of the processor, mean return and length of the last
100 episodes, share of them that succeeded) and NAME.json (what a random policy and the policy at the end reach in 20 episodes each, without learning).
"""

from __future__ import annotations

import argparse
import csv
import json
import pathlib
import time
from typing import Any, Callable, Dict, List, Tuple

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize
from vec_env import SignoriniVecEnv

import signorini.gymnasium

EPISODES = 20
"""Episodes of an evaluation."""

Policy = Callable[[NDArray[Any]], NDArray[Any]]


def make_envs(name: str, count: int) -> signorini.gymnasium.VectorEnv:
    """A native vector environment on one thread."""
    envs = gymnasium.make_vec(
        f"signorini/{name}-v0", num_envs=count, vectorization_mode="vector_entry_point", autoreset_mode="SameStep", nthread=1
    )
    assert isinstance(envs, signorini.gymnasium.VectorEnv)
    return envs


def evaluate(name: str, policy: Policy, seed: int) -> Dict[str, float]:
    """Returns of the first episode of each of ``EPISODES`` simulations."""
    envs = make_envs(name, EPISODES)
    observations, _ = envs.reset(seed=seed)
    total, length, success = np.zeros(EPISODES), np.zeros(EPISODES), np.zeros(EPISODES)
    open_ones = np.ones(EPISODES, dtype=bool)
    while open_ones.any():
        observations, rewards, terminated, truncated, infos = envs.step(policy(observations))
        total += rewards * open_ones
        length += open_ones
        ended = open_ones & (terminated | truncated)
        if ended.any() and "is_success" in infos["final_info"]:
            success[ended] = infos["final_info"]["is_success"][ended]
        open_ones &= ~ended
    return {
        "return_mean": float(total.mean()),
        "return_std": float(total.std()),
        "length_mean": float(length.mean()),
        "success": float(success.mean()),
    }


class Curve(BaseCallback):
    """Keeps the mean return of the last 100 episodes at every update, and ends the training when its time is over."""

    def __init__(self, path: pathlib.Path, minutes: float) -> None:
        super().__init__()
        self.path = path
        self.minutes = minutes
        self.rows: List[Tuple[int, float, float, float, float, float]] = []
        self.start, self.cpu_start = time.perf_counter(), time.process_time()

    def _on_step(self) -> bool:
        return time.perf_counter() - self.start < 60.0 * self.minutes

    def _on_rollout_end(self) -> None:
        episodes = self.model.ep_info_buffer
        if episodes:
            mean = float(np.mean([e["r"] for e in episodes])), float(np.mean([e["l"] for e in episodes]))
            success = float(np.mean(self.model.ep_success_buffer)) if self.model.ep_success_buffer else 0.0
            seconds, cpu_seconds = self.elapsed()
            self.rows.append((self.num_timesteps, seconds, cpu_seconds, *mean, success))
            with self.path.open("w", newline="") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(["steps", "seconds", "cpu_seconds", "return_mean", "length_mean", "success"])
                writer.writerows(
                    [s, f"{t:.1f}", f"{c:.1f}", f"{r:.4g}", f"{n:.4g}", f"{p:.3g}"] for s, t, c, r, n, p in self.rows
                )

    def elapsed(self) -> Tuple[float, float]:
        """Seconds since the start, by the clock and of the processor."""
        return time.perf_counter() - self.start, time.process_time() - self.cpu_start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=sorted(signorini.gymnasium.TASKS))
    parser.add_argument("--steps", type=int, default=1_000_000, help="environment steps")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="time after which the training ends")
    parser.add_argument("--envs", type=int, default=32, help="simulations at once")
    parser.add_argument("--horizon", type=int, default=128, help="steps of each simulation per update")
    parser.add_argument("--gamma", type=float, default=0.99, help="discount of an action")
    parser.add_argument("--gae-lambda", type=float, default=0.95, help="of generalised advantage estimation")
    parser.add_argument("--log-std", type=float, default=0.0, help="logarithm of the actions' standard deviation at the start")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path.cwd(), help="folder of the results")
    arguments = parser.parse_args()
    name, seed = arguments.name, arguments.seed

    torch.set_num_threads(1)
    rng = np.random.default_rng(seed)
    actions = make_envs(name, 1).single_action_space.shape
    assert actions is not None
    random = evaluate(name, lambda _: rng.uniform(-1.0, 1.0, (EPISODES, *actions)), seed=10_000 + seed)
    print("random policy:", random, flush=True)

    normalised = VecNormalize(VecMonitor(SignoriniVecEnv(make_envs(name, arguments.envs))), gamma=0.99)
    model = PPO(
        "MlpPolicy",
        normalised,
        n_steps=arguments.horizon,
        batch_size=arguments.envs * arguments.horizon // 16,
        n_epochs=10,
        learning_rate=lambda left: 3e-4 * left,
        gamma=arguments.gamma,
        gae_lambda=arguments.gae_lambda,
        clip_range=0.2,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": arguments.log_std},
        seed=seed,
        device="cpu",
    )
    curve = Curve(arguments.out / f"{name}.csv", arguments.minutes)
    model.learn(arguments.steps, callback=curve)
    seconds, cpu_seconds = curve.elapsed()

    def policy(observations: NDArray[Any]) -> NDArray[Any]:
        inputs = normalised.normalize_obs(observations.astype(np.float32))
        assert isinstance(inputs, np.ndarray)
        return model.predict(inputs, deterministic=True)[0]

    trained = evaluate(name, policy, seed=10_000 + seed)
    print("trained policy:", trained, flush=True)
    results = {
        "steps": model.num_timesteps,
        "seconds": round(seconds, 1),
        "cpu_seconds": round(cpu_seconds, 1),
        "random": random,
        "trained": trained,
    }
    (arguments.out / f"{name}.json").write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
