"""The runner of the mutations tells what is noticed from what is not."""

import csv
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
    yield root
    if mutations.FORKS:  # the process from which the tests were forked
        forkserver._forkserver._stop()


@pytest.mark.slow
def test_the_killed_are_told_from_the_survivors(project, capsys):
    rows = [ROW, ROW | {"number": "2", "new": "x - 2"}]
    found = mutations.tried(rows, project, 120, trust=True)
    killer = "tests/test_half.py::test_half"
    assert found == {"1": ("killed", killer), "2": ("survived", "")}
    assert "1 killed" in capsys.readouterr().out
    assert (project / "pgm_lab" / "half.py").read_text().endswith("return x / 2\n")


@pytest.mark.slow
def test_a_mutation_that_never_ends_is_killed_by_the_time_limit(project):
    endless = ROW | {"old": "    return", "new": "    while True: x / 2\n    return"}
    found = mutations.tried([endless], project, 5, trust=True)
    assert found == {"1": (mutations.SLOW, "")}


@pytest.mark.slow
def test_tests_that_fail_anyhow_prove_nothing(project):
    (project / "pgm_lab" / "half.py").write_text("def half(x):\n    return x / 2 + 1\n")
    with pytest.raises(ValueError, match="fail without any mutation"):
        mutations.tried([ROW], project, 20)


def test_an_outdated_list_fails_before_anything_is_run(project):
    with pytest.raises(ValueError, match="mutation 1: 'x / 5' stands 0 times in"):
        mutations.tried([ROW | {"old": "x / 5"}], project, 20)


def test_verdicts_are_written_into_their_column(tmp_path):
    path = tmp_path / "list.csv"
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, [*ROW, "before"])
        writer.writeheader()
        writer.writerows([ROW, ROW | {"number": "2", "before": "survived"}])
    mutations.record("before", {"1": ("killed", "test_half")}, path)
    assert [row["before"] for row in mutations.mutations(path)] == [
        "killed",
        "survived",
    ]


@pytest.mark.slow
def test_a_drawn_fault_is_looked_for_in_its_room_and_then_in_others(project, tmp_path):
    drawn = {"number": "1", "file": "pgm_lab/half.py", "before": "return x / 2"}
    drawn |= {"after": "return x * 2", "occurrence": "1", "kind": "arithmetic"}
    (project / "tests" / "test_other.py").write_text("def test_nothing():\n    pass\n")
    drawn |= {"killer": "", "tests": "tests/test_other.py", "verdict": ""}
    rows = [drawn | {"others": "tests/test_half.py"}, drawn | {"number": "2"}]
    rows[1]["others"] = ""
    found = mutations.tried(rows, project, 120, trust=True)
    assert found["1"] == ("killed", "tests/test_half.py::test_half")
    assert found["2"] == ("survived", "")
    path = tmp_path / "drawn.csv"
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    mutations.record("verdict", found, path)
    killers = [row["killer"] for row in mutations.mutations(path)]
    assert killers == ["tests/test_half.py::test_half", ""]


def test_every_mutation_names_tests_that_exist_and_breaks_one_line():
    rows = mutations.mutations()
    assert [row["number"] for row in rows] == [str(n + 1) for n in range(len(rows))]
    for row in rows:
        assert row["breaks"] and "\n" not in row["old"]
        assert all((mutations.ROOT / name).exists() for name in row["tests"].split())


def test_the_killer_is_one_test_though_its_name_holds_spaces():
    row = {"killer": "a.py::test[no folder]", "tests": "a.py b.py", "others": ""}
    assert mutations.stages(row) == [["a.py::test[no folder]"], ["a.py", "b.py"]]
    assert mutations.stages(row | {"killer": ""}) == [["a.py", "b.py"]]
