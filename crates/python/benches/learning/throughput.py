"""Actions per second of processor time with a random policy, 32 environments on one thread: the vector environments of the package
against Gymnasium's ``SyncVectorEnv`` over its single ones, in interleaved rounds of which the fastest counts."""

from __future__ import annotations

import time
from typing import Any, Sequence

import gymnasium
import numpy as np

from signorini.gymnasium import TASKS, VectorEnv

COUNT, STEPS, ROUNDS = 32, 20, 8


def main() -> None:
    rng = np.random.default_rng(0)
    for name in TASKS:

        def single(name: str = name) -> gymnasium.Env[Any, Any]:
            return gymnasium.make(f"signorini/{name}-v0")

        native = VectorEnv(name, COUNT, max_episode_steps=1000, nthread=1)
        both: Sequence[gymnasium.vector.VectorEnv[Any, Any, Any]] = (native, gymnasium.vector.SyncVectorEnv([single] * COUNT))
        fastest = [np.inf, np.inf]
        for envs in both:
            envs.reset(seed=0)
        for _ in range(ROUNDS):
            actions = [rng.uniform(-1.0, 1.0, native.action_space.shape or ()).astype(np.float32) for _ in range(STEPS)]
            for i, envs in enumerate(both):
                begin = time.process_time()
                for action in actions:
                    envs.step(action)
                fastest[i] = min(fastest[i], time.process_time() - begin)
        ours, theirs = (COUNT * STEPS / seconds for seconds in fastest)
        print(f"{name}: {ours:.0f} actions/s, SyncVectorEnv {theirs:.0f}; {ours * native.task.frame_skip:.0f} steps/s")


if __name__ == "__main__":
    main()
