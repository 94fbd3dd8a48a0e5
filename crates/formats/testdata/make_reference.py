"""Compiles the models of testdata/mjcf with MuJoCo and stores what it made of them.

    python -m venv .venv && .venv/bin/pip install mujoco==4.0.0
    .venv/bin/python crates/formats/testdata/make_reference.py

Written to testdata/reference/NAME.json: masses, inertias, joints, geoms, keyframes, and the pairs of geoms that MuJoCo
lets collide (every geom but planes and height fields is made a huge sphere, so that every admitted pair touches).
"""

import json
import pathlib
import struct
import zlib

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).parent
# An L-shaped prism: not convex, and its hull is known.
OUTLINE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]


def prism():
    vertices = [(x, y, z) for z in (0, 1) for x, y in OUTLINE]
    lid = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in lid] + [(a + 6, b + 6, c + 6) for a, b, c in lid]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    return np.array(vertices, float), np.array(faces)


def write_meshes(folder):
    vertices, faces = prism()
    corners = vertices[faces]
    record = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
    record["corners"] = corners
    header = b"solid but binary".ljust(80) + np.uint32(len(faces)).tobytes()
    (folder / "ell.stl").write_bytes(header + record.tobytes())
    lines = ["solid ell"]
    for face in corners:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {:g} {:g} {:g}".format(*p) for p in face]
        lines += ["endloop", "endfacet"]
    (folder / "ell_text.stl").write_text("\n".join(lines + ["endsolid ell"]) + "\n")
    lines = ["v {:g} {:g} {:g}".format(*p) for p in vertices]
    lines += ["f {} {} {}".format(*(face + 1)) for face in faces]
    (folder / "ell.obj").write_text("\n".join(lines) + "\n")


def write_heights(folder):
    """An image of 5 x 4 colours, and other heights in MuJoCo's own format."""
    rows = [bytes(c for k in range(5) for c in (37 * (k + 2 * row) % 256, 9, 200)) for row in range(4)]
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", 5, 4, 8, 2, 0, 0, 0)
    pixels = zlib.compress(b"".join(b"\0" + row for row in rows))
    image = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    (folder / "hills.png").write_bytes(image)
    heights = np.array([[0, 1, 2, 3], [1, 5, 2, -1], [0.5, 0, 1, 4]], "<f4")
    (folder / "hills.bin").write_bytes(np.array(heights.shape, "<i4").tobytes() + heights.tobytes())


def rotation(quat):
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quat)
    return matrix.reshape(3, 3)


def admitted_pairs(path):
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in spec.geoms:
        if geom.type not in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD):
            geom.type, geom.size, geom.meshname = mujoco.mjtGeom.mjGEOM_SPHERE, [1000, 0, 0], ""
            geom.fromto = [np.nan] * 6
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return sorted({tuple(sorted(map(int, c.geom))) for c in data.contact})


def pair_frictions(model):
    result = []
    for k in range(model.npair):
        friction = 0.0 if model.pair_dim[k] == 1 else float(model.pair_friction[k][0])
        result.append([int(model.pair_geom1[k]), int(model.pair_geom2[k]), friction])
    return result


def mesh_vertices(model, geom):
    """Vertices of a mesh geom in the frame of its body."""
    mesh = model.geom_dataid[geom]
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return []
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    points = model.mesh_vert[start : start + count].astype(float)
    return (points @ rotation(model.geom_quat[geom]).T + model.geom_pos[geom]).tolist()


