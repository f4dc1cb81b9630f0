"""The runner of the mutations tells what is noticed from what is not."""

from multiprocessing import forkserver

import pytest

from pgm_book.make import mutations

ROW = {
    "number": "1",
    "file": "pgm_lab/half.py",
    "old": "x / 2",
    "new": "x / 3",
    "breaks": "the half",
    "tests": "tests/test_half.py",
}


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A package of one function, whose test looks at one of its values."""
    monkeypatch.setattr(mutations, "LIBRARIES", ["nbval.plugin", "hypothesis"])
    root = tmp_path / "project"
    for folder in ("pgm_lab", "tests"):
        (root / folder).mkdir(parents=True)
    for name in ("conftest.py", "pyproject.toml", "pgm_lab/__init__.py"):
        (root / name).touch()
    (root / "pgm_lab" / "half.py").write_text("def half(x):\n    return x / 2\n")
    test = (
        "from pgm_lab.half import half\n\ndef test_half():\n    assert half(4) == 2\n"
    )
    (root / "tests" / "test_half.py").write_text(test)
    (root / "tests" / "test_other.py").write_text("def test_nothing():\n    pass\n")
    yield root
    if mutations.FORKS:  # the process from which the tests were forked
        forkserver._forkserver._stop()


@pytest.mark.slow
def test_the_killed_are_told_from_the_survivors(project):
    rows = [ROW, ROW | {"number": "2", "new": "x - 2"}]
    found = mutations.tried(rows, project, 120, trust=True)
    assert found == {"1": "killed", "2": "survived"}
    assert (project / "pgm_lab" / "half.py").read_text().endswith("return x / 2\n")


@pytest.mark.slow
def test_a_mutation_that_never_ends_is_killed_by_the_time_limit(project):
    endless = ROW | {"old": "    return", "new": "    while True: x / 2\n    return"}
    found = mutations.tried([endless], project, 5, trust=True)
    assert found == {"1": mutations.SLOW}


def test_an_outdated_list_fails_before_anything_is_run(project):
    with pytest.raises(ValueError, match="fault 1: 'x / 5' occurs 0 times in"):
        mutations.tried([ROW | {"old": "x / 5"}], project, 20)


def test_verdicts_are_written_into_their_column(tmp_path):
    path = tmp_path / "list.csv"
    path.write_text("number,before\n1,\n2,survived\n", encoding="utf-8")
    mutations.record("before", {"1": "killed"}, path)
    assert path.read_text() == "number,before\n1,killed\n2,survived\n"


def test_the_list_names_lines_and_tests_that_exist():
    rows = mutations.listed()
    numbers = [int(row["number"]) for row in rows]
    assert numbers == sorted(set(numbers))  # what is gone leaves its number
    for row in rows:
        assert row["breaks"] and "\n" not in row["old"]
        assert all((mutations.ROOT / name).exists() for name in row["tests"].split())
        mutations.mutated(row)
