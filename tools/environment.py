"""The project's own Python environments: made when missing, renewed when stale.

A stamp inside the environment remembers what it was made from. While the stamp fits,
nothing is installed and the network is not touched. It is written last, so a broken
or interrupted installation counts as stale and is repaired by the next run.
"""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# What can be installed together, and what pip has to be told for it.
SETS = {
    "main": ["-r", "requirements.txt"],
    "publish": ["-r", "requirements-publish.txt"],
    "oldest": ["-r", "requirements-oldest.txt"],
    "dev": [],  # filled from pyproject.toml, see pip_arguments
}

# Settings of the caller that would change what is imported, installed or tested.
DISTURBING = [
    "MPLBACKEND",
    "PIP_TARGET",
    "PIP_USER",
    "PYTEST_ADDOPTS",
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
    subprocess.CalledProcessError
        If an installation failed; the environment then stays stale.
    """
    venv = root / venv_name
    python = python_of(venv)
    stamp = venv / "pgm_lab_stamp.json"
    wanted = fingerprint(venv, root)

    known = read_stamp(stamp)
    current = known.get("fingerprint") == wanted and python.exists()
    installed = set(known["sets"]) if current else set()
    missing = [name for name in sets if name not in installed]
    if not missing:
        return python

    print(f"Setting up {venv_name} ({', '.join(missing)}) ...", flush=True)
    stamp.unlink(missing_ok=True)
    if not current and not is_usable(venv):
        call([sys.executable, "-m", "venv", "--clear", venv])
    for name in missing:
        pip(python, pip_arguments(name, root))
    if not current:
        pip(python, ["--no-deps", "--no-build-isolation", "-e", root])
    content = {"fingerprint": wanted, "sets": sorted(installed | set(missing))}
    stamp.write_text(json.dumps(content), encoding="utf-8")
    return python


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
    digest = hashlib.sha256(f"{sys.version} {venv}".encode())
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
    """Whether an existing environment was made here, by this version of Python."""
    try:
        lines = (venv / "pyvenv.cfg").read_text(encoding="utf-8").splitlines()
    except OSError:
        return False
    settings = dict(line.split(" = ", 1) for line in lines if " = " in line)
    version = ".".join(map(str, sys.version_info[:3]))
    made_here = settings.get("command", "").endswith(str(venv))
    return made_here and settings.get("version") == version and has_pip(venv)


def has_pip(venv: Path) -> bool:
    """Whether pip works there; it does not if making the environment broke off."""
    command = [python_of(venv), "-m", "pip", "--version"]
    try:
        done = subprocess.run(command, capture_output=True, env=environment())
        return done.returncode == 0
    except OSError:
        return False


def pip_arguments(name: str, root: Path = ROOT) -> list[str]:
    """What pip has to be told for one set of packages."""
    if name != "dev":
        return SETS[name]
    import tomllib

    with open(root / "pyproject.toml", "rb") as file:
        return tomllib.load(file)["project"]["optional-dependencies"]["dev"]


def pip(python: Path, arguments: list) -> None:
    """Run ``pip install``, also where pip is set to install for the user alone."""
    options = ["--quiet", "--disable-pip-version-check", "--no-input", "--no-user"]
    call([python, "-m", "pip", "install", *options, *arguments], cwd=python.parents[2])


def call(command: list, cwd: Path = ROOT) -> None:
    """Run a command that has to succeed."""
    command = [str(part) for part in command]
    subprocess.run(command, cwd=cwd, env=environment(), check=True)


def environment(**extra: str) -> dict[str, str]:
    """The caller's environment variables without those that would disturb."""
    kept = {name: value for name, value in os.environ.items() if name not in DISTURBING}
    return kept | STEADY | extra
