"""A deck as a list of slides, each a list of cells."""

from nbformat import NotebookNode
from nbformat.v4 import new_markdown_cell

from pgm_book.make.student import slide_type

MADE = "--"  # in the id of a cell that only slides have


def slides(cells: list[NotebookNode]) -> list[list[NotebookNode]]:
    """Return the cells by slides; the first slide begins with the first cell."""
    found: list[list[NotebookNode]] = []
    for cell in cells:
        if not found or slide_type(cell) in ("slide", "subslide"):
            found.append([])
        found[-1].append(cell)
    return found


def made(
    cell: NotebookNode, source: str, slide: str, number: int = 0, tag: str = ""
) -> NotebookNode:
    """Return a text for slides alone; its id begins with that of its cell."""
    metadata = {"slideshow": {"slide_type": slide}, "tags": [tag] * bool(tag)}
    return new_markdown_cell(source, id=f"{cell.id}{MADE}{number}", metadata=metadata)


def origin(cell_id: str) -> str:
    """Return the id of the notebook's cell that a cell of the slides comes from."""
    return cell_id.partition(MADE)[0]
