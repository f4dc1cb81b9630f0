"""What of a notebook goes on slides: its titles, pace, questions, verdicts and notes.

A deck is a list of slides, each a list of cells. Where a lesson or a case shows a slide
without its heading, or an answer at once with its question, `faults` names it.
"""

import copy
import re
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from itertools import accumulate, pairwise
from typing import Literal

from bs4 import BeautifulSoup
from nbformat import NotebookNode
from nbformat.v4 import new_markdown_cell

from pgm_book.make import form
from pgm_book.make.student import slide_type, tags, unsolved
from pgm_lab import datasets

# "## What is a pixel? · 8 min": the time that a section takes a reader who works alone
MINUTES = re.compile(r"^(## .*\S) · \d+ min$", re.MULTILINE)
FIRST_LINE = re.compile(r"#+ .*\n*")
# An exercise that follows the text of its slide: it is worked on alone
EXERCISE = re.compile(r"\n+### Exercise .*", re.DOTALL)
HEADING = re.compile(r"^#{1,6} .*\S", re.MULTILINE)
FENCED = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)
SENTENCE = re.compile(r"(?<=[.?!]) (?=[A-Z])")

MADE = "--"  # in the id of a cell that only slides have
STEP = 5  # seconds: nobody keeps time more exactly
SHORT = 30  # minutes; who has listened for less needs no break
QUESTIONS = "the quick questions"
# A mark beside the colour of a verdict, for those who cannot distinguish the colours
MARKS = {"reproduced": "✓", "corrected": "≠", "not derivable": "?"}
LEDGER = ["source", "printed", "what we get", "verdict"]
CARDS = 3  # verdicts on a slide

Audience = Literal["lecturer", "student"]
Row = list[str]


def for_slides(
    notebook: NotebookNode, audience: Audience, stem: str = ""
) -> NotebookNode:
    """Return the notebook as slides: without what is for reading or working alone.

    The lecturer's slides have notes and the answers to the quick questions; in the
    students' there is neither, also out of sight. Both have the same pace and break.
    """
    result = unsolved(notebook)
    cells = []
    for cell in result.cells:
        asked = questions(cell, key=audience == "lecturer")
        read_alone = {"check", "write"} & set(tags(cell)) or slide_type(cell) == "skip"
        cells += asked or ([] if read_alone else [cell])
    parts = sections(notebook, cells)
    keep_time(parts)
    notes_first(parts)
    add_break(parts, notebook, stem)
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
    return as_cards(titled(slide[0]) + slide[1:])


def titled(cell: NotebookNode) -> list[NotebookNode]:
    """Return a slide's first cell with the heading that it has on slides alone."""
    slideshow = cell.metadata.get("slideshow", {})
    if "title" not in slideshow:
        return [cell]
    heading = f"### {slideshow['title']}"
    if cell.cell_type == "markdown":
        cell.source = (
            f"{heading}\n\n{FIRST_LINE.sub('', cell.source.lstrip(), count=1)}"
        )
        return [cell]
    above = made(cell, heading, slide_type(cell))
    above.metadata.slideshow = cell.metadata.pop("slideshow")
    return [above, cell]


def title(notebook: NotebookNode) -> str:
    """Return the first heading as plain text."""
    for cell in notebook.cells:
        heading = re.search(r"^#+ +(.+?)\s*#*$", cell.source, re.MULTILINE)
        if cell.cell_type == "markdown" and heading:
            return re.sub(r"[*`$]|<[^>]*>", "", heading[1])
    return "Untitled"


# --- Slides and cells that slides alone have ---


def divided(cells: list[NotebookNode]) -> list[list[NotebookNode]]:
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


# --- The pace of a lecture, from the minutes that the lecturer's notes begin with ---


@dataclass(frozen=True)
class Section:
    """The slides of a section, and its minutes in the lecture."""

    title: str
    minutes: int
    slides: list[list[NotebookNode]]


def sections(notebook: NotebookNode, cells: list[NotebookNode]) -> list[Section]:
    """Return the slides by sections; quick questions are one without minutes.

    Where a section's note gives no minutes, none has any: a pace with holes misleads.
    """
    minutes = form.lecture(notebook)
    known = None not in minutes.values()
    found = [Section(form.HEAD, 0, [])]
    for slide in divided(cells):
        heading = form.SECTION.search(slide[0].source)
        title = form.MINUTES.sub("", heading[1]) if heading else ""
        if title in minutes:
            found.append(Section(title, (minutes[title] or 0) * known, []))
        elif "question" in tags(slide[0]) and found[-1].title != QUESTIONS:
            found.append(Section(QUESTIONS, 0, []))
        found[-1].slides.append(slide)
    return found


def keep_time(parts: list[Section]) -> None:
    """Give the slides their seconds, which the speaker's view adds up to a pace.

    A prediction has twice the time of another slide of its section.
    """
    for one in filter(lambda one: one.minutes, parts):
        weights = [1 + any("predict" in tags(c) for c in slide) for slide in one.slides]
        for slide, seconds in zip(one.slides, shares(60 * one.minutes, weights)):
            slide[0].metadata.slideshow["data"] = {"timing": seconds}


