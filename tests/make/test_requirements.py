"""What the project imports, pyproject.toml and the requirement files say the same."""

import ast
import copy
import json
import re
import sys
from collections import defaultdict
from functools import cache

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

from pgm_book.make.requirements import (
    FILES,
    ROOT,
    environment_yml,
    project,
    tables_sha256,
    uv_range,
    without,
)

EXTRAS = {
    "requirements.txt": ["test"],
    "requirements-publish.txt": ["test", "publish"],
    "requirements-oldest.txt": ["test"],
}
OURS = {"pgm_lab", "pgm_book", "tests", "conftest"}

# Where the name of a package is not the name under which it is imported.
PACKAGES = {
    "IPython": "ipython",
    "PIL": "pillow",
    "_pytest": "pytest",
    "axe_playwright_python": "axe-playwright-python",
    "bs4": "beautifulsoup4",
    "cv2": "opencv-python-headless",
    "jupyter_client": "jupyter-client",
    "pillow_heif": "pillow-heif",
    "jupyter_core": "jupyter",
    "mpl_toolkits": "matplotlib",
    "skimage": "scikit-image",
}

# Where what is imported has to be asked for: the extras on top of the dependencies.
PLACES = {
    "pgm_lab": ["geo", "phone", "scale"],
    "notebooks": [],
    "pgm_book": ["test", "publish", "dev"],
    "pgm_book/make": ["test", "publish"],
    "tests": ["test", "publish", "dev"],
    # a reader's copy and what starts before anything is installed
    "pgm_book/make/student.py": [],
    "pgm_book/make/__main__.py": [],
    "pgm_book/make/work_copy.py": [],
}


def pin_lines(file_name):
    """A line for each pin, with its hashes; publishing takes those of the tests too."""
    text = (ROOT / file_name).read_text(encoding="utf-8").replace(" \\\n    ", " ")
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    if lines[0] == "-r requirements.txt":
        lines = [*pin_lines("requirements.txt"), *lines[1:]]
    return lines


def pins(file_name):
    """The pinned versions of each package, more than one if they depend on Python."""
    found = defaultdict(set)
    for line in pin_lines(file_name):
        requirement = Requirement(line.split(" --hash=")[0])
        found[canonicalize_name(requirement.name)].add(str(requirement.specifier)[2:])
    return dict(found)


def disagreements(table, file_name):
    """Dependencies that a file does not pin, or pins outside their range."""
    if file_name == "requirements-uv.txt":
        wanted = [uv_range(table)]
    else:
        wanted = list(table["dependencies"])
        for extra in EXTRAS[file_name]:
            wanted += table["optional-dependencies"][extra]
    pinned = pins(file_name)
    found = []
    for requirement in map(Requirement, wanted):
        versions = pinned.get(canonicalize_name(requirement.name), set())
        if not versions or not all(map(requirement.specifier.contains, versions)):
            found.append(str(requirement))
    return found


def recorded_digest(file_name):
    text = (ROOT / file_name).read_text(encoding="utf-8")
    return re.search(r"^# dependency tables: (\w+)$", text, re.MULTILINE)[1]


@pytest.mark.parametrize("file_name", FILES)
def test_every_dependency_is_pinned_in_its_range_with_hashes(file_name):
    """With hashes pip takes the files that were tested, and no others of that name."""
    message = "pyproject.toml has changed: run `python tasks.py requirements`"
    assert recorded_digest(file_name) == tables_sha256(project()), message
    assert disagreements(project(), file_name) == []
    name, condition = r"[a-z0-9][a-z0-9._-]*==[0-9][0-9a-z.+]*", r"( ; [^/\\]+)?"
    pin = re.compile(f"{name}{condition}( --hash=sha256:[0-9a-f]{{64}})+")
    assert [line for line in pin_lines(file_name) if not pin.fullmatch(line)] == []


def test_publishing_lists_only_what_it_adds():
    """Each package of the tests has one version there too."""
    tested, publishing = pins("requirements.txt"), pins("requirements-publish.txt")
    assert {name: publishing.get(name) for name in tested} == tested
    one, two = "a==1 \\\n    --hash=sha256:0\n", "b==2 \\\n    --hash=sha256:1\n"
    assert without(one + two, one) == two


def test_oldest_pins_are_the_lower_bounds():
    table = project()
    oldest = pins("requirements-oldest.txt")
    for line in table["dependencies"] + table["optional-dependencies"]["test"]:
        bound = re.search(r">=([0-9.]+)", line)[1]
        (version,) = oldest[canonicalize_name(Requirement(line).name)]
        # setuptools>=77 has no 77.0.0, opencv's 4.11 is called 4.11.0.86
        assert Version(version).release[:2] >= Version(bound).release[:2]
        assert version.startswith(bound.removesuffix(".0"))


def test_uv_has_a_file_for_itself_and_environment_yml_is_derived():
    assert set(pins("requirements-uv.txt")) == {"uv"}
    assert all("uv" not in pins(file_name) for file_name in EXTRAS)
    text = (ROOT / "environment.yml").read_text(encoding="utf-8")
    assert text == environment_yml(project()), "run `python tasks.py requirements`"


@pytest.mark.parametrize("where", ["dependencies", "test", "publish", "dev"])
def test_a_changed_bound_is_noticed(where):
    """The tests above can fail: raise a bound, and two of three notice."""
    table = copy.deepcopy(project())
    entries = table.get(where) or table["optional-dependencies"][where]
    index = entries.index(uv_range(table)) if where == "dev" else 0
    entries[index] = raised = re.split("[<>=]", entries[index])[0] + ">=9999"
    assert tables_sha256(table) != recorded_digest("requirements.txt")
    file_name = "requirements-uv.txt" if where == "dev" else "requirements-publish.txt"
    assert disagreements(table, file_name) == [raised]
    if where in ("dependencies", "test"):
        assert disagreements(table, "requirements.txt") == [raised]
        assert environment_yml(table) != environment_yml(project())


def python_sources(place):
    """The code of a file, or of a folder by file; a notebook's cells are one piece."""
    if place.endswith(".py"):
        return {place: (ROOT / place).read_text(encoding="utf-8")}
    found = {}
    for path in sorted((ROOT / place).rglob("*.py")):
        if path.parent.name == "boxed":  # its modules import each other, in the box
            continue
        found[path.relative_to(ROOT).as_posix()] = path.read_text(encoding="utf-8")
    for path in sorted((ROOT / place).rglob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        code = ["".join(c["source"]) for c in cells if c["cell_type"] == "code"]
        found[path.relative_to(ROOT).as_posix()] = "\n".join(code)
    return found


@cache
def imported(source):
    """The packages from elsewhere that some code imports, by their own names."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.add(node.module.split(".")[0])
    foreign = names - set(sys.stdlib_module_names) - OURS
    return {PACKAGES.get(name, name) for name in foreign}


@pytest.mark.parametrize("place", PLACES)
def test_every_import_is_a_declared_dependency(place):
    table = project()
    wanted = list(table["dependencies"])
    for extra in PLACES[place]:
        wanted += table["optional-dependencies"][extra]
    known = {re.split("[<>=]", requirement)[0].strip() for requirement in wanted}
    sources = python_sources(place)
    found = {path: imported(source) - known for path, source in sources.items()}
    assert {path: names for path, names in found.items() if names} == {}
