"""States and what moves them."""

from __future__ import annotations

import os
from types import TracebackType
from typing import Any, Dict, List, Optional, Sequence, Tuple, Type, Union

import numpy as np
from numpy.typing import NDArray

from signorini import _core
from signorini._core import Recording
from signorini._names import Key, Strict, index_of
from signorini._parameters import changes, check_name
from signorini.model import Model, table
from signorini.settings import Settings

__all__ = ["ActuatorData", "BodyData", "Data", "JointData", "Recorder"]

Array = NDArray[np.float64]


class Data(Strict, _core.Data):
    """The state of a model, and everything that a step needs.

    ``qpos``, ``qvel``, ``act``, ``ctrl``, ``qfrc_applied`` and ``xfrc_applied`` are live NumPy views: what is written to them is the state and the
    input of the next step. ``xpos``, ``xquat``, ``xmat``, ``xipos``, ``linear_velocity``, ``angular_velocity`` and ``qacc``
    are live results, read-only: every step updates them in place, and they belong to the state at its end. After writing to ``qpos``
    call :func:`signorini.forward` or :func:`signorini.kinematics` to update them. Views stay valid as long as they are kept.

    ``contact``, ``limit``, ``sensordata``, ``certificate``, ``report``, :meth:`problem` and :meth:`solution` are snapshots of the last
    step; the contacts are those at its beginning.

    One thread at a time may use a data.

    Args:
        model: the model.
        settings: see :class:`Settings`.

    Raises:
        SettingError: a setting is out of its range.
        ModelError: a shape cannot be prepared for collision.
    """

    def __new__(cls, model: Model, settings: Settings = Settings()) -> Data:
        return super().__new__(cls, model, settings)

    def reset(self, keyframe: Optional[Key] = None) -> None:
        """Goes to the reference configuration at rest at time 0, or to a keyframe (name or index).

        Control is zero or the keyframe's, applied forces are zero, and the next step starts cold.
        """
        if keyframe is None:
            self._reset()
        else:
            self._reset(index_of("keyframe", self.model.keyframe_names, keyframe))

    def body(self, key: Key) -> BodyData:
        """The motion of the body of this name or index.

        Raises:
            KeyError: no body has this name; the message lists those that exist, the most similar first.
        """
        return BodyData(self, index_of("body", self.model.body_names, key))

    def joint(self, key: Key) -> JointData:
        """The coordinates of the joint of this name or index; errors as in :meth:`body`."""
        return JointData(self, index_of("joint", self.model.joint_names, key))

    def actuator(self, key: Key) -> ActuatorData:
        """The control of the actuator of this name or index; errors as in :meth:`body`."""
        return ActuatorData(self, index_of("actuator", self.model.actuator_names, key))

    def sensor(self, key: Key) -> Array:
        """The numbers of the sensor of this name or index, a copy; see ``sensordata``; errors as in :meth:`body`."""
        i = index_of("sensor", self.model.sensor_names, key)
        start = int(self.model.sensor_adr[i])
        return self.sensordata[start : start + int(self.model.sensor_dim[i])]

    def parameter(self, name: str) -> Array:
        """Values of a parameter of the model in this data, one row for each part, read-only; names are those of ``PARAMETERS``."""
        check_name(name)
        return self._parameter(name)

    def change(self, **values: Any) -> None:
        """Goes on with other numbers of the model, in this data alone: no file is read and nothing compiled.

        ``data.change(body_mass={"box": 2.0}, geom_friction=0.4, gravity=(0, 0, -1.62))``: a mapping changes the parts it names (by name or
        index), an array all of them, one number all of them alike (of friction that of sliding). ``PARAMETERS`` lists the names, which are
        MuJoCo's, with the shape of a part's numbers. State, input and warm start stay, and the next step is that of a model compiled with these
        numbers, bit for bit; what a loader made of the old ones (relative poses of welds, keyframes, inertia of shapes) stays too.

        It costs a copy of the model without its meshes, some microseconds and one or two per body; where ``prepares_search`` says so, also asking
        which geoms can meet. Steps cost what they cost before.

        Raises:
            ProblemError: there is no parameter of this name, or the numbers have another shape.
            ModelError: a part cannot have this number; nothing has changed then.
            RuntimeError: the data is being recorded.
        """
        self._change(changes(values, lambda name: self._parameter(name)[np.newaxis], self.model._parameter_parts))

    def record(self, path: Optional[Union[str, "os.PathLike[str]"]] = None) -> Recorder:
        """Records every step until the recorder is stopped; see :class:`Recorder`."""
        return Recorder(self, path)

    def __copy__(self) -> Data:
        return _rebuild(type(self), self.model, self.settings, self.get_state(), self._changed())

    def __deepcopy__(self, memo: Dict[int, Any]) -> Data:
        return self.__copy__()

    def __reduce__(self) -> Tuple[Any, ...]:
        return _rebuild, (type(self), self.model, self.settings, self.get_state(), self._changed())

    def _facts(self) -> List[Tuple[str, str]]:
        kinetic, potential = self.energy
        return [
            ("time", f"{self.time:g} s"),
            ("steps", f"{self.steps} of {self.timestep:g} s"),
            ("contacts", str(self.ncon)),
            ("last step", f"{self.report.status}, worst residual {self.certificate.worst:.1e}"),
            ("steps that missed the tolerance", str(self.missed_steps)),
            ("energy", f"kinetic {kinetic:.6g} J, potential {potential:.6g} J"),
        ]

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {value}" for name, value in self._facts())
        return f"<signorini.Data of '{self.model.name}': {facts}>"

    def _repr_html_(self) -> str:
        return table("signorini.Data", [("model", self.model.name), *self._facts()])


