"""A prediction waits for a click wherever it is shown, and nothing else needs one."""

import nbformat
import pytest
from nbconvert import HTMLExporter
from nbformat.v4 import new_output

from pgm_book.common.predict import page as choices_page
from pgm_book.make.browser import offline_context
from pgm_book.make.handouts import for_handouts
from pgm_book.make.page import handout_page, slides_page
from pgm_book.make.slides import for_slides
from pgm_book.make.student import student_copy, tags
from tests.publish.example import code, example, figure_output, text
from tests.publish.look import overflow
from tests.publish.watch import Watched, each_slide, written

WAITING = ".html:has(.pgm-predict) ~ *"


@pytest.fixture(scope="module")
def slides(lesson_decks):
    """The slides, at the one with the prediction."""
    page = lesson_decks[0].page
    for _ in each_slide(page):
        if page.locator("section section.present .pgm-predict").count():
            break
    return page


def test_on_a_slide_what_follows_a_prediction_waits_for_a_click(slides):
    at = slides.evaluate("Reveal.getIndices()")
    choices = slides.locator(".pgm-predict summary")
    waiting = slides.locator(WAITING)
    sentences = slides.locator(".pgm-predict details p")
    assert choices.count() == 3 and waiting.count() == 1
    assert not waiting.is_visible()
    assert not any(sentences.nth(k).is_visible() for k in range(3))
    for k in range(3):
        choices.nth(k).click()
        assert waiting.is_visible()
        open_ones = [j for j in range(3) if sentences.nth(j).is_visible()]
        assert open_ones == [k], "one choice closes the other"
        assert overflow(slides) <= 0
    assert slides.evaluate("Reveal.getIndices()") == at, "a click turns no page"


def test_with_the_keyboard_too(slides):
    slides.evaluate("document.querySelectorAll('[open]').forEach(d => d.open = false)")
    at = slides.evaluate("Reveal.getIndices()")
    assert not slides.locator(WAITING).is_visible()
    slides.locator(".pgm-predict summary").nth(1).focus()
    slides.keyboard.press("Enter")
    assert slides.locator(WAITING).is_visible()
    assert slides.evaluate("Reveal.getIndices()") == at


def choices(number, sentence="Yes."):
    """What a prediction with three choices shows."""
    rows = [{"choice": "yes", "right": "yes", "feedback": sentence}] * 3
    return new_output("display_data", data={"text/html": choices_page(number, rows)})


LONG = "A sentence that takes a line of the slide, more or less, and so on. " * 4
WHY = f"<details><summary>Why?</summary>\n\n{LONG}{LONG}\n\n</details>"


def predicted(number="1.1"):
    """A prediction about a figure."""
    output = choices(number, LONG)
    return code("predict()", output, figure_output(), tags=("predict",))


def mixed():
    """A prediction of which one choice has a much longer sentence than the others."""
    short, long = (
        choices("1.2", sentence).data["text/html"].split("</details>")
        for sentence in ("Yes.", LONG * 2)
    )
    html = "</details>".join([long[0], *short[1:]])
    return code(
        "predict()",
        new_output("display_data", data={"text/html": html}),
        tags=("predict",),
    )


SEVERAL = code(
    "predict()",
    choices("1.5"),
    new_output("stream", text="The second question\n"),
    choices("1.6"),
    new_output("stream", text="The end\n"),
    tags=("predict",),
)
# What stands on the slides of one deck
ON_SLIDES = {
    "folds": [predicted("1.1"), text(WHY), text(WHY)],
    "tallest": [mixed(), text(LONG)],
    "below": [predicted("1.3"), text("The answer."), text("More.", "fragment")],
    "several": [SEVERAL],
}


@pytest.fixture(scope="module")
def deck(browser, tmp_path_factory):
    """A page with all of these slides."""
    folder = tmp_path_factory.mktemp("predict")
    cells = [
        c for name, on in ON_SLIDES.items() for c in (text(f"## {name}", "slide"), *on)
    ]
    nbformat.write(example(*cells), folder / "01_example.ipynb")
    context = offline_context(browser)
    watched = Watched(context)
    page = slides_page(folder / "01_example.ipynb")
    watched.page.goto(written(folder, page).as_uri())
    watched.wait()
    yield watched.page
    context.close()


@pytest.fixture
def on_slide(deck):
    """A function that shows a slide, and gives the page and the slide."""

    def shown(name):
        number = list(ON_SLIDES).index(name) - len(ON_SLIDES)
        deck.evaluate(
            """(number) => {
                const { h, v } = Reveal.getIndices(Reveal.getSlides().at(number));
                Reveal.slide(h, v);
            }""",
            number,
        )
        return deck, deck.locator("section section.present")

    return shown


def test_a_slide_is_laid_out_for_what_opens_on_it(on_slide):
    """A figure beside the choices, and two answers of which one is open at a time."""
    page, slide = on_slide("folds")
    assert slide.locator("[open]").count() == 0
    for choice in range(3):
        slide.locator(".pgm-predict summary").nth(choice).click()
        for answer in range(2):
            slide.locator(".text summary").nth(answer).click()
            assert slide.locator("[open]").count() == 2
            assert overflow(page) <= 0
    page, slide = on_slide("tallest")
    slide.locator(".pgm-predict summary").first.click()
    assert overflow(page) <= 0


