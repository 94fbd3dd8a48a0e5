"""Fetches the peers and makes the scenes, all in build/peers of the repository; what cannot be had is named and left out.

    python3 benchmarks/sim/install.py

Everything is built as its users get it: no flags for this machine's processor, neither for the peers nor for us.
MuJoCo, Drake, PyBullet and DART come from PyPI, Rapier from crates.io, ODE from Debian (apt, with sudo where needed).
"""

import os
import pathlib
import shutil
import subprocess
import venv

HERE = pathlib.Path(__file__).resolve().parent
BUILD = HERE.parents[1] / "build" / "peers"
PYTHON = BUILD / "venv" / "bin" / "python"
PACKAGES = ["mujoco==4.0.0", "drake==1.51.1", "pybullet==3.2.7", "dartpy==6.20.0"]
TOOLS = ["numpy", "scipy", "example-robot-data==6.0.0", "dm_control==1.0.50"]


def attempt(name, commands, **options):
    """Runs commands until one fails; says so and goes on."""
    for command in commands:
        try:
            subprocess.run(list(map(str, command)), check=True, **options)
        except (OSError, subprocess.CalledProcessError) as error:
            print(f"left out: {name} ({error})")
            return False
    return True


def install_python():
    if not PYTHON.exists():
        venv.create(BUILD / "venv", with_pip=True)
    pip = [PYTHON, "-m", "pip", "install", "--quiet"]
    subprocess.run([*map(str, pip), *TOOLS], check=True)
    for package in PACKAGES:
        attempt(package, [[*pip, package]])


def install_ode():
    if not pathlib.Path("/usr/include/ode/ode.h").exists():
        sudo = [] if os.geteuid() == 0 else ["sudo"]
        apt = [*sudo, "apt-get", "install", "-y", "-qq", "--no-install-recommends", "g++", "libode-dev"]
        if not attempt("ODE", [[*sudo, "apt-get", "update", "-qq"], apt]):
            return
    attempt("ODE", [["g++", "-std=c++17", "-O3", "-o", BUILD / "ode_peer", HERE / "peers" / "ode.cpp", "-lode"]])


def install_rapier():
    project = HERE / "peers" / "rapier"
    environment = os.environ | {"CARGO_TARGET_DIR": str(BUILD / "rapier")}
    if attempt("Rapier", [["cargo", "build", "--release", "--quiet"]], cwd=project, env=environment):
        shutil.copy(BUILD / "rapier" / "release" / "rapier-peer", BUILD / "rapier_peer")


def make_scenes():
    scenes = BUILD / "sim" / "scenes.json"
    if not scenes.exists():
        arguments = [PYTHON, HERE / "scenes.py", scenes, "--settle", "--robots", BUILD / "robots"]
        subprocess.run(list(map(str, arguments)), check=True)


if __name__ == "__main__":
    BUILD.mkdir(parents=True, exist_ok=True)
    install_python()
    install_ode()
    install_rapier()
    make_scenes()
