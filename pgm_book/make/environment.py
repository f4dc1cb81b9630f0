"""The project's own Python environments: made when missing, renewed when stale.

A stamp inside the environment remembers what it was made from. While the stamp fits,
nothing is installed and the network is not touched. It is written last, so a broken
or interrupted installation counts as stale and is repaired by the next run. A mark is
written first: a folder without it, or behind a link, is never emptied.

uv installs the packages, many times as fast as pip; where it cannot, pip does.
"""

import csv
import hashlib
import json
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# What can be installed together, and what uv or pip has to be told for it.
SETS = {
    "main": ["--require-hashes", "-r", "requirements.txt"],
    "publish": ["--require-hashes", "-r", "requirements-publish.txt"],
    "oldest": ["--require-hashes", "-r", "requirements-oldest.txt"],
    "dev": [],  # filled from pyproject.toml, see arguments_for
}

# In the environment's folder: that this project made it, and what from.
MARK = "pgm_lab_made_this.txt"
STAMP = "pgm_lab_stamp.json"

# How Windows calls a junction, which Python 3.11 does not count as a link.
JUNCTION = 0xA0000003  # IO_REPARSE_TAG_MOUNT_POINT

# Settings of the caller that would change what is imported, installed or tested.
DISTURBING = [
    "MPLBACKEND",
    "PIP_TARGET",
    "PIP_USER",
    "PYTEST_ADDOPTS",
    "PYTHONDONTWRITEBYTECODE",  # each kernel would compile the package anew
    "PYTHONHOME",
    "PYTHONIOENCODING",
    "PYTHONPATH",
    "PYTHONSAFEPATH",
    "PYTHONSTARTUP",
    "VIRTUAL_ENV",
    "__PYVENV_LAUNCHER__",
]

# A tick or a Greek letter can be printed whatever the character set of the system.
STEADY = {"PYTHONUTF8": "1"}

# Settings of pip that uv does not read, and without which it would ask elsewhere.
INDEX_SETTINGS = {"index-url", "pypi-url", "no-index", "proxy"}

# uv trusts the certificates of the system, as pip does. Where a firewall swallows all
# it gives up after seconds; pip is more patient.
UV_SETTINGS = {
    "UV_SYSTEM_CERTS": "1",
    "UV_HTTP_CONNECT_TIMEOUT": "5",
    "UV_HTTP_TIMEOUT": "15",
    "UV_HTTP_RETRIES": "1",
}


class Refused(Exception):
    """The environment's folder cannot be used; the message says what to do."""


def ensure(venv_name: str, *sets: str, root: Path = ROOT) -> Path:
    """Make sure that an environment holds the wanted sets of packages.

    Parameters
    ----------
    venv_name : str
        Folder of the environment, for example ``".venv"``.
    *sets : str
        Names from `SETS`.
    root : Path
        The project's folder.

    Returns
    -------
    Path
        The environment's Python.

    Raises
    ------
    Refused
        If the folder was not made here, is a link, or cannot be written.
    subprocess.CalledProcessError
        If an installation failed; the environment then stays stale.
    """
    venv = root / venv_name
    python = python_of(venv)
    stamp = venv / STAMP
    wanted = fingerprint(venv, root)

    known = read_stamp(stamp)
    current = known.get("fingerprint") == wanted and python.exists()
    installed = sorted(known["sets"]) if current else []
    missing = [name for name in sets if name not in installed]
    if not missing:
        return python

    claim(venv)
    print(f"Setting up {venv_name} ({', '.join(missing)}) ...", flush=True)
    make(venv)
    names = [*installed, *missing]
    orders = [arguments_for(name, root) for name in names]
    orders.append(["--no-deps", "--no-build-isolation", "-e", root])
    reason = install_with_uv(python, orders)
    if reason:
        print(f"pip installs instead of uv, which is slower: {reason}", file=sys.stderr)
        make(venv)  # again, if uv has left a package half installed
        for arguments in orders:
            pip(python, arguments)
    content = {"fingerprint": wanted, "sets": sorted(names)}
    stamp.write_text(json.dumps(content), encoding="utf-8")
    return python


