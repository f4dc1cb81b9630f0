"""What a deck is made of: questions, pace, break, verdicts, titles."""

import nbformat
import pytest
from nbformat.v4 import new_notebook, new_output

from pgm_book.common import checks, ledger
from pgm_book.make.form import form_of
from pgm_book.make.slides import (
    LEDGER,
    STEP,
    cards,
    divided,
    faults,
    for_slides,
    shares,
)
from pgm_book.make.student import slide_type, tags
from tests.publish.conftest import CHAPTERS
from tests.publish.example import ANSWER, QUESTION, code, quick_questions, text

NOTE = "notes"


def slides(*cells, audience="lecturer", stem="") -> list[list]:
    """Return what the cells become, slide by slide."""
    prepared = for_slides(new_notebook(cells=cells), audience, stem)
    return divided(prepared.cells)


def sources(slide) -> list[str]:
    return [cell.source for cell in slide]


def timings(found) -> list[int]:
    return [one[0].metadata.slideshow.get("data", {}).get("timing", 0) for one in found]


def lecture(*minutes: int) -> list:
    """A lesson whose sections take so many minutes of a lecture."""
    cells = [text("# Title", "slide"), text("60 minutes with the exercises.", NOTE)]
    for number, time in enumerate(minutes, start=1):
        cells += [
            text(f"## Section {number} · 9 min", "slide"),
            text("### More of it", "subslide"),
            text(f"{time} minutes. Ask first.", NOTE),
        ]
    return cells


# The quick questions


def test_a_quick_question_is_a_slide_and_its_answer_a_fragment_of_the_lecturers():
    cells = [text("# Title", "slide"), quick_questions()]
    lecturer, student = slides(*cells)[-1], slides(*cells, audience="student")[-1]
    assert lecturer[0].source == student[0].source
    assert student[0].source.startswith(f"### {QUESTION}\n")
    assert "<li>12.68 µm</li>\n<li>6.10 µm</li>" in student[0].source
    assert len(student) == 1 and ANSWER not in student[0].source
    assert lecturer[1].source == f"> **✓ B.** {ANSWER}"
    assert slide_type(lecturer[1]) == "fragment"


def test_a_prediction_that_slides_skip_is_no_quick_question():
    cell = quick_questions()
    del cell.outputs[0]  # the printed question
    assert len(slides(text("# Title", "slide"), cell)) == 1


@pytest.mark.parametrize("name", CHAPTERS)
def test_every_deck_is_fit_and_the_students_has_no_notes_and_answers(name):
    notebook = nbformat.read(CHAPTERS[name], as_version=4)
    lecturer, student = (
        for_slides(notebook, who, name).cells for who in ("lecturer", "student")
    )
    assert not form_of(CHAPTERS[name]) or faults(lecturer) == []
    assert len({cell.id for cell in lecturer}) == len(lecturer)
    taken = [cell for cell in lecturer if cell.id not in {one.id for one in student}]
    kept = [cell for cell in lecturer if cell.id in {one.id for one in student}]
    assert sources(kept) == sources(student)
    assert not any(slide_type(cell) == NOTE for cell in student)
    assert all(slide_type(c) == NOTE or "question" in tags(c) for c in taken)
    answers = [
        c for c in taken if "question" in tags(c) and slide_type(c) == "fragment"
    ]
    assert bool(answers) == (form_of(CHAPTERS[name]) == "lesson")
    shown = nbformat.writes(new_notebook(cells=student))
    assert not any(answer.source.split("** ")[1] in shown for answer in answers)


# The pace, and the break


def test_minutes_of_a_section_are_seconds_of_its_slides():
    predicted = code("checks.predict('1.1')", slide="subslide", tags=["predict"])
    found = slides(*lecture(10)[:-1], predicted, text("7 minutes.", NOTE))
    assert timings(found) == [0, 105, 105, 210]  # a prediction counts twice


def test_the_note_of_a_section_is_once_in_it_on_its_first_slide():
    found = slides(*lecture(10, 5), quick_questions())
    notes = [[c.source for c in one if slide_type(c) == NOTE] for one in found]
    first, second = ["10 minutes. Ask first."], ["5 minutes. Ask first."]
    head = ["60 minutes with the exercises."]
    assert notes == [head, first, [], second, [], []]


@pytest.mark.parametrize("whole", [60, 420, 540])
@pytest.mark.parametrize("number", [1, 2, 3])
def test_seconds_sum_to_the_section(whole, number):
    found = shares(whole, [1, 2] * number)
    assert sum(found) == whole and min(found) > 0
    assert all(seconds % STEP == 0 for seconds in found)


def test_what_is_left_out_takes_no_time_and_a_pace_with_holes_is_none():
    found = slides(*lecture(10, 0, 4), quick_questions())
    assert timings(found) == [0, 300, 300, 0, 0, 120, 120, 0]
    cells = lecture(10, 10)
    cells[-1].source = "Ask first."
    assert sum(timings(slides(*cells))) == 0


def breaks(found) -> list[int]:
    return [k for k, one in enumerate(found) if one[0].source.startswith("### Break")]


def test_a_break_comes_where_45_minutes_end_and_names_what_comes():
    found = slides(*lecture(20, 20, 20, 20))
    assert breaks(found) == [5]
    assert "<li>Section 3</li>" in found[5][0].source
    assert "Section 4" not in found[5][0].source
    student = slides(*lecture(20, 20, 20, 20), audience="student")
    assert sources(student[5]) == sources(found[5])


