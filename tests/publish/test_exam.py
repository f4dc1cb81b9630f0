"""The paper of an examination and its key, chosen, printed and read back."""

import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from io import BytesIO

import pytest
from pypdf import PdfReader

from pgm_book.course import exam
from pgm_book.course.numbers import Chance
from pgm_book.make.archive import date
from pgm_book.make.environment import ROOT
from pgm_book.make.handouts import _empty, plain, print_pdf
from pgm_book.make.tagged import read

NOTEBOOKS = ROOT / "notebooks"


def chosen(seed="7", *lessons):
    return exam.choose(seed, list(lessons), NOTEBOOKS)


def of(number):
    return number.partition(".")[0]


def test_two_hours_and_a_hundred_points_balanced_over_the_lessons():
    paper = chosen()
    assert (paper.minutes, paper.points) == (120, 100)
    assert Counter(of(one.number) for one in paper.choices) == {
        one: 2 for one in ["1", "A1", *"23456789"]
    }
    assert Counter(of(one.number) for one in paper.numbers) == {
        one: 1 for one in ["1", "A1", *"23456789"]
    }
    everything = [one.number for one in [*paper.choices, *paper.numbers]]
    assert len(set(everything)) == 30


def test_named_lessons_share_the_paper():
    paper = chosen("3", "a1", "5")
    assert Counter(of(one.number) for one in paper.numbers) == {"A1": 5, "5": 5}
    assert {of(one.number) for one in paper.choices} == {"A1", "5"}
    alone = chosen("3", "7")
    assert len(alone.numbers) in (6, 7)  # all it has, but one of a fact
    assert alone.points == 2 * len(alone.choices) + 6 * len(alone.numbers)


@pytest.mark.parametrize("lesson", ["0", "8m", "x", "1c"])
def test_a_lesson_without_questions_is_refused(lesson, capsys):
    assert exam.main(["7", lesson]) == 1
    assert f"no lesson {lesson.upper()}; give some of 1, A1" in capsys.readouterr().err


def test_the_same_seed_gives_the_same_paper_and_another_another():
    assert chosen() == chosen()
    one, other = chosen("7"), chosen("8")
    assert [q.number for q in one.numbers] != [q.number for q in other.numbers]


def test_balanced_takes_what_there_is(monkeypatch):
    monkeypatch.setattr(exam, "name_of", str)
    draw = Chance("balance")
    some = exam.balanced(draw, [["a"], list("bcdef"), ["g", "h"]], 6, [])
    assert len(some) == 6 and {"a", "g", "h"} <= set(some)
    assert exam.balanced(draw, [["a"], ["b"]], 6, []) == ["a", "b"]
    monkeypatch.setattr(exam, "FACTS", [{"a", "b"}])
    assert len(exam.balanced(draw, [["a"], ["b"]], 6, [])) == 1


@pytest.fixture(scope="module")
def printed(browser):
    """The paper and its key as PDF."""
    paper = chosen()
    return paper, [print_pdf(browser, exam.page(paper, key)) for key in (False, True)]


def letters(pdf):
    return plain("".join(piece.text for piece in read(pdf).pieces))


def test_paper_and_key_are_tagged_and_have_a_title(printed):
    for pdf, end in zip(printed[1], ("", ": key")):
        reader = PdfReader(BytesIO(pdf))
        assert reader.root_object["/MarkInfo"]["/Marked"]
        assert reader.metadata.title == f"Photogrammetry: examination 7{end}"
        assert reader.root_object["/Lang"] == "en"


def test_the_paper_asks_everything_and_tells_no_answer(printed):
    paper, (pdf, _) = printed
    shown = letters(pdf)
    for one in paper.choices:
        assert all(plain(choice.text) in shown for choice in one.choices)
        assert not any(plain(choice.feedback) in shown for choice in one.choices)
    for one in paper.numbers:
        first = re.sub(r"\$.*?\$", "$", one.text).partition("$")[0]
        assert plain(first) in shown
        assert plain(one.number) not in shown
    assert "formulas" in shown and "120minutes" in shown


def test_the_key_has_every_answer(printed):
    paper, (_, pdf) = printed
    shown = letters(pdf)
    for one in paper.choices:
        (right,) = (choice for choice in one.choices if choice.right)
        letter = "abcdef"[one.choices.index(right)]
        assert plain(letter + right.text + right.feedback) in shown
    for one in paper.numbers:
        assert plain(one.shown.replace("−", "")) in shown
        assert all(plain(words) in shown for words in one.slips)


def test_no_page_is_nearly_empty_and_no_question_is_divided(printed):
    paper, pdfs = printed
    for pdf in pdfs:
        assert not list(_empty(read(pdf)))
    pages = [plain(page.extract_text()) for page in PdfReader(BytesIO(pdfs[0])).pages]
    for one in paper.choices:
        assert any(all(plain(c.text) in page for c in one.choices) for page in pages)


def test_the_same_bytes_on_another_day(browser, printed):
    paper, pdfs = printed
    assert [print_pdf(browser, exam.page(paper, key)) for key in (False, True)] == pdfs
    assert b"/CreationDate (D:%s" % f"{date():%Y%m%d}".encode() in pdfs[0]


def test_a_figure_is_printed_with_its_description(browser):
    paper = chosen("7", "1")
    (one,) = (q for q in exam.choice_questions(NOTEBOOKS)["1"] if q.number == "1.4")
    paper = replace(paper, choices=[one], numbers=paper.numbers[:1])
    pieces = read(print_pdf(browser, exam.page(paper, key=False))).pieces
    assert one.picture.alt in [
        piece.text for piece in pieces if piece.kind == "picture"
    ]


def test_writes_both_files(tmp_path):
    command = [sys.executable, "-m", "pgm_book.course.exam", "5", "1"]
    run = subprocess.run(
        [*command, "--build", tmp_path], cwd=ROOT, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    names = [path.name for path in sorted((tmp_path / "exam").iterdir())]
    assert names == ["exam-5-1-key.pdf", "exam-5-1.pdf"]
    assert "exam-5-1.pdf" in run.stdout
