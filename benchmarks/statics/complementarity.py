"""Loads at which walls of blocks balance and may begin to move, by a program with complementarity constraints.

    python benchmarks/statics/complementarity.py --wall 1 --starts 20

M. C. Ferris and F. Tin-Loi (Int. J. Mech. Sci. 43, 2001) ask for the least horizontal share α of the weights at which forces within the friction
cones balance the loads and a mechanism exists that obeys Coulomb's law with them: contacts that open bear nothing, those that slip have all
their friction, against the slip and without dilatancy. Here the products of that law are penalised, the program is solved from the
associated limit with forces picked at random by linear programs of its tangents (HiGHS), and what it ends with is taken as modes: with these
held, one more linear program has forces and mechanism exactly. What is printed is a load that satisfies all conditions; that none is smaller is not proved.
"""

import argparse

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import bmat, coo_array, csr_array, eye_array, vstack

HALVES, WHOLE = [0.5, 1, 1, 1, 1, 0.5], [1] * 5
FOUR, SHIFTED = [1] * 4, [0.5, 1, 1, 1, 0.5]
WINDOW, WINDOW_SHIFTED = [0.5, 1, -1, 1, 0.5], [1, 0.5, -1, 0.5, 1]
WINDOWS, WINDOWS_SHIFTED = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
# Courses from below: lengths of blocks in units of a whole one, negative where there is an opening.
WALLS = {
    1: [HALVES, WHOLE] * 3,
    2: [HALVES, WHOLE] * 5,
    3: [FOUR, SHIFTED, FOUR, WINDOW, WINDOW_SHIFTED, WINDOW, WINDOW_SHIFTED, WINDOW, FOUR, SHIFTED, FOUR],
    4: [HALVES, WHOLE, HALVES, WINDOWS, WINDOWS_SHIFTED, WINDOWS, WINDOWS_SHIFTED, WINDOWS, HALVES, WHOLE, HALVES],
}
SIZE, FRICTION = (0.4, 0.175), 0.65


def blocks_of(courses):
    """Left, right, lower and upper end of every block."""
    blocks = []
    for layer, course in enumerate(courses):
        x = 0.0
        for part in course:
            width = SIZE[0] * abs(part)
            if part > 0:
                blocks.append((x, x + width, layer * SIZE[1], (layer + 1) * SIZE[1]))
            x += width
    return blocks


def contacts_of(blocks, near=1e-9):
    """Ends of all faces that touch: upper and lower (or right and left) block, -1 for the ground, place and whether the normal is vertical."""
    points = []
    for i, b in enumerate(blocks):
        if b[2] < near:
            points += [(i, -1, x, 0.0, True) for x in b[:2]]
        for j, c in enumerate(blocks):
            low, high = max(b[0], c[0]), min(b[1], c[1])
            if abs(b[2] - c[3]) < near and high - low > near:
                points += [(i, j, x, b[2], True) for x in (low, high)]
            low, high = max(b[2], c[2]), min(b[3], c[3])
            if abs(b[0] - c[1]) < near and high - low > near:
                points += [(i, j, b[0], z, False) for z in (low, high)]
    return points


