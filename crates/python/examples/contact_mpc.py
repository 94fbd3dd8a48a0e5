"""Model-predictive control through contact: a cart-pole between walls, and a cube that a finger pivots about its edge.

`python contact_mpc.py FOLDER` records both for the viewer. The rates printed are of processor time: OMP_NUM_THREADS=1 keeps them to one core.

In every period the step is taken as a linear complementarity system about the present state, with contacts that are not made yet, and a few
rounds of differential dynamic programming improve the plan on it. Plans are rolled out with the exact complementarity problems. Their
slopes are those of relaxed ones, z w = relaxation, which know that there is a wall before it is touched: where nothing touches,
the exact slopes know of none.
"""

from __future__ import annotations

import contextlib
import sys
import time
from pathlib import Path
from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

import signorini

Array = NDArray[np.float64]


class Planner:
    """A plan of `horizon` controls for a quadratic cost of (q, v) and u.

    Args:
        goal: (nq,).
        running, effort: weights of (q, v), (2 nv,), and of u, (nu,), in every period.
        bound: of every control.
        within: distance of contacts that are planned with, m.
        final: weights of (q, v) at the end; ``None`` takes what a linear-quadratic regulator would pay from there, without contacts.
        relaxation: product of an impulse in N·s and its complement in m/s.
        rounds: of differential dynamic programming in a period.
    """

    def __init__(
        self,
        model: signorini.Model,
        goal: Array,
        running: Sequence[float],
        effort: Sequence[float],
        *,
        horizon: int,
        bound: float,
        within: float,
        final: Optional[Sequence[float]] = None,
        relaxation: float = 1e-4,
        rounds: int = 2,
    ) -> None:
        self.model, self.goal, self.bound, self.within = model, goal, bound, within
        self.running, self.effort = np.diag(running), np.diag(effort)
        self.final = self.regulated() if final is None else np.diag(final)
        self.relaxation, self.rounds = relaxation, rounds
        self.plan: Array = np.zeros((horizon, model.nu))

    def regulated(self) -> Array:
        """What is left to pay where no contact comes any more: the cost of the linear-quadratic regulator at the goal."""
        data = signorini.Data(self.model)
        data.qpos[:] = self.goal
        system = signorini.linearize(self.model, data, within=0.0)
        A, B = system.A, system.B
        cost: Array = self.running
        for _ in range(1000):
            gain = np.linalg.solve(self.effort + B.T @ cost @ B, B.T @ cost @ A)
            cost = self.running + A.T @ cost @ (A - B @ gain)
        return cost

    def control(self, data: signorini.Data) -> Array:
        """Improves the plan from the present state; its first control, and what is left moves up."""
        system = signorini.linearize(self.model, data, within=self.within)
        offset = np.r_[signorini.difference(self.model, data.qpos, self.goal), np.zeros(self.model.nv)]
        states, plan, impulses, cost = self.rollout(system, offset, self.plan)
        for _ in range(self.rounds):
            gains = self.gains(system, offset, states, plan, impulses)
            for step in (1.0, 0.5, 0.25, 0.1):
                better = self.rollout(system, offset, plan, gains, step, states)
                if better[3] < cost - 1e-9 * abs(cost):
                    states, plan, impulses, cost = better
                    break
            else:
                break
        self.plan = np.r_[plan[1:], plan[-1:]]
        first: Array = plan[0]
        return first

    def rollout(
        self,
        system: signorini.LinearComplementaritySystem,
        offset: Array,
        plan: Array,
        gains: Sequence[tuple[Array, Array]] = (),
        step: float = 0.0,
        around: Optional[Array] = None,
    ) -> tuple[Array, Array, Array, float]:
        """States, controls, impulses and cost of a plan, or of one that is corrected along gains about the states of another."""
        x: Array = system.x
        cost: Any = 0.0
        states, used, impulses = [x], [], []
        for k, u in enumerate(plan):
            if around is not None:
                u = u + step * gains[k][0] + gains[k][1] @ (x - around[k])
            u = np.clip(u, -self.bound, self.bound)
            cost += 0.5 * (x + offset) @ self.running @ (x + offset) + 0.5 * u @ self.effort @ u
            x, impulse = system.step(x, u)
            states.append(x)
            impulses.append(impulse)
            used.append(u)
        cost += 0.5 * (x + offset) @ self.final @ (x + offset)
        return np.array(states), np.array(used), np.array(impulses), float(cost)

    def slopes(
        self, system: signorini.LinearComplementaritySystem, states: Array, plan: Array, impulses: Array
    ) -> tuple[Array, Array]:
        """∂x⁺/∂(x, u) along a rollout where every product z w is the relaxation: Newton's method for all periods at once."""
        free = states @ system.E.T + plan @ system.H.T + system.c
        least, diagonal = np.sqrt(self.relaxation), np.arange(len(system.c))
        z: Array = np.maximum(impulses, least)
        w: Array = np.maximum(impulses @ system.F.T + free, least)

        def solved(right: Array) -> Array:
            matrix = np.repeat(system.F[None], len(z), axis=0)
            matrix[:, diagonal, diagonal] += w / z
            out: Any = np.linalg.solve(matrix, right)
            return np.asarray(out, np.float64)

        for _ in range(30):
            rest, gap = z @ system.F.T + free - w, z * w - self.relaxation
            if max(np.abs(rest).max(initial=0), np.abs(gap).max(initial=0)) < 0.1 * self.relaxation:
                break
            dz = solved((-rest - gap / z)[:, :, None])[:, :, 0]
            dw = dz @ system.F.T + rest
            most = np.maximum(np.max(-dz / z, axis=1, initial=0.0), np.max(-dw / w, axis=1, initial=0.0))
            length = np.minimum(1.0, 0.9 / np.maximum(most, 1e-9))[:, None]
            z, w = z + length * dz, w + length * dw
        held = solved(np.repeat(np.c_[system.E, system.H][None], len(z), axis=0))
        n = states.shape[1]
        return system.A - system.D @ held[:, :, :n], system.B - system.D @ held[:, :, n:]

    def gains(
        self, system: signorini.LinearComplementaritySystem, offset: Array, states: Array, plan: Array, impulses: Array
    ) -> list[tuple[Array, Array]]:
        """Feedforward and feedback of one backward pass (Gauss–Newton)."""
        gradient: Any = self.final @ (states[-1] + offset)
        hessian: Any = self.final
        gains = []
        slopes = self.slopes(system, states[:-1], plan, impulses)
        for x, u, A, B in zip(states[-2::-1], plan[::-1], slopes[0][::-1], slopes[1][::-1]):
            gx, gu = self.running @ (x + offset) + A.T @ gradient, self.effort @ u + B.T @ gradient
            hxx, huu, hux = self.running + A.T @ hessian @ A, self.effort + B.T @ hessian @ B, B.T @ hessian @ A
            forward, back = -np.linalg.solve(huu, gu), -np.linalg.solve(huu, hux)
            gradient = gx + back.T @ gu + hux.T @ forward + back.T @ huu @ forward
            hessian = hxx + back.T @ hux + hux.T @ back + back.T @ huu @ back
            gains.append((forward, back))
        return gains[::-1]


