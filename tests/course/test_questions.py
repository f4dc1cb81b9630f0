"""The choice questions: all of them, right, complete, and each able to stand alone."""

import re
import tomllib
from html import unescape

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from pgm_book.common.predict import BOOK, choices_of
from pgm_book.course import exam, questions
from pgm_book.course.numbers import VARIANTS, number_questions
from pgm_book.make.environment import ROOT
from pgm_lab import datasets

ASKED = questions.choice_questions(ROOT / "notebooks")
ALL = [one for some in ASKED.values() for one in some]


def predictions():
    """The numbers of all predictions in the tables of the chapters."""
    found = set()
    for path in BOOK.glob("ch*/*predictions.csv"):
        lines = path.read_text(encoding="utf-8").splitlines()[1:]
        found |= {line.partition(",")[0] for line in lines}
    return found


def test_every_prediction_is_asked_once_or_left_out_by_name():
    numbers = [one.number for one in ALL]
    assert len(numbers) == len(set(numbers))
    left_out = questions.left_out()
    assert set(numbers) | set(left_out) == predictions()
    assert not set(numbers) & set(left_out)
    assert set(left_out) == {"4c.1", "5c.3"} and all(left_out.values())


def test_no_two_questions_of_a_paper_rest_on_one_fact(monkeypatch):
    numbers = {exam.name_of(one) for one in [*ALL, *number_questions()]}
    assert set().union(*exam.FACTS) <= numbers
    monkeypatch.setattr(exam, "choice_questions", lambda _: ASKED)
    monkeypatch.setattr(exam, "variants", lambda one: [one])
    for seed in range(1, 41):
        paper = exam.choose(str(seed), [], ROOT / "notebooks")
        asked = {exam.name_of(one) for one in [*paper.choices, *paper.numbers]}
        assert len(asked) == 30
        assert all(len(fact & asked) < 2 for fact in exam.FACTS)


def test_readme_counts_them():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"the {len(ALL)} predictions and quick questions that" in readme
    counted = f"{len(number_questions())} questions with numbers in {VARIANTS} variants"
    assert counted in readme


def test_choices_and_feedback_are_those_of_the_notebooks():
    for one in ALL:
        rows = choices_of(one.number)
        assert [c.text for c in one.choices] == [row["choice"] for row in rows]
        assert [c.feedback for c in one.choices] == [row["feedback"] for row in rows]
        assert [c.right for c in one.choices].count(True) == 1
        assert all(c.text and c.feedback for c in one.choices)


def test_no_question_points_to_what_it_does_not_carry():
    for one in ALL:
        assert "Predict.**" not in one.text and one.text.strip() and one.title
        found = re.search("figure|sketch|click|± above|sentence above", one.text, re.I)
        # "Figure 3.1 of the paper draws ...", and says what it draws
        assert not found or one.number in ("7c.5", "8c.4") or one.picture, one.number


def test_figures_are_png_with_a_description():
    pictures = [one.picture for one in ALL if one.picture]
    assert len(pictures) == 9
    for one in pictures:
        assert one.png.startswith(b"\x89PNG") and len(one.alt) > 40


def test_what_stands_beside_a_question_belongs_to_one():
    beside = tomllib.loads(questions.BESIDE.read_text(encoding="utf-8"))
    assert set(beside) <= predictions()
    for extra in beside.values():
        assert extra and set(extra) <= {"before", "cell", "cut", "left_out"}


def test_formulas_are_tex_between_brackets():
    for one in ALL:
        page = questions.html(one.text)
        assert page.count("\\(") == page.count("\\)")
        assert page.count("\\[") == page.count("\\]")
        assert "$" not in page and not re.search(r"<\w+ [^>]", page)
    assert questions.html("$a < b$ and $$c$$") == "<p>\\(a &lt; b\\) and \\[c\\]</p>"


def lesson(monkeypatch, folder, *cells):
    """Let the book have one chapter, with these cells."""
    nbformat.write(new_notebook(cells=list(cells)), folder / "one.ipynb")
    rows = [{"number": "1", "notebook": "one"}, {"number": "2", "notebook": ""}]
    monkeypatch.setattr(datasets, "rows", lambda name: rows)
    return questions.choice_questions(folder)["1"]


def predicting(number):
    source = f'checks.predict("{number}")'
    return new_code_cell(source, metadata={"tags": ["predict"]})


def test_a_number_stays_when_the_order_changes(monkeypatch, tmp_path):
    one = (
        new_markdown_cell("## First · 3 min\n\n**Predict.** Signs?"),
        predicting("1.1"),
    )
    two = new_markdown_cell("### Other\n\n**Predict** the size."), predicting("1.5")
    forth = lesson(monkeypatch, tmp_path, *one, *two)
    back = lesson(monkeypatch, tmp_path, *two, *one)
    assert {q.number: q for q in forth} == {q.number: q for q in back}
    assert [(q.title, q.text) for q in forth] == [
        ("First", "Signs?"),
        ("Other", "Predict the size."),
    ]


def test_a_text_that_no_longer_fits_is_named(monkeypatch, tmp_path):
    cells = new_markdown_cell("**Predict.** Other words."), predicting("1.6")
    with pytest.raises(ValueError, match="Nobody is wrong.*Other words"):
        lesson(monkeypatch, tmp_path, *cells)


def test_a_figure_that_is_gone_is_named(monkeypatch, tmp_path):
    cells = new_markdown_cell("**Predict.** x (chapter 6)"), predicting("1.4")
    with pytest.raises(ValueError, match="cell lesson1-35 has no stored figure"):
        lesson(monkeypatch, tmp_path, *cells)


def test_quick_questions_have_their_own_words():
    (one,) = (q for q in ASKED["1"] if q.number == "1.10")
    assert one.text == one.title == "image.shape begins with the number of"
    assert not any(re.match(r"\d\. ", unescape(q.text)) for q in ALL)
