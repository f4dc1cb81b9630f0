"""What of a notebook goes on paper."""

import re

from bs4 import BeautifulSoup
from nbformat import NotebookNode

from publish.student import slide_type, tags, unsolved

LONGEST_TABLE = 150  # rows; four pages
LABEL = 7.5  # pt: how large the smallest writing of a figure is printed
NARROWEST = 60.0  # mm
PREPARES = re.compile(r"import |from |plt\.style\.use\(")


def for_handouts(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without solutions, checks and speaker notes, as printed.

    What is folded to be read later is open on paper, a prediction stays closed; a
    figure is as small as its writing allows; a very long table stays in the notebook.

    Parameters
    ----------
    notebook : NotebookNode
        The executed notebook; it is not changed.
    """
    result = unsolved(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if slide_type(cell) != "notes" and "check" not in tags(cell)
        if not _only_prepares(cell)
    ]
    for cell in result.cells:
        # The template that both share leaves out what slides skip; paper does not.
        cell.metadata.pop("slideshow", None)
        if {"derive", "why"} & set(tags(cell)):
            cell.source = cell.source.replace("<details>", "<details open>")
        for output in cell.get("outputs", []):
            _shorten(output)
            _shrink(output)
    return result


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
        sentence = f"<p>{name}: {rows - 1} rows, which stand in the notebook.</p>"
        output.data["text/html"] = sentence


def _shrink(output: NotebookNode) -> None:
    """Print a figure no larger than its smallest writing needs."""
    seen = output.get("metadata", {}).get("image/png", {})
    if "label" in seen and "width" in seen:
        scale = min(1.0, LABEL / seen["label"])
        seen["width"] = max(seen["width"] * scale, NARROWEST / 25.4 * 96)
