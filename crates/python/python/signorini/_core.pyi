"""The native half of the package: what the Rust side gives, with shapes and units.

Arrays are ``float64`` unless said otherwise. Array arguments may be anything that NumPy can read, and matrices also SciPy
sparse ones, which are made dense.
"""

import os
from typing import Any, Callable, Dict, List, Literal, Optional, Protocol, Sequence, Tuple, Union, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, disjoint_base

from signorini.model import Model as _PublicModel
from signorini.settings import Settings as _PublicSettings

__all__ = [
    "Actuator",
    "Assembly",
    "Batch",
    "Body",
    "Certificate",
    "ContactPoint",
    "ContactProblem",
    "ContactSolution",
    "ContactSum",
    "Contacts",
    "Data",
    "Film",
    "Geom",
    "IdentifiedValues",
    "ImportWarning",
    "InverseKinematics",
    "Joint",
    "Keyframe",
    "LcpResult",
    "Limits",
    "LinearComplementaritySystem",
    "Margin",
    "Model",
    "Nearest",
    "Placements",
    "RayHit",
    "Recording",
    "RecordingCheck",
    "Renderer",
    "Safety",
    "SettleReport",
    "Spec",
    "Stability",
    "StageCount",
    "StageRun",
    "StepDerivatives",
    "StepReport",
    "View",
    "Viewer",
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
    "identify_parameters",
    "integrate",
    "inverse",
    "inverse_kinematics",
    "jacobian",
    "jacobian_rate",
    "kinematics",
    "lcp_methods",
    "linearize",
    "make_arch",
    "make_heap",
    "make_pallet",
    "make_rough",
    "make_stack",
    "make_stairs",
    "make_terrain",
    "make_wall",
    "mass_matrix",
    "operational_space_inertia",
    "overlaps",
    "parameter_table",
    "parameter_values",
    "placements",
    "safety",
    "save_png",
    "settle",
    "solve_lcp",
    "stability",
    "step",
    "support_polygon",
    "with_images",
    "with_parameters",
    "zero_moment_point",
]

__version__: str

_Array = NDArray[np.float64]
_Ints = NDArray[np.int32]
_Longs = NDArray[np.int64]
_Path = Union[str, os.PathLike[str]]

class _Sparse(Protocol):
    def toarray(self) -> Any: ...

_MatrixLike = Union[ArrayLike, _Sparse]

@disjoint_base
class Batch:
    """Base of ``signorini.Batch``."""

    def __new__(cls, model: _PublicModel, nsim: int, settings: _PublicSettings, nthread: int = 0) -> Self: ...
    def __len__(self) -> int: ...
    @property
    def model(self) -> _PublicModel:
        """The model."""
    @property
    def settings(self) -> _PublicSettings:
        """The settings."""
    @property
    def nthread(self) -> int:
        """At most so many threads, as asked for; 0 for as many as the machine runs at once."""
    @property
    def time(self) -> _Array:
        """Times, (nsim,), s: a live view."""
    @property
    def qpos(self) -> _Array:
        """Configurations, (nsim, nq): a live view; what is written to it is the state."""
    @property
    def qvel(self) -> _Array:
        """Velocities, (nsim, nv): a live view."""
    @property
    def act(self) -> _Array:
        """Activations of actuators, (nsim, na): a live view."""
    @property
    def ctrl(self) -> _Array:
        """Control values, (nsim, nu): a live view."""
    @property
    def mocap_pos(self) -> _Array:
        """Positions of the bodies that are moved from outside, (nsim, nmocap, 3), m: a live view."""
    @property
    def mocap_quat(self) -> _Array:
        """Their orientations, (nsim, nmocap, 4), (w, x, y, z): a live view."""
    @property
    def residual(self) -> _Array:
        """Largest residual of each simulation's last step, (nsim,); 0 where there is none."""
    @property
    def theta(self) -> _Array:
        """Part θ of the overlaps and violations asked for that each simulation's last step removes, (nsim,); 1 where there is none."""
    @property
    def limited_steps(self) -> _Longs:
        """Steps of each simulation that removed a part of them only, (nsim,): since it was made, or had its parameters varied."""
    @property
    def correction_energy(self) -> _Array:
        """Work of the impulses along the corrections of all steps of each simulation, (nsim,), J: since as ``limited_steps``."""
    @property
    def ncon(self) -> _Ints:
        """Contacts and joint limits in each simulation's last step, (nsim,); 0 where there is none."""
    @property
    def sensordata(self) -> _Array:
        """Numbers of all sensors at the beginning of each simulation's last step, (nsim, nsensordata); 0 where there is none."""
    @property
    def contact_wrench(self) -> _Array:
        """What the contacts of each simulation's last step do to its bodies, (nsim, nbody, 6); 0 where there is none.

        Moments about the bodies' centres of mass, N·m, and mean forces over the step, N, in world axes. The row of body 0, the
        world, is that of fixed geoms, about the origin.
        """
    def step_with_derivatives(self, parameters: Optional[Sequence[Any]] = None) -> list[StepDerivatives]:
        """Makes one step of every simulation, and takes its derivative, on the batch's threads; the GIL is released meanwhile.

        Args:
            parameters: as for ``signorini.derivatives``.

        Returns:
            One for each simulation; "refused" with its reason where one stopped.
        """
    def step(self, nstep: int = 1, ids: Optional[Sequence[int]] = None) -> None:
        """Makes ``nstep`` steps of the simulations ``ids``, or of all; the GIL is released meanwhile.

        Raises:
            BatchError: simulations stopped; the others made all their steps.
            IndexError: there is no simulation of an index.
        """
    def vary(
        self, id: int, *, friction: float = 1.0, mass: float = 1.0, gravity: Optional[Tuple[float, float, float]] = None
    ) -> None:
        """Gives simulation ``id`` parameters of its own, relative to those of the model; its next step starts cold.

        A reset keeps them. ``self.model`` stays the one without them.

        Args:
            id: the simulation.
            friction: factor on all coefficients of sliding friction, at least 0.
            mass: factor on masses and inertia of all bodies, positive.
            gravity: gravity in world, m/s²; without it the model's.

        Raises:
            SettingError: a parameter is out of its range.
            IndexError: there is no such simulation.
        """
    def _rollout(self, ctrl: Optional[ArrayLike], nstep: Optional[int], record: Sequence[str]) -> list[_Array]: ...
    def _reset(self, ids: Optional[Sequence[int]] = None, keyframe: Optional[int] = None) -> None: ...
    def _simulations(self, ids: Optional[Sequence[int]] = None) -> list[int]: ...
    def _save(self) -> list[tuple[bytes, list[tuple[str, list[float]]]]]: ...
    def _restore(self, saved: Sequence[tuple[bytes, Sequence[tuple[str, Sequence[float]]]]]) -> None: ...
    def _parameter(self, name: str) -> _Array: ...
    def _change(self, ids: Sequence[int], changes: Sequence[tuple[str, Sequence[float]]]) -> None: ...

@final
class ImportWarning:
    """Something in a model file that the model does not have, or has in another form."""

    @property
    def file(self) -> str:
        """The file, or a label for text that came from memory."""
    @property
    def line(self) -> int:
        """Line of the first place, from 1."""
    @property
    def element(self) -> str:
        """The element it is about."""
    @property
    def what(self) -> str:
        """What is not taken over."""
    @property
    def effect(self) -> str:
        """What that changes."""
    @property
    def count(self) -> int:
        """Number of places."""
    @property
    def changes_motion(self) -> bool:
        """Whether the motion can differ because of it."""
    @property
    def text(self) -> str:
        """All of it in a line."""

@disjoint_base
class Model:
    """Base of ``signorini.Model``."""

    def __new__(
        cls,
        *,
        path: Optional[_Path] = None,
        text: Optional[str] = None,
        format: str = "auto",
        base_dir: _Path = ...,
        package_dirs: Sequence[_Path] = ...,
        floating_base: bool = False,
        merge_fixed_joints: bool = False,
        self_collision: bool = True,
        srdf: Optional[_Path] = None,
        friction: float = 1.0,
        floor: bool = False,
        missing_meshes: str = "stop",
        decompose: Optional[float] = None,
        visuals: bool = True,
        other: Optional[Model] = None,
    ) -> Self: ...
    @property
    def name(self) -> str:
        """The model's name."""
    @property
    def content_hash(self) -> int:
        """A hash of everything the model is, equal for equal models on every machine."""
    @property
    def import_report(self) -> list[ImportWarning]:
        """Everything in the file that the model does not have, in the order of the file."""
    @property
    def nq(self) -> int:
        """Number of entries of ``qpos``."""
    @property
    def nv(self) -> int:
        """Number of degrees of freedom, entries of ``qvel``."""
    @property
    def na(self) -> int:
        """Number of activations of actuators, entries of ``act``."""
    @property
    def nu(self) -> int:
        """Number of actuators, entries of ``ctrl``."""
    @property
    def nmocap(self) -> int:
        """Number of bodies that are moved from outside, rows of ``mocap_pos`` and ``mocap_quat``."""
    @property
    def nbody(self) -> int:
        """Number of bodies, the world included."""
    @property
    def njnt(self) -> int:
        """Number of joints."""
    @property
    def ngeom(self) -> int:
        """Number of geoms."""
    @property
    def ntendon(self) -> int:
        """Number of tendons."""
    @property
    def nsensor(self) -> int:
        """Number of sensors."""
    @property
    def nsensordata(self) -> int:
        """Number of entries of ``sensordata``."""
    @property
    def nkey(self) -> int:
        """Number of keyframes."""
    @property
    def timestep(self) -> float:
        """Time step that the file suggests, s."""
    @property
    def sleeping(self) -> bool:
        """Whether the file asks for what rests to be left alone."""
    @property
    def gravity(self) -> _Array:
        """Gravity in world, (3,), m/s²."""
    @property
    def qpos0(self) -> _Array:
        """The reference configuration, (nq,)."""
    @property
    def body_mass(self) -> _Array:
        """Masses of the bodies, (nbody,), kg."""
    @property
    def body_parentid(self) -> _Ints:
        """Index of every body's parent, (nbody,); the world's is itself."""
    @property
    def geom_bodyid(self) -> _Ints:
        """Body of every geom, (ngeom,)."""
    @property
    def jnt_bodyid(self) -> _Ints:
        """Body of every joint, (njnt,)."""
    @property
    def jnt_qposadr(self) -> _Ints:
        """Where every joint's entries in ``qpos`` begin, (njnt,)."""
    @property
    def jnt_dofadr(self) -> _Ints:
        """Where every joint's entries in ``qvel`` begin, (njnt,)."""
    @property
    def jnt_range(self) -> _Array:
        """Limits of every joint, (njnt, 2), rad or m; infinite where there are none."""
    @property
    def actuator_ctrlrange(self) -> _Array:
        """Ranges of the control values, (nu, 2); infinite where there are none."""
    @property
    def body_names(self) -> list[str]:
        """Names of the bodies; index 0 is the world."""
    @property
    def joint_names(self) -> list[str]:
        """Names of the joints."""
    @property
    def geom_names(self) -> list[str]:
        """Names of the geoms."""
    @property
    def actuator_names(self) -> list[str]:
        """Names of the actuators."""
    @property
    def tendon_names(self) -> list[str]:
        """Names of the tendons."""
    @property
    def sensor_names(self) -> list[str]:
        """Names of the sensors."""
    @property
    def sensor_adr(self) -> _Ints:
        """Where every sensor's entries in ``sensordata`` begin, (nsensor,)."""
    @property
    def sensor_dim(self) -> _Ints:
        """Number of every sensor's entries in ``sensordata``, (nsensor,)."""
    @property
    def keyframe_names(self) -> list[str]:
        """Names of the keyframes."""
    def _body(self, id: int) -> Body: ...
    def _joint(self, id: int) -> Joint: ...
    def _geom(self, id: int) -> Geom: ...
    def _actuator(self, id: int) -> Actuator: ...
    def _keyframe(self, id: int) -> Keyframe: ...
    def _mocap_names(self) -> list[str]: ...
    def _activation_names(self) -> list[str]: ...
    def _parameter(self, name: str) -> _Array: ...
    def _parameter_parts(self, name: str) -> list[str]: ...
    def _images(self) -> Any: ...

