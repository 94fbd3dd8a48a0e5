"""Compares the dynamics algorithms with Pinocchio's: instructions of a call (callgrind) and time, in one run.

    python -m venv .venv && .venv/bin/pip install pin==4.1.0 cmeel-eigen==3.4.1
    .venv/bin/python benchmarks/dynamics/run.py [--robot talos] [--rounds 5]

Compiles pinocchio.cpp against the package's headers and library (about a minute and a half) into build/dynamics, and the
engine's side with cargo. Needs g++, valgrind and cargo.
"""

import argparse
import pathlib
import re
import subprocess

import pinocchio

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / "build" / "dynamics"
PREFIX = next(p for p in pathlib.Path(pinocchio.__file__).resolve().parents if (p / "include/pinocchio").is_dir())
NAMES = ["kinematics", "rnea", "crba", "aba", "factor", "solve", "jacobian", "centroidal"]


def compile_pinocchio():
    program, source = BUILD / "pinocchio", HERE / "pinocchio.cpp"
    if program.exists() and program.stat().st_mtime > source.stat().st_mtime:
        return program
    BUILD.mkdir(parents=True, exist_ok=True)
    defines = ["NDEBUG", "BOOST_MPL_LIMIT_LIST_SIZE=30", "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
               "PINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION", "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "BOOST_FUSION_INVOKE_MAX_ARITY=12"]
    subprocess.run(
        ["g++", "-std=c++17", "-O3", *(f"-D{d}" for d in defines), f"-I{PREFIX}/include", f"-I{PREFIX}/include/eigen3",
         source, f"-L{PREFIX}/lib", "-lpinocchio_default", f"-Wl,-rpath,{PREFIX}/lib", "-o", program],
        check=True,
    )
    return program


def compile_engine():
    command = ["cargo", "bench", "--locked", "-p", "signorini-multibody", "--bench", "humanoid", "--no-run"]
    output = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stderr
    return ROOT / re.search(r"Executable .*\((.*)\)", output)[1]


def instructions(program, tree, name):
    """Of one call: the difference of two runs, so that the start does not count."""

    def count(calls):
        command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, tree, name, str(calls)]
        output = subprocess.run(command, check=True, capture_output=True, text=True).stderr
        return int(re.search(r"Collected : (\d+)", output)[1])

    return (count(300) - count(100)) / 200


def times(program, tree):
    lines = subprocess.run([program, tree], check=True, capture_output=True, text=True).stdout.splitlines()
    return {name: float(ns) for name, ns in (line.split() for line in lines)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--robot", default="talos")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    tree = ROOT / "crates/multibody/testdata/peers" / f"{arguments.robot}.txt"
    programs = [compile_engine(), compile_pinocchio()]
    best = [dict.fromkeys(NAMES, float("inf")) for _ in programs]
    for _ in range(arguments.rounds):
        for program, times_of in zip(programs, best):
            for name, ns in times(program, tree).items():
                times_of[name] = min(times_of[name], ns)
    print("| algorithm | instructions | Pinocchio's | ratio | ns | Pinocchio's | ratio |\n|---|---|---|---|---|---|---|")
    for name in NAMES:
        ours, theirs = (instructions(program, tree, name) for program in programs)
        a, b = (times_of[name] for times_of in best)
        print(f"| {name} | {ours:.0f} | {theirs:.0f} | {ours / theirs:.2f} | {a:.0f} | {b:.0f} | {a / b:.2f} |")


if __name__ == "__main__":
    main()
