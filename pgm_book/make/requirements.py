"""Derive the requirement files and environment.yml from pyproject.toml.

For maintainers, after a change of the tables: `python tasks.py requirements`. Pins that
still fit stay as they are; `python tasks.py requirements --upgrade` takes newer
versions. The pins hold for every system and Python from 3.11 on.
"""

import hashlib
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OLDEST_PYTHON = "3.11"

# What each file is compiled from: uv alone, which installs all the others, or the
# dependencies with some extras. Publishing builds on the pins of requirements.txt,
# which is therefore made before it, and lists only what it adds to them.
FILES = {
    "requirements-uv.txt": "-",  # the standard input: the range of uv
    "requirements.txt": "pyproject.toml --extra test",
    "requirements-publish.txt": (
        "pyproject.toml --extra test --extra publish -c requirements.txt"
    ),
    "requirements-oldest.txt": "pyproject.toml --extra test --resolution lowest-direct",
}

HEADER = """\
# Compiled from pyproject.toml by `python tasks.py requirements`; do not edit.
# dependency tables: {digest}
"""

# conda's OpenCV has another name and another build, its lazrs another name: all take
# those from PyPI.
NOT_FROM_CONDA = ("opencv-python-headless", "lazrs")

ENVIRONMENT = """\
# Derived from pyproject.toml by `python tasks.py requirements`; do not edit.
name: pgm_lab
channels:
  - conda-forge
  - nodefaults
dependencies:
  - python{python}
  - pip
{conda}
  - pip:
{pip}
      - -e .
"""


def project(root: Path = ROOT) -> dict:
    """The table [project] of pyproject.toml."""
    with open(root / "pyproject.toml", "rb") as file:
        return tomllib.load(file)["project"]


def tables_sha256(table: dict) -> str:
    """The hash of all in [project] that the requirement files depend on."""
    extras = table["optional-dependencies"]
    used = [table["requires-python"], table["dependencies"]]
    used += [extras["test"], extras["publish"], uv_range(table)]
    return hashlib.sha256(json.dumps(used).encode()).hexdigest()


def uv_range(table: dict) -> str:
    """What [project] says of uv, in its extra for maintainers."""
    (found,) = (w for w in table["optional-dependencies"]["dev"] if w.startswith("uv>"))
    return found


def compile_pins(name: str, *upgrade: str, root: Path = ROOT) -> None:
    """Write one requirement file; its present pins are kept where they fit."""
    table = project(root)
    command = [sys.executable, "-m", "uv", "pip", "compile", *FILES[name].split()]
    command += ["--universal", "--python-version", OLDEST_PYTHON]
    command += ["--generate-hashes"]  # pip then takes no other file than these
    command += ["--no-config", "--no-header", "--no-annotate", "--quiet"]
    command += ["--no-emit-index-url", "--no-emit-find-links", "-o", name, *upgrade]
    if "lowest-direct" in FILES[name]:  # a bound of ours is to be its pin, always
        wanted = table["dependencies"] + table["optional-dependencies"]["test"]
        names = [re.split("[<>=]", requirement)[0] for requirement in wanted]
        command += [f"--upgrade-package={name}" for name in names]
    # No index but PyPI: what is pinned here has to be there for everybody.
    variables = {k: v for k, v in os.environ.items() if not k.startswith("UV_")}
    subprocess.run(
        command,
        cwd=root,
        env=variables,
        check=True,
        input=uv_range(table).encode(),
        stdout=subprocess.DEVNULL,
    )
    path = root / name
    text = path.read_text(encoding="utf-8")
    if name == "requirements-publish.txt":
        tested = (root / "requirements.txt").read_text(encoding="utf-8")
        text = "-r requirements.txt\n" + without(text, tested)
    text = HEADER.format(digest=tables_sha256(table)) + text
    path.write_text(text, encoding="utf-8", newline="\n")


def without(text: str, other: str) -> str:
    """Leave out the pins, with their hashes, that another file has already."""
    pin = re.compile(r"^\S.*\n(?:    .*\n)*", re.MULTILINE)
    known = set(pin.findall(other))
    return "".join(found for found in pin.findall(text) if found not in known)


def environment_yml(table: dict) -> str:
    """The text of environment.yml, with ranges instead of pins."""
    wanted = sorted(table["dependencies"] + table["optional-dependencies"]["test"])
    pip = [w for w in wanted if w.startswith(NOT_FROM_CONDA)]
    return ENVIRONMENT.format(
        python=table["requires-python"],
        conda="\n".join(f"  - {w}" for w in wanted if w not in pip),
        pip="\n".join(f"      - {w}" for w in pip),
    )


def main(arguments: list[str]) -> int:
    """Write all five files, with newer versions if asked to."""
    if arguments not in ([], ["--upgrade"]):
        print("python tasks.py requirements [--upgrade]")
        return 2
    for name in FILES:
        compile_pins(name, *arguments)
        print(name)
    path = ROOT / "environment.yml"
    path.write_text(environment_yml(project()), encoding="utf-8", newline="\n")
    print(path.name)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
