"""Makes the scenes: every body explicit, the same numbers for every engine, from fixed seeds.

    build/peers/venv/bin/python benchmarks/sim/scenes.py OUT.json [--settle] [--robots FOLDER]

`--settle` also makes the piles at rest (S4s): the boxes of S4 after 4 s in PyBullet, their velocities set to zero.
The piles that rest exactly (S4r) come from these by `sim S4s_pile100 S4s_pile300 … --settle`.
`--robots` writes the quadruped and the humanoid, taken from the packages example-robot-data and dm_control, as model files.

SI units, z up; body frames in the centre of mass with principal axes. A body is `[kind, three half-sizes, mass, position, quaternion
wxyz]` with kind "b" (box) or "s" (sphere, radius first), inertia that of the uniform solid; a plane is the half-space
n·x ≥ offset, `[n, offset]`; a force acts on the centre, `[body, force]`. One friction coefficient per scene, no restitution,
no damping, no sleeping.
"""

import argparse
import json
import math
import pathlib
import sys

GRAVITY = 9.81
FLOOR = [[0, 0, 1, 0]]


class Random:
    """splitmix64, so that any language can make the same scenes."""

    def __init__(self, seed):
        self.state = seed

    def uniform(self, low, high):
        self.state = (self.state + 0x9E3779B97F4A7C15) % 2**64
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) % 2**64
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) % 2**64
        return low + (high - low) * ((z ^ (z >> 31)) >> 11) * 2.0**-53


def short(values):
    return [round(x, 6) for x in values]


def box(half, mass, position, quaternion=(1, 0, 0, 0)):
    return ["b", *short(half), round(mass, 6), *short(position), *(round(x, 9) for x in quaternion)]


def ball(radius, mass, position):
    return ["s", round(radius, 6), 0, 0, round(mass, 6), *short(position), 1, 0, 0, 0]


def scene(what, dt, duration, **rest):
    usual = dict(gravity=[0, 0, -GRAVITY], mu=0.5, planes=FLOOR, bodies=[], joints=[], forces=[], collide=True, sample_every=50)
    return dict(what=what, dt=dt, duration=duration) | usual | rest


def incline(mu, duration):
    slope = math.radians(20)
    gravity = [round(GRAVITY * math.sin(slope), 12), 0, round(-GRAVITY * math.cos(slope), 12)]
    what = f"one box on a plane of 20° (gravity is tilted instead of the plane), μ = {mu}"
    bodies = [box([0.1, 0.1, 0.05], 4.0, [0, 0, 0.05])]
    return scene(what, 0.005, duration, mu=mu, gravity=gravity, bodies=bodies, sample_every=20)


def stack(n):
    bodies = [box([0.5] * 3, 1.0, [0, 0, 0.5 + k]) for k in range(n)]
    return scene(f"{n} unit boxes stacked, touching", 0.005, 10.0, bodies=bodies, sample_every=100)


def wall(base):
    places = [(1.05 * (k - (base - row - 1) / 2), row) for row in range(base) for k in range(base - row)]
    bodies = [box([0.5] * 3, 1.0, [x, 0, 0.5 + row]) for x, row in places]
    return scene(f"wall of {len(bodies)} boxes, base {base}", 0.005, 10.0, bodies=bodies, sample_every=100)


def square_bin(half):
    """Floor and walls of a bin of this half width."""
    return FLOOR + [[1, 0, 0, -half], [-1, 0, 0, -half], [0, 1, 0, -half], [0, -1, 0, -half]]


def pile(n, width, seed, balls=False):
    """Layers of k × k and (k − 1) × (k − 1) bodies, shifted against each other so that no tower survives, in a bin."""
    random, pitch = Random(seed), 0.165 if balls else 0.29
    per_side, places, layer = int((width - 0.02) / pitch), [], 0
    while len(places) < n:
        k = per_side - layer % 2
        row = [(i - (k - 1) / 2) * pitch for i in range(k)]
        places += [(x, y, 0.16 + layer * pitch) for y in row for x in row]
        layer += 1
    bodies = []
    for x, y, z in places[:n]:
        x, y = x + random.uniform(-0.005, 0.005), y + random.uniform(-0.005, 0.005)
        if balls:
            r = random.uniform(0.04, 0.075)
            bodies.append(ball(r, 1000 * 4 / 3 * math.pi * r**3, [x, y, z]))
            continue
        half = [random.uniform(0.04, 0.10) for _ in range(3)]
        axis = [random.uniform(-1, 1) for _ in range(3)]
        norm, angle = math.sqrt(sum(a * a for a in axis)), random.uniform(0, 0.6)
        turn = [math.cos(angle / 2), *(math.sin(angle / 2) * a / norm for a in axis)]
        bodies.append(box(half, 8000 * half[0] * half[1] * half[2], [x, y, z], turn))
    what = f"{n} {'balls' if balls else 'mixed boxes'} dropped into a bin of {width} m"
    return scene(what, 0.005, 4.0, bodies=bodies, planes=square_bin(width / 2), sample_every=100)


