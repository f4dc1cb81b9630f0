"""The slides of every chapter, as a lecturer without internet sees them."""

import nbformat
from bs4 import BeautifulSoup

from pgm_book.make import form
from pgm_book.make.browser import offline_context
from pgm_book.make.form import form_of
from pgm_book.make.page import slides_page
from pgm_book.make.sizes import measure, problems
from pgm_book.make.slides import divided, title
from pgm_book.make.student import slide_type
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


def test_nothing_is_fetched_and_nothing_fails(slides, slides_file):
    assert len(slides.looks) > 1
    assert slides.requests == [slides_file.as_uri()]
    assert slides.errors == []


def test_title_and_language(slides, notebook):
    assert slides.page.title() == title(notebook) != "Untitled"
    assert slides.page.locator("html").get_attribute("lang") == "en"
    # One heading of the first rank a slide: the title page's own, and one for readers
    assert slides.page.locator(".slides h1").count() == 1
    assert slides.page.locator("header h1").text_content() == title(notebook)


def test_as_many_slides_as_the_notebook_says(slides, prepared):
    expected = len(divided(prepared))
    assert len(slides.looks) == expected
    assert slides.page.locator(".slide-number").inner_text().endswith(f"/ {expected}")


def test_formulas_are_typeset(slides, prepared):
    count, errors = formulas(slides.page)
    assert errors == 0
    assert (count > 0) == has_maths(c for c in prepared if slide_type(c) != "notes")
    assert raw_markup(slides.page) == []
    small = [
        n
        for n, look in enumerate(slides.looks, 1)
        if min(look["formulas"], default=9) <= 5
    ]
    assert small == []


def test_every_image_is_there_decoded_and_described(slides, prepared):
    figures = [
        output
        for cell in prepared
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert slides.page.locator("figure img").count() == len(figures)
    assert bad_images(slides.page) == []


def test_every_slide_fits(slides):
    too_full = {n: look["overflow"] for n, look in enumerate(slides.looks, start=1)}
    assert {n: px for n, px in too_full.items() if px > 0} == {}


def test_speaker_notes_are_kept_and_hidden(slides, prepared):
    notes = [cell for cell in prepared if slide_type(cell) == "notes"]
    shown = "asides => asides.map((aside) => aside.checkVisibility())"
    assert slides.page.locator("aside.notes").evaluate_all(shown) == [False] * len(
        notes
    )
    assert slides.page.locator(".fragment aside").count() == 0


def test_no_solution_and_no_check_is_shown(slides_file, notebook):
    soup = BeautifulSoup(slides_file.read_text(encoding="utf-8"), "html.parser")
    assert "SOLUTION" not in soup.find("main").get_text()
    hidden = {"check", "solution", "write", "claims"}
    shown = {element["data-cell"] for element in soup.select("[data-cell]")}
    assert shown
    assert not shown & {
        cell.id
        for cell in notebook.cells
        if slide_type(cell) == "skip" or hidden & set(cell.metadata.get("tags", []))
    }


def test_a_hall_can_read_every_slide(slides, chapter):
    """Nothing is wrong with a lesson or a case; of the others nothing sticks out."""
    wrong = problems(measure(slides.page))
    if not form_of(chapter):
        wrong = [row for row in wrong if row.kind == "overflow"]
    assert [str(row) for row in wrong] == []


def test_no_accessibility_violation_on_any_slide(slides):
    """The last test of a deck, since it leaves all slides laid out."""
    load_axe(slides.page)
    lay_out_all(slides.page)
    assert axe_violations(slides.page) == []


def test_a_violation_deep_in_a_deck_is_found(browser, tmp_path):
    pale = text('## Pale\n\n<p style="color: #aaa">Who reads this?</p>', "slide")
    nbformat.write(example(pale, text("## Last", "slide")), tmp_path / "01_pale.ipynb")
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    page = slides_page(tmp_path / "01_pale.ipynb")
    deep = Deck(context, written(tmp_path, page)).page
    load_axe(deep)
    lay_out_all(deep)
    (violation,) = axe_violations(deep)
    context.close()
    assert "color-contrast" in violation and "Who reads this?" in violation


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


def test_a_slide_that_does_not_fit_is_found(browser, tmp_path):
    full = text("## Too long\n\n" + "- one more line\n" * 40, "slide")
    nbformat.write(example(full), tmp_path / "01_full.ipynb")
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    page = slides_page(tmp_path / "01_full.ipynb")
    heights = [
        look["overflow"] for look in Deck(context, written(tmp_path, page)).looks
    ]
    context.close()
    assert max(heights[:-1]) <= 0 < heights[-1]


def test_the_key_to_go_on_first_opens_the_right_choice(watched, lesson, tmp_path):
    page = watched.page
    page.goto(written(tmp_path, slides_page(lesson)).as_uri())
    watched.wait()
    page.evaluate(
        """() => {
            const asked = document.querySelector(".slides .pgm-predict");
            const { h, v } = Reveal.getIndices(asked.closest("section"));
            Reveal.slide(h, v);
        }"""
    )
    number = page.evaluate("Reveal.getSlidePastCount()")
    page.keyboard.press("PageDown")
    assert page.evaluate("Reveal.getSlidePastCount()") == number
    opened = page.locator("section section.present .pgm-predict details[open]")
    assert "✓" in opened.text_content()
    page.keyboard.press("PageDown")
    assert page.evaluate("Reveal.getSlidePastCount()") == number + 1
