"""Rollouts and the gradients of functions of them, in NumPy: what ``signorini.torch`` and ``signorini.jax`` have in common."""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from signorini._core import StepDerivatives, derivatives, step
from signorini.data import Data
from signorini.errors import OverlapWarning
from signorini.identification import with_parameters
from signorini.model import Model
from signorini.settings import Settings

Array = NDArray[np.float64]


class DerivativeError(ValueError):
    """A step of a rollout has no derivative; the message says which and why."""


class Gradients(NamedTuple):
    """By qpos (nq,), qvel (nv,), ctrl (n, nu), qfrc_applied (n, nv) and the parameters."""

    qpos: Array
    qvel: Array
    ctrl: Array
    qfrc: Array
    theta: Array


class Rollout:
    """Steps of a model from given states, each from a cold start, so that they can be made again one by one.

    Only the states between steps are kept. The backward pass makes every step again, last one first, and needs the memory of one
    derivative.
    """

    def __init__(self, model: Model, settings: Optional[Settings], parameters: Any, ties: str) -> None:
        if ties not in ("modes", "raise"):
            raise ValueError(f"ties is {ties!r}: it must be 'modes' or 'raise'")
        if model.na:
            raise ValueError(f"the model has {model.na} activations of actuators, a state that rollouts do not have")
        self.model, self.settings = model, settings if settings is not None else Settings()
        self.parameters, self.ties = list(parameters or []), ties

    def data(self, theta: Array) -> tuple[Data, Any]:
        """A Data of the model with these parameters, and the snapshot it begins with."""
        if len(theta) != len(self.parameters):
            raise ValueError(f"theta has {len(theta)} numbers for {len(self.parameters)} parameters")
        model = with_parameters(self.model, self.parameters, theta) if self.parameters else self.model
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OverlapWarning)
            data = Data(model, self.settings)
        return data, data.get_state(warm_start=False)

    def _step(self, data: Data, blank: Any, q: Array, v: Array, u: Array, f: Array) -> None:
        data.set_state(blank)
        data.qpos[:], data.qvel[:] = q, v
        data.ctrl[:], data.qfrc_applied[:] = u, f
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OverlapWarning)
            step(data.model, data)

    def forward(self, q: Array, v: Array, ctrl: Array, qfrc: Array, theta: Array) -> tuple[Array, Array]:
        """All states, (n + 1, nq) and (n + 1, nv)."""
        data, blank = self.data(theta)
        qs, vs = [q], [v]
        for u, f in zip(ctrl, qfrc):
            self._step(data, blank, qs[-1], vs[-1], u, f)
            qs.append(data.qpos.copy())
            vs.append(data.qvel.copy())
        return np.array(qs), np.array(vs)

    def backward(
        self, qs: Array, vs: Array, ctrl: Array, qfrc: Array, theta: Array, gqs: Array, gvs: Array
    ) -> Gradients:
        """Gradients of a function whose gradients by all states are given."""
        data, blank = self.data(theta)
        model = data.model
        n = len(ctrl)
        out = Gradients(
            np.zeros(model.nq), np.zeros(model.nv), np.zeros((n, model.nu)), np.zeros((n, model.nv)), np.zeros(len(theta))
        )
        tangent = tangent_gradient(model, qs[n], gqs[n])
        gv = gvs[n].copy()
        for k in reversed(range(n)):
            self._step(data, blank, qs[k], vs[k], ctrl[k], qfrc[k])
            slopes = derivatives(model, data, self.parameters)
            self._check(slopes, k)
            if self.parameters:
                out.theta[:] += slopes.parameter_vjp(tangent, gv)
            tangent, gv, out.ctrl[k], out.qfrc[k] = slopes.vjp(tangent, gv)
            tangent = tangent + tangent_gradient(model, qs[k], gqs[k])
            gv = gv + gvs[k]
        out.qpos[:], out.qvel[:] = ambient_gradient(model, qs[0], tangent), gv
        return out

    def _check(self, slopes: StepDerivatives, k: int) -> None:
        if slopes.validity == "refused":
            raise DerivativeError(f"step {k} has no derivative: {slopes.reason}")
        if slopes.validity == "one_sided" and self.ties == "raise":
            raise DerivativeError(f"step {k} has a derivative on each side alone: {slopes.deciding}")


