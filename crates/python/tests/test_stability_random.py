"""Verdicts on random stacks against another solver of linear programs, and against exact arithmetic.

`SIGNORINI_STACKS=50000 SIGNORINI_EXACT=2000 SIGNORINI_SEED=1 python -m pytest -s` asks for more of them.
"""

import collections
import os
from fractions import Fraction

import numpy as np
import pytest

import signorini

STACKS = int(os.environ.get("SIGNORINI_STACKS", 150))
EXACT = int(os.environ.get("SIGNORINI_EXACT", 6))
SEED = int(os.environ.get("SIGNORINI_SEED", 24))


def stack(rng, most=4):
    """One to `most` boxes, askew on each other on a slope, sometimes a ball beside them and a pull across."""
    friction, angle = rng.choice([0.0, 0.2, 0.5, 0.9]), rng.choice([0.0, 0.0, 0.1, 0.3])
    bodies, x, z = [], 0.0, 0.0
    for _ in range(rng.integers(1, most + 1)):
        half = rng.uniform(0.05, 0.1, 3)
        x, z = x + rng.uniform(-0.06, 0.06), z + half[2]
        turn = rng.uniform(-40, 40) if rng.random() < 0.5 else 0
        bodies.append(f"<body pos='{x} 0 {z}' euler='0 0 {turn}'><freejoint/>"
                      f"<geom type='box' size='{half[0]} {half[1]} {half[2]}' friction='{friction}'/></body>")
        z += half[2]
    if rng.random() < 0.3:
        bodies.append(f"<body pos='{x + 0.4} 0 0.05'><freejoint/><geom size='0.05' friction='{friction}'/></body>")
    gravity = 9.81 * np.array([np.sin(angle), 0.05 * rng.integers(0, 2), -np.cos(angle)])
    return signorini.Model.from_string(
        f"<mujoco><option gravity='{gravity[0]} {gravity[1]} {gravity[2]}'/><worldbody>"
        f"<geom type='plane' friction='{friction}'/>{''.join(bodies)}</worldbody></mujoco>")


def rays(problem):
    """Extreme rays of the friction cones as impulses on the degrees of freedom, one a row."""
    generators = []
    for i, friction in enumerate(problem.mu):
        normal, tangents = problem.Jn[i], problem.Jt[2 * i:2 * i + 2]
        directions = problem.D[problem.direction_offsets[i]:problem.direction_offsets[i + 1]]
        generators += [normal + friction * (d @ tangents) for d in directions] if friction > 0 else [normal]
    return np.array(generators).reshape(-1, len(problem.v_free))


def imbalance(problem, linprog):
    """The least sum of impulses, in units of the loads, that must be added for a balance; by HiGHS."""
    root = np.sqrt(np.diag(problem.M))
    load = problem.M @ problem.v_free / root
    n = len(load)
    cones = rays(problem).T / root[:, None]
    cost = np.r_[np.zeros(cones.shape[1]), np.ones(2 * n)]
    solved = linprog(cost, A_eq=np.c_[cones, np.eye(n), -np.eye(n)], b_eq=-load / np.abs(load).max(), method="highs")
    assert solved.status == 0
    return solved.fun


def test_no_verdict_contradicts_highs():
    linprog = pytest.importorskip("scipy.optimize").linprog
    rng = np.random.default_rng(SEED)
    counts = collections.Counter()
    for _ in range(STACKS):
        found = signorini.stability(stack(rng), enumeration=0)
        assert found.proved
        counts[found.verdict] += 1
        missing = imbalance(found.problem, linprog)
        # HiGHS knows its programs to 1e-7; no stack is that near to its limit.
        assert missing > 1e-6 if found.verdict == "must_move" else missing < 1e-7, (found, missing)
    print(f"seed {SEED}: {STACKS} stacks beside HiGHS: {dict(counts)}")
    assert min(counts[verdict] for verdict in ("must_move", "stays", "stands")) >= 10, counts


def eliminated(matrix, right):
    """The solution of a square system in fractions."""
    rows = [list(row) + [value] for row, value in zip(matrix, right, strict=True)]
    for k in range(len(rows)):
        pivot = next(i for i in range(k, len(rows)) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for i, row in enumerate(rows):
            if i != k and row[k]:
                rows[i] = [a - row[k] * b for a, b in zip(row, rows[k], strict=True)]
    return [row[-1] for row in rows]


def exact_imbalance(problem):
    """The same as `imbalance` without any rounding after the problem's numbers: the simplex method (Bland's rule) in fractions."""
    fractions = lambda values: [Fraction(float(x)) for x in values]
    mass = [fractions(row) for row in problem.M]
    free = fractions(problem.v_free)
    load = [-sum(m * v for m, v in zip(row, free, strict=True)) for row in mass]
    n, size = len(load), max(map(abs, load))
    load = [p / size for p in load]
    # What is missing is added along the axes, in the direction of the load.
    sign = [1 if p >= 0 else -1 for p in load]
    axes = [[Fraction(s * (i == k)) for i in range(n)] for k in range(n) for s in (sign[k], -sign[k])]
    columns = [fractions(ray) for ray in rays(problem)] + axes
    first = len(columns) - 2 * n
    cost = [int(j >= first) for j in range(len(columns))]
    basis = [first + 2 * k for k in range(n)]
    while True:
        matrix = [[columns[j][i] for j in basis] for i in range(n)]
        values = eliminated(matrix, load)
        prices = eliminated([list(column) for column in zip(*matrix, strict=True)], [Fraction(cost[j]) for j in basis])
        gain = lambda j: cost[j] - sum(a * y for a, y in zip(columns[j], prices, strict=True))
        enters = next((j for j in range(len(columns)) if j not in basis and gain(j) < 0), None)
        if enters is None:
            return sum(cost[j] * x for j, x in zip(basis, values, strict=True))
        along = eliminated(matrix, columns[enters])
        _, _, leaves = min((x / a, j, k) for k, (x, a, j) in enumerate(zip(values, along, basis, strict=True)) if a > 0)
        basis[leaves] = enters


def test_no_verdict_contradicts_exact_arithmetic():
    rng = np.random.default_rng(SEED)
    counts = collections.Counter()
    for _ in range(EXACT):
        found = signorini.stability(stack(rng, most=2 if EXACT > 100 else 1), enumeration=0)
        counts[found.verdict] += 1
        missing = exact_imbalance(found.problem)
        # Normals that are turned by a rounding error need friction where there is none: a balance is one to 1e-11 of the loads.
        assert missing > 1e-11 if found.verdict == "must_move" else missing < 1e-11, (found, float(missing))
    print(f"seed {SEED}: {EXACT} stacks in exact arithmetic: {dict(counts)}")
    assert counts["must_move"] and counts["stays"], counts
