"""Handouts: what of a notebook goes on paper, its PDF, and whether that can be read.

A lesson and a case must have none of the `faults`; of the other notebooks they are
listed.
"""

import html
import re
from collections.abc import Iterator
from itertools import zip_longest
from typing import TYPE_CHECKING

from bs4 import BeautifulSoup
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_markdown_cell, new_output

from pgm_book.make.archive import steady
from pgm_book.make.student import PLACEHOLDER, slide_type, tags, unsolved

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from pgm_book.make.tagged import Piece, Printed

LONGEST_TABLE = 150  # rows; four pages
LABEL = 7.0  # pt: how large the smallest writing of a figure is printed
NARROWEST = 60.0  # mm
HEADING = re.compile(r"^#+ +(.+?)(?: · \d+ min)?$", re.MULTILINE)
SUMMARY = re.compile(r"<summary>(.*?)</summary>", re.DOTALL)
OF_BOOK = re.compile(r"^from pgm_book\b.*\n", re.MULTILINE)  # checks and figures
SOLUTION = re.compile(r"### BEGIN SOLUTION(.*?)\n *### END SOLUTION", re.DOTALL)
TO_WRITE = re.compile(rf"^( *){re.escape(PLACEHOLDER)}", re.MULTILINE)
RULED = "_" * 80
FEWEST, MOST = 2, 3  # lines to write code on
ANSWERS = "## Answers\n\nEach has the number of its question."
PREDICTION = "pgm-predict"  # the class of its choices
PREPARES = re.compile(r"import |from |plt\.style\.use\(")

FOOTER = """\
<div style="width: 100%; margin: 0 15mm; display: flex; font: 8pt sans-serif;
            color: #4d5761; justify-content: space-between">
  <span>{title}</span>
  <span><span class="pageNumber"></span> / <span class="totalPages"></span></span>
</div>"""

PAGES = {"lesson": 8, "case": 6}
MARGIN = 36.0  # points: the lower one, where only the footer is
FILLED = 1 / 3  # of a page, except of the last
AT_LEAST = {"text": 9.0, "heading": 9.0, "code": 7.5}  # points
LEAST_LABEL = 7.0  # points: the smallest writing in a figure
ROUNDING = 0.05
TEXTS = {"text", "heading", "code"}