def reference(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    weightless = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    touching = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
    bodies = []
    for b in range(model.nbody):
        r = rotation(model.body_iquat[b])
        bodies.append({
            "name": model.body(b).name,
            "parent": int(model.body_parentid[b]),
            "pos": model.body_pos[b].tolist(),
            "quat": model.body_quat[b].tolist(),
            "mass": float(model.body_mass[b]),
            "com": model.body_ipos[b].tolist(),
            "inertia": (r @ np.diag(model.body_inertia[b]) @ r.T).tolist(),
        })
    joints = []
    for j in range(model.njnt):
        dof = model.jnt_dofadr[j]
        scalar = model.jnt_type[j] >= 2
        joints.append({
            "name": model.joint(j).name,
            "body": int(model.jnt_bodyid[j]),
            "type": ["free", "ball", "slide", "hinge"][model.jnt_type[j]],
            "axis": model.jnt_axis[j].tolist(),
            "pos": model.jnt_pos[j].tolist(),
            "range": model.jnt_range[j].tolist() if model.jnt_limited[j] and scalar else None,
            "ref": float(model.qpos0[model.jnt_qposadr[j]]) if scalar else 0.0,
            "springref": float(model.qpos_spring[model.jnt_qposadr[j]]) if scalar else 0.0,
            "stiffness": float(model.jnt_stiffness[j]),
            "damping": float(model.dof_damping[dof]),
            "armature": float(model.dof_armature[dof]),
            "frictionloss": float(model.dof_frictionloss[dof]),
        })
    geoms = []
    for g in range(model.ngeom):
        geoms.append({
            "name": model.geom(g).name,
            "body": int(model.geom_bodyid[g]),
            "type": str(mujoco.mjtGeom(model.geom_type[g]).name)[len("mjGEOM_") :].lower(),
            "size": model.geom_size[g].tolist(),
            "pos": model.geom_pos[g].tolist(),
            "rotation": rotation(model.geom_quat[g]).tolist(),
            "friction": float(model.geom_friction[g][0]),
            "condim": int(model.geom_condim[g]),
            "contype": int(model.geom_contype[g]) if touching else 0,
            "conaffinity": int(model.geom_conaffinity[g]) if touching else 0,
            "rgba": model.geom_rgba[g].tolist(),
            "vertices": mesh_vertices(model, g),
        })
    fields = []
    for h in range(model.nhfield):
        data = model.hfield_data[: model.hfield_nrow[h] * model.hfield_ncol[h]] * model.hfield_size[h][2]
        fields.append({"rows": int(model.hfield_nrow[h]), "heights": data.tolist()})
    actuators = []
    for k in range(model.nu):
        limited = lambda flag, values: values.tolist() if flag else None
        actuators.append({
            "name": model.actuator(k).name,
            "joint": int(model.actuator_trnid[k][0]),
            "gear": model.actuator_gear[k].tolist(),
            "gain": model.actuator_gainprm[k][:3].tolist() if model.actuator_gaintype[k] else [float(model.actuator_gainprm[k][0]), 0.0, 0.0],
            "bias": model.actuator_biasprm[k][:3].tolist() if model.actuator_biastype[k] else [0.0] * 3,
            "ctrlrange": limited(model.actuator_ctrllimited[k], model.actuator_ctrlrange[k]),
            "forcerange": limited(model.actuator_forcelimited[k], model.actuator_forcerange[k]),
        })
    sites = []
    for s in range(model.nsite):
        sites.append({
            "body": int(model.site_bodyid[s]),
            "type": str(mujoco.mjtGeom(model.site_type[s]).name)[len("mjGEOM_") :].lower(),
            "size": model.site_size[s].tolist(),
            "pos": model.site_pos[s].tolist(),
            "rotation": rotation(model.site_quat[s]).tolist(),
        })
    tendons = []
    for t in range(model.ntendon):
        first, count = model.tendon_adr[t], model.tendon_num[t]
        wraps = range(first, first + count)
        tendons.append({
            "terms": [[int(model.wrap_objid[w]), float(model.wrap_prm[w])] for w in wraps],
            "spring": [float(model.tendon_stiffness[t]), float(model.tendon_damping[t])],
            "rest": model.tendon_lengthspring[t].tolist(),
            "range": model.tendon_range[t].tolist() if model.tendon_limited[t] else None,
        })
    keys = []
    for k in range(model.nkey):
        keys.append({
            "time": float(model.key_time[k]),
            "qpos": model.key_qpos[k].tolist(),
            "qvel": model.key_qvel[k].tolist(),
            "ctrl": model.key_ctrl[k].tolist(),
        })
    return {
        "mujoco": mujoco.__version__,
        "nq": model.nq,
        "nv": model.nv,
        "timestep": model.opt.timestep,
        "gravity": [0.0] * 3 if weightless else model.opt.gravity.tolist(),
        "qpos0": model.qpos0.tolist(),
        "bodies": bodies,
        "joints": joints,
        "geoms": geoms,
        "height_fields": fields,
        "sites": sites,
        "tendons": tendons,
        "actuators": actuators,
        "keyframes": keys,
        "pairs": pair_frictions(model),
        "admitted": admitted_pairs(path),
    }


def main():
    (HERE / "mjcf" / "meshes").mkdir(exist_ok=True)
    (HERE / "reference").mkdir(exist_ok=True)
    write_meshes(HERE / "mjcf" / "meshes")
    write_heights(HERE / "mjcf" / "meshes")
    for path in sorted((HERE / "mjcf").glob("*.xml")):
        if not path.stem.startswith("included"):
            text = json.dumps(reference(path), indent=1)
            (HERE / "reference" / (path.stem + ".json")).write_text(text + "\n")
            print(path.stem)


if __name__ == "__main__":
    main()
