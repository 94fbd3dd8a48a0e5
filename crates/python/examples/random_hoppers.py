"""What a random policy earns with the hopper: 64 environments of Gymnasium on all processors, and one episode as a page."""

import pathlib
import tempfile
import time

import gymnasium
import numpy as np

import signorini.gymnasium
from signorini.gymnasium import Env, VectorEnv

STEPS = 200


def main() -> None:
    envs: VectorEnv = VectorEnv("Hopper", num_envs=64, max_episode_steps=1000)
    rng = np.random.default_rng(0)
    envs.reset(seed=0)
    returns, finished = np.zeros(envs.num_envs), []
    begin = time.perf_counter()
    for _ in range(STEPS):
        _, rewards, terminated, truncated, _ = envs.step(rng.uniform(-1.0, 1.0, (envs.num_envs, 3)))
        returns += rewards
        ended = terminated | truncated
        finished += returns[ended].tolist()
        returns[ended] = 0.0
    seconds = time.perf_counter() - begin
    print(f"{len(finished)} episodes, mean return {np.mean(finished):.1f}, {STEPS * envs.num_envs / seconds:.0f} actions per second")

    env: Env = Env("PushBox", render_mode="html")
    env.reset(seed=1)
    for _ in range(20):
        env.step(rng.uniform(-1.0, 1.0, 2))
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "push_box.html"
        shown = env.render()
        assert isinstance(shown, str)
        page.write_text(shown)
        print(f"an episode of PushBox as a page of {page.stat().st_size / 1e6:.1f} MB")
    assert "signorini/Hopper-v0" in gymnasium.registry and signorini.gymnasium.TASKS["Hopper"]().dt == 0.008


if __name__ == "__main__":
    main()
