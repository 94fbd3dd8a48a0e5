"""Multibody dynamics with hard contact and dry friction.

Every time step is a linear complementarity problem (LCP) that is solved exactly and comes with a certificate.

>>> import signorini
>>> model = signorini.Model.from_string(
...     "<mujoco><worldbody><geom type='plane'/><body name='ball' pos='0 0 0.1'><freejoint/>"
...     "<geom size='0.1'/></body></worldbody></mujoco>")
>>> data = signorini.Data(model)
>>> signorini.step(model, data, nstep=100)
>>> data.certificate.holds(1e-9)
True

SI units, ``float64``, world z up; quaternions are (w, x, y, z). A free joint has ``qpos = [position, quaternion]`` and
``qvel = [velocity of the origin in world axes, angular velocity in body axes]``, as in MuJoCo.
"""

from __future__ import annotations

import os
from enum import IntEnum
from typing import Union

from signorini import generate, viewer
from signorini._core import (
    Actuator,
    Assembly,
    Body,
    Certificate,
    ContactPoint,
    ContactProblem,
    ContactSolution,
    ContactSum,
    Contacts,
    Film,
    Geom,
    ImportWarning,
    InverseKinematics,
    Joint,
    Keyframe,
    LcpResult,
    Limits,
    LinearComplementaritySystem,
    Margin,
    Nearest,
    Placements,
    RayHit,
    Recording,
    RecordingCheck,
    Renderer,
    Safety,
    SettleReport,
    Stability,
    StageCount,
    StageRun,
    StepDerivatives,
    StepReport,
    View,
    __version__,
    bias_force,
    cast_ray,
    cast_rays,
    center_of_mass,
    center_of_mass_jacobian,
    contacts_at,
    critical_bodies,
    derivatives,
    difference,
    distance,
    forward,
    frame_pose,
    integrate,
    inverse,
    inverse_kinematics,
    jacobian,
    jacobian_rate,
    kinematics,
    lcp_methods,
    linearize,
    mass_matrix,
    operational_space_inertia,
    overlaps,
    parameter_values,
    placements,
    safety,
    save_png,
    settle,
    solve_lcp,
    stability,
    step,
    support_polygon,
    zero_moment_point,
)
from signorini._parameters import PARAMETERS, Parameter
from signorini._scene import Scene, scene
from signorini.batch import Batch
from signorini.data import ActuatorData, BodyData, Data, JointData, Recorder
from signorini.errors import (
    BatchError,
    ModelError,
    ModelWarning,
    OverlapWarning,
    ProblemError,
    RecordingError,
    SettingError,
    SignoriniError,
    SolveError,
    StateError,
    ToleranceWarning,
)
from signorini.identification import Identification, Unknown, identify, with_parameters
from signorini.lemkelcp import lemkelcp
from signorini.model import Model
from signorini.settings import Settings, SolverSettings
from signorini.spec import Spec, SpecPart

__all__ = [
    "Actuator",
    "Assembly",
    "ActuatorData",
    "Batch",
    "BatchError",
    "Body",
    "BodyData",
    "Certificate",
    "ContactMode",
    "ContactPoint",
    "ContactProblem",
    "ContactSolution",
    "ContactSum",
    "Contacts",
    "Data",
    "Film",
    "Geom",
    "Identification",
    "ImportWarning",
    "InverseKinematics",
    "Joint",
    "JointData",
    "Keyframe",
    "LcpResult",
    "Limits",
    "LinearComplementaritySystem",
    "Margin",
    "Model",
    "ModelError",
    "ModelWarning",
    "Nearest",
    "Placements",
    "OverlapWarning",
    "PARAMETERS",
    "Parameter",
    "ProblemError",
    "RayHit",
    "Recorder",
    "Recording",
    "RecordingCheck",
    "RecordingError",
    "Renderer",
    "Safety",
    "Scene",
    "SettingError",
    "Settings",
    "SettleReport",
    "SignoriniError",
    "SolveError",
    "SolverSettings",
    "Spec",
    "SpecPart",
    "Stability",
    "StageCount",
    "StageRun",
    "StateError",
    "StepDerivatives",
    "StepReport",
    "ToleranceWarning",
    "Unknown",
    "View",
    "__version__",
    "bias_force",
    "cast_ray",
    "cast_rays",
    "center_of_mass",
    "center_of_mass_jacobian",
    "contacts_at",
    "critical_bodies",
    "derivatives",
    "difference",
    "distance",
    "forward",
    "frame_pose",
    "generate",
    "identify",
    "integrate",
    "inverse",
    "inverse_kinematics",
    "jacobian",
    "jacobian_rate",
    "kinematics",
    "lcp_methods",
    "lemkelcp",
    "linearize",
    "load_recording",
    "mass_matrix",
    "operational_space_inertia",
    "overlaps",
    "parameter_values",
    "placements",
    "safety",
    "save_png",
    "scene",
    "settle",
    "solve_lcp",
    "stability",
    "step",
    "support_polygon",
    "viewer",
    "with_parameters",
    "zero_moment_point",
]


class ContactMode(IntEnum):
    """What a contact does: values of ``Contacts.mode`` and ``ContactSolution.mode``."""

    OPEN = 0
    """No impulse."""
    FRICTIONLESS = 1
    """Closed without friction."""
    STICKING = 2
    """Closed, impulse inside the friction cone."""
    SLIDING = 3
    """Slides; the friction impulse is on a direction of the polygon, or between two."""


def load_recording(path: Union[str, "os.PathLike[str]"]) -> Recording:
    """Reads a recording with all its complete frames.

    Raises:
        RecordingError: the file cannot be read or is not a recording.
    """
    return Recording.load(os.fspath(path))
