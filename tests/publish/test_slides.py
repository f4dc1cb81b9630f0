"""The slides of every chapter, as a lecturer without internet sees them."""

import nbformat
from bs4 import BeautifulSoup

from pgm_book.make import form
from pgm_book.make.browser import offline_context
from pgm_book.make.form import form_of
from pgm_book.make.page import slides_page
from pgm_book.make.sizes import measure, problems
from pgm_book.make.slides import divided, title
from pgm_book.make.student import slide_type, tags
from tests.publish.example import ANSWER, QUESTION, example, text
from tests.publish.look import (
    axe_violations,
    bad_images,
    formulas,
    has_maths,
    lay_out_all,
    load_axe,
    raw_markup,
)
from tests.publish.watch import Deck, published, written

SHOW = """index => {
    const { h, v } = Reveal.getIndices(Reveal.getSlides()[index]);
    Reveal.slide(h, v);
}"""
# Seconds that the speaker's view gives until the end of the slide
LEFT = """["hours", "minutes", "seconds"]
    .map((unit) => document.querySelector(`.pacing .${unit}-value`).textContent)
    .reduce((sum, text) => 60 * sum + Number(text.replace(":", "")), 0)"""


def test_the_command_writes_two_decks(small, tmp_path):
    """What it writes is what the tests here look at."""
    build = tmp_path / "build"
    paths = published("slides", small, build)
    folders = [build / "slides" / audience for audience in ("lecturer", "student")]
    assert paths == [folder / "01_example.html" for folder in folders]
    for path, audience in zip(paths, ("lecturer", "student")):
        assert path.read_text(encoding="utf-8") == slides_page(small, audience)


def test_all_is_there_and_nothing_is_fetched(slides, slides_file, notebook, prepared):
    """Every slide, figure and formula, the title, and the notes out of sight."""
    page, number = slides.page, len(slides.looks)
    assert (slides.requests, slides.errors) == ([slides_file.as_uri()], [])
    assert 1 < number <= len(divided(prepared))  # some stand together
    assert page.locator(".slide-number").inner_text().endswith(f"/ {number}")
    assert page.title() == title(notebook) != "Untitled"
    assert page.locator("html").get_attribute("lang") == "en"
    # One heading of the first rank a slide: the title page's own, and one for readers
    assert page.locator(".slides h1").count() == 1
    assert page.locator("header h1").text_content() == title(notebook)
    outputs = [output for cell in prepared for output in cell.get("outputs", [])]
    figures = sum("image/png" in output.get("data", {}) for output in outputs)
    assert page.locator("figure img").count() == figures
    assert bad_images(page) == []
    count, errors = formulas(page)
    assert errors == 0
    assert (count > 0) == has_maths(c for c in prepared if slide_type(c) != "notes")
    assert raw_markup(page) == []
    assert all(min(look["formulas"], default=9) > 5 for look in slides.looks)
    notes = [cell for cell in prepared if slide_type(cell) == "notes"]
    shown = "asides => asides.map((aside) => aside.checkVisibility())"
    assert page.locator("aside.notes").evaluate_all(shown) == [False] * len(notes)
    assert page.locator(".fragment aside").count() == 0


def test_no_solution_and_no_check_is_shown(slides_file, notebook):
    soup = BeautifulSoup(slides_file.read_text(encoding="utf-8"), "html.parser")
    assert "SOLUTION" not in soup.find("main").get_text()
    hidden = {"check", "solution", "write", "claims"}
    shown = {element["data-cell"] for element in soup.select("[data-cell]")}
    assert shown
    assert not shown & {
        cell.id
        for cell in notebook.cells
        if slide_type(cell) == "skip" or hidden & set(tags(cell))
    }


def test_a_hall_can_read_every_slide(slides, chapter):
    """Nothing is wrong with a lesson or a case; of the others nothing sticks out."""
    assert max(look["overflow"] for look in slides.looks) <= 0
    wrong = problems(measure(slides.page))
    if not form_of(chapter):
        wrong = [row for row in wrong if row.kind == "overflow"]
    assert [str(row) for row in wrong] == []


def test_no_accessibility_violation_on_any_slide(slides):
    """The last test of a deck, since it leaves all slides laid out."""
    load_axe(slides.page)
    lay_out_all(slides.page)
    assert axe_violations(slides.page) == []


def test_a_violation_and_a_slide_that_does_not_fit_are_found(browser, tmp_path):
    pale = text('## Pale\n\n<p style="color: #aaa">Who reads this?</p>', "slide")
    full = text("## Too long\n\n" + "- one more line\n" * 80, "slide")
    nbformat.write(example(pale, full), tmp_path / "01_pale.ipynb")
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    page = slides_page(tmp_path / "01_pale.ipynb")
    deep = Deck(context, written(tmp_path, page))
    load_axe(deep.page)
    lay_out_all(deep.page)
    (pale,) = [one for one in axe_violations(deep.page) if "Who reads this?" in one]
    context.close()
    assert "color-contrast" in pale
    *others, last = (look["overflow"] for look in deep.looks)
    assert max(others) <= 0 < last


def address(deck) -> str:
    """Where a deck begins, wherever the tests before have left it."""
    return deck.page.url.partition("#")[0]


def test_the_keyboard_leads_through_all_slides(watched, lesson_decks):
    watched.page.goto(address(lesson_decks[0]))
    watched.wait()
    seen = []
    for _ in range(200):
        seen.append(watched.page.evaluate("Reveal.getSlidePastCount()"))
        if watched.page.evaluate("Reveal.getProgress()") == 1:
            break
        watched.page.keyboard.press("ArrowRight")
    assert sorted(set(seen)) == list(range(len(lesson_decks[0].looks)))


