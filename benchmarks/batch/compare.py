"""A batch of quadrupeds in our `Batch` and in MuJoCo's `rollout`, in turns on the same threads.

    build/peers/venv/bin/python benchmarks/batch/compare.py [--simulations 64] [--steps 250] [--rounds 12] [--program target/release/batch]

Both read the same MJCF file: the A1 of `benchmarks/sim` with servos whose targets trot in place, each simulation at a frequency of its
own. Both record every state of every simulation. Engines and numbers of threads take turns, so that what else the machine does
meets all of them; medians and quartiles are printed, of wall time and of the time of all processors, and ratios within the rounds.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time

import mujoco
import mujoco.rollout
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PEERS = REPOSITORY / "build" / "peers"
LEGS = ["FL", "FR", "RL", "RR"]
HZ = [1.5, 0.02]


def make_task(scene):
    """Writes the robot with servos and the task for our program; the task."""
    servos = "".join(
        f'<position joint="{name}" kp="{scene["kp"]}" kv="{scene["kd"]}" forcerange="{-scene["tau_max"]} {scene["tau_max"]}"/>'
        for name in scene["motors"]
    )
    text = (PEERS / "robots" / scene["mjcf"]).read_text()
    model = PEERS / "robots" / "a1_servos.xml"
    model.write_text(text.replace("</worldbody>", f"</worldbody><actuator>{servos}</actuator>"))
    phase = [1.0 if leg in scene["trot"]["phase_on"] else -1.0 for leg in LEGS for _ in range(3)]
    start = [0, 0, scene["base_height"], 1, 0, 0, 0, *scene["stance"] * 4]
    task = dict(model=str(model), start=start, timestep=scene["dt"], stance=scene["stance"] * 4, lift=scene["trot"]["lift"] * 4)
    task |= dict(phase=phase, hz=HZ)
    (PEERS / "robots" / "batch.json").write_text(json.dumps(task))
    return task


def targets(task, simulations, first, steps):
    """Targets of the servos, rad, [simulations, steps, motors]."""
    hz = HZ[0] + HZ[1] * np.arange(simulations)
    wave = np.sin(2 * np.pi * hz[:, None] * task["timestep"] * np.arange(first, first + steps))
    lifted = np.maximum(wave[:, :, None] * np.array(task["phase"]), 0)
    return np.array(task["stance"]) + lifted * np.array(task["lift"])


class MuJoCo:
    def __init__(self, task, simulations, steps, threads):
        self.task, self.first, self.steps = task, 0, steps
        self.model = mujoco.MjModel.from_xml_path(task["model"])
        data = mujoco.MjData(self.model)
        data.qpos[:] = task["start"]
        everything = mujoco.mjtState.mjSTATE_FULLPHYSICS
        start = np.empty(mujoco.mj_stateSize(self.model, everything))
        mujoco.mj_getState(self.model, data, start, everything)
        self.states = np.tile(start, (simulations, 1))
        self.data = [mujoco.MjData(self.model) for _ in range(threads)]
        self.pool = mujoco.rollout.Rollout(nthread=threads if threads > 1 else 0)
        self.record = np.empty((simulations, steps, start.size))
        self.sensors = np.empty((simulations, steps, 0))

    def turn(self):
        control = targets(self.task, len(self.states), self.first, self.steps)
        begin = np.array([time.perf_counter(), time.process_time()])
        self.pool.rollout(self.model, self.data, self.states, control, state=self.record, sensordata=self.sensors)
        elapsed = np.array([time.perf_counter(), time.process_time()]) - begin
        self.states = np.array(self.record[:, -1])
        self.first += self.steps
        return elapsed

    def height(self):
        return self.states[:, 3].min()


class Ours:
    """One process for all numbers of threads; it waits while others run."""

    def __init__(self, program, options):
        threads = ",".join(map(str, options.threads))
        task = PEERS / "robots" / "batch.json"
        arguments = ["--task", task, "--simulations", options.simulations, "--steps", options.steps, "--threads", threads]
        command = list(map(str, [program, *arguments]))
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.process.stdout.readline()

    def turn(self, threads):
        self.process.stdin.write(f"{threads}\n")
        self.process.stdin.flush()
        return np.array(self.process.stdout.readline().split(), float)

    def end(self):
        out, _ = self.process.communicate()
        return [line.split() for line in out.splitlines()]


def quartiles(values):
    low, middle, high = statistics.quantiles(values, n=4)
    return f"{middle:.3g} ({low:.3g}–{high:.3g})"


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--simulations", type=int, default=64)
    options.add_argument("--steps", type=int, default=250, help="steps in a turn")
    options.add_argument("--rounds", type=int, default=12)
    options.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    options.add_argument("--program", default=REPOSITORY / "target" / "release" / "batch")
    options = options.parse_args()
    task = make_task(json.loads((PEERS / "sim" / "scenes.json").read_text())["S6_quadruped"])
    ours = Ours(options.program, options)
    peers = {n: MuJoCo(task, options.simulations, options.steps, n) for n in options.threads}
    runners = {("signorini", n): lambda n=n: ours.turn(n) for n in options.threads}
    runners |= {("MuJoCo", n): peers[n].turn for n in options.threads}
    times = {key: [] for key in runners}
    for k in range(options.rounds + 1):
        for key, turn in runners.items():
            elapsed = turn()
            if k > 0:  # the first turn falls onto the floor, and fills the memory
                times[key].append(1e6 * elapsed / options.simulations / options.steps)
    print(f"MuJoCo {mujoco.__version__}, {options.simulations} simulations, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors\n")
    print("| engine | threads | wall time of a step of one simulation, µs | processor time, µs |\n|---|---|---|---|")
    for (engine, threads), values in times.items():
        wall, processor = zip(*values)
        print(f"| {engine} | {threads} | {quartiles(wall)} | {quartiles(processor)} |")
    print("\n| ratio within rounds | wall time | processor time |\n|---|---|---|")

    def compare(name, a, b):
        wall, processor = zip(*(x / y for x, y in zip(times[a], times[b])))
        print(f"| {name} | {quartiles(wall)} | {quartiles(processor)} |")

    for n in options.threads:
        compare(f"MuJoCo / ours, {n} threads", ("MuJoCo", n), ("signorini", n))
    one, many = options.threads[0], options.threads[-1]
    for engine in ("signorini", "MuJoCo"):
        compare(f"{engine}, {one} / {many} threads", (engine, one), (engine, many))
    print("\nOurs: threads, steps, missed, worst residual, lowest base, hash of the states:")
    for line in ours.end():
        print("   ", *line)
    print("MuJoCo, lowest base:", *(f"{peer.height():.4f}" for peer in peers.values()))


if __name__ == "__main__":
    sys.exit(main())
