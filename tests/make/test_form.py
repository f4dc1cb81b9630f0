"""Lessons and cases keep to the form, and what is too much is named with its place."""

import csv
import re

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_output

from pgm_book.make import form
from pgm_book.make.chapter import TEMPLATES, filled
from pgm_book.make.errors import PublishError
from pgm_book.make.notebooks import FOLDER

WORDS = {"NUMBER": "7", "FILE": "07", "TITLE": "A trial", "QUESTION": "Does it run?"}


KINDS = form.kinds()


@pytest.mark.parametrize(("name", "kind"), KINDS.items(), ids=list(KINDS))
def test_no_lesson_and_no_case_has_a_problem(name, kind):
    """Their names say which they are."""
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    assert form.problems(notebook, kind) == []
    assert ("_case_" in name) == (kind == "case")
    assert len(KINDS) > 15
    code = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    asked = re.findall(r'(?:predict\(|^    )"\w+\.(\d+)"[):]', code, re.M)
    assert asked == [str(k) for k in range(1, len(asked) + 1)]  # one order everywhere


def test_each_prediction_has_one_right_choice_and_a_sentence_on_each():
    found: dict[str, list] = {}
    files = sorted(form.ROOT.glob("pgm_book/ch*/*predictions.csv"))
    texts = [path.read_text(encoding="utf-8").splitlines() for path in files]
    for row in (row for text in texts for row in csv.DictReader(text, strict=True)):
        found.setdefault(row["prediction"], []).append(row)
        assert row["right"] in ("yes", "no")
        assert row["feedback"].endswith((".", "!")), row
        assert form.words(row["choice"]) <= 15 and form.words(row["feedback"]) <= 40, (
            row
        )
    assert len(found) > 60
    for number, rows in found.items():
        assert 2 <= len(rows) <= 5, number
        assert [row["right"] for row in rows].count("yes") == 1, number


def template(kind="lesson"):
    text = (TEMPLATES / f"{kind}.ipynb").read_text(encoding="utf-8")
    return nbformat.reads(filled(text, WORDS), as_version=4)


def test_counted_is_what_a_student_gets():
    lesson = template()
    before = form.counts(lesson)
    notes = {"slideshow": {"slide_type": "notes"}}
    lesson.cells.insert(3, new_markdown_cell("word " * 100, metadata=notes))
    solution = {"tags": ["solution"]}
    lesson.cells.insert(3, new_markdown_cell("word " * 100, metadata=solution))
    lesson.cells[-1].source += "\nassert True" * 10  # the claims
    assert form.counts(lesson) == before
    derive = {"tags": ["derive"]}
    lesson.cells.insert(3, new_markdown_cell("word " * 100, metadata=derive))
    assert form.counts(lesson) == before | {"cells": before["cells"] + 1}


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("Two words.", 2),
        ("It's *one* **word** less", 4),
        ("$x = 1$ is a formula, $$y\n= 2$$ too", 6),
        ("[a link](https://example.org/a/b) <b>bold</b>", 3),
        ("| a | b |\n|:--|--:|\n| 1.5 | - |", 3),
        ("", 0),
    ],
)
def test_words_are_what_is_read(text, number):
    assert form.words(text) == number


def at(lesson, tag):
    """The first cell with this tag."""
    return next(c for c in lesson.cells if tag in c.metadata.get("tags", []))


def add(*cells):
    """Put cells into the first section, behind its heading."""

    def change(lesson):
        place = next(k for k, c in enumerate(lesson.cells) if "## How" in c.source)
        lesson.cells[place + 1 : place + 1] = [cell.copy() for cell in cells]

    return change


def replace(old, new):
    def change(lesson):
        (cell,) = [cell for cell in lesson.cells if old in cell.source]
        cell.source = cell.source.replace(old, new)

    return change


def drop(tag):
    def change(lesson):
        cells = lesson.cells
        lesson.cells = [c for c in cells if tag not in c.metadata.get("tags", [])]

    return change


def retag(tag, *new):
    def change(lesson):
        at(lesson, tag).metadata["tags"] = list(new)

    return change


def lose(tag, pattern, rest=""):
    """Take something out of the cell with a tag."""

    def change(lesson):
        cell = at(lesson, tag)
        cell.source = re.sub(pattern, rest, cell.source)

    return change