def claim(venv: Path) -> None:
    """Mark a folder as made here, or refuse it; then take its stamp away.

    Parameters
    ----------
    venv : Path
        Folder of the environment; it may be missing or empty.

    Raises
    ------
    Refused
        If it is a link or a file, holds files but no mark, or cannot be written.
    """
    try:
        obstacle = foreign(venv)
        if obstacle:
            raise Refused(
                f"{venv} is {obstacle}, which is left as it is. "
                "Move or delete it yourself, then run the task again."
            )
        venv.mkdir(exist_ok=True)
        if not (venv / MARK).exists():
            with open(venv / MARK, "x", encoding="utf-8") as file:
                file.write("Made by pgm_lab, whose tasks may empty this folder.\n")
        (venv / STAMP).unlink(missing_ok=True)
    except OSError as error:
        raise Refused(
            f"{venv} cannot be written: {error}\n"
            "Change that, or delete it yourself, then run the task again."
        ) from error


def foreign(venv: Path) -> str:
    """What stands in the place of an environment and was not made here, if anything."""
    if is_link(venv):
        return "a link to another place"
    if not venv.exists():
        return ""
    if not venv.is_dir():
        return "a file"
    names = {path.name for path in venv.iterdir()}
    if names and names.isdisjoint({MARK, STAMP}):
        return "a folder with files that this project has not made"
    return ""


def is_link(path: Path) -> bool:
    """Whether a path is a symbolic link, broken or not, or a junction of Windows."""
    try:
        tag = getattr(os.lstat(path), "st_reparse_tag", 0)
    except FileNotFoundError:
        return False
    return path.is_symlink() or tag == JUNCTION


def make(venv: Path) -> None:
    """Make an environment in a marked folder, unless one there can be built upon.

    All but the mark is removed first, and links are removed without following them.
    """
    if is_usable(venv):
        return
    try:
        for path in venv.iterdir():
            if path.name == MARK:
                continue
            if path.is_dir() and not is_link(path):
                shutil.rmtree(path)
            else:
                path.unlink()
    except OSError as error:
        raise Refused(
            f"{venv} cannot be emptied: {error}\nClose what uses it, such as "
            "JupyterLab, or delete it yourself, then run the task again."
        ) from error
    call([sys.executable, "-m", "venv", venv])


def python_of(venv: Path) -> Path:
    """Where an environment keeps its Python."""
    if os.name == "nt":
        return venv / "Scripts" / "python.exe"
    return venv / "bin" / "python"


def fingerprint(venv: Path, root: Path = ROOT) -> str:
    """A hash of all that an environment depends on.

    These are the requirement files, pyproject.toml, the version of Python, and the
    environment's place, because environments do not survive being moved.
    """
    digest = hashlib.sha256(os.fsencode(f"{sys.version} {venv}"))
    for path in [root / "pyproject.toml", *sorted(root.glob("requirements*.txt"))]:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def read_stamp(stamp: Path) -> dict:
    """What the stamp says, or an empty dict if it is missing or damaged."""
    try:
        known = json.loads(stamp.read_text(encoding="utf-8"))
        return {"fingerprint": known["fingerprint"], "sets": list(known["sets"])}
    except (OSError, ValueError, KeyError, TypeError):
        return {}


def is_usable(venv: Path) -> bool:
    """Whether an environment was made here, by this version of Python, and is whole."""
    try:
        lines = (venv / "pyvenv.cfg").read_text(encoding="utf-8").splitlines()
    except OSError:
        return False
    settings = dict(line.split(" = ", 1) for line in lines if " = " in line)
    version = ".".join(map(str, sys.version_info[:3]))
    made_here = settings.get("command", "").endswith(str(venv))
    same = made_here and settings.get("version") == version
    return same and has_pip(venv) and is_whole(venv)


