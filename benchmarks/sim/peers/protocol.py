"""What all peers have in common: scenes, how a run is driven and timed, and what is written down of it.

A peer is a module `NAME_peer.py` with `version()` and a class `Peer(scene, variant)`:

    step()       one time step; the only thing that is timed
    state()      array [bodies, 13]: position, quaternion wxyz, linear velocity, angular velocity, world axes
    contacts()   number of contact points of the last step
    forces()     optional, rows [i, j, point, normal, normal force, tangential force, mu] of the last step: the force (N) acts on
                 body i, the normal points from j to i, -1 is the world. Engines that `curves.py` runs add the gap at the beginning of the
                 step (m, negative in an overlap) and a corner of the polygon that bounds friction where the normal force times mu is one
                 (zeros where friction is bounded by a circle)
    joints()     robots: angles and rates in the order of the scene; torque(values): what the motors give in the next step

    python peers/protocol.py NAME VARIANT SCENE OUT --scenes FILE --cap SECONDS

writes one run as JSON: `step_ns` of every step (CPU time of the thread), `samples` of the state, `contacts` at the samples, and
`snapshots` of some steps: state before, state after, contact forces.
"""

import argparse
import importlib
import json
import math
import os
import sys
import time

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np


def bodies(scene):
    """Kinds, half-sizes [n, 3], masses [n], positions [n, 3], quaternions wxyz [n, 4]."""
    rows = scene["bodies"]
    numbers = np.array([row[1:] for row in rows], float)
    return [row[0] for row in rows], numbers[:, :3], numbers[:, 3], numbers[:, 4:7], numbers[:, 7:11]


def inertia(kind, size, mass):
    """Principal moments of a uniform box (half-sizes) or ball (radius first)."""
    squares = np.asarray(size, float) ** 2
    return mass / 3 * (squares.sum() - squares) if kind == "b" else np.full(3, 0.4 * mass * squares[0])


def rotation(q):
    """Matrix of a unit quaternion wxyz."""
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])


def relative(q, p):
    """Quaternion of q seen from p: p⁻¹ q."""
    (a, b, c, d), (w, x, y, z) = (p[0], -p[1], -p[2], -p[3]), q
    return np.array([
        a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w,
    ])


def joint_of(scene):
    """Body → the joint that hangs it on its parent."""
    return {joint["b"]: joint for joint in scene["joints"]}


def velocities(scene):
    """Linear and angular velocities at the beginning, world axes [n, 6]; zero where the scene has none."""
    return np.array(scene.get("velocities") or np.zeros((len(scene["bodies"]), 6)), float)


def row(i, j, point, normal, force, mu, gap=None, corner=()):
    """A row of `forces()` from the total force on i."""
    normal, force = np.asarray(normal, float), np.asarray(force, float)
    along = float(force @ normal)
    more = [] if gap is None else [float(gap), *map(float, corner)]
    return [int(i), int(j), *map(float, point), *map(float, normal), along, *map(float, force - along * normal), float(mu), *more]


def motor_targets(scene, t):
    """Joint angles that the robot's controller wants at time t: the stance, then a trot in place."""
    trot, angles = scene["trot"], np.tile(np.array(scene["stance"], float), 4)
    if t >= trot["start"]:
        wave = math.sin(2 * math.pi * trot["hz"] * (t - trot["start"]))
        for leg, name in enumerate(("FL", "FR", "RL", "RR")):
            lift = max(0.0, wave if name in trot["phase_on"] else -wave)
            angles[3 * leg : 3 * leg + 3] += lift * np.array(trot["lift"])
    return angles


def control(scene, peer, t):
    """Joint PD with limited torque, computed outside the timed step."""
    angles, rates = peer.joints()
    torque = scene["kp"] * (motor_targets(scene, t) - angles) - scene["kd"] * rates
    peer.torque(np.clip(torque, -scene["tau_max"], scene["tau_max"]))


def is_snapshot(step, steps):
    """Steps of which the forces are written down: four spread over the run and the last three."""
    return step >= steps - 3 or (steps > 20 and step % (steps // 4) == steps // 8)


def drive(peer, scene, cap):
    """Runs a scene until its end or until `cap` seconds of CPU time are used up."""
    dt, steps = scene["dt"], round(scene["duration"] / scene["dt"])
    every = scene.get("sample_every", 50)
    run = dict(dt=dt, planned=steps, done=0, error=None, step_ns=[], snapshots=[])
    run["samples"], run["contacts"] = [[0.0, peer.state().tolist()]], [0]
    begin = time.process_time()
    for k in range(steps):
        if "kp" in scene:
            control(scene, peer, k * dt)
        snapshot = hasattr(peer, "forces") and "bodies" in scene and is_snapshot(k, steps)
        before = peer.state().tolist() if snapshot else None
        start = time.thread_time_ns()
        try:
            peer.step()
        except Exception as error:  # noqa: BLE001
            run["error"] = str(error)[:300]  # an engine that gives up has failed the scene
            break
        run["step_ns"].append(time.thread_time_ns() - start)
        run["done"] = k + 1
        late = time.process_time() - begin > cap
        if snapshot:
            after = peer.state().tolist()
            run["snapshots"].append(dict(t=(k + 1) * dt, before=before, after=after, forces=peer.forces()))
        if late or (k + 1) % every == 0 or k + 1 == steps:
            state = peer.state()
            run["samples"].append([(k + 1) * dt, state.tolist()])
            run["contacts"].append(int(peer.contacts()))
            if not np.isfinite(state).all():
                run["error"] = "a state that is not finite"
                break
        if late:
            break
    return run


def main():
    options = argparse.ArgumentParser()
    for name in ("peer", "variant", "scene", "out", "--scenes", "--robots"):
        options.add_argument(name)
    options.add_argument("--cap", type=float, default=10.0)
    options = options.parse_args()
    with open(options.scenes) as file:
        scene = json.load(file)[options.scene]
    scene["robots"] = options.robots
    module = importlib.import_module(options.peer + "_peer")
    head = dict(engine=options.peer, variant=options.variant, version=module.version(), scene=options.scene)
    run = drive(module.Peer(scene, options.variant), scene, options.cap)
    with open(options.out, "w") as file:
        json.dump(head | run, file, allow_nan=True)


if __name__ == "__main__":
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    sys.modules["protocol"] = sys.modules["__main__"]
    main()
