"""The page of a report: a template of sentences, laid out as plain text or as HTML.

A template such as matching.j2 holds a whole report in the order of the page. What it
hands to `section`, `p`, `finding`, `table` and `figure` is collected in a `Page`, which
`as_text` and `as_html` lay out. Python supplies numbers, the templates all sentences.
"""

import re
import sys
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jinja2
import numpy as np
from markupsafe import Markup, escape

from pgm_lab._rounding import plain

WIDTH = 88
NUMBER = re.compile(r"[-+<]?\d+(\.\d+)?(e[-+]\d+)?")
TALL_ROWS = 25  # a longer table is scrolled in a frame of its own
LONG_CELL = 24  # characters; a longer cell may be broken into lines
MAX_LISTED = 8  # names in a list before "and 12 more"
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


@dataclass(frozen=True)
class Section:
    """A part of the report; `figures` are PNGs in base64, each with its alt text."""

    title: str
    paragraphs: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    figures: list[tuple[str, str]] = field(default_factory=list)


class Page:
    """Collects the sections of a report while its template is rendered."""

    def __init__(self, draw: Callable[[str], list] | None = None) -> None:
        self.draw = draw
        self.sections = [Section("")]  # what stands before the first heading

    def section(self, title: str) -> str:
        """Begin a section."""
        self.sections.append(Section(title))
        return ""

    def paragraph(self, caller: Callable[[], str]) -> str:
        """Add a paragraph, unless it is empty."""
        if words := _one_line(caller()):
            self.sections[-1].paragraphs.append(words)
        return ""

    def finding(self, title: str, caller: Callable[[], str]) -> str:
        """Add something that the reader should know first."""
        self.sections[-1].findings.append(Finding(title, _one_line(caller())))
        return ""

    def table(self, one: Table) -> str:
        """Add a table."""
        self.sections[-1].tables.append(one)
        return ""

    def figure(self, name: str, caller: Callable[[dict], str]) -> str:
        """Add the figures of a name; `caller` puts what each shows into words."""
        for picture, shown in self.draw(name) if self.draw else ():
            alt = _one_line(caller(shown))
            self.sections[-1].figures.append((picture, alt))
        return ""


def _one_line(words: str) -> str:
    """Join the lines of a template; blanks within a name stay."""
    return re.sub(r"\s*\n\s*", " ", words.strip())


def count(number: int, noun: str) -> str:
    """Return "no ray", "one ray", "450 rays"."""
    word = NUMBERS[number] if number <= 1 else f"{number}"
    plural = "es" if noun.endswith("ch") else "s"
    return f"{word} {noun}{plural if number > 1 else ''}"


def listed(words: Iterable[object]) -> str:
    """Join words with commas, and count those beyond the first few."""
    names = [str(word) for word in words]
    if len(names) > MAX_LISTED:
        return f"{', '.join(names[:MAX_LISTED])} and {len(names) - MAX_LISTED} more"
    *before, last = names
    return f"{', '.join(before)} and {last}" if before else last


SENTENCES = jinja2.Environment(
    loader=jinja2.PackageLoader("pgm_lab.report"),  # the folder templates
    autoescape=False,  # `typeset` escapes all that is collected
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)
SENTENCES.filters |= {"plain": plain, "listed": listed}
SENTENCES.globals |= {"count": count, "NUMBERS": NUMBERS, "np": np}
HTML = SENTENCES.overlay(autoescape=True)


def sections(
    template: str,
    values: Mapping[str, Any],
    draw: Callable[[str], list] | None = None,
) -> list[Section]:
    """Render a template of sentences; without `draw` it has no figures."""
    page = Page(draw)
    collect = {
        "section": page.section,
        "p": page.paragraph,
        "finding": page.finding,
        "table": page.table,
        "figure": page.figure,
    }
    SENTENCES.get_template(template).render({**values, **collect})
    return page.sections[1:] or page.sections


def constants(module: str) -> dict[str, Any]:
    """Return the constants of a module, which its template states as limits."""
    return {name: x for name, x in vars(sys.modules[module]).items() if name.isupper()}


