"""A class is graded: everybody gets what was earned, and nobody more."""

import csv
import html
import os
import re
import shutil
from dataclasses import replace

import nbformat
import numpy as np
import pytest

from pgm_book.ch02 import checks as chapter2
from pgm_book.common import checks
from pgm_book.course import box, feedback, grade, intake, library
from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import student_copy
from tests.course import classroom

ALL = os.environ.get("PGM_LAB_LARGEST_SAMPLES")  # in test-all: minutes
WHY = box.closed()
needs_box = pytest.mark.skipif(bool(WHY), reason=WHY or "there is a box")
EXERCISES = {(one.lesson, one.name): one for one in grade.exercises()}
TWO = [one for one in EXERCISES.values() if one.lesson == "2"]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """The libraries of the exercises of lesson 2."""
    found = tmp_path_factory.mktemp("libraries")
    (found / "library").mkdir()
    library.write_library(found / "library")
    for one in TWO:
        library.without(found / "library", found / f"2-{one.name}", one.books_own)
    return found


@pytest.fixture(scope="module")
def class_of(tmp_path_factory):
    folder = tmp_path_factory.mktemp("class")
    classroom.write(folder)
    return {one.student: one for one in intake.read(folder)}


def points(submission, place, name, secret="word", **how):
    how.setdefault("trusted", bool(WHY))
    mark = grade.marked(EXERCISES["2", name], submission, place, secret, **how)
    return mark.points, mark.said


def of_program(text, student="Ada"):
    return intake.Submission(student, (), text, {}, ())


# --- One exercise ---


@pytest.mark.parametrize("trusted", [pytest.param(False, marks=needs_box), True])
def test_solved_unusual_wrong_and_empty_answers_get_what_they_earn(
    place, class_of, trusted
):
    got = {
        who: points(class_of[who], place, "line", trusted=trusted)
        for who in ("Ani", "Budi", "Citra", "Dewi", "Eko")
    }
    assert got["Ani"] == got["Budi"] == (10, "")
    assert got["Citra"][0] == 0 and "the gain comes last" in got["Citra"][1]
    assert got["Dewi"][0] == 0
    assert got["Eko"] == (0, "line: a part of the answer is still `...`. Your turn!")


def test_a_property_that_holds_is_worth_its_points(place):
    text = "import numpy as np\ndef line(x, y):\n    beta = np.std(y) / np.std(x)\n"
    text += (
        "    return np.mean(y) - beta * np.mean(x), beta\n"  # exact, not least squares
    )
    earned, said = points(of_program(text), place, "line")
    assert earned == EXERCISES["2", "line"].points["exact where y is a line of x"]
    assert "another gain" in said


def test_who_calls_the_books_own_gets_nothing_and_hears_it(place, class_of):
    for name in ("correlation", "correlation_map", "peak_of_parabola"):
        assert points(class_of["Dewi"], place, name) == (
            0,
            "it calls the book's own function; write yours.",
        )
    text = "from pgm_lab import ncc\n"
    text += "def correlation(a, b):\n    return ncc.regression(a, b).r"  # in a field
    assert points(of_program(text), place, "correlation")[0] == 0
    text = "from pgm_lab import ncc\ndef line(x, y):\n    r = ncc.correlation(x, y)\n"
    text += "    b = r * y.std() / x.std()\n    return y.mean() - b * x.mean(), b"
    assert points(of_program(text), place, "line") == (10, "")  # as a help in another


def test_who_lets_a_near_function_do_the_work_is_named_and_keeps_the_points(place):
    text = "import pgm_lab.ncc\nfrom pgm_lab.ncc import correlation as r\n"
    text += "import numpy as np\n"
    text += "def of_two(a, b): return r(a, b)\ndef correlation_map(template, search):\n"
    text += (
        "    windows = np.lib.stride_tricks.sliding_window_view(search, template.shape)"
    )
    text += "\n    return [[of_two(template, w) for w in line] for line in windows]"
    mark = grade.marked(
        EXERCISES["2", "correlation_map"], of_program(text), place, "word", trusted=True
    )
    said = "calls pgm_lab.ncc.correlation, which may do much of the work"
    assert mark.points == 10 and said in mark.said and mark.remarks == (said,)


