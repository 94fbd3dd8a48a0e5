"""Turns runs into results. Accuracy is computed here, for every engine by the same code, from the states and forces that it reported.

`judge_all(raw, scenes, out, machine)` reads all runs and writes one JSON file per scene. Lengths in the results are in millimetres.
"""

import itertools
import json
import math
import pathlib
import statistics
import sys

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(pathlib.Path(__file__).parent / "peers"))
from protocol import bodies, inertia, rotation  # noqa: E402

# A body that dropped or drifted by this part of the first body's height has fallen.
STANDING = 0.3
MM = 1e3


def rotations(q):
    return np.array([rotation(row) for row in q / np.linalg.norm(q, axis=1)[:, None]])


class Judge:
    """What is known of a scene: its shapes, masses and laws."""

    def __init__(self, name, scene):
        self.name, self.scene = name, scene
        self.kind, self.size, self.mass, _, _ = bodies(scene)
        self.is_box = np.array(self.kind) == "b"
        self.moments = np.array([inertia(*row) for row in zip(self.kind, self.size, self.mass)])
        self.gravity = np.array(scene["gravity"], float)

    def energy(self, state):
        """Kinetic and potential energy, J."""
        spin = np.einsum("bij,bi->bj", rotations(state[:, 3:7]), state[:, 10:13])
        kinetic = 0.5 * (self.mass * (state[:, 7:10] ** 2).sum(1)).sum() + 0.5 * (self.moments * spin**2).sum()
        return float(kinetic), float(-(self.mass[:, None] * state[:, :3] @ self.gravity).sum())

    def penetrations(self, state):
        """Depth of every overlap of two shapes, m: exact, for boxes by the 15 separating axes."""
        turn, at, depths = rotations(state[:, 3:7]), state[:, :3], [np.zeros(0)]
        for plane in self.scene["planes"]:
            normal = np.array(plane[:3], float)
            extent = (np.abs(np.einsum("bij,i->bj", turn, normal)) * self.size).sum(1)
            depths.append(np.where(self.is_box, extent, self.size[:, 0]) + plane[3] - at @ normal)
        if self.scene["collide"] and len(at) > 1:
            radius = np.where(self.is_box, np.linalg.norm(self.size, axis=1), self.size[:, 0])
            pairs = cKDTree(at).query_pairs(2 * radius.max(), output_type="ndarray")
            if len(pairs):
                depths.append(self.pair_depths(turn, at, radius, *pairs.T))
        depths = np.concatenate(depths)
        return depths[depths > 0]

    def pair_depths(self, turn, at, radius, a, b):
        between = at[b] - at[a]
        distance = np.linalg.norm(between, axis=1)
        depth = np.where(~self.is_box[a] & ~self.is_box[b], radius[a] + radius[b] - distance, 0.0)
        near = self.is_box[a] & self.is_box[b] & (distance < radius[a] + radius[b])
        a, b, between = a[near], b[near], between[near]
        least = np.full(len(a), np.inf)
        faces = [turn[k][:, :, axis] for k in (a, b) for axis in range(3)]
        edges = [np.cross(turn[a][:, :, i], turn[b][:, :, j]) for i, j in itertools.product(range(3), range(3))]
        for axis in faces + edges:
            length = np.linalg.norm(axis, axis=1)
            unit = axis / np.where(length > 1e-6, length, 1.0)[:, None]
            reach = sum((np.abs(np.einsum("nij,ni->nj", turn[k], unit)) * self.size[k]).sum(1) for k in (a, b))
            overlap = reach - np.abs((between * unit).sum(1))
            least = np.where(length > 1e-6, np.minimum(least, overlap), least)
        depth[near] = least
        return depth

    def laws(self, snapshot):
        """How far one step is from the hard laws of contact at the velocity after it, with every contact's share of the largest normal
        force as its weight: `signorini` |v_n| (mm/s), `dissipation` μ f_n |v_t| + f_t·v_t over the largest μ f_n (mm/s: zero iff slip is
        opposed by the full friction and what sticks does not slip), `cone` (|f_t| − μ f_n)⁺ over the same. `momentum`: whether the
        reported forces explain the step at all, as a part of the gravity impulse."""
        before, after, rows = (np.array(snapshot[key], float) for key in ("before", "after", "forces"))
        if len(rows) == 0 or rows[:, 8].max() <= 0 or not np.isfinite(rows).all():
            return None
        i, j = rows[:, 0].astype(int), rows[:, 1].astype(int)
        point, normal, normal_force, tangential, mu = rows[:, 2:5], rows[:, 5:8], rows[:, 8], rows[:, 9:12], rows[:, 12]

        def velocity(k):
            v = after[k, 7:10] + np.cross(after[k, 10:13], point - before[k, :3])
            v[k < 0] = 0
            return v

        slip = velocity(i) - velocity(j)
        along = (slip * normal).sum(1)
        slip = slip - along[:, None] * normal
        largest = normal_force.max()
        bound = mu.max() * largest
        excess = np.maximum(0, np.linalg.norm(tangential, axis=1) - mu * normal_force)
        power = mu * normal_force * np.linalg.norm(slip, axis=1) + (tangential * slip).sum(1)
        laws = dict(signorini=np.abs(normal_force / largest * along).max() * MM, dissipation=np.abs(power).max() / bound * MM)
        laws["cone"] = excess.max() / bound
        if not self.scene["joints"]:
            force, dt = np.zeros((len(self.mass), 3)), self.scene["dt"]
            total = normal_force[:, None] * normal + tangential
            np.add.at(force, i[i >= 0], total[i >= 0])
            np.add.at(force, j[j >= 0], -total[j >= 0])
            gap = after[:, 7:10] - before[:, 7:10] - dt * self.gravity - dt * force / self.mass[:, None]
            laws["momentum"] = np.abs(gap).max() / (np.linalg.norm(self.gravity) * dt)
        return {key: float(value) for key, value in laws.items()}

    def judge(self, run):
        """All figures of one run."""
        times = np.array([t for t, _ in run["samples"]])
        states = [np.array(state, float) for _, state in run["samples"]]
        if not all(np.isfinite(state).all() for state in states):
            return dict(failed="a state that is not finite")
        result = self.common(states) | self.special(times, states)
        laws = [found for found in map(self.laws, run["snapshots"]) if found]
        if laws:
            result["laws"] = {key: max(row[key] for row in laws) for key in laws[0]} | dict(snapshots=len(laws))
        return result

    def common(self, states):
        depths = [self.penetrations(state) for state in states[1:]]
        depths = [d if len(d) else np.zeros(1) for d in depths] or [np.zeros(1)]
        energies = [self.energy(state) for state in states]
        total = [sum(energy) for energy in energies]
        moved = states[-1][:, :3] - states[0][:, :3]
        last = depths[-1][depths[-1] > 1e-6]
        return dict(
            penetration_max_mm=float(max(d.max() for d in depths)) * MM,
            penetration_end_mean_mm=float(last.mean()) * MM if len(last) else 0.0,
            penetration_end_max_mm=float(depths[-1].max()) * MM,
            drop_mm=max(0.0, float(-moved[:, 2].min())) * MM,
            drift_mm=float(np.linalg.norm(moved[:, :2], axis=1).max()) * MM,
            kinetic_end_J=energies[-1][0],
            energy_gain_J=max(total) - total[0],
            energy_deviation_J=max(abs(e - total[0]) for e in total),
            kinetic_max_J=max(energy[0] for energy in energies),
        )

    def special(self, times, states):
        """What a scene is about."""
        first, last, name, scene = states[0], states[-1], self.name, self.scene
        if name == "S1_slide":
            steps = round(times[-1] / scene["dt"])
            slope = self.gravity[0] - scene["mu"] * abs(self.gravity[2])
            exact = slope * scene["dt"] ** 2 * steps * (steps + 1) / 2
            hop = max(state[0, 2] for state in states) - first[0, 2]
            return dict(slide_error_percent=100 * ((last[0, 0] - first[0, 0]) / exact - 1), hop_mm=float(hop) * MM)
        if name == "S1_stick":
            return dict(creep_mm_s=rate(times, [state[0, 0] for state in states], 2.0))
        if name.startswith(("S2", "S3", "S8", "S9", "S13")):
            moved, height = last[:, :3] - first[:, :3], 2 * scene["bodies"][0][3]
            return dict(stands=bool(max(-moved[:, 2].min(), np.linalg.norm(moved[:, :2], axis=1).max()) < STANDING * height))
        if name.startswith(("S4", "S5")):
            width = max(abs(plane[3]) for plane in scene["planes"])
            return dict(lost=int(((np.abs(last[:, :2]).max(1) > width) | (last[:, 2] < 0)).sum()))
        if name.startswith("S10"):
            return dict(gap_mm=max(self.joint_gap(first, state) for state in states) * MM)
        if name == "S12_gripper":
            heights = [state[0, 2] - 0.5 * (state[1, 2] + state[2, 2]) for state in states]
            return dict(slip_mm_s=-rate(times, heights, 1.0), held=bool(abs(heights[-1] - heights[0]) < 0.02))
        return {}

    def joint_gap(self, first, state):
        """Largest distance between a joint's anchors on its two bodies, m."""
        turn, start, gap = rotations(state[:, 3:7]), rotations(first[:, 3:7]), 0.0
        for joint in self.scene["joints"]:
            anchor = np.array(joint["anchor"], float)
            ends = [anchor if k < 0 else state[k, :3] + turn[k] @ start[k].T @ (anchor - first[k, :3]) for k in (joint["a"], joint["b"])]
            gap = max(gap, float(np.linalg.norm(ends[0] - ends[1])))
        return gap


