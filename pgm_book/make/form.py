"""Count what a chapter asks of its reader, and name what is too much or missing.

`python -m pgm_book.make.form` prints the counts of every notebook, and what is wrong
with those that `data/chapters.csv` calls a lesson or a case;
`python -m pgm_book.make.form 02` judges the named one as a lesson, whatever it
is yet. The counts are those of a student's copy, its derivations excepted. The choices
of a prediction and their sentences are not among the words; tests/make/test_form.py
keeps them short.
"""

import csv
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from pgm_book.make.environment import ROOT
from pgm_book.make.errors import PublishError
from pgm_book.make.student import name, slide_type, student_copy, tags


@dataclass(frozen=True)
class Limits:
    """The most that a notebook may ask for."""

    cells: int
    words: int
    minutes: int


LIMITS = {"lesson": Limits(60, 2200, 60), "case": Limits(80, 3000, 45)}
FOLDED = 0.1  # of the lines of code
SHOWN_LINES = 15  # of a cell that is read; what the reader writes may be longer
WORDS_A_MINUTE = 200  # nobody reads a textbook faster
TASK = 15  # minutes of the hour without a scaffold
LECTURE = 45  # minutes, the sum of those that the lecturer's notes begin with

SECTION = re.compile(r"^## (.*)$", re.MULTILINE)
MINUTES = re.compile(r" · (\d+) min$")
NOTE = re.compile(r"(\d+) minutes?\b")  # at the beginning of a note
TOTAL = re.compile(r"About \*\*(\d+) minutes\*\*")
DETAILS = re.compile(
    r"<details>\s*<summary>[^<]+</summary>\n\n.*\n\n</details>", re.DOTALL
)
HEAD = "the head"


@dataclass(frozen=True)
class Section:
    """The cells under one heading; the head before the first heading with minutes."""

    title: str
    minutes: int | None
    cells: list[NotebookNode]

    @property
    def words(self) -> int:
        """Words to be read, without those of the derivations, which are optional."""
        read = [c for c in self.cells if "derive" not in tags(c)]
        return sum(words(c.source) for c in read if c.cell_type == "markdown")


def sections(notebook: NotebookNode) -> list[Section]:
    """Return the student's copy by sections; the head ends where minutes begin."""
    found = [Section(HEAD, None, [])]
    for cell in student_copy(notebook).cells:
        heading = SECTION.search(cell.source) if cell.cell_type == "markdown" else None
        minutes = MINUTES.search(heading[1]) if heading else None
        if heading and (minutes or len(found) > 1):
            title = MINUTES.sub("", heading[1])
            found.append(Section(title, int(minutes[1]) if minutes else None, []))
        found[-1].cells.append(cell)
    return found


def lecture(notebook: NotebookNode) -> dict[str, int | None]:
    """Return the minutes that the lecturer's notes give each section, None for none."""
    found: dict[str, int | None] = {}
    place = HEAD
    for cell in notebook.cells:
        heading = SECTION.search(cell.source) if cell.cell_type == "markdown" else None
        if heading and MINUTES.search(heading[1]):
            place = MINUTES.sub("", heading[1])
            found[place] = None
        minutes = NOTE.match(cell.source) if slide_type(cell) == "notes" else None
        if minutes and place in found:  # not in the head, whose note is on the whole
            found[place] = (found[place] or 0) + int(minutes[1])
    return found


def words(text: str) -> int:
    """Count the words of a text; a formula counts as one."""
    text = re.sub(r"\$\$.*?\$\$|\$[^$]*\$", " formula ", text, flags=re.DOTALL)
    text = re.sub(r"<[^>]*>|\]\([^)]*\)", " ", text)
    return len(re.findall(r"[^\W_][\w'’.-]*", text))


def lines(cell: NotebookNode) -> int:
    """Count the lines of code of a cell, without empty ones."""
    return sum(bool(line.strip()) for line in cell.source.splitlines())


def is_folded(cell: NotebookNode) -> bool:
    """Whether a cell's code is out of sight."""
    hidden = cell.metadata.get("jupyter", {}).get("source_hidden", False)
    return hidden or "hide-input" in tags(cell)


def code(parts: list[Section]) -> list[NotebookNode]:
    """Return the code cells of all sections."""
    return [cell for one in parts for cell in one.cells if cell.cell_type == "code"]


