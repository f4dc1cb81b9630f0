"""The chapters: each notebook with its stored outputs, as a page.

A page has what a student's copy has and the outputs besides. Solutions are folded below
their exercises, and what a prediction asks about waits for a click.
"""

import base64
import copy
import html
import re
import struct
from pathlib import Path

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_markdown_cell, new_output

from pgm_book.make.student import PLACEHOLDER, blank_solutions, name, slide_type, tags
from pgm_lab import datasets

LEFT_OUT = {"claims", "write"}
FOLDED = {"draw", "hide-input", "predict"}
MARKER = re.compile(r"^\s*#+\s*(BEGIN|END)\s+SOLUTION.*\n?", re.M | re.I)
HEADING = re.compile(r"^#{1,3} ", re.MULTILINE)
STYLE = re.compile(r"<style>.*?</style>\s*", re.DOTALL)


def write(chapters: list[Path], folder: Path) -> list[str]:
    """Write the notebooks as the site shows them; return the names of their pages."""
    (folder / "chapters").mkdir()
    order = [row["notebook"] for row in datasets.rows("chapters.csv")]
    known = {name: place for place, name in enumerate(order)}
    chapters = sorted(chapters, key=lambda path: known.get(path.stem, len(known)))
    for path in chapters:
        page, figures = prepare(nbformat.read(path, as_version=4), path.stem)
        nbformat.write(page, folder / "chapters" / path.name)
        for file, content in figures.items():
            target = folder / "files" / "chapters" / file
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
    return [f"chapters/{path.stem}" for path in chapters]


def prepare(notebook: NotebookNode, stem: str) -> tuple[NotebookNode, dict[str, bytes]]:
    """Return the notebook as a reader of the site gets it, and its figures by name."""
    blank = {cell.id: cell for cell in blank_solutions(notebook).cells}
    result = copy.deepcopy(notebook)
    result.cells, figures = [], {}
    waits = False
    for solved in notebook.cells:
        if slide_type(solved) == "notes" or LEFT_OUT & set(tags(solved)):
            continue
        cell = blank.get(solved.id)
        if cell is None or not cell.source.strip():
            continue
        if cell.cell_type == "markdown":
            if waits and not HEADING.search(cell.source):
                cell.source = f'<div class="pgm-waits">\n\n{cell.source}\n\n</div>'
            result.cells.append(cell)
            waits = False
            continue
        waits = "predict" in tags(cell)
        if FOLDED & set(tags(cell)):
            cell.metadata["tags"] = sorted({*tags(cell), "hide-input"})
        result.cells.append(cell)
        if PLACEHOLDER in cell.source:
            # What a picture shows is asked about; what is printed answers it.
            cell.outputs = [o for o in cell.outputs if "image/png" in o.get("data", {})]
            result.cells.append(_solution(solved))
        cell.outputs = [_output(o, cell, stem, figures) for o in cell.outputs]
    return result, figures


def _solution(cell: NotebookNode) -> NotebookNode:
    """Return a solved exercise and what it prints, folded."""
    printed = "".join(o.text for o in cell.outputs if o.output_type == "stream")
    parts = [
        '<details class="pgm-solution"><summary>One solution</summary>',
        f"```python\n{MARKER.sub('', cell.source)}\n```",
        *([f"```text\n{printed.rstrip()}\n```"] if printed.strip() else []),
        "</details>",
    ]
    return new_markdown_cell("\n\n".join(parts), id=f"{cell.id}-solution"[:64])


def _output(
    output: NotebookNode, cell: NotebookNode, stem: str, figures: dict[str, bytes]
) -> NotebookNode:
    """Return an output whose figure is a file, and whose style is that of the site."""
    data = output.get("data", {})
    if "image/png" in data:
        content = base64.b64decode(data["image/png"])
        told = output.metadata.get("image/png", {})
        if not told.get("alt"):
            raise ValueError(f"{stem}, {name(cell)}: a figure has no alternative text")
        file = f"{stem}-{len(figures) + 1}.png"
        figures[file] = content
        return _as_html(_picture(file, content, told))
    if "text/html" in data:
        return _as_html(STYLE.sub("", data["text/html"]))
    return output


def _picture(file: str, content: bytes, told: dict) -> str:
    """Write a figure, a link to itself so that a phone shows it large."""
    pixels = struct.unpack(">II", content[16:24])  # the head of a PNG
    width = int(told.get("width", pixels[0]))
    height = round(width * pixels[1] / pixels[0])
    return (
        f'<a class="pgm-figure" href="{file}"><img src="{file}" width="{width}" '
        f'height="{height}" loading="lazy" alt="{html.escape(told["alt"])}"></a>'
    )


def _as_html(text: str) -> NotebookNode:
    return new_output("display_data", data={"text/html": text})
