"""The handouts of every chapter: A4, readable by machines, nothing cut off."""

import re
from io import BytesIO

import pytest
from nbformat.v4 import new_output
from pypdf import PdfReader

from pgm_book.make import tagged
from pgm_book.make.browser import offline_context
from pgm_book.make.form import form_of
from pgm_book.make.handouts import faults, for_handouts, pdf_of
from pgm_book.make.page import handout_page
from pgm_book.make.slides import title
from pgm_book.make.student import slide_type, tags
from tests.publish.example import code, example, text
from tests.publish.look import (
    axe_violations,
    bad_images,
    formulas,
    has_maths,
    load_axe,
    raw_markup,
)
from tests.publish.watch import Watched

WHY = ("why",)
A4 = (595.28, 841.89)  # points
COLUMN = int((210 - 2 * 15) / 25.4 * 96)  # px between the margins


@pytest.fixture(scope="module")
def built(chapter):
    return handout_page(chapter)


@pytest.fixture(scope="module")
def page(browser, built):
    """The page before printing, as wide as the column of text; leave it as it was."""
    context = offline_context(browser, viewport={"width": COLUMN, "height": 900})
    watched = Watched(context)
    watched.page.emulate_media(media="print")
    watched.page.set_content(built)
    watched.wait()
    yield watched.page
    assert watched.errors == []
    assert watched.requests == []
    context.close()


@pytest.fixture(scope="module")
def paper(notebook):
    return for_handouts(notebook)


@pytest.fixture(scope="module")
def printed(page):
    return pdf_of(page)


@pytest.fixture(scope="module")
def pdf(printed):
    return PdfReader(BytesIO(printed))


@pytest.fixture(scope="module")
def words(printed):
    """All text without its spaces, since a PDF keeps no spaces of its own."""
    pieces = [piece for piece in tagged.read(printed).pieces if piece.kind != "picture"]
    return "".join("".join(piece.text.split()) for piece in pieces)


def test_a_lesson_and_a_case_are_fit_for_paper(chapter, printed, paper):
    form = form_of(chapter)
    found = faults(printed, paper, form)
    assert not form or found == []
    assert not [said for said in found if "not found" in said]


def test_the_pdf_is_a4_and_tagged_with_title_language_and_outline(pdf, notebook):
    assert 1 <= len(pdf.pages) <= 60
    for page in pdf.pages:
        size = (float(page.mediabox.width), float(page.mediabox.height))
        assert size == pytest.approx(A4, abs=1)
    root = pdf.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and "/StructTreeRoot" in root
    assert root["/Lang"] == "en"
    assert pdf.metadata.title == title(notebook)
    assert len(pdf.outline) > 0


def test_every_figure_carries_its_text_into_the_pdf(pdf, paper):
    alts = {
        output.metadata["image/png"]["alt"]
        for cell in paper.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    }
    found = {
        str(object_["/Alt"])
        for number in range(1, pdf.trailer["/Size"])
        if "/Alt" in (object_ := pdf.get_object(number) or {})
    }
    assert alts <= found


def test_what_is_to_be_read_is_printed_and_no_more(words, built, paper, notebook):
    for cell in paper.cells:
        assert f'data-cell="{cell.id}"' in built, cell.source[:40]
    for cell in notebook.cells:  # headings also of what slides skip
        notes = slide_type(cell) == "notes" or "solution" in tags(cell)
        if cell.cell_type == "markdown" and not notes:
            for heading in re.findall(r"^#+ +([\w ,]+)", cell.source, re.MULTILINE):
                assert "".join(heading.split()) in words
    shown = [
        cell.source
        for cell in paper.cells
        if cell.cell_type == "code"
        and not {"hide-input", "draw", "predict"} & set(tags(cell))
    ]
    longest = max("\n".join(shown).split("\n"), key=len)
    assert "".join(longest.split())[-25:] in words
    # No solutions, nobody is asked to click, no line says whose function runs
    for gone in ("SOLUTION", "double-click", "Chooseone:", ":thebook'sown."):
        assert gone not in words
    answers = [cell.id for cell in notebook.cells if "why" in tags(cell)]
    last = [cell.id for cell in paper.cells[len(paper.cells) - len(answers) :]]
    assert last == answers
    assert ("answers" in [cell.id for cell in paper.cells]) == bool(answers)


def test_the_page_is_whole_and_everyone_can_read_it(page, pdf, paper):
    assert too_wide(page) == []
    count, errors = formulas(page)
    assert errors == 0
    assert (count > 0) == has_maths(paper.cells)
    assert raw_markup(page) == []
    assert bad_images(page) == []
    images = sum(len(pictures(one["/Resources"])) for one in pdf.pages)
    assert images >= page.locator("figure img").count()
    assert page.locator("aside").count() == 0
    load_axe(page)
    assert axe_violations(page) == []


def too_wide(page) -> list[str]:
    return page.evaluate(
        """column => [...document.querySelectorAll("main *")]
            .filter((element) => !element.closest("svg, mjx-assistive-mml"))
            .filter((element) =>
                element.getBoundingClientRect().right > column + 1 ||
                (element.clientWidth && element.scrollWidth > element.clientWidth + 1))
            .map((element) => element.outerHTML.slice(0, 120))""",
        COLUMN,
    )


def pictures(resources) -> list:
    """The pictures that a page names, also inside of what it draws as one."""
    found = []
    for named in resources.get("/XObject", {}).values():
        drawn = named.get_object()
        if drawn["/Subtype"] == "/Image":
            found.append(drawn)
        elif drawn["/Subtype"] == "/Form" and "/Resources" in drawn:
            found += pictures(drawn["/Resources"])
    return found


def test_a_line_that_is_cut_is_found(watched):
    watched.page.set_viewport_size({"width": COLUMN, "height": 900})
    watched.page.set_content(f"<main><pre>{'long ' * 60}</pre></main>")
    assert too_wide(watched.page) != []


def test_an_answer_has_its_question_or_the_heading_above_it():
    book = example(
        text("## The edge · 3 min\n\nLook.\n\n### Along *it*"),
        text("<details><summary>Why: the answer</summary>\n\nA\n</details>", tags=WHY),
        text("Go on."),
        text("<details><summary>Why so?</summary>\n\nB\n</details>", tags=WHY),
    )
    below, first, second = for_handouts(book).cells[-3:]
    assert below.source == "## Answers"
    assert "<details open><summary>Along it</summary>" in first.source
    assert "<details open><summary>Why so?</summary>" in second.source


def test_on_paper_no_import_of_figures_and_checks_takes_a_line():
    source = "from pgm_book.ch09 import figures\nfrom pgm_lab import ncc\n\nx = 1"
    last = for_handouts(example(code(source))).cells[-1]
    assert last.source == "from pgm_lab import ncc\n\nx = 1"


def test_what_own_prints_is_left_out_and_the_rest_stays():
    said = "mean: the book's own. Yours takes its place.\n"
    printed = [
        new_output("stream", name="stdout", text=t) for t in (said, said + "3\n")
    ]
    cells = for_handouts(example(*(code("mean(x)", one) for one in printed))).cells
    assert cells[-2].outputs == []
    assert cells[-1].outputs[0].text == "3\n"