def _rebuild(
    cls: Type[Data], model: Model, settings: Settings, state: Array, changed: Sequence[Tuple[str, List[float]]] = ()
) -> Data:
    data = cls(model, settings)
    data._change(list(changed))
    data.set_state(state)
    return data


class BodyData(Strict):
    """The motion of one body: rows of the arrays of a :class:`Data`, live."""

    id: int = -1

    def __init__(self, data: Data, id: int) -> None:
        self._data = data
        self.id = id

    @property
    def name(self) -> str:
        """The body's name."""
        return self._data.model.body_names[self.id]

    @property
    def xpos(self) -> Array:
        """Position of the origin in world, (3,), m."""
        return _row(self._data.xpos, self.id)

    @property
    def xquat(self) -> Array:
        """Orientation, (4,), (w, x, y, z)."""
        return _row(self._data.xquat, self.id)

    @property
    def xmat(self) -> Array:
        """Rotation matrix, (3, 3), body to world."""
        return _row(self._data.xmat, self.id)

    @property
    def xipos(self) -> Array:
        """Centre of mass in world, (3,), m."""
        return _row(self._data.xipos, self.id)

    @property
    def linear_velocity(self) -> Array:
        """Velocity of the origin, (3,), world axes, m/s."""
        return _row(self._data.linear_velocity, self.id)

    @property
    def angular_velocity(self) -> Array:
        """Angular velocity, (3,), world axes, rad/s."""
        return _row(self._data.angular_velocity, self.id)

    @property
    def contact_force(self) -> Array:
        """Sum of the contact forces on the body in the last step, (3,), world axes, N: a copy."""
        contact = self._data.contact
        force, on, against = contact.force_world, contact.body2 == self.id, contact.body1 == self.id
        total: Array = force[on].sum(axis=0) - force[against].sum(axis=0)
        total.flags.writeable = False
        return total

    def __repr__(self) -> str:
        return f"<signorini.BodyData {self.id} '{self.name}' at {self.xpos}>"


class JointData(Strict):
    """The coordinates of one joint: slices of the arrays of a :class:`Data`, live and writable."""

    id: int = -1

    def __init__(self, data: Data, id: int) -> None:
        self._data = data
        self.id = id
        joint = data.model.joint(id)
        self._q = slice(joint.qposadr, joint.qposadr + joint.nq)
        self._v = slice(joint.dofadr, joint.dofadr + joint.nv)

    @property
    def name(self) -> str:
        """The joint's name."""
        return self._data.model.joint_names[self.id]

    @property
    def qpos(self) -> Array:
        """Its entries of ``qpos``: (1,), (4,) for a ball, (7,) for a free joint."""
        return self._data.qpos[self._q]

    @qpos.setter
    def qpos(self, value: Any) -> None:
        _assign(self._data.qpos, self._q, "qpos", value)

    @property
    def qvel(self) -> Array:
        """Its entries of ``qvel``: (1,), (3,) for a ball, (6,) for a free joint."""
        return self._data.qvel[self._v]

    @qvel.setter
    def qvel(self, value: Any) -> None:
        _assign(self._data.qvel, self._v, "qvel", value)

    @property
    def qfrc_applied(self) -> Array:
        """Its entries of ``qfrc_applied``, as ``qvel``."""
        return self._data.qfrc_applied[self._v]

    @qfrc_applied.setter
    def qfrc_applied(self, value: Any) -> None:
        _assign(self._data.qfrc_applied, self._v, "qfrc_applied", value)

    def __repr__(self) -> str:
        return f"<signorini.JointData {self.id} '{self.name}' at {self.qpos}>"


class ActuatorData(Strict):
    """The control of one actuator, live and writable."""

    id: int = -1

    def __init__(self, data: Data, id: int) -> None:
        self._data = data
        self.id = id

    @property
    def name(self) -> str:
        """The actuator's name."""
        return self._data.model.actuator_names[self.id]

    @property
    def ctrl(self) -> float:
        """Its control value: N or N·m (motor), m or rad (position servo), m/s or rad/s (velocity servo)."""
        return float(self._data.ctrl[self.id])

    @ctrl.setter
    def ctrl(self, value: float) -> None:
        _assign(self._data.ctrl, self.id, "ctrl", value)

    def __repr__(self) -> str:
        return f"<signorini.ActuatorData {self.id} '{self.name}' at {self.ctrl}>"


class Recorder:
    """Records every step of a data, from its making to :meth:`stop` or to the end of a ``with`` block.

    With a path, frames go to the file at once, so that a killed run leaves a readable recording; without one they are kept
    in memory.
    """

    def __init__(self, data: Data, path: Optional[Union[str, "os.PathLike[str]"]] = None) -> None:
        self._data = data
        self._path = None if path is None else os.fspath(path)
        self._recording: Optional[Recording] = None
        self._running = True
        data._start_recording(self._path)

    def stop(self, reason: str = "stopped") -> Recording:
        """Ends the recording with the present state and returns it; ``reason`` is kept in it."""
        if self._running:
            self._running = False
            self._recording = self._data._stop_recording(reason)
        return self.recording

    @property
    def recording(self) -> Recording:
        """What was recorded; available after :meth:`stop`."""
        if self._running:
            raise RuntimeError("the recording goes on: call stop() first")
        if self._recording is None:
            if self._path is None:
                raise RuntimeError("the recording could not be finished")
            self._recording = Recording.load(self._path)
        return self._recording

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.stop("finished" if error is None else f"{type(error).__name__}: {error}")


def _row(array: Array, i: int) -> Array:
    row: Array = array[i]
    return row


def _assign(array: Array, at: Union[int, slice], name: str, value: Any) -> None:
    if value is None:
        raise TypeError(f"{name}: None is no number")
    array[at] = value