@disjoint_base
class Spec:
    """Base of ``signorini.Spec``."""

    def __new__(cls, model: Optional[Model] = None, name: str = "world") -> Self: ...
    @property
    def gravity(self) -> Tuple[float, float, float]:
        """Gravity in world, (3), m/s²; set it as a whole."""
    @gravity.setter
    def gravity(self, gravity: Sequence[float]) -> None: ...
    @property
    def timestep(self) -> float:
        """Suggested time step, s."""
    @timestep.setter
    def timestep(self, timestep: float) -> None: ...
    @property
    def sleeping(self) -> bool:
        """Whether simulations leave alone what rests, where they are not told otherwise."""
    @sleeping.setter
    def sleeping(self, sleeping: bool) -> None: ...
    def _attach(
        self, other: Spec, body: str = "world", *, pos: Sequence[float] = ..., quat: Sequence[float] = ..., prefix: str = ""
    ) -> None: ...
    def _add(
        self,
        sort: str,
        element: str,
        body: str,
        assets: str = "",
        weighs: Optional[bool] = None,
        name: str = "",
        own: Sequence[Tuple[str, Any]] = ...,
    ) -> None: ...
    def _inertia_of_geoms(self, body: str) -> None: ...
    def _add_relation(self, sort: str, name: str, element: str) -> None: ...
    def _attributes(self, sort: str) -> list[str]: ...
    def _get(self, sort: str, name: str, attribute: str) -> Any: ...
    def _set(self, sort: str, name: str, attribute: str, value: Any) -> bool: ...
    def add_exclude(self, bodyname1: str, bodyname2: str) -> None:
        """Keeps two bodies from touching.

        Raises:
            ModelError: there is no such body.
        """
    @property
    def excludes(self) -> list[tuple[str, str]]:
        """Pairs of names of bodies that are kept from touching; a copy."""
    def remove_exclude(self, bodyname1: str, bodyname2: str) -> None:
        """Lets two bodies touch again.

        Raises:
            ModelError: there is no such body, or they are not kept from touching.
        """
    def names(self, sort: str) -> list[str]:
        """Names of all parts of a sort ("body", "joint", "geom", "site", "tendon", "actuator", "sensor", "equality", "keyframe"), in order.

        Raises:
            ProblemError: there is no such sort.
        """
    def remove(self, sort: Literal["body", "joint", "geom", "site", "tendon", "actuator", "sensor", "equality", "keyframe"], name: str) -> list[str]:
        """Removes a part with all that hangs on it or refers to it; lists what went.

        Raises:
            ModelError: no part has this name; the message has the most similar one.
        """
    def to_mjcf(self) -> tuple[str, list[str]]:
        """The model as MJCF that needs no other file, and what MJCF cannot say.

        Raises:
            ModelError: the parts are no mechanism; the message names the part.
        """
    def _mechanism(self) -> tuple[str, list[str]]: ...
    def _dress(self, model: Model) -> Model | None: ...
    def to_urdf(self) -> tuple[str, list[str], list[tuple[str, str]]]:
        """The compiled model as URDF, what URDF cannot say, and the files (meshes) that it names, with their text.

        Raises:
            ModelError: the parts are no mechanism.
        """

@final
class View:
    """From where a picture is taken."""

    @staticmethod
    def looking(position: Sequence[float], target: Sequence[float], fovy: float = 45.0) -> View:
        """From a point to another one, (3,), m, with the world's z axis up.

        Args:
            fovy: angle between the lower and the upper edge of the picture, degrees.
        """
    @staticmethod
    def orbit(
        target: Sequence[float], distance: float, azimuth: float = 120.0, elevation: float = ..., fovy: float = 45.0
    ) -> View:
        """At a distance (m) from a target (3,) (m), looking along ``azimuth`` (0: along x, 90: along y) and up by ``elevation``, degrees."""
    @property
    def position(self) -> _Array:
        """Position of the camera, (3,), world, m."""
    @property
    def quat(self) -> _Array:
        """How it is turned, (4,), w, x, y, z: its x axis to the right of the picture, y up, -z into the scene."""
    @property
    def fovy(self) -> float:
        """Angle between the lower and the upper edge of the picture, degrees."""

@final
class Renderer:
    """Takes pictures of a model, without a window or a graphics card.

    Args:
        model: the model.
        width, height: of pictures, pixels.
        samples: rays for every pixel. With 1 there are more at edges and shadows are hard; 16 and more give soft shadows and dark corners,
            as a paper would print them, and take 15 times as long
            (640 × 480 pixels: 0.16 s and 2.5 s of one core).
        shadows: whether things throw shadows.
        background: "sky" or "white".
        groups: visibility groups that are shown (MJCF ``group``).

    Raises:
        ValueError: a picture would have no pixels, or more than 16384 along a side, or there is no such background.
    """

    def __new__(
        cls,
        model: Model,
        width: int = 640,
        height: int = 480,
        *,
        samples: int = 1,
        shadows: bool = True,
        background: str = "sky",
        groups: Sequence[int] = ...,
    ) -> Self: ...
    @property
    def model(self) -> Model:
        """The model."""
    @property
    def width(self) -> int:
        """Width of pictures in pixels."""
    @property
    def height(self) -> int:
        """Height of pictures in pixels."""
    def render(self, data: Data, camera: Union[str, View, None] = None) -> NDArray[np.uint8]:
        """What a camera sees, (height, width, 3), red, green, blue.

        Args:
            data: the state.
            camera: a camera of the model by name, a view, or nothing: the scene fills the picture.

        Raises:
            ValueError: there is no such camera.
        """
    def depth(self, data: Data, camera: Union[str, View, None] = None) -> NDArray[np.float64]:
        """Distance along the camera's axis, (height, width), m; infinite where there is nothing."""
    def segmentation(self, data: Data, camera: Union[str, View, None] = None) -> NDArray[np.int32]:
        """Index of the geom, (height, width), -1 where there is none."""
    def framing(self, data: Data, azimuth: float = 120.0, elevation: float = ...) -> View:
        """A view in which the scene, as it is in ``data``, fills the picture, along ``azimuth`` and up by ``elevation``, degrees."""

@final
class Film:
    """A film in the making: H.264 in an MP4 file, made without another program.

    Args:
        width, height: of frames, pixels; even.
        fps: frames per second.
    """

    def __new__(cls, width: int = 640, height: int = 480, fps: float = 30.0) -> Self: ...
    def add(self, frame: NDArray[np.uint8]) -> None:
        """Adds a frame, (height, width, 3)."""
    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the film; more frames can follow, and it can be written again."""
    def __len__(self) -> int: ...
    def __bool__(self) -> bool: ...

def make_heap(count: int, shapes: str, radius: float, friction: float, bin: bool, seed: int) -> str: ...
def make_stack(count: int, size: float, offset: float, friction: float, seed: int) -> str: ...
def make_pallet(layers: int, friction: float, free: bool) -> str: ...
def make_wall(columns: int, courses: int, brick: Sequence[float], friction: float) -> str: ...
def make_arch(count: int, radius: float, thickness: float, depth: float, friction: float) -> str: ...
def make_stairs(steps: int, rise: float, run: float, width: float, friction: float, objects: int, seed: int) -> str: ...
def make_rough(
    points: int, size: float, height: float, roughness: float, friction: float, objects: int, seed: int
) -> str: ...
def make_terrain(
    heights: ArrayLike, size: Sequence[float], height: float, friction: float, objects: int, seed: int
) -> str: ...
def save_png(path: Union[str, os.PathLike[str]], picture: NDArray[np.uint8]) -> None:
    """Writes a picture, (height, width, 3), as PNG."""

@final
class Nearest:
    """Where two geoms are nearest to each other."""

    @property
    def distance(self) -> float:
        """Signed distance of the surfaces, m; negative where they overlap."""
    @property
    def normal(self) -> _Array:
        """Unit normal from the first geom to the second, (3,), world axes."""
    @property
    def point1(self) -> _Array:
        """The point of the first geom's surface, (3,), world, m."""
    @property
    def point2(self) -> _Array:
        """The point of the second geom's surface, (3,), world, m."""

@final
class RayHit:
    """Where a ray meets a geom first."""

    @property
    def geom(self) -> int:
        """Index of the geom."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def distance(self) -> float:
        """Distance from the ray's origin, m."""
    @property
    def point(self) -> _Array:
        """The point, (3,), world, m."""
    @property
    def normal(self) -> _Array:
        """Unit outward normal of the surface, (3,), world axes."""

@final
class ContactPoint:
    """A point at which two geoms touch or nearly touch."""

    @property
    def geom1(self) -> int:
        """Index of the first geom."""
    @property
    def geom2(self) -> int:
        """Index of the second geom."""
    @property
    def body1(self) -> int:
        """Index of the first body."""
    @property
    def body2(self) -> int:
        """Index of the second body."""
    @property
    def point(self) -> Tuple[float, float, float]:
        """The point, midway between the surfaces, world, m."""
    @property
    def normal(self) -> Tuple[float, float, float]:
        """Unit normal from the first geom to the second, world axes."""
    @property
    def gap(self) -> float:
        """Gap, m; negative where they overlap."""
    @property
    def friction(self) -> float:
        """Coefficient of friction."""

@final
class InverseKinematics:
    """What inverse kinematics found."""

    @property
    def qpos(self) -> _Array:
        """The configuration, (nq,)."""
    @property
    def converged(self) -> bool:
        """Whether the target is met within the tolerance."""
    @property
    def position_error(self) -> float:
        """Distance of the frame's origin from the target, m."""
    @property
    def angle_error(self) -> float:
        """Angle of the frame from the target, rad."""
    @property
    def iterations(self) -> int:
        """Evaluations of the error."""

