#!/usr/bin/env python3
"""Every public name of the Python package with its signature and text, as Markdown, read from stubs and sources without importing them."""

import ast
import pathlib
import re
import sys

SECTIONS = {
    "Models": ["Model", "Spec", "ImportWarning", "Body", "Joint", "Geom", "Actuator", "Keyframe"],
    "States and steps": ["Data", "Settings", "SolverSettings", "step", "settle", "forward", "kinematics", "BodyData", "JointData", "ActuatorData"],
    "What a step found": ["Contacts", "ContactSum", "ContactMode", "Limits", "Certificate", "StepReport", "StageCount", "StageRun",
                            "SettleReport"],
    "Many simulations": ["Batch"],
    "Questions about a configuration": ["distance", "Nearest", "contacts_at", "ContactPoint", "overlaps", "cast_ray", "RayHit", "cast_rays", "frame_pose", "jacobian_rate", "center_of_mass", "center_of_mass_jacobian", "operational_space_inertia", "inverse_kinematics", "InverseKinematics", "support_polygon", "zero_moment_point"],
    "Dynamics": ["inverse", "bias_force", "mass_matrix", "jacobian", "integrate", "difference", "derivatives", "StepDerivatives", "Margin", "parameter_values", "with_parameters", "linearize", "LinearComplementaritySystem"],
    "Identification": ["identify", "Unknown", "Identification"],
    "Solvers": ["solve_lcp", "lcp_methods", "LcpResult", "ContactProblem", "ContactSolution"],
    "Recordings": ["Recorder", "Recording", "RecordingCheck", "load_recording"],
    "Errors and warnings": [
        "SignoriniError", "ModelError", "SettingError", "StateError", "ProblemError", "SolveError", "BatchError", "RecordingError",
        "ModelWarning", "OverlapWarning", "ToleranceWarning",
    ],
}  # fmt: skip


class Package:
    """The modules of a package as syntax trees by their dotted names within it, and where its names are defined."""

    def __init__(self, folder):
        self.modules = {}
        for file in sorted([*folder.rglob("*.py"), *folder.rglob("*.pyi")]):
            parts = file.relative_to(folder).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)
            self.modules[name] = ast.parse(file.read_text(encoding="utf-8"))

    def definition(self, name, module):
        """The class, function or assignment `name` as `module` sees it, following its imports; `None` for a module."""
        if module == "__init__" and name in self.modules and name != "lemkelcp":
            return None
        for node in self.modules[module].body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and node.name == name:
                return node, module
            if isinstance(node, (ast.Assign, ast.AnnAssign)) and assigned(node) == name:
                return node, module
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("signorini"):
                source = node.module.removeprefix("signorini").lstrip(".") or "__init__"
                if any((alias.asname or alias.name) == name for alias in node.names) and source in self.modules:
                    return self.definition(name, source)
        return None

    def exported(self, module):
        """`__all__` of a module."""
        for node in self.modules[module].body:
            if isinstance(node, ast.Assign) and assigned(node) == "__all__":
                return ast.literal_eval(node.value)
        return []

    def members(self, node, module):
        """Public members of a class, those of its base in `_core` after its own."""
        own = [m for m in node.body if is_member(m)]
        for base in node.bases:
            if isinstance(base, ast.Attribute) and getattr(base.value, "id", "") == "_core":
                inherited, _ = self.definition(base.attr, "_core")
                names = {member_name(m) for m in own}
                own += [m for m in inherited.body if is_member(m) and member_name(m) not in names]
        return own


def assigned(node):
    """The name that an assignment gives a value to; empty where it is none."""
    return getattr(node.target if isinstance(node, ast.AnnAssign) else node.targets[0], "id", "")


def member_name(node):
    return node.name if isinstance(node, ast.FunctionDef) else assigned(node)


def is_member(node):
    if isinstance(node, ast.FunctionDef):
        setter = any(isinstance(d, ast.Attribute) and d.attr == "setter" for d in node.decorator_list)
        return not node.name.startswith("_") and not setter
    return isinstance(node, ast.Assign) and assigned(node).isupper()


def decorated(node, name):
    return any(getattr(d, "id", "") == name for d in node.decorator_list)


def plain(text):
    """Python's markup as Markdown's."""
    text = re.sub(r":\w+:`~?([^`]*)`", r"`\1`", text)
    return re.sub(r"``([^`]*)``", r"`\1`", text)


def docstring(node):
    """A docstring as Markdown: arguments and errors as lists, examples as code."""
    text = ast.get_docstring(node) or ""
    out, code = [], False
    for line in text.splitlines():
        example = line.startswith(">>>") or (code and line.startswith("..."))
        result = code and not example and line.strip() != ""
        if example and not code:
            out.append("```pycon")
        if code and not example and not result:
            out.append("```")
        code = example or result
        section = re.fullmatch(r"(Args|Raises|Returns|Attributes|Yields):", line)
        item = re.match(r"    (\*{0,2}[\w, ]+): (.*)", line)
        if code:
            out.append(line)
        elif section:
            out += ["", f"*{section.group(1)}*", ""]
        elif item:
            out.append(f"- `{item.group(1)}`: {plain(item.group(2))}")
        else:
            belongs = line.startswith(" ") and out and out[-1].startswith(("- ", "  "))
            out.append("  " + plain(line.strip()) if belongs else plain(line.strip()))
    if code:
        out.append("```")
    return "\n".join(out)


