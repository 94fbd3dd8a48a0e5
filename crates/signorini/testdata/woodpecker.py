"""The limit cycle of Glocker's woodpecker toy, with nothing of signorini: Moreau's midpoint scheme and projected Gauss-Seidel.

    python -m venv .venv && .venv/bin/pip install numpy
    .venv/bin/python crates/signorini/testdata/woodpecker.py

Prints time and fall from peck to peck, for the published equations (angles taken as small) and for finite angles. The
tests of `woodpecker.rs` carry these numbers.
"""

from math import cos, sin

import numpy as np

POLE, SLEEVE, HALF_SLEEVE = 0.0025, 0.0031, 0.0058
TO_SPRING, TO_BIRD, BEAK_UP, BEAK_BACK = 0.010, 0.015, 0.02, 0.0201
SLEEVE_MASS, BIRD_MASS, SLEEVE_INERTIA, BIRD_INERTIA = 0.0003, 0.0045, 5e-9, 7e-7
SPRING, GRAVITY, FRICTION = 0.0056, 9.81, 0.3
RESTITUTION = [0.5, 0.0, 0.0]


def equations(q, u, small):
    """Inverse mass matrix, force, gaps, normal rows, tangential rows; contacts: beak, lower and upper edge of the sleeve."""
    a, b = (0.0, 0.0) if small else q[1:]
    bird = np.array([[0, -TO_SPRING * sin(a), -TO_BIRD * sin(b)], [1, TO_SPRING * cos(a), TO_BIRD * cos(b)]])
    rates = np.array([0.0, u[1] ** 2, u[2] ** 2]) * (0.0 if small else 1.0)
    centripetal = -np.array([[0, TO_SPRING * cos(a), TO_BIRD * cos(b)], [0, TO_SPRING * sin(a), TO_BIRD * sin(b)]]) @ rates
    mass = np.diag([SLEEVE_MASS, SLEEVE_INERTIA, BIRD_INERTIA]) + BIRD_MASS * bird.T @ bird
    twist = SPRING * (q[1] - q[2])
    force = np.array([-SLEEVE_MASS * GRAVITY, -twist, twist])
    force += BIRD_MASS * bird.T @ (np.array([0.0, -GRAVITY]) - centripetal)

    def point(angle, x, z):
        """A point of a body that turns by an angle: where it is, and how it moves with the angle."""
        place = np.array([x * cos(angle) - z * sin(angle), x * sin(angle) + z * cos(angle)])
        return place, np.array([-place[1], place[0]])

    back, back_rate = point(b, TO_BIRD - BEAK_BACK, BEAK_UP)
    rows = [np.array([[0, -TO_SPRING * sin(a), back_rate[0]], [1, TO_SPRING * cos(a), back_rate[1]]])]
    gaps = [TO_SPRING * cos(a) + back[0] - POLE]
    for z in (-HALF_SLEEVE, HALF_SLEEVE):
        place, rate = point(a, SLEEVE, z)
        rows.append(np.array([[0, rate[0], 0], [1, rate[1], 0]]))
        gaps.append(place[0] - POLE)
    if small:
        gaps = [gap + row[0] @ [0.0, q[1], q[2]] for gap, row in zip(gaps, rows)]
    return np.linalg.inv(mass), force, gaps, [r[0] for r in rows], [r[1] for r in rows]


def step(q, u, dt, small):
    middle = q + 0.5 * dt * u
    inverse, force, gaps, normal, tangent = equations(middle, u, small)
    v = u + dt * inverse @ force
    pushes, drags = np.zeros(3), np.zeros(3)
    for _ in range(2000):
        before = v.copy()
        for i in (i for i in range(3) if gaps[i] <= 0.0):
            row, rate = normal[i], normal[i] @ v + RESTITUTION[i] * (normal[i] @ u)
            push = max(0.0, pushes[i] - rate / (row @ inverse @ row))
            v, pushes[i] = v + inverse @ row * (push - pushes[i]), push
            row = tangent[i]
            drag = np.clip(drags[i] - row @ v / (row @ inverse @ row), -FRICTION * push, FRICTION * push)
            v, drags[i] = v + inverse @ row * (drag - drags[i]), drag
        if np.abs(v - before).max() < 1e-13:
            break
    return middle + 0.5 * dt * v, v, pushes[0] > 1e-7


def pecks(dt, duration, small):
    q, u = np.array([0.0, -0.1036, -0.2788]), np.array([-0.3411, 0.0, -7.4583])
    found, last = [], -1.0
    for k in range(int(duration / dt)):
        q, u, peck = step(q, u, dt, small)
        if peck:
            if k * dt > last + 0.02:
                found.append((k * dt, q[0]))
            last = k * dt
    return np.diff(np.array(found), axis=0)[2:].mean(axis=0)


if __name__ == "__main__":
    for small in (True, False):
        period, fall = pecks(2e-5, 1.2, small)
        print(f"{'small' if small else 'finite'} angles: {period:.4f} s, {1e3 * fall:.2f} mm")
