"""The slides of every chapter, as a lecturer without internet sees them."""

import nbformat
import pytest
from bs4 import BeautifulSoup

from publish import assets
from publish.browser import offline_context
from publish.page import own_scripts
from publish.prepare import title
from publish.selfcontained import problems
from tests.publish.example import example, text
from tests.publish.look import (
    axe_violations,
    bad_images,
    formulas,
    has_maths,
    load_axe,
    overflow,
    raw_markup,
)
from tests.publish.watch import Watched, each_slide, published


def kind(cell) -> str:
    return cell.metadata.get("slideshow", {}).get("slide_type", "-")


def shown(notebook) -> list:
    """List the cells that belong on slides, by the rules for authors."""
    return [
        cell
        for cell in notebook.cells
        if kind(cell) != "skip"
        and not {"check", "solution", "write", "claims"}
        & set(cell.metadata.get("tags", []))
    ]


def content(notebook) -> list:
    """List the cells that the audience sees."""
    return [cell for cell in shown(notebook) if kind(cell) != "notes"]


def test_the_file_is_self_contained(slides_file):
    page = slides_file.read_text(encoding="utf-8")
    assert problems(page, own_scripts(assets.slides_assets())) == []


def test_nothing_is_fetched_and_nothing_fails(slides, slides_file):
    for _ in each_slide(slides.page):
        pass
    assert slides.requests == [slides_file.as_uri()]
    assert slides.errors == []


def test_title_and_language(slides, notebook):
    assert slides.page.title() == title(notebook) != "Untitled"
    assert slides.page.locator("html").get_attribute("lang") == "en"
    # One heading of the first rank a slide: the title page's own, and one for readers
    assert slides.page.locator(".slides h1").count() == 1
    assert slides.page.locator("header h1").text_content() == title(notebook)


def test_as_many_slides_as_the_notebook_says(slides, notebook):
    starts = [
        cell for cell in content(notebook)[1:] if kind(cell) in ("slide", "subslide")
    ]
    expected = 1 + len(starts)
    assert slides.page.evaluate("Reveal.getTotalSlides()") == expected
    assert slides.page.locator(".slide-number").inner_text().endswith(f"/ {expected}")


def test_formulas_are_typeset(slides, notebook):
    count, errors = formulas(slides.page)
    assert errors == 0
    assert (count > 0) == has_maths(content(notebook))
    assert raw_markup(slides.page) == []


def test_formulas_have_their_size(slides):
    """Those in a fold, and those that wait for a prediction, once it is open."""
    for number in each_slide(slides.page):
        heights = slides.page.evaluate(
            """() => [...Reveal.getCurrentSlide().querySelectorAll("mjx-container")]
                .filter((formula) => !formula.closest("aside"))
                .map((formula) => {
                    const slide = formula.closest("section");
                    const choice = slide.querySelector(".pgm-predict details");
                    const folds = [choice, formula.closest("details")].filter(Boolean);
                    folds.forEach((fold) => { fold.open = true; });
                    const { height } = formula.getBoundingClientRect();
                    folds.forEach((fold) => { fold.open = false; });
                    return height;
                })"""
        )
        assert all(height > 5 for height in heights), f"slide {number}"


def test_every_image_is_decoded_and_described(slides):
    assert bad_images(slides.page) == []


def test_figures_are_all_there(slides, notebook):
    figures = [
        output
        for cell in shown(notebook)
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    assert slides.page.locator("figure img").count() == len(figures)


def test_every_slide_fits(slides):
    too_full = {n: overflow(slides.page) for n in each_slide(slides.page)}
    assert {n: px for n, px in too_full.items() if px > 0} == {}


def test_no_accessibility_violation_on_any_slide(slides):
    load_axe(slides.page)
    found = {n: axe_violations(slides.page) for n in each_slide(slides.page)}
    assert {n: texts for n, texts in found.items() if texts} == {}


def test_speaker_notes_are_kept_and_hidden(slides, notebook):
    notes = [cell for cell in shown(notebook) if kind(cell) == "notes"]
    asides = slides.page.locator("aside.notes")
    assert asides.count() == len(notes)
    assert all(asides.nth(i).is_hidden() for i in range(asides.count()))
    assert slides.page.locator(".fragment aside").count() == 0


def test_no_solution_and_no_check_is_shown(slides_file, notebook):
    soup = BeautifulSoup(slides_file.read_text(encoding="utf-8"), "html.parser")
    assert "SOLUTION" not in soup.find("main").get_text()
    cells = {element["data-cell"] for element in soup.select("[data-cell]")}
    assert cells <= {cell.id for cell in shown(notebook)}


def test_the_keyboard_leads_through_all_slides(browser, slides_file):
    context = offline_context(browser)
    watched = Watched(context)
    watched.page.goto(slides_file.as_uri())
    watched.wait()
    seen = []
    for _ in range(200):
        seen.append(watched.page.evaluate("Reveal.getSlidePastCount()"))
        if watched.page.evaluate("Reveal.getProgress()") == 1:
            break
        watched.page.keyboard.press("ArrowRight")
    total = watched.page.evaluate("Reveal.getTotalSlides()")
    context.close()
    assert sorted(set(seen)) == list(range(total))


def test_the_speaker_view_opens_with_the_notes(browser, slides_file):
    context = offline_context(browser)
    watched = Watched(context)
    watched.page.goto(slides_file.as_uri())
    watched.wait()
    with watched.page.expect_popup() as popup:
        watched.page.keyboard.press("s")
    expected = watched.page.evaluate(
        """() => [...Reveal.getCurrentSlide().querySelectorAll("aside.notes")]
            .map((notes) => notes.textContent)"""
    )
    notes = popup.value.locator(".speaker-controls-notes .value")
    notes.wait_for(state="attached")
    popup.value.wait_for_function("document.querySelectorAll('iframe').length == 2")
    if expected:
        popup.value.wait_for_function(
            "document.querySelector('.speaker-controls-notes .value').textContent"
        )
    shown_notes = " ".join(notes.text_content().split())
    context.close()
    assert all(" ".join(note.split()) in shown_notes for note in expected)


@pytest.fixture
def too_full(tmp_path):
    notebook = example(text("## Too long\n\n" + "- one more line\n" * 40, "slide"))
    path = tmp_path / "01_full.ipynb"
    nbformat.write(notebook, path)
    return published("slides", path, tmp_path / "build")


def test_a_slide_that_does_not_fit_is_found(watched, too_full):
    watched.page.goto(too_full.as_uri())
    watched.wait()
    heights = [overflow(watched.page) for _ in each_slide(watched.page)]
    assert max(heights[:-1]) <= 0 < heights[-1]