SHORTER = (
    ("_PublicModel", "Model"), ("_PublicSettings", "Settings"), ("_MatrixLike", "MatrixLike"), ("_Path", "PathLike"), ("_core.", ""),
    ("NDArray[np.bool_]", "bool array"), ("NDArray[np.int8]", "int array"), ("NDArray[np.int64]", "int array"),
    ("NDArray[np.uint32]", "int array"), ("NDArray[np.float64]", "array"), ("_Array", "array"), ("_Ints", "int array"),
)  # fmt: skip


def shorter(type_text):
    """A type as a reader wants it."""
    for old, new in SHORTER:
        type_text = type_text.replace(old, new)
    return type_text


def signature(node, name):
    """`name(arguments) -> type` without `self`."""
    arguments = re.sub(r"^(self|cls)(, )?", "", ast.unparse(node.args))
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return shorter(f"{name}({arguments}){returns}")


def function(node, name, level):
    return f"{'#' * level} `{name}`\n\n```python\n{signature(node, name)}\n```\n\n{docstring(node)}\n"


def class_text(package, node, module, name, level):
    out = [f"{'#' * level} `{name}`\n\n{docstring(node)}\n"]
    constructor = next((m for m in node.body if isinstance(m, ast.FunctionDef) and m.name in ("__new__", "__init__")), None)
    if constructor and "Error" not in name and "Warning" not in name:
        out.insert(1, f"```python\n{signature(constructor, name).split(' -> ')[0]}\n```\n")
    fields = [m for m in node.body if isinstance(m, ast.AnnAssign) and not m.target.id.startswith("_")]
    if fields and any("dataclass" in ast.unparse(d) for d in node.decorator_list):
        out.insert(1, f"```python\n{name}({', '.join(ast.unparse(field) for field in fields)})\n```\n")
    rows, methods, seen = [], [], set()
    for member in package.members(node, module):
        if member_name(member) in seen:
            continue
        if isinstance(member, ast.Assign):
            rows.append((assigned(member), ast.unparse(member.value), following_text(node, member)))
        elif decorated(member, "property"):
            rows.append((member.name, shorter(ast.unparse(member.returns)), ast.get_docstring(member) or ""))
        elif decorated(member, "overload") and not ast.get_docstring(member):
            continue
        else:
            methods.append(member)
        seen.add(member_name(member))
    if rows:
        cells = ([name, f"`{cell(kind)}`", cell(text)] for name, kind, text in rows)
        lines = [f"| `{name}` | {kind} | {text} |" for name, kind, text in cells]
        out.append("\n".join(["| attribute | type | |", "|---|---|---|", *lines, ""]))
    for member in methods:
        out.append(f"**`{signature(member, f'{name}.{member.name}')}`**\n\n{docstring(member)}\n")
    return "\n".join(out)


def cell(text):
    return " ".join(plain(text).split()).replace("|", "\\|")


def following_text(parent, member):
    """The string after an assignment in a class or module, which documents it."""
    position = parent.body.index(member) + 1
    following = parent.body[position] if position < len(parent.body) else None
    if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
        return following.value.value
    return ""


def entry(package, name, module, level=3):
    found = package.definition(name, module)
    if found is None:
        return ""
    node, home = found
    if isinstance(node, ast.FunctionDef):
        return function(node, name, level)
    if not isinstance(node, ast.ClassDef):
        text = following_text(package.modules[home], node)
        return f"{'#' * level} `{name}`\n\n```python\n{ast.unparse(node)}\n```\n\n{plain(text)}\n"
    return class_text(package, node, home, name, level)


def reference(folder):
    """The whole reference: what `signorini` exports, and what each of its modules and packages exports beside that."""
    package = Package(folder)
    public = [n for n in package.exported("__init__") if package.definition(n, "__init__")]
    listed = {name for names in SECTIONS.values() for name in names}
    sections = {**SECTIONS, "More": [n for n in public if n not in listed and n != "lemkelcp" and not n.startswith("__")]}
    out = []
    for title, names in sections.items():
        texts = [entry(package, name, "__init__") for name in names if name in public]
        if texts:
            out += [f"## {title}\n", *texts]
    shown = set(public) - {"lemkelcp"}
    for module in sorted(package.modules):
        names = [n for n in package.exported(module) if n not in shown]
        if module.startswith("_") or "." in module or not names:
            continue
        out += [f"## `signorini.{module}`\n", docstring(package.modules[module]) + "\n"]
        out += [entry(package, name, module) for name in names]
    return "\n".join(out)


if __name__ == "__main__":
    print(reference(pathlib.Path(sys.argv[1])))