def test_a_table_of_the_notebooks_inputs_earns_nothing(place):
    seen = []

    def watched(before, middle, after):
        top = (before - after) / (2 * (before - 2 * middle + after))
        seen.append(((before, middle, after), top))
        return top

    chapter2.peak_of_parabola(watched)
    text = (
        f"TABLE = {dict(seen)}\ndef peak_of_parabola(*v):\n    return TABLE.get(v, 0.0)"
    )
    names = {}
    exec(text, names)
    chapter2.peak_of_parabola(names["peak_of_parabola"])  # right in the notebook
    assert points(of_program(text), place, "peak_of_parabola")[0] == 0


def test_the_notebooks_answers_in_their_order_earn_nothing(place):
    answers = []

    def watched(a, b):
        answers.append(float(np.corrcoef(a.ravel(), b.ravel())[0, 1]))
        return answers[-1]

    chapter2.correlation(watched)
    text = f"L = {answers}\ndef correlation(*_):\n    L.append(L.pop(0))\n"
    text += "    return L[-1]\n"
    names = {}
    exec(text, names)
    chapter2.correlation(names["correlation"])  # right in the notebook
    for who in "Ada", "Bob", "Eva":
        earned, said = points(of_program(text, who), place, "correlation")
        assert earned == 0 and "two answers to the same question" in said


def test_the_same_submission_gets_the_same_inputs_and_another_gets_others(place):
    text = (
        "import os\ndef correlation(a, b):\n    raise ValueError(repr(a[0].tolist()))"
    )
    said = [
        points(of_program(text + more, who), place, "correlation", secret)[1]
        for who, more, secret in [
            ("Ada", "", "word"),
            ("Ada", "", "word"),
            ("Bob", "", "word"),
            ("Ada", "\n", "word"),
            ("Ada", "", "other"),
        ]
    ]
    assert said[0] == said[1] and len(set(said)) == 4


def test_a_program_makes_good_for_a_notebook_and_the_other_way_round(place, class_of):
    for book, program in (("Eko", "Budi"), ("Ani", "Citra")):
        both = replace(class_of[book], program=class_of[program].program)
        assert points(both, place, "line") == (10, "")


@pytest.mark.slow
def test_a_task_is_judged_with_other_data_by_what_it_hands_in(place, class_of):
    assert points(class_of["Ani"], place, "task") == (20, "")
    assert points(class_of["Budi"], place, "task")[0] == 0
    for result, said in {
        "None": "the result must be",
        "np.zeros((30, 2))": "30 wrong (each counts 2)",
        "{'a': 1}": "the result must be",
        "'text'": "the result must be",
    }.items():
        source = f"import numpy as np\nmine.hand_in({result})"
        one = intake.Submission("Ada", (), "", {"2": source}, ())
        earned, why = points(one, place, "task")
        assert earned == 0 and said in why, result
    blank = intake.Submission("Ada", (), "", {"2": "1 / 0"}, ())
    assert "nothing was handed in" in points(blank, place, "task")[1]


# --- A class ---


def killed_at_some(job):
    """Grade as ever, but die: at Eva always, at Bob once, at Jo by an error."""
    submission, _, place, *_ = job
    died = place / submission.student
    if submission.student == "Jo":
        raise MemoryError("none left")
    if submission.student == "Eva" or submission.student == "Bob" and not died.exists():
        died.touch()
        os.kill(os.getpid(), 9)
    return grade._student(job)