def bricks(pairs, layers, seed):
    """Bricks of 2 × 1 × 1 laid in a bin, `pairs` × 2 `pairs` to a layer, every layer across the one below it and moved by an eighth of a
    brick, so that all hold together; densities between 500 and 1500 kg/m³."""
    random, w, slit = Random(seed), 0.1, 0.002
    side, bodies = 2 * pairs * (w + slit), []
    for layer in range(layers):
        over_x, over_y = ((0, 0), (w / 4, 0), (w / 4, w / 4), (0, w / 4))[layer % 4]
        for i in range(pairs):
            for k in range(2 * pairs):
                x, y, half = (i + 0.5) * 2 * (w + slit) - side / 2, (k + 0.5) * (w + slit) - side / 2, [w, w / 2, w / 2]
                if layer % 2:
                    x, y, half = y, x, [w / 2, w, w / 2]
                mass = random.uniform(500, 1500) * 2 * w**3
                bodies.append(box(half, mass, [x + over_x, y + over_y, w * (layer + 0.5)]))
    what = f"{len(bodies)} bricks laid in a bin in {layers} layers, at rest"
    return scene(what, 0.005, 0.25, bodies=bodies, planes=square_bin(side / 2 + 0.03), sample_every=25)


def mass_ratio():
    bodies = [box([0.5] * 3, 1.0, [0, 0, 0.5]), box([0.5] * 3, 1000.0, [0, 0, 1.5])]
    return scene("a cube of 1000 kg on a cube of 1 kg on the floor", 0.005, 10.0, bodies=bodies)


def chain(dt):
    links, length, angle = 50, 0.1, math.radians(60)  # 30° from the vertical
    along, turn = (math.cos(angle), -math.sin(angle)), [math.cos(angle / 2), 0, math.sin(angle / 2), 0]

    def at(s):
        return [along[0] * s, 0, along[1] * s]

    bodies = [box([0.05, 0.01, 0.01], 0.1, at(length * (k + 0.5)), turn) for k in range(links)]
    bodies.append(ball(0.1, 100.0, at(length * links + 0.1)))
    joints = [dict(type="hinge", a=k - 1, b=k, anchor=at(length * k), axis=[0, 1, 0]) for k in range(links + 1)]
    what = f"chain of 50 links of 0.1 kg with 100 kg at its end, let go straight at 30°, Δt = {1000 * dt:.0f} ms"
    return scene(what, dt, 5.0, bodies=bodies, joints=joints, planes=[], collide=False, sample_every=25)


def cards():
    """Three storeys: six leaning pairs and three flat cards."""
    height, thick, width, lean = 0.10, 0.004, 0.06, math.radians(22)
    c, s, half, t = math.cos(lean), math.sin(lean), height / 2, thick / 2
    rise, pitch = 2 * half * c + 2 * t * s, 2 * (2 * half * s + 2 * t * c) + 0.0005
    bodies, floor = [], 0.0
    for pairs in (3, 2, 1):
        for k in range(pairs):
            middle = (k - (pairs - 1) / 2) * pitch
            for side in (-1, 1):
                turn = [math.cos(side * lean / 2), 0, -math.sin(side * lean / 2), 0]
                place = [middle + side * (half * s + t * c), 0, floor + half * c + t * s]
                bodies.append(box([t, width / 2, half], 900 * thick * width * height, place, turn))
        for k in range(pairs - 1):
            place = [(k - (pairs - 2) / 2) * pitch, 0, floor + rise + t]
            bodies.append(box([pitch / 2 - 0.00025, width / 2, t], 900 * thick * width * pitch, place))
        floor += rise + thick
    return scene("house of 15 cards in three storeys", 0.002, 5.0, mu=0.6, bodies=bodies, sample_every=100)


