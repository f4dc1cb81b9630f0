"""What of a notebook goes on paper."""

import re

from bs4 import BeautifulSoup
from nbformat import NotebookNode
from nbformat.v4 import new_markdown_cell

from pgm_book.make.student import slide_type, tags, unsolved

LONGEST_TABLE = 150  # rows; four pages
LABEL = 7.5  # pt: how large the smallest writing of a figure is printed
NARROWEST = 60.0  # mm
OWN = re.compile(r"^\w+: the book's own\. .*\n?", re.MULTILINE)  # of checks.own
HEADING = re.compile(r"^#+ +(.+?)(?: · \d+ min)?$", re.MULTILINE)
SUMMARY = re.compile(r"<summary>(.*?)</summary>", re.DOTALL)
PREPARES = re.compile(r"import |from |plt\.style\.use\(")


def for_handouts(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook without solutions, checks and speaker notes, as printed.

    What is folded to be read later is open on paper, a prediction stays closed. The
    answers stand at the end, so that a reader commits to one of their own before. A
    figure is as small as its writing allows; a very long table stays in the notebook,
    and so does what is tagged `screen`, a figure that its text only sums up.

    Parameters
    ----------
    notebook : NotebookNode
        The executed notebook; it is not changed.
    """
    result = unsolved(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if slide_type(cell) != "notes" and not {"check", "screen"} & set(tags(cell))
        if not _only_prepares(cell)
    ]
    for cell in result.cells:
        # The template that both share leaves out what slides skip; paper does not.
        cell.metadata.pop("slideshow", None)
        if {"derive", "why"} & set(tags(cell)):
            cell.source = cell.source.replace("<details>", "<details open>")
        _leave_out_own(cell)
        for output in cell.get("outputs", []):
            _shorten(output)
            _shrink(output)
    result.cells = _answers_last(result.cells)
    return result


def _answers_last(cells: list[NotebookNode]) -> list[NotebookNode]:
    """Collect the answers below a heading, each with its question or its section's."""
    kept, answers, heading = [], [], ""
    for cell in cells:
        if "why" not in tags(cell):
            kept.append(cell)
            if cell.cell_type == "markdown":
                heading = [heading, *HEADING.findall(cell.source)][-1]
            continue
        summary = SUMMARY.search(cell.source)
        if summary and "?" not in summary[1]:
            title = f"<summary>{re.sub('[*`]', '', heading)}</summary>"
            cell.source = cell.source.replace(summary[0], title)
        answers.append(cell)
    if answers:
        kept.append(new_markdown_cell("## Answers", id="answers"))
    return kept + answers


def _leave_out_own(cell: NotebookNode) -> None:
    """Drop the lines that say whose function runs: nothing runs on paper."""
    for output in cell.get("outputs", []):
        if output.output_type == "stream":
            output.text = OWN.sub("", output.text)
    if "outputs" in cell:
        cell.outputs = [output for output in cell.outputs if output.get("text", True)]


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
        scale = max(scale, NARROWEST / 25.4 * 96 / seen["width"])
        seen["width"] *= scale
        seen["label"] *= scale
