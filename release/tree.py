"""The clone that a release is built in, and how programs run there."""

import dataclasses
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile


@dataclasses.dataclass(frozen=True)
class Tree:
    """A clone of one commit, its version and time, and the folder of tools."""

    path: pathlib.Path
    target: pathlib.Path
    tools: pathlib.Path
    version: str
    # Seconds since 1970 of the commit: the only time that a release knows.
    time: int

    @staticmethod
    def version_of(folder):
        """The version that the workspace's manifest gives."""
        return re.search(r'^version = "(.+)"', (folder / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]

    def environment(self):
        """What makes builds independent of place and time."""
        home = os.environ.get("CARGO_HOME", pathlib.Path.home() / ".cargo")
        remapped = {self.path: "/signorini", self.target: "/target", home: "/cargo"}
        flags = " ".join(f"--remap-path-prefix={place}={name}" for place, name in remapped.items())
        return os.environ | {
            "CARGO_TARGET_DIR": str(self.target),
            "CARGO_INCREMENTAL": "0",
            "RUSTFLAGS": flags,
            "CFLAGS": " ".join(f"-ffile-prefix-map={place}={name}" for place, name in remapped.items()),
            "CXXFLAGS": " ".join(f"-ffile-prefix-map={place}={name}" for place, name in remapped.items()),
            "SOURCE_DATE_EPOCH": str(self.time),
            "TZ": "UTC",
            "LC_ALL": "C.UTF-8",
            "PATH": os.pathsep.join([str(self.tools / "bin"), str(self.tools / "python" / "bin"), os.environ["PATH"]]),
        }

    def run(self, *command, folder=None):
        """Runs a command in the clone; a failure ends the release with the command's words."""
        done = subprocess.run([str(part) for part in command], cwd=folder or self.path, env=self.environment())
        if done.returncode:
            sys.exit(f"failed: {' '.join(str(part) for part in command)}")

    def output(self, *command, folder=None):
        """The standard output of a command in the clone."""
        done = subprocess.run(
            [str(part) for part in command], cwd=folder or self.path, env=self.environment(), stdout=subprocess.PIPE, text=True
        )
        if done.returncode:
            sys.exit(f"failed: {' '.join(str(part) for part in command)}")
        return done.stdout

    def need_cargo_tool(self, crate, version, *options):
        """Installs a program from crates.io into the folder of tools where it is missing."""
        if not (self.tools / "bin" / crate).exists():
            build = self.tools / "target"
            command = ["cargo", "install", crate, "--version", version, "--locked", *options, "--root", self.tools, "--target-dir", build]
            subprocess.run([str(part) for part in command], check=True)
            shutil.rmtree(build, ignore_errors=True)

    def need_python_tools(self, *packages):
        """Installs Python's packages into an environment beside the tools."""
        place = self.tools / "python"
        if not place.exists():
            subprocess.run([sys.executable, "-m", "venv", str(place)], check=True)
        pip = [str(place / "bin" / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, *packages], check=True)

    def need_target(self, target):
        """Ends the release where the compiler has no standard library for a target."""
        place = self.output("rustc", "--print", "target-libdir", "--target", target).strip()
        if not any(pathlib.Path(place).glob("libstd-*.rlib")):
            sys.exit(f"the standard library for {target} is not installed: rustup target add {target}")

    def pack(self, folder, archive):
        """A tar.gz of a folder under its own name: names in order, no owner, the time of the commit."""

        def plain(entry):
            entry.uid = entry.gid = 0
            entry.uname = entry.gname = ""
            entry.mtime = self.time
            entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
            return entry

        raw = archive.with_suffix("")
        with tarfile.open(raw, "w", format=tarfile.PAX_FORMAT) as tar:
            tar.add(folder, folder.name, recursive=False, filter=plain)
            for path in sorted(folder.rglob("*")):
                tar.add(path, str(pathlib.PurePosixPath(folder.name, *path.relative_to(folder).parts)), recursive=False, filter=plain)
        # gzip of the system writes no name and no time with -n.
        subprocess.run(["gzip", "-9nf", str(raw)], check=True)


def checked_out(root, work, commit):
    """A new clone of a commit of `root` below `work`; what was built there before is kept."""
    path = work / "tree"
    shutil.rmtree(path, ignore_errors=True)
    work.mkdir(parents=True, exist_ok=True)
    subprocess.run(["git", "clone", "--quiet", "--no-checkout", str(root), str(path)], check=True)
    subprocess.run(["git", "checkout", "--quiet", "--detach", commit], cwd=path, check=True)
    time = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=path, check=True, capture_output=True, text=True).stdout
    return Tree(path, work / "target", root / "build" / "tools", Tree.version_of(path), int(time))
