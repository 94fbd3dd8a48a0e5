#!/usr/bin/env python3
"""Makes the plots of the verification chapter from runs: `python3 docs/figures/runs.py [NAME ...]`.

Needs the package, matplotlib, and for the creep of a softened contact MuJoCo (`pip install mujoco`). The cube's recordings are those of
`benchmarks/cube_toss`. Every function prints the numbers that the chapter quotes. A minute on two cores.
"""

import pathlib
import sys
import warnings

import matplotlib
import numpy as np
import signorini

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "signorini", "font.size": 10, "axes.spines.top": False,
                            "axes.spines.right": False, "figure.constrained_layout.use": True})  # fmt: skip
import matplotlib.pyplot as plt  # noqa: E402
import matplotlib.ticker  # noqa: E402

IMAGES = pathlib.Path(__file__).resolve().parent.parent / "src" / "images"
TOSSES = pathlib.Path(__file__).resolve().parents[3] / "shared/data/cube_tosses/cube_tosses.npz"
GRAVITY, SLOPE = 9.81, np.radians(20)
OURS, OTHER, FORM = "#c0392b", "#2166ac", "#7b8794"

BOX_ON_SLOPE = """<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <geom type="plane" size="50 50 1" euler="0 20 0" friction="{mu}"/>
    <body name="box" euler="0 20 0"><freejoint/><geom type="box" size="0.1 0.1 0.05" pos="0 0 0.05" mass="4" friction="{mu}"/></body>
  </worldbody>
</mujoco>"""


def save(figure, name):
    figure.savefig(IMAGES / f"run_{name}.svg", metadata={"Date": None, "Creator": None})
    plt.close(figure)


def start(text, **settings):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", signorini.ModelWarning)
        model = signorini.Model.from_string(text)
    return model, signorini.Data(model, signorini.Settings(**settings))


def creep():
    """A box below its friction angle, for ten seconds: ours, and MuJoCo with its defaults."""
    import mujoco

    text = BOX_ON_SLOPE.format(mu=0.5)
    model, data = start(text)
    other = mujoco.MjModel.from_xml_string(text)
    other_data = mujoco.MjData(other)
    times, ours, theirs = [], [], []
    for _ in range(200):
        signorini.step(model, data, nstep=10)
        mujoco.mj_step(other, other_data, nstep=10)
        times.append(data.time)
        ours.append(np.linalg.norm(data.body("box").xpos))
        theirs.append(np.linalg.norm(other_data.xpos[1]))
    print(f"creep: ours {ours[-1]:.1e} m in 10 s, MuJoCo {mujoco.__version__} {theirs[-1]:.1e} m, {(theirs[-1] - theirs[99]) / 5 * 1e3:.2f} mm/s")
    figure, axes = plt.subplots(figsize=(6.4, 3.2))
    axes.semilogy(times, np.maximum(theirs, 1e-20), color=OTHER, label=f"MuJoCo {mujoco.__version__}, defaults")
    axes.semilogy(times, np.maximum(ours, 1e-20), color=OURS, label="signorini")
    axes.axhline(np.finfo(float).eps * 0.1, color=FORM, lw=0.8, ls="--")
    axes.text(0.1, 3.3e-17, "rounding of 10 cm", color=FORM)
    axes.set(xlabel="time, s", ylabel="moved, m", ylim=(1e-20, 1), title="Box on 20°, μ = 0.5")
    axes.legend(loc="center right")
    save(figure, "creep")


def slide():
    """How far a box slides in two seconds, for coefficients on both sides of the friction angle."""
    frictions = np.concatenate([np.linspace(0, 0.35, 15), [0.355, 0.36, 0.363, 0.365, 0.37], np.linspace(0.4, 0.8, 9)])
    moved = []
    for friction in frictions:
        model, data = start(BOX_ON_SLOPE.format(mu=friction))
        signorini.step(model, data, nstep=400)
        moved.append(np.linalg.norm(data.body("box").xpos))
    distance = lambda mu: 0.5 * GRAVITY * np.maximum(0, np.sin(SLOPE) - mu * np.cos(SLOPE)) * 2.0 * 2.005
    error = np.abs(np.array(moved) - distance(frictions))
    print(f"slide: largest difference from the closed form {error.max():.1e} m of {max(moved):.2f} m")
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.2))
    fine = np.linspace(0, 0.8, 500)
    left.plot(fine, distance(fine), color=FORM, label="closed form")
    left.plot(frictions, moved, "o", color=OURS, ms=4, label="simulated")
    left.set(xlabel="μ", ylabel="moved in 2 s, m")
    left.legend()
    right.semilogy(frictions, np.maximum(error, 1e-18), "o", color=OURS, ms=4)
    right.axvline(np.tan(SLOPE), color=FORM, lw=0.8, ls="--")
    right.text(np.tan(SLOPE) + 0.01, 1e-10, "tan 20°", color=FORM)
    right.set(xlabel="μ", ylabel="difference, m", ylim=(1e-18, 1e-8))
    save(figure, "slide")