def test_the_speaker_view_shows_the_notes_and_the_pace(watched, lesson_decks, lesson):
    page = watched.page
    page.goto(address(lesson_decks[0]))
    watched.wait()
    with page.expect_popup() as popup:
        page.keyboard.press("s")
    speaker = popup.value
    speaker.wait_for_function("document.querySelectorAll('iframe').length == 2")
    last = len(lesson_decks[0].looks) - 1
    page.evaluate(SHOW, last)
    # On the last slide what is left is the whole lecture, less the seconds since then.
    minutes = form.lecture(nbformat.read(lesson, as_version=4))
    whole = 60 * sum(minutes.values())
    speaker.wait_for_function(LEFT + "> 0")
    assert speaker.locator(".speaker-controls-time .pacing").is_visible()
    assert whole - 60 <= speaker.evaluate(LEFT) <= whole
    noted = page.locator("section:has(> aside.notes)").first
    page.evaluate(SHOW, noted.evaluate("slide => Reveal.getSlides().indexOf(slide)"))
    words = noted.locator("aside").first.text_content().split()
    shown = speaker.locator(".speaker-controls-notes .value", has_text=words[0])
    shown.wait_for()
    assert " ".join(words) in " ".join(shown.text_content().split())


def test_the_students_deck_is_the_lecturers_without_the_key(lesson_decks):
    lecturer, student = lesson_decks
    assert len(student.looks) == len(lecturer.looks)
    assert student.errors == [] and len(student.requests) == 1
    assert student.page.locator("aside.notes").count() == 0
    assert student.page.evaluate("Reveal.getPlugin('notes') === undefined")
    assert max(look["overflow"] for look in student.looks) <= 0


def test_answers_and_notes_are_not_in_the_students_file(small):
    """Not hidden either, where a curious reader would look."""
    lecturer, student = (slides_page(small, who) for who in ("lecturer", "student"))
    assert QUESTION in lecturer and QUESTION in student
    for only in (ANSWER, "say where the coffee is", "speaker-controls-notes"):
        assert only in lecturer and only not in student
    assert "your code here" in student
    assert "secret" not in student and "[2143.5 1423.5]" not in student


def test_the_key_to_go_on_first_opens_the_right_choice(watched, lesson, tmp_path):
    page = watched.page
    page.goto(written(tmp_path, slides_page(lesson)).as_uri())
    watched.wait()
    at_the_first_prediction(page)
    number = page.evaluate("Reveal.getSlidePastCount()")
    page.keyboard.press("PageDown")
    assert page.evaluate("Reveal.getSlidePastCount()") == number
    opened = page.locator("section section.present .pgm-predict details[open]")
    assert "✓" in opened.text_content()
    page.keyboard.press("PageDown")
    assert page.evaluate("Reveal.getSlidePastCount()") == number + 1


def at_the_first_prediction(page) -> None:
    page.evaluate(
        """() => {
            const asked = document.querySelector(".slides .pgm-predict");
            const { h, v } = Reveal.getIndices(asked.closest("section"));
            Reveal.slide(h, v);
        }"""
    )


def test_the_space_bar_opens_the_choice_that_has_the_focus(watched, lesson, tmp_path):
    """And not the right one: whoever presses it there has chosen."""
    page = watched.page
    page.goto(written(tmp_path, slides_page(lesson)).as_uri())
    watched.wait()
    at_the_first_prediction(page)
    choices = page.locator("section section.present .pgm-predict details")
    wrong = choices.filter(has_text="✗").first
    number = page.evaluate("Reveal.getSlidePastCount()")
    wrong.locator("summary").focus()
    page.keyboard.press("Space")
    assert wrong.evaluate("one => one.open")
    assert choices.filter(has_text="✓").evaluate("one => !one.open")
    assert page.evaluate("Reveal.getSlidePastCount()") == number


def test_the_key_end_reaches_the_last_slide(watched, tmp_path):
    """Which is the second of the last column, as the quick questions are."""
    last = text("## A section", "slide"), text("### Its last slide", "subslide")
    nbformat.write(example(*last), tmp_path / "01_end.ipynb")
    page = watched.page
    page.goto(written(tmp_path, slides_page(tmp_path / "01_end.ipynb")).as_uri())
    watched.wait()
    page.keyboard.press("End")
    assert page.evaluate("Reveal.isLastSlide()")


def test_two_short_slides_stand_together_but_no_answer_with_its_question(
    browser, tmp_path
):
    cells = [
        text("## Long\n\n" + "- a line\n" * 9, "slide"),
        text("### Where?\n\nHere.", "subslide"),
        text("### How far?\n\nNot far.", "subslide"),
        text("## Asked\n\nWho knows why?", "slide"),
        text("### Because\n\nIt is so.", "subslide"),
        text("### More\n\nOf it.", "subslide"),
    ]
    nbformat.write(example(*cells), tmp_path / "01_short.ipynb")
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    page = slides_page(tmp_path / "01_short.ipynb")
    deck = Deck(context, written(tmp_path, page)).page
    titles = (
        "Reveal.getSlides().map((one) => one.querySelector('h1, h2, h3').innerText)"
    )
    found = deck.evaluate(titles)
    context.close()
    assert found[-4:] == ["Long", "Where?", "Asked", "Because"]
