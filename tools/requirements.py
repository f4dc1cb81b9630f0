"""Derive the requirement files and environment.yml from pyproject.toml.

For maintainers, after a change of the dependency tables or to take newer versions:
`python tasks.py requirements`. The pins hold for every system and Python from 3.11 on.
"""

import hashlib
import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OLDEST_PYTHON = "3.11"

# What each file holds: the extras on top of the dependencies, and how they are chosen.
# Publishing builds on the pins of requirements.txt, which is therefore made first.
FILES = {
    "requirements.txt": "--extra test",
    "requirements-publish.txt": "--extra test --extra publish -c requirements.txt",
    "requirements-oldest.txt": "--extra test --resolution lowest-direct",
}

HEADER = """\
# Compiled from pyproject.toml by `python tasks.py requirements`; do not edit.
# dependency tables: {digest}
"""

# conda's OpenCV has another name and another build: all take the one from PyPI.
NOT_FROM_CONDA = ["opencv-python-headless"]

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
    used += [extras["test"], extras["publish"]]
    return hashlib.sha256(json.dumps(used).encode()).hexdigest()


def compile_pins(table: dict, options: str, root: Path = ROOT) -> str:
    """The text of one requirement file."""
    command = [sys.executable, "-m", "uv", "pip", "compile", "pyproject.toml"]
    command += ["--universal", "--python-version", OLDEST_PYTHON, *options.split()]
    command += ["--no-config", "--no-header", "--no-annotate", "--quiet"]
    command += ["--no-emit-index-url", "--no-emit-find-links"]
    # No index but PyPI: what is pinned here has to be there for everybody.
    variables = {k: v for k, v in os.environ.items() if not k.startswith("UV_")}
    result = subprocess.run(
        command, cwd=root, env=variables, check=True, text=True, stdout=subprocess.PIPE
    )
    return HEADER.format(digest=tables_sha256(table)) + result.stdout


def environment_yml(table: dict) -> str:
    """The text of environment.yml, with ranges instead of pins."""
    wanted = sorted(table["dependencies"] + table["optional-dependencies"]["test"])
    pip = [w for w in wanted if w.startswith(tuple(NOT_FROM_CONDA))]
    conda = [w for w in wanted if w not in pip]
    return ENVIRONMENT.format(
        python=table["requires-python"],
        conda="\n".join(f"  - {name}" for name in conda),
        pip="\n".join(f"      - {name}" for name in pip),
    )


def main() -> int:
    """Write all four files."""
    table = project()
    for name, options in FILES.items():
        text = compile_pins(table, options)
        (ROOT / name).write_text(text, encoding="utf-8", newline="\n")
        print(f"{name}: {len(text.splitlines()) - 2} pins")
    path = ROOT / "environment.yml"
    path.write_text(environment_yml(table), encoding="utf-8", newline="\n")
    print(path.name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
