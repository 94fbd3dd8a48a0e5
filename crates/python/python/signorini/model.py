"""Models: immutable mechanisms read from MJCF, URDF or SDF."""

from __future__ import annotations

import html
import os
import pathlib
import warnings
from typing import Any, Dict, List, Literal, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from signorini import _core
from signorini._names import Key, Strict, index_of
from signorini._parameters import check_name
from signorini.errors import ModelError, ModelWarning

__all__ = ["Model"]

PathLike = Union[str, "os.PathLike[str]"]


class Model(Strict, _core.Model):
    """An immutable mechanism: bodies in a tree, joints, shapes, actuators, keyframes.

    Made by :meth:`from_file`, :meth:`from_mjcf`, :meth:`from_urdf`, :meth:`from_sdf` or :meth:`from_string`. What a file has
    that the model has not is listed in ``import_report``; what of it can change the motion is issued as a :class:`ModelWarning` at its
    line. Names and conventions are MuJoCo's (``nq``, ``nv``, ``nu``, ``nbody``, …; quaternions w, x, y, z); bodies and
    joints keep the order of the file, depth first; body 0 is the world. Its arrays are read-only.
    """

    _recipe: Dict[str, Any]

    @classmethod
    def from_file(
        cls,
        path: PathLike,
        *,
        package_dirs: Sequence[PathLike] = (),
        floating_base: bool = False,
        merge_fixed_joints: bool = False,
        self_collision: bool = True,
        srdf: Optional[PathLike] = None,
        friction: float = 1.0,
        floor: bool = False,
        missing_meshes: Literal["stop", "skip"] = "stop",
        decompose: Optional[float] = None,
        visuals: bool = True,
    ) -> Model:
        """Reads a model file; its root element says whether it is MJCF, URDF or SDF.

        Args:
            path: the file.
            package_dirs: folders in which the packages of ``package://…`` are looked for (URDF, SDF).
            floating_base: whether the root link of a URDF gets a free joint; otherwise it is fixed to the world.
            merge_fixed_joints: whether links that a fixed joint connects become one body (URDF); the frame of the merged link
                stays as a site of its name.
            self_collision: whether the links of a URDF meet each other, but for those that a joint connects.
            srdf: a file whose ``<disable_collisions>`` say which links of a URDF do not meet.
            friction: coefficient of friction of the shapes of a URDF, which has no word for it.
            floor: whether the world gets a floor (URDF, SDF), the plane z = 0, as the first geom; the friction of what stands on it
                counts.
            missing_meshes: what becomes of a geom whose mesh file is not there: "stop" refuses the model, "skip" leaves the geom
                out with a warning.
            decompose: the largest concavity of a part, in (0, 1], where meshes that touch are to be taken apart into convex parts
                instead of taking their hulls; 0.01 is a good one. The parts are kept in the folder ``signorini.parts`` beside the model.
            visuals: whether what is only seen is read: the ``<visual>`` shapes of URDF and SDF become geoms that touch nothing (group
                2; what touches of a link that they show is in group 3), with colours and images of STL, OBJ with MTL, COLLADA and
                glTF files; and images on surfaces of MJCF. Loading without them is quicker.

        Raises:
            ModelError: the file cannot be read, with file and line.
        """
        options = _options(
            package_dirs, floating_base, merge_fixed_joints, self_collision, srdf, friction, floor, missing_meshes, decompose,
            visuals,
        )
        return cls._load({"path": os.fspath(path)}, options)

    @classmethod
    def from_string(
        cls,
        text: str,
        *,
        base_dir: PathLike = "",
        package_dirs: Sequence[PathLike] = (),
        floating_base: bool = False,
        merge_fixed_joints: bool = False,
        self_collision: bool = True,
        srdf: Optional[PathLike] = None,
        friction: float = 1.0,
        floor: bool = False,
        missing_meshes: Literal["stop", "skip"] = "stop",
        decompose: Optional[float] = None,
        visuals: bool = True,
        format: Literal["auto", "mjcf", "urdf", "sdf"] = "auto",
    ) -> Model:
        """Reads MJCF, URDF or SDF from text; files that it names are looked for in ``base_dir``; other arguments as in
        :meth:`from_file`.

        Raises:
            ModelError: the text cannot become a model, with line.
        """
        source: Dict[str, Any] = {"text": text, "format": format, "base_dir": os.fspath(base_dir)}
        options = _options(
            package_dirs, floating_base, merge_fixed_joints, self_collision, srdf, friction, floor, missing_meshes, decompose,
            visuals,
        )
        return cls._load(source, options)

    @classmethod
    def from_mjcf(
        cls,
        source: PathLike,
        *,
        missing_meshes: Literal["stop", "skip"] = "stop",
        decompose: Optional[float] = None,
        visuals: bool = True,
    ) -> Model:
        """Reads MJCF from a file, or from text that begins with ``<``; other arguments as in :meth:`from_file`."""
        if _is_text(source):
            return cls.from_string(
                os.fspath(source), format="mjcf", missing_meshes=missing_meshes, decompose=decompose, visuals=visuals
            )
        return cls.from_file(source, missing_meshes=missing_meshes, decompose=decompose, visuals=visuals)

    @classmethod
    def from_urdf(
        cls,
        source: PathLike,
        *,
        package_dirs: Sequence[PathLike] = (),
        floating_base: bool = False,
        merge_fixed_joints: bool = False,
        self_collision: bool = True,
        srdf: Optional[PathLike] = None,
        friction: float = 1.0,
        floor: bool = False,
        missing_meshes: Literal["stop", "skip"] = "stop",
        decompose: Optional[float] = None,
        visuals: bool = True,
    ) -> Model:
        """Reads URDF from a file, or from text that begins with ``<``; other arguments as in :meth:`from_file`."""
        options = _options(
            package_dirs, floating_base, merge_fixed_joints, self_collision, srdf, friction, floor, missing_meshes, decompose,
            visuals,
        )
        if _is_text(source):
            return cls._load({"text": os.fspath(source), "format": "urdf", "base_dir": ""}, options)
        return cls._load({"path": os.fspath(source)}, options)

    @classmethod
    def from_sdf(
        cls,
        source: PathLike,
        *,
        package_dirs: Sequence[PathLike] = (),
        floor: bool = False,
        missing_meshes: Literal["stop", "skip"] = "stop",
        decompose: Optional[float] = None,
    ) -> Model:
        """Reads SDF from a file, or from text that begins with ``<``; other arguments as in :meth:`from_file`."""
        given: Dict[str, Any] = {
            "package_dirs": package_dirs,
            "floor": floor,
            "missing_meshes": missing_meshes,
            "decompose": decompose,
        }
        if _is_text(source):
            return cls.from_string(os.fspath(source), format="sdf", **given)
        return cls.from_file(source, **given)

    @classmethod
    def _load(cls, source: Dict[str, Any], options: Dict[str, Any]) -> Model:
        model = cls(**source, **options)
        model._recipe = {"source": _text_of(source), "options": options}
        for w in model.import_report:
            if w.changes_motion:
                warning = ModelWarning(str(w), w.file, w.line, w.element, w.what, w.effect, w.count)
                warnings.warn_explicit(warning, None, w.file, w.line)
        return model

    def _changed(self, core: _core.Model, change: Tuple[Any, Any]) -> Model:
        """This model with other numbers, of which a pickle keeps the recipe."""
        model = type(self)(other=core)
        model._recipe = dict(self._recipe, changes=[*self._recipe.get("changes", []), change])
        return model

    def _in_other_looks(self, core: Optional[_core.Model]) -> Model:
        """This model as another one that differs in looks alone, where there is one."""
        if core is None:
            return self
        model = type(self)(other=core)
        model._recipe = dict(self._recipe, dressed=True)
        return model

    def body(self, key: Key) -> _core.Body:
        """The body of this name or index.

        Raises:
            KeyError: no body has this name; the message lists those that exist, the most similar first.
        """
        return self._body(index_of("body", self.body_names, key))

    def joint(self, key: Key) -> _core.Joint:
        """The joint of this name or index; errors as in :meth:`body`."""
        return self._joint(index_of("joint", self.joint_names, key))

    def geom(self, key: Key) -> _core.Geom:
        """The geom of this name or index; errors as in :meth:`body`."""
        return self._geom(index_of("geom", self.geom_names, key))

    def actuator(self, key: Key) -> _core.Actuator:
        """The actuator of this name or index; errors as in :meth:`body`."""
        return self._actuator(index_of("actuator", self.actuator_names, key))

    def keyframe(self, key: Key) -> _core.Keyframe:
        """The keyframe of this name or index; errors as in :meth:`body`."""
        return self._keyframe(index_of("keyframe", self.keyframe_names, key))

    def parameter(self, name: str) -> NDArray[np.float64]:
        """Values of a parameter, one row for each part, read-only; names are those of ``PARAMETERS``. A :class:`Data` can have others
        (:meth:`Data.change`).
        """
        check_name(name)
        return self._parameter(name)

    def __copy__(self) -> Model:
        return self

    def __deepcopy__(self, memo: Dict[int, Any]) -> Model:
        return self

    def __reduce__(self) -> Tuple[Any, ...]:
        images = self._images() if self._recipe.get("dressed") else None
        return _unpickle, (type(self), self._recipe, self.content_hash, images)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.content_hash == other.content_hash

    def __hash__(self) -> int:
        return hash(self.content_hash)

    def _facts(self) -> List[Tuple[str, str]]:
        left_out = len(self.import_report)
        motion = sum(w.changes_motion for w in self.import_report)
        base = "floating" if any(self.joint(i).type == "free" for i in range(self.njnt)) else "fixed"
        return [
            ("bodies", str(self.nbody)),
            ("joints", str(self.njnt)),
            ("geoms", str(self.ngeom)),
            ("actuators", str(self.nu)),
            ("sensors", str(self.nsensor)),
            ("keyframes", str(self.nkey)),
            ("nq, nv", f"{self.nq}, {self.nv}"),
            ("base", base),
            ("time step", f"{self.timestep:g} s"),
            ("left out of the file", f"{left_out} ({motion} can change the motion)"),
        ]

    def __repr__(self) -> str:
        facts = ", ".join(f"{name} {value}" for name, value in self._facts())
        return f"<signorini.Model '{self.name}': {facts}>"

    def _repr_html_(self) -> str:
        return table(f"signorini.Model <i>{html.escape(self.name)}</i>", self._facts())


