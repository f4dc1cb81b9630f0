"""What is wrong with a printed handout, read from its PDF.

A lesson and a case must have nothing of it; of the other notebooks it is listed.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import mistune
from bs4 import BeautifulSoup
from nbformat import NotebookNode

from pgm_book.make import tagged
from pgm_book.make.errors import PublishError
from pgm_book.make.forms import form_of
from pgm_book.make.student import tags

PAGES = {"lesson": 8, "case": 6}
FOOTER = 42.0  # points: the lower margin, where only the footer is
FILLED = 1 / 3  # of a page, except of the last
AT_LEAST = {"text": 9.0, "heading": 9.0, "code": 7.5}  # points
LABEL = 7.0  # points: the smallest writing in a figure
ROUNDING = 0.05
TEXTS = {"text", "heading", "code"}
HEADING = re.compile(r"^#+ +(.+)$", re.MULTILINE)


def check(printed: dict[Path, bytes], prepared: dict[Path, NotebookNode]) -> None:
    """Judge handouts; say what is wrong with those that are no lesson and no case.

    Parameters
    ----------
    printed : dict of Path and bytes
        The PDF of each notebook.
    prepared : dict of Path and NotebookNode
        What was printed of it (`paper.for_handouts`).

    Raises
    ------
    PublishError
        If a lesson or a case has a fault; it names the page.
    """
    refused = []
    for path, pdf in printed.items():
        form = form_of(path)
        found = [f"{path.name}, {said}" for said in faults(pdf, prepared[path], form)]
        if form:
            refused += found
        else:
            for said in found:
                print(f"publish: {said}", file=sys.stderr)
    if refused:
        said = "the handouts are written, but are not fit for paper:"
        raise PublishError("\n  ".join([said, *refused]))


def faults(pdf: bytes, notebook: NotebookNode, form: str = "") -> list[str]:
    """List what is wrong with a handout, each with its page.

    Parameters
    ----------
    pdf : bytes
        The handout.
    notebook : NotebookNode
        What was printed.
    form : str
        "lesson" or "case", whose pages are limited, or nothing.
    """
    printed = tagged.read(pdf)
    count = len(printed.heights)
    found = []
    if count > PAGES.get(form, count):
        found.append(f"it has {count} pages, a {form} has {PAGES[form]}")
    return [
        *found,
        *_lone_headings(printed.pieces),
        *_empty(printed),
        *_divided(printed.pieces, notebook),
        *_small_writing(printed.pieces),
        *_small_labels(printed.pieces, notebook),
    ]


def _lone_headings(pieces: list[tagged.Piece]) -> Iterator[str]:
    """Name the headings whose text or figure is on another page."""
    shown = [piece for piece in pieces if piece.kind]
    following = shown[-1].page if shown else 0
    alone: list[tagged.Piece] = []
    for piece in reversed(shown):
        if piece.kind != "heading":
            following = piece.page
        elif piece.page != following:
            alone.insert(0, piece)
    for piece in alone:
        said = f"the heading {piece.text.strip()!r} stands alone at its foot"
        yield f"page {piece.page}: {said}"


def _empty(printed: tagged.Printed) -> Iterator[str]:
    """Name the pages that are nearly empty; the last one may be.

    Lines to write on are not counted. They are at most 14 mm of a page.
    """
    for number, height in enumerate(printed.heights[:-1], start=1):
        bottoms = [p.bottom for p in printed.pieces if p.page == number]
        lowest = min((b for b in bottoms if b > FOOTER), default=height)
        used = (height - lowest) / height
        if used < FILLED:
            yield f"page {number}: only {used:.0%} of it is used"


def _divided(pieces: list[tagged.Piece], notebook: NotebookNode) -> Iterator[str]:
    """Name the questions and exercises that are not on one page."""
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
        # The words may also stand elsewhere: they count below those that ask for them.
        asked_at = max(letters.find(asked, end), end)
        found = letters.find(words, asked_at)
        if found < 0:
            yield f"{name} is not found on paper"
            continue
        begin, end = letters.rfind(asked, asked_at, found), found + len(words)
        begin = found if begin < 0 else begin
        where = set(pages[begin:end])
        where |= {p.page for p in pieces if p.kind == "picture" and p.text in alts}
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
        words = plain("".join(choice.get_text() for choice in asked[0]))
        metadata = [output.get("metadata", {}) for output in outputs]
        alts = [one.get("image/png", {}).get("alt") for one in metadata]
        return "question", words, [alt for alt in alts if alt]
    if "exercise" in tags(cell):
        return "exercise", plain(cell.source), []
    return "", "", []


def _last_words(source: str) -> str:
    """Return the last letters of a text, without its formulas."""
    words = BeautifulSoup(str(mistune.html(source)), "html.parser").get_text()
    return plain(re.sub(r"\$[^$]*\$", "", words))[-12:]


def _small_writing(pieces: list[tagged.Piece]) -> Iterator[str]:
    """Name the smallest text and code of each page that is hard to read."""
    small: dict[tuple[int, str], tagged.Piece] = {}
    for piece in pieces:
        least = AT_LEAST.get(piece.kind, 0.0)
        if piece.size < least - ROUNDING:
            key = piece.page, piece.kind
            small[key] = min(small.get(key, piece), piece, key=lambda p: p.size)
    for (page, kind), piece in sorted(small.items()):
        said = f"the {kind} {piece.text.strip()[:40]!r} is {piece.size:.1f} pt high"
        yield f"page {page}: {said}, less than {AT_LEAST[kind]:g}"


def _small_labels(pieces: list[tagged.Piece], notebook: NotebookNode) -> Iterator[str]:
    """Name the figures whose smallest writing is hard to read."""
    outputs = [o for cell in notebook.cells for o in cell.get("outputs", [])]
    seen = [output.get("metadata", {}).get("image/png", {}) for output in outputs]
    known = {one.get("alt"): one for one in seen if "label" in one and "width" in one}
    for piece in pieces:
        if piece.kind != "picture" or piece.text not in known:
            continue
        figure = known[piece.text]
        label = figure["label"] * piece.size / (figure["width"] * 72 / 96)
        if label < LABEL - ROUNDING:
            said = (
                f"the labels of the figure {piece.text[:50]!r} are {label:.1f} pt high"
            )
            yield f"page {piece.page}: {said}, less than {LABEL:g}"


def plain(text: str) -> str:
    """Letters and digits alone: a PDF keeps no spaces of its own."""
    text = text.replace("\ufb01", "fi").replace("\ufb02", "fl").replace("\ufb00", "ff")
    return "".join(sign for sign in text.lower() if sign.isalnum() and sign.isascii())
