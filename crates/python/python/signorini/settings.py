"""Settings of a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Optional

__all__ = ["Settings"]


@dataclass(frozen=True)
class Settings:
    """Settings of a simulation.

    Attributes:
        timestep: Δt, s; ``None`` takes the model's.
        directions: friction directions of every contact, even, at least 4.
        direction_angle: angle of the first direction from the first tangent, rad.
        stabilization: factor in (0, 1] on φ/Δt where φ < 0.
        tolerance: a step whose worst residual exceeds this has missed its tolerance, in (0, 1).
        method: "structured", or a name of ``lcp_methods()`` to solve every step as a dense standard LCP.
        infeasible: what to do where the contact problem has no solution: "stop" raises ``SolveError`` before the step,
            "clip_gaps" solves again with negative gaps taken as zero.
    """

    timestep: Optional[float] = None
    directions: int = 8
    direction_angle: float = 0.0
    stabilization: float = 1.0
    tolerance: float = 1e-9
    method: str = "structured"
    infeasible: Literal["stop", "clip_gaps"] = "stop"
