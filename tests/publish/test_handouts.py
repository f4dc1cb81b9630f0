"""The handouts of every chapter: A4, readable by machines, nothing cut off."""

import re
from io import BytesIO
from itertools import pairwise

import pytest
from bs4 import BeautifulSoup
from nbformat.v4 import new_output
from pypdf import PdfReader

from pgm_book.make import tagged
from pgm_book.make.browser import offline_context
from pgm_book.make.form import form_of
from pgm_book.make.handouts import faults, for_handouts, pdf_of
from pgm_book.make.page import handout_page
from pgm_book.make.slides import title
from pgm_book.make.student import PLACEHOLDER, slide_type, tags
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
    ids = [cell.id for cell in paper.cells]
    last = ids[ids.index("answers") :] if "answers" in ids else []
    early = {cell.id for cell in notebook.cells if "why" in tags(cell)} & set(ids)
    early |= {f"{cell.id}-answer" for cell in paper.cells if "predict" in tags(cell)}
    assert early <= set(last)


def test_no_result_of_a_prediction_is_printed_beside_its_question(paper):
    cells = {cell.id: cell for cell in paper.cells}
    for asked in [cell for cell in paper.cells if "predict" in tags(cell)]:
        beside = [output.get("data", {}) for output in asked.outputs]
        several = len([data for data in beside if choices_in(data)]) > 1
        assert several or all(choices_in(data) for data in beside)
        shown = cells[f"{asked.id}-answer"].outputs
        right = "".join(one.get("data", {}).get("text/html", "") for one in shown)
        for soup in filter(None, map(choices_in, beside)):
            assert re.fullmatch(r"A?\d+c?\.\d+", soup.p.text)
            assert soup.p.text in right and "✓" in right


def choices_in(data) -> BeautifulSoup | None:
    soup = BeautifulSoup(data.get("text/html", ""), "html.parser")
    return soup.select_one(".pgm-predict")


def test_no_placeholder_but_lines_stand_where_code_is_to_be_written(paper):
    for cell in [one for one in paper.cells if one.cell_type == "code"]:
        assert PLACEHOLDER not in cell.source
        if "exercise" in tags(cell):
            assert re.search(r"^ *_{80}$", cell.source, re.MULTILINE), cell.source


def test_what_a_derivation_gives_away_is_not_below_its_exercise(paper):
    answers = False
    for above, cell in pairwise(paper.cells):
        answers = answers or above.id == "answers"
        asks = {"exercise", "predict"} & set(tags(above))
        assert answers or not (asks and "derive" in tags(cell)), cell.source[:60]


def test_few_pages_end_far_above_their_foot(chapter, printed):
    """A large figure may not fit; the last page may end where it likes."""
    read = tagged.read(printed)
    short = 0
    for number, height in enumerate(read.heights[:-1], start=1):
        bottoms = [p.bottom for p in read.pieces if p.page == number and p.kind]
        short += min(bottoms) - 13 / 25.4 * 72 > 0.25 * height
    assert short <= 1 or not form_of(chapter)


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
    assert below.source.startswith("## Answers")
    assert "<details open><summary>Along it</summary>" in first.source
    assert "<details open><summary>Why so?</summary>" in second.source


def test_a_text_that_waits_for_a_choice_is_with_the_answers():
    choice = "<details name='predict-9.1'><summary>{}</summary><p>{}</p></details>"
    choices = choice.format("More", "✗ No.") + choice.format("Less", "✓ So it is.")
    box = f'<div class="pgm-predict"><p>Choose one:</p>{choices}</div>'
    asked = new_output("display_data", {"text/html": box})
    figure = new_output("stream", name="stdout", text="3.4 px\n")
    derive = text("<details><summary>Derive it</summary>\n\nD\n</details>")
    derive.metadata.tags = ["derive"]
    book = example(
        text("## More?"),
        code('predict("9.1")', asked, figure, tags=("predict",)),
        text("It was 3.4 px."),
        text("Now look:"),
        code("look()"),
        text("## Write it"),
        code("f = 1", tags=("exercise",)),
        derive,
        text("Go on."),
    )
    sources = [cell.source for cell in for_handouts(book).cells]
    at = next(n for n, one in enumerate(sources) if one.startswith("## Answers"))
    assert sources[at - 1] == "Go on."
    assert "Now look:" in sources[:at]
    answer, waited, derived = for_handouts(book).cells[at + 1 :]
    assert answer.outputs[1].text == "3.4 px\n"
    right = "<p><strong>9.1</strong> Less ✓ So it is.</p>"
    assert answer.outputs[0].data["text/html"] == f"<div>{right}</div>"
    assert waited.source == "It was 3.4 px."
    assert "Derive it" in derived.source


@pytest.mark.parametrize(("solution", "count"), [(1, 2), (3, 3), (9, 3)])
def test_there_are_about_as_many_lines_to_write_on_as_a_solution_has(solution, count):
    solved = "    x = 1\n" * solution
    source = f"def f():\n    ### BEGIN SOLUTION\n{solved}    ### END SOLUTION"
    last = for_handouts(example(code(source))).cells[-1]
    assert last.source == "def f():" + f"\n\n    {'_' * 80}" * count


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