@final
class Body:
    """A rigid body of a model."""

    @property
    def id(self) -> int:
        """Index in the model."""
    @property
    def name(self) -> str:
        """Name."""
    @property
    def parent(self) -> str:
        """Name of the parent."""
    @property
    def mass(self) -> float:
        """Mass, kg."""
    @property
    def com(self) -> Tuple[float, ...]:
        """Centre of mass in the body frame, 3 numbers, m."""
    @property
    def inertia(self) -> Tuple[Tuple[float, ...], ...]:
        """Rotational inertia about the centre of mass in the body's axes, 3 × 3, kg·m²."""
    @property
    def joints(self) -> Tuple[str, ...]:
        """Names of the joints that move it, in order."""
    @property
    def begins_asleep(self) -> bool:
        """Whether, where sleeping is allowed, its tree stands in the reference configuration until something touches it."""

@final
class Joint:
    """A joint of a model."""

    @property
    def id(self) -> int:
        """Index in the model."""
    @property
    def name(self) -> str:
        """Name."""
    @property
    def type(self) -> Literal["free", "ball", "hinge", "slide"]:
        """Its kind."""
    @property
    def body(self) -> int:
        """Index of the body it moves."""
    @property
    def qposadr(self) -> int:
        """Where its entries in ``qpos`` begin."""
    @property
    def dofadr(self) -> int:
        """Where its entries in ``qvel`` begin."""
    @property
    def nq(self) -> int:
        """Number of its entries in ``qpos``."""
    @property
    def nv(self) -> int:
        """Number of its entries in ``qvel``."""
    @property
    def axis(self) -> Optional[Tuple[float, ...]]:
        """Axis in the body frame (hinge, slide), 3 numbers; ``None`` for others."""
    @property
    def range(self) -> Optional[Tuple[float, ...]]:
        """Lower and upper limit, rad or m; ``None`` without limits."""
    @property
    def damping(self) -> float:
        """Viscous damping, N·s/m or N·m·s/rad."""
    @property
    def stiffness(self) -> float:
        """Spring stiffness, N/m or N·m/rad."""
    @property
    def armature(self) -> float:
        """Rotor inertia, kg or kg·m²."""
    @property
    def frictionloss(self) -> float:
        """Dry friction bound, N or N·m."""

@final
class Geom:
    """A shape of a model."""

    @property
    def id(self) -> int:
        """Index in the model."""
    @property
    def name(self) -> str:
        """Name."""
    @property
    def body(self) -> int:
        """Index of the body that carries it."""
    @property
    def type(self) -> str:
        """"plane", "sphere", "box", "capsule", "cylinder", "cone", "ellipsoid", "convex mesh", "triangle mesh", "height field"."""
    @property
    def size(self) -> Tuple[float, ...]:
        """Half-extents, m: x, y, z (box, ellipsoid), radius (sphere), radius and half the length (capsule, cylinder, cone)."""
    @property
    def friction(self) -> float:
        """Coefficient of friction."""
    @property
    def pos(self) -> Tuple[float, ...]:
        """Position in the body frame, 3 numbers, m."""
    @property
    def quat(self) -> Tuple[float, ...]:
        """Orientation in the body frame, (w, x, y, z)."""
    @property
    def rgba(self) -> Tuple[float, ...]:
        """Red, green, blue, opacity, in [0, 1]."""

@final
class Actuator:
    """An actuator of a model."""

    @property
    def id(self) -> int:
        """Index in the model."""
    @property
    def name(self) -> str:
        """Name."""
    @property
    def type(self) -> Literal["motor", "position", "velocity", "speed", "affine", "muscle"]:
        """Its law."""
    @property
    def joint(self) -> Optional[int]:
        """Index of the joint it drives; ``None`` if it drives something else."""
    @property
    def tendon(self) -> Optional[int]:
        """Index of the tendon it drives; ``None`` if it drives something else."""
    @property
    def site(self) -> Optional[int]:
        """Index of the site it drives; ``None`` if it drives something else."""
    @property
    def body(self) -> Optional[int]:
        """Index of the body whose contacts it pulls together; ``None`` if it drives something else."""
    @property
    def gear(self) -> float:
        """Factor from actuator force to joint force."""
    @property
    def ctrlrange(self) -> Optional[Tuple[float, ...]]:
        """Range of the control value; ``None`` without one."""
    @property
    def forcerange(self) -> Optional[Tuple[float, ...]]:
        """Range of the force before the gear, N or N·m; ``None`` without one."""

@final
class Keyframe:
    """A named state of a model."""

    @property
    def id(self) -> int:
        """Index in the model."""
    @property
    def name(self) -> str:
        """Name."""
    @property
    def time(self) -> float:
        """Time, s."""
    @property
    def qpos(self) -> Tuple[float, ...]:
        """Configuration, nq numbers."""
    @property
    def qvel(self) -> Tuple[float, ...]:
        """Velocity, nv numbers."""
    @property
    def act(self) -> Tuple[float, ...]:
        """Activations, na numbers."""
    @property
    def ctrl(self) -> Tuple[float, ...]:
        """Control, nu numbers."""
    @property
    def mocap_pos(self) -> Tuple[Tuple[float, ...], ...]:
        """Positions of the bodies that are moved from outside, nmocap times 3, m; empty: where the model places them."""
    @property
    def mocap_quat(self) -> Tuple[Tuple[float, ...], ...]:
        """Their orientations, nmocap times 4, (w, x, y, z); empty as these."""

@disjoint_base
class Data:
    """Base of ``signorini.Data``."""

    def __new__(cls, model: _PublicModel, settings: _PublicSettings) -> Self: ...
    @property
    def model(self) -> _PublicModel:
        """The model."""
    @property
    def settings(self) -> _PublicSettings:
        """The settings."""
    @property
    def qpos(self) -> _Array:
        """Configuration, (nq,), m, rad, unit quaternions (w, x, y, z): a live view; what is written to it is the state."""
    @qpos.setter
    def qpos(self, value: ArrayLike) -> None: ...
    @property
    def qvel(self) -> _Array:
        """Generalized velocity, (nv,), m/s, rad/s: a live view."""
    @qvel.setter
    def qvel(self, value: ArrayLike) -> None: ...
    @property
    def act(self) -> _Array:
        """Activations of actuators, (na,): a live view."""
    @act.setter
    def act(self, value: ArrayLike) -> None: ...
    @property
    def ctrl(self) -> _Array:
        """Control values, (nu,): a live view."""
    @ctrl.setter
    def ctrl(self, value: ArrayLike) -> None: ...
    @property
    def qfrc_applied(self) -> _Array:
        """Applied generalized force, (nv,), N, N·m: a live view."""
    @qfrc_applied.setter
    def qfrc_applied(self, value: ArrayLike) -> None: ...
    @property
    def xfrc_applied(self) -> _Array:
        """Applied force (N) and moment (N·m) on each body at its centre of mass, world axes, (nbody, 6): a live view."""
    @xfrc_applied.setter
    def xfrc_applied(self, value: ArrayLike) -> None: ...
    @property
    def actuator_force(self) -> _Array:
        """Forces of the actuators in the last step, before the gear, (nu,), N or N·m; zeros before the first step."""
    @property
    def mocap_pos(self) -> _Array:
        """Positions of the bodies that are moved from outside, (nmocap, 3), m: a live view."""
    @mocap_pos.setter
    def mocap_pos(self, value: ArrayLike) -> None: ...
    @property
    def mocap_quat(self) -> _Array:
        """Their orientations, (nmocap, 4), (w, x, y, z): a live view."""
    @mocap_quat.setter
    def mocap_quat(self, value: ArrayLike) -> None: ...
    @property
    def qacc(self) -> _Array:
        """Mean acceleration over the last step, (nv,), m/s², rad/s²: (v⁺ − v)/Δt."""
    @property
    def xpos(self) -> _Array:
        """Positions of the bodies' origins in world, (nbody, 3), m."""
    @property
    def xquat(self) -> _Array:
        """Orientations of the bodies, (nbody, 4), (w, x, y, z)."""
    @property
    def xmat(self) -> _Array:
        """Rotation matrices of the bodies, (nbody, 3, 3), body to world."""
    @property
    def xipos(self) -> _Array:
        """Centres of mass of the bodies in world, (nbody, 3), m."""
    @property
    def linear_velocity(self) -> _Array:
        """Velocities of the bodies' origins, (nbody, 3), world axes, m/s."""
    @property
    def angular_velocity(self) -> _Array:
        """Angular velocities of the bodies, (nbody, 3), world axes, rad/s."""
    @property
    def time(self) -> float:
        """Time, s."""
    @time.setter
    def time(self, time: float) -> None: ...
    @property
    def timestep(self) -> float:
        """Length of a step, s."""
    @property
    def steps(self) -> int:
        """Steps made with this object."""
    @property
    def missed_steps(self) -> int:
        """Steps made with this object whose residuals exceed the tolerance."""
    @property
    def limited_steps(self) -> int:
        """Steps made with this object that were permitted to remove a part of their overlaps and violations only."""
    @property
    def correction_energy(self) -> float:
        """Work of the impulses along corrections of overlaps and violations, J, of all steps made with this object."""
    @property
    def clipped_steps(self) -> int:
        """Steps made with this object in which negative gaps were taken as zero (``Settings.infeasible``)."""
    @property
    def contact(self) -> Contacts:
        """Contacts of the last step."""
    @property
    def limit(self) -> Limits:
        """Limits of joints and tendons in the last step's problem."""
    @property
    def sensordata(self) -> _Array:
        """Numbers of all sensors, (nsensordata,): those of the state at the beginning of the last step, and the accelerations and
        forces with which it went on; zeros before the first step."""
    @property
    def ncon(self) -> int:
        """Number of contacts of the last step."""
    @property
    def body_asleep(self) -> NDArray[np.bool_]:
        """Whether the last step left each body alone, (nbody,), because it and what is around it stood as they had stood before
        (``Settings.sleeping``); its contacts are among those of the step."""
    @property
    def certificate(self) -> Certificate:
        """Residuals of the laws in the last step."""
    @property
    def report(self) -> StepReport:
        """How the last step was solved."""
    @property
    def energy(self) -> Tuple[float, float]:
        """Kinetic and potential energy at the present qpos and qvel, J."""
    def problem(self) -> ContactProblem:
        """The contact problem of the last step, a copy.

        Raises:
            RuntimeError: no step was made or previewed since the data was made, reset or set.
        """
    def solution(self) -> ContactSolution:
        """The solution of the last step's contact problem, a copy; errors as :meth:`problem`."""
    def get_state(self, *, warm_start: bool = True) -> _Array:
        """Time (1), qpos (nq), qvel (nv), act (na), ctrl (nu), qfrc_applied (nv), xfrc_applied (6 nbody), mocap_pos with mocap_quat
        (7 for each of nmocap), and the solver's warm start (any number) as one vector.

        Given back to :meth:`set_state` of any data of the same model and settings, a run goes on with the same bits.
        """
    def set_state(self, state: ArrayLike) -> None:
        """Takes over a vector of :meth:`get_state`; one without warm start makes the next step start cold.

        Raises:
            StateError: the vector is not one of this model; nothing has changed then but the warm start.
        """
    def _reset(self, keyframe: Optional[int] = None) -> None: ...
    def _parameter(self, name: str) -> _Array: ...
    def _change(self, changes: Sequence[tuple[str, Sequence[float]]]) -> None: ...
    def _changed(self) -> list[tuple[str, list[float]]]: ...
    def _start_recording(self, path: Optional[_Path] = None) -> None: ...
    def _stop_recording(self, reason: str) -> Optional[Recording]: ...

