"""The pace of a lecture, from the minutes that the lecturer's notes begin with."""

from dataclasses import dataclass
from html import escape
from itertools import accumulate

from nbformat import NotebookNode

from pgm_book.make import deck, form
from pgm_book.make.student import slide_type, tags
from pgm_lab import datasets

STEP = 5  # seconds: nobody keeps time more exactly
SHORT = 30  # minutes; who has listened for less needs no break
QUESTIONS = "the quick questions"


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
    for slide in deck.slides(cells):
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


def repeat_notes(parts: list[Section]) -> None:
    """Put the note of a section, which says what to ask, on each of its slides.

    In a notebook it ends the section, where a lecturer would see it too late.
    """
    for one in parts[1:]:
        every = [cell for slide in one.slides for cell in slide]
        notes = [cell for cell in every if slide_type(cell) == "notes"]
        for note in filter(lambda note: form.NOTE.match(note.source), notes):
            others = (slide for slide in one.slides if note not in slide)
            for number, slide in enumerate(others, start=1):  # 0 is the break
                slide.append(deck.made(note, note.source, "notes", number))


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
        parts[place].slides.append([deck.made(last, text, "slide", tag="break")])


def _after_the_lecture(
    rest: list[Section], notebook: NotebookNode, stem: str
) -> list[str]:
    """Name what a lesson goes on with: questions, exercises, its case."""
    rows = datasets.rows("chapters.csv")
    number = next((row["number"] for row in rows if row["notebook"] == stem), "")
    used = {tag for cell in notebook.cells for tag in tags(cell)}
    return [
        *(one.title for one in rest if one.title == QUESTIONS),
        *(["the exercises, each at its own pace"] if "exercise" in used else []),
        *(row["title"] for row in rows if row["number"] == f"{number}c"),
    ]
