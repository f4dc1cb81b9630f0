"""The lecturer's notes on paper: a PDF a lesson, each note once, with the pace."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_markdown_cell

from pgm_book.make import slides
from pgm_book.make.form import MINUTES
from pgm_book.make.handouts import print_pdf
from pgm_book.make.page import handout_page
from pgm_book.make.student import slide_type

if TYPE_CHECKING:
    from playwright.sync_api import Browser

INTRODUCTION = (
    "Each note stands at the slide where it is first needed, with the minutes from the "
    "beginning of the lecture at which that slide should be seen."
)


def for_notes(notebook: NotebookNode, stem: str = "") -> NotebookNode:
    """Return the notes of a notebook's deck, below the titles of their slides.

    On slides a section's note is repeated; on paper the slides that share it are named
    once, below it. Where the notes give no minutes there is no clock.
    """
    deck = slides.for_slides(notebook, "lecturer", stem)
    texts = [f"# Notes: {slides.title(notebook)}\n\n{INTRODUCTION}"]
    said: set[tuple[str, str]] = set()  # cell and text: two may say "2 minutes."
    then: list[str] = []  # slides without a note of their own
    seconds = 0
    for number, slide in enumerate(slides.divided(deck.cells), start=1):
        heading = slides.HEADING.search(slide[0].source)
        title = MINUTES.sub("", heading[0].lstrip("# ")) if heading else ""
        notes = {
            (slides.origin(cell.id), cell.source): cell.source
            for cell in slide
            if slide_type(cell) == "notes"
        }
        new = [text for note, text in notes.items() if note not in said]
        timing = slide[0].metadata.get("slideshow", {}).get("data", {}).get("timing", 0)
        clock = f" · minute {seconds // 60}" if timing else ""
        seconds += timing
        if new:
            texts += [f"*Then*: {'; '.join(then)}"] * bool(then)
            texts.append("\n\n".join([f"## {number}. {title}{clock}", *new]))
            then = []
        elif number > 1:  # the title needs no line
            then.append(f"{number} {title}")
        said.update(notes)
    texts += [f"*Then*: {'; '.join(then)}"] * bool(then)
    deck.cells = [
        new_markdown_cell(text, id=f"note-{number}")
        for number, text in enumerate(texts)
    ]
    return deck


def print_notes(browser: "Browser", notebooks: list[Path]) -> dict[str, bytes]:
    """Return the PDF of each notebook's notes, by its name."""
    printed = {}
    for path in notebooks:
        title = slides.title(nbformat.read(path, as_version=4))
        prepared = partial(for_notes, stem=path.stem)
        page = handout_page(path, prepared, f"Notes: {title}")
        printed[f"{path.stem}.pdf"] = print_pdf(browser, page)
    return printed
