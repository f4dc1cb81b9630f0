"""What a slide should not be: untitled, about cells, or with its answer at once."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import nbformat
from bs4 import BeautifulSoup
from nbformat import NotebookNode

from pgm_book.make import deck, prepare
from pgm_book.make.errors import PublishError
from pgm_book.make.forms import form_of
from pgm_book.make.student import slide_type, tags

HEADING = re.compile(r"^#{1,6} .*\S", re.MULTILINE)
FENCED = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)

# A slide has no cells, and no place but itself to point to.
OF_A_NOTEBOOK = re.compile(
    r"\b("
    r"(this|the|each|every|next|last|previous|following|check) cells?"
    r"|cells? (above|below)"
    r"|(code|text|folded) cells?"
    r"|run (this|it|the (cell|notebook)|all)"
    r"|typed? (it |them )?(in|into)\b"
    r"|double-click|shift \+ enter"
    r"|at the (top|bottom|end) of (this|the) (page|notebook|chapter)"
    r"|(picture|figure|photo|map|table|sketch) (at the (top|bottom)|above|below)"
    r"|(check|exercise|answer|derivation|code) (above|below)"
    r"|scroll (up|down)"
    r")",
    re.IGNORECASE,
)


def problems(cells: list[NotebookNode]) -> list[str]:
    """Name the slides that lack a title, speak of cells or show an answer at once.

    Parameters
    ----------
    cells : list of NotebookNode
        What `prepare.for_slides` returns.

    Returns
    -------
    list of str
        Nothing, or a sentence for each finding, with slide and words.
    """
    return [
        f"slide {number}{_called(slide)}: {said}"
        for number, slide in enumerate(deck.slides(cells), start=1)
        for said in [*_heading(slide), *_words(slide), *_answers(slide)]
    ]


def check(notebooks: list[Path]) -> None:
    """Refuse lessons and cases whose slides have problems; list those of the others.

    Raises
    ------
    PublishError
        If a lesson or a case has a problem; it names each slide.
    """
    refused = []
    for path in notebooks:
        notebook = nbformat.read(path, as_version=4)
        slides = prepare.for_slides(notebook, "lecturer", path.stem)
        for said in problems(slides.cells):
            if form_of(path):
                refused.append(f"{path.name}, {said}")
            else:
                print(f"publish: {path.name}, {said}", file=sys.stderr)
    if refused:
        said = "the slides are written, but they are not fit for a hall:"
        raise PublishError("\n  ".join([said, *refused]))


def _called(slide: list[NotebookNode]) -> str:
    heading = HEADING.search(slide[0].source)
    return f" ({heading[0].lstrip('# ')!r})" if heading else f" ({slide[0].id})"


def _shown(slide: list[NotebookNode]) -> list[NotebookNode]:
    return [cell for cell in slide if slide_type(cell) != "notes"]


def _heading(slide: list[NotebookNode]) -> Iterator[str]:
    """Say if a slide does not begin with its only heading."""
    texts = [c for c in _shown(slide) if c.cell_type == "markdown"]
    headings = [h for c in texts for h in HEADING.findall(FENCED.sub("", c.source))]
    if slide[0] not in texts or not HEADING.match(slide[0].source.lstrip()):
        yield "has no heading; give its first cell one, or slideshow.title in metadata"
    elif len(headings) > 1:
        yield f"has {len(headings)} headings, the second {headings[1]!r}"


def _words(slide: list[NotebookNode]) -> Iterator[str]:
    """Say which words of a slide are about the notebook."""
    for cell in _shown(slide):
        for text in _texts(cell):
            for found in OF_A_NOTEBOOK.finditer(text):
                yield f"says {found[0]!r}, which a slide does not have"


def _texts(cell: NotebookNode) -> Iterator[str]:
    """Yield what the hall reads of a cell, without code."""
    if cell.cell_type == "markdown":
        yield FENCED.sub("", cell.source)
        return
    for output in cell.outputs:
        yield output.get("text", "")
        html = output.get("data", {}).get("text/html", "")
        soup = BeautifulSoup(html, "html.parser")
        for hidden in soup.select("style, .pgm-shown"):
            hidden.decompose()
        yield soup.get_text(" ")


def _answers(slide: list[NotebookNode]) -> Iterator[str]:
    """Say what answers a question of the same slide at once.

    What follows a question waits: as a fragment, folded, or behind the choices of a
    prediction. A cell that shows nothing need not.
    """
    asked, waits = "", False
    for cell in _shown(slide):
        folded = cell.source.lstrip().startswith("<details>")
        if "predict" in tags(cell) or slide_type(cell) == "fragment":
            waits = True
        unseen = "hide-input" in tags(cell) and not cell.outputs
        if asked and not (waits or folded or unseen):
            first = cell.source.strip().partition("\n")[0]
            yield f"shows {first[:50]!r} at once with the question {asked[:50]!r}"
            asked = ""
        if cell.cell_type == "markdown" and not folded and _asks(cell.source):
            asked, waits = " ".join(_asks(cell.source).split()), False


def _asks(text: str) -> str:
    """Return the question that a text poses: a prediction, or its last sentence."""
    text = HEADING.sub("", text).strip()
    predict = text.find("**Predict")
    if predict >= 0:
        return text[predict:]
    last = re.split(r"(?<=[.!?:]) |\n\n", text.rstrip("*_ "))[-1]
    return last if last.endswith("?") else ""
