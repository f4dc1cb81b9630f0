"""What of a notebook goes into the slides and into the handouts."""

import re
from typing import Literal

from nbformat import NotebookNode

from publish import questions
from publish.student import PLACEHOLDER, blank_solutions, slide_type, tags

# "## What is a pixel? · 8 min": what a section takes a reader who works alone
MINUTES = re.compile(r"^(## .*\S) · \d+ min$", re.MULTILINE)
HEADING = re.compile(r"#+ .*\n*")  # the first line of a text

Audience = Literal["lecturer", "student"]


def for_slides(notebook: NotebookNode, audience: Audience) -> NotebookNode:
    """Return the notebook without what is only for reading or for working alone.

    The lecturer's slides have notes and the answers to the quick questions; in the
    students' there is neither, also out of sight.
    """
    lecturer = audience == "lecturer"
    result = _unsolved(notebook)
    cells = []
    for cell in result.cells:
        # A lecture has its own minutes; those of the heading are a reader's.
        cell.source = MINUTES.sub(r"\1", cell.source)
        kind = slide_type(cell)
        read_alone = kind == "skip" or {"check", "write"} & set(tags(cell))
        if asked := questions.slides(cell, key=lecturer):
            cells += asked
        elif not read_alone and (lecturer or kind != "notes"):
            cells += titled(cell)
    result.cells = cells
    return result


def titled(cell: NotebookNode) -> list[NotebookNode]:
    """Return the cell with the heading that it has on slides alone, if it has one."""
    heading = cell.metadata.get("slideshow", {}).get("title")
    if not heading:
        return [cell]
    if cell.cell_type == "markdown":
        cell.source = f"### {heading}\n\n{HEADING.sub('', cell.source.lstrip())}"
        return [cell]
    kind = cell.metadata.pop("slideshow")["slide_type"]
    above = questions.made(cell, f"### {heading}", kind)
    return [above, cell]


def for_handouts(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without solutions and speaker notes."""
    result = _unsolved(notebook)
    result.cells = [cell for cell in result.cells if slide_type(cell) != "notes"]
    for cell in result.cells:
        # The template that both share leaves out what slides skip; paper does not.
        cell.metadata.pop("slideshow", None)
        # What is folded to be read later is open on paper; a prediction stays closed.
        if {"derive", "why"} & set(tags(cell)):
            cell.source = cell.source.replace("<details>", "<details open>")
    return result


def title(notebook: NotebookNode) -> str:
    """Return the first heading as plain text."""
    for cell in notebook.cells:
        heading = re.search(r"^#+ +(.+?)\s*#*$", cell.source, re.MULTILINE)
        if cell.cell_type == "markdown" and heading:
            return re.sub(r"[*`$]|<[^>]*>", "", heading[1])
    return "Untitled"


def _unsolved(notebook: NotebookNode) -> NotebookNode:
    """Blank the solutions, and clear the outputs that would give them away."""
    result = blank_solutions(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if cell.source.strip() and "claims" not in tags(cell)
    ]
    for cell in result.cells:
        if PLACEHOLDER in cell.source or "check" in tags(cell):
            cell.outputs = []
    return result