@final
class Contacts:
    """The contacts of a step: a snapshot whose arrays have one row per contact, in the order of the contact problem.

    Normals point from geom1 to geom2; forces and impulses act on geom2.
    """

    @staticmethod
    def _of(contacts: Any, timestep: float, bodies: Any, part: Any) -> Contacts: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...
    def __len__(self) -> int: ...
    @property
    def gap(self) -> _Array:
        """Signed distances at the beginning of the step, (ncon,), m; negative when penetrating."""
    @property
    def point(self) -> _Array:
        """Contact points in world, midway between the surfaces, those of a flat patch at the mean of their heights, (ncon, 3), m."""
    @property
    def frame(self) -> _Array:
        """Contact frames, (ncon, 3, 3): rows normal, first tangent, second tangent, in world."""
    @property
    def friction(self) -> _Array:
        """Coefficients of friction, (ncon,)."""
    @property
    def impulse(self) -> _Array:
        """Impulses of the step along normal and tangents, (ncon, 3), N·s: all that acted on the bodies there, the drive of a
        moving surface and both phases of an impact included.
        """
    @property
    def stabilization(self) -> _Array:
        """The part of ``impulse`` that corrects penetrations and violated equality constraints, (ncon, 3), N·s: what it has
        beyond the impulse of the same step with these taken as zero. One more problem is solved for it, once.

        Raises:
            RuntimeError: the contacts are those of a recording, which does not hold it.
        """
    def between(self, body1: str | int, body2: str | int) -> ContactSum:
        """Sums over the contacts between two bodies, by name or index; they act on ``body2``.

        Raises:
            KeyError: no body has this name; the message lists those that exist.
            IndexError: the index is out of range.
        """
    @property
    def force(self) -> _Array:
        """Mean forces over the step along normal and tangents, (ncon, 3), N."""
    @property
    def force_world(self) -> _Array:
        """Mean forces over the step on geom2 in world axes, (ncon, 3), N."""
    @property
    def sliding_velocity(self) -> _Array:
        """Velocities of geom2 relative to geom1 along the two tangents at the end of the step, (ncon, 2), m/s."""
    @property
    def mode(self) -> NDArray[np.int8]:
        """What each contact does, (ncon,): values of ``signorini.ContactMode``."""
    @property
    def direction(self) -> _Ints:
        """The friction directions that a sliding contact's impulse lies on, (ncon, 2); -1 where there is none."""
    @property
    def geom1(self) -> _Ints:
        """First geoms, (ncon,)."""
    @property
    def geom2(self) -> _Ints:
        """Second geoms, (ncon,)."""
    @property
    def body1(self) -> _Ints:
        """Bodies of the first geoms, (ncon,)."""
    @property
    def body2(self) -> _Ints:
        """Bodies of the second geoms, (ncon,)."""

@final
class ContactSum:
    """What the contacts between two bodies add up to in a step; it acts on the second of them, world axes."""

    @property
    def ncon(self) -> int:
        """Number of contacts."""
    @property
    def closed(self) -> int:
        """Number of contacts with an impulse."""
    @property
    def impulse(self) -> _Array:
        """Sum of the impulses on the second body, (3,), N·s."""
    @property
    def force(self) -> _Array:
        """Mean force over the step on the second body, (3,), N."""
    @property
    def torque(self) -> _Array:
        """Mean moment of these forces about the world's origin, (3,), N·m."""

@final
class Limits:
    """The limits of joints and tendons in a step's problem: a snapshot whose arrays have one entry per limit. That of a ball joint may be there more
    than once, about several axes.
    """

    def __len__(self) -> int: ...
    @property
    def joint(self) -> _Ints:
        """Joints, (nlimit,); -1 where it is the limit of a tendon."""
    @property
    def tendon(self) -> _Ints:
        """Tendons, (nlimit,); -1 where it is the limit of a joint."""
    @property
    def upper(self) -> NDArray[np.bool_]:
        """Whether it is the upper limit, (nlimit,)."""
    @property
    def gap(self) -> _Array:
        """Distance to the limit at the beginning of the step, (nlimit,), rad or m; negative beyond it."""
    @property
    def impulse(self) -> _Array:
        """Impulses away from the limit, (nlimit,), N·s or N·m·s."""
    @property
    def force(self) -> _Array:
        """Mean forces over the step away from the limit, (nlimit,), N or N·m."""

@final
class Certificate:
    """Residuals of the laws of one step or solve; each is 0 for an exact solution, without unit."""

    @staticmethod
    def _of(residuals: Any) -> Certificate: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...
    @property
    def momentum(self) -> float:
        """Momentum balance of the claimed velocity and impulses."""
    @property
    def natural_map(self) -> float:
        """Natural map of the LCP in one unit."""
    @property
    def signorini(self) -> float:
        """Signorini's condition."""
    @property
    def friction(self) -> float:
        """Friction bound in the polygon's gauge."""
    @property
    def dissipation(self) -> float:
        """Maximum dissipation: distance from the linear program's minimum."""
    @property
    def bilateral(self) -> float:
        """Bilateral rows."""
    @property
    def worst(self) -> float:
        """The largest residual."""
    def holds(self, tolerance: float = 1e-9) -> bool:
        """Whether every law holds within ``tolerance``."""
    def _repr_html_(self) -> str: ...

@final
class StageCount:
    """What a stage of the structured solver did."""

    @property
    def asked(self) -> int:
        """How often it was asked: once for each island that came to it."""
    @property
    def ended(self) -> int:
        """How often it ended an island: by a solution, or by the proof that there is none."""
    @property
    def time_share(self) -> Optional[float]:
        """Its part of the time of all stages; None where times were not measured."""

@final
class StageRun:
    """What a stage of the structured solver did on an island."""

    @property
    def island(self) -> int:
        """The island, by the order of the first tree in each."""
    @property
    def stage(self) -> str:
        """The stage's name."""
    @property
    def outcome(self) -> str:
        """Why it ended."""
    @property
    def residuals(self) -> list[float]:
        """What the laws lacked after each proximal iteration, relative to the island's velocity scale."""

@final
class StepReport:
    """What the last step did."""

    @staticmethod
    def _of(verdict: Any, work: Any, corrections: Any, stages: Any) -> StepReport: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...
    @property
    def status(self) -> str:
        """"solved", "inaccurate", "unresolved", "infeasible", "iteration_limit"."""
    @property
    def blamed(self) -> list[int]:
        """Contacts that contradict each other, where the status says so; indices into the problem."""
    @property
    def certificate(self) -> Certificate:
        """Residuals of the step."""
    @property
    def contacts(self) -> int:
        """Contacts in the problem, joint limits included."""
    @property
    def iterations(self) -> int:
        """Mode changes, proximal iterations and pivots together."""
    @property
    def islands(self) -> int:
        """Islands: sets of trees that contacts tie together."""
    @property
    def lemke_islands(self) -> int:
        """Islands that were given to Lemke's method."""
    @property
    def sweeps(self) -> int:
        """Contact sweeps."""
    @property
    def worst_row(self) -> tuple[str, int] | None:
        """Where the budget was used up: the row that lacks most, ("contact", "group" or "bilateral", its index in the problem)."""
    @property
    def residual_rms(self) -> float | None:
        """Where the budget was used up: root mean square of what the rows lack, relative to the velocity scale."""
    @property
    def missed_tolerance(self) -> bool:
        """Whether the worst residual exceeds the tolerance."""
    @property
    def theta(self) -> float:
        """Part θ of the overlaps and violations asked for that the step removes: 1 where it is all of them."""
    @property
    def kept(self) -> list[tuple[str, int, float]]:
        """What was kept where ``theta`` is less than 1: ("contact" or "bilateral", index of the row in the problem, m or rad)."""
    @property
    def correction_energy(self) -> float:
        """Work of the impulses along the corrections, J."""
    @property
    def left_out(self) -> int:
        """Contact points that no degree of freedom moves along their normal; they are not in the problem."""
    @property
    def clipped_gaps(self) -> bool:
        """Whether negative gaps were taken as zero."""
    @property
    def enlargements(self) -> int:
        """How often contacts were found anew because a body moved farther than expected."""
    @property
    def stages(self) -> dict[str, StageCount]:
        """What the structured solver's stages did, those that were asked, by name in the order of the cascade.

        Times are measured where ``SolverSettings.time_stages`` asks for it.
        """

@final
class SettleReport:
    """How :func:`settle` brought a state to rest."""

    @property
    def steps(self) -> int:
        """Steps towards rest; 0 where the state rested."""
    @property
    def factorizations(self) -> int:
        """Factorisations in them; 0 where the state rested."""
    @property
    def at_rest(self) -> StepReport:
        """The ordinary step that ended where it began."""
    @property
    def speed(self) -> float:
        """Largest entry of the velocity before and after it, m/s or rad/s: zero, or rounding where springs or servos hold a load."""

@final
class Assembly:
    """Rigid blocks given by their surfaces; what touches is found from their faces, without any simulation.

    Where a plane of one block lies on a plane of another, the corners of the convex hull of what they have in common are contact points.
    Blocks that touch at edges or corners alone do not touch here.

    Args:
        floor: height of a floor, m; ``None`` for none. The friction of what stands on it counts.
        touching: faces at most this far apart touch, and may overlap as much, m.
    """

    def __new__(cls, *, floor: Optional[float] = None, touching: float = 1e-6) -> Assembly: ...
    def add(
        self,
        name: str,
        vertices: ArrayLike,
        faces: Sequence[Sequence[int]],
        *,
        density: float = 1000.0,
        friction: float = 0.6,
        fixed: bool = False,
    ) -> None:
        """Adds a block.

        Args:
            vertices: (n, 3), in world, m.
            faces: polygons of vertex indices, closed and all looking to one side; they need not be convex.
            density: kg/m³.
            friction: the larger coefficient of two blocks counts.
            fixed: whether it is held in its place.

        Raises:
            SettingError: the faces enclose no volume, or a number is out of its range.
        """
    def __len__(self) -> int:
        """Number of blocks."""
    def join(
        self,
        first: Optional[str],
        second: Optional[str],
        points: ArrayLike,
        normal: Tuple[float, float, float],
        *,
        tension: float,
        friction: float = 0.6,
    ) -> None:
        """Adds points at which two blocks hold together: studs of bricks, dabs of glue.

        Args:
            first, second: names of blocks; ``None`` for the floor.
            points: (n, 3), in world, m.
            normal: from the first to the second.
            tension: what each point bears, N.
            friction: its coefficient of friction.

        Raises:
            SettingError: there is no such block, or a number is out of its range.
        """
    def stability(self, *, tolerance: float = 1e-9, enumeration: int = 1000) -> Stability:
        """Whether the blocks stand under their weight; as :func:`stability`."""
    def safety(
        self,
        *,
        what: str,
        direction: Optional[Union[Tuple[float, float, float], str]] = None,
        body: Optional[str] = None,
        circular: bool = False,
        motion: bool = False,
        tolerance: float = 1e-9,
    ) -> Safety:
        """How far the blocks are from collapse; as :func:`safety`, without loads."""

