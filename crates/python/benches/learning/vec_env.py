"""signorini's vector environments as those of Stable-Baselines3."""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Type, Union

import gymnasium
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvObs, VecEnvStepReturn

from signorini.gymnasium import VectorEnv


class SignoriniVecEnv(VecEnv):
    """A :class:`VectorEnv` with autoreset mode "SameStep" behind the interface that Stable-Baselines3 trains on."""

    def __init__(self, envs: VectorEnv) -> None:
        if envs.autoreset_mode is not gymnasium.vector.AutoresetMode.SAME_STEP:
            raise ValueError("make the environments with autoreset_mode='SameStep'")
        self.envs = envs
        self._next_seed: Optional[int] = None
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)

    def seed(self, seed: Optional[int] = None) -> Sequence[Optional[int]]:
        self._next_seed = seed
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def reset(self) -> VecEnvObs:
        observations, _ = self.envs.reset(seed=self._next_seed)
        self._next_seed = None
        return observations.astype(np.float32)

    def step_async(self, actions: NDArray[Any]) -> None:
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        observations, rewards, terminated, truncated, numbers = self.envs.step(self._actions)
        infos: List[Dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(terminated | truncated):
            infos[i]["terminal_observation"] = numbers["final_obs"][i].astype(np.float32)
            infos[i]["TimeLimit.truncated"] = bool(truncated[i] and not terminated[i])
            if "is_success" in numbers["final_info"]:
                infos[i]["is_success"] = bool(numbers["final_info"]["is_success"][i])
        return observations.astype(np.float32), rewards.astype(np.float32), terminated | truncated, infos

    def close(self) -> None:
        self.envs.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> List[Any]:
        return [getattr(self.envs, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        raise NotImplementedError("the simulations share their parameters")

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> List[Any]:
        raise NotImplementedError("the simulations share their methods")

    def env_is_wrapped(
        self, wrapper_class: Type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: VecEnvIndices = None
    ) -> List[bool]:
        return [False] * len(list(self._get_indices(indices)))
