"""What a call of signorini.step from Python costs beyond the step itself.

Compares N calls with nstep=1 with one call with nstep=N, which loops in Rust, in interleaved short rounds from the same state, and
prints the fastest of each, which other programs on the machine disturb least. Run it with an optimised build of the package.
"""

import pathlib
import time

import signorini

SCENES = pathlib.Path(__file__).resolve().parents[3] / "scenes"
BALL = """<mujoco model="ball on a floor"><worldbody><geom type="plane"/>
<body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""


def measure(model: signorini.Model, steps: int, rounds: int = 400) -> None:
    data = signorini.Data(model)
    signorini.step(model, data, nstep=10)
    start = data.get_state()
    in_rust, in_python = [], []
    for _ in range(rounds):
        data.set_state(start)
        begin = time.perf_counter()
        signorini.step(model, data, nstep=steps)
        in_rust.append((time.perf_counter() - begin) / steps)
        data.set_state(start)
        begin = time.perf_counter()
        for _ in range(steps):
            signorini.step(model, data)
        in_python.append((time.perf_counter() - begin) / steps)
    rust, python = 1e6 * min(in_rust), 1e6 * min(in_python)
    print(f"{model.name:20} {model.nbody - 1:3} bodies: {rust:8.2f} µs in Rust, {python:8.2f} µs from Python: {python - rust:+.2f} µs")


if __name__ == "__main__":
    measure(signorini.Model.from_string(BALL), 500)
    for scene, steps in (("incline", 100), ("quadruped", 50), ("house_of_cards", 10)):
        measure(signorini.Model.from_file(SCENES / f"{scene}.xml"), steps)