def table(title: str, facts: Sequence[Tuple[str, str]]) -> str:
    """A small HTML table for notebooks."""
    rows = "".join(f"<tr><td>{html.escape(name)}</td><td>{html.escape(value)}</td></tr>" for name, value in facts)
    return f"<b>{title}</b><table>{rows}</table>"


def _is_text(source: PathLike) -> bool:
    return isinstance(source, str) and source.lstrip().startswith("<")


def _options(
    package_dirs: Sequence[PathLike],
    floating_base: bool,
    merge_fixed_joints: bool,
    self_collision: bool,
    srdf: Optional[PathLike],
    friction: float,
    floor: bool,
    missing_meshes: str,
    decompose: Optional[float],
    visuals: bool,
) -> Dict[str, Any]:
    return {
        "package_dirs": [os.fspath(folder) for folder in package_dirs],
        "floating_base": floating_base,
        "merge_fixed_joints": merge_fixed_joints,
        "self_collision": self_collision,
        "srdf": None if srdf is None else os.path.abspath(srdf),
        "friction": friction,
        "floor": floor,
        "missing_meshes": missing_meshes,
        "decompose": decompose,
        "visuals": visuals,
    }


def _text_of(source: Dict[str, Any]) -> Dict[str, Any]:
    """A source by its text, so that a pickle of a model without meshes and includes needs no file."""
    if "path" not in source:
        return dict(source, base_dir=os.path.abspath(source["base_dir"]))
    path = pathlib.Path(source["path"])
    return {"text": path.read_text(encoding="utf-8"), "format": "auto", "base_dir": str(path.parent.resolve())}


def _unpickle(cls: type[Model], recipe: Dict[str, Any], content_hash: int, images: Any = None) -> Model:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)  # They were issued when the model was made.
        model = cls._load(recipe["source"], recipe["options"])
        if images is not None:
            model = model._in_other_looks(_core.with_images(model, images))
        for parameters, values in recipe.get("changes", []):
            model = model._changed(_core.with_parameters(model, parameters, values), (parameters, values))
    if model.content_hash != content_hash:
        raise ModelError(f"the files of model '{model.name}' are not those that it was pickled with: load it anew")
    return model
