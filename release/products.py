"""What a release consists of, one function a product: each gets the clone and the folder for its files."""

import functools
import shutil
import sys

LINUX = "x86_64-unknown-linux-gnu"
# The GNU ones for every Linux since 2014.
WHEELS = {"x86-64": LINUX, "aarch64": "aarch64-unknown-linux-gnu", "musl": "x86_64-unknown-linux-musl"}
# The oldest C library that programs run with, as the wheels' manylinux_2_17 has it.
GLIBC = "2.17"
# What is given to users with code of others linked in.
SHIPPED = ("cli", "python", "c")
NOTICES = "THIRD-PARTY-NOTICES.txt"
RULE = "-" * 80
MATURIN = "maturin[zig]>=1.9,<2"


def notices(tree, out):
    """THIRD-PARTY-NOTICES.txt: licences of everything that is linked into what is given out (cargo-about), and of the report's page"""
    shutil.copy(notices_of(tree), out / NOTICES)


def notices_of(tree):
    """Makes the notices once a clone."""
    path = tree.target / NOTICES
    if not path.exists() or path.stat().st_mtime < (tree.path / "Cargo.lock").stat().st_mtime:
        tree.need_cargo_tool("cargo-about", "^0.9", "--features", "cli")
        path.parent.mkdir(parents=True, exist_ok=True)
        text = tree.output("cargo", "about", "generate", "--workspace", "--locked", "--fail", "--config", "release/about.toml", "release/about.hbs")
        page = (tree.path / "crates/recording/assets/report.html").read_text(encoding="utf-8")
        ours = page.split("<!--", 1)[1].split("-->", 1)[0].replace("This page", "The page of reports and of the live view", 1)
        path.write_text(f"{text.rstrip()}\n\n{RULE}\n{ours.strip()}\n", encoding="utf-8")
    return path


def sbom(tree, out):
    """one CycloneDX list of components (cargo-cyclonedx) for the command, the Python package and the C library"""
    tree.need_cargo_tool("cargo-cyclonedx", "^0.5")
    name = f"signorini-{tree.version}.cdx"
    tree.run("cargo", "cyclonedx", "--format", "json", "--spec-version", "1.5", "--override-filename", name)
    for crate in SHIPPED:
        text = (tree.path / "crates" / crate / f"{name}.json").read_text(encoding="utf-8").replace(str(tree.path), "")
        (out / f"signorini-{crate}-{tree.version}.cdx.json").write_text(text, encoding="utf-8")
    # One was written beside every crate, with this machine's folders in it: no other product may find them.
    for written in tree.path.rglob(name + ".json"):
        written.unlink()


def changes(tree, out):
    """CHANGES.md: the changelog's section of this version"""
    text = (tree.path / "CHANGELOG.md").read_text(encoding="utf-8")
    title = f"## {tree.version}"
    if title not in text:
        sys.exit(f"CHANGELOG.md has no section '{title}'")
    section = text.split(title, 1)[1].split("\n## ", 1)[0]
    (out / "CHANGES.md").write_text(title + section.rstrip() + "\n", encoding="utf-8")


def crates(tree, out):
    """every crate as crates.io would get it, each built from its packaged files alone (cargo publish --dry-run)"""
    tree.run("python3", "release/check-packages", "--build")
    (out / "crates").mkdir()
    for crate in sorted((tree.target / "package").glob(f"*-{tree.version}.crate")):
        shutil.copy(crate, out / "crates")


def command(tree, out):
    """signorini-VERSION-TARGET.tar.gz: the command, the C and C++ interface with its libraries, licences; for any Linux since 2014"""
    tree.need_target(LINUX)
    tree.need_python_tools(MATURIN, "cargo-zigbuild>=0.20,<1")
    for package in ("signorini-cli", "signorini-c"):
        tree.run("cargo", "zigbuild", "--release", "--locked", "--target", f"{LINUX}.{GLIBC}", "-p", package)
    built = tree.target / LINUX / "release"
    # Zig's C++ library is not the one that programs link a static library with. What is static asks for no version of the C library.
    plain = tree.target / "static"
    tree.run("cargo", "build", "--release", "--locked", "--target-dir", plain, "-p", "signorini-c")
    libraries = tree.target / "libraries"
    shutil.rmtree(libraries, ignore_errors=True)
    libraries.mkdir()
    shutil.copy(built / "libsignorini_c.so", libraries)
    # Without the bitcode that Rust's own link keeps: it is half of the library, of no use to other linkers, and not the same twice.
    static = "libsignorini_c.a"
    bitcode = ("--remove-section=.llvmbc", "--remove-section=.llvmcmd")
    tree.run("objcopy", "--enable-deterministic-archives", *bitcode, plain / "release" / static, libraries / static)
    name = f"signorini-{tree.version}-{LINUX}"
    folder = tree.target / name
    shutil.rmtree(folder, ignore_errors=True)
    tree.run("crates/c/install", folder, libraries)
    (folder / "bin").mkdir()
    shutil.copy(built / "signorini", folder / "bin")
    for file in ("LICENSE-MIT", "LICENSE-APACHE", "README.md"):
        shutil.copy(tree.path / file, folder)
    shutil.copy(notices_of(tree), folder / NOTICES)
    tree.pack(folder, out / f"{name}.tar.gz")


def sdist(tree, out):
    """Python's source package, which builds without a network: its crates are in it (cargo vendor)"""
    tree.need_python_tools(MATURIN)
    packed = tree.target / "sdist"
    shutil.rmtree(packed, ignore_errors=True)
    shutil.copy(notices_of(tree), tree.path / "crates/python/LICENSE-THIRD-PARTY.txt")
    tree.run("maturin", "sdist", "-m", "crates/python/Cargo.toml", "--out", packed)
    (archive,) = packed.glob("*.tar.gz")
    tree.run("tar", "xzf", archive, folder=packed)
    folder = packed / archive.name.removesuffix(".tar.gz")
    config = tree.output("cargo", "vendor", "--versioned-dirs", "vendor", folder=folder)
    (folder / ".cargo").mkdir(exist_ok=True)
    (folder / ".cargo" / "config.toml").write_text(config, encoding="utf-8")
    archive.unlink()
    tree.pack(folder, out / archive.name)


def wheel(tree, out, target):
    """Python's wheel for a target and every Python from 3.10 on"""
    shutil.copy(notices_of(tree), tree.path / "crates/python/LICENSE-THIRD-PARTY.txt")
    tree.need_target(target)
    tree.run("python3", ".ci/wheels", target)
    for made in sorted((tree.path / "build" / "wheels").glob("*.whl")):
        shutil.copy(made, out)


def wheels():
    """A product for the wheel of every Linux target, by a short name."""
    for name, target in WHEELS.items():
        make = functools.partial(wheel, target=target)
        make.__doc__ = f"Python's wheel for {target} and every Python from 3.10 on"
        yield f"wheel-{name}", make


PRODUCTS = {make.__name__: make for make in (changes, notices, sbom, crates, command, sdist)} | dict(wheels())
