"""A task: everybody's own data, a result that is judged, tries that are kept."""

import importlib.util
import json
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book import task
from pgm_book.common.own_program import CheckFailed
from pgm_book.make.chapter import TEMPLATES


@pytest.fixture(autouse=True)
def lesson(monkeypatch, tmp_path):
    """The task of the template, in an empty folder; its picture is drawn and closed."""
    spec = importlib.util.spec_from_file_location("bus", TEMPLATES / "task.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "bus", module)
    spec.loader.exec_module(module)
    monkeypatch.setattr(task, "_lesson", lambda number: module)
    monkeypatch.setattr(task.plot, "show", lambda figure, alt: plt.close(figure))
    monkeypatch.chdir(tmp_path)
    return module


def solved(mine):
    """The principal distance by least squares, from the file."""
    height, length = np.loadtxt(mine.folder / "bus.csv", delimiter=",", skiprows=1).T
    a = 12 / (0.004 * height)
    return np.sum(a * length) / np.sum(a * a)


def test_a_name_makes_the_same_data_everywhere_and_its_neighbour_others():
    ada = task.start(1, "Ada Lovelace")
    assert ada.digest[:16] == "0d46689088a6f2ba"  # on every machine and version
    assert task.start("1", "  ada   LOVELACE ").digest == ada.digest
    others = [(1, "Ada Lovelac"), (2, "Ada Lovelace")]
    digests = {task.start(*other).digest for other in others}
    digests |= {ada.digest, task.start(1, "Ada Lovelace", secret="marks").digest}
    assert len(digests) == 4
    assert repr(ada) == "Task 1 for Ada Lovelace: bus.csv"


@pytest.mark.parametrize("name", ["", "  ", None, 7])
def test_a_task_needs_a_name(name):
    with pytest.raises(ValueError, match="name must be a text"):
        task.start(1, name)


def test_what_is_hardly_off_is_off_by_nothing():
    assert str(task.Part("sd", 1.27e-7)) == "sd: 0 standard deviations (3 allowed)"
    assert str(task.Part("zero", 0.04326, 0.1, "px")) == "zero: 0.0433 px (0.1 allowed)"


def test_without_a_program_nothing_is_left_in_the_folder(tmp_path, capsys):
    mine = task.start(1, "Ada")
    mine.hand_in(solved(mine))
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr().out.startswith(
        "Your data are in a temporary folder: bus.csv.\n✓ Task 1, try 1. c: "
    )


def test_a_second_start_overwrites_nothing(tmp_path):
    (tmp_path / "my_pgm.py").write_text("", encoding="utf-8")
    first = task.start(1, "Ada")
    mark = (first.folder / "bus.csv").stat().st_mtime_ns
    assert task.start(1, "Ada").folder == first.folder
    assert (first.folder / "bus.csv").stat().st_mtime_ns == mark
    other = task.start(1, "Grace")
    assert (first.folder.name, other.folder.name) == ("task_01", "task_01-2")
    (first.folder / "bus.csv").write_text("my notes", encoding="utf-8")
    assert task.start(1, "Ada").folder.name == "task_01-3"
    assert (first.folder / "bus.csv").read_text(encoding="utf-8") == "my notes"


def test_the_tolerance_follows_from_the_noise():
    """Of 300 names the best solution is beyond three sd about once; chi-square."""
    off = [
        mine.judged(solved(mine))[0].off
        for mine in (task.start(1, f"name {k}") for k in range(300))
    ]
    assert np.mean(np.square(off)) == pytest.approx(1, abs=4 * np.sqrt(2 / 300))
    assert np.sum(np.array(off) > 3) <= 4


def test_wrong_results_fail_and_a_hint_names_the_slip(lesson, capsys):
    mine, other = task.start(1, "Ada"), task.start(1, "Grace")
    with pytest.raises(CheckFailed, match="hand a result in first"):
        mine.hint()
    for words, wrong in lesson.slips(mine._truth).items():
        with pytest.raises(CheckFailed, match="standard deviations .3 allowed"):
            mine.hand_in(wrong["c"])
        capsys.readouterr()
        mine.hint()
        assert capsys.readouterr().out == f"{words}\n"
    with pytest.raises(CheckFailed, match="mine.hint"):
        mine.hand_in(solved(other))
    with pytest.raises(CheckFailed, match="one number: c in mm"):
        mine.hand_in("ten")
    with pytest.raises(CheckFailed, match="one number: c in mm"):
        mine.hint()  # of this one, not of the try before
    with pytest.raises(CheckFailed):
        mine.hand_in(np.nan)


@pytest.mark.parametrize(
    ("sds", "words"),
    [(0, ""), (6, "Far?"), (9.5, "Far?"), (10.5, "Farther?"), (4.5, "Draw the two")],
)
def test_the_nearest_slip_explains_what_it_would_make_right(
    lesson, monkeypatch, sds, words
):
    mine = task.start(1, "Ada")
    c, sd = mine._truth.answer["c"], mine._truth.sd
    slips = {"Farther?": {"c": c + 12 * sd}, "Far?": {"c": c + 8 * sd}}
    monkeypatch.setattr(lesson, "slips", lambda truth: slips)
    said = mine.explained({"c": c + sds * sd})
    assert said.startswith(words) if words else said == ""


WANTED = {"c": ("one number, in mm", ()), "axes": ("two words", None)}


@pytest.mark.parametrize("answer", [{"axes": 0, "c": "24", "d": 1}, (24, 0), [[24], 0]])
def test_an_answer_of_several_parts_is_a_dict_or_in_order(answer):
    assert task.named(answer, WANTED) == {"c": 24, "axes": 0}


@pytest.mark.parametrize("answer", [None, 24, {"c": 24}, (24,), "24"])
def test_all_parts_that_are_wanted_are_named_with_their_units(answer):
    with pytest.raises(CheckFailed, match='"c", one number, in mm; "axes", two words'):
        task.named(answer, WANTED)


def test_grey_values_are_whole_and_end_at_0_and_255():
    assert task.grey(np.array([-3, 1.6, 254.4, 300])).tolist() == [0, 2, 254, 255]


def test_each_try_is_kept_with_what_was_typed(tmp_path, monkeypatch):
    (tmp_path / "my_pgm.py").write_text("", encoding="utf-8")
    monkeypatch.setattr(task, "_typed", lambda: "mine.hand_in(π)")
    mine = task.start(1, "Ada")
    with pytest.raises(CheckFailed, match="try 1: c"):
        mine.hand_in(3.0)
    again = task.start(1, "ada")  # another day
    again.hand_in(solved(again))
    tries = json.loads((tmp_path / "my_results.json").read_text(encoding="utf-8"))
    assert [(one["task"], one["try"], one["passed"]) for one in tries] == [
        ("1", 1, False),
        ("1", 2, True),
    ]
    assert tries[1]["source"] == "mine.hand_in(π)" and 0 <= tries[1]["parts"]["c"] <= 3


@pytest.mark.parametrize("text", ["", "[{}]", '{"a": 1}', "[1]"])
def test_a_damaged_record_is_not_written_over(tmp_path, text):
    (tmp_path / "my_pgm.py").write_text("", encoding="utf-8")
    (tmp_path / "my_results.json").write_text(text, encoding="utf-8")
    mine = task.start(1, "Ada")
    with pytest.raises(CheckFailed, match="cannot be read. Nothing was written"):
        mine.hand_in(solved(mine))
    assert (tmp_path / "my_results.json").read_text(encoding="utf-8") == text
