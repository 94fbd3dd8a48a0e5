"""Solves LCPs with other programs' solvers, for the benchmark `contact_lcp`.

    python benchmarks/contact_lcp/peers.py --install    installs Siconos (apt) and Drake (pip, in build/peers/venv)

Without arguments it reads requests from standard input, one JSON object per line, and answers each with one line:

    {"problem": "p.npz", "solver": "drake_unrevised", "scaled": false, "limit": 1.0, "budget": 0.02, "out": "z.npz"}
    {"status": "done", "claims": true, "seconds": [...]}

`problem` holds `A` [n, n], `b` [n] and the weights `z_weight`, `w_weight` [n] that put all unknowns and all rows in one unit;
with `scaled` the solver gets the problem in that unit. `limit`: CPU seconds of the whole request; `budget`: seconds after which
a solve is not repeated. The solution goes to `out` as `z`, in the problem's own units. Only the solver's own call is timed.
Every request runs in a forked process: a crash or an endless loop costs that request alone.

    build/peers/venv/bin/python benchmarks/contact_lcp/peers.py --lu 4 16 64

prints the time of LAPACK's LU for these sizes.
"""

import ctypes
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import venv

os.environ["OPENBLAS_NUM_THREADS"] = "1"

HERE = pathlib.Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build" / "peers"
LIBRARY = BUILD / "siconos_lcp.so"
PYTHON = BUILD / "venv" / "bin" / "python"
DRAKE = "1.51.1"
MOST_REPETITIONS = 50
TOLERANCE = 1e-10
# From this wall time on the thread's CPU time counts, as in the benchmark's own stopwatch.
CPU_FROM = 2e-4
SICONOS = {"siconos_lemke": 0, "siconos_newton": 1}
DRAKE_SOLVERS = {"drake_unrevised", "drake_unrevised_warm", "drake_moby"}


def install():
    BUILD.mkdir(parents=True, exist_ok=True)
    apt = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", "gcc", "libc6-dev", "liblapack-dev"]
    apt.append("libsiconos-numerics-dev")
    sudo = [] if os.geteuid() == 0 else ["sudo"]
    subprocess.run([*sudo, "apt-get", "update", "-qq"], check=True)
    subprocess.run([*sudo, *apt], check=True, env={**os.environ, "DEBIAN_FRONTEND": "noninteractive"})
    headers = [f"-I{path}" for path, _, _ in os.walk("/usr/include/siconos")]
    source, libraries = HERE / "siconos_lcp.c", ["-lsiconos_numerics", "-llapack"]
    subprocess.run(["gcc", "-O2", "-shared", "-fPIC", *headers, source, "-o", LIBRARY, *libraries], check=True)
    if not PYTHON.exists():
        venv.create(BUILD / "venv", with_pip=True)
    subprocess.run([PYTHON, "-m", "pip", "install", "--quiet", f"drake=={DRAKE}", "numpy"], check=True)


class Siconos:
    """The solvers behind `siconos_lcp.c`."""

    def __init__(self):
        self.library = ctypes.CDLL(str(LIBRARY))
        self.library.time_lu.restype = ctypes.c_double

    def prepare(self, name, A, b):
        n = len(b)
        columns, z, seconds = np.asfortranarray(A), np.zeros(n), ctypes.c_double()
        pointer = lambda x: x.ctypes.data_as(ctypes.POINTER(ctypes.c_double))  # noqa: E731
        iterations = max(1000, 20 * n)

        def solve():
            code = self.library.solve_lcp(
                SICONOS[name], n, pointer(columns), pointer(b), ctypes.c_double(TOLERANCE), iterations,
                pointer(z), ctypes.byref(seconds))
            return seconds.value, code == 0, z

        return solve

    def lu_seconds(self, n):
        A = np.random.default_rng(n).normal(size=(n, n))
        pointer = A.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        return self.library.time_lu(n, pointer)


