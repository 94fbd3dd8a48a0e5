"""Running simulations in the viewers of `Rerun <https://rerun.io>`_ and `Foxglove <https://foxglove.dev>`_.

>>> import signorini
>>> from signorini.streams import RerunStream
>>> model = signorini.Model.from_string("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
>>> data = signorini.Data(model)
>>> with RerunStream(model, port=0) as stream:  # doctest: +SKIP
...     print(stream.url)                       # rerun rerun+http://…
...     for _ in range(1000):
...         signorini.step(model, data)
...         stream.log(data)

Both show bodies with their shapes, contact points with forces, energies and residuals over simulated time. They need the makers' own packages:
``pip install 'signorini[rerun]'`` and ``pip install 'signorini[foxglove]'``.
"""

from __future__ import annotations

import importlib
import json
import socket
from types import TracebackType
from typing import Any, Dict, List, Optional, Type

import numpy as np

from signorini import Data, Model, _rerun

__all__ = ["FoxgloveStream", "RerunStream"]

ARROW_LENGTH = 0.1
"""Length of the arrow of a contact force of the weight of all bodies, m."""


class RerunStream:
    """A running simulation for Rerun's viewer, by gRPC.

    Args:
        model: the model.
        port: serve on this port, 0 for one that is free; viewers come and go: ``rerun URL``.
        connect: instead send to a viewer or proxy at this address ("rerun+http://127.0.0.1:9876/proxy").

    Raises:
        ImportError: the package ``rerun-sdk`` is not installed.
        ValueError: both or none of ``port`` and ``connect`` are given.
    """

    url: str
    """Where viewers find it."""

    def __init__(self, model: Model, *, port: Optional[int] = None, connect: Optional[str] = None) -> None:
        self._rr = _package("rerun", "rerun-sdk", "rerun")
        if (port is None) == (connect is None):
            raise ValueError("give either port (to serve) or connect (the address of a viewer)")
        self._stream: Any = self._rr.RecordingStream("signorini")
        if connect is None:
            self.url = str(self._stream.serve_grpc(grpc_port=port or _free_port()))
        else:
            self._stream.connect_grpc(connect)
            self.url = connect
        self._names, self._scale = model.body_names, _arrow_scale(model)
        self._stream.log("world", self._rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for k, shape in enumerate(_geoms(model)):
            entity = f"{_rerun._entity(self._rr, self._names[shape['body']])}/geom{k}"
            _rerun._log_shape(self._rr, self._stream, entity, shape)

    def log(self, data: Data) -> None:
        """Shows the state as it is, and the contacts of the last step."""
        rr, stream = self._rr, self._stream
        stream.set_time("sim_time", duration=data.time)
        for body in range(1, len(self._names)):
            w, x, y, z = data.xquat[body]
            placed = rr.Transform3D(translation=data.xpos[body], quaternion=rr.Quaternion(xyzw=[x, y, z, w]))
            stream.log(_rerun._entity(rr, self._names[body]), placed)
        contact = data.contact
        stream.log("world/contacts", rr.Arrows3D(origins=contact.point, vectors=self._scale * contact.force_world))
        for kind, value in _numbers(data).items():
            stream.log(kind, rr.Scalars(value))

    def close(self) -> None:
        """Sends what is left and ends the stream; a viewer keeps what it has."""
        self._stream.flush()
        self._stream.disconnect()

    def __enter__(self) -> RerunStream:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()


class FoxgloveStream:
    """A running simulation for Foxglove, by its WebSocket protocol: topics ``/tf``, ``/scene``, ``/contact_forces`` and ``/numbers``.

    Args:
        model: the model.
        port: serve on this port; 0 for one that is free.
        host: address to listen at; "0.0.0.0" lets other machines look.

    Raises:
        ImportError: the package ``foxglove-sdk`` is not installed.
    """

    url: str
    """Where Foxglove finds it ("Open connection")."""

    def __init__(self, model: Model, *, port: int = 8765, host: str = "127.0.0.1") -> None:
        self._foxglove = _package("foxglove", "foxglove-sdk", "foxglove")
        channels, self._messages = (importlib.import_module(f"foxglove.{name}") for name in ("channels", "messages"))
        self._names, self._scale = model.body_names, _arrow_scale(model)
        # The channels end with it.
        self._context = context = self._foxglove.Context()
        self._tf = channels.FrameTransformsChannel("/tf", context=context)
        self._scene = channels.SceneUpdateChannel("/scene", context=context)
        self._forces = channels.SceneUpdateChannel("/contact_forces", context=context)
        self._numbers = self._foxglove.Channel("/numbers", message_encoding="json", context=context)
        self._time = 0.0
        self._shapes = self._messages.SceneUpdate(entities=self._entities(_geoms(model)))

        def on_subscribe(listener: Any, client: Any, channel: Any) -> None:
            if channel.topic == "/scene":
                self._scene.log(self._shapes, log_time=_nanoseconds(self._time))

        # Foxglove's package may not be there, so that no class can be written down.
        listener = type("Listener", (self._foxglove.ServerListener,), {"on_subscribe": on_subscribe})()
        self._server = self._foxglove.start_server(
            name=f"signorini: {model.name}", host=host, port=port, context=context, server_listener=listener
        )
        self.url = f"ws://{host}:{self._server.port}"

    def log(self, data: Data) -> None:
        """Shows the state as it is, and the contacts of the last step."""
        messages, self._time = self._messages, data.time
        stamp, at = _stamp(messages, data.time), _nanoseconds(data.time)
        frames = [
            messages.FrameTransform(
                timestamp=stamp,
                parent_frame_id=self._names[0],
                child_frame_id=self._names[body],
                translation=_vector(messages, data.xpos[body]),
                rotation=_quaternion(messages, data.xquat[body]),
            )
            for body in range(1, len(self._names))
        ]
        self._tf.log(messages.FrameTransforms(transforms=frames), log_time=at)
        self._forces.log(messages.SceneUpdate(entities=[self._arrows(data, stamp)]), log_time=at)
        self._numbers.log(_numbers(data), log_time=at)

    def close(self) -> None:
        """Ends the server."""
        self._server.stop()

    def __enter__(self) -> FoxgloveStream:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def _arrows(self, data: Data, stamp: Any) -> Any:
        """Contact forces: arrows along x, turned."""
        messages, contact = self._messages, data.contact
        arrows = []
        for point, force in zip(contact.point, self._scale * contact.force_world):
            length = float(np.linalg.norm(force))
            if length == 0.0:
                continue
            pose = messages.Pose(position=_vector(messages, point), orientation=_quaternion(messages, _x_to(force / length)))
            thick = 0.02 * ARROW_LENGTH
            arrows.append(
                messages.ArrowPrimitive(
                    pose=pose,
                    shaft_length=0.8 * length,
                    shaft_diameter=2 * thick,
                    head_length=0.2 * length,
                    head_diameter=4 * thick,
                    color=messages.Color(r=0.9, g=0.2, b=0.1, a=1.0),
                )
            )
        return messages.SceneEntity(timestamp=stamp, frame_id=self._names[0], id="contact forces", arrows=arrows)

    def _entities(self, geoms: List[Dict[str, Any]]) -> List[Any]:
        messages, entities = self._messages, []
        for k, geom in enumerate(geoms):
            primitives: Dict[str, List[Any]] = {"cubes": [], "spheres": [], "cylinders": [], "triangles": []}
            _add_shape(messages, primitives, geom)
            frame = self._names[geom["body"]]
            entities.append(messages.SceneEntity(frame_id=frame, frame_locked=True, id=f"geom{k}", **primitives))
        return entities


def _package(module: str, package: str, extra: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"this stream needs the package {package}: pip install 'signorini[{extra}]'") from error


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _geoms(model: Model) -> List[Dict[str, Any]]:
    """The shapes as recordings have them."""
    with Data(model).record() as recorder:
        pass
    geoms: List[Dict[str, Any]] = json.loads(recorder.recording._geoms())
    return geoms


def _arrow_scale(model: Model) -> float:
    """Metres per newton."""
    weight = float(np.sum(model.body_mass) * np.linalg.norm(model.gravity))
    return ARROW_LENGTH / weight if weight > 0 else ARROW_LENGTH


def _numbers(data: Data) -> Dict[str, float]:
    kinetic, potential = (float(x) for x in data.energy)
    return {"energy/kinetic": kinetic, "energy/potential": potential, "certificate/worst": data.certificate.worst}


def _nanoseconds(time: float) -> int:
    return round(time * 1e9)


def _stamp(messages: Any, time: float) -> Any:
    seconds, rest = divmod(_nanoseconds(time), 10**9)
    return messages.Timestamp(seconds, rest)


def _vector(messages: Any, x: Any) -> Any:
    return messages.Vector3(x=float(x[0]), y=float(x[1]), z=float(x[2]))


def _quaternion(messages: Any, wxyz: Any) -> Any:
    w, x, y, z = (float(value) for value in wxyz)
    return messages.Quaternion(x=x, y=y, z=z, w=w)


def _x_to(direction: Any) -> Any:
    """The quaternion (w, x, y, z) of the shortest turn of the x axis to a unit vector."""
    w = 1.0 + direction[0]
    if w < 1e-9:
        return np.array([0.0, 0.0, 0.0, 1.0])
    quaternion = np.array([w, 0.0, -direction[2], direction[1]])
    return quaternion / np.linalg.norm(quaternion)


def _add_shape(messages: Any, primitives: Dict[str, List[Any]], geom: Dict[str, Any]) -> None:
    shape, (x, y, z, w, i, j, k) = geom["shape"], geom["pose"]
    red, green, blue, alpha = geom["rgba"] or (0.7, 0.7, 0.7, 1.0)
    color = messages.Color(r=red, g=green, b=blue, a=alpha)

    def pose(along: float = 0.0) -> Any:
        """The geom's, moved along its z axis."""
        up = np.array([2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j)])
        place = np.array([x, y, z]) + along * up
        return messages.Pose(position=_vector(messages, place), orientation=_quaternion(messages, (w, i, j, k)))

    def sized(kind: str, size: Any, at: Any, **more: float) -> None:
        make = {"cubes": messages.CubePrimitive, "spheres": messages.SpherePrimitive, "cylinders": messages.CylinderPrimitive}[kind]
        primitives[kind].append(make(pose=at, size=_vector(messages, size), color=color, **more))

    kind = shape["type"]
    if kind == "plane":
        sized("cubes", (20, 20, 0.01), pose(-0.005))
    elif kind == "sphere":
        sized("spheres", 3 * [2 * shape["radius"]], pose())
    elif kind == "ellipsoid":
        sized("spheres", [2 * radius for radius in shape["radii"]], pose())
    elif kind == "box":
        sized("cubes", [2 * half for half in shape["half_extents"]], pose())
    elif kind in ("cylinder", "capsule"):
        width, half = 2 * shape["radius"], shape["half_length"]
        sized("cylinders", (width, width, 2 * half), pose(), bottom_scale=1.0, top_scale=1.0)
        for end in (-half, half) if kind == "capsule" else ():
            sized("spheres", 3 * [width], pose(end))
    else:
        points, faces = _rerun._triangles(shape)
        corners = [messages.Point3(x=float(p[0]), y=float(p[1]), z=float(p[2])) for p in points]
        indices = [int(index) for index in np.ravel(faces)]
        primitives["triangles"].append(
            messages.TriangleListPrimitive(pose=pose(), points=corners, indices=indices, color=color)
        )