PENDULUM = """<mujoco><option timestep="{dt}"/><worldbody><body><joint name="hinge" axis="0 -1 0"/>
  <inertial pos="0 0 -0.8" mass="1.3" diaginertia="1e-13 1e-13 1e-13"/></body></worldbody></mujoco>"""


def runge_kutta(function, state, step, count):
    for _ in range(count):
        a = function(state)
        b = function(state + 0.5 * step * a)
        c = function(state + 0.5 * step * b)
        d = function(state + step * c)
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
    return state


def pendulum_error(dt, shifted, duration=3.0, angle=2.0):
    omega2 = GRAVITY / 0.8
    exact = runge_kutta(lambda s: np.array([s[1], -omega2 * np.sin(s[0])]), np.array([angle, 0.0]), 1e-4, 30_000)[0]
    model, data = start(PENDULUM.format(dt=dt))
    data.qpos[0] = angle
    data.qvel[0] = 0.5 * dt * omega2 * np.sin(angle) if shifted else 0.0
    signorini.step(model, data, nstep=round(duration / dt))
    return abs(data.qpos[0] - exact)


FOUR_BAR = """<mujoco><option timestep="{dt}" gravity="0 0 0"/><default><geom size="0.01" density="1000" contype="0" conaffinity="0"/></default>
  <worldbody>
    <body name="crank"><joint name="crank" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 0.4"/>
      <body name="coupler" pos="0 0 0.4"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 1 0 0.5"/>
        <body name="rocker" pos="1 0 0.5"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.2 0 -0.9"/></body></body></body>
  </worldbody>
  <equality><connect body1="rocker" anchor="0.2 0 -0.9"/></equality></mujoco>"""


def loop_error(dt, speed=1.0, duration=1.0):
    """The largest opening of a four-bar's loop while its crank turns, by the stabilisation of the step alone."""
    model, data = start(FOUR_BAR.format(dt=dt))
    data.joint("crank").qvel = speed
    rocker, largest = data.body("rocker"), 0.0
    for _ in range(round(duration / dt)):
        signorini.step(model, data)
        end = rocker.xpos + rocker.xmat @ [0.2, 0, -0.9]
        largest = max(largest, np.linalg.norm(end - [1.2, 0, 0]))
    return largest


