"""How far a step of any engine is from a solution of rigid contact with friction: one number, from its states and forces alone.

A step takes velocities v to v⁺ with the impulses that the engine reports at its own contact points. Each contact has a normal n, a gap φ at
the beginning of the step (negative in an overlap), the relative velocity u of its bodies at v⁺ in that place, the impulse p on the body that n
points to, and the coefficient μ; g is the mean of the diagonal of its Delassus block J M⁻¹ Jᵀ, the velocity that an impulse of one makes. Then
the residual of the contact is the largest of these, in m/s:

- normal: how much quicker than φ/Δt open gaps close, or overlaps become deeper; `min(u_n − c, g p_n)` where bodies separate at more than c, the
  speed that closes an overlap within the step (0 where there is none), and are pushed nevertheless; `g |p_n|` where they are pulled.
  Between the two any impulse is right: engines are free to push overlaps out soon, late or never, and to stop a body at any time of the step;
- friction: `g |p_t − P(p_t − u_t / g)|` with P the projection onto what the engine bounds friction by (`BOUNDS`) times μ p_n: zero iff friction is
  within its bound, nothing slips that could be held, and slip is opposed as much as the bound permits. Each engine has its own bound, so that what is measured
  is how well it solved its step and not which polygon it took for Coulomb's circle.

And the residual of a body is what the impulses do not explain of its change of momentum, |v⁺ − v − Δt g − Σp/m|. (Of the angular momentum nothing
is asked: engines integrate what gyroscopes do in different ways.)

The residual of a step is the largest of all, and beside it the root mean square over the contacts that press or have a residual, over the velocity scale: the largest
speed of a body at the beginning of the scene and what gravity adds to it in a step. Overlaps are no part of it; `judge.py` measures them.
"""

import numpy as np

from judge import rotations

# Corners of the polygon that bounds friction where the rows of the forces have one; where they have none it is a circle.
BOUNDS = {"signorini": 8, "mujoco": 4, "bullet": 4, "ode": 4, "rapier": 4}


def velocity_scale(scene):
    """The largest speed of a body's centre at the beginning and what gravity adds to it in a step, m/s."""
    speeds = np.linalg.norm(np.array(scene["velocities"], float)[:, :3], axis=1)
    return float(speeds.max() + np.linalg.norm(scene["gravity"]) * scene["dt"])


def onto_circle(points, radius):
    """Planar points [n, 2] onto circles around the origin."""
    length = np.linalg.norm(points, axis=1)
    return points * np.where(length > radius, radius / np.maximum(length, 1e-300), 1.0)[:, None]


def onto_polygon(points, radius, corners):
    """Planar points [n, 2] onto regular polygons around the origin with this circumradius and their first corner on the first axis."""
    sector = 2 * np.pi / corners
    turn = (np.floor(np.arctan2(points[:, 1], points[:, 0]) / sector) + 0.5) * sector
    out, along = np.stack([np.cos(turn), np.sin(turn)], axis=1), np.stack([-np.sin(turn), np.cos(turn)], axis=1)
    half = radius * np.sin(sector / 2)
    beyond = (points * out).sum(1) - radius * np.cos(sector / 2)
    edge = (points - beyond[:, None] * out) + (np.clip((points * along).sum(1), -half, half) - (points * along).sum(1))[:, None] * along
    return np.where((beyond > 0)[:, None], edge, points)