@final
class Placements:
    """What became of many configurations of a model; see :func:`placements`."""

    @property
    def verdict(self) -> List[str]:
        """The verdicts, as of :func:`stability`; "unknown" where neither forces nor a mechanism were found to the accuracy asked for."""
    @property
    def proved(self) -> bool:
        """Whether every proof is there and holds within the tolerance."""
    @property
    def residual(self) -> NDArray[np.float64]:
        """Worst residual of each proof, (n,); not a number where the verdict is unknown, as the numbers below."""
    @property
    def overlap(self) -> NDArray[np.float64]:
        """The deepest overlap that was taken as touching, (n,), m or rad."""
    @property
    def margin(self) -> NDArray[np.float64]:
        """Where the limit that was asked for lies at least, (n,); not a number where it must move or none was asked for."""
    def __len__(self) -> int:
        """Number of placements."""

@final
class Safety:
    """A limit between two values with a proof each; see :func:`safety`."""

    @property
    def holds(self) -> float:
        """Forces balance the loads here; not a number where they do not even as it is."""
    @property
    def falls(self) -> float:
        """No forces balance the loads here; infinite, or for friction not a number, where there is no such value."""
    @property
    def residuals(self) -> Tuple[Optional[float], Optional[float]]:
        """Residuals of the two proofs: of the balance, and of the mechanism."""
    @property
    def direction(self) -> Optional[NDArray[np.float64]]:
        """The worst of all directions in world, (3,); ``None`` where one was given."""
    @property
    def at_least(self) -> Optional[float]:
        """No direction has a limit below this; ``None`` where one was given."""
    @property
    def circular(self) -> Optional[Tuple[float, float]]:
        """With circular cones of friction forces balance the loads at the first value, and none do at the second."""
    @property
    def polygons(self) -> Optional[Tuple[float, float]]:
        """The limits with regular polygons of friction inside and outside the circles."""
    @property
    def motion(self) -> Optional[Tuple[float, float]]:
        """Where no moving solution was found, and where there is one; a value between the two is the limit."""
    def save(self, prefix: Union[str, "os.PathLike[str]"]) -> None:
        """Writes both proofs with their problems, for ``signorini check``.

        PREFIX-holds.npz and PREFIX-holds-proof.npz, PREFIX-falls.npz and PREFIX-falls-proof.npz.
        """

