"""The project's own Python environments: made when missing, renewed when stale.

Standard library only. A stamp inside the environment says what it was made from; while
it fits, nothing is installed and the network is not touched. The stamp is written last:
an environment without one was interrupted and is made again. A mark is written first:
a folder without it, or behind a link, is never emptied.

uv installs the packages, many times as fast as pip; where it cannot, pip does.
"""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# What can be installed together, and the arguments of uv or pip for it.
SETS = {
    "main": ["--require-hashes", "-r", "requirements.txt"],
    "publish": ["--require-hashes", "-r", "requirements-publish.txt"],
    "oldest": ["--require-hashes", "-r", "requirements-oldest.txt"],
    "dev": [],  # filled from pyproject.toml, see arguments_for
}

# In the environment's folder: that this project made it, and what from.
MARK = "pgm_lab_made_this.txt"
STAMP = "pgm_lab_stamp.json"

# Settings of the caller that would change what is imported, installed or tested.
DISTURBING = {
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
}

# A tick or a Greek letter can be printed whatever the character set of the system. uv
# trusts the certificates of the system, as pip does, and where a firewall swallows
# everything it gives up after seconds; pip is more patient.
STEADY = {
    "PYTHONUTF8": "1",
    "UV_SYSTEM_CERTS": "1",
    "UV_HTTP_CONNECT_TIMEOUT": "5",
    "UV_HTTP_TIMEOUT": "15",
    "UV_HTTP_RETRIES": "1",
}


class Refused(Exception):
    """The environment's folder cannot be used; the message says what to do."""


def ensure(venv_name: str, *sets: str, root: Path = ROOT) -> Path:
    """Make sure that an environment has the wanted sets of packages.

    Raises
    ------
    Refused
        If the folder was not made here, is a link, or cannot be written.
    subprocess.CalledProcessError
        If an installation failed; the next run tries again.
    """
    venv = root / venv_name
    python = python_of(venv)
    made_from = {"python": f"{sys.version} {venv}", "files": files_sha256(root)}

    stamp = read_stamp(venv)
    same_python = stamp.get("python") == made_from["python"] and python.exists()
    current = same_python and stamp["files"] == made_from["files"]
    installed = stamp["sets"] if current else []
    missing = [name for name in sets if name not in installed]
    if not missing:
        return python

    print(f"Setting up {venv_name} ({', '.join(missing)}) ...", flush=True)
    orders = [arguments_for(name, root) for name in missing]
    try:
        refuse_foreign(venv)
        if not current:
            claim(venv)
            orders.append(["--no-deps", "--no-build-isolation", "-e", str(root)])
        if not same_python:
            make(venv)
    except OSError as error:
        raise Refused(
            f"{venv} cannot be made anew: {error}\nClose what uses it, such as "
            "JupyterLab, or delete it yourself, then run the task again."
        ) from error
    reason = install_with_uv(python, orders)
    if reason:
        print(f"pip installs instead of uv, which is slower: {reason}", file=sys.stderr)
        for arguments in orders:
            pip(python, arguments)
    content = made_from | {"sets": sorted([*installed, *missing])}
    (venv / STAMP).write_text(json.dumps(content), encoding="utf-8")
    return python


def refuse_foreign(venv: Path) -> None:
    """Refuse an environment's folder that was not made here."""
    if is_link(venv):
        obstacle = "a link to another place"
    elif venv.exists() and not venv.is_dir():
        obstacle = "a file"
    else:
        names = set(os.listdir(venv)) if venv.exists() else set()
        if not names or names & {MARK, STAMP}:
            return
        obstacle = "a folder with files that this project has not made"
    raise Refused(
        f"{venv} is {obstacle}, which is left as it is. "
        "Move or delete it yourself, then run the task again."
    )


def is_link(path: Path) -> bool:
    """Whether a path is a symbolic link, broken or not, or a junction of Windows."""
    parent = os.path.realpath(path.parent)
    return os.path.realpath(path) != os.path.join(parent, path.name)


def claim(venv: Path) -> None:
    """Mark a folder as made here, then take its stamp away."""
    venv.mkdir(exist_ok=True)
    (venv / MARK).write_text("Made by pgm_lab, whose tasks may empty this folder.\n")
    (venv / STAMP).unlink(missing_ok=True)


def make(venv: Path) -> None:
    """Make an environment in a marked folder; all but the mark is removed first."""
    for path in venv.iterdir():
        if path.is_dir() and not is_link(path):
            shutil.rmtree(path)  # it does not follow links
        elif path.name != MARK:
            path.unlink()
    call([sys.executable, "-m", "venv", venv])


def work_folder(root: Path = ROOT) -> Path:
    """Where the reader's notebooks are: work, or work-2 beside an older edition."""
    later = [path for path in root.glob("work-*") if path.name[5:].isdigit()]
    return max(later, key=lambda path: int(path.name[5:]), default=root / "work")


def python_of(venv: Path) -> Path:
    """Where an environment keeps its Python."""
    if os.name == "nt":
        return venv / "Scripts" / "python.exe"
    return venv / "bin" / "python"


def files_sha256(root: Path) -> str:
    """The hash of the files that say what is installed."""
    digest = hashlib.sha256()
    for path in [root / "pyproject.toml", *sorted(root.glob("requirements*.txt"))]:
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def read_stamp(venv: Path) -> dict:
    """What the stamp says, or an empty dict if it is missing or damaged."""
    try:
        stamp = json.loads((venv / STAMP).read_text(encoding="utf-8"))
        return stamp if {"python", "files", "sets"} <= set(stamp) else {}
    except (OSError, ValueError, TypeError):
        return {}


def arguments_for(name: str, root: Path = ROOT) -> list[str]:
    """The arguments of uv or pip for one set of packages."""
    if name != "dev":
        return SETS[name]
    import tomllib

    with open(root / "pyproject.toml", "rb") as file:
        return tomllib.load(file)["project"]["optional-dependencies"]["dev"]


def install_with_uv(python: Path, orders: list[list]) -> str:
    """Let pip install uv, and uv all the rest; return the reason if that fails."""
    hashes = ["--require-hashes", "-r", "requirements-uv.txt"]
    try:
        pip(python, ["--only-binary=:all:", "--retries=1", *hashes], quiet=True)
        for arguments in orders:
            uv(python, arguments)
    except subprocess.CalledProcessError as error:
        lines = [line.strip(" ×") for line in (error.stderr or "").splitlines()]
        said = [line for line in lines if line and not line.startswith("WARNING")]
        return said[0] if said else "no reason was given"
    return ""


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
        env=environment(),
        check=True,
        capture_output=quiet,
        encoding="utf-8",
        errors="replace",
    )


def environment(**extra: str) -> dict[str, str]:
    """The caller's environment variables without those that would disturb."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if name not in DISTURBING
        and (not name.startswith("UV_") or name == "UV_CACHE_DIR")
    }
    return kept | STEADY | extra
