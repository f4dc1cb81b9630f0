"""A stick for a room without internet: wheels, and all that needs no installation.

pip is told which system and Python a wheel is for, but it evaluates the conditions of
requirements.txt for the Python that runs, so they are evaluated here. A pin without a
wheel for a system leaves that system out, and is named.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from packaging.requirements import Requirement

from pgm_book.make.environment import ROOT
from pgm_book.make.errors import PublishError
from pgm_lab.io.files import save

PATCH = 9  # a pin may ask for a bug-fix release of Python: this one, or later
PYTHON = re.compile(r"3\.\d+")
NO_WHEEL = re.compile(r"No matching distribution found for (\S+)")
MADE_FOR = "made_for.txt"

# sys.platform, the machine, and the tags of wheels: Windows 10, a Linux with glibc 2.28
# (Ubuntu 20.04, Debian 10), macOS 15; those of older ones follow from it.
GLIBC = [f"manylinux_2_{minor}_x86_64" for minor in range(28, 16, -1)]
SYSTEMS = {
    "windows": [("win32", "x86_64", ["win_amd64"])],
    "linux": [("linux", "x86_64", [*GLIBC, "manylinux2014_x86_64"])],
    "macos": [
        ("darwin", "arm64", ["macosx_15_0_arm64"]),
        ("darwin", "x86_64", ["macosx_15_0_x86_64"]),
    ],
}
NAMES = {"win32": ("nt", "Windows"), "linux": ("posix", "Linux")}


@dataclass(frozen=True)
class Target:
    """A system and a Python that wheels are for."""

    platform: str
    machine: str
    python: str
    tags: tuple[str, ...]

    def __str__(self) -> str:
        """Return what start.py compares with the Python that runs it."""
        return f"{self.platform} {self.machine} Python {self.python}"

    def environment(self) -> dict[str, str]:
        """Return what the conditions of requirements.txt may ask for."""
        os_name, system = NAMES.get(self.platform, ("posix", "Darwin"))
        machine = "AMD64" if self.platform == "win32" else self.machine
        return {
            "implementation_name": "cpython",
            "os_name": os_name,
            "platform_machine": machine,
            "platform_python_implementation": "CPython",
            "platform_system": system,
            "python_full_version": f"{self.python}.{PATCH}",
            "python_version": self.python,
            "sys_platform": self.platform,
        }


def targets(systems: str | None, pythons: str) -> list[Target]:
    """Return the targets that a lecturer names: "windows,linux" and "3.12,3.13".

    Raises
    ------
    ValueError
        If a system or a version is not known.
    """
    found = []
    for system in systems.split(",") if systems else []:
        if system not in SYSTEMS:
            raise ValueError(f"wheels: {system!r} is none of {', '.join(SYSTEMS)}")
        for python in pythons.split(","):
            if not PYTHON.fullmatch(python):
                raise ValueError(f"pythons: {python!r} is no version such as 3.13")
            found += [Target(p, m, python, tuple(t)) for p, m, t in SYSTEMS[system]]
    return found


def write(folder: Path, files: dict[str, bytes], wanted: list[Target]) -> Path:
    """Write the stick anew: the students' files and what is to be read, and wheels.

    Raises
    ------
    PublishError
        If no system that was named has all its wheels.
    """
    wheels = folder / "wheels"
    shutil.rmtree(folder, ignore_errors=True)
    wheels.mkdir(parents=True)
    complete = []
    for target in wanted:
        print(f"Fetching wheels for {target} ...", flush=True)
        with tempfile.TemporaryDirectory() as fetched:
            lacking = fetch(target, Path(fetched))
            if lacking:
                said = f"{target} is left out, there is no wheel of"
                print(f"course: {said} {', '.join(lacking)}", file=sys.stderr)
                continue
            shutil.copytree(fetched, wheels, dirs_exist_ok=True)
        complete.append(target)
    if not complete:
        raise PublishError("the stick is empty: no system has all its wheels.")
    files = files | {
        f"wheels/{MADE_FOR}": "".join(f"{one}\n" for one in complete).encode(),
        "ROOM.html": (Path(__file__).parent / "templates" / "ROOM.html").read_bytes(),
    }
    save({folder / name: content for name, content in files.items()})
    return folder


def fetch(target: Target, folder: Path) -> list[str]:
    """Fetch the wheels of a target into a folder; return the pins that have none."""
    lacking: list[str] = []
    while True:
        wanted = [one for one in pins(target) if one.split()[0] not in lacking]
        listed = folder / "pins.txt"
        listed.write_text("\n".join(wanted), encoding="utf-8")
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
        command += ["--only-binary=:all:", "--disable-pip-version-check"]
        command += ["--python-version", f"{target.python}.{PATCH}"]
        command += [f"--platform={tag}" for tag in target.tags]
        command += ["--dest", str(folder), "-r", str(listed)]
        done = subprocess.run(command, capture_output=True, text=True)
        listed.unlink()
        missing = NO_WHEEL.search(done.stderr)
        if done.returncode and not missing:
            raise PublishError(f"the wheels were not fetched:\n{done.stderr.strip()}")
        if not missing:
            return lacking
        lacking.append(missing[1])


def pins(target: Target) -> Iterator[str]:
    """Yield the lines of requirements.txt, with hashes, that hold for a target."""
    text = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    for line in text.replace("\\\n", " ").splitlines():
        if line and line[0] not in "#-":
            requirement, *hashes = line.split(" --hash=")
            wanted = Requirement(requirement.strip())
            if not wanted.marker or wanted.marker.evaluate(target.environment()):
                pin = f"{wanted.name}{wanted.specifier}"
                yield " ".join([pin, *(f"--hash={one.strip()}" for one in hashes)])