def test_after_a_lesson_come_questions_exercises_and_its_case():
    cells = [
        *lecture(25, 20),
        quick_questions(),
        code("x", slide="skip", tags=["exercise"]),
    ]
    found = slides(*cells, stem="07_pearson_registration")
    (place,) = breaks(found)
    assert place == 5 and found[6][0].source.startswith(f"### {QUESTION}")
    listed = ["the quick questions", "the exercises, ", "Fifty shifts: the case"]
    at = [found[5][0].source.index(one) for one in listed]
    assert at == sorted(at)


@pytest.mark.parametrize("minutes", [(20, 20), (10, 5, 40), ()])
def test_no_break_where_nothing_follows_or_little_went_before(minutes):
    assert breaks(slides(*lecture(*minutes))) == []


def test_whose_program_draws_is_not_for_the_hall(capsys):
    checks.own("find", min)
    said = new_output("stream", text=capsys.readouterr().out + "3 found\n")
    cell = code("draw()", slide="subslide", tags=["draw"])
    cell.outputs = [said]
    assert [o.text for o in slides(cell)[0][0].outputs] == ["3 found\n"]


def test_a_title_of_the_slides_takes_the_place_of_a_heading():
    one, two = (
        text("## Where? · 9 min\n\nThere.", "slide"),
        text("In code:", "subslide"),
    )
    drawn = code("draw()", slide="subslide", tags=["draw"])
    for cell, said in ((one, "It is there"), (two, "A line"), (drawn, "It grows")):
        cell.metadata.slideshow["title"] = said
    found = slides(one, two, drawn)
    assert sources(found[0]) == ["### It is there\n\nThere."]
    assert sources(found[1]) == ["### A line\n\nIn code:"]
    assert sources(found[2]) == ["### It grows", "draw()"]
    assert one.source.startswith("## Where?")


# Verdicts


def table(number: int) -> list:
    """A slide with so many rows of the ledger, shown as a notebook shows them."""
    rows = ledger.verdicts("5")[:number]
    cells = "".join(
        f"<tr><th>{r['source']}, {r['place']}</th><td>{r['printed']}</td>"
        f"<td>{r['obtained']}</td><td>{r['verdict']}</td></tr>"
        for r in rows
    )
    head = "".join(f"<th>{name}</th>" for name in LEDGER)
    html = f"<table><thead><tr>{head}</tr></thead><tbody>{cells}</tbody></table>"
    output = new_output("display_data", data={"text/html": html})
    return [text("## The verdict", "slide"), code("ledger.table(rows)", output)]


@pytest.mark.parametrize(
    ("rows", "on_slides"), [(1, [1]), (3, [3]), (4, [3, 1]), (6, [3, 3]), (9, [3])]
)
def test_a_slide_shows_at_most_three_verdicts(rows, on_slides):
    found = slides(*table(rows), text("A last word."))
    html = [
        "".join(o.data["text/html"] for c in one for o in c.get("outputs", []))
        for one in found
    ]
    assert [page.count('class="verdict ') for page in html] == on_slides
    assert ("6 more are in the notebook" in html[0]) == (rows == 9)
    assert faults([cell for one in found for cell in one]) == []


def test_a_card_has_word_mark_place_and_the_first_sentence():
    """The note has the rest."""
    row = ["Bani 2010, (2.3)", "a < b", "It is 1.5 mm. The rest is long.", "corrected"]
    card = cards([row], "One of 61")
    words = ['<span aria-hidden="true">≠</span> corrected', "Bani 2010, (2.3)"]
    for said in [*words, "a &lt; b", "It is 1.5 mm.", "One of 61"]:
        assert said in card
    assert "The rest is long" not in card
    rows = ledger.verdicts("5")[:2]
    notes = [c.source for c in slides(*table(2))[0] if slide_type(c) == NOTE]
    assert all(row["obtained"][-30:] in notes[0] for row in rows)


def said(*cells) -> list[str]:
    return faults([text("# Title", "slide"), *cells])


def test_a_slide_without_its_one_heading_is_named():
    drawn = code("draw()", slide="subslide")
    assert "has no heading" in said(drawn)[0]
    assert "has no heading" in said(text("Words.", "subslide"))[0]
    assert "2 headings" in said(text("## Two\n\n### Three", "slide"))[0]
    assert "2 headings" in said(text("## Two", "slide"), text("### Three"))[0]


ASKED = text("## Two\n\n**Predict.** How large will it be?", "slide")
RESULT = code("print(2)", new_output("stream", name="stdout", text="2"))


def test_an_answer_beside_its_question_waits():
    (found,) = said(ASKED, RESULT, text("It is two."))
    assert "shows 'print(2)' at once with the question '**Predict.** How large" in found
    assert "shows 'It is two.'" in said(text("## Two\n\nWhy is it two?", "slide"),
                                        text("It is two."))[0]  # fmt: skip


@pytest.mark.parametrize(
    "after",
    [
        [code("print(2)", slide="fragment"), text("It is two.")],
        [code("checks.predict('1')", tags=["predict"]), text("It is two.")],
        [text("<details><summary>Why?</summary>\n\nTwo.\n\n</details>")],
        [code("x = 2", tags=["hide-input"])],
        [text("2 minutes. It is two.", NOTE)],
        [text("## Three", "slide"), RESULT],
    ],
)
def test_what_waits_or_shows_nothing_is_fine(after):
    assert said(ASKED, *after) == []


def test_an_exercise_that_ends_a_text_is_left_to_the_reader():
    whole = "## Two\n\nAn idea.\n\n### Exercise 1.2 · Do it\n\nWrite it."
    (slide,) = slides(text(whole, "slide"))
    assert sources(slide) == ["## Two\n\nAn idea."]


def test_the_skeleton_is_fit_for_a_hall(lesson):
    notebook = nbformat.read(lesson, as_version=4)
    assert faults(for_slides(notebook, "lecturer", lesson.stem).cells) == []