class Case:
    """What the sentences of a report need to know; each report adds its own.

    `NAME` is that of its templates, which state the constants of its module as limits.
    """

    NAME: str

    @property
    def values(self) -> dict[str, Any]:
        """What both templates are given."""
        return {"case": self} | constants(type(self).__module__)

    @property
    def findings(self) -> list[Finding]:
        """All warnings; none when nothing is wrong."""
        return sections(f"{self.NAME}_findings.j2", self.values)[0].findings

    def sections(self, about: str, short: bool, draw: Any = None) -> list[Section]:
        """Collect the report, the summary first; what is empty is left out."""
        more = {"findings": self.findings, "about": about, "short": short}
        return sections(f"{self.NAME}.j2", self.values | more, draw)


# --- As plain text ---


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
    left = [not _is_number(column[1:]) for column in columns]
    lines = [textwrap.fill(table.caption, WIDTH), ""]
    for row in (table.header, *table.rows):
        cells = (
            cell.ljust(width) if words else cell.rjust(width)
            for cell, width, words in zip(row, widths, left)
        )
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def _is_number(cells: Sequence[str]) -> bool:
    """Whether a column holds numbers, but for "-" and "held"."""
    return all(cell in ("-", "held") or NUMBER.fullmatch(cell) for cell in cells)


# --- As HTML ---


def as_html(title: str, sections: Sequence[Section], names: Iterable[object]) -> str:
    """Lay out a report as one page that needs no other file; `names` stay as written.

    Formulas and numbers are plain in the text: r^3, mm^-2, sigma0, 1.2e-05. Here they
    get Greek letters, real minus signs, sub- and superscripts.
    """
    return HTML.get_template("page.html.j2").render(
        title=title,
        sections=sections,
        typeset=typesetter(names),
        left=lambda table: [not _is_number(cells) for cells in zip(*table.rows)],
        TALL_ROWS=TALL_ROWS,
        LONG_CELL=LONG_CELL,
    )


GREEK = {"sigma": "σ", "omega": "ω", "phi": "φ", "kappa": "κ", "tau": "τ", "rho": "ρ"}
RULES: tuple[tuple[str, Callable[[re.Match], str]], ...] = (
    (r"v'P", lambda found: "v<sup>T</sup>P"),
    (r"\bsqrt\(", lambda found: "√("),
    (r"\bsigma0(?!_)", lambda found: "σ<sub>0</sub>"),
    (r"_(omega|phi|kappa)\b", lambda found: f"<sub>{GREEK[found[1]]}</sub>"),
    (r"\b(sigma|omega|phi|kappa|tau|rho)\b", lambda found: GREEK[found[1]]),
    (
        r"(?<![\w.])([KP][123]|[ab][012]|[xyXYZ]0)(?!\w|\.\w)",
        lambda found: f"{found[1][0]}<sub>{found[1][1]}</sub>",
    ),
    (r"\bRMSE_([xyT])(?!\w|\.\w)", lambda found: f"RMSE<sub>{found[1]}</sub>"),
    (r"(?<=[\w)])\^(-?\d+)", lambda found: f"<sup>{_minus(found[1])}</sup>"),
    (
        r"(?<=\d)e([-+])0*(\d+)\b",
        lambda found: f" × 10<sup>{_minus(found[1].strip('+'))}{found[2]}</sup>",
    ),
    (r"(?<![^ =(|])-(?=[\d.]|[a-z ])(?!-)", lambda found: "−"),
)


def typesetter(names: Iterable[object]) -> Callable[[str], Markup]:
    """Return a function that typesets and escapes text, but for some names in it."""
    formulas = re.compile("|".join(pattern for pattern, _ in RULES))
    odd = sorted({str(name) for name in names if formulas.search(str(name))}, key=len)
    kept = "|".join(map(re.escape, odd[::-1])) or "(?!)"  # the longest comes first
    rules = [(kept, lambda found: escape(found[0])), *RULES]
    one = re.compile("|".join(f"(?P<rule{i}>{p})" for i, (p, _) in enumerate(rules)))

    def typeset(text: str) -> Markup:
        parts, end = [], 0
        for found in one.finditer(text):
            pattern, write = rules[int(str(found.lastgroup).removeprefix("rule"))]
            # Once more, since groups have other numbers in the pattern of all
            own = re.compile(pattern).match(text, found.start())
            assert own
            parts += [escape(text[end : found.start()]), Markup(write(own))]
            end = found.end()
        return Markup("").join([*parts, escape(text[end:])])

    return typeset


def _minus(number: str) -> str:
    return number.replace("-", "−")
