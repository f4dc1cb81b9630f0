"""The tables of TEACHING.md: the weeks of a course, and outcomes in Indonesian form.

``python -m pgm_book.make.teaching`` renews them. What a chapter is called and takes
stands in data/chapters.csv, the minutes of a lecture in the notes of its notebook; what
a course adds, in data/course_weeks.csv and data/course_short.csv.
"""

import sys
from dataclasses import dataclass
from itertools import groupby

import nbformat

from pgm_book.make import form
from pgm_book.make.chapters import ROOT, replaced
from pgm_lab import datasets

TEACHING = ROOT / "TEACHING.md"
TWO_HOURS = 120  # minutes
EXAMS = {
    8: ("UTS: ujian tengah semester", "midterm examination", 20),
    16: ("UAS: ujian akhir semester", "final examination", 20),
}


@dataclass(frozen=True)
class Chapter:
    """A notebook, the minutes of its deck and those of who reads it alone."""

    number: str
    title: str
    notebook: str
    form: str
    lecture: int
    minutes: int


@dataclass(frozen=True)
class Week:
    """What a row of data/course_weeks.csv says, with its chapters."""

    row: dict[str, str]
    chapters: list[Chapter]

    @property
    def semester(self) -> int:
        """The week of the semester: the midterm examination takes one."""
        week = int(self.row["week"])
        return week + (week >= min(EXAMS))


def chapters() -> dict[str, Chapter]:
    """Return the chapters by their numbers."""
    found = {}
    for row in datasets.rows("chapters.csv"):
        path = ROOT / "notebooks" / f"{row['notebook']}.ipynb"
        notes = form.lecture(nbformat.read(path, as_version=4))
        found[row["number"]] = Chapter(
            row["number"],
            row["title"],
            row["notebook"],
            row["form"],
            sum(minutes or 0 for minutes in notes.values()),
            int(row["minutes"]),
        )
    return found


def weeks() -> list[Week]:
    """Return the fourteen weeks."""
    known = chapters()
    rows = datasets.rows("course_weeks.csv")
    return [Week(row, [known[n] for n in row["chapters"].split()]) for row in rows]


def plan() -> str:
    """Return the fourteen weeks as a table in Markdown."""
    lines = [
        "| week | outcome: the student | notebook, and its minutes | deck, and its"
        " minutes | task | for questions and a break | reading |",
        "|---|---|---|---|---|---|---|",
    ]
    for week in weeks():
        notebooks = [
            f"[{c.number}](notebooks/{c.notebook}.ipynb) {c.title}, {c.minutes}"
            for c in week.chapters
        ]
        decks = [f"`{c.notebook}`, {c.lecture}" for c in week.chapters]
        tasks = [f"task {c.number}" for c in week.chapters if c.form == "lesson"]
        outcome, reading = week.row["outcome"], week.row["reading"]
        cells = [
            week.row["week"],
            outcome[0].lower() + outcome[1:],
            "<br>".join(notebooks),
            "<br>".join(decks),
            ", ".join(tasks) or "none; a page is handed in",
            str(TWO_HOURS - sum(c.lecture for c in week.chapters)),
            reading,
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def short() -> str:
    """Return the shorter courses as tables in Markdown."""
    known = chapters()
    tables = []
    rows = datasets.rows("course_short.csv")
    for course, units in groupby(rows, lambda row: row["course"]):
        lines = [
            f"| {course} | chapters | decks, minutes | for exercises, of all |",
            "|---|---|---|---|",
        ]
        for row in units:
            own = [known[number] for number in row["chapters"].split()]
            named = ", ".join(f"{c.number} {c.title}" for c in own)
            lecture, whole = sum(c.lecture for c in own), int(row["minutes"])
            rest = f"{whole - lecture} of {whole}"
            lines.append(f"| {row['unit']} | {named} | {lecture} | {rest} |")
        tables.append("\n".join(lines))
    return "\n\n".join(tables)


def rps() -> str:
    """Return outcomes, indicators and weights as Indonesian programmes write them."""
    lines = [
        "| minggu / week | CPMK | sub-CPMK | indikator / indicator"
        " | bobot / weight, % |",
        "|---|---|---|---|---|",
    ]
    taught = {week.semester: week.row for week in weeks()}
    for number in sorted(taught | EXAMS):
        if number in EXAMS:
            name, english, weight = EXAMS[number]
            lines.append(f"| {number} |  | {name} |  *{english}* | {weight} |")
            continue
        row = taught[number]
        outcome = f"{row['outcome_id']}<br>*{row['outcome']}*"
        indicator = f"{row['indicator_id']}<br>*{row['indicator']}*"
        lines.append(
            f"| {number} | {row['cpmk']} | {outcome} | {indicator} | {row['weight']} |"
        )
    return "\n".join(lines)


TABLES = {"the weeks": plan, "the short courses": short, "RPS": rps}


def renewed(text: str) -> str:
    """Return the text of TEACHING.md with its tables as the data have them now."""
    for name, table in TABLES.items():
        text = replaced(text, f"<!-- {name} -->", f"<!-- end of {name} -->", table())
    return text


def main() -> int:
    """Renew TEACHING.md."""
    text = renewed(TEACHING.read_text(encoding="utf-8"))
    TEACHING.write_text(text, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