PRINTED = [new_output("stream", text="1\n")]
FOLDED = {"tags": ["hide-input"]}
HIDDEN = {"jupyter": {"source_hidden": True}}
SECTION = r"'How large is a pixel on the ground\?'"
BREAKS = [
    (add(*[new_markdown_cell("a")] * 37), rf"65 cells, 5 too many; .* {SECTION}: \d+"),
    (
        add(new_markdown_cell("word " * 1900)),
        rf"2414 words, 214 .* {SECTION}: 2",
    ),
    (
        replace(" · 4 min", " · 60 min"),
        "89 minutes, 29 too many; most are in 'What you have now': 60",
    ),
    (replace(" · 4 min", ""), "section 'What you have now' ends without its minutes"),
    (replace(" · 4 min", " · 5 min"), "head says 33 minutes; the sections give 34"),
    (replace("About **33 minutes**", "Short"), "head says no minutes: .* give 33"),
    (replace("You need", "Take"), "the head does not say what it needs"),
    (
        add(new_code_cell("x = 1\n" * 9, metadata=FOLDED)),
        r"9 of \d\d lines .* are folded",
    ),
    (
        add(new_code_cell("x = 1", metadata=HIDDEN)),
        "is folded and shows nothing",
    ),
    (add(new_code_cell("x = 1\n" * 16)), "has 16 lines, over 15"),
    (add(new_code_cell("if True:\n    assert 1")), "asserts: put it into the cell of"),
    (
        lambda lesson: lesson.cells.insert(4, lesson.cells.pop()),
        "1 cells of claims; there must be one, at the very end",
    ),
    (drop("claims"), "0 cells of claims"),
    (retag("predict", "draw"), "checks.predict goes with the tag predict"),
    (replace("plot.table(", "plot.show("), "spells out its alt text"),
    (drop("check"), "is an exercise, and no check follows it"),
    (lose("derive", "<summary>.*</summary>"), "must be one <details> with a <summary>"),
    (
        lose("why", "</summary>\n\n", "</summary>\n"),
        "must be one <details> with a <summary>, and empty lines",
    ),
    (drop("predict"), "no cell is tagged predict"),
    (drop("derive"), "no cell is tagged derive"),
    (drop("why"), "no cell is tagged why"),
    (replace("10 minutes, 4", "4"), rf"section {SECTION} has no note that begins with"),
    (
        replace("2 minutes. Ask", "36 minutes. Ask"),
        "a lecture of 46 minutes, 1 too many; most are in 'What you have now': 36",
    ),
    (replace("task · 15 min", "task · 9 min"), "one section: ## Your task · 15 min"),
    (drop("task"), "one cell tagged task must hold the solution"),
    (replace("\nchecks.keep(ground_size)", ""), "no check keeps the reader's function"),
]


@pytest.mark.parametrize(("spoil", "finding"), BREAKS)
def test_each_break_is_named(spoil, finding):
    lesson = template()
    spoil(lesson)
    found = form.problems(lesson, "lesson")
    assert any(re.search(finding, line) for line in found), found


def test_a_section_cannot_be_read_faster_than_anybody_reads():
    lesson = template()
    # a folded cell with an output is allowed
    add(new_code_cell("x", metadata=FOLDED, outputs=PRINTED))(lesson)
    assert form.problems(lesson, "lesson") == []
    replace("· 14 min", "· 2 min")(lesson)
    add(new_markdown_cell("word " * 400))(lesson)
    found = form.problems(lesson, "lesson")
    assert any(re.search(r"has \d+ words for 2 min: more than 200", f) for f in found)


def test_a_lesson_is_refused_and_what_is_none_is_listed(tmp_path, capsys):
    (tmp_path / "data").mkdir()
    rows = "notebook,form\n01_other,\n09_new,lesson\n"
    (tmp_path / "data" / "chapters.csv").write_text(rows, encoding="utf-8")
    other, new = (tmp_path / "notebooks" / f"{n}.ipynb" for n in ("01_other", "09_new"))
    form.judge({other: ["slide 2: too full"], new: []}, "not fit")
    assert capsys.readouterr().err == "publish: 01_other.ipynb, slide 2: too full\n"
    with pytest.raises(PublishError, match="not fit\n  09_new.ipynb, slide 3\nMend"):
        form.judge({other: [], new: ["slide 3"]}, "not fit", "Mend it.")


def test_the_command_prints_the_counts_of_the_named(capsys):
    assert form.main(["02"]) in (0, 1)
    shown = capsys.readouterr().out
    assert "02_normalized_cross_correlation" in shown and "03_" not in shown
