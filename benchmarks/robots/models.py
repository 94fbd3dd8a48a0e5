"""Finds model files below folders and says which are complete: whether everything they name is there.

The files are read as a sequence of tags, so that a file that no XML parser takes is judged by the engines and not here.
"""

import hashlib
import pathlib
import re
from dataclasses import dataclass, field

TAG = re.compile(r"<([A-Za-z_][\w:.-]*)((?:\s+[\w:.-]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*)\s*/?>", re.S)
ATTRIBUTE = re.compile(r"([\w:.-]+)\s*=\s*(?:\"([^\"]*)\"|'([^']*)')", re.S)
COMMENT = re.compile(r"<!--.*?-->|<!\[CDATA\[.*?\]\]>", re.S)
URI = re.compile(r"<uri>\s*([^<\s]+)\s*</uri>")
MJCF_ASSETS = {"mesh", "hfield", "texture", "skin", "flexcomp", "model"}
# Of files that differ in numbers only (random_urdfs/000 … 999) this many are enough.
PER_SERIES = 10


@dataclass
class ModelFile:
    """A model file. `missing` is the first file that it names and that is not there."""

    path: pathlib.Path
    kind: str
    missing: str = ""
    empty: bool = False
    keyframes: list = field(default_factory=list)
    servos: bool = False
    digest: str = ""


def tags(text):
    """Name and attributes of every start tag outside of comments."""
    for match in TAG.finditer(COMMENT.sub("", text)):
        yield match[1], {a[1]: a[2] if a[2] is not None else a[3] for a in ATTRIBUTE.finditer(match[2])}


def read(path):
    return path.read_bytes().decode("utf-8", "replace")


def root_of(text):
    """The name of the first element."""
    return next((name for name, _ in tags(text)), "")


def find(folders):
    """All models below folders, each content once and few of each series; complete ones and others."""
    seen, series, found = set(), {}, []
    suffixes = {".urdf", ".sdf", ".world", ".xml"}
    for folder in folders:
        for path in sorted(p for p in folder.rglob("*") if p.suffix in suffixes and p.is_file()):
            model = inspect(path)
            key = re.sub(r"\d+", "#", str(path))
            if model is None or model.digest in seen or series.get(key, 0) >= PER_SERIES:
                continue
            seen.add(model.digest)
            series[key] = series.get(key, 0) + 1
            found.append(model)
    return found


def inspect(path):
    """What a file is; None where it is no model of rigid bodies."""
    text = read(path)
    root = root_of(text)
    if root == "mujoco" and path.suffix == ".xml":
        return inspect_mjcf(path, text)
    if root == "robot" and path.suffix == ".urdf":
        return inspect_urdf(path, text)
    if root in ("sdf", "gazebo") and path.suffix in (".sdf", ".world"):
        return inspect_sdf(path, text)
    return None


def inspect_mjcf(path, text):
    model = ModelFile(path, "mjcf")
    parts, model.missing = with_includes(path, text)
    elements = [(name, attributes, base) for base, part in parts for name, attributes in tags(part)]
    compiler = {}
    for name, attributes, _ in elements:
        compiler.update(attributes if name == "compiler" else {})
    meshes = compiler.get("meshdir", compiler.get("assetdir", ""))
    textures = compiler.get("texturedir", compiler.get("assetdir", ""))
    strip = compiler.get("strippath") == "true"
    for name, attributes, base in elements:
        files = [v for k, v in attributes.items() if k.startswith("file") and v] if name in MJCF_ASSETS else []
        inside = {"texture": textures, "model": ""}.get(name, meshes)
        for file in files:
            file = pathlib.PurePath(file).name if strip else file
            if not any((folder / inside / file).is_file() for folder in (path.parent, base)):
                model.missing = model.missing or file
    model.keyframes = [a["name"] for name, a, _ in elements if name == "key" and "name" in a]
    model.servos = any(name == "position" for name, _, _ in elements)
    model.empty = not any(name in ("body", "geom", "attach", "frame") for name, _, _ in elements)
    return digested(model, "".join(part for _, part in parts))


def with_includes(path, text):
    """The text with those of its includes, each with the folder it lies in, and the first include that is missing."""
    parts, queue, missing, names = [], [(path.parent, text)], "", set()
    while queue:
        base, part = queue.pop(0)
        parts.append((base, part))
        for name, attributes in tags(part):
            if name != "include" or not attributes.get("file") or attributes["file"] in names:
                continue
            names.add(attributes["file"])
            places = [folder / attributes["file"] for folder in (path.parent, base)]
            file = next((place for place in places if place.is_file()), None)
            if file is None:
                missing = missing or attributes["file"]
            else:
                queue.append((file.parent, read(file)))
    return parts, missing


def inspect_urdf(path, text):
    model = ModelFile(path, "urdf")
    elements = list(tags(text))
    files = [a.get("filename", "") for name, a in elements if name == "mesh"]
    model.missing = next((f for f in files if f and not resolve(f, path.parent)), "")
    model.empty = not any(name == "link" for name, _ in elements)
    return digested(model, text)


def inspect_sdf(path, text):
    model = ModelFile(path, "sdf")
    # Materials are looks alone, and their scripts are Ogre's.
    shapes = re.sub(r"<(material|plugin|sensor|sky|light|scene)\b.*?</\1>", "", COMMENT.sub("", text), flags=re.S)
    model.missing = next((f for f in URI.findall(shapes) if not resolve(f, path.parent)), "")
    model.empty = not any(name in ("link", "include") for name, _ in tags(text))
    return digested(model, text)


def resolve(uri, base):
    """Whether a file or folder of `package://`, `model://`, `file://` or a relative path is there."""
    for scheme in ("package://", "model://"):
        if uri.startswith(scheme):
            package, _, rest = uri.removeprefix(scheme).partition("/")
            above = [folder for folder in (base, *base.parents)]
            inside = [folder / rest for folder in above if folder.name == package]
            return any(place.exists() for place in [*(folder / package / rest for folder in above), *inside])
    return (base / uri.removeprefix("file://")).exists() and "://" not in uri.removeprefix("file://")


def digested(model, text):
    # Two robots may have the same text and different meshes: the folder's name tells them apart.
    words = " ".join(text.split())
    model.digest = hashlib.sha256(f"{model.path.parent.name} {words}".encode()).hexdigest()
    return model
