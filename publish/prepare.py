"""What of a notebook goes into the slides and into the handouts."""

import re

from nbformat import NotebookNode

from publish.student import PLACEHOLDER, blank_solutions, slide_type, tags

# "## What is a pixel? · 8 min": what a section takes a reader who works alone
MINUTES = re.compile(r"^(## .*\S) · \d+ min$", re.MULTILINE)


def for_slides(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without what is only for reading or for working alone."""
    result = _unsolved(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if slide_type(cell) != "skip" and not {"check", "write"} & set(tags(cell))
    ]
    for cell in result.cells:
        # A lecture has its own minutes; those of the heading are a reader's.
        cell.source = MINUTES.sub(r"\1", cell.source)
    return result


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