def test_on_a_slide_the_result_stands_beside_the_choices_and_text_waits(on_slide):
    page, slide = on_slide("below")
    page.evaluate("Reveal.configure({ fragments: false })")
    answers = [slide.get_by_text(said, exact=True) for said in ("The answer.", "More.")]
    assert not any(answer.is_visible() for answer in answers)
    slide.locator(".pgm-predict summary").nth(1).click()
    assert all(answer.is_visible() for answer in answers)
    picture, choice = (
        slide.locator(f".cell:has(.pgm-predict) {what}").first.bounding_box()
        for what in ("img", ".pgm-predict")
    )
    assert picture["x"] > choice["x"] + choice["width"]
    assert abs(picture["y"] - choice["y"]) < 20 and picture["width"] > 600


def assert_one_at_a_time(page):
    asked = [
        page.locator("pre", has_text=words)
        for words in ("The second question", "The end")
    ]
    questions = page.locator(".pgm-predict")
    assert not asked[0].is_visible() and not questions.nth(1).is_visible()
    questions.nth(0).locator("summary").first.click()
    assert asked[0].is_visible() and not asked[1].is_visible()
    questions.nth(1).locator("summary").first.click()
    assert asked[1].is_visible()


def test_each_prediction_of_a_cell_waits_for_the_one_before_and_text_below_too(
    on_slide, browser
):
    """On a slide, and in the page that nbconvert makes by itself; no heading waits."""
    _, slide = on_slide("several")
    assert_one_at_a_time(slide)
    again = code("predict()", choices("1.2"), tags=("predict",))
    cells = [predicted(), text("The answer."), again, text("### What comes next")]
    context = offline_context(browser)
    page = context.new_page()
    html, _ = HTMLExporter().from_notebook_node(example(SEVERAL))
    page.set_content(html, wait_until="domcontentloaded")
    assert_one_at_a_time(page)
    html, _ = HTMLExporter().from_notebook_node(example(*cells))
    page.set_content(html, wait_until="domcontentloaded")
    answer = page.get_by_text("The answer.", exact=True)
    assert not answer.is_visible()
    assert page.get_by_role("heading", name="What comes next").is_visible()
    page.locator(".pgm-predict summary").first.click()
    assert answer.is_visible()
    context.close()


@pytest.fixture(params=[True, False], ids=["run", "student"])
def stock(request, browser, lesson, tmp_path):
    """The page that nbconvert makes of it by itself, and whether it was run."""
    notebook = nbformat.read(lesson, as_version=4)
    if not request.param:
        notebook = student_copy(notebook)
    html, _ = HTMLExporter().from_notebook_node(notebook)
    (tmp_path / "page.html").write_text(html, encoding="utf-8")
    context = offline_context(browser)
    page = context.new_page()
    page.goto((tmp_path / "page.html").as_uri(), wait_until="domcontentloaded")
    yield page, request.param
    context.close()


def test_in_a_page_without_kernel_it_waits_and_the_rest_is_folded(stock):
    page, was_run = stock
    derive = page.locator("details", has_text="Two rays through the perspective")
    text = derive.locator("p").first
    assert not text.is_visible()
    derive.locator("summary").click()
    assert text.is_visible()
    if not was_run:
        assert page.locator(".pgm-predict").count() == 0
        return
    area = page.locator(".jp-OutputArea", has=page.locator(".pgm-predict"))
    table = area.locator(".jp-OutputArea-child").nth(1)
    assert not table.is_visible()
    area.locator("summary").first.click()
    assert table.is_visible()


def test_on_paper_all_is_open_but_the_answers_to_the_prediction(browser, lesson):
    context = offline_context(browser)
    page = context.new_page()
    page.emulate_media(media="print")
    page.set_content(handout_page(lesson))
    assert (
        page.locator("details", has_text="Two rays through").get_attribute("open") == ""
    )
    assert page.locator(WAITING).count() == 0
    assert page.locator(".answer > .html ~ *, .answer > figure").first.is_visible()
    assert not page.locator(".pgm-predict details p").first.is_visible()
    assert page.locator(".write").bounding_box()["height"] >= 50  # two lines
    context.close()


def test_minutes_claims_and_the_reader_s_own_words_are_not_projected(lesson):
    notebook = nbformat.read(lesson, as_version=4)
    on_slides = for_slides(notebook, "student")
    on_paper = for_handouts(notebook)
    text = nbformat.writes(on_slides)
    assert "## What you have now\\n" in text and "4 min" not in text
    assert "## What you have now · 4 min\\n" in nbformat.writes(on_paper)
    kinds = [{tag for cell in one.cells for tag in tags(cell)}
             for one in (notebook, on_slides, on_paper)]  # fmt: skip
    assert {"write", "claims"} <= kinds[0]
    assert not {"write", "claims"} & kinds[1]
    assert {"write"} == {"write", "claims"} & kinds[2]
