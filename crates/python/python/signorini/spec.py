"""Models that can be edited."""

from __future__ import annotations

import os
import pathlib
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union
from xml.etree import ElementTree

import numpy as np

from signorini import _core
from signorini._names import Strict, index_of
from signorini.data import Data
from signorini.errors import ModelError, ProblemError
from signorini.model import Model

__all__ = ["Spec", "SpecPart"]

PathLike = Union[str, "os.PathLike[str]"]


PathPart = Union[str, "SpecPart", float, Tuple[Union[str, "SpecPart"], Union[str, "SpecPart"]]]
"""A part of the path of a tendon: a site or a geom, a pulley's divisor, or a geom with the site on its side."""


class SpecPart:
    """A part of a :class:`Spec` whose attributes can be read and set; they have MJCF's names: ``spec.geom("box").friction = 0.4``.

    ``dir(part)`` lists them. A body has besides ``add_body``, ``add_joint``, ``add_freejoint``, ``add_geom`` and ``add_site``, as the spec has
    them.
    """

    __slots__ = {
        "spec": "The spec.",
        "sort": 'Its sort: "body", "joint", "geom", …',
        "name": "Its name, by which it is found.",
    }

    spec: Spec
    sort: str
    name: str

    def __init__(self, spec: Spec, sort: str, name: str) -> None:
        object.__setattr__(self, "spec", spec)
        object.__setattr__(self, "sort", sort)
        object.__setattr__(self, "name", name)

    def __dir__(self) -> List[str]:
        return [*super().__dir__(), *self.spec._attributes(self.sort)]

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        if attribute in self.spec._attributes(self.sort):
            return self.spec._get(self.sort, self.name, attribute)
        raise self._unknown(attribute)

    def __setattr__(self, attribute: str, value: Any) -> None:
        try:
            if not self.spec._set(self.sort, self.name, attribute, _plain(value)):
                raise self._unknown(attribute)
        except (TypeError, ValueError) as error:
            raise ProblemError(f"{attribute} of {self.sort} '{self.name}': {error}") from None

    def _unknown(self, attribute: str) -> AttributeError:
        known = ", ".join(self.spec._attributes(self.sort)) or "none that can be changed: remove the part and add another"
        return AttributeError(f"a {self.sort} has no attribute '{attribute}'; it has {known}")

    def remove(self) -> List[str]:
        """Takes the part away with all that refers to it; lists what went."""
        sort: Any = self.sort
        return self.spec.remove(sort, self.name)

    def add_body(self, name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds a body to this one; see :meth:`Spec.add_body`."""
        return self.spec.add_body(name, self._body(), **attributes)

    def add_joint(self, type: str = "hinge", name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds a joint to this body; see :meth:`Spec.add_joint`."""
        return self.spec.add_joint(self._body(), type, name, **attributes)

    def add_freejoint(self, name: Optional[str] = None) -> SpecPart:
        """Lets this body move freely."""
        return self.spec.add_joint(self._body(), "free", name)

    def add_geom(self, type: str = "sphere", name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds a geom to this body; see :meth:`Spec.add_geom`."""
        return self.spec.add_geom(self._body(), type, name, **attributes)

    def add_site(self, name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds a site to this body; see :meth:`Spec.add_site`."""
        return self.spec.add_site(self._body(), name, **attributes)

    def _body(self) -> str:
        if self.sort != "body":
            raise ModelError(f"{self.sort} '{self.name}' is no body: parts are added to bodies")
        return self.name

    def __repr__(self) -> str:
        return f"<signorini.SpecPart {self.sort} '{self.name}'>"


class Spec(Strict, _core.Spec):
    """A model that can be edited: parts found, added, changed, removed, others attached to it, compiled into a :class:`Model`.

    >>> from signorini import Spec
    >>> world = Spec.from_string("<mujoco><worldbody><geom type='plane'/></worldbody></mujoco>")
    >>> ball = Spec.from_string(
    ...     "<mujoco><worldbody><body name='ball'><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    >>> for k in range(3):
    ...     world.attach(ball, pos=(0, 0, 0.1 + 0.3 * k), prefix=f"{k} ")
    >>> pole = world.add_body("pole", pos=(1, 0, 1))
    >>> hinge = pole.add_joint("hinge", axis=(0, 1, 0), damping=0.1)
    >>> rod = pole.add_geom("capsule", fromto=(0, 0, 0, 0, 0, -0.5), size=0.02, mass=0.3)
    >>> rod.friction = 0.4
    >>> motor = world.add_actuator("motor", joint=hinge, gear=5)
    >>> model = world.compile()
    >>> model.nbody, model.nu, model.geom(rod.name).friction
    (5, 1, 0.4)

    Args:
        model: the model to begin with; an empty world without one.
        name: the name of an empty world.
    """

    def __new__(cls, model: Optional[Model] = None, name: str = "world") -> Spec:
        return super().__new__(cls, model, name)

    @classmethod
    def from_file(cls, path: PathLike, **options: Any) -> Spec:
        """A copy of what a file describes; options as of :meth:`Model.from_file`."""
        return cls(Model.from_file(path, **options))

    @classmethod
    def from_string(cls, text: str, **options: Any) -> Spec:
        """A copy of what a text describes; options as of :meth:`Model.from_string`."""
        return cls(Model.from_string(text, **options))

    def attach(
        self,
        other: Union[_core.Spec, Model, str],
        body: Union[str, SpecPart] = "world",
        *,
        pos: Sequence[float] = (0.0, 0.0, 0.0),
        quat: Sequence[float] = (1.0, 0.0, 0.0, 0.0),
        prefix: str = "",
    ) -> None:
        """Puts a spec, a model or the text of one at a body: what is fixed to its world is fixed to that body, at ``pos`` (m) and turned by
        ``quat`` (w, x, y, z). Names get ``prefix`` before them.

        Raises:
            ModelError: there is no such body, a name is taken, or a floating body would hang on something that is not the world; nothing has
                changed then.
        """
        if prefix != prefix.lstrip():
            raise ModelError(f"names cannot begin with the space of the prefix {prefix!r}")
        if isinstance(other, str):
            other = Spec.from_string(other)
        elif isinstance(other, Model):
            other = Spec(other)
        self._attach(other, _name(body), pos=tuple(map(float, pos)), quat=tuple(map(float, quat)), prefix=prefix)

    def part(self, sort: str, key: Union[str, int]) -> SpecPart:
        """The part of a sort ("body", "joint", "geom", "site", "tendon", "actuator", "sensor", "equality", "keyframe") by name or index.

        Raises:
            KeyError: no part has this name; the message lists those that exist, the most similar first.
        """
        names = self.names(sort)
        return SpecPart(self, sort, names[index_of(sort, names, key)])

    def body(self, key: Union[str, int]) -> SpecPart:
        """The body of this name or index; errors as of :meth:`part`."""
        return self.part("body", key)

    def joint(self, key: Union[str, int]) -> SpecPart:
        """The joint of this name or index; errors as of :meth:`part`."""
        return self.part("joint", key)

    def geom(self, key: Union[str, int]) -> SpecPart:
        """The geom of this name or index; errors as of :meth:`part`."""
        return self.part("geom", key)

    def site(self, key: Union[str, int]) -> SpecPart:
        """The site of this name or index; errors as of :meth:`part`."""
        return self.part("site", key)

    def actuator(self, key: Union[str, int]) -> SpecPart:
        """The actuator of this name or index; errors as of :meth:`part`."""
        return self.part("actuator", key)

    def add_body(self, name: Optional[str] = None, parent: Union[str, SpecPart] = "world", **attributes: Any) -> SpecPart:
        """Adds a body with MJCF's attributes (``pos``, ``quat``, ``mocap``, ``gravcomp``, …).

        With ``mass``, and ``inertia`` (3 moments, kg·m²) and ``ipos`` beside it, it has an inertia of its own; otherwise its geoms give it one.
        Where the spec is ``sleeping``, the tree of a body whose ``begins_asleep`` is set stands until something touches it (MJCF ``sleep="init"``).

        Raises:
            ModelError: a name is taken, there is no such parent, or an attribute is wrong; nothing has changed then.
        """
        mass, inertia, ipos = (attributes.pop(word, None) for word in ("mass", "inertia", "ipos"))
        name = self._free_name("body", name)
        element = _element("body", {"name": name, **attributes})
        if mass is not None:
            if inertia is None:
                raise ModelError(f"body '{name}': give inertia (3 moments, kg·m²) with its mass, or neither and geoms with mass")
            element.append(_element("inertial", {"pos": (0, 0, 0) if ipos is None else ipos, "mass": mass, "diaginertia": inertia}))
        self._add("body", _text(element), _name(parent))
        if mass is None:
            self._inertia_of_geoms(name)
        return SpecPart(self, "body", name)

    def add_joint(
        self, body: Union[str, SpecPart], type: str = "hinge", name: Optional[str] = None, **attributes: Any
    ) -> SpecPart:
        """Adds a joint ("hinge", "slide", "ball", "free") to a body with MJCF's attributes; angles are in radians."""
        name = self._free_name("joint", name, _name(body))
        if type == "free":
            element = _element("freejoint", {"name": name, **attributes})
        else:
            element = _element("joint", {"name": name, "type": type, **_limited(attributes, "range")})
        return self._added("joint", name, element, body)

    def add_geom(
        self,
        body: Union[str, SpecPart] = "world",
        type: str = "sphere",
        name: Optional[str] = None,
        *,
        mesh: Optional[PathLike] = None,
        **attributes: Any,
    ) -> SpecPart:
        """Adds a geom to a body with MJCF's attributes (``size``, ``pos``, ``fromto``, ``mass``, ``friction``, …).

        Its mass, or its volume times ``density`` (1000 kg/m³), counts where it is given and on bodies that were added without an inertia.
        ``mesh`` is the file of a mesh, of which the convex hull is taken; ``scale`` (3) belongs to it.
        """
        name = self._free_name("geom", name, _name(body))
        attributes = {word: value for word, value in attributes.items() if value is not None}
        weighs = True if "mass" in attributes or "density" in attributes else None
        own = [(word, _plain(attributes.pop(word))) for word in ("restitution", "surface_velocity", "grain") if word in attributes]
        assets = ""
        if mesh is not None:
            asset = {"name": "mesh", "file": os.fspath(pathlib.Path(mesh).resolve())}
            if "scale" in attributes:
                asset["scale"] = attributes.pop("scale")
            assets, type = _text(_element("mesh", asset)), "mesh"
            attributes["mesh"] = "mesh"
        element = _element("geom", {"name": name, "type": type, **attributes})
        self._add("geom", _text(element), _name(body), assets, weighs, name, own)
        return SpecPart(self, "geom", name)

    def add_site(self, body: Union[str, SpecPart] = "world", name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds a site to a body with MJCF's attributes."""
        name = self._free_name("site", name, _name(body))
        return self._added("site", name, _element("site", {"name": name, **attributes}), body)

    def add_actuator(self, type: str = "motor", name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds an actuator ("motor", "position", "velocity", "general", "muscle", "adhesion", …) with MJCF's attributes: ``joint``, ``tendon``,
        ``site`` or ``body`` says what it drives.
        """
        driven = next((attributes[word] for word in ("joint", "tendon", "site", "body") if word in attributes), None)
        name = self._free_name("actuator", name, "" if driven is None else _name(driven))
        attributes = _limited(attributes, "ctrlrange", "forcerange")
        return self._related("actuator", name, _element(type, {"name": name, **attributes}))

    def add_sensor(self, type: str, name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds a sensor by MJCF's name of its sort ("accelerometer", "jointpos", "framepos", …) with MJCF's attributes."""
        name = self._free_name("sensor", name, type)
        return self._related("sensor", name, _element(type, {"name": name, **attributes}))

    def add_equality(self, type: str, name: Optional[str] = None, **attributes: Any) -> SpecPart:
        """Adds an equality constraint ("connect", "weld", "joint") with MJCF's attributes."""
        name = self._free_name("equality", name, type)
        return self._related("equality", name, _element(type, {"name": name, **attributes}))

    def add_tendon(
        self,
        joints: Optional[Mapping[str, float]] = None,
        name: Optional[str] = None,
        *,
        path: Optional[Sequence[PathPart]] = None,
        **attributes: Any,
    ) -> SpecPart:
        """Adds a tendon with MJCF's attributes: a fixed one, whose length is the sum of joint coordinates times the coefficients ``joints``,
        or a spatial one along a ``path``.

        A path has sites and, between two of them, geoms (spheres and cylinders) that are in the way, by name or as parts; ``(geom, site)`` is a
        geom with the site on the side where the tendon lies; a number is a pulley with this divisor, after which another branch begins.
        A name that a site and a geom have is that of the site.

        Raises:
            ModelError: both or none of ``joints`` and ``path`` are given, or a part is wrong; nothing has changed then.
        """
        if (joints is None) == (path is None):
            raise ModelError("a tendon has either joints (a fixed one) or a path (a spatial one)")
        name = self._free_name("tendon", name, "tendon")
        element = _element("fixed" if path is None else "spatial", {"name": name, **_limited(attributes, "range")})
        for joint, coefficient in (joints or {}).items():
            element.append(_element("joint", {"joint": _name(joint), "coef": coefficient}))
        for part in path or ():
            element.append(self._path_part(part))
        return self._related("tendon", name, element)

    def add_pair(self, geom1: Union[str, SpecPart], geom2: Union[str, SpecPart], **attributes: Any) -> None:
        """Lets two geoms meet with a friction of their own, with MJCF's attributes. Nothing is taken over from the geoms: what is not given is
        MJCF's (``condim`` 3, ``friction`` 1 1 0.005 0.0001 0.0001, ``margin`` 0).
        """
        self._add_relation("pair", "", _text(_element("pair", {"geom1": geom1, "geom2": geom2, **attributes})))

    def add_keyframe(self, name: str, **attributes: Any) -> SpecPart:
        """Adds a named state with MJCF's attributes (``qpos``, ``qvel``, ``act``, ``ctrl``, …) in the order of the model that
        :meth:`compile` gives now.
        """
        name = _checked_name("keyframe", name)
        return self._related("keyframe", name, _element("key", {"name": name, **attributes}))

    def compile(self) -> Model:
        """The model: what :meth:`to_mjcf` writes, read again, with the images on its surfaces, which its pickles keep.

        Raises:
            ModelError: the parts are no mechanism, or MJCF cannot say all of it; the message names the part.
        """
        text, left_out = self._mechanism()
        if left_out:
            raise ModelError("MJCF cannot say all of this model: " + "; ".join(left_out))
        model = Model.from_string(text, format="mjcf")
        return model._in_other_looks(self._dress(model))

    def recompile(self, data: Data) -> Tuple[Model, Data]:
        """The model as it is now, and a data of it that goes on from ``data`` (of the model before).

        Joints, activations, controls, applied forces and mocap bodies that are in both by name keep what they had, and so do changed
        parameters (:meth:`Data.change`); what is new is at its reference, at rest. The time stays, and the next step starts cold.

        Raises:
            ModelError: as of :meth:`compile`.
        """
        model = self.compile()
        return model, _carried(data, model)

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self), (self.compile(),)

    def _path_part(self, part: PathPart) -> ElementTree.Element:
        if isinstance(part, (int, float)):
            return _element("pulley", {"divisor": float(part)})
        if isinstance(part, tuple):
            geom, side = part
            return _element("geom", {"geom": geom, "sidesite": side})
        is_site = part.sort == "site" if isinstance(part, SpecPart) else part in self.names("site")
        if not is_site and _name(part) not in self.names("geom"):
            raise ModelError(f"path of a tendon: there is no site or geom '{_name(part)}'")
        sort = "site" if is_site else "geom"
        return _element(sort, {sort: part})

    def _free_name(self, sort: str, name: Optional[str], like: str = "") -> str:
        """The name given, or one that nobody has."""
        if name is not None:
            return _checked_name(sort, name)
        names, base = set(self.names(sort)), f"{like} {sort}".strip()
        return next(free for free in _numbered(base) if free not in names)

    def _added(self, sort: str, name: str, element: ElementTree.Element, body: Union[str, SpecPart]) -> SpecPart:
        self._add(sort, _text(element), _name(body))
        return SpecPart(self, sort, name)

    def _related(self, sort: str, name: str, element: ElementTree.Element) -> SpecPart:
        self._add_relation(sort, name, _text(element))
        return SpecPart(self, sort, name)


def _numbered(base: str) -> Iterator[str]:
    yield base
    k = 2
    while True:
        yield f"{base} {k}"
        k += 1


def _name(part: Union[str, SpecPart]) -> str:
    return part.name if isinstance(part, SpecPart) else part


def _checked_name(sort: str, name: str) -> str:
    """The name, where a model file keeps it as it is."""
    if not isinstance(name, str):
        raise ModelError(f"the name of a {sort} is text, not {name!r}")
    if not name or name != name.strip():
        raise ModelError(f"a {sort} cannot be called {name!r}: a name is not empty, and neither begins nor ends with a space")
    return name


def _plain(value: Any) -> Any:
    """NumPy arrays as lists."""
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def _limited(attributes: Dict[str, Any], *ranges: str) -> Dict[str, Any]:
    """MJCF with ``limited`` said where a range is given."""
    words = {"range": "limited", "ctrlrange": "ctrllimited", "forcerange": "forcelimited"}
    said = {words[name]: True for name in ranges if attributes.get(name) is not None}
    return {**said, **attributes}


def _element(tag: str, attributes: Mapping[str, Any]) -> ElementTree.Element:
    return ElementTree.Element(tag, {word: _word(value) for word, value in attributes.items() if value is not None})


def _text(element: ElementTree.Element) -> str:
    return ElementTree.tostring(element, encoding="unicode")


def _word(value: Any) -> str:
    if isinstance(value, SpecPart):
        return value.name
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    return " ".join(repr(float(x)) for x in np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel())


def _carried(data: Data, model: Model) -> Data:
    """A data of another model in which the parts that both have by name are as they were."""
    old, new = data.model, Data(model, data.settings)
    new.time = data.time
    for i, name in enumerate(model.joint_names):
        if name not in old.joint_names or old.joint(name).type != model.joint(i).type:
            continue
        before, after = data.joint(name), new.joint(i)
        after.qpos, after.qvel, after.qfrc_applied = before.qpos, before.qvel, before.qfrc_applied
    for row, name in enumerate(model.actuator_names):
        if name in old.actuator_names:
            new.ctrl[row] = data.actuator(name).ctrl
    _carry_activations(data, new)
    for row, name in enumerate(model.body_names):
        if name in old.body_names:
            new.xfrc_applied[row] = data.xfrc_applied[old.body_names.index(name)]
    mocap_before, mocap_after = old._mocap_names(), model._mocap_names()
    for row, name in enumerate(mocap_after):
        if name in mocap_before:
            at = mocap_before.index(name)
            new.mocap_pos[row], new.mocap_quat[row] = data.mocap_pos[at], data.mocap_quat[at]
    for parameter, values in data._changed():
        _carry_parameter(parameter, np.reshape(values, data.parameter(parameter).shape), old, new)
    _core.kinematics(model, new)
    return new


def _carry_activations(data: Data, new: Data) -> None:
    before, after = data.model._activation_names(), new.model._activation_names()
    for row, name in enumerate(after):
        if name in before:
            new.act[row] = data.act[before.index(name)]


def _carry_parameter(parameter: str, values: Any, old: Model, new: Data) -> None:
    """Numbers of parts that both models have, where they are not those of the old model."""
    before = old.parameter(parameter)
    names, others = old._parameter_parts(parameter), new.model._parameter_parts(parameter)
    if not names:
        if before.shape == values.shape and parameter == "gravity":
            new.change(gravity=values)
        return
    rows = {name: values[i] for i, name in enumerate(names) if name in others and (values[i] != before[i]).any()}
    if rows:
        new.change(**{parameter: rows})
