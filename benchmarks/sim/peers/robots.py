"""The two robots as model files for all engines: links that fixed joints tie together become one, and of the quadruped's shapes the
four feet and the trunk remain. Nothing of the robots is stored in the repository."""

import importlib.util
import os
import pathlib
import sys
import xml.etree.ElementTree as ET

import numpy as np

URDF = "cmeel.prefix/share/example-robot-data/robots/a1_description/urdf/a1.urdf"


def write(scenes, folder):
    """Writes the files that the scenes name into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    source = next(path for path in (os.path.join(p, URDF) for p in sys.path) if os.path.exists(path))
    links = merged_links(ET.parse(source).getroot())
    quadruped = scenes["S6_quadruped"]
    (folder / quadruped["urdf"]).write_text(as_urdf(links))
    (folder / quadruped["mjcf"]).write_text(as_mjcf(links, quadruped))
    write_humanoid(folder / scenes["S7_humanoid"]["mjcf"])


def write_humanoid(path):
    """The humanoid in one file: MuJoCo resolves what it includes. Its joints all have ranges, so that saying in a default that they
    are limited adds nothing, and a limit without a range is not accepted by every loader."""
    import mujoco

    suite = pathlib.Path(importlib.util.find_spec("dm_control").origin).parent / "suite"
    model = mujoco.MjModel.from_xml_path(str(suite / "humanoid.xml"))
    mujoco.mj_saveLastXML(str(path), model)
    path.write_text(path.read_text().replace(' limited="true"', ""))
    again = mujoco.MjModel.from_xml_path(str(path))
    if not np.array_equal(model.jnt_limited, again.jnt_limited):
        raise ValueError("the humanoid has joints with limits but without ranges")


def rotation_of(rpy):
    (cx, cy, cz), (sx, sy, sz) = np.cos(rpy), np.sin(rpy)
    roll = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    pitch = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    return np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]) @ pitch @ roll


def origin(element):
    place = element.find("origin")
    if place is None:
        return np.eye(3), np.zeros(3)
    read = lambda key: np.array(place.get(key, "0 0 0").split(), float)  # noqa: E731
    return rotation_of(read("rpy")), read("xyz")


def mass_of(link):
    """Mass, centre, inertia about the centre in link axes."""
    inertial = link.find("inertial")
    if inertial is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    turn, center = origin(inertial)
    value = {key: float(x) for key, x in inertial.find("inertia").attrib.items()}
    full = np.array([[value["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
    return float(inertial.find("mass").get("value")), center, turn @ full @ turn.T


def shapes_of(link):
    """Spheres (the feet), and the box of the trunk."""
    found = []
    for collision in link.findall("collision"):
        _, at = origin(collision)
        sphere, box = collision.find("geometry/sphere"), collision.find("geometry/box")
        if sphere is not None:
            found.append(("sphere", [float(sphere.get("radius"))], at))
        elif box is not None and link.get("name") in ("trunk", "base"):
            half = [float(x) / 2 for x in box.get("size").split()]
            if max(half) > 0.1:
                found.append(("box", half, at))
    return found


def merged_links(robot):
    """Links in depth-first order, the root first: name, joint, parent, place, axis, mass, center, inertia, shapes."""
    links = {link.get("name"): link for link in robot.findall("link")}
    joints = robot.findall("joint")
    root = (set(links) - {joint.find("child").get("link") for joint in joints}).pop()
    merged = [dict(name=root, joint=None, parent=None, place=np.zeros(3), axis=None, parts=[], shapes=[])]

    def visit(name, turn, at, target):
        mass, center, inertia = mass_of(links[name])
        target["parts"].append((mass, turn @ center + at, turn @ inertia @ turn.T))
        target["shapes"] += [(kind, size, turn @ place + at) for kind, size, place in shapes_of(links[name])]
        for joint in joints:
            if joint.find("parent").get("link") != name:
                continue
            child, (joint_turn, joint_at) = joint.find("child").get("link"), origin(joint)
            joint_at = turn @ joint_at + at
            if joint.get("type") == "fixed":
                visit(child, turn @ joint_turn, joint_at, target)
                continue
            if not np.allclose(turn @ joint_turn, np.eye(3)):
                raise ValueError(f"joint {joint.get('name')} is turned, which is not written")
            axis = np.array(joint.find("axis").get("xyz").split(), float)
            link = dict(name=child, joint=joint.get("name"), parent=target["name"], place=joint_at, axis=axis, parts=[], shapes=[])
            merged.append(link)
            visit(child, np.eye(3), np.zeros(3), link)

    visit(root, np.eye(3), np.zeros(3), merged[0])
    for link in merged:
        parts = link.pop("parts")
        mass = sum(m for m, _, _ in parts)
        center = sum(m * c for m, c, _ in parts) / mass
        inertia = sum(i + m * ((c - center) @ (c - center) * np.eye(3) - np.outer(c - center, c - center)) for m, c, i in parts)
        link.update(mass=mass, center=center, inertia=inertia)
    return merged


def text(values):
    return " ".join(f"{x:.9g}" for x in values)


def as_urdf(links):
    lines = ['<robot name="a1">']
    for link in links:
        entries = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), link["inertia"][np.triu_indices(3)])
        inertia = " ".join(f'{key}="{x:.9g}"' for key, x in entries)
        lines.append(f'<link name="{link["name"]}"><inertial><origin xyz="{text(link["center"])}"/>')
        lines.append(f'<mass value="{link["mass"]:.9g}"/><inertia {inertia}/></inertial>')
        for kind, size, at in link["shapes"]:
            shape = f'sphere radius="{size[0]}"' if kind == "sphere" else f'box size="{text(2 * np.array(size))}"'
            lines.append(f'<collision><origin xyz="{text(at)}"/><geometry><{shape}/></geometry></collision>')
        lines.append("</link>")
    for link in links[1:]:
        lines.append(f'<joint name="{link["joint"]}" type="continuous"><origin xyz="{text(link["place"])}"/>')
        lines.append(f'<parent link="{link["parent"]}"/><child link="{link["name"]}"/><axis xyz="{text(link["axis"])}"/></joint>')
    return "\n".join([*lines, "</robot>\n"])


def as_mjcf(links, scene):
    lines = [
        f'<mujoco model="a1"><compiler angle="radian"/><option timestep="{scene["dt"]}" gravity="{text(scene["gravity"])}"/>',
        f'<default><geom friction="{scene["mu"]} 0 0" condim="3" contype="1" conaffinity="0"/></default><worldbody>',
        '<geom name="floor" type="plane" size="0 0 1" contype="0" conaffinity="1"/>',
    ]

    def emit(link):
        place = link["place"] if link["joint"] else [0, 0, scene["base_height"]]
        lines.append(f'<body name="{link["name"]}" pos="{text(place)}">')
        hinge = f'<joint name="{link["joint"]}" type="hinge" axis="{text(link["axis"])}"/>' if link["joint"] else "<freejoint/>"
        inertia = link["inertia"][[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        lines.append(hinge)
        lines.append(f'<inertial pos="{text(link["center"])}" mass="{link["mass"]:.9g}" fullinertia="{text(inertia)}"/>')
        for kind, size, at in link["shapes"]:
            lines.append(f'<geom type="{kind}" size="{text(size)}" pos="{text(at)}"/>')
        for child in [c for c in links if c["parent"] == link["name"]]:
            emit(child)
        lines.append("</body>")

    emit(links[0])
    return "\n".join([*lines, "</worldbody></mujoco>\n"])
