"""Recordings as those of Rerun (``pip install 'signorini[rerun]'``)."""

from __future__ import annotations

import importlib
import json
import os
from typing import Any, Dict, Union

import numpy as np

from signorini._core import Recording

__all__ = ["write"]

LONGEST_ARROW = 0.3
"""Length of the arrow of the largest contact force of a recording, m."""


def write(recording: Recording, path: Union[str, "os.PathLike[str]"]) -> None:
    """Writes a recording to a ``.rrd`` file: bodies that move with their shapes, contact points with forces, residuals and
    energies as curves, on the timeline ``sim_time``.

    Raises:
        ImportError: the package ``rerun-sdk`` is not installed.
    """
    try:
        rr: Any = importlib.import_module("rerun")
    except ImportError as error:
        raise ImportError("recordings of Rerun need the package rerun-sdk: pip install 'signorini[rerun]'") from error

    stream = rr.RecordingStream("signorini", recording_id=f"{recording.model_name}-{recording.model_hash:016x}")
    stream.save(os.fspath(path))
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    times = [rr.TimeColumn("sim_time", duration=recording.time)]
    names = recording.body_names
    for geom, shape in enumerate(json.loads(recording._geoms())):
        _log_shape(rr, stream, f"{_entity(rr, names[shape['body']])}/geom{geom}", shape)
    xpos, xquat = recording.xpos, recording.xquat
    for body in range(1, len(names)):
        turned = np.roll(xquat[:, body], -1, axis=1)  # (x, y, z, w) there
        columns = rr.Transform3D.columns(translation=xpos[:, body], quaternion=turned)
        stream.send_columns(_entity(rr, names[body]), indexes=times, columns=columns)
    _log_contacts(rr, stream, times, recording)
    residuals = recording.residuals
    for k, law in enumerate(("momentum", "natural_map", "signorini", "friction", "dissipation")):
        stream.send_columns(f"certificate/{law}", indexes=times, columns=rr.Scalars.columns(scalars=residuals[:, k]))
    for k, kind in enumerate(("kinetic", "potential")):
        stream.send_columns(f"energy/{kind}", indexes=times, columns=rr.Scalars.columns(scalars=recording.energy[:, k]))
    stream.flush()
    stream.disconnect()


def _entity(rr: Any, body: str) -> str:
    path: str = rr.new_entity_path(["world", "bodies", body])
    return path


def _log_contacts(rr: Any, stream: Any, times: Any, recording: Recording) -> None:
    frames = [recording.contact(i) for i in range(len(recording))]
    forces = [frame.force_world for frame in frames]
    largest = max((float(np.linalg.norm(f, axis=1).max()) for f in forces if len(f)), default=0.0)
    scale = LONGEST_ARROW / largest if largest > 0 else 0.0
    origins, vectors = np.vstack([frame.point for frame in frames]), scale * np.vstack(forces)
    columns = rr.Arrows3D.columns(origins=origins, vectors=vectors).partition([len(frame) for frame in frames])
    stream.send_columns("world/contacts", indexes=times, columns=columns)


def _log_shape(rr: Any, stream: Any, entity: str, geom: Dict[str, Any]) -> None:
    shape, (x, y, z, qw, qx, qy, qz) = geom["shape"], geom["pose"]
    color = None if geom["rgba"] is None else [geom["rgba"]]
    stream.log(entity, rr.Transform3D(translation=[x, y, z], quaternion=rr.Quaternion(xyzw=[qx, qy, qz, qw])), static=True)
    kind = shape["type"]
    if kind == "plane":
        drawn = rr.Boxes3D(centers=[[0, 0, -0.005]], half_sizes=[[10, 10, 0.005]], colors=color, fill_mode="solid")
    elif kind == "sphere":
        drawn = rr.Ellipsoids3D(half_sizes=[3 * [shape["radius"]]], colors=color, fill_mode="solid")
    elif kind == "ellipsoid":
        drawn = rr.Ellipsoids3D(half_sizes=[shape["radii"]], colors=color, fill_mode="solid")
    elif kind == "box":
        drawn = rr.Boxes3D(half_sizes=[shape["half_extents"]], colors=color, fill_mode="solid")
    elif kind == "capsule":
        half = shape["half_length"]
        drawn = rr.Capsules3D(lengths=[2 * half], radii=[shape["radius"]], translations=[[0, 0, -half]], colors=color)
    elif kind == "cylinder":
        drawn = rr.Cylinders3D(lengths=[2 * shape["half_length"]], radii=[shape["radius"]], colors=color, fill_mode="solid")
    else:
        points, faces = _triangles(shape)
        vertex_colors = None if geom["rgba"] is None else [geom["rgba"]] * len(points)
        drawn = rr.Mesh3D(vertex_positions=points, triangle_indices=faces, vertex_colors=vertex_colors)
    stream.log(entity, drawn, static=True)


def _triangles(shape: Dict[str, Any]) -> Any:
    """Vertices and triangles of a mesh, a height field or a cone."""
    if shape["type"] == "mesh":
        return np.array(shape["vertices"], float), np.array(shape["faces"], np.uint32)
    if shape["type"] == "height_field":
        rows, cols, (hx, hy) = shape["rows"], shape["cols"], shape["half_extents"]
        x, y = np.meshgrid(np.linspace(-hx, hx, cols), np.linspace(-hy, hy, rows))
        points = np.column_stack([x.ravel(), y.ravel(), np.array(shape["heights"], float)])
        i = (np.arange(rows - 1)[:, None] * cols + np.arange(cols - 1)).ravel()
        quads = [np.column_stack([i, i + 1, i + cols + 1]), np.column_stack([i, i + cols + 1, i + cols])]
        return points, np.vstack(quads).astype(np.uint32)
    count, radius, half = 24, shape["radius"], shape["half_height"]
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, -half)])
    points = np.vstack([rim, [[0, 0, half], [0, 0, -half]]])
    i, j = np.arange(count), (np.arange(count) + 1) % count
    sides, base = np.column_stack([i, j, np.full(count, count)]), np.column_stack([j, i, np.full(count, count + 1)])
    return points, np.vstack([sides, base]).astype(np.uint32)
