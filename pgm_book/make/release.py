"""Make all files of a release from the commit, with their SHA-256 sums.

``make release`` works on a clone, so that only what is committed is released. With
``CHECK=yes`` it makes everything twice and compares: who makes it again from the tag,
with the pinned packages and the same browser, gets the same bytes.
"""

import argparse
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from unittest.mock import patch

from pgm_book.make import archive
from pgm_book.make.environment import ROOT, environment
from pgm_book.make.errors import PublishError
from pgm_book.make.requirements import project
from pgm_lab.io.files import save

SUMS = "SHA256SUMS"
# Who else says the version; the changelog in its first heading.
SAYS = {
    "CITATION.cff": re.compile(r"^version: (\S+)$", re.MULTILINE),
    "pgm_lab/__init__.py": re.compile(r'^__version__ = "(.+)"$', re.MULTILINE),
    ".zenodo.json": re.compile(r'^  "version": "(.+)",$', re.MULTILINE),
    "CHANGELOG.md": re.compile(r"^## ([^\s:,]+)", re.MULTILINE),
}
ZIPPED = "site", "slides", "handouts"


def main(arguments: list[str] | None = None) -> int:
    """Make the files in build/release; return 1 if two makings differ."""
    parser = argparse.ArgumentParser(
        prog="python tasks.py release", description=__doc__
    )
    parser.add_argument("--check", action="store_true", help="make twice and compare")
    options = parser.parse_args(arguments)
    release = ROOT / "build" / "release"
    try:
        tag = asked("git", "tag", "--points-at", "HEAD", "v*").partition("\n")[0]
        if found := disagreements(tag):
            raise PublishError("\n  ".join(["these do not agree:", *found]))
        commit = asked("git", "rev-parse", "HEAD")  # others may be made meanwhile
        files = made(commit)
        if options.check:
            compare(files, made(commit))
    except PublishError as error:
        print(f"release: {error}", file=sys.stderr)
        return 1
    shutil.rmtree(release, ignore_errors=True)
    save({release / name: content for name, content in files.items()})
    for name, content in files.items():
        print(f"{release / name}  {len(content) / 1e6:.1f} MB")
    return 0


def disagreements(tag: str = "") -> list[str]:
    """Name the files that say another version than pyproject.toml, or than a tag.

    Between two releases the changelog begins with what is unreleased.
    """
    version = project()["version"]
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in SAYS}
    said = {name: SAYS[name].search(text) for name, text in texts.items()}
    found = [
        f"{name} says {words[1] if words else 'nothing'}, not {version}"
        for name, words in said.items()
        if not words or words[1] not in (version, "Unreleased" * (not tag))
    ]
    if tag and tag != f"v{version}":
        found.append(f"the tag is {tag}, not v{version}")
    return found


def made(commit: str) -> dict[str, bytes]:
    """Return the files of a release of a commit."""
    seconds = asked("git", "log", "-1", "--format=%ct", commit)
    name = asked("git", "describe", "--always", "--tags", commit)
    print(f"Making {name} ...", flush=True)
    with (
        tempfile.TemporaryDirectory() as folder,
        patch.dict(os.environ, {archive.EPOCH: seconds}),
    ):
        clone = Path(folder, "pgm_lab")
        build = clone / "build"
        call("git", "clone", "-q", "--no-local", ROOT, clone)
        call("git", "checkout", "-q", commit, cwd=clone)
        python = [sys.executable, "-m"]
        dist = [*python, "build", "--no-isolation", "--outdir", build / "dist"]
        call(*dist, cwd=clone)
        call(*python, "pgm_book.make", "site", cwd=clone)
        call(*python, "pgm_book.course.pack", cwd=clone)
        return collected(build)


def collected(build: Path) -> dict[str, bytes]:
    """Return what was built as the files of a release, and their sums."""
    (wheel,), (sdist,) = (build / "dist").glob("*.whl"), (build / "dist").glob("*.gz")
    name = sdist.name.removesuffix(".tar.gz")
    files = {
        wheel.name: wheel.read_bytes(),
        sdist.name: archive.tarred(sdist.read_bytes()),
    }
    for what in ZIPPED:
        content = archive.tree(build / what, f"{name}-{what}")
        files[f"{name}-{what}.zip"] = archive.zipped(content)
    files |= {path.name: path.read_bytes() for path in (build / "course").glob("*.zip")}
    return files | {SUMS: sums(files).encode()}


def sums(files: dict[str, bytes]) -> str:
    """Return the lines that ``sha256sum --check`` reads."""
    hashes = {name: hashlib.sha256(files[name]).hexdigest() for name in sorted(files)}
    return "".join(f"{value}  {name}\n" for name, value in hashes.items())


def compare(first: dict[str, bytes], second: dict[str, bytes]) -> None:
    """Raise a PublishError that names the files of two makings which differ."""
    names = sorted(first.keys() | second.keys())
    differ = [name for name in names if first.get(name) != second.get(name)]
    if differ:
        raise PublishError(f"made twice, these files differ: {', '.join(differ)}")


def asked(*command: str) -> str:
    """Return what git says of the project."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def call(*command, cwd: Path = ROOT, **extra: str) -> None:
    """Run a command that has to succeed; what it says is kept for the error."""
    words = [str(part) for part in command]
    variables = environment(**extra)
    done = subprocess.run(words, cwd=cwd, env=variables, capture_output=True, text=True)
    if done.returncode:
        raise PublishError(f"{' '.join(words)} failed:\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    sys.exit(main())
