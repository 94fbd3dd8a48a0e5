"""Steps and rollouts as functions of JAX, with gradients that say when they do not exist (``pip install signorini[jax]``).

The state is (qpos, qvel): models whose actuators have activations are refused. The engine is called on the host, so that they work under
``jit`` and ``grad``; ``vmap`` makes one call after another. It computes in ``float64``: without ``jax_enable_x64`` states are rounded to
``float32`` on the way.
"""

from __future__ import annotations

import importlib
from typing import Any, Optional

import numpy as np

from signorini._rollouts import DerivativeError, Rollout, step_count
from signorini.model import Model
from signorini.settings import Settings

__all__ = ["DerivativeError", "rollout", "step"]

# jax.Array; the package is imported without JAX, too.
Array = Any


def step(
    model: Model,
    qpos: Any,
    qvel: Any,
    ctrl: Any = None,
    qfrc_applied: Any = None,
    *,
    parameters: Any = None,
    theta: Any = None,
    settings: Optional[Settings] = None,
    ties: str = "modes",
) -> tuple[Array, Array]:
    """(qpos, qvel) after one step from (nq,), (nv,); see ``signorini.torch.step``. Where a derivative is refused, the callback's error
    names the step and the reason."""
    def one(x: Any) -> Any:
        return None if x is None else _jax().numpy.asarray(x)[None]

    qs, vs = rollout(
        model, qpos, qvel, one(ctrl), one(qfrc_applied), steps=1, parameters=parameters, theta=theta, settings=settings, ties=ties
    )
    return qs[1], vs[1]


def rollout(
    model: Model,
    qpos: Any,
    qvel: Any,
    ctrl: Any = None,
    qfrc_applied: Any = None,
    *,
    steps: Optional[int] = None,
    parameters: Any = None,
    theta: Any = None,
    settings: Optional[Settings] = None,
    ties: str = "modes",
) -> tuple[Array, Array]:
    """All states of a rollout, (n + 1, nq) and (n + 1, nv), the first ones included; see ``signorini.torch.rollout``."""
    jnp = _jax().numpy
    qpos, qvel = jnp.asarray(qpos), jnp.asarray(qvel)
    if qpos.ndim != 1:
        raise ValueError(f"qpos has shape {qpos.shape}: it must be ({model.nq},); jax.vmap makes batches")
    ctrl, qfrc = (x if x is None else jnp.asarray(x) for x in (ctrl, qfrc_applied))
    n = step_count(model, qpos, qvel, ctrl, qfrc, steps, jnp.issubdtype(qpos.dtype, jnp.floating))
    ctrl = jnp.zeros((n, model.nu), qpos.dtype) if ctrl is None else ctrl
    qfrc = jnp.zeros((n, model.nv), qpos.dtype) if qfrc is None else qfrc
    theta = jnp.zeros(0, qpos.dtype) if theta is None else jnp.asarray(theta)
    out: tuple[Array, Array] = _function(Rollout(model, settings, parameters, ties))(qpos, qvel, ctrl, qfrc, theta)
    return out


def _jax() -> Any:
    try:
        importlib.import_module("jax.numpy")
        return importlib.import_module("jax")
    except ImportError as error:
        raise ImportError("signorini.jax needs JAX: pip install signorini[jax]") from error


def _doubles(arrays: Any) -> list[Any]:
    return [np.asarray(x, np.float64) for x in arrays]


def _function(runner: Rollout) -> Any:
    """The rollouts of a runner with their gradient."""
    jax = _jax()

    def states_of(*given: Any) -> Any:
        qpos, _, ctrl, *_ = given
        sizes = (runner.model.nq, runner.model.nv)
        shapes = tuple(jax.ShapeDtypeStruct((ctrl.shape[0] + 1, size), qpos.dtype) for size in sizes)

        def call(*arrays: Any) -> Any:
            return tuple(np.asarray(x, qpos.dtype) for x in runner.forward(*_doubles(arrays)))

        return jax.pure_callback(call, shapes, *given, vmap_method="sequential")

    def forward(*given: Any) -> Any:
        states = states_of(*given)
        return states, (given, states)

    def backward(kept: Any, gradients: Any) -> Any:
        given, states = kept
        shapes = tuple(jax.ShapeDtypeStruct(x.shape, x.dtype) for x in given)

        def call(*arrays: Any) -> Any:
            found = runner.backward(*_doubles(arrays))
            return tuple(np.asarray(x, shape.dtype) for x, shape in zip(found, shapes))

        return jax.pure_callback(call, shapes, *states, *given[2:], *gradients, vmap_method="sequential")

    function = jax.custom_vjp(states_of)
    function.defvjp(forward, backward)
    return function