class Drake:
    """The solvers of `pydrake.solvers`."""

    def __init__(self):
        import pydrake.solvers

        self.solvers = pydrake.solvers

    def prepare(self, name, A, b):
        program = self.solvers.MathematicalProgram()
        x = program.NewContinuousVariables(len(b))
        program.AddLinearComplementarityConstraint(A, b, x)
        make = self.solvers.MobyLcpSolver if name == "drake_moby" else self.solvers.UnrevisedLemkeSolver
        # The Unrevised Lemke solver starts from the basis of its last call: a cold solve needs a fresh one.
        warm = make() if name.endswith("_warm") else None
        if warm:
            warm.Solve(program, None, None)

        def solve():
            solver = warm or make()
            cpu, wall = time.thread_time(), time.perf_counter()
            result = solver.Solve(program, None, None)
            wall, cpu = time.perf_counter() - wall, time.thread_time() - cpu
            return wall if wall < CPU_FROM else min(wall, cpu), result.is_success(), result.get_x_val()

        return solve


def load_peers():
    """Solver name → the program that has it, for what is installed."""
    peers = {}
    try:
        siconos = Siconos()
        peers.update({name: siconos for name in SICONOS})
    except OSError as error:
        print(f"Siconos is absent: {error}", file=sys.stderr)
    try:
        drake = Drake()
        peers.update({name: drake for name in DRAKE_SOLVERS})
    except ImportError as error:
        print(f"Drake is absent: {error}", file=sys.stderr)
    return peers


def measure(peer, request, problem):
    """Solves a problem repeatedly and writes the solution."""
    A, b = problem["A"], problem["b"]
    if request["scaled"]:
        A, b = problem["w_weight"][:, None] * A / problem["z_weight"], problem["w_weight"] * b
    solve = peer.prepare(request["solver"], A, b)
    seconds, claims, z = solve()
    times = [seconds]
    while sum(times) < request["budget"] and len(times) < MOST_REPETITIONS:
        seconds, claims, z = solve()
        times.append(seconds)
    z = np.asarray(z, float) if np.shape(z) == b.shape else np.full(len(b), np.nan)
    np.savez(request["out"], z=z / problem["z_weight"] if request["scaled"] else z)
    return {"status": "done", "claims": bool(claims), "seconds": times}


def answer(peers, request, problem):
    """Runs one request in a process of its own."""
    if request["solver"] not in peers:
        return {"status": "absent", "claims": False, "seconds": []}
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        signal.setitimer(signal.ITIMER_PROF, request["limit"])
        try:
            # Some solvers talk, and the parent's standard output is for answers only.
            silence = os.open(os.devnull, os.O_WRONLY)
            os.dup2(silence, 1), os.dup2(silence, 2)
            reply = measure(peers[request["solver"]], request, problem)
        except Exception as error:  # noqa: BLE001
            reply = {"status": f"error: {error}"[:200], "claims": False, "seconds": []}
        os.write(writing, json.dumps(reply).encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as stream:
        reply = stream.read()
    _, state = os.waitpid(child, 0)
    if reply:
        return json.loads(reply)
    timed_out = os.WIFSIGNALED(state) and os.WTERMSIG(state) == signal.SIGPROF
    return {"status": "time-out" if timed_out else "crash", "claims": False, "seconds": []}


def serve():
    peers = load_peers()
    path, problem = None, None
    for line in sys.stdin:
        request = json.loads(line)
        if request["solver"] == "list":
            reply = {"status": "done", "solvers": sorted(peers)}
        else:
            if request["problem"] != path:
                path, problem = request["problem"], dict(np.load(request["problem"]))
            reply = answer(peers, request, problem)
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["--install"]:
        install()
        sys.exit()
    import numpy as np

    if sys.argv[1:2] == ["--lu"]:
        library = Siconos()
        for size in map(int, sys.argv[2:]):
            best = sorted(library.lu_seconds(size) for _ in range(15))[7]
            print(f"{size:5} {1e6 * best:10.2f} us")
    else:
        serve()