def for_handouts(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without solutions, checks and speaker notes, as printed.

    What is folded to be read later is open on paper, a prediction stays closed. Its
    answer, with what the cell shows, is at the end, so that a reader commits to one
    first; where code is to be written, there are lines. A figure is as small as its
    writing allows; a very long table stays in the notebook, and so does what is tagged
    `screen`, a figure that its text only sums up.
    """
    result = unsolved(notebook)
    _rule(result, notebook)
    result.cells = [
        cell
        for cell in result.cells
        if slide_type(cell) != "notes" and not {"check", "screen"} & set(tags(cell))
        if not _only_prepares(cell)
    ]
    for cell in result.cells:
        # The template that both share leaves out what slides skip; paper does not.
        cell.metadata.pop("slideshow", None)
        if {"derive", "why"} & set(tags(cell)):
            cell.source = cell.source.replace("<details>", "<details open>")
        if cell.cell_type == "code":
            cell.source = OF_BOOK.sub("", cell.source)
        for output in cell.get("outputs", []):
            _shorten(output)
            _shrink(output)
    result.cells = _answers_last(result.cells)
    return result


def _rule(blank: NotebookNode, solved: NotebookNode) -> None:
    """Where a solution is missing, rule about as many lines as it has."""
    sources = {cell.id: cell.source for cell in solved.cells}
    for cell in blank.cells:
        for solution in SOLUTION.findall(sources[cell.id]):
            count = min(max(solution.count("\n"), FEWEST), MOST)
            # With an empty line above each they are 7 mm apart.
            lines = rf"\n\g<1>{RULED}\n" * count
            cell.source = TO_WRITE.sub(lines[:-2], cell.source, count=1)


def _answers_last(cells: list[NotebookNode]) -> list[NotebookNode]:
    """Collect below a heading what would tell a reader too early.

    The results of a prediction go there, and the text below them that waits on a
    screen for a choice. A text that leads to code stays. There go the reasons,
    too, each with its question or its section's, and a derivation right below an
    exercise.
    """
    kept, answers, heading = [], [], ""
    above: set[str] = set()
    for cell, below in zip_longest(cells, cells[1:]):
        if cell.cell_type == "markdown":
            heading = [heading, *HEADING.findall(cell.source)][-1]
        if "why" in tags(cell):
            _name(cell, heading)
            answers.append(cell)
            continue
        if _too_early(cell, above, below):
            answers.append(cell)
        else:
            kept.append(cell)
            answers += _results(cell)
            above = set(tags(cell))
    if answers:
        kept.append(new_markdown_cell(ANSWERS, id="answers"))
    return kept + answers


def _too_early(cell: NotebookNode, above: set[str], below: NotebookNode | None) -> bool:
    """Whether a text tells what the cell with the tags `above` asks."""
    if cell.cell_type != "markdown" or HEADING.search(cell.source):
        return False
    if "derive" in tags(cell):
        return bool({"predict", "exercise"} & above)
    leads = below is not None and below.cell_type == "code"
    return "predict" in above and "write" not in tags(cell) and not leads


def _name(cell: NotebookNode, heading: str) -> None:
    """Put a heading in the place of a summary that asks nothing."""
    summary = SUMMARY.search(cell.source)
    if summary and "?" not in summary[1]:
        title = f"<summary>{re.sub('[*`]', '', heading)}</summary>"
        cell.source = cell.source.replace(summary[0], title)


def _results(cell: NotebookNode) -> list[NotebookNode]:
    """Take the results from a prediction: the right choices, and what it shows."""
    outputs = cell.get("outputs", [])
    pages = [output.get("data", {}).get("text/html", "") for output in outputs]
    asked = [
        output
        for output, page in zip(outputs, pages, strict=True)
        if PREDICTION in page
    ]
    if not asked:
        return []
    right = "".join(map(_right, asked))
    answer = new_output("display_data", {"text/html": f"<div>{right}</div>"})
    shown = [] if len(asked) > 1 else [one for one in outputs if one not in asked]
    cell.outputs = [one for one in outputs if one not in shown]
    figures = [one for one in shown if "image/png" in one.get("data", {})]
    others = [one for one in shown if one not in figures]
    metadata = {"tags": ["hide-input", "answer"]}
    made = new_code_cell(outputs=[*figures, answer, *others], metadata=metadata)
    made.id = f"{cell.id}-answer"
    return [made]


def _right(asked: NotebookNode) -> str:
    """Number a question, and return its number, right choice and feedback."""
    soup = BeautifulSoup(asked.data["text/html"], "html.parser")
    folded = soup.select("details")
    number = html.escape(str(folded[0].get("name", "")).removeprefix("predict-"))
    choose = soup.select_one(f".{PREDICTION} > p")
    if choose:
        choose.string = number
        asked.data["text/html"] = str(soup)
    right = [one for one in folded if one.get_text().count("✓")]
    parts = [part for one in right for part in one.select("summary, p")]
    said = [part.decode_contents() for part in parts]
    return f"<p><strong>{number}</strong> {' '.join(said)}</p>"


def _only_prepares(cell: NotebookNode) -> bool:
    """Whether a cell imports and sets the style, and shows nothing."""
    lines = [line for line in cell.source.splitlines() if line.strip()]
    prepares = all(PREPARES.match(line) for line in lines)
    return cell.cell_type == "code" and not cell.outputs and prepares


def _shorten(output: NotebookNode) -> None:
    """Put a sentence in the place of a very long table."""
    table = output.get("data", {}).get("text/html", "")
    rows = table.count("<tr")
    if rows > LONGEST_TABLE:
        caption = BeautifulSoup(table, "html.parser").find("caption")
        name = caption.get_text(" ", strip=True) if caption else "A table"
        sentence = f"<p>{name}: {rows - 1} rows, see the notebook.</p>"
        output.data["text/html"] = sentence


def _shrink(output: NotebookNode) -> None:
    """Print a figure no larger than its smallest writing needs."""
    seen = output.get("metadata", {}).get("image/png", {})
    if "label" in seen and "width" in seen:
        scale = min(1.0, LABEL / seen["label"])
        scale = max(scale, NARROWEST / 25.4 * 96 / seen["width"])
        seen["width"] *= scale
        seen["label"] *= scale


# --- The PDF ---


def print_pdf(browser: "Browser", content: str) -> bytes:
    """Return the PDF of an HTML page, tagged and with an outline."""
    from pgm_book.make.browser import offline_context

    context = offline_context(browser)
    try:
        page = context.new_page()
        page.set_content(content)
        page.wait_for_function("document.documentElement.dataset.ready")
        return pdf_of(page)
    finally:
        context.close()


def pdf_of(page: "Page") -> bytes:
    """Return the PDF of a page that is open and ready."""
    pdf = page.pdf(
        format="A4",
        margin={"top": "10mm", "bottom": "13mm", "left": "15mm", "right": "15mm"},
        print_background=True,
        display_header_footer=True,
        header_template="<span></span>",
        footer_template=FOOTER.format(title=html.escape(page.title())),
        tagged=True,
        outline=True,
    )
    return steady(pdf)


# --- What is wrong with it ---


def faults(pdf: bytes, notebook: NotebookNode, form: str = "") -> list[str]:
    """List what is wrong with a handout, each with its page."""
    from pgm_book.make import tagged

    printed = tagged.read(pdf)
    count = len(printed.heights)
    found = []
    if count > PAGES.get(form, count):
        found.append(f"it has {count} pages, a {form} at most {PAGES[form]}")
    return [
        *found,
        *_lone_headings(printed.pieces),
        *_empty(printed),
        *_divided(printed.pieces, notebook),
        *_small_writing(printed.pieces),
        *_small_labels(printed.pieces, notebook),
    ]


def _lone_headings(pieces: "list[Piece]") -> Iterator[str]:
    """Name the headings whose text or figure is on another page."""
    shown = [piece for piece in pieces if piece.kind]
    following = shown[-1].page if shown else 0
    alone: list[Piece] = []
    for piece in reversed(shown):
        if piece.kind != "heading":
            following = piece.page
        elif piece.page != following:
            alone.insert(0, piece)
    for piece in alone:
        said = f"the heading {piece.text.strip()!r} stands alone at its foot"
        yield f"page {piece.page}: {said}"


def _empty(printed: "Printed") -> Iterator[str]:
    """Name the pages that are nearly empty; the last one may be.

    Lines to write on are not counted. They are at most 14 mm of a page.
    """
    for number, height in enumerate(printed.heights[:-1], start=1):
        bottoms = [p.bottom for p in printed.pieces if p.page == number]
        lowest = min((b for b in bottoms if b > MARGIN), default=height)
        used = (height - lowest) / height
        if used < FILLED:
            yield f"page {number}: only {used:.0%} of it is used"


def _divided(pieces: "list[Piece]", notebook: NotebookNode) -> Iterator[str]:
    """Name the questions, exercises and answers that are not on one page."""
    shown = [(p.page, plain(p.text)) for p in pieces if p.kind in TEXTS]
    letters = "".join(text for _, text in shown)
    pages = [page for page, text in shown for _ in text]
    end, heading, asked = 0, "", ""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            heading = ([heading] + HEADING.findall(cell.source))[-1]
            asked = _last_words(cell.source)
            continue
        what, words, alts = _together(cell)
        if not what:
            continue
        name = f"the {what} under {heading!r}" if heading else f"the {what}"
        # The words may also occur elsewhere: they count below those that ask for them.
        asked_at = max(letters.find(asked, end), end)
        found = letters.find(words, asked_at)
        if found < 0:
            yield f"{name} is not found on paper"
            continue
        begin, end = letters.rfind(asked, asked_at, found), found + len(words)
        begin = found if begin < 0 or what == "answer" else begin
        where = set(pages[begin:end])
        for alt in alts:  # which other figures may have, too
            shown_on = {p.page for p in pieces if (p.kind, p.text) == ("picture", alt)}
            where |= set() if shown_on & where else shown_on
        if len(where) > 1:
            yield f"page {min(where)}: {name} is divided"
        asked = ""


def _together(cell: NotebookNode) -> tuple[str, str, list[str]]:
    """Return what a cell of code is, its letters, and the figures of its result.

    Nothing is said of several questions in one cell, the quick ones: they may go on
    overleaf.
    """
    outputs = cell.get("outputs", [])
    pages = [output.get("data", {}).get("text/html", "") for output in outputs]
    soups = [BeautifulSoup(page, "html.parser") for page in pages]
    asked = [soup.select(".pgm-predict summary") for soup in soups]
    asked = [choices for choices in asked if choices]
    if len(asked) == 1:
        return "question", plain("".join(one.get_text() for one in asked[0])), []
    if "answer" in tags(cell):
        (first, *_) = (soup.p for soup in soups if soup.p)
        metadata = [output.get("metadata", {}) for output in outputs]
        alts = [one["image/png"]["alt"] for one in metadata if "image/png" in one]
        return "answer", plain(first.get_text()), alts
    if "exercise" in tags(cell):
        return "exercise", plain(cell.source), []
    return "", "", []


def _last_words(source: str) -> str:
    """Return the last letters of a text, without its formulas."""
    import mistune

    words = BeautifulSoup(str(mistune.html(source)), "html.parser").get_text()
    return plain(re.sub(r"\$[^$]*\$", "", words))[-12:]


def _small_writing(pieces: "list[Piece]") -> Iterator[str]:
    """Name the smallest text and code of each page that is hard to read."""
    small: dict[tuple[int, str], Piece] = {}
    for piece in pieces:
        least = AT_LEAST.get(piece.kind, 0.0)
        if piece.size < least - ROUNDING:
            key = piece.page, piece.kind
            small[key] = min(small.get(key, piece), piece, key=lambda p: p.size)
    for (page, kind), piece in sorted(small.items()):
        said = f"the {kind} {piece.text.strip()[:40]!r} is {piece.size:.1f} pt high"
        yield f"page {page}: {said}, less than {AT_LEAST[kind]:g}"


def _small_labels(pieces: "list[Piece]", notebook: NotebookNode) -> Iterator[str]:
    """Name the figures whose smallest writing is hard to read."""
    outputs = [o for cell in notebook.cells for o in cell.get("outputs", [])]
    seen = [output.get("metadata", {}).get("image/png", {}) for output in outputs]
    known = {one.get("alt"): one for one in seen if "label" in one and "width" in one}
    for piece in pieces:
        if piece.kind != "picture" or piece.text not in known:
            continue
        figure = known[piece.text]
        label = figure["label"] * piece.size / (figure["width"] * 72 / 96)
        if label < LEAST_LABEL - ROUNDING:
            said = (
                f"the labels of the figure {piece.text[:50]!r} are {label:.1f} pt high"
            )
            yield f"page {piece.page}: {said}, less than {LEAST_LABEL:g}"


def plain(text: str) -> str:
    """Letters and digits alone: a PDF keeps no spaces of its own."""
    text = text.replace("\ufb01", "fi").replace("\ufb02", "fl").replace("\ufb00", "ff")
    return "".join(sign for sign in text.lower() if sign.isalnum() and sign.isascii())
