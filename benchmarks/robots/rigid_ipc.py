"""Writes mechanisms of rigid-ipc (Ferguson et al., "Intersection-free rigid body dynamics", SIGGRAPH 2021) as MJCF and runs them.

    python3 benchmarks/robots/rigid_ipc.py FOLDER [--only REGEX] [--duration 5] [--decompose 0.01] [--program model_run] [--out build/rigid_ipc]

FOLDER is a checkout of rigid-ipc or a copy of its `fixtures` and `meshes`. Meshes are taken as they are (`type="sdf"`, triangle against
triangle), or apart into convex parts. What it prints: a line for each with steps, missed ones, the deepest penetration, contacts and time.
"""

import argparse
import json
import math
import pathlib
import re
import subprocess
import sys

NAMES = "bolt|gears|092-piston|140-punching-press"
AXES = ["1 0 0", "0 1 0", "0 0 1"]


def read_off(path):
    """Vertices and faces of an OFF file."""
    words = path.read_text().split()
    count, faces = int(words[1]), int(words[2])
    at = 4 + 3 * count
    vertices = [words[4 + 3 * k : 7 + 3 * k] for k in range(count)]
    triangles = []
    for _ in range(faces):
        n = int(words[at])
        face = [int(w) for w in words[at + 1 : at + 1 + n]]
        triangles += [[face[0], face[k], face[k + 1]] for k in range(1, n - 1)]
        at += n + 1
    return vertices, triangles


def mesh_file(path, folder):
    """A mesh in a format that MJCF knows."""
    if path.suffix != ".off":
        return path
    vertices, triangles = read_off(path)
    out = folder / f"{path.parent.name}-{path.stem}.obj"
    lines = [f"v {' '.join(v)}" for v in vertices] + ["f " + " ".join(str(i + 1) for i in t) for t in triangles]
    out.write_text("\n".join(lines) + "\n")
    return out


def quaternion(degrees):
    """Rotations about the world's x, y and z axes, in this order; w first."""
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    for axis, angle in enumerate(degrees):
        c, s = math.cos(math.radians(angle) / 2), math.sin(math.radians(angle) / 2)
        u = [s * (axis == k) for k in range(3)]
        w, x, y, z = (
            c * w - u[0] * x - u[1] * y - u[2] * z,
            c * x + u[0] * w + u[1] * z - u[2] * y,
            c * y + u[1] * w + u[2] * x - u[0] * z,
            c * z + u[2] * w + u[0] * y - u[1] * x,
        )
    return w, x, y, z


def numbers(values):
    return " ".join(repr(float(v)) for v in values)


def body(k, part, shape):
    """The element of a body, and its actuators with their controls. Joints have the world's axes: a body that is turned carries its
    shape turned."""
    position, turn = (numbers(part.get("position", [0, 0, 0])), numbers(quaternion(part.get("rotation", [0, 0, 0]))))
    if part.get("type") == "static":
        return f'<geom type="{shape}" mesh="m{k}" pos="{position}" quat="{turn}"/>', []
    fixed = part.get("is_dof_fixed", [False] * 6)
    sorts = {dof: "slide" if dof < 3 else "hinge" for dof in range(6) if not fixed[dof]}
    joints = [f'<joint name="j{k}_{d}" type="{sort}" axis="{AXES[d % 3]}"/>' for d, sort in sorts.items()]
    if len(joints) == 6:
        joints = [f'<freejoint name="j{k}"/>']
    drives = []
    if part.get("type") == "kinematic":
        for dof in (d for d in sorts if d >= 3):
            servo = f'<velocity joint="j{k}_{dof}" kv="1e9"/>'
            drives.append((servo, math.radians(part.get("angular_velocity", [0, 0, 0])[dof - 3])))
    for dof in (d for d in sorts if d < 3 and part.get("force", [0, 0, 0])[d]):
        drives.append((f'<motor joint="j{k}_{dof}" gear="{part["force"][dof]}"/>', 1.0))
    geom = f'<geom type="{shape}" mesh="m{k}" quat="{turn}" density="{part.get("density", 1000)}"/>'
    return f'<body name="b{k}" pos="{position}">{"".join(joints)}{geom}</body>', drives


def convert(fixture, meshes, folder, shape):
    """Writes the MJCF file of a fixture, and its controls beside it; the path."""
    text = json.loads(fixture.read_text())
    problem = text["rigid_body_problem"]
    assets, bodies, drives = [], [], []
    for k, part in enumerate(problem["rigid_bodies"]):
        if not part.get("enabled", True):
            continue
        scale = part.get("scale", 1.0)
        scale = scale if isinstance(scale, list) else [scale] * 3
        assets.append(f'<mesh name="m{k}" file="{mesh_file(meshes / part["mesh"], folder)}" scale="{numbers(scale)}"/>')
        element, own = body(k, part, shape)
        bodies.append(element)
        drives += own
    gravity, friction = numbers(problem.get("gravity", [0, 0, 0])), problem.get("coefficient_friction", 0.0)
    mjcf = (
        f'<mujoco model="{fixture.stem}"><option timestep="{text.get("timestep", 0.01)}" gravity="{gravity}"/>'
        f'<default><geom friction="{friction}"/></default><asset>{"".join(assets)}</asset>'
        f'<worldbody>{"".join(bodies)}</worldbody><actuator>{"".join(servo for servo, _ in drives)}</actuator></mujoco>\n'
    )
    out = folder / f"{fixture.parent.name}-{fixture.stem}.xml"
    out.write_text(mjcf.replace("><", ">\n<"))
    out.with_suffix(".control.json").write_text(json.dumps([[control for _, control in drives]]))
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", metavar="REGEX", default=NAMES)
    parser.add_argument("--duration", type=float, default=5.0)
    parser.add_argument("--patience", type=float, default=120.0, help="CPU time of a run, s")
    parser.add_argument("--decompose", type=float, metavar="CONCAVITY")
    parser.add_argument("--program", type=pathlib.Path, default=pathlib.Path("target/release/model_run"))
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("build/rigid_ipc"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    fixtures = [f for f in sorted((options.folder / "fixtures").rglob("*.json")) if re.search(options.only, str(f))]
    meshes = (options.folder / "meshes").resolve()
    shape = "mesh" if options.decompose else "sdf"
    print("| mechanism | end | time s | steps | missed | worst residual | deepest mm | contacts | median step ms | why |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for fixture in fixtures:
        model = convert(fixture, meshes, options.out.resolve(), shape)
        command = [options.program, model, "--duration", str(options.duration), "--patience", str(options.patience)]
        command += ["--control", model.with_suffix(".control.json")]
        command += ["--decompose", str(options.decompose)] if options.decompose else []
        child = subprocess.run(command, capture_output=True, text=True, check=False)
        row = {}
        for line in child.stdout.splitlines():
            row.update(json.loads(line))
        end = row.get("end", child.stderr.strip()[-200:])
        cells = [model.stem, end, f"{row.get('time', 0.0):.2f}", row.get("steps"), row.get("missed"), f"{row.get('worst', 0.0):.1e}"]
        cells += [f"{row.get('deepest_mm', 0.0):.6f}", row.get("contacts_max"), f"{row.get('median_us', 0.0) / 1000:.2f}"]
        print("|", " | ".join(map(str, [*cells, row.get("message", "")])), "|", flush=True)


if __name__ == "__main__":
    sys.exit(main())
