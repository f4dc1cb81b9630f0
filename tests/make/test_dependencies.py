"""Whatever the project imports, it asks for in pyproject.toml."""

import ast
import json
import re
import sys

import pytest

from pgm_book.make.requirements import ROOT, project

OURS = {"pgm_lab", "pgm_book", "tools", "tests", "conftest"}

# Where the name of a package is not the name under which it is imported.
PACKAGES = {
    "IPython": "ipython",
    "PIL": "pillow",
    "_pytest": "pytest",
    "axe_playwright_python": "axe-playwright-python",
    "bs4": "beautifulsoup4",
    "cv2": "opencv-python-headless",
    "jupyter_client": "jupyter-client",
    "jupyter_core": "jupyter",
    "mpl_toolkits": "matplotlib",
    "skimage": "scikit-image",
}

# Where what is imported has to be asked for: the extras on top of the dependencies.
PLACES = {
    "pgm_lab": ["geo", "scale"],
    "notebooks": [],
    "pgm_book": ["test", "publish"],
    "tools": ["test", "dev"],
    "tests": ["test", "publish", "dev"],
}


def python_sources(place: str) -> dict[str, str]:
    """The code of a folder by file; a notebook's cells are one piece."""
    found = {}
    for path in sorted((ROOT / place).rglob("*.py")):
        found[path.relative_to(ROOT).as_posix()] = path.read_text(encoding="utf-8")
    for path in sorted((ROOT / place).rglob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        code = ["".join(c["source"]) for c in cells if c["cell_type"] == "code"]
        found[path.relative_to(ROOT).as_posix()] = "\n".join(code)
    return found


def imported(source: str) -> set[str]:
    """The packages from elsewhere that some code imports, by their own names."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(node.module.split(".")[0])
    foreign = names - set(sys.stdlib_module_names) - OURS
    return {PACKAGES.get(name, name) for name in foreign}


def declared(extras: list[str]) -> set[str]:
    """The packages that pyproject.toml asks for, with some extras."""
    table = project()
    wanted = list(table["dependencies"])
    for extra in extras:
        wanted += table["optional-dependencies"][extra]
    return {re.split("[<>=]", requirement)[0].strip() for requirement in wanted}


@pytest.mark.parametrize("place", PLACES)
def test_every_import_is_a_declared_dependency(place):
    known = declared(PLACES[place])
    missing = {
        path: imported(source) - known
        for path, source in python_sources(place).items()
        if imported(source) - known
    }
    assert missing == {}


def test_what_a_reader_starts_with_needs_no_extra():
    """work/ and the student copies are made with the dependencies alone."""
    for path in (
        "pgm_book/make/student.py",
        "pgm_book/make/__main__.py",
        "pgm_book/make/work_copy.py",
    ):
        source = (ROOT / path).read_text(encoding="utf-8")
        assert imported(source) <= declared([]), path


def test_tasks_start_with_python_alone():
    for path in (
        "tasks.py",
        "pgm_book/make/commands.py",
        "pgm_book/make/environment.py",
    ):
        assert imported((ROOT / path).read_text(encoding="utf-8")) == set(), path


def test_imports_are_found_wherever_they_stand():
    source = "import a.b, os\nfrom c.d import e\nfrom . import f\nif 1:\n    import PIL"
    assert imported(source) == {"a", "c", "pillow"}