class Step:
    """One step of an engine: the relative velocities, impulses and gains of its contacts."""

    def __init__(self, judge, snapshot):
        before, after, rows = (np.array(snapshot[key], float) for key in ("before", "after", "forces"))
        rows = rows.reshape(-1, 17)
        self.judge, self.before, self.after, self.dt = judge, before, after, judge.scene["dt"]
        self.bodies = rows[:, 0].astype(int), rows[:, 1].astype(int)
        self.point, self.normal, self.friction, self.gap = rows[:, 2:5], rows[:, 5:8], rows[:, 12], rows[:, 13]
        self.p_n, self.p_t, self.corner = self.dt * rows[:, 8], self.dt * rows[:, 9:12], rows[:, 14:17]
        i, j = self.bodies
        u = self.velocity(i) - self.velocity(j)
        self.u_n = (u * self.normal).sum(1)
        self.u_t = u - self.u_n[:, None] * self.normal
        self.gain = self.mobility(i) + self.mobility(j)

    def arm(self, k):
        return self.point - self.before[k, :3]

    def velocity(self, k):
        """Velocity after the step of the bodies `k` at the contact points; −1 is the world."""
        return np.where((k >= 0)[:, None], self.after[k, 7:10] + np.cross(self.after[k, 10:13], self.arm(k)), 0.0)

    def mobility(self, k):
        """Mean over the directions of the velocity that an impulse of one gives the bodies at the contact points."""
        turn, arm = rotations(self.before[k, 3:7]), self.arm(k)
        local = np.einsum("nij,ni->nj", turn, arm) ** 2
        inverse = 1 / self.judge.moments[k]
        turning = (local.sum(1)[:, None] * inverse - local * inverse).sum(1)
        return np.where(k >= 0, 1 / self.judge.mass[k] + turning / 3, 0.0)

    def normal_residuals(self):
        closing, opening = np.maximum(self.gap, 0) / self.dt, np.maximum(-self.gap, 0) / self.dt
        pushed = np.minimum(self.u_n - opening, self.gain * self.p_n)
        return np.maximum.reduce([-closing - self.u_n, pushed, -self.gain * self.p_n, np.zeros(len(self.u_n))])

    def friction_residuals(self, corners):
        """With a polygon of so many corners where the contact has a first one, else with a circle; with circles alone where it is 0."""
        reach = np.linalg.norm(self.corner, axis=1)
        across = np.where((reach > 0)[:, None], self.corner, np.cross(self.normal, [0.3, 0.5, 0.8]))
        first = across / np.linalg.norm(across, axis=1)[:, None]
        second = np.cross(self.normal, first)

        def planar(vectors):
            return np.stack([(vectors * first).sum(1), (vectors * second).sum(1)], axis=1)

        most, tried = self.friction * np.maximum(self.p_n, 0), planar(self.p_t - self.u_t / self.gain[:, None])
        found = onto_circle(tried, most)
        if corners:
            found = np.where((reach > 0)[:, None], onto_polygon(tried, reach * most, corners), found)
        return self.gain * np.linalg.norm(planar(self.p_t) - found, axis=1)

    def momentum_residuals(self):
        """What the impulses do not explain of every body's velocity, m/s."""
        (i, j), total = self.bodies, self.p_n[:, None] * self.normal + self.p_t
        impulse = np.zeros((len(self.judge.mass), 3))
        np.add.at(impulse, i[i >= 0], total[i >= 0])
        np.add.at(impulse, j[j >= 0], -total[j >= 0])
        left = self.after[:, 7:10] - self.before[:, 7:10] - self.dt * self.judge.gravity - impulse / self.judge.mass[:, None]
        return np.linalg.norm(left, axis=1)


def residuals(judge, snapshot, corners, scale):
    """The residual of a step: `worst`, `rms`, the worst of its parts, and the worst with Coulomb's circle as everyone's bound, in units of
    the velocity scale; and the contacts that press or have one."""
    step = Step(judge, snapshot)
    normal, friction, momentum = step.normal_residuals(), step.friction_residuals(corners), step.momentum_residuals()
    contact = np.maximum(normal, friction)
    active = contact[(step.p_n > 0) | (contact > 0)]
    largest = [float(part.max(initial=0.0)) / scale for part in (normal, friction, momentum)]
    result = dict(zip(("normal", "friction", "momentum"), largest), worst=max(largest), active=len(active))
    result["rms"] = float(np.sqrt(((active**2).sum() + (momentum**2).sum()) / max(1, len(active) + len(momentum)))) / scale
    result["circle"] = max(largest[0], float(step.friction_residuals(0).max(initial=0.0)) / scale, largest[2])
    return result
