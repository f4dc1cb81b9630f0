"""What of a notebook goes into the slides."""

import re
from typing import Literal

from nbformat import NotebookNode

from pgm_book.make import deck, pace, questions, verdicts
from pgm_book.make.student import slide_type, tags, unsolved

# "## What is a pixel? · 8 min": what a section takes a reader who works alone
MINUTES = re.compile(r"^(## .*\S) · \d+ min$", re.MULTILINE)
# What `checks.own` says: a hall need not know whose program drew
OWN = re.compile(r"^\w+: the book's own\..*\n?", re.MULTILINE)
HEADING = re.compile(r"#+ .*\n*")  # the first line of a text
# An exercise that follows the text of its slide: it is worked on alone
EXERCISE = re.compile(r"\n+### Exercise .*", re.DOTALL)

Audience = Literal["lecturer", "student"]


def for_slides(
    notebook: NotebookNode, audience: Audience, stem: str = ""
) -> NotebookNode:
    """Return the notebook as slides: without what is for reading or working alone.

    The lecturer's slides have notes and the answers to the quick questions; in the
    students' there is neither, also out of sight. Both have the same pace and break.

    Parameters
    ----------
    notebook : NotebookNode
        The executed notebook; it is not changed.
    audience : "lecturer" or "student"
        Whose slides.
    stem : str
        Name of the file, by which a lesson finds its case.
    """
    result = unsolved(notebook)
    cells = []
    for cell in result.cells:
        asked = questions.slides(cell, key=audience == "lecturer")
        read_alone = {"check", "write"} & set(tags(cell)) or slide_type(cell) == "skip"
        cells += asked or ([] if read_alone else [cell])
    parts = pace.sections(notebook, cells)
    pace.keep_time(parts)
    pace.repeat_notes(parts)
    pace.add_break(parts, notebook, stem)
    result.cells = [
        cell
        for part in parts
        for slide in part.slides
        for cell in _finished(slide)
        if audience == "lecturer" or slide_type(cell) != "notes"
    ]
    return result


def _finished(slide: list[NotebookNode]) -> list[NotebookNode]:
    """Return a slide with its title, without what is for reading alone; with cards."""
    for cell in slide:
        cell.source = MINUTES.sub(r"\1", cell.source)
        if cell.cell_type == "markdown":
            cell.source = EXERCISE.sub("", cell.source)
        for output in list(cell.get("outputs", [])):
            if output.output_type == "stream":
                output.text = OWN.sub("", output.text)
                if not output.text:
                    cell.outputs.remove(output)
    return verdicts.as_cards(titled(slide[0]) + slide[1:])


def titled(cell: NotebookNode) -> list[NotebookNode]:
    """Return a slide's first cell with the heading that it has on slides alone."""
    slideshow = cell.metadata.get("slideshow", {})
    if "title" not in slideshow:
        return [cell]
    heading = f"### {slideshow['title']}"
    if cell.cell_type == "markdown":
        cell.source = f"{heading}\n\n{HEADING.sub('', cell.source.lstrip(), count=1)}"
        return [cell]
    above = deck.made(cell, heading, slide_type(cell))
    above.metadata.slideshow = cell.metadata.pop("slideshow")
    return [above, cell]


def title(notebook: NotebookNode) -> str:
    """Return the first heading as plain text."""
    for cell in notebook.cells:
        heading = re.search(r"^#+ +(.+?)\s*#*$", cell.source, re.MULTILINE)
        if cell.cell_type == "markdown" and heading:
            return re.sub(r"[*`$]|<[^>]*>", "", heading[1])
    return "Untitled"
