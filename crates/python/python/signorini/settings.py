"""Settings of a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Optional

__all__ = ["Settings", "SolverSettings"]


@dataclass(frozen=True)
class SolverSettings:
    """Settings of the structured contact solver; tolerances are relative to the data's velocity scale.

    Attributes:
        polish: proximal iterations stop at this residual, in (0, 1).
        proximal_weight: ε of the proximal term, relative to each contact's Delassus block, in (0, 1).
        smallest_proximal_weight: ε is lowered to this where the iterations converge slowly, in (0, 1).
        mode_tolerance: how far outside its mode's cone a trial impulse may lie, relative to its typical size, in (0, 1).
        newton_iterations: Newton steps on all modes at once before the path is followed, at most.
        max_rounds: how often the path is followed for one proximal problem, at least 1.
        max_proximal_iterations: at least 1.
        path_changes_base: mode changes any path may use.
        path_changes_per_violation: more of them for each contact whose data are shifted, from modes at hand.
        path_changes_per_contact: more of them for each contact, from all contacts open.
        lemke_pivots_per_row: pivots that Lemke's method may use for each row.
        lemke_max_rows: islands with more rows are not given to Lemke's method.
        threads: at most so many threads solve islands at the same time; 0 for as many as the machine gives. The result has the
            same bits whatever it is.
        time_stages: whether the time of every stage is measured, for ``StepReport.stages``.
    """

    polish: float = 1e-12
    proximal_weight: float = 1e-5
    smallest_proximal_weight: float = 1e-10
    mode_tolerance: float = 1e-11
    newton_iterations: int = 10
    max_rounds: int = 4
    max_proximal_iterations: int = 60
    path_changes_base: int = 100
    path_changes_per_violation: int = 8
    path_changes_per_contact: int = 16
    lemke_pivots_per_row: int = 30
    lemke_max_rows: int = 1000
    threads: int = 1
    time_stages: bool = False


@dataclass(frozen=True)
class Settings:
    """Settings of a simulation.

    Attributes:
        timestep: Δt, s; ``None`` takes the model's.
        directions: friction directions of every contact, even, from 4 to 4096.
        direction_angle: angle of the first direction from the first tangent, rad.
        contact_points: points in which two convex shapes touch, at most; 0: all that are found. One that was left out comes in where it
            would close within the step.
        stabilization: factor in (0, 1] on φ/Δt where φ < 0, and on the violation of equality constraints.
        gap_resolution: gaps and overlaps of at most this count as closed, m, and of deeper overlaps what is beyond it counts; with 0 all but last digits
            count. A ten-thousandth of a body's size lets piles of hundreds of bodies come to rest.
        tolerance: a step whose worst residual exceeds this has missed its tolerance, in (0, 1).
        budget: contact sweeps that a step may make, at least 1; ``None`` for steps as exact as can be. Where they are used up the step is made
            with the best point found, ``StepReport.status`` is "inaccurate", and the certificate says how far it is from the laws; momentum
            balance and friction bounds hold to rounding. A count and no clock: the same bits every time. Islands of less than 64 contacts are solved
            as without.
        method: "structured", or a name of ``lcp_methods()`` to solve every step as a dense standard LCP.
        correction_speed: speed at which a step removes overlaps and violations at most, m/s, beside what the motion of the step before
            has left, which it removes in full; ``math.inf`` removes everything in one step.
        correction_angular_speed: the same for angles, rad/s.
        infeasible: what to do where a step cannot remove all of its overlaps and violations: "go_on" removes the largest part that the
            laws permit (``StepReport.theta``), "stop" raises ``SolveError`` before the step, "clip_gaps" solves again with
            negative gaps taken as zero.
        overlaps: parts of one mechanism that overlap in its reference configuration by more than a hundredth of the smaller one's radius:
            "exclude" lets them not touch each other (a warning names them), "keep" keeps them as contacts, "stop" raises an
            error.
        friction_law: "polygon" is maximum dissipation over a polygon of ``directions``, an LCP solved exactly; "circular" is
            Coulomb's law with the circular cone, a nonlinear problem solved to ``tolerance``; "refined" turns the polygon's
            directions into the slip until the circular cone's laws hold within ``cone_tolerance``. The last two need the
            structured solver and contacts as the only friction.
        cone_tolerance: bound on every residual of the circular cone's laws with "refined", in (0, 1).
        impulses: which of the impulses that give the same motion a step ends with: "solver" takes those nearest to the step
            before, "least_norm" those of least norm.
        restitution: law of impacts, with the coefficients of the geoms: "newton" or "poisson".
        position_iterations: Newton steps, at most, that bring the configuration onto the equality constraints after a step;
            with 0 the stabilization alone holds them.
        assembly_tolerance: violation of an equality constraint with which a simulation may begin, m or rad.
        sleeping: whether islands at rest are left unsolved; they are certified all the same. ``None`` takes the model's.
        solver: settings of the structured solver.
    """

    timestep: Optional[float] = None
    directions: int = 8
    direction_angle: float = 0.0
    contact_points: int = 8
    stabilization: float = 1.0
    gap_resolution: float = 0.0
    correction_speed: float = 0.25
    correction_angular_speed: float = 1.0
    tolerance: float = 1e-9
    budget: Optional[int] = None
    method: str = "structured"
    infeasible: Literal["go_on", "stop", "clip_gaps"] = "go_on"
    overlaps: Literal["exclude", "keep", "stop"] = "exclude"
    friction_law: Literal["polygon", "circular", "refined"] = "polygon"
    cone_tolerance: float = 1e-6
    impulses: Literal["solver", "least_norm"] = "solver"
    restitution: Literal["newton", "poisson"] = "newton"
    position_iterations: int = 0
    assembly_tolerance: float = 1e-6
    sleeping: Optional[bool] = None
    solver: SolverSettings = SolverSettings()