def rate(times, values, begin):
    """Mean rate from time `begin` to the end, mm/s; absent if the run ended before."""
    k = int(np.searchsorted(times, begin - 1e-9))
    return float((values[-1] - values[k]) / (times[-1] - times[k])) * MM if k < len(times) - 1 else None


def judge_robot(scene, run):
    states = [np.array(state, float) for _, state in run["samples"]]
    if not all(np.isfinite(state).all() for state in states):
        return dict(failed="a state that is not finite")
    drift = np.linalg.norm(states[-1][0, :2] - states[0][0, :2])
    return dict(height_end_m=float(states[-1][0, 2]), drift_m=float(drift))


def step_time(run):
    """Median CPU time of a step over the last quarter of the steps, µs."""
    times = run["step_ns"][len(run["step_ns"]) * 3 // 4 :]
    return statistics.median(times) / 1e3 if times else None


def judge_group(name, scene, runs):
    """One row: accuracy from the first repetition (all engines are deterministic), time from all."""
    run = runs[0]
    row = {key: run.get(key) for key in ("engine", "variant", "version", "done", "planned", "error")}
    for key in ("tolerance", "missed", "clipped", "contacts_max", "complaints"):
        if key in run:
            row[key] = run[key]
    if run.get("certificates"):
        residuals = [math.inf if r is None else r for r in run["certificates"]]  # JSON has no infinity
        row["certificate_worst"], row["certificate_median"] = max(residuals), statistics.median(residuals)
    times = [t for t in map(step_time, runs) if t is not None]
    if not times:
        return row | dict(failed=run.get("error") or "no step was made")
    row |= dict(us_step=statistics.median(times), us_repetitions=times, us_worst=max(run["step_ns"]) / 1e3)
    row |= dict(us_mean=statistics.fmean(run["step_ns"]) / 1e3, contacts=run["contacts"][-1], t_end=run["samples"][-1][0])
    return row | (judge_robot(scene, run) if "bodies" not in scene else Judge(name, scene).judge(run))


def strict(value):
    """The value with `null` for what JSON has no number for."""
    if isinstance(value, dict):
        return {key: strict(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [strict(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def judge_all(raw, scenes, out, machine):
    out.mkdir(exist_ok=True)
    for name, scene in scenes.items():
        groups = {}
        for path in sorted(raw.glob(f"{name}__*.json")):
            run = json.loads(path.read_text())
            groups.setdefault((run["engine"], run["variant"]), []).append(run)
        if groups:
            rows = [judge_group(name, scene, runs) for runs in groups.values()]
            result = dict(scene=name, what=scene["what"], dt=scene["dt"], duration=scene["duration"], machine=machine, rows=rows)
            (out / f"{name}.json").write_text(json.dumps(strict(result), indent=1) + "\n")