def notes_first(parts: list[Section]) -> None:
    """Move the note of a section, which says what to ask, to its first slide.

    In a notebook it ends the section, where a lecturer would see it too late.
    """
    for one in parts[1:]:
        first = one.slides[0]
        for slide in one.slides[1:]:
            moved = [cell for cell in slide if _times(cell)]
            slide[:] = [cell for cell in slide if not _times(cell)]
            first += moved


def _times(cell: NotebookNode) -> bool:
    """Whether a note begins with the minutes of its section."""
    return slide_type(cell) == "notes" and bool(form.NOTE.match(cell.source))


def shares(whole: int, weights: list[int]) -> list[int]:
    """Divide seconds by weights, in steps of 5 s, so that they sum to the whole.

    Examples
    --------
    >>> shares(480, [1, 1, 2, 1])
    [95, 95, 195, 95]
    """
    ends = [
        STEP * round(whole * part / sum(weights) / STEP) for part in accumulate(weights)
    ]
    return [end - start for start, end in zip([0, *ends], ends)]


def add_break(parts: list[Section], notebook: NotebookNode, stem: str) -> None:
    """Put a slide where the lecture has lasted 45 minutes, if something follows.

    It ends the last section that ends within them. There is none in a notebook whose
    notes give no minutes, and in a lecture that is short.
    """
    totals = list(accumulate(one.minutes for one in parts))
    within = [total for total in totals if total <= form.LECTURE]
    place = totals.index(within[-1])  # the first of that total: others take no time
    later = [one.title for one in parts[place + 1 :] if one.minutes]
    coming = later[:1] or _after_the_lecture(parts[place + 1 :], notebook, stem)
    if within[-1] >= SHORT and coming:
        comes = "".join(f"<li>{escape(one)}</li>" for one in coming)
        text = f'### Break\n\nWhat comes next:\n\n<ul class="choices">{comes}</ul>'
        last = parts[place].slides[-1][-1]
        parts[place].slides.append([made(last, text, "slide", tag="break")])


def _after_the_lecture(
    rest: list[Section], notebook: NotebookNode, stem: str
) -> list[str]:
    """Name what a lesson goes on with: questions, exercises, its case."""
    rows = datasets.rows("chapters.csv")
    number = next((row["number"] for row in rows if row["notebook"] == stem), "")
    used = {tag for cell in notebook.cells for tag in tags(cell)}
    return [
        *(one.title for one in rest if one.title == QUESTIONS),
        *(["the exercises, at your own pace"] if "exercise" in used else []),
        *(row["title"] for row in rows if row["number"] == f"{number}c"),
    ]


# --- Quick questions, one a slide; students get no answers, lecturers do ---


def questions(cell: NotebookNode, key: bool) -> list[NotebookNode]:
    """Return the slides that a cell of quick questions becomes, else nothing.

    A lesson asks them in a cell tagged ``predict`` that slides skip, each with a
    printed line and its choices. With `key` the answers go with the questions.
    """
    if "predict" not in tags(cell) or slide_type(cell) != "skip":
        return []
    found, printed = [], ""
    for output in cell.get("outputs", []):
        if output.output_type == "stream":
            printed = output.text.strip()
            continue
        soup = BeautifulSoup(output.get("data", {}).get("text/html", ""), "html.parser")
        folded = soup.select(".pgm-predict details")
        if printed and folded:
            choices, answer = [], ""
            for letter, one in zip("ABCDE", folded):
                choice, said = (part.get_text() for part in one(["summary", "p"]))
                choices.append(f"<li>{escape(choice)}</li>")
                mark, _, sentence = said.partition(" ")
                if mark == "✓":
                    answer = f"> **✓ {letter}.** {escape(sentence)}"
            listed = "\n".join(choices)
            asked = f'<ol class="choices" type="A">\n{listed}\n</ol>'
            found.append((f"### {escape(printed)}\n\n{asked}", "subslide"))
            if answer:
                found.append((answer, "fragment"))
        printed = ""
    cells = [
        made(cell, text, kind, number, tag="question")
        for number, (text, kind) in enumerate(found)
    ]
    for asked, answer in pairwise(cells):
        if slide_type(answer) == "fragment":
            asked.metadata.slideshow["data"] = {"answer": len(answer.source)}
    return [one for one in cells if key or slide_type(one) != "fragment"]


# --- The ledger's table: one to three verdicts, large, each on a card ---


def as_cards(slide: list[NotebookNode]) -> list[NotebookNode]:
    """Return a slide with its table of verdicts as cards, three a slide.

    Up to six become two slides; of more the first three are shown, and their number. A
    card has the first sentence of what we get, and the note of the slide has the rest.
    """
    for cell in slide:
        for output in cell.get("outputs", []):
            html = output.get("data", {}).get("text/html", "")
            caption, rows = _table(html) if "verdict" in html else ("", [])
            if rows:
                return _with_cards(slide, cell, output, caption, rows)
    return slide


