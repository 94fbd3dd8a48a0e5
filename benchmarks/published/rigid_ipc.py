"""Writes scenes of rigid-ipc (Ferguson et al., "Intersection-free rigid body dynamics", SIGGRAPH 2021) as MJCF."""

import json
import math

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


def corners(path):
    """Smallest and largest coordinates of a mesh's vertices."""
    lines = (line.split() for line in path.read_text().splitlines())
    vertices = [[float(x) for x in words[1:4]] for words in lines if words and words[0] == "v"]
    return [[extreme(v[k] for v in vertices) for k in range(3)] for extreme in (min, max)]


def scales(part, path):
    """Factors of the mesh along its axes: as they stand, or so that it has the extents asked for."""
    if "dimensions" not in part:
        scale = part.get("scale", 1.0)
        return scale if isinstance(scale, list) else [scale] * 3
    low, high = corners(path)
    return [wanted / (b - a) if wanted else 1.0 for wanted, a, b in zip(part["dimensions"], low, high, strict=True)]


def ground(part):
    """The rectangle of `plane.obj`, the top of a box that reaches as deep below as half of the rectangle's shorter side."""
    x, _, z = (d / 2 for d in part["dimensions"])
    position = list(part.get("position", [0, 0, 0]))
    position[1] -= min(x, z)
    return f'<geom type="box" size="{numbers([x, min(x, z), z])}" pos="{numbers(position)}"/>'


def body(k, part, shape):
    """The element of a body, its actuators with their controls, and its velocity at the beginning. Joints have the world's axes: a body
    that is turned carries its shape turned."""
    position, turn = (numbers(part.get("position", [0, 0, 0])), numbers(quaternion(part.get("rotation", [0, 0, 0]))))
    fixed = part.get("is_dof_fixed", False)
    if part.get("type") == "static" or fixed is True:
        return f'<geom type="{shape}" mesh="m{k}" pos="{position}" quat="{turn}"/>', [], []
    fixed = fixed or [False] * 6
    is_kinematic = part.get("type") == "kinematic"
    velocity = part.get("linear_velocity", [0, 0, 0]) + [math.radians(w) for w in part.get("angular_velocity", [0, 0, 0])]
    load = part.get("force", [0, 0, 0]) + part.get("torque", [0, 0, 0])
    free = [dof for dof in range(6) if not fixed[dof]]
    joints = [f'<joint name="j{k}_{dof}" type="{"slide" if dof < 3 else "hinge"}" axis="{AXES[dof % 3]}"/>' for dof in free]
    drives = []
    for dof in free:
        if is_kinematic and dof >= 3:
            drives.append((f'<velocity joint="j{k}_{dof}" kv="1e9"/>', velocity[dof]))
        elif load[dof] and len(free) < 6:
            drives.append((f'<motor joint="j{k}_{dof}" gear="{load[dof]}"/>', 1.0))
    if len(free) == 6:
        joints = [f'<freejoint name="j{k}"/>']
        drives += [(f'<motor joint="j{k}" gear="{numbers(load)}"/>', 1.0)] * any(load)
    geom = f'<geom type="{shape}" mesh="m{k}" quat="{turn}" density="{part.get("density", 1000)}"/>'
    return f'<body name="b{k}" pos="{position}">{"".join(joints)}{geom}</body>', drives, [velocity[dof] for dof in free]


def convert(fixture, meshes, folder, shape):
    """Writes the MJCF file of a fixture, and its controls beside it; the path. Velocities at the beginning are the keyframe `start`."""
    text = json.loads(fixture.read_text())
    problem = text["rigid_body_problem"]
    assets, bodies, drives, start = [], [], [], []
    for k, part in enumerate(problem["rigid_bodies"]):
        if not part.get("enabled", True):
            continue
        path = meshes / part["mesh"]
        if path.name == "plane.obj":
            bodies.append(ground(part))
            continue
        assets.append(f'<mesh name="m{k}" file="{mesh_file(path, folder)}" scale="{numbers(scales(part, path))}"/>')
        element, own, velocity = body(k, part, shape)
        bodies.append(element)
        drives += own
        start += velocity
    gravity, friction = numbers(problem.get("gravity", [0, 0, 0])), problem.get("coefficient_friction", 0.0)
    mjcf = (
        f'<mujoco model="{fixture.stem}"><option timestep="{text.get("timestep", 0.01)}" gravity="{gravity}"/><size memory="512M"/>'
        f'<default><geom friction="{friction}"/></default><asset>{"".join(assets)}</asset>'
        f'<worldbody>{"".join(bodies)}</worldbody><actuator>{"".join(servo for servo, _ in drives)}</actuator>'
        f'<keyframe><key name="start" qvel="{numbers(start)}"/></keyframe></mujoco>\n'
    )
    out = folder / f"{fixture.parent.name}-{fixture.stem}.xml"
    out.write_text(mjcf.replace("><", ">\n<"))
    out.with_suffix(".control.json").write_text(json.dumps([[control for _, control in drives]]))
    return out