@pytest.mark.slow
def test_who_kills_the_grading_process_takes_no_points_from_others(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(grade, "_student", killed_at_some)
    right = [of_program(classroom.UNUSUAL, who) for who in "Ada Bob Eva Jo Zoe".split()]
    asked = [EXERCISES["2", "line"]]
    marks = grade.graded(right, asked, "word", trusted=True, workers=2)
    got = {who: mine[0].points for who, mine in marks.items()}
    assert got == {"Ada": 10, "Bob": 10, "Eva": 0, "Jo": 0, "Zoe": 10}
    feedback.write(tmp_path, right, asked, marks, [], trusted=True)
    pages = [told(tmp_path / "feedback" / f"{who}.html") for who in ("Eva", "Jo")]
    for page in [told(tmp_path / "class.html"), *pages]:
        assert "it could not be graded, because" in page


def told(path):
    """Return the text of a page."""
    text = re.sub(
        r"<style>.*?</style>|<[^>]+>", " ", path.read_text("utf-8"), flags=re.S
    )
    return " ".join(html.unescape(text).split())


@needs_box
@pytest.mark.slow
def test_a_class_of_twelve(tmp_path, monkeypatch):
    folder = tmp_path / "class"
    folder.mkdir()
    classroom.write(folder)
    key = tmp_path / "key.txt"
    key.write_text("the key")
    before = set(tmp_path.rglob("*"))
    to = tmp_path / "grades"
    asked = ["2", "2c", "--secret", "nobody guesses it", "--to", str(to)]
    assert grade.main([str(folder), *asked]) == 0
    after = {path for path in tmp_path.rglob("*") if to not in [path, *path.parents]}
    assert after == before
    with (to / "grades.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    total = {row["student"]: float(row["total"]) for row in rows}
    assert rows[0]["student"] == "of" and total.pop("of") == 80
    assert total == {
        "'=cmd|' calc'!A0": 0,
        "Ani": 70,
        "Budi": 50,
        "Citra": 4,  # of its map what is right
        "Dewi": 0,
        "Eko": 0,
        "Fajar": 0,
        "Gita": 0,
        "Hadi": 0,
        "Indah": 0,
        "Joko": 0,
        "Kartika": 50,
    }
    (ani,) = [row for row in rows if row["Identifier"]]
    assert [ani[name] for name in feedback.WORKSHEET] == ["Participant 101", "70", ""]
    page = told(to / "class.html")
    for remark in (
        "2 correlation_map, 2 peak_of_parabola: calls the book's own function",
        "gives checks.report another value",
        "gives np.allclose another value",
        "ended the program",
        "it gave no answer in 10 seconds",
        "tried to start another process",
        "it ended its process",
        "tried to reach a network",
        "No module named 'pgm_book.course'",
        "../../escaped.ipynb: its path leads out of the zip, not read",
        "a link, which is not followed",
        "2 line: an output says that it passed its check",
        "Ani, the book's solution 100 %",
        "Budi, Kartika 100 %",
    ):
        assert remark in page, remark
    assert "without a box" not in page
    pages = {path.stem: told(path) for path in (to / "feedback").iterdir()}
    assert len(pages) == 12 and "50 of 80 points" in pages["Budi"]
    assert "✗ least squares where it is not" in pages["Citra"]
    assert "– any network" not in pages["Citra"]


@needs_box
@pytest.mark.slow
def test_a_lesson_solved_earns_all_and_blank_nothing(tmp_path):
    for who in ("solved", "blank"):
        (tmp_path / who).mkdir()
    for path in FOLDER.glob("*.ipynb"):
        shutil.copy(path, tmp_path / "solved")
        blank = student_copy(nbformat.read(path, as_version=4))
        nbformat.write(blank, tmp_path / "blank" / path.name)
    asked = [one for one in grade.exercises() if ALL or one.lesson in ("3", "5", "6c")]
    marks = grade.graded(intake.read(tmp_path), asked, "word", workers=2)
    assert [(m.exercise, m.said) for m in marks["solved"] if m.points < m.most] == []
    assert [(m.exercise, m.said) for m in marks["blank"] if m.points] == []


@pytest.mark.slow
def test_without_a_box_a_class_is_refused_unless_it_is_trusted(
    tmp_path, capsys, monkeypatch
):
    (tmp_path / "class" / "Ada").mkdir(parents=True)
    text = "def line(x, y):\n    return 0.0, 1.0\n"
    (tmp_path / "class" / "Ada" / "my_pgm.py").write_text(text)
    monkeypatch.setattr(box, "closed", lambda: "bubblewrap is not installed")
    asked = [str(tmp_path / "class"), "2", "--to", str(tmp_path / "to")]
    assert grade.main(asked) == 1
    assert "TRUSTED=yes" in capsys.readouterr().err and not (tmp_path / "to").exists()
    assert grade.main([*asked, "--trusted"]) == 0
    assert "ran without a box" in told(tmp_path / "to" / "class.html")
    word = (tmp_path / "to" / "secret.txt").read_text()
    assert grade.kept_secret(tmp_path / "to") == word.strip() and len(word) > 12


@pytest.mark.slow
def test_half_a_character_in_what_was_handed_in_harms_nobody(tmp_path):
    (tmp_path / "class" / "Ada").mkdir(parents=True)
    text = "def line(x, y):\n    raise ValueError('\\ud800')\n"
    (tmp_path / "class" / "Ada" / "my_pgm.py").write_text(text)
    asked = [str(tmp_path / "class"), "2", "--to", str(tmp_path / "to"), "--trusted"]
    assert grade.main(asked) == 0
    assert "ValueError: ?" in told(tmp_path / "to" / "feedback" / "Ada.html")


def test_a_name_is_no_formula_whatever_separates_the_cells():
    assert feedback.safe(" =1+1") == "' =1+1"
    assert feedback.safe("Ada;=1+1") == "Ada,=1+1"


def test_who_hands_in_many_copies_to_guess_is_tried_a_few_times():
    cells = ("def search_width(*_): return 1",)
    name = "02_normalized_cross_correlation.ipynb"
    many = tuple(intake.Notebook(f"{name}", cells, (), str(k)) for k in range(9))
    submission = intake.Submission("Ada", many, "", {}, ())
    tried = [*grade._candidates(EXERCISES["2", "search_width"], submission)]
    assert len([one for one in tried if one]) == grade.COPIES


def test_a_command_that_cannot_be_followed_is_answered(tmp_path, capsys):
    (tmp_path / "Ada").mkdir()
    (tmp_path / "Ada" / "my_pgm.py").write_text("x = 1")
    for asked, said in (
        ([""], "which submissions?"),
        ([str(tmp_path / "missing")], "no such folder"),
        ([str(tmp_path), "--trusted", "2", "12"], "12 is not in the rubric"),
        ([str(tmp_path), "--rubric", str(tmp_path / "none.csv")], "none.csv"),
        ([str(tmp_path), "--secret", "too short"], "12 characters or more"),
    ):
        assert grade.main([*asked, "--trusted"]) == 1
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("2,line,exact where y is a line of x,-1", "line 2: a row has lesson"),
        ("2,line,exact where y is a line of x,many", "line 2"),
        ("2,line,exact where y is a lime,1", "line 2: no check names this property"),
        ("2,line", "line 2"),
        ("2,lime,exact where y is a line of x,1", "line 2: no check names"),
        ("12,line,exact where y is a line of x,1", "line 2: no check names"),
    ],
)
def test_a_rubric_that_does_not_fit_is_named(tmp_path, rows, said):
    path = tmp_path / "rubric.csv"
    path.write_text(f"lesson,exercise,property,points\n{rows}\n")
    with pytest.raises(ValueError, match=said):
        grade.exercises(path)


def test_a_rubric_decides_what_is_graded(tmp_path):
    path = tmp_path / "rubric.csv"
    text = "lesson,exercise,property,points\n2,line,least squares where it is not,3.5\n"
    path.write_text(f"\ufeff{text}", encoding="utf-8")  # as Excel saves it
    (one,) = grade.exercises(path)
    assert (one.lesson, one.name, one.most) == ("2", "line", 3.5)


def test_each_check_of_the_notebooks_can_be_called_by_the_grader():
    calls = [one for one in EXERCISES.values() if one.name != "task"]
    assert len(calls) == 59 and len(EXERCISES) - len(calls) == 10
    assert all(one.call.startswith("chapter") and one.names for one in calls)
    assert issubclass(checks.CheckFailed, AssertionError)