CART_POLE = """<mujoco model="cart-pole between walls"><option timestep="0.02"/><worldbody>
  <geom name="left" type="box" pos="-0.45 0 0.8" size="0.1 0.3 0.5"/><geom name="right" type="box" pos="0.45 0 0.8" size="0.1 0.3 0.5"/>
  <body name="cart" pos="0 0 0.2"><joint name="x" type="slide" axis="1 0 0"/><geom type="box" size="0.1 0.06 0.04" mass="1" contype="0" conaffinity="0"/>
    <body name="pole"><joint name="angle" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 0.56" size="0.01" mass="0.2" contype="0" conaffinity="0"/>
      <geom name="tip" pos="0 0 0.6" size="0.04" mass="0.2" friction="0.2"/></body></body>
  </worldbody><actuator><motor joint="x"/></actuator></mujoco>"""

CUBE = """<mujoco model="pivoting a cube"><option timestep="0.02"/><worldbody>
  <geom name="floor" type="plane" size="2 2 1" friction="1"/>
  <body name="cube" pos="0 0 0.1"><joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/><joint name="angle" axis="0 1 0"/>
    <geom type="box" size="0.1 0.1 0.1" mass="0.5" friction="1"/></body>
  <body name="finger" pos="-0.14 0 0.17" gravcomp="1"><joint name="across" type="slide" axis="1 0 0"/><joint name="up" type="slide" axis="0 0 1"/>
    <geom size="0.03" mass="0.2" friction="1"/></body>
  </worldbody><actuator><motor joint="across"/><motor joint="up"/></actuator></mujoco>"""


def run(planner: Planner, data: signorini.Data, periods: int, name: str) -> tuple[Array, int, float]:
    """Controls for some periods; their states, how many had a contact, and how many a second of computing is enough for."""
    spent, states, touching = 0.0, [], 0
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    recorder: Any = data.record(str(folder / f"{name}.rec")) if folder else contextlib.nullcontext()
    with recorder:
        for _ in range(periods):
            start = time.process_time()
            data.ctrl[:] = planner.control(data)
            spent += time.process_time() - start
            signorini.step(planner.model, data)
            states.append(np.r_[data.qpos, data.qvel])
            touching += int(data.ncon > 0)
    if folder:
        signorini.load_recording(str(folder / f"{name}.rec")).to_html(str(folder / f"{name}.html"))
    return np.array(states), touching, periods / spent


def cart_pole(within: float, name: str) -> float:
    """How far from upright a pole ends that was pushed into a wall."""
    model = signorini.Model.from_string(CART_POLE)
    data = signorini.Data(model)
    data.qvel[:] = 0, 3
    planner = Planner(model, np.zeros(2), [5, 50, 0.1, 0.1], [0.01], horizon=10, bound=20, within=within)
    states, touching, rate = run(planner, data, 200, name)
    off = float(np.abs(states[-1, :2]).max())
    print(f"{name}: {touching} periods at a wall, ends {off:.3f} from upright, {rate:.0f} Hz")
    return off


def cube() -> Array:
    """A cube that is tilted by half a radian about its lower edge, and held there."""
    model = signorini.Model.from_string(CUBE)
    data = signorini.Data(model, signorini.Settings(directions=4))
    goal = np.array([0.05, 0.03, 0.5, 0.08, 0.0])
    running, final = [0, 0, 50, 5, 5, 0.01, 0.01, 0.2, 0.1, 0.1], [0, 0, 500, 50, 50, 0.1, 0.1, 10, 1, 1]
    planner = Planner(model, goal, running, [0.01, 0.01], horizon=12, bound=10, within=0.3, final=final)
    states, _, rate = run(planner, data, 120, "cube")
    print(f"cube: tilted by {states[-1, 2]:.4f} rad, {rate:.0f} Hz")
    return states


if __name__ == "__main__":
    assert cart_pole(0.5, "cart-pole, walls planned with") < 0.05
    assert cart_pole(0.0, "cart-pole, walls not seen") > 0.1, "without the walls in the plan they keep the pole down"
    held = cube()[-50:]
    # The last second: it is held where it is wanted, and does not turn.
    assert np.abs(held[:, 2] - 0.5).max() < 1e-2 and np.abs(held[:, 7]).max() < 1e-2