def step_count(model: Model, qpos: Any, qvel: Any, ctrl: Any, qfrc: Any, steps: Optional[int], is_floating: bool) -> int:
    """The number of steps that arrays ask for, all of one batch or of none; those that do not belong together are refused.

    Args:
        ctrl, qfrc: ``None`` where they are not given.
        steps: where it is said beside them, or alone.
        is_floating: whether qpos, whose type states have, is made of floating-point numbers.
    """
    if not is_floating:
        raise ValueError(f"qpos has type {qpos.dtype}: it must be a floating type, as the states have it")
    batch = tuple(qpos.shape[:-1])
    long = [x for x in (ctrl, qfrc) if x is not None and len(x.shape) >= 2]
    n = steps if steps is not None else int(long[0].shape[-2]) if long else None
    if n is None and (ctrl is not None or qfrc is not None):
        raise ValueError("ctrl and qfrc_applied must have one row for each step")
    if n is None:
        raise ValueError("the number of steps is needed where there are no controls and no forces")
    if n < 0:
        raise ValueError(f"steps is {n}: it must be at least 0")
    expected = {
        "qpos": (qpos, (*batch, model.nq)),
        "qvel": (qvel, (*batch, model.nv)),
        "ctrl": (ctrl, (*batch, n, model.nu)),
        "qfrc_applied": (qfrc, (*batch, n, model.nv)),
    }
    for name, (array, shape) in expected.items():
        if array is not None and tuple(array.shape) != shape:
            raise ValueError(f"{name} has shape {tuple(array.shape)}: it must be {shape}")
    return n


def _quaternions(model: Model) -> list[tuple[int, int]]:
    """Where quaternions begin in qpos and their rotations in qvel."""
    out = []
    for joint in (model.joint(i) for i in range(model.njnt)):
        if joint.type == "free":
            out.append((joint.qposadr + 3, joint.dofadr + 3))
        elif joint.type == "ball":
            out.append((joint.qposadr, joint.dofadr))
    return out


def _turn(w: float, x: float, y: float, z: float) -> Array:
    """∂(q ⊕ δ)/∂δ of a quaternion q."""
    return 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])


def _plain(model: Model) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of qpos and of qvel of all that is no quaternion, in the same order."""
    turned_q, turned_v = np.zeros(model.nq, bool), np.zeros(model.nv, bool)
    for q, v in _quaternions(model):
        turned_q[q : q + 4], turned_v[v : v + 3] = True, True
    return np.flatnonzero(~turned_q), np.flatnonzero(~turned_v)


def tangent_gradient(model: Model, qpos: Array, gradient: Array) -> Array:
    """From a gradient by the numbers of qpos that by its tangent coordinates, (nv,)."""
    out = np.zeros(model.nv)
    plain_q, plain_v = _plain(model)
    out[plain_v] = gradient[plain_q]
    for q, v in _quaternions(model):
        out[v : v + 3] = _turn(*qpos[q : q + 4]).T @ gradient[q : q + 4]
    return out


def ambient_gradient(model: Model, qpos: Array, gradient: Array) -> Array:
    """From a gradient by tangent coordinates that by the numbers of qpos, (nq,), which is along the unit quaternions."""
    out = np.zeros(model.nq)
    plain_q, plain_v = _plain(model)
    out[plain_q] = gradient[plain_v]
    for q, v in _quaternions(model):
        out[q : q + 4] = 4.0 * _turn(*qpos[q : q + 4]) @ gradient[v : v + 3]
    return out
