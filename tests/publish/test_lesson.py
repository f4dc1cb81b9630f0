"""A prediction waits for a click wherever it is shown, and nothing else needs one."""

import nbformat
import pytest
from nbconvert import HTMLExporter
from nbformat.v4 import new_output

from pgm_lab.checks._predict import page as choices_page
from publish.browser import offline_context
from publish.page import handout_page
from publish.prepare import for_handouts, for_slides
from publish.student import student_copy, tags
from tests.publish.example import code, example, figure_output, text
from tests.publish.look import overflow
from tests.publish.watch import each_slide, published

WAITING = ".html:has(.pgm-predict) ~ *"


@pytest.fixture(scope="module")
def slides(browser, lesson, tmp_path_factory):
    """The slides, at the one with the prediction."""
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    page = context.new_page()
    path = published("slides", lesson, tmp_path_factory.mktemp("build"))
    page.goto(path.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready")
    for _ in each_slide(page):
        if page.locator("section section.present .pgm-predict").count():
            break
    yield page
    context.close()


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


def test_a_slide_is_laid_out_for_what_opens_on_it(watched, tmp_path):
    """A figure below the choices gives way to the longest sentence."""
    long = "A sentence that takes a line of the slide, more or less, and so on. " * 4
    rows = [{"choice": "yes", "right": "yes", "feedback": long}] * 3
    choices = new_output("display_data", data={"text/html": choices_page("1.1", rows)})
    cells = [
        text("## Predict", "slide"),
        code("predict(); draw()", choices, figure_output(), tags=("predict",)),
    ]
    nbformat.write(example(*cells), tmp_path / "01_example.ipynb")
    path = published("slides", tmp_path / "01_example.ipynb", tmp_path / "build")
    watched.page.goto(path.as_uri())
    watched.wait()
    *_, _ = each_slide(watched.page)  # the last one
    assert watched.page.locator("[open]").count() == 0
    for k in range(3):
        watched.page.locator(".pgm-predict summary").nth(k).click()
        assert overflow(watched.page) <= 0


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
    assert page.locator(WAITING).is_visible()
    assert not page.locator(".pgm-predict details p").first.is_visible()
    assert page.locator(".write").bounding_box()["height"] >= 60
    context.close()


def test_minutes_claims_and_the_reader_s_own_words_are_not_projected(lesson):
    notebook = nbformat.read(lesson, as_version=4)
    on_slides, on_paper = for_slides(notebook), for_handouts(notebook)
    text = nbformat.writes(on_slides)
    assert "## What you have now\\n" in text and "4 min" not in text
    assert "## What you have now · 4 min\\n" in nbformat.writes(on_paper)
    kinds = [{tag for cell in one.cells for tag in tags(cell)}
             for one in (notebook, on_slides, on_paper)]  # fmt: skip
    assert {"write", "claims"} <= kinds[0]
    assert not {"write", "claims"} & kinds[1]
    assert {"write"} == {"write", "claims"} & kinds[2]