def orders():
    """Errors against the time step: a pendulum's angle after 3 s, and the opening of a closed loop."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.2))
    steps = 4e-3 / 2.0 ** np.arange(6)
    for shifted, color, order, label in ((False, OURS, 1, "from rest"), (True, OTHER, 2, "velocity half a step before")):
        errors = np.array([pendulum_error(dt, shifted) for dt in steps])
        found = np.log2(errors[:-1] / errors[1:])
        print(f"pendulum, {label}: errors {errors[0]:.1e} … {errors[-1]:.1e} rad, orders {np.round(found, 3)}")
        left.loglog(steps, errors, "o-", color=color, ms=4, label=label)
        left.loglog(steps, errors[0] * (steps / steps[0]) ** order, color=FORM, lw=0.8, ls="--")
    left.set(xlabel="Δt, s", ylabel="error, rad", title="Pendulum released at 115°, after 3 s")
    left.legend()
    steps = 8e-3 / 2.0 ** np.arange(5)
    errors = np.array([loop_error(dt) for dt in steps])
    print(f"four-bar: openings {errors[0]:.1e} … {errors[-1]:.1e} m, orders {np.round(np.log2(errors[:-1] / errors[1:]), 3)}")
    long = loop_error(1e-3, duration=20.0)
    print(f"four-bar, 20 s at 1 ms: {long:.1e} m, after 1 s {loop_error(1e-3):.1e} m")
    right.loglog(steps, errors, "o-", color=OURS, ms=4)
    right.loglog(steps, errors[0] * (steps / steps[0]) ** 2, color=FORM, lw=0.8, ls="--")
    right.set(xlabel="Δt, s", ylabel="opening, m", title="Opening of a four-bar at 1 rad/s")
    for axes in (left, right):
        # Less than a decade or two: numbers between the powers of ten would lie on one another.
        axes.xaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    save(figure, "orders")


def t_handle():
    """A T-handle about its middle axis for 100 s: energy, and how it flips; beside it the gyroscopic torque taken explicitly."""
    bar, stem, thin = 0.1 * 0.12**2 / 12, 0.05 * 0.06**2 / 12, 1e-6
    x = 0.05 * 0.03 / 0.15
    across = stem + 0.1 * x**2 + 0.05 * (0.03 - x) ** 2
    inertia = np.array([bar + thin, across + thin, bar + across])
    text = f"""<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody><body><freejoint/>
      <inertial pos="0 0 0" mass="0.15" diaginertia="{inertia[0]:.17g} {inertia[1]:.17g} {inertia[2]:.17g}"/></body></worldbody></mujoco>"""
    model, data = start(text)
    data.qvel[3:] = omega = np.array([10.0, 0.01, 0.02])
    first = data.energy[0]
    times, spin, change, explicit = [0.0], [10.0], [0.0], [0.0]
    for _ in range(10_000):
        signorini.step(model, data, nstep=10)
        for _ in range(10):
            omega = omega - 1e-3 * np.cross(omega, inertia * omega) / inertia
        times.append(data.time)
        spin.append(data.qvel[3])
        change.append(data.energy[0] / first - 1)
        explicit.append(0.5 * omega @ (inertia * omega) / first - 1)
    spin = np.array(spin)
    flips = int((np.diff(np.sign(spin)) != 0).sum())
    print(f"T-handle: {flips} flips in 100 s, energy within {np.abs(change).max():.1e}, explicit {explicit[-1]:.1%}")
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.2))
    left.plot(times[:2001], spin[:2001], color=OURS, lw=1)
    left.set(xlabel="time, s", ylabel="spin about the middle axis, rad/s", title="It flips, for ever")
    right.semilogy(times[1:], np.maximum(np.abs(change[1:]), 1e-12), color=OURS, lw=0.7, label="signorini")
    right.semilogy(times[1:], np.maximum(np.abs(explicit[1:]), 1e-12), color=OTHER, lw=1, label="gyroscopic torque explicit")
    right.set(xlabel="time, s", ylabel="relative change of energy", title="Δt = 1 ms", ylim=(1e-10, 1))
    right.legend(loc="center right")
    save(figure, "t_handle")


CUBE = """<mujoco><option timestep="{dt}"/><worldbody><geom type="plane" friction="0.18"/><body name="cube"><freejoint/>
  <inertial pos="0 0 0" mass="0.37" diaginertia="0.00081 0.00081 0.00081"/><geom type="box" size="0.0524 0.0524 0.0524" friction="0.18"/>
  </body></worldbody></mujoco>"""


def cube_toss():
    """Every recorded toss from its first sample: one path, and the distribution of the errors."""
    if not TOSSES.exists():
        print("cube_toss: skipped, there are no recordings")
        return
    tosses = np.load(TOSSES)
    model, data = start(CUBE.format(dt=1 / 1480), directions=16)
    errors, shown = [], None
    for k, (begin, length) in enumerate(zip(tosses["start"], tosses["length"])):
        measured = tosses["state"][begin : begin + length].astype(float)
        data.reset()
        measured[:, 3:7] /= np.linalg.norm(measured[:, 3:7], axis=1, keepdims=True)
        data.qpos, data.qvel = measured[0, :7], measured[0, 7:]
        path = [measured[0, :3]]
        for _ in range(length - 1):
            signorini.step(model, data, nstep=10)
            path.append(data.qpos[:3].copy())
        errors.append(np.linalg.norm(np.array(path) - measured[:, :3], axis=1).mean() / 0.1048 * 100)
        if k == 8:
            shown = np.arange(length) / 148, measured[:, :3], np.array(path)
    errors = np.array(errors)
    print(f"cube: {len(errors)} tosses, mean position error {errors.mean():.1f} %, median {np.median(errors):.1f} %, missed steps {data.missed_steps}")
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.2))
    times, measured, path = shown
    for axis, name in ((0, "x"), (2, "z")):
        left.plot(times, measured[:, axis] - measured[0, axis] * (axis == 0), ".", color=FORM, ms=4, label="recorded" if axis == 0 else None)
        left.plot(times, path[:, axis] - path[0, axis] * (axis == 0), color=OURS, lw=1.2, label="simulated" if axis == 0 else None)
        left.text(times[-1], path[-1, axis] - path[0, axis] * (axis == 0), f" {name}")
    left.set(xlabel="time, s", ylabel="position, m", title="One toss")
    left.legend()
    right.hist(errors, bins=np.arange(0, 62, 3), color=OURS)
    right.axvline(errors.mean(), color="black", lw=0.8, ls="--")
    right.set(xlabel="mean position error, % of the width", ylabel="tosses", title=f"{len(errors)} tosses, μ = 0.18")
    save(figure, "cube_toss")


PUSHED = """<mujoco><option timestep="0.01"/><worldbody><geom type="plane" friction="0.5"/>
  <body name="box" pos="0 0 0.1"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
    <geom type="box" size="0.1 0.1 0.1" mass="2" friction="0.5"/></body></worldbody></mujoco>"""

FLAGS = {"exact": "#2166ac", "one_sided": "#e08214", "refused": "#c0392b"}


def relaxed(system, x, relaxation):
    """The next state where z w = relaxation in place of 0 ≤ z ⟂ w ≥ 0."""
    free = system.E @ x + system.c
    z = w = np.full(len(free), np.sqrt(relaxation))
    for _ in range(200):
        rest, gap = system.F @ z + free - w, z * w - relaxation
        if max(np.abs(rest).max(), np.abs(gap).max()) < 1e-9 * relaxation:
            break
        dz = np.linalg.solve(system.F + np.diag(w / z), -rest - gap / z)
        dw = system.F @ dz + rest
        length = min(1.0, 0.9 / max(np.max(-dz / z), np.max(-dw / w), 1e-9))
        z, w = z + length * dz, w + length * dw
    return system.A @ x + system.D @ z + system.d


def derivatives():
    """A push on a box that rests: the step, its derivatives and what relaxation makes of it."""
    pushes = np.linspace(0, 20, 81)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.4), sharey=True)
    fine = np.linspace(0, 20, 400)
    for axes in (left, right):
        axes.plot(fine, 0.005 * np.maximum(0, fine - GRAVITY) * 100, color=FORM, lw=1, label="closed form")
        axes.set(xlabel="push, N")
    # A box of 2 kg in 0.01 s: 0.5 cm/s for every newton beyond μ m g.
    error, seen = 0.0, set()
    for push in np.sort(np.r_[np.linspace(1, 19, 10), 0.5 * 2 * GRAVITY]):
        model, data = start(PUSHED)
        data.qfrc_applied[0] = push
        signorini.step(model, data)
        slopes = signorini.derivatives(model, data)
        speed, color = 100 * data.qvel[0], FLAGS[slopes.validity]
        error = max(error, abs(speed - 0.5 * max(0, push - GRAVITY)))
        label = slopes.validity.replace("_", "-") if slopes.validity not in seen else None
        seen.add(slopes.validity)
        left.plot(push, speed, "o", color=color, ms=4, label=label)
        for side in (-1.0, 1.0):
            along = 100 * slopes.directional(dqfrc=[side, 0.0])[1][0]
            left.plot([push, push + 0.7 * side], [speed, speed + 0.7 * along], color=color, lw=1.6)
    left.set(ylabel="speed after the step, cm/s", title="the step and its slopes")
    left.legend(loc="upper left")
    for relaxation, shade in ((1e-6, 1.0), (1e-5, 0.7), (1e-4, 0.45)):
        speeds = []
        for push in pushes:
            model, data = start(PUSHED)
            data.qfrc_applied[0] = push
            system = signorini.linearize(model, data)
            speeds.append(100 * relaxed(system, system.x, relaxation)[2])
        right.plot(pushes, speeds, color=OTHER, alpha=shade, lw=1.4, label=f"z w = {relaxation:.0e}")
    right.set(title="relaxed")
    right.legend()
    print(f"derivatives: largest difference from the closed form {error:.0e} cm/s, flags {sorted(seen)}")
    save(figure, "derivatives")


CUBE = """<mujoco><option timestep="0.002"/><worldbody><geom type="plane" friction="0.4"/>
  <body pos="0 0 0.3"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="0.4" friction="0.4"/></body></worldbody></mujoco>"""


def flags():
    """Where on the way of a tossed cube its steps have derivatives, and by what margin."""
    model, data = start(CUBE)
    data.qvel[:] = 0.6, 0.2, 0.0, 3.0, -5.0, 2.0
    times, margins, validity, heights = [], [], [], []
    for _ in range(175):
        signorini.step(model, data)
        slopes = signorini.derivatives(model, data)
        times.append(data.time)
        heights.append(data.qpos[2])
        validity.append(slopes.validity)
        margins.append(max(1e-18, min((abs(m.value) for m in slopes.margins), default=1.0)))
    counts = {name: validity.count(name) for name in FLAGS}
    print(f"flags: {counts}")
    figure, (above, below) = plt.subplots(2, 1, figsize=(8.4, 4.0), sharex=True, height_ratios=(1, 1.4))
    for name, color in FLAGS.items():
        chosen = np.array([v == name for v in validity])
        if chosen.any():
            label = f"{name.replace('_', '-')}: {counts[name]} steps"
            above.plot(np.array(times)[chosen], np.array(heights)[chosen], ".", color=color, ms=4, label=label)
            below.semilogy(np.array(times)[chosen], np.array(margins)[chosen], ".", color=color, ms=4)
    above.set(ylabel="height, m")
    above.legend()
    below.set(xlabel="time, s", ylabel="least margin")
    save(figure, "flags")


ALL = {f.__name__: f for f in (creep, slide, orders, t_handle, cube_toss, derivatives, flags)}
for name in sys.argv[1:] or ALL:
    ALL[name]()
