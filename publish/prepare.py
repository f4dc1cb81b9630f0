"""What of a notebook goes into the slides and into the handouts."""

import re

from nbformat import NotebookNode

from publish.student import PLACEHOLDER, blank_solutions, slide_type, tags


def for_slides(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without solutions, checks and skipped cells."""
    result = _unsolved(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if slide_type(cell) != "skip" and "check" not in tags(cell)
    ]
    return result


def for_handouts(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without solutions and speaker notes."""
    result = _unsolved(notebook)
    result.cells = [cell for cell in result.cells if slide_type(cell) != "notes"]
    for cell in result.cells:
        # The template that both share leaves out what slides skip; paper does not.
        cell.metadata.pop("slideshow", None)
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
    result.cells = [cell for cell in result.cells if cell.source.strip()]
    for cell in result.cells:
        if PLACEHOLDER in cell.source or "check" in tags(cell):
            cell.outputs = []
    return result
