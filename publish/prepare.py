"""What of a notebook goes into the slides and into the handouts."""

import re

from nbformat import NotebookNode

from publish.student import PLACEHOLDER, blank_solutions, tags


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
    return result


def slide_type(cell: NotebookNode) -> str:
    """Return slide, subslide, fragment, skip, notes or "-" (continues)."""
    return cell.metadata.get("slideshow", {}).get("slide_type", "-")


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