@final
class Stability:
    """A verdict on a configuration at rest, with what proves it; see :func:`stability`."""

    @property
    def verdict(self) -> str:
        """"must_move", "stays", "may_do_either" or "stands"."""
    @property
    def residuals(self) -> Dict[str, float]:
        """Residuals of the proof, by name; each is 0 for a proof without rounding."""
    @property
    def proved(self) -> bool:
        """Whether the proof holds within the tolerance."""
    @property
    def forces(self) -> NDArray[np.float64]:
        """Contact forces of the balance on the second body in world, (nc, 3), N; zero where there is no balance, and for limits."""
    @property
    def friction_use(self) -> NDArray[np.float64]:
        """The part of its friction that every contact uses in the balance, (nc,)."""
    @property
    def points(self) -> NDArray[np.float64]:
        """Contact points in world, (nc, 3), m; not a number for limits."""
    @property
    def motion(self) -> Dict[str, Tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """How bodies move in the mechanism, whose fastest has speed 1, or in the first step of the moving solution.

        Velocity of the origin (m/s) and angular velocity (rad/s) in world, by the name of the body.
        """
    @property
    def required_force(self) -> Optional[float]:
        """Contact forces together, N, that a balance would need at least; infinite where none of any size would do.

        ``None`` where there is a balance.
        """
    def force_ranges(self) -> NDArray[np.float64]:
        """The range of every contact's normal force over all balances, (nc, 2), N; infinite where contacts can press against each other.

        (0, 2) where there is no balance. Two linear programs per contact: for problems of up to some hundred contacts.

        Raises:
            ProblemError: there is friction of joints, servos, spinning or rolling.
        """
    @property
    def search(self) -> List[Tuple[str, str]]:
        """Where the search for a moving solution started and what it ended with: "rests", "moves" or "nothing"."""
    @property
    def problem(self) -> ContactProblem:
        """The contact problem that the verdict speaks of."""
    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the verdict with its proof as .npz, for ``signorini check PROBLEM.npz PROOF.npz``."""

@final
class ContactProblem:
    """The contact problem of one step as plain data.

    Find v, lambda_n, alpha, beta with M (v − v_free) = Jnᵀ lambda_n + Jtᵀ D alpha,
    0 ≤ lambda_n ⟂ phi/dt + Jn v ≥ 0, 0 ≤ alpha ⟂ Dᵀ Jt v + E beta ≥ 0, 0 ≤ beta ⟂ mu lambda_n − Eᵀ alpha ≥ 0.

    Args:
        M: mass matrix, (nv, nv), symmetric positive definite.
        Jn: normal Jacobian, (nc, nv).
        Jt: tangential Jacobian, (2 nc, nv): rows 2i and 2i + 1 are those of contact i.
        phi: gaps, (nc,), m; negative when penetrating.
        mu: coefficients of friction, (nc,) or one for all.
        dt: time step, s.
        v_free: velocity without contact, (nv,).
        directions: number of equally spaced friction directions of every contact, even, or for every contact an
            (m_i, 2) array of unit vectors, balanced. Default 8.
        Jb: Jacobian of bilateral rows, (nb, nv).
        theta: violations of the bilateral rows, (nb,).

    Raises:
        ProblemError: an array has a wrong shape, a number is not finite or out of range, M is not positive definite.
    """

    @staticmethod
    def _from_bytes(bytes: bytes) -> ContactProblem: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...
    def __new__(
        cls,
        M: _MatrixLike,
        Jn: _MatrixLike,
        Jt: _MatrixLike,
        phi: ArrayLike,
        mu: ArrayLike,
        dt: float,
        v_free: ArrayLike,
        directions: Optional[Union[int, Sequence[ArrayLike]]] = None,
        *,
        Jb: Optional[_MatrixLike] = None,
        theta: Optional[ArrayLike] = None,
    ) -> Self: ...
    @staticmethod
    def load(path: _Path) -> ContactProblem:
        """Reads a problem file (``.npz``)."""
    def save(self, path: _Path) -> None:
        """Writes a problem file (``.npz``) for ``signorini solve``, ``signorini check`` and :meth:`load`."""
    @property
    def nv(self) -> int:
        """Number of degrees of freedom."""
    @property
    def nc(self) -> int:
        """Number of contacts."""
    @property
    def M(self) -> _Array:
        """Mass matrix, (nv, nv), kg, kg·m, kg·m²; in a step the effective one, with implicit springs and dampers."""
    @property
    def Jn(self) -> _Array:
        """Normal Jacobian, (nc, nv)."""
    @property
    def Jt(self) -> _Array:
        """Tangential Jacobian, (2 nc, nv): rows 2i and 2i + 1 are those of contact i."""
    @property
    def Jb(self) -> _Array:
        """Jacobian of the bilateral rows, (nb, nv)."""
    @property
    def theta(self) -> _Array:
        """Violations of the bilateral rows, (nb,), m or rad."""
    @property
    def phi(self) -> _Array:
        """Gaps, (nc,), m."""
    @property
    def mu(self) -> _Array:
        """Coefficients of friction, (nc,)."""
    @property
    def dt(self) -> float:
        """Time step, s."""
    @property
    def v_free(self) -> _Array:
        """Velocity without contact, (nv,), m/s, rad/s."""
    @property
    def D(self) -> _Array:
        """Friction directions of all contacts, (m, 2), contact after contact."""
    @property
    def direction_offsets(self) -> NDArray[np.int64]:
        """Where each contact's directions begin in ``D``, (nc + 1,)."""
    def lcp(self) -> Tuple[_Array, _Array]:
        """The standard LCP in z = (lambda_n, alpha, beta): A, (n, n), and b, (n,), with n = 2 nc + m.

        Raises:
            ProblemError: there are bilateral rows; take :meth:`mixed_lcp`.
        """
    def mixed_lcp(self) -> Tuple[_Array, _Array, NDArray[np.bool_]]:
        """The mixed LCP in (v, lambda_b, lambda_n, alpha, beta): A, b, and which unknowns are free."""
    def solve(
        self,
        method: str = "structured",
        *,
        tolerance: float = 1e-9,
        warm_start: Optional[ContactSolution] = None,
        record_history: bool = False,
    ) -> ContactSolution:
        """Solves the problem; the GIL is released meanwhile.

        Args:
            method: "structured", or a name of ``lcp_methods()`` for the dense standard LCP.
            tolerance: the worst residual up to which the status is "solved", in (0, 1).
            warm_start: a solution of a similar problem with the same contacts (structured method).
            record_history: whether the solution has the ``history`` of the stages on every island (structured method).

        Raises:
            SettingError: no method has this name, or the tolerance is out of its range.
        """
    def certify(
        self,
        v: ArrayLike,
        lambda_n: ArrayLike,
        alpha: ArrayLike,
        beta: ArrayLike,
        lambda_b: Optional[ArrayLike] = None,
        *,
        alpha_f: Optional[ArrayLike] = None,
        beta_f: Optional[ArrayLike] = None,
    ) -> Certificate:
        """Residuals of a claimed solution, computed from the data alone: anyone's solver can be judged by it.

        Args:
            v, lambda_n, alpha, beta: see :class:`ContactSolution`.
            lambda_b: impulses of the bilateral rows, (nb,); zero where they are not given.
            alpha_f, beta_f: impulses and multipliers of friction that is no contact's sliding (of joints, servos and belts, spinning,
                rolling), as ``ContactSolution.alpha_f`` and ``beta_f``; needed where the problem has some.

        Raises:
            ProblemError: the problem has such friction, and its numbers are missing.
        """
    def contradiction(self) -> Optional[Tuple[_Array, _Array, float]]:
        """The proof that there is no solution, because no velocity satisfies the gaps and bilateral rows together; None where there is none.

        Returns:
            Multipliers y ≥ 0 of the gaps, (nc,), and z of the bilateral rows, (nb,), with Jnᵀ y + Jbᵀ z = 0 and phi·y + theta·z < 0, and
            what rounding leaves of that, 0 for an exact proof.
        """

@final
class ContactSolution:
    """Velocity and impulses that solve a contact problem, with their certificate."""

    @property
    def v(self) -> _Array:
        """Velocity at the end of the step, (nv,), m/s, rad/s."""
    @property
    def lambda_n(self) -> _Array:
        """Normal impulses, (nc,), N·s."""
    @property
    def alpha(self) -> _Array:
        """Impulses along the friction directions, (m,), N·s."""
    @property
    def beta(self) -> _Array:
        """Multipliers of the friction bounds, (nc,), m/s."""
    @property
    def lambda_b(self) -> _Array:
        """Impulses of the bilateral rows, (nb,), N·s or N·m·s."""
    @property
    def alpha_f(self) -> _Array:
        """Impulses along the directions of friction that is no contact's sliding, group after group, N·s or N·m·s."""
    @property
    def beta_f(self) -> _Array:
        """Multipliers of the bounds of that friction, one per group, m/s or rad/s."""
    @property
    def z(self) -> _Array:
        """z = (lambda_n, alpha, beta) of the standard LCP."""
    @property
    def impulse(self) -> _Array:
        """Impulses along normal and tangents, (nc, 3), N·s."""
    @property
    def mode(self) -> NDArray[np.int8]:
        """What each contact does, (nc,): values of ``signorini.ContactMode``."""
    @property
    def direction(self) -> _Ints:
        """The friction directions that a sliding contact's impulse lies on, (nc, 2); -1 where there is none."""
    @property
    def status(self) -> str:
        """"solved", "inaccurate", "unresolved", "infeasible", "iteration_limit"."""
    @property
    def solved(self) -> bool:
        """Whether every law holds within the tolerance."""
    @property
    def blamed(self) -> list[int]:
        """Contacts that contradict each other, where the status says so."""
    @property
    def certificate(self) -> Certificate:
        """Residuals of the laws, computed from the data."""
    @property
    def iterations(self) -> int:
        """Mode changes, proximal iterations and pivots together."""
    @property
    def stages(self) -> dict[str, StageCount]:
        """What the structured solver's stages did, those that were asked, by name in the order of the cascade."""
    @property
    def history(self) -> list[StageRun]:
        """What each stage did on each island, in order; empty unless the solve was asked to record it."""

@final
class LcpResult:
    """The end of a run of a method on a complementarity problem."""

    @property
    def z(self) -> _Array:
        """The point, (n,); the best one found where the problem was not solved."""
    @property
    def w(self) -> _Array:
        """w = A z + b, (n,)."""
    @property
    def status(self) -> str:
        """"solved", "inaccurate", "unresolved", "infeasible", "no_solution", "iteration_limit", "inconsistent", "singular", "too_large"."""
    @property
    def solved(self) -> bool:
        """Whether the residual is within the method's tolerance."""
    @property
    def residual(self) -> float:
        """Natural-map residual of ``z`` in the original data, relative to max |b|."""
    @property
    def iterations(self) -> int:
        """Pivots (Lemke) or bases (enumeration)."""
    @property
    def basis(self) -> NDArray[np.bool_]:
        """Which ``z`` are basic, (n,): a warm start for a similar problem."""
    @property
    def ray(self) -> Optional[_Array]:
        """Direction in ``z`` of the ray on which Lemke's path ended, (n,); ``None`` where it did not."""
    @property
    def farkas(self) -> Optional[_Array]:
        """A proof that no z ≥ 0 has A z + b ≥ 0: y ≥ 0, Aᵀ y ≤ 0, bᵀ y < 0, (n,); ``None`` where none was found."""
    @property
    def exclusion(self) -> Optional[list[tuple[list[int], list[int], _Array]]]:
        """What was excluded, where there is a proof that there is no solution: cases that together are all, each as (pairs with z = 0, pairs
        with w = 0, multipliers); ``None`` where there is none."""

@final
class Margin:
    """How far an inequality of a step is from turning."""

    @property
    def source(self) -> str:
        """What it belongs to: "contact" (limits are among them), "friction group", "bilateral row", "candidate" (a point that is not in the
        step's problem), "joint limit" and "tendon limit" (those that are not in it), or "range" (of a control, force or length)."""
    @property
    def index(self) -> Optional[int]:
        """Index of the contact, group or row in the step's problem, or of the joint or tendon in the model."""
    @property
    def kind(self) -> str:
        """Which inequality: "gap", "normal_impulse", "friction_bound", "sliding_speed", "direction", "share", "feature", "threshold",
        "redundancy" or "range"."""
    @property
    def value(self) -> float:
        """Velocities relative to the problem's velocity scale, impulses times the Delassus scale relative to the same, forces and controls
        relative to their range."""

@final
class StepDerivatives:
    """The derivative of a step, with the flag that says whether it exists.

    Configurations are in the tangent coordinates of ``integrate`` at both ends: δq has the axes of qvel. The matrices of a one-sided
    derivative are those of the modes that the solution has; a refused one has none, and asking for them is a ``ValueError``.
    """

    @property
    def validity(self) -> Literal["exact", "one_sided", "refused"]:
        """"exact": every inequality holds by a margin; "one_sided": those in ``deciding`` are about to turn; "refused": see ``reason``."""
    @property
    def reason(self) -> Optional[str]:
        """Why there is no derivative; ``None`` where there is one."""
    @property
    def deciding(self) -> list[Margin]:
        """The inequalities that are about to turn, where the derivative is one-sided."""
    @property
    def margins(self) -> list[Margin]:
        """How far every inequality of the step is from turning."""
    @property
    def A(self) -> _Array:
        """∂(q⁺, v⁺)/∂(q, v), (2 nv, 2 nv)."""
    @property
    def B(self) -> _Array:
        """∂(q⁺, v⁺)/∂ctrl, (2 nv, nu)."""
    @property
    def B_force(self) -> _Array:
        """∂(q⁺, v⁺)/∂qfrc_applied, (2 nv, nv)."""
    @property
    def P(self) -> _Array:
        """∂(q⁺, v⁺) by the parameters asked for, (2 nv, number of parameters); a ``ValueError`` says which has no derivative, and why."""
    def parameter_vjp(self, gq: Optional[ArrayLike] = None, gv: Optional[ArrayLike] = None) -> _Array:
        """The gradient by the parameters of a function whose gradient by (q⁺, v⁺) is given, without forming matrices."""
    def jvp(
        self,
        dq: Optional[ArrayLike] = None,
        dv: Optional[ArrayLike] = None,
        dctrl: Optional[ArrayLike] = None,
        dqfrc: Optional[ArrayLike] = None,
    ) -> tuple[_Array, _Array]:
        """(δq⁺, δv⁺) from a change of the arguments, (nv,) each and (nu,) for ctrl, without forming matrices; what is not given is zero."""
    def directional(
        self,
        dq: Optional[ArrayLike] = None,
        dv: Optional[ArrayLike] = None,
        dctrl: Optional[ArrayLike] = None,
        dqfrc: Optional[ArrayLike] = None,
    ) -> tuple[_Array, _Array]:
        """(δq⁺, δv⁺) to the side of a change; at a tie of contacts the one-sided derivative along it, which a small LCP decides.

        Raises:
            ValueError: the step or the tie has none; the message says why.
        """
    def vjp(
        self, gq: Optional[ArrayLike] = None, gv: Optional[ArrayLike] = None
    ) -> tuple[_Array, _Array, _Array, _Array]:
        """The gradient by (q, v, ctrl, qfrc_applied) of a function whose gradient by (q⁺, v⁺) is given, without forming matrices."""

@final
class LinearComplementaritySystem:
    """x⁺ = A x + B u + D λ + d, 0 ≤ λ ⟂ E x + F λ + H u + c ≥ 0, about a state.

    x = (δq, v), (2 nv,), with q = q* ⊕ δq (``signorini.integrate``); u, (nu,); λ = (lambda_n, alpha, beta), (nlambda,), of the
    standard LCP, impulses in N·s. M, Jn, Jt and the friction directions are those of the state; the gap is linear in δq with
    slope Jn; the velocity without contact is linearised in q, v and u. At the state itself the system is the step.

    Source: A. Aydinoglu, A. Wei, W.-C. Huang, M. Posa, Consensus Complementarity Control for Multi-Contact MPC, IEEE
    Transactions on Robotics (2024), with the letters as there.
    """

    @property
    def A(self) -> _Array:
        """(2 nv, 2 nv)."""
    @property
    def B(self) -> _Array:
        """(2 nv, nu)."""
    @property
    def D(self) -> _Array:
        """(2 nv, nlambda)."""
    @property
    def d(self) -> _Array:
        """(2 nv,)."""
    @property
    def E(self) -> _Array:
        """(nlambda, 2 nv)."""
    @property
    def F(self) -> _Array:
        """(nlambda, nlambda)."""
    @property
    def H(self) -> _Array:
        """(nlambda, nu)."""
    @property
    def c(self) -> _Array:
        """(nlambda,)."""
    @property
    def x(self) -> _Array:
        """The state about which it was made, (0, qvel), (2 nv,)."""
    @property
    def u(self) -> _Array:
        """The control about which it was made, (nu,)."""
    @property
    def problem(self) -> ContactProblem:
        """The contact problem of the step from there."""
    def step(
        self, x: Optional[ArrayLike] = None, u: Optional[ArrayLike] = None, method: str = "automatic"
    ) -> Tuple[_Array, _Array]:
        """One step of the system: x⁺, (2 nv,), and λ, (nlambda,). Without ``x`` or ``u``, those about which it was made.

        Raises:
            SolveError: the LCP was not solved.
        """

@final
class RecordingCheck:
    """What certifying the steps of a recording again found; true where every law holds in every step."""

    @property
    def ok(self) -> bool:
        """Whether there are steps and every law holds in all of them."""
    @property
    def steps(self) -> int:
        """Steps certified."""
    @property
    def law(self) -> str:
        """"polygon" or "circular_cone": the law of friction of the certificates."""
    @property
    def worst(self) -> Certificate:
        """Largest residual of each law."""
    @property
    def worst_step(self) -> int:
        """The step with the largest residual."""
    @property
    def violated(self) -> int:
        """Number of steps that do not hold."""
    @property
    def violations(self) -> list[tuple[int, float, str]]:
        """The first of them: step, time in s, and what is wrong."""
    @property
    def restarts(self) -> list[int]:
        """Steps that do not begin where the one before ended: the state was set from outside."""
    def __bool__(self) -> bool: ...

@final
class Recording:
    """What a run did, frame by frame: state at the beginning of each step, its contacts, its residuals."""

    @staticmethod
    def load(path: _Path) -> Recording:
        """Reads a file with all its complete frames."""
    def save(self, path: _Path) -> None:
        """Writes a file for :meth:`load` and ``load_recording``."""
    @overload
    def to_html(
        self, path: None = None, *, title: str = "", notes: Sequence[Tuple[str, str]] = ..., max_frames: int = 2000
    ) -> str: ...
    @overload
    def to_html(
        self, path: _Path, *, title: str = "", notes: Sequence[Tuple[str, str]] = ..., max_frames: int = 2000
    ) -> None:
        """One HTML page with the run in 3-D, contact forces, energies and residuals: written to ``path``, or returned."""
    def to_npz(self, path: _Path) -> None:
        """Writes every quantity as one array over all frames, for ``numpy.load``: those of this class under their names, and
        the contacts of all frames one after the other as ``contact_…``, those of frame i from ``contact_start[i]`` on.
        """
    def to_csv(self, path: _Path) -> None:
        """Writes one row per frame, after a row of names with units: state, energies, contacts, residuals."""
    def to_mcap(self, path: _Path) -> None:
        """Writes timed JSON messages for Foxglove and other readers of MCAP: poses, shapes, contact forces, contacts,
        certificates, states.
        """
    def to_rerun(self, path: _Path) -> None:
        """Writes a recording of Rerun, ``.rrd``.

        Raises:
            ImportError: the package rerun-sdk is not installed (``pip install 'signorini[rerun]'``).
        """
    def check(self, model: Model | None = None, *, tolerance: float = 1e-8) -> RecordingCheck:
        """Certifies every step again, without any solver: at the recorded state the contact problem is built anew from the
        model, and the recorded velocity and impulses are judged as its solution.

        Args:
            model: the recorded one; made from the text in the recording if it is not given.
            tolerance: largest residual of a step that holds.

        Raises:
            RecordingError: the model is another one, or the recording holds neither solutions nor its model's text.
            ModelError: the text cannot become a model any more.
        """
    def _geoms(self) -> str: ...
    def _to_bytes(self) -> bytes: ...
    @staticmethod
    def _from_bytes(bytes: bytes) -> Recording: ...
    def __reduce__(self) -> Tuple[Any, ...]: ...
    def _inline_html(self, title: str, max_frames: int, height: int) -> str: ...
    def _repr_html_(self) -> str: ...
    def __len__(self) -> int: ...
    @property
    def model_name(self) -> str:
        """The model's name."""
    @property
    def model_hash(self) -> int:
        """The model's ``content_hash``."""
    @property
    def timestep(self) -> float:
        """Length of a step, s."""
    @property
    def body_names(self) -> list[str]:
        """Names of the bodies."""
    @property
    def ending(self) -> str:
        """How the run ended."""
    @property
    def time(self) -> _Array:
        """Times, (nframe,), s."""
    @property
    def qpos(self) -> _Array:
        """Configurations, (nframe, nq)."""
    @property
    def qvel(self) -> _Array:
        """Velocities, (nframe, nv)."""
    @property
    def xpos(self) -> _Array:
        """Positions of the bodies' origins, (nframe, nbody, 3), m."""
    @property
    def xquat(self) -> _Array:
        """Orientations of the bodies, (nframe, nbody, 4), (w, x, y, z)."""
    @property
    def energy(self) -> _Array:
        """Kinetic and potential energy, (nframe, 2), J."""
    @property
    def residuals(self) -> _Array:
        """Residuals, (nframe, 5): momentum, natural map, Signorini, friction, dissipation."""
    @property
    def iterations(self) -> NDArray[np.uint32]:
        """Solver iterations, (nframe,)."""
    @property
    def ncon(self) -> _Ints:
        """Numbers of contacts, (nframe,)."""
    @property
    def status(self) -> list[str]:
        """How each step ended."""
    def contact(self, index: int) -> Contacts:
        """Contacts of the step that begins at frame ``index``; the last frame has none."""

@disjoint_base
class Viewer:
    """Base of ``signorini.viewer.Viewer``."""

    def __new__(cls, data: Data, port: int, title: str, running: bool, speed: float) -> Self: ...
    @property
    def url(self) -> str:
        """The address of the page; whoever knows it can see and move the simulation."""
    @property
    def is_open(self) -> bool:
        """Whether it has not been closed."""
    def close(self) -> None:
        """Ends the simulation in the browser; closing twice is closing once."""
    def _state(self) -> Tuple[float, _Array, _Array]: ...
    def _open_browser(self) -> None: ...

def step(model: Model, data: Data, nstep: int = 1) -> None:
    """Makes ``nstep`` steps; the GIL is released meanwhile.

    The control and the applied forces stay what they are at the call. Steps that miss the tolerance are announced by a
    ``ToleranceWarning``, shapes far inside each other where a run begins by an ``OverlapWarning``.

    Raises:
        SolveError: a step's contact problem has no solution; the state is the one before that step.
        StateError: qpos, qvel, act, ctrl or qfrc_applied is not finite, or a quaternion is not of unit length.
    """

def placements(
    model: Model,
    qpos: ArrayLike,
    data: Optional[Data] = None,
    *,
    what: Optional[str] = None,
    direction: Optional[ArrayLike] = None,
    body: Optional[str] = None,
    hold: bool = False,
    attraction: Optional[Union[float, Dict[Tuple[str, str], float]]] = None,
    touching: float = 1e-6,
    tolerance: float = 1e-9,
    enumeration: int = 0,
    search: bool = True,
    progress: Optional[Callable[[int], object]] = None,
) -> Placements:
    """Judges many configurations of a model at rest on all cores, each as :func:`stability` does.

    Args:
        qpos: (n, nq), a configuration each.
        data: input and settings.
        what, direction, body: the margin that is wanted of those that need not move, as in :func:`safety`.
        hold, attraction, touching, tolerance, enumeration: as in :func:`stability`.
        search: whether moving solutions are searched for where forces balance the loads and nothing is proved; without, such placements
            stand, and are judged several times as fast.
        progress: called with the number of configurations judged so far, from any thread.

    Raises:
        SettingError, StateError: as in :func:`stability`, of the first such configuration.
    """

def safety(
    model: Model,
    data: Optional[Data] = None,
    *,
    what: str,
    direction: Optional[Union[ArrayLike, str]] = None,
    load: Optional[ArrayLike] = None,
    body: Optional[str] = None,
    hold: bool = False,
    attraction: Optional[Union[float, Dict[Tuple[str, str], float]]] = None,
    circular: bool = False,
    motion: bool = False,
    touching: float = 1e-6,
    tolerance: float = 1e-9,
) -> Safety:
    """Says how far a model at rest is from collapse, with a proof on either side of the limit.

    A limit of statics: up to it forces exist that balance the loads, and beyond it none do. As friction is not associated, motion may
    begin earlier.

    Args:
        what: "tilt", the angle in rad by which gravity is turned towards ``direction``; "horizontal", a share of gravity in
            ``direction`` beside gravity itself; "friction", the multiplier of all coefficients of friction of contacts, which is
            lowered; "push", a force in N at the centre of mass of ``body`` in ``direction``; "load", the multiplier of the generalized force ``load``, (nv,), beside the loads; "weight", a weight in kg at the
            centre of mass of ``body``; "motors", the multiplier of the force ranges of motors that ``hold``, which is lowered.
        direction: in world, of any length; "worst" asks all directions across gravity (tilt, horizontal, push).
        hold, attraction: as in :func:`stability`.
        circular: also the limit under circular cones of friction, between polygons inside and outside them.
        motion: also where the first step from rest begins to move.
        touching: as in :func:`stability`.

    Raises:
        SettingError: an argument is missing or out of its range.
        ProblemError, StateError: as in :func:`stability`.
    """

def stability(
    model: Model,
    data: Optional[Data] = None,
    *,
    hold: bool = False,
    attraction: Optional[Union[float, Dict[Tuple[str, str], float]]] = None,
    touching: float = 1e-6,
    tolerance: float = 1e-9,
    enumeration: int = 1000,
) -> Stability:
    """Says whether a model at rest stands under its loads, with a proof.

    The verdict is "must_move" (no contact forces within the friction cones balance the loads), "stays" (forces balance the loads, and
    it is proved that nothing can begin to move), "may_do_either" (a moving solution exists as well) or "stands" (a search for one
    found none, and nothing more is proved). Coulomb friction is not associated: forces that balance the loads are alone no proof that
    nothing moves.

    Args:
        data: the configuration and its input; the velocity is taken as zero. ``None`` takes the model's reference configuration.
        hold: every actuator holds still with whatever force within its range that takes; controls do not count.
        attraction: tension in N that contacts bear, by a force that pulls the bodies together as long as they touch: of every contact
            point, or of pairs of bodies ``{("left", "right"): 5.0}``, spread over their contact points. Friction grows by it.
        touching: gap up to which shapes and limits touch, m or rad.
        tolerance: a proof holds when its residuals are at most this.
        enumeration: linear programs of the complete enumeration of modes at most; 0 for no enumeration.

    Raises:
        ProblemError: neither a balance nor a mechanism was found to the accuracy asked for, or the contact problem is malformed.
        SettingError: an argument is out of its range.
        StateError: as in :func:`step`.
    """

def settle(
    model: Model, data: Data, *, max_steps: int = 2000, timestep: Optional[float] = None, momentum: float = 0.5
) -> SettleReport:
    """Brings the state to rest: to a configuration, near the present one, from which steps end with velocity zero.

    The way there is no simulation: bodies fall, slide and tumble, by steps in which contacts give way a little and velocity is taken
    away. The end is exact: ``qvel`` is zero (where springs or servos hold a load it may be rounding), and an ordinary step, certified
    within the tolerance of the settings, ends where it began.
    A state that rests stays where it is; piles of hundreds of bodies may settle by tenths of a millimetre once more. Time,
    activations and input stay; ``data.steps`` counts none of these steps, and a recorder does not see them. ``contact``,
    ``certificate``, ``problem()`` and ``solution()`` are then those of the step from the state of rest, which has not been made,
    and the next step starts warm from it. The GIL is released meanwhile; Ctrl-C ends it in the state reached.

    Args:
        max_steps: steps at most.
        timestep: Δt of these steps, s; ``None`` takes four times that of the simulation. What falls freely falls by g Δt² in a step;
            that should be some percent of a body's size.
        momentum: part of its velocity that a step takes over from the one before, in [0, 1). With 0 bodies fall and slide as through
            honey, with 0.9 and more they bounce and swing for long.

    Raises:
        SolveError: the steps are used up, with status "not_settled": something slides, rolls or falls for ever, or settles slowly. The
            state is the one reached, with the velocity it has there.
        SettingError: an argument is out of its range.
        ProblemError: the settings have the circular cone, the model has friction that is no contact's sliding (joints, servos,
            spinning, rolling), or the start violates equality constraints.
        StateError: as in :func:`step`.
    """

def forward(model: Model, data: Data) -> None:
    """Solves the step from the present state without making it.

    Updates xpos and its kind, ``qacc``, ``contact``, ``certificate``, ``problem()`` and ``solution()``; time, qpos, qvel and the
    warm start stay what they are. Errors as :func:`step`.
    """

def kinematics(model: Model, data: Data) -> None:
    """Updates poses and velocities of the bodies after qpos or qvel was written to."""

def inverse(model: Model, data: Data, qacc: Optional[ArrayLike] = None) -> _Array:
    """Inverse dynamics (recursive Newton–Euler): τ = M qacc + h at the present qpos and qvel, (nv,), N, N·m.

    Gravity, Coriolis, centrifugal and gyroscopic forces and armature are in it; contacts, joint springs, damping, limits and
    friction are not. ``qacc``, (nv,); without it ``data.qacc``. Steps take Coriolis forces at both of their ends: of a step's qacc this is the
    force that acted but for a part of the order of Δt, where trees and free bodies turn.
    """

def bias_force(model: Model, data: Data) -> _Array:
    """Coriolis, centrifugal, gyroscopic and gravity forces h of M v̇ + h = τ at the present qpos and qvel, (nv,), N, N·m."""

def mass_matrix(model: Model, data: Data) -> _Array:
    """The mass matrix M at the present qpos, (nv, nv), kg, kg·m, kg·m²."""

_Key = Union[str, int]

def jacobian(
    model: Model, data: Data, body: Optional[_Key] = None, point: Optional[ArrayLike] = None, *, geom: Optional[_Key] = None, site: Optional[_Key] = None
) -> Tuple[_Array, _Array]:
    """Jacobians of a point of a body, or of the origin of a geom or site (name or index), at the present qpos.

    Of its velocity, (3, nv), and of the angular velocity, (3, nv), world axes. ``point`` is in world, (3,), m; without it, the frame's origin.
    """

def jacobian_rate(
    model: Model, data: Data, body: Optional[_Key] = None, point: Optional[ArrayLike] = None, *, geom: Optional[_Key] = None, site: Optional[_Key] = None
) -> Tuple[_Array, _Array]:
    """Rates of the Jacobians of :func:`jacobian` along the motion at the present qpos and qvel."""

def frame_pose(
    model: Model, data: Data, *, body: Optional[_Key] = None, geom: Optional[_Key] = None, site: Optional[_Key] = None
) -> Tuple[_Array, _Array]:
    """Position in world, (3,), m, and rotation matrix, (3, 3), of a body, geom or site at the present qpos."""

def center_of_mass(model: Model, data: Data, body: Optional[_Key] = None) -> _Array:
    """Centre of mass of a body with all that hangs on it, (3,), m; without a body, of everything."""

def center_of_mass_jacobian(model: Model, data: Data, body: Optional[_Key] = None) -> Tuple[_Array, _Array]:
    """Jacobian of :func:`center_of_mass`, (3, nv), and its rate along the motion, (3, nv), world axes."""

def operational_space_inertia(
    model: Model, data: Data, jacobian: Union[_MatrixLike, _Key, None] = None, *, body: Optional[_Key] = None, geom: Optional[_Key] = None,
    site: Optional[_Key] = None, point: Optional[ArrayLike] = None
) -> _Array:
    """Operational-space inertia (J M⁻¹ Jᵀ)⁻¹ at the present qpos: of the rows of a Jacobian, (k, nv), as (k, k), or of a body, geom or site
    (name or index; of a body at a ``point`` in world) as (6, 6), linear before angular, world axes. A body may stand in the Jacobian's place.

    Raises:
        SolveError: the rows depend on each other.
    """

def inverse_kinematics(
    model: Model,
    data: Data,
    pos: Optional[ArrayLike] = None,
    quat: Optional[ArrayLike] = None,
    *,
    body: Optional[_Key] = None,
    geom: Optional[_Key] = None,
    site: Optional[_Key] = None,
    joints: Optional[Sequence[_Key]] = None,
    tolerance: float = 1e-9,
    max_iterations: int = 200,
) -> InverseKinematics:
    """A configuration at which a body, geom or site is at ``pos``, turned as ``quat`` (w, x, y, z, or a matrix, (3, 3)) says: damped least squares from the present
    qpos on, within the joints' limits. ``data`` stays what it is.

    ``joints``: those that may move, all without it. Where the answer has not converged it is the nearest configuration that was found; another
    start may lead to a better one.
    """

def distance(model: Model, data: Data, geom1: _Key, geom2: _Key) -> Optional[Nearest]:
    """The distance of two geoms (names or indices) at the present qpos, with the nearest points; nothing for two planes."""

def contacts_at(model: Model, data: Data, qpos: Optional[ArrayLike] = None, *, within: float = 0.0) -> list[ContactPoint]:
    """The contact points of a configuration (the present one without ``qpos``), without a step: those with a gap of at most ``within``, m."""

def overlaps(model: Model, data: Data) -> list[tuple[int, int, float]]:
    """Pairs of geoms that may touch and overlap at the present qpos, with the deepest overlap of each, m."""

def cast_ray(
    model: Model, data: Data, point: ArrayLike, direction: ArrayLike, *, exclude_body: Optional[_Key] = None
) -> Optional[RayHit]:
    """What a ray from ``point`` along ``direction`` (of any length) meets first; nothing if it meets nothing.

    From inside a shape its surface is met from inside; planes are met from their front alone; of a convex mesh the hull is met. The geoms of
    ``exclude_body`` are passed over.
    """

def cast_rays(
    model: Model, data: Data, points: ArrayLike, directions: ArrayLike, *, exclude_body: Optional[_Key] = None, nthread: int = 0
) -> Tuple[_Array, _Ints, _Array]:
    """Many rays at once, on threads (0: as many as the machine runs): distances, (n,), infinite where nothing is met; geoms, (n,), −1
    there; normals, (n, 3).

    ``points``, (n, 3) or one for all, (3,); ``directions``, (n, 3). Otherwise as :func:`cast_ray`.
    """

def support_polygon(model: Model, data: Data, body: Optional[_Key] = None) -> _Array:
    """Corners of the convex hull, seen along gravity, of the points at which the last step's contacts carry a body with all that hangs on it
    (everything without one), (k, 3), m."""

def zero_moment_point(model: Model, data: Data, body: Optional[_Key] = None, *, height: float = 0.0) -> Optional[_Array]:
    """The zero-moment point of the last step's contact forces on a body with all that hangs on it, on the plane at ``height`` (m) across
    gravity, (3,), m; nothing where no force presses on it."""

def integrate(model: Model, qpos: ArrayLike, qvel: ArrayLike, dt: float = 1.0) -> _Array:
    """qpos ⊕ dt qvel, (nq,): a configuration moved along a velocity; quaternions stay unit."""

def difference(model: Model, qpos1: ArrayLike, qpos0: ArrayLike) -> _Array:
    """The velocity that leads from ``qpos0`` to ``qpos1`` in unit time, (nv,); rotations go the short way."""

def critical_bodies(
    model: Model,
    data: Optional[Data] = None,
    *,
    attraction: Optional[Union[float, Dict[Tuple[str, str], float]]] = None,
    touching: float = 1e-6,
    tolerance: float = 1e-9,
) -> Dict[str, Tuple[float, NDArray[np.float64]]]:
    """What every free body bears: those that bear least are what collapse begins with.

    Returns:
        By the name of the body the least horizontal force at its centre of mass, over all directions, that is at the limit of what
        can be balanced, N, and its direction in world, (3,). Not a number where the loads are not balanced as they are.

    Raises:
        SettingError, ProblemError, StateError: as in :func:`safety`.
    """

def derivatives(
    model: Model, data: Data, parameters: Optional[Sequence[Any]] = None, *, twice: bool = False
) -> StepDerivatives:
    """The derivative of the step just made (``step``, ``forward``): of (q⁺, v⁺) by (q, v), ctrl and qfrc_applied.

    Args:
        parameters: numbers of the model that get columns, too (``StepDerivatives.P``). Each is "timestep" or a tuple of a name, a part and
            an index: ("gravity", axis); ("body_mass", body); ("body_ipos", body, axis); ("body_inertia", body, (row, column)) about
            the centre of mass in the body's axes; ("dof_damping", joint), ("jnt_stiffness", joint), ("qpos_spring", joint),
            ("dof_armature", joint), ("dof_frictionloss", joint); ("geom_friction", geom, 0), 1 and 2 against spinning and rolling;
            ("geom_restitution", geom), ("geom_margin", geom), ("geom_pos", geom, axis) in the body's axes, ("geom_size", geom, index);
            ("pair_friction", index). A list of parts in place of one, a list of tuples, or a dictionary of them with their shares, are
            numbers that change together.
        twice: solves the step's problem again, without the start that it had from the step before, and refuses where that ends at
            another velocity: friction admits several solutions now and then, each with its own derivative. It costs another solution.

    Raises:
        RuntimeError: there is no step yet.
        ValueError: a parameter is no number of the model.
    """

def parameter_values(model: Model, parameters: Sequence[Any]) -> _Array:
    """The values of parameters as for ``derivatives``, each that of its first number, (n,)."""

def with_images(model: Model, images: Any) -> Model:
    """The model with images that ``Model._images`` gave, and no others."""

def with_parameters(model: Model, parameters: Sequence[Any], values: ArrayLike) -> Model:
    """``signorini.with_parameters`` without what Python adds to a model."""

@final
class IdentifiedValues:
    """What ``identify_parameters`` found; see ``signorini.Identification``."""

    @property
    def values(self) -> _Array: ...
    @property
    def covariance(self) -> _Array: ...
    @property
    def determined(self) -> list[bool]: ...
    @property
    def at_bound(self) -> list[bool]: ...
    @property
    def objective(self) -> tuple[float, float]: ...
    @property
    def deviation(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def converged(self) -> bool: ...
    @property
    def steps(self) -> tuple[int, int]: ...

def identify_parameters(
    model: Model,
    recordings: Sequence[tuple[Any, Any, Any, Any]],
    unknowns: Sequence[tuple[str, Any, list[float], Optional[list[float]]]],
    settings: _PublicSettings,
    interval: float,
    substeps: int,
    window: int,
    weights: Sequence[float],
    outlier: float,
    equal_recordings: bool,
    starts: int,
    draws: int,
    iterations: int,
    tolerance: float,
    progress: Optional[Callable[[int, float, _Array], Any]],
) -> IdentifiedValues:
    """``signorini.identify`` with all arguments."""

def linearize(model: Model, data: Data, *, within: Optional[float] = None) -> LinearComplementaritySystem:
    """The linear complementarity system of a step from the present qpos, qvel, ctrl and qfrc_applied. Bilateral rows are eliminated.

    Args:
        within: all points and limits at most so far from touching, m or rad, in place of those that the step could close: a plan over
            several steps needs the contacts that are met later.

    Raises:
        StateError: as :func:`step`.
        SettingError: ``within`` is negative or not finite.
    """

def parameter_table() -> list[tuple[str, str, list[int], bool]]:
    """Names of all parameters with the sort of part that has them, the shape of a part's numbers, and whether a change prepares the search for contacts anew."""

def lcp_methods() -> list[str]:
    """Names of the methods that ``solve_lcp`` knows."""

def solve_lcp(
    A: _MatrixLike,
    b: ArrayLike,
    method: str = "automatic",
    *,
    free: Optional[Sequence[bool]] = None,
    warm_start: Optional[Sequence[bool]] = None,
    explain: bool = True,
) -> LcpResult:
    """Finds z with 0 ≤ z ⟂ w = A z + b ≥ 0; the GIL is released meanwhile.

    Args:
        A: (n, n), dense or sparse.
        b: (n,).
        method: a name of ``lcp_methods()``.
        free: (n,); where it is true, w = 0 and z has any sign (a mixed problem).
        warm_start: (n,), the ``basis`` of a similar problem's result.
        explain: whether to look through the problem's cases where the method ends without a solution: for one, or for the proof that there
            is none (``farkas``, ``exclusion``). It takes some seconds at most.

    Raises:
        ProblemError: a shape does not fit or a number is not finite.
        SettingError: no method has this name.
    """