def gripper():
    bodies = [box([0.03] * 3, 1.0, [0, 0, 0.5])]
    bodies += [box([0.01, 0.02, 0.02], 0.2, [x, 0, 0.5]) for x in (-0.04, 0.04)]
    joints = [dict(type="slider", a=-1, b=k, anchor=bodies[k][5:8], axis=[1, 0, 0]) for k in (1, 2)]
    forces, what = [[1, 20, 0, 0], [2, -20, 0, 0]], "two sliding fingers hold a box of 1 kg with 20 N each"
    return scene(what, 0.002, 10.0, bodies=bodies, joints=joints, forces=forces, planes=[], sample_every=100)


def quadruped():
    trot = dict(start=2.0, hz=2.0, lift=[0, 0.35, -0.7], phase_on=["FL", "RR"])
    motors = [f"{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf")]
    return dict(
        what="quadruped A1: stands for 2 s, then trots in place; joint PD", dt=0.002, duration=6.0, mu=0.7, planes=FLOOR,
        gravity=[0, 0, -GRAVITY], robot="a1", urdf="a1.urdf", mjcf="a1.xml", motors=motors, base_height=0.30,
        stance=[0, 0.8, -1.6], kp=60.0, kd=2.0, tau_max=33.5, trot=trot, sample_every=50)  # fmt: skip


def humanoid():
    return dict(
        what="humanoid of the dm_control suite falls without control; timed over the last quarter of 5 s", dt=0.005, duration=5.0,
        gravity=[0, 0, -GRAVITY], planes=[], mu=0.7, robot="humanoid", mjcf="humanoid.xml", sample_every=50)  # fmt: skip


def all_scenes():
    return {
        "S1_slide": incline(0.3, 2.0), "S1_stick": incline(0.5, 10.0), "S2_stack10": stack(10), "S2_stack20": stack(20),
        "S3_wall10": wall(10), "S4_pile100": pile(100, 1.2, 101), "S4_pile300": pile(300, 1.8, 102),
        "S4_pile1000": pile(1000, 2.7, 103), "S4_pile3000": pile(3000, 4.0, 104), "S5_spheres1000": pile(1000, 1.6, 105, True),
        "S6_quadruped": quadruped(), "S7_humanoid": humanoid(), "S8_cards": cards(), "S9_massratio": mass_ratio(),
        "S10_chain": chain(0.001), "S10_chain_2ms": chain(0.002), "S12_gripper": gripper(),
        "S13_bricks96": bricks(2, 12, 131), "S13_bricks306": bricks(3, 17, 132), "S13_bricks1000": bricks(5, 20, 133),
        "S13_bricks3038": bricks(7, 31, 134), "S13_bricks10000": bricks(10, 50, 135),
    }  # fmt: skip


def settle(dropped):
    """The scene of a pile at rest, from where the boxes lie after the drop."""
    from bullet_peer import Peer

    peer = Peer(dropped, "default")
    for _ in range(round(dropped["duration"] / dropped["dt"])):
        peer.step()
    bodies = []
    for row, state in zip(dropped["bodies"], peer.state().tolist()):
        bodies.append([*row[:5], *short(state[:3]), *(round(x, 9) for x in state[3:7])])
    return dropped | dict(what=dropped["what"] + ", come to rest", duration=0.5, sample_every=50, bodies=bodies)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("out", type=pathlib.Path)
    options.add_argument("--settle", action="store_true")
    options.add_argument("--robots", type=pathlib.Path)
    options = options.parse_args()
    sys.path.insert(0, str(pathlib.Path(__file__).parent / "peers"))
    scenes = all_scenes()
    if options.settle:
        for n in (100, 300, 1000, 3000):
            scenes[f"S4s_pile{n}"] = settle(scenes[f"S4_pile{n}"])
    if options.robots:
        import robots

        robots.write(scenes, options.robots)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text("{\n" + ",\n".join(f'"{name}": {json.dumps(data)}' for name, data in scenes.items()) + "\n}\n")


if __name__ == "__main__":
    main()