def has_pip(venv: Path) -> bool:
    """Whether pip works there; it does not if making the environment broke off."""
    command = [python_of(venv), "-m", "pip", "--version"]
    try:
        done = subprocess.run(command, capture_output=True, env=environment())
        return done.returncode == 0
    except OSError:
        return False


def is_whole(venv: Path) -> bool:
    """Whether each package has all its files; one that was interrupted may not."""
    folder = Path(sysconfig.get_path("purelib", "venv", {"base": str(venv)}))
    try:
        for package in folder.glob("*.dist-info"):
            with open(package / "RECORD", encoding="utf-8", newline="") as record:
                for name, _, size in csv.reader(record):
                    if size and (folder / name).stat().st_size != int(size):
                        return False
    except (OSError, ValueError):
        return False
    return True


def arguments_for(name: str, root: Path = ROOT) -> list[str]:
    """What uv or pip has to be told for one set of packages."""
    if name != "dev":
        return SETS[name]
    import tomllib

    with open(root / "pyproject.toml", "rb") as file:
        return tomllib.load(file)["project"]["optional-dependencies"]["dev"]


def install_with_uv(python: Path, orders: list[list]) -> str:
    """Let pip install uv, and uv all the rest; the answer is why not, or nothing."""
    if has_own_index(python):
        return "pip is set to an index or a proxy of its own"
    hashes = ["--require-hashes", "-r", "requirements-uv.txt"]
    try:
        pip(python, ["--quiet", "--only-binary=:all:", "--retries=1", *hashes], True)
        for arguments in orders:
            uv(python, arguments)
    except subprocess.CalledProcessError as error:
        lines = [line.strip(" ×") for line in (error.stderr or "").splitlines()]
        said = [line for line in lines if line and not line.startswith("WARNING")]
        return said[0] if said else "it does not say why"
    return ""


def has_own_index(python: Path) -> bool:
    """Whether pip is set to ask another server than PyPI, or to go through a proxy."""
    command = [python, "-m", "pip", "config", "list"]
    done = subprocess.run(command, capture_output=True, env=environment())
    lines = done.stdout.decode("utf-8", "replace").splitlines()
    keys = [line.partition("=")[0].rpartition(".")[2] for line in lines]
    return not INDEX_SETTINGS.isdisjoint(keys)


def uv(python: Path, arguments: list) -> None:
    """Run ``uv pip install`` in the environment, whatever the caller's settings."""
    options = ["--no-config", "--quiet", "--python", python]
    command = [python, "-m", "uv", "pip", "install", *options, *arguments]
    call(command, cwd=python.parents[2], quiet=True)


def pip(python: Path, arguments: list, quiet: bool = False) -> None:
    """Run ``pip install``, also where pip is set to install for the user alone."""
    options = ["--quiet", "--disable-pip-version-check", "--no-input", "--no-user"]
    command = [python, "-m", "pip", "install", *options, *arguments]
    call(command, cwd=python.parents[2], quiet=quiet)


def call(command: list, cwd: Path = ROOT, quiet: bool = False) -> None:
    """Run a command that has to succeed; what a quiet one says is kept in its error."""
    subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=without_uv(environment()) | UV_SETTINGS,
        check=True,
        capture_output=quiet,
        encoding="utf-8",
        errors="replace",
    )


def without_uv(variables: dict[str, str]) -> dict[str, str]:
    """The same variables without the settings of uv; the place of its cache stays."""
    return {
        name: value
        for name, value in variables.items()
        if not name.startswith("UV_") or name == "UV_CACHE_DIR"
    }


def environment(**extra: str) -> dict[str, str]:
    """The caller's environment variables without those that would disturb."""
    kept = {name: value for name, value in os.environ.items() if name not in DISTURBING}
    return kept | STEADY | extra
