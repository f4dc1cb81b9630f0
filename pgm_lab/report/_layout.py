"""The sections of a report, laid out as plain text or as one HTML page."""

import re
import textwrap
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import jinja2

from pgm_lab.report._typeset import typesetter

WIDTH = 88
NUMBER = re.compile(r"[-+<]?\d+(\.\d+)?(e[-+]\d+)?")
TALL = 25  # rows of a table that is scrolled in a frame of its own
LONG = 24  # characters in a cell that may be broken into lines
LONGEST = 8  # names in a list before "and 12 more"
NUMBERS = "no one two three four five six seven eight nine ten eleven twelve".split()


class Finding(NamedTuple):
    """Something the reader should know before the numbers are used."""

    title: str
    words: str


class Table(NamedTuple):
    """Cells as they are shown; the first column names the rows."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


class Section(NamedTuple):
    """A part of the report."""

    title: str
    paragraphs: Sequence[str] = ()
    findings: Sequence[Finding] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[str] = ()  # names, which `as_html` gives to `pictures`


def count(number: int, noun: str) -> str:
    """Return "no ray", "one ray", "450 rays"."""
    word = NUMBERS[number] if number <= 1 else f"{number}"
    plural = "es" if noun.endswith("ch") else "s"
    return f"{word} {noun}{plural if number > 1 else ''}"


def listed(words: Iterable[object]) -> str:
    """Join words with commas, and count those beyond the first few."""
    names = [str(word) for word in words]
    if len(names) > LONGEST:
        return f"{', '.join(names[:LONGEST])} and {len(names) - LONGEST} more"
    *before, last = names
    return f"{', '.join(before)} and {last}" if before else last


def as_text(title: str, sections: Sequence[Section]) -> str:
    """Lay out a report in lines of at most 88 characters, but for wide tables."""
    parts = [title, "=" * len(title), ""]
    for number, section in enumerate(sections):
        if number:
            heading = f"{number}  {section.title}"
            parts += ["", heading, "-" * len(heading), ""]
        parts += ["\n\n".join(_blocks(section)), ""]
    return "\n".join(parts)


def _blocks(section: Section) -> list[str]:
    wrap = textwrap.TextWrapper(WIDTH, break_long_words=False)
    items = textwrap.TextWrapper(
        WIDTH, initial_indent="- ", subsequent_indent="  ", break_long_words=False
    )
    return [
        *map(wrap.fill, section.paragraphs),
        *(items.fill(f"{one.title}: {one.words}") for one in section.findings),
        *map(_text_table, section.tables),
    ]


def _text_table(table: Table) -> str:
    """Lay out a table: words to the left, numbers to the right."""
    columns = list(zip(table.header, *table.rows))
    widths = [max(map(len, column)) for column in columns]
    left = [not is_number(column[1:]) for column in columns]
    lines = [textwrap.fill(table.caption, WIDTH), ""]
    for row in (table.header, *table.rows):
        cells = (
            cell.ljust(width) if words else cell.rjust(width)
            for cell, width, words in zip(row, widths, left)
        )
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def is_number(cells: Sequence[str]) -> bool:
    """Whether a column holds numbers, but for "-" and "held"."""
    return all(cell in ("-", "held") or NUMBER.fullmatch(cell) for cell in cells)


def as_html(
    title: str,
    sections: Sequence[Section],
    pictures: Callable[[str], list[tuple[str, str]]],
    names: Iterable[object],
) -> str:
    """Lay out a report as a page that needs no other file.

    `pictures` returns the figures of a name, PNGs in base64, each with what it shows in
    words; `names` are never typeset.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pgm_lab.report"),  # the folder templates
        autoescape=True,
        trim_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["typeset"] = typesetter(names)
    return environment.get_template("page.html.j2").render(
        title=title,
        sections=sections,
        pictures=pictures,
        left=lambda table: [not is_number(cells) for cells in zip(*table.rows)],
        tall=TALL,
        long=LONG,
    )
