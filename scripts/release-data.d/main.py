"""Packs a run for others, and checks such an archive; `scripts/release-data` says how it is called."""

import argparse
import gzip
import hashlib
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent
# Figures, reports and copies of tables are made again from the rows.
LEFT_OUT = {"plots", "units", "parquet", "report.md", "report.html", ".lock"}


class Refused(Exception):
    """The input is not what is needed."""


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/release-data", usage="scripts/release-data [--out FILE] [--poses N] [RUN] | --check ARCHIVE [--sample N]", add_help=False)
    parser.add_argument("--home", type=Path, required=True)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--poses", type=int, default=2048)
    parser.add_argument("--check", type=Path, metavar="ARCHIVE")
    parser.add_argument("--sample", type=int, default=8)
    parser.add_argument("run", nargs="?", type=Path)
    options = parser.parse_args()
    if options.poses < 1 or options.sample < 1:
        parser.error("--poses and --sample must be 1 or more")
    return options


def program(home):
    given = os.environ.get("BVBENCH")
    if given:
        return shlex.split(given)
    return ["cargo", "run", "--release", "--quiet", "--manifest-path", str(home / "Cargo.toml"), "--"]


def ask(home, *words):
    """What the program writes to standard output."""
    command = [*program(home), *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise Refused(f"{shlex.join(command)}: {(done.stderr.strip() or 'failed').splitlines()[-1]}")
    return done.stdout


def source(home, revision, name):
    """A file of the shipped scenes at a revision, or today's where the history does not have it; `None` where there is none."""
    if shutil.which("git") and re.fullmatch("[0-9a-f]{40}", revision or ""):
        shown = subprocess.run(["git", "-C", home, "show", f"{revision}:bench-scenes/{name}"], capture_output=True)
        if shown.returncode == 0:
            return shown.stdout
    path = home / "bench-scenes" / name
    return path.read_bytes() if path.resolve().is_relative_to(home.resolve() / "bench-scenes") and path.is_file() else None


def write_scenes(home, manifest, scenes, folder):
    """Writes the scene files that the run read, and holds them to the manifest's hashes."""
    inputs, revision = manifest["inputs"], manifest["program"].get("git_revision")
    found = {name: source(home, revision, name) for name in inputs.keys() | {f"{scene}/scene.toml" for scene in scenes}}
    foreign = sorted(name for name, content in found.items() if content is None)
    if foreign:
        raise Refused(f"not bvbench's own, so not ours to release: {', '.join(foreign)}")
    for name, content in found.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    hashes = {}
    for scene in scenes:
        hashes |= json.loads(ask(home, "scene", "info", folder / scene, "--json"))["inputs"]
    changed = sorted(name for name in hashes.keys() | inputs.keys() if hashes.get(name) != inputs.get(name))
    if changed:
        raise Refused(f"not the files that the run read: {', '.join(changed)}; pack the run in a clone that has its revision, {revision or 'which it does not name'}")


def gather(home, run, poses, scratch):
    """Every file of the archive by its name in it."""
    try:
        manifest = json.loads((run / "manifest.json").read_text(encoding="utf-8"))
    except (FileNotFoundError, json.JSONDecodeError) as error:
        raise Refused(f"{run / 'manifest.json'}: {error}") from error
    scenes = [scene["name"] for scene in manifest.get("scenes", [])]
    if not scenes:
        raise Refused(f"{run} names no scenes: is it the folder of a run that was measured?")
    texts, exported = scratch / "texts", scratch / "exported"
    write_scenes(home, manifest, scenes, texts)
    files = {f"run/{path.relative_to(run).as_posix()}": path for path in run.rglob("*") if path.is_file() and not LEFT_OUT & set(path.relative_to(run).parts)}
    counts = []
    for scene in scenes:
        print(f"exporting {scene}", file=sys.stderr, flush=True)
        # Meshes, poses and verdicts.
        ask(home, "peers", "export", "--scene", texts / scene, "--seed", manifest["request"]["seed"], "--poses", poses, "--quiet", "--out", exported)
        for pair in sorted(path.parent for path in (exported / scene).rglob("poses.npy")):
            name = f"scenes/{scene}/{pair.name}"
            files |= {f"{name}/{path.name}": path for path in pair.glob("*.npy")}
            counts.append(name)
        about = home / "bench-scenes" / scene / "README.md"
        files |= {f"scenes/{scene}/README.md": about} if about.is_file() else {}
    # Scene files, programs and shared machines, as the manifest names them.
    files |= {f"scenes/{name}": texts / name for name in manifest["inputs"]}
    files |= {name: home / name for name in ("LICENSE-MIT", "LICENSE-APACHE", "CITATION.cff")}
    files |= {"DICTIONARY.md": home / "results/README.md", "RUNNER.md": home / "docs/adding-a-peer.md", "check.py": HERE / "check.py"}
    readme = scratch / "README.md"
    listed = "\n".join(f"- `{name}`" for name in counts)
    text = (HERE / "README.md").read_text(encoding="utf-8")
    revision = manifest.get("versions", {}).get("revision") or manifest.get("revision") or "see run/manifest.json"
    told = {
        "RUN": run.name,
        "PROTOCOL": manifest["protocol"],
        "SCHEMA": manifest["schema"],
        "SEED": manifest["request"]["seed"],
        "REVISION": manifest["program"].get("git_revision") or "not recorded",
        "PAIRS": listed,
    }
    for key, value in told.items():
        text = text.replace(f"@{key}@", str(value))
    readme.write_text(text, encoding="utf-8")
    files |= {"README.md": readme}
    missing = [str(path) for path in files.values() if not path.is_file()]
    if missing:
        raise Refused(f"not there: {', '.join(missing)}")
    return files


def pack(files, top, out):
    """Writes the archive: sorted, without times or owners, checksums last."""
    out.parent.mkdir(parents=True, exist_ok=True)
    partial = out.with_name(out.name + ".partial")
    sums = []
    with open(partial, "wb") as raw, gzip.GzipFile(fileobj=raw, mode="wb", mtime=0, filename="") as squeezed, tarfile.open(fileobj=squeezed, mode="w", format=tarfile.PAX_FORMAT) as archive:

        def add(name, content):
            entry = tarfile.TarInfo(f"{top}/{name}")
            entry.size = len(content)
            entry.mode = 0o644
            archive.addfile(entry, io.BytesIO(content))

        for name in sorted(files):
            content = files[name].read_bytes()
            sums.append(f"{hashlib.sha256(content).hexdigest()}  {name}\n")
            add(name, content)
        add("SHA256SUMS", "".join(sums).encode())
    partial.replace(out)


def release(options):
    run = (options.run or options.home / "results/reference").resolve()
    top = f"bvbench-data-{run.name}"
    out = (options.out or options.home / "target" / f"{top}.tar.gz").resolve()
    if out.is_dir():
        raise Refused(f"--out {out}: a folder; the archive is one file")
    with tempfile.TemporaryDirectory() as scratch:
        files = gather(options.home, run, options.poses, Path(scratch))
        pack(files, top, out)
    print(f"{out}: {len(files) + 1} files, {out.stat().st_size / 1e6:.1f} MB")
    return 0


def check(options):
    with tempfile.TemporaryDirectory() as scratch:
        try:
            with tarfile.open(options.check, "r:gz") as archive:
                archive.extractall(scratch, filter="data")
        except (OSError, EOFError, zlib.error, tarfile.TarError) as error:
            raise Refused(f"{options.check}: {error}") from error
        sums = list(Path(scratch).glob("*/SHA256SUMS"))
        if len(sums) != 1:
            raise Refused(f"{options.check} has no SHA256SUMS: scripts/release-data did not make it")
        # By our own copy: one in an archive that was changed could say anything.
        return subprocess.run([sys.executable, HERE / "check.py", sums[0].parent, str(options.sample)]).returncode


def main():
    options = arguments()
    try:
        return check(options) if options.check else release(options)
    except Refused as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
