"""Fetches packages and makes scenes of them; `scripts/real-scenes` says how it is called.

A scene is a folder beside this file: `origin.toml` says what is taken from which package under which licence; every other file is ours
and is copied. `origin.toml` has
  package   a table of packages.toml
  licence   of what is taken, with the file that says so
  files     globs in the unpacked package; a file that ends in .gz is unpacked
  tree      a folder of the package whose files keep their places below it (for meshes that a URDF file names)
  make      true: `make.py` is run in the scene's folder with the unpacked package as its argument
"""

import argparse
import fnmatch
import gzip
import hashlib
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

TEMPLATES = Path(__file__).resolve().parent
OURS = {"origin.toml", "make.py"}
MARK = ".made-from"


class Unavailable(Exception):
    """A package cannot be had, or is not the one that is expected."""


def run(command, **options):
    """Runs a command; its last words become the error when it fails."""
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    except OSError as error:
        raise Unavailable(f"{command[0]}: {error}") from error
    if done.returncode:
        said = (done.stderr.strip() or done.stdout.strip() or "failed").splitlines()
        raise Unavailable(f"{Path(str(command[0])).name}: {said[-1]}")
    return done.stdout


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


class Packages:
    """The packages of packages.toml, each downloaded at most once in a run and kept in the folder."""

    def __init__(self, folder):
        self.folder = folder / "packages"
        self.known = tomllib.loads((TEMPLATES / "packages.toml").read_text(encoding="utf-8"))
        self.failed = {}

    def root(self, name):
        """The folder of the unpacked package, or of the environment; downloads it when it is not there."""
        if name in self.failed:
            raise Unavailable(self.failed[name])
        package = self.known[name]
        root = self.folder / f"{name}-{package.get('version', 'current')}"
        if (root / ".complete").is_file():
            return root
        shutil.rmtree(root, ignore_errors=True)
        root.mkdir(parents=True)
        print(f"downloading {name} {package.get('version', '')}".rstrip(), file=sys.stderr)
        try:
            origin = getattr(self, package["registry"])(name, package, root)
        except Unavailable as error:
            self.failed[name] = str(error)
            raise
        (root / ".complete").write_text(origin + "\n", encoding="utf-8")
        return root

    def origin(self, name):
        """Name, version and checksum of what was downloaded."""
        return (self.root(name) / ".complete").read_text(encoding="utf-8").strip()

    @staticmethod
    def debian(name, _package, root):
        run(["apt-get", "download", name], cwd=root)
        archive = next(root.glob("*.deb"))
        run(["dpkg", "-x", archive, root])
        said = f"Debian package {archive.stem.replace('%3a', ':')}, SHA-256 {sha256(archive)}"
        archive.unlink()
        return said

    @staticmethod
    def pypi(name, package, root):
        wanted = f"{name}=={package['version']}"
        options = ["--python-version", package["python"]] if "python" in package else []
        options += ["--platform", package["platform"]] if "platform" in package else []
        run([sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary", ":all:", *options, "--dest", root, wanted])
        archive = next(root.glob("*.whl"))
        found = sha256(archive)
        if found != package["sha256"]:
            raise Unavailable(f"{archive.name} has SHA-256 {found}, not {package['sha256']}")
        with zipfile.ZipFile(archive) as wheel:
            wheel.extractall(root)
        archive.unlink()
        return f"PyPI package {wanted}, SHA-256 {found}"

    @staticmethod
    def environment(name, package, root):
        venv.create(root, with_pip=True)
        wanted = [f"{name}=={package['version']}", *package["with"]]
        run([root / "bin/python", "-m", "pip", "install", "--quiet", *wanted])
        return f"PyPI packages {' and '.join(wanted)} with what they need"


class Scene:
    """One scene: its template, and the folder that it is made in."""

    def __init__(self, name, folder):
        self.name = name
        self.template = TEMPLATES / name
        self.folder = folder / name
        self.origin = tomllib.loads((self.template / "origin.toml").read_text(encoding="utf-8"))
        self.title = tomllib.loads((self.template / "scene.toml").read_text(encoding="utf-8"))["title"]

    def stamp(self, packages):
        """What the scene is made from: unchanged, it need not be made again."""
        hashes = [f"{file.name} {sha256(file)}" for file in sorted(self.template.iterdir()) if file.is_file()]
        hashes += [f"{name} {sha256(TEMPLATES / name)}" for name in ("cad.py", "robot.py") if self.origin.get("make")]
        return "\n".join([packages.origin(self.origin["package"]), *hashes, ""])

    def make(self, packages):
        """Makes the scene, or keeps it; true when it was made."""
        stamp = self.stamp(packages)
        mark = self.folder / MARK
        if mark.is_file() and mark.read_text(encoding="utf-8") == stamp:
            return False
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for file in sorted(self.template.iterdir()):
            if file.is_file() and file.name not in OURS:
                shutil.copyfile(file, self.folder / file.name)
        root = packages.root(self.origin["package"])
        self.copy(root)
        if self.origin.get("make"):
            python = root / "bin/python"
            environment = {"PYTHONPATH": str(TEMPLATES), "PYTHONDONTWRITEBYTECODE": "1", "PATH": "/usr/bin:/bin"}
            run([python if python.exists() else sys.executable, self.template / "make.py", root], cwd=self.folder, env=environment)
        mark.write_text(stamp, encoding="utf-8")
        return True

    def copy(self, root):
        """Copies the package's files, those under `tree` with the folders they are in."""
        base = root / self.origin.get("tree", ".")
        names = [str(path.relative_to(base)) for path in sorted(base.rglob("*")) if path.is_file()] if self.origin.get("files") else []
        for pattern in self.origin.get("files", []):
            found = fnmatch.filter(names, pattern)
            if not found:
                raise Unavailable(f"{self.origin['package']} has no file {pattern}")
            for name in found:
                target = self.folder / (name if "tree" in self.origin else Path(name).name)
                target.parent.mkdir(parents=True, exist_ok=True)
                if name.endswith(".gz"):
                    target.with_suffix("").write_bytes(gzip.decompress((base / name).read_bytes()))
                else:
                    shutil.copyfile(base / name, target)


def provenance(made):
    """What stands in the folder, whose it is, and under which terms."""
    lines = ["# Where these scenes come from", "", "Machines' layouts, fixtures, programs and joint paths are bvbench's; the meshes and the programs named below are others'.", ""]
    lines += ["| scene | made from | licence |", "|---|---|---|"]
    for scene in made:
        origin = (scene.folder / MARK).read_text(encoding="utf-8").splitlines()[0]
        lines.append(f"| {scene.name} | {origin} | {scene.origin['licence']} |")
    return "\n".join(lines) + "\n"


def arguments(known):
    parser = argparse.ArgumentParser(prog="scripts/real-scenes", usage="scripts/real-scenes [--list] [--only NAME]... [FOLDER]", add_help=False)
    parser.add_argument("--home", type=Path, required=True)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--only", action="append", metavar="NAME", default=[])
    parser.add_argument("folder", nargs="?", type=Path)
    options = parser.parse_args()
    for name in options.only:
        if name not in known:
            parser.error(f"there is no scene {name}: {', '.join(known)}")
    return options


def main():
    known = sorted(path.parent.name for path in TEMPLATES.glob("*/origin.toml"))
    options = arguments(known)
    folder = (options.folder or options.home / "target/real-scenes").resolve()
    scenes = [Scene(name, folder) for name in (options.only or known)]
    if options.list:
        for scene in scenes:
            print(f"{scene.name:<18}{scene.origin['package']:<20}{scene.origin['licence']}\n{'':18}{scene.title}")
        return 0
    packages = Packages(folder)
    made, missing = [], []
    for scene in scenes:
        try:
            word = "made" if scene.make(packages) else "kept"
        except Unavailable as error:
            missing.append(f"{scene.name}: not made, {error}")
            print(missing[-1], file=sys.stderr)
            continue
        made.append(scene)
        print(f"{word} {scene.folder} ({scene.origin['licence']})")
    there = [Scene(name, folder) for name in known if (folder / name / MARK).is_file()]
    if there:
        (folder / "PROVENANCE.md").write_text(provenance(there), encoding="utf-8")
    if missing:
        print(f"{len(missing)} of {len(scenes)} scenes could not be made", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
