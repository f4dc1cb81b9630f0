"""The chapters: each notebook with its stored outputs, as a page."""

from pathlib import Path

import nbformat
from nbformat import NotebookNode

from publish.student import slide_type, tags

FOLDED = {"draw", "hide-input", "predict"}


def write(chapters: list[Path], folder: Path) -> list[str]:
    """Write the notebooks as the site shows them; return the names of their pages."""
    target = folder / "chapters"
    target.mkdir()
    for path in chapters:
        notebook = nbformat.read(path, as_version=4)
        nbformat.write(prepare(notebook), target / path.name)
    return [f"chapters/{path.stem}" for path in chapters]


def prepare(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook as a reader of the site gets it."""
    notebook.cells = [
        cell
        for cell in notebook.cells
        if slide_type(cell) != "notes" and not {"claims", "write"} & set(tags(cell))
    ]
    for cell in notebook.cells:
        if FOLDED & set(tags(cell)):
            cell.metadata["tags"] = [*tags(cell), "hide-input"]
    return notebook
