"""pyproject.toml, the requirement files and environment.yml say the same."""

import copy
import re
from collections import defaultdict

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

from pgm_book.make.requirements import (
    FILES,
    ROOT,
    environment_yml,
    project,
    tables_sha256,
    uv_range,
)

EXTRAS = {
    "requirements.txt": ["test"],
    "requirements-publish.txt": ["test", "publish"],
    "requirements-oldest.txt": ["test"],
}


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def pin_lines(file_name: str) -> list[str]:
    """A line for each pin, with its hashes at its end."""
    text = (ROOT / file_name).read_text(encoding="utf-8").replace(" \\\n    ", " ")
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def without_hashes(line: str) -> str:
    return line.split(" --hash=")[0]


def pins(file_name: str) -> dict[str, set[str]]:
    """The pinned versions of each package, more than one if they depend on Python."""
    found = defaultdict(set)
    for line in pin_lines(file_name):
        requirement = Requirement(without_hashes(line))
        found[canonical(requirement.name)].add(str(requirement.specifier)[2:])
    return dict(found)


def disagreements(table: dict, file_name: str) -> list[str]:
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
        versions = pinned.get(canonical(requirement.name), set())
        if not versions or not all(map(requirement.specifier.contains, versions)):
            found.append(str(requirement))
    return found


def recorded_digest(file_name: str) -> str:
    text = (ROOT / file_name).read_text(encoding="utf-8")
    return re.search(r"^# dependency tables: (\w+)$", text, re.MULTILINE)[1]


@pytest.mark.parametrize("file_name", FILES)
def test_every_dependency_is_pinned_in_its_range(file_name):
    assert disagreements(project(), file_name) == []


@pytest.mark.parametrize("file_name", FILES)
def test_files_were_compiled_from_the_present_tables(file_name):
    message = "pyproject.toml has changed: run `python tasks.py requirements`"
    assert recorded_digest(file_name) == tables_sha256(project()), message


@pytest.mark.parametrize("file_name", FILES)
def test_lines_are_pins_with_hashes_and_without_an_address(file_name):
    """With hashes pip takes the files that were tested, and no others of that name."""
    name, condition = r"[a-z0-9][a-z0-9._-]*==[0-9][0-9a-z.+]*", r"( ; [^/\\]+)?"
    pin = re.compile(f"{name}{condition}( --hash=sha256:[0-9a-f]{{64}})+")
    assert [line for line in pin_lines(file_name) if not pin.fullmatch(line)] == []


@pytest.mark.parametrize("file_name", [*FILES, "environment.yml"])
def test_no_address_and_no_folder_of_a_machine(file_name):
    text = (ROOT / file_name).read_text(encoding="utf-8")
    for forbidden in ("://", "file:", "--index", "--extra-index", "--find-links", " /"):
        assert forbidden not in text


def test_publishing_uses_the_pins_that_were_tested():
    tested, publishing = pins("requirements.txt"), pins("requirements-publish.txt")
    assert {name: publishing.get(name) for name in tested} == tested


def test_oldest_pins_are_the_lower_bounds():
    table = project()
    oldest = pins("requirements-oldest.txt")
    for line in table["dependencies"] + table["optional-dependencies"]["test"]:
        bound = re.search(r">=([0-9.]+)", line)[1]
        (version,) = oldest[canonical(Requirement(line).name)]
        # setuptools>=77 has no 77.0.0, opencv's 4.11 is called 4.11.0.86
        assert Version(version).release[:2] >= Version(bound).release[:2]
        assert version.startswith(bound.removesuffix(".0"))


def test_uv_has_a_file_for_itself():
    """What installs all others is not among them, and its bound counts as well."""
    assert set(pins("requirements-uv.txt")) == {"uv"}
    assert all("uv" not in pins(file_name) for file_name in EXTRAS)
    table = copy.deepcopy(project())
    extra = table["optional-dependencies"]["dev"]
    extra[extra.index(uv_range(table))] = "uv>=9999"
    assert tables_sha256(table) != recorded_digest("requirements-uv.txt")
    assert disagreements(table, "requirements-uv.txt") == ["uv>=9999"]


def test_environment_yml_is_derived():
    text = (ROOT / "environment.yml").read_text(encoding="utf-8")
    message = "run `python tasks.py requirements`"
    assert text == environment_yml(project()), message


@pytest.mark.parametrize("where", ["dependencies", "test", "publish"])
def test_a_changed_bound_is_noticed(where):
    """The tests above can fail: raise each bound in turn, and two of three notice."""
    table = project()
    count = len(table.get(where) or table["optional-dependencies"][where])
    for index in range(count):
        changed = copy.deepcopy(table)
        entries = changed.get(where) or changed["optional-dependencies"][where]
        entries[index] = re.split("[<>=]", entries[index])[0] + ">=9999"
        assert tables_sha256(changed) != recorded_digest("requirements.txt")
        assert disagreements(changed, "requirements-publish.txt") == [entries[index]]
        if where != "publish":
            assert disagreements(changed, "requirements.txt") == [entries[index]]
            assert environment_yml(changed) != environment_yml(table)


def test_a_missing_dependency_is_noticed():
    table = copy.deepcopy(project())
    table["dependencies"].append("a-package-nobody-pinned")
    assert disagreements(table, "requirements.txt") == ["a-package-nobody-pinned"]