class Program:
    """Variables: normal forces n, tangential forces t, the load α, the blocks' velocities v, slips forwards and backwards."""

    def __init__(self, courses):
        blocks = blocks_of(courses)
        points = contacts_of(blocks)
        self.count, self.free = len(points), 3 * len(blocks)
        self.jacobians = [self._rows(blocks, points, along) for along in (0, 1)]
        areas = np.array([(b[1] - b[0]) * (b[3] - b[2]) for b in blocks])
        weights = areas / areas.mean()
        self.own, self.load = np.zeros(self.free), np.zeros(self.free)
        self.own[1::3], self.load[0::3] = -weights, weights
        self.sizes = [self.count, self.count, 1, self.free, self.count, self.count]
        self.ends = np.cumsum([0, *self.sizes])
        normal, tangential = self.jacobians
        one = eye_array(self.count)
        self.equal = vstack([
            self._row(self.free, n=normal.T, t=tangential.T, alpha=csr_array(self.load[:, None])),
            self._row(1, v=csr_array(self.load[None, :])),
            self._row(self.count, v=tangential, forwards=-one, backwards=one),
        ], format="csr")
        self.equal_to = np.r_[-self.own, 1, np.zeros(self.count)]
        self.below = vstack([self._row(self.count, t=one, n=-FRICTION * one), self._row(self.count, t=-one, n=-FRICTION * one),
                             self._row(self.count, v=-normal)], format="csr")

    def _rows(self, blocks, points, along):
        entries = []
        for row, (i, j, x, z, is_vertical) in enumerate(points):
            # The tangent of a normal (0, 1) is (1, 0), that of (1, 0) is (0, -1).
            dx, dz = ((0, 1) if is_vertical else (1, 0)) if along == 0 else ((1, 0) if is_vertical else (0, -1))
            for block, sign in ((i, 1), (j, -1)):
                if block >= 0:
                    left, right, low, high = blocks[block]
                    rx, rz = x - 0.5 * (left + right), z - 0.5 * (low + high)
                    entries += [(row, 3 * block + k, sign * e) for k, e in enumerate((dx, dz, rx * dz - rz * dx))]
        rows, columns, values = zip(*entries, strict=True)
        return csr_array(coo_array((values, (rows, columns)), shape=(self.count, self.free)))

    def _row(self, height, **parts):
        names = ("n", "t", "alpha", "v", "forwards", "backwards")
        blocks = [parts.get(name, csr_array((height, size))) for name, size in zip(names, self.sizes, strict=True)]
        return bmat([blocks], format="csr")

    def split(self, x):
        return [x[a:b] for a, b in zip(self.ends, self.ends[1:], strict=False)]

    def bounds(self):
        low, high = np.full(self.ends[-1], -np.inf), np.full(self.ends[-1], np.inf)
        low[:self.ends[1]], low[self.ends[4]:] = 0, 0
        return low, high

    def minimum(self, cost, low, high, rows=()):
        equal = vstack([self.equal, *rows], format="csr")
        right = np.r_[self.equal_to, np.zeros(equal.shape[0] - len(self.equal_to))]
        solved = linprog(cost, A_ub=self.below, b_ub=np.zeros(self.below.shape[0]), A_eq=equal, b_eq=right, bounds=np.c_[low, high])
        return solved.x if solved.status == 0 else None

    def associated(self, cost):
        """The associated limit with its mechanism; a cost of the normal forces picks among the forces, and may lower the load."""
        one, normal, tangential = eye_array(self.count), *self.jacobians
        equal = bmat([[normal.T, tangential.T, csr_array(self.load[:, None])]], format="csr")
        below = bmat([[-FRICTION * one, one, csr_array((self.count, 1))], [-FRICTION * one, -one, csr_array((self.count, 1))]], format="csr")
        cost = np.r_[cost, np.zeros(self.count), -1]
        bounds = [(0, None)] * self.count + [(None, None)] * (self.count + 1)
        solved = linprog(cost, A_ub=below, b_ub=np.zeros(2 * self.count), A_eq=equal, b_eq=-self.own, bounds=bounds)
        motion = solved.eqlin.marginals / (self.load @ solved.eqlin.marginals)
        slip = tangential @ motion
        return np.r_[solved.x, motion, np.maximum(slip, 0), np.maximum(-slip, 0)]

    def products(self, x):
        n, t, _, v, forwards, backwards = self.split(x)
        return n @ (self.jacobians[0] @ v) + forwards @ (t + FRICTION * n) + backwards @ (FRICTION * n - t)

    def gradient(self, x):
        n, t, _, v, forwards, backwards = self.split(x)
        normal = self.jacobians[0]
        return np.r_[normal @ v + FRICTION * (forwards + backwards), forwards - backwards, 0, normal.T @ n, t + FRICTION * n, FRICTION * n - t]

    def descend(self, x, penalty, radius=1.0):
        """A local minimum of α + penalty · products, by linear programs within a box."""
        low, high = self.bounds()
        box = np.repeat([5.0, 5.0, 1.0, 0.05, 0.05, 0.05], self.sizes)
        value = lambda x: x[self.ends[2]] + penalty * self.products(x)
        for _ in range(60):
            gradient = penalty * self.gradient(x)
            gradient[self.ends[2]] += 1
            tried = self.minimum(gradient, np.maximum(low, x - radius * box), np.minimum(high, x + radius * box))
            expected = 0.0 if tried is None else gradient @ (x - tried)
            if tried is not None and expected < 1e-10 or radius < 1e-6:
                break
            gained = -1.0 if tried is None else value(x) - value(tried)
            if gained > 0:
                x, radius = tried, min(radius * (2 if gained > 0.7 * expected else 1), 10)
            else:
                radius *= 0.4
        return x

    def with_modes(self, x, slips):
        """The least load with the modes of a point: which contacts open, stick and slip; slower slips count as none."""
        n, _, _, v, forwards, backwards = self.split(x)
        low, high = self.bounds()
        opening, fastest = self.jacobians[0] @ v, max(forwards.max(), backwards.max())
        open_ = opening / opening.max() > n / n.max()
        ahead = ~open_ & (forwards >= backwards) & (forwards > slips * fastest)
        behind = ~open_ & ~ahead & (backwards > slips * fastest)
        high[:self.count][open_] = 0
        high[self.ends[4]:self.ends[5]][~open_ & ~ahead] = 0
        high[self.ends[5]:][~open_ & ~behind] = 0
        one = csr_array(eye_array(self.count))
        rows = [self._row(int((~open_).sum()), v=self.jacobians[0][~open_]),
                self._row(int(ahead.sum()), n=FRICTION * one[ahead], t=one[ahead]),
                self._row(int(behind.sum()), n=FRICTION * one[behind], t=-one[behind])]
        cost = np.zeros(self.ends[-1])
        cost[self.ends[2]] = 1
        found = self.minimum(cost, low, high, rows)
        if found is None or self.products(found) > 1e-9:
            return np.inf
        return found[self.ends[2]]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--wall", type=int, choices=sorted(WALLS), default=1)
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    program, rng = Program(WALLS[arguments.wall]), np.random.default_rng(arguments.seed)
    limit = program.associated(np.zeros(program.count))[program.ends[2]]
    print(f"wall {arguments.wall}: {program.free // 3} blocks, {program.count // 2} faces, associated limit {limit:.6f}", flush=True)
    least = np.inf
    for start in range(arguments.starts):
        x = program.associated(rng.random(program.count) * 10 ** rng.uniform(-4, -1))
        for penalty in (1.0, 10.0, 100.0):
            x = program.descend(x, penalty)
        load = min(program.with_modes(x, slips) for slips in (1e-8, 1e-6, 1e-4, 1e-3))
        if load < least - 1e-9:
            least = load
            print(f"  start {start}: balance and mechanism at {least:.8f}", flush=True)


if __name__ == "__main__":
    main()
