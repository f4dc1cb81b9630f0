"""What is wrong with a printed handout, read from its PDF.

A lesson and a case must have nothing of it; of the other notebooks it is listed.
"""

import re
import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import mistune
from bs4 import BeautifulSoup
from nbformat import NotebookNode
from pypdf import PageObject, PdfReader

from publish.chapters import form_of
from publish.errors import PublishError
from publish.student import tags

PAGES = {"lesson": 8, "case": 6}
FOOTER = 48.0  # points from the lower edge of the paper: only the footer is below
BELOW = 36.0  # points, three lines: what has to stand below a heading
FILLED = 1 / 3  # of a page, except of the last


def check(printed: dict[Path, bytes], prepared: dict[Path, NotebookNode]) -> None:
    """Judge handouts; say what is wrong with those of the older form.

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
    reader = PdfReader(BytesIO(pdf))
    found = []
    if len(reader.pages) > PAGES.get(form, len(reader.pages)):
        found.append(f"it has {len(reader.pages)} pages, a {form} has {PAGES[form]}")
    found += _lone_headings(reader, reader.outline)
    for number, page in enumerate(reader.pages[:-1], start=1):
        height = float(page.mediabox.height)
        used = (height - lowest(page)) / height
        if used < FILLED:
            found.append(f"page {number}: only {used:.0%} of it is used")
    return found + list(_divided(reader, notebook))


def lowest(page: PageObject) -> float:
    """Return the height of the lowest text or picture above the footer, in points."""
    heights = [float(page.mediabox.height)]

    def text(words, cm, tm, font, size):
        if words.strip():
            heights.append(tm[4] * cm[1] + tm[5] * cm[3] + cm[5])

    def picture(operator, operands, cm, tm):
        if operator == b"Do":
            heights.append(min(cm[5], cm[5] + cm[3]))

    page.extract_text(visitor_text=text, visitor_operand_before=picture)
    return min(height for height in heights if height > FOOTER)


def _lone_headings(reader: PdfReader, outline: list) -> Iterator[str]:
    """Name the headings at the foot of a page."""
    for entry in outline:
        if isinstance(entry, list):
            yield from _lone_headings(reader, entry)
        elif float(entry.top) < FOOTER + BELOW:
            number = reader.get_destination_page_number(entry) + 1
            yield f"page {number}: the heading {entry.title!r} stands alone at its foot"


def _divided(reader: PdfReader, notebook: NotebookNode) -> Iterator[str]:
    """Name the questions and exercises that are not on one page."""
    pages = [plain(page.extract_text()) for page in reader.pages]
    pictures = described(reader)
    before = ""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            before = BeautifulSoup(mistune.html(cell.source), "html.parser").get_text()
            before = plain(re.sub(r"\$[^$]*\$", "", before))[-12:]
            continue
        parts, what = [before], ""
        if "exercise" in tags(cell):
            what, parts = "exercise", [before, *_ends(cell.source)]
        choices = _choices(cell)
        if len(choices) == 1:
            what, parts = "question", [before, *map(plain, choices[0])]
        where = [{n for n, page in enumerate(pages, 1) if p in page} for p in parts]
        where += [pictures.get(alt, set()) for alt in _alts(cell) if choices]
        if what and not set.intersection(*where):
            number = min(min(places, default=0) for places in where)
            yield f"page {number}: the {what} {before!r} is divided"
        if what:
            before = ""


def plain(text: str) -> str:
    """Letters and digits alone: a PDF keeps no spaces of its own."""
    text = text.replace("\ufb01", "fi").replace("\ufb02", "fl").replace("\ufb00", "ff")
    return "".join(sign for sign in text.lower() if sign.isalnum() and sign.isascii())


def _ends(source: str) -> list[str]:
    """First and last line of a cell of code."""
    lines = [plain(line.partition("#")[0])[:40] for line in source.splitlines()]
    lines = [line for line in lines if line]
    return [lines[0], lines[-1]]


def _choices(cell: NotebookNode) -> list[list[str]]:
    """Return the choices of each prediction that a cell shows."""
    pages = [o.get("data", {}).get("text/html", "") for o in cell.get("outputs", [])]
    soups = [BeautifulSoup(page, "html.parser") for page in pages]
    found = [soup.select(".pgm-predict summary") for soup in soups]
    return [[one.get_text() for one in several] for several in found if several]


def _alts(cell: NotebookNode) -> list[str]:
    outputs = cell.get("outputs", [])
    found = [o.get("metadata", {}).get("image/png", {}).get("alt") for o in outputs]
    return [alt for alt in found if alt]


def described(reader: PdfReader) -> dict[str, set[int]]:
    """Return the pages of each picture, by its description."""
    numbers = {
        page.indirect_reference.idnum: n for n, page in enumerate(reader.pages, 1)
    }
    found: dict[str, set[int]] = {}
    for number in range(1, reader.trailer["/Size"]):
        element = reader.get_object(number)
        if not isinstance(element, dict) or "/Alt" not in element:
            continue
        kids = element.get("/K", [])
        for holder in [element, *(kids if isinstance(kids, list) else [kids])]:
            page = holder.raw_get("/Pg") if "/Pg" in _mapping(holder) else None
            if page is not None:
                found.setdefault(str(element["/Alt"]), set()).add(numbers[page.idnum])
    return found


def _mapping(holder) -> dict:
    holder = holder.get_object() if hasattr(holder, "get_object") else holder
    return holder if isinstance(holder, dict) else {}
