"""Steps and rollouts as functions of PyTorch, with gradients that say when they do not exist (``pip install signorini[torch]``).

>>> import torch, signorini, signorini.torch                                                # doctest: +SKIP
>>> qpos, qvel = signorini.torch.step(model, qpos, qvel, ctrl)                              # doctest: +SKIP

The state is (qpos, qvel): models whose actuators have activations are refused. Gradients by ``qpos`` are along unit quaternions. Double
backward is not offered. Tensors of any floating type on the CPU are taken; the engine computes in ``float64``.
"""

from __future__ import annotations

import importlib
from typing import Any, Optional

import numpy as np

from signorini._rollouts import DerivativeError, Rollout, step_count
from signorini.model import Model
from signorini.settings import Settings

__all__ = ["DerivativeError", "rollout", "step"]

# torch.Tensor; the package is imported without PyTorch, too.
Tensor = Any

_made: list[Any] = []


def step(
    model: Model,
    qpos: Tensor,
    qvel: Tensor,
    ctrl: Optional[Tensor] = None,
    qfrc_applied: Optional[Tensor] = None,
    *,
    parameters: Any = None,
    theta: Optional[Tensor] = None,
    settings: Optional[Settings] = None,
    ties: str = "modes",
) -> tuple[Tensor, Tensor]:
    """(qpos, qvel) after one step.

    Args:
        qpos, qvel: (nq,), (nv,); or (batch, nq), (batch, nv), with all others of the same batch.
        ctrl, qfrc_applied: (nu,), (nv,); zero where they are not given.
        parameters, theta: numbers of the model as for ``signorini.derivatives``, and their values, (number of parameters,).
        ties: what to do at a tie: "modes" takes the derivative of the modes that the solution has, "raise" raises.

    Raises:
        DerivativeError: in the backward pass, where a step has no derivative.
    """
    def one(x: Any) -> Any:
        return None if x is None else x.unsqueeze(-2)

    qs, vs = rollout(
        model, qpos, qvel, one(ctrl), one(qfrc_applied), steps=1, parameters=parameters, theta=theta, settings=settings, ties=ties
    )
    return qs[..., 1, :], vs[..., 1, :]


def rollout(
    model: Model,
    qpos: Tensor,
    qvel: Tensor,
    ctrl: Optional[Tensor] = None,
    qfrc_applied: Optional[Tensor] = None,
    *,
    steps: Optional[int] = None,
    parameters: Any = None,
    theta: Optional[Tensor] = None,
    settings: Optional[Settings] = None,
    ties: str = "modes",
) -> tuple[Tensor, Tensor]:
    """All states of a rollout, (n + 1, nq) and (n + 1, nv), the first ones included; with a batch in front where qpos has one.

    Only states are kept between the passes: the backward pass makes every step again.

    Args:
        ctrl, qfrc_applied: (n, nu), (n, nv), one for each step; zero where they are not given.
        steps: n; it may be left out where one of them is given.

    The others, and what is raised, are as in :func:`step`; a ``ValueError`` names what has another shape than that.
    """
    n = step_count(model, qpos, qvel, ctrl, qfrc_applied, steps, qpos.is_floating_point())
    batch = tuple(qpos.shape[:-1])
    if len(batch) > 1:
        raise ValueError(f"qpos has shape {tuple(qpos.shape)}: it must be (nq,) or (batch, nq)")
    ctrl = qpos.new_zeros((*batch, n, model.nu)) if ctrl is None else ctrl
    qfrc = qpos.new_zeros((*batch, n, model.nv)) if qfrc_applied is None else qfrc_applied
    theta = qpos.new_zeros(0) if theta is None else theta
    runner, function = Rollout(model, settings, parameters, ties), _function()
    if not batch:
        qs, vs = function.apply(runner, qpos, qvel, ctrl, qfrc, theta)
        return qs, vs
    if batch[0] == 0:
        # The zero is of all arguments: their gradients are zero, not missing.
        zero = ctrl.sum() + qfrc.sum() + 0.0 * theta.sum()
        qs, vs = qpos[:, None].expand(0, n + 1, model.nq), qvel[:, None].expand(0, n + 1, model.nv)
        return (qs + zero).to(qpos.dtype), (vs + zero).to(qpos.dtype)
    lanes = [function.apply(runner, *lane, theta) for lane in zip(qpos, qvel, ctrl, qfrc)]
    torch = _torch()
    return torch.stack([q for q, _ in lanes]), torch.stack([v for _, v in lanes])


def _torch() -> Any:
    try:
        return importlib.import_module("torch")
    except ImportError as error:
        raise ImportError("signorini.torch needs PyTorch: pip install signorini[torch]") from error


def _function() -> Any:
    """The class of torch.autograd that makes rollouts, made once."""
    if _made:
        return _made[0]
    torch = _torch()

    def forward(ctx: Any, runner: Rollout, *given: Tensor) -> tuple[Tensor, Tensor]:
        arrays = [x.detach().cpu().numpy().astype(np.float64) for x in given]
        qs, vs = runner.forward(*arrays)
        ctx.kept = (runner, arrays, qs, vs)
        return given[0].new_tensor(qs), given[0].new_tensor(vs)

    def backward(ctx: Any, gqs: Tensor, gvs: Tensor) -> tuple[Any, ...]:
        runner, arrays, qs, vs = ctx.kept
        gradients = [x.detach().cpu().numpy().astype(np.float64) for x in (gqs, gvs)]
        return (None, *(gqs.new_tensor(x) for x in runner.backward(qs, vs, *arrays[2:], *gradients)))

    once = torch.autograd.function.once_differentiable(backward)
    methods = {"forward": staticmethod(forward), "backward": staticmethod(once)}
    _made.append(type("Rollouts", (torch.autograd.Function,), methods))
    return _made[0]