def counts(notebook: NotebookNode) -> dict[str, int]:
    """Return cells, words, lines, folded lines, minutes and minutes of a lecture."""
    parts = sections(notebook)
    every = code(parts)
    return {
        "cells": sum(len(one.cells) for one in parts),
        "words": sum(one.words for one in parts),
        "lines": sum(map(lines, every)),
        "folded": sum(lines(cell) for cell in every if is_folded(cell)),
        "minutes": sum(one.minutes or 0 for one in parts),
        "lecture": sum(minutes or 0 for minutes in lecture(notebook).values()),
    }


def problems(notebook: NotebookNode, kind: str) -> list[str]:
    """Name what is too much in a lesson or a case, and what it lacks."""
    parts = sections(notebook)
    return [
        *too_much(parts, counts(notebook), LIMITS[kind]),
        *minutes_problems(parts),
        *code_problems(notebook, code(parts)),
        *folded_texts(parts),
        *claims_problems(notebook),
        *(only_lesson_problems(notebook, parts) if kind == "lesson" else []),
    ]


def too_much(parts: list[Section], count: dict, limits: Limits) -> list[str]:
    """Say what goes over its limit, and which section has most of it."""
    found = []
    sizes = {
        "cells": [len(one.cells) for one in parts],
        "words": [one.words for one in parts],
        "minutes": [one.minutes or 0 for one in parts],
    }
    for what, most in vars(limits).items():
        if count[what] > most:
            size, title = max(zip(sizes[what], (one.title for one in parts)))
            found.append(
                f"{count[what]} {what}, {count[what] - most} too many; most are in"
                f" {title!r}: {size}"
            )
    if count["folded"] > FOLDED * count["lines"]:
        folded = [cell for cell in code(parts) if is_folded(cell)]
        largest_cell = max(folded, key=lines)
        found.append(
            f"{count['folded']} of {count['lines']} lines of code are folded, more than"
            f" a tenth; most in {name(largest_cell)}: {lines(largest_cell)}"
        )
    return found


def minutes_problems(parts: list[Section]) -> list[str]:
    """Say which section gives no minutes or too few, and what else the head lacks."""
    found = []
    for one in parts[1:]:
        if one.minutes is None:
            found.append(f"section {one.title!r} ends without its minutes: · 5 min")
        elif one.words > WORDS_A_MINUTE * one.minutes:
            found.append(
                f"section {one.title!r} has {one.words} words for {one.minutes} min:"
                f" more than {WORDS_A_MINUTE} a minute"
            )
    text = "\n".join(cell.source for cell in parts[0].cells)
    total = TOTAL.search(text)
    whole = sum(one.minutes or 0 for one in parts)
    if not total or int(total[1]) != whole:
        said = f"{total[1]} minutes" if total else "no minutes: About **60 minutes**"
        found.append(f"the head says {said}; the sections give {whole}")
    if "You need" not in text:
        found.append("the head does not say what it needs: You need ...")
    return found


def code_problems(notebook: NotebookNode, every: list[NotebookNode]) -> list[str]:
    """Say which cells hide too much, are too long to be read, or assert claims."""
    outputs = {cell.get("id"): cell.get("outputs") for cell in notebook.cells}
    found = []
    for cell in every:
        if is_folded(cell) and not outputs[cell.get("id")]:
            found.append(f"{name(cell)} is folded and shows nothing: show its code")
        long = lines(cell) > SHOWN_LINES and not is_folded(cell)
        if long and "exercise" not in tags(cell):
            found.append(f"{name(cell)} has {lines(cell)} lines, over {SHOWN_LINES}")
        if re.search(r"^\s*assert\b", cell.source, re.MULTILINE):
            found.append(f"{name(cell)} asserts: put it into the cell of claims")
        if ("checks.predict(" in cell.source) != ("predict" in tags(cell)):
            found.append(f"{name(cell)}: checks.predict goes with the tag predict")
        if "predict" in tags(cell) and "plot.show(" in cell.source:
            found.append(
                f"{name(cell)} spells out its alt text, which gives the answer: let a"
                " function of pgm_lab.plot show the figure"
            )
    for cell, after in zip(every, [*every[1:], None]):
        if "exercise" in tags(cell) and (after is None or "check" not in tags(after)):
            found.append(f"{name(cell)} is an exercise, and no check follows it")
    return found


def folded_texts(parts: list[Section]) -> list[str]:
    """Say which "Derive it" or "Why?" is not one folded text."""
    return [
        f"{name(cell)} must be one <details> with a <summary>, and empty lines inside"
        for one in parts
        for cell in one.cells
        if {"derive", "why"} & set(tags(cell))
        and not DETAILS.fullmatch(cell.source.strip())
    ]


def claims_problems(notebook: NotebookNode) -> list[str]:
    """Say if the claims are not in one cell at the end."""
    places = [k for k, cell in enumerate(notebook.cells) if "claims" in tags(cell)]
    if places == [len(notebook.cells) - 1]:
        return []
    return [f"{len(places)} cells of claims; there must be one, at the very end"]