def _table(html: str) -> tuple[str, list[Row]]:
    """Return caption and rows of the ledger's table, no rows of another table."""
    soup = BeautifulSoup(html, "html.parser")
    if [th.get_text() for th in soup.select("thead th")][:4] != LEDGER:
        return "", []
    rows = [
        [part.get_text() for part in line(["th", "td"])][:4]
        for line in soup.select("tbody tr")
    ]
    return soup.caption.get_text() if soup.caption else "", rows


def _with_cards(
    slide: list[NotebookNode],
    cell: NotebookNode,
    output: NotebookNode,
    caption: str,
    rows: list[Row],
) -> list[NotebookNode]:
    shown = rows if len(rows) <= 2 * CARDS else rows[:CARDS]
    if len(shown) < len(rows):
        caption = f"{caption}; {len(rows) - len(shown)} more are in the notebook"
    first, second = shown[:CARDS], shown[CARDS:]
    # A copy before the first cards are put in: it will hold the second.
    more = copy.deepcopy(cell)
    output.data = {"text/html": cards(first, caption)}
    # 0 is the heading that a slide may have for itself, see `titled`.
    result = [*slide, made(cell, _in_full(first), "notes", 1)]
    if second:
        heading = slide[0].source.partition("\n")[0].lstrip("# ") or "Verdicts"
        more.id, more.metadata.slideshow = f"{cell.id}{MADE}cards", {}
        more.outputs = [copy.deepcopy(output)]
        more.outputs[0].data = {"text/html": cards(second, caption)}
        above = made(cell, f"### {heading}, continued", "subslide", 2)
        result += [above, more, made(cell, _in_full(second), "notes", 3)]
    return result


def cards(rows: list[Row], caption: str) -> str:
    """Write verdicts in HTML, each with its word and mark, and what it is about."""
    written = [
        f'<div class="verdict {verdict.replace(" ", "-")}">'
        '<p class="word">'
        f'<span aria-hidden="true">{MARKS[verdict]}</span> {verdict}</p>'
        f'<p class="place">{escape(place)}</p>'
        f"<p><strong>Printed:</strong> {escape(printed)}</p>"
        f"<p><strong>We get:</strong> {escape(SENTENCE.split(obtained)[0])}</p></div>"
        for place, printed, obtained, verdict in rows
    ]
    return (
        f'<div class="verdicts">{"".join(written)}</div>'
        f'<p class="of-verdicts">{escape(caption)}</p>'
    )


def _in_full(rows: list[Row]) -> str:
    """Return the note of verdicts: what the ledger says of each."""
    return "\n\n".join(
        f"**{escape(place)}:** {escape(obtained)}." for place, _, obtained, _ in rows
    )


# --- What a slide may not be ---


def faults(cells: list[NotebookNode]) -> list[str]:
    """Name the slides without a title of their own, and those that answer at once."""
    found = []
    for number, slide in enumerate(divided(cells), start=1):
        heading = HEADING.search(slide[0].source)
        name = repr(heading[0].lstrip("# ")) if heading else slide[0].id
        shown = [cell for cell in slide if slide_type(cell) != "notes"]
        for said in [*_heading(shown), *_answers(shown)]:
            found.append(f"slide {number} ({name}): {said}")
    return found


def _heading(slide: list[NotebookNode]) -> Iterator[str]:
    """Say if a slide does not begin with its only heading."""
    texts = [c for c in slide if c.cell_type == "markdown"]
    headings = [h for c in texts for h in HEADING.findall(FENCED.sub("", c.source))]
    if slide[0] not in texts or not HEADING.match(slide[0].source.lstrip()):
        yield "has no heading; give its first cell one, or slideshow.title in metadata"
    elif len(headings) > 1:
        yield f"has {len(headings)} headings, the second {headings[1]!r}"


def _answers(slide: list[NotebookNode]) -> Iterator[str]:
    """Say what answers a question of the same slide at once.

    What follows a question waits: as a fragment, folded, or behind the choices of a
    prediction. A cell that shows nothing need not.
    """
    asked, waits = "", False
    for cell in slide:
        folded = cell.source.lstrip().startswith("<details>")
        if "predict" in tags(cell) or slide_type(cell) == "fragment":
            waits = True
        unseen = "hide-input" in tags(cell) and not cell.outputs
        if asked and not (waits or folded or unseen):
            first = cell.source.strip().partition("\n")[0]
            yield f"shows {first[:50]!r} at once with the question {asked[:50]!r}"
            asked = ""
        if cell.cell_type == "markdown" and not folded and _asks(cell.source):
            asked, waits = " ".join(_asks(cell.source).split()), False


def _asks(text: str) -> str:
    """Return the question that a text poses: a prediction, or its last sentence."""
    text = HEADING.sub("", text).strip()
    predict = text.find("**Predict")
    if predict >= 0:
        return text[predict:]
    last = re.split(r"(?<=[.!?:]) |\n\n", text.rstrip("*_ "))[-1]
    return last if last.endswith("?") else ""