def only_lesson_problems(notebook: NotebookNode, parts: list[Section]) -> list[str]:
    """Say which part of the form a lesson lacks, and whether it makes a lecture."""
    used = {tag for one in parts for cell in one.cells for tag in tags(cell)}
    wanted = ("predict", "derive", "why", "exercise", "check")
    found = [f"no cell is tagged {tag}" for tag in wanted if tag not in used]
    if not any("checks.keep(" in cell.source for cell in code(parts)):
        found.append("no check keeps the reader's function: checks.keep(function)")
    found += task_problems(parts)
    given = lecture(notebook)
    found += [
        f"section {place!r} has no note that begins with its minutes in a lecture, 0 if"
        " it is left out: 5 minutes."
        for place, minutes in given.items()
        if minutes is None
    ]
    whole = sum(minutes or 0 for minutes in given.values())
    if whole > LECTURE:
        longest = max(given, key=lambda place: given[place] or 0)
        found.append(
            f"the notes give a lecture of {whole} minutes, {whole - LECTURE} too many;"
            f" most are in {longest!r}: {given[longest]}"
        )
    return found


def task_problems(parts: list[Section]) -> list[str]:
    """Say what the reader's own task lacks: a section of its own, an empty cell."""
    found = []
    minutes = [one.minutes for one in parts if one.title == "Your task"]
    if minutes != [TASK]:
        found.append(f"there must be one section: ## Your task · {TASK} min")
    tasks = [cell for cell in code(parts) if "task" in tags(cell)]
    if len(tasks) != 1 or tasks[0].source.strip():
        found.append("one cell tagged task must hold the solution, and nothing else")
    return found


def choose(folder: Path, names: list[str]) -> list[Path]:
    """Return the notebooks of these names, or all; a name may be the number only."""
    chapters = sorted(Path(folder).glob("[0-9A-Z]*.ipynb"))
    if not chapters:
        raise PublishError(f"there is no notebook in {folder}.")
    chosen = []
    for wanted in names:
        stem = Path(wanted).name.removesuffix(".ipynb")
        number = stem.zfill(2)  # 2 as well as 02
        matches = [p for p in chapters if number in (p.stem, p.stem.split("_")[0])]
        if not matches:
            known = ", ".join(path.stem for path in chapters)
            raise PublishError(f"no notebook is called {wanted!r}; there are: {known}.")
        chosen += matches
    return chosen or chapters


def form_of(notebook: Path) -> str:
    """Return "lesson" or "case" as data/chapters.csv says, nothing where it is neither.

    Of a notebook elsewhere the table beside its folder counts.
    """
    table = notebook.resolve().parents[1] / "data" / "chapters.csv"
    if not table.is_file():
        return ""
    with table.open(encoding="utf-8", newline="") as lines:
        forms = {row["notebook"]: row["form"] for row in csv.DictReader(lines)}
    form = forms.get(notebook.stem, "")
    return form if form in LIMITS else ""


def kinds() -> dict[str, str]:
    """Return which notebooks of the project are lessons and which cases, by name."""
    paths = sorted((ROOT / "notebooks").glob("*.ipynb"))
    return {path.stem: form_of(path) for path in paths if form_of(path)}


def judge(found: dict[Path, list[str]], said: str, advice: str = "") -> None:
    """Raise a PublishError with all findings of lessons and cases; print the others."""
    refused = []
    for path, findings in found.items():
        lines = [f"{path.name}, {finding}" for finding in findings]
        if form_of(path):
            refused += lines
        else:
            print(
                "".join(f"publish: {line}\n" for line in lines), end="", file=sys.stderr
            )
    if refused:
        text = "\n  ".join([said, *refused])
        raise PublishError(f"{text}\n{advice}" if advice else text)


def main(names: list[str]) -> int:
    """Print the counts; return 1 if a notebook of this form has a problem."""
    failed = False
    print(f"{'':40} cells words lines folded minutes lecture")
    for path in choose(ROOT / "notebooks", names):
        notebook = nbformat.read(path, as_version=4)
        count = counts(notebook)
        numbers = "".join(
            f"{n:{w}}" for n, w in zip(count.values(), (6, 6, 6, 7, 8, 8))
        )
        print(f"{path.stem:40}{numbers}")
        if kind := form_of(path) or ("lesson" if names else ""):
            found = problems(notebook, kind)
            print("".join(f"  {finding}\n" for finding in found), end="")
            failed = failed or bool(found)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
