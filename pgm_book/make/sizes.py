"""Can the back row read the slides? Measure decks in the installed browser.

A slide is 1280 x 720 px, which reveal.js scales to the screen. A row of `measure` is
one thing on one slide: the smallest writing in a figure, a size of text, an overflow.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from pgm_book.make.errors import missing

if TYPE_CHECKING:
    from playwright.sync_api import Page, ViewportSize

SIZE: ViewportSize = {"width": 1280, "height": 720}
# px of 720; of text and code it is the size of the font, as the browser computes it.
AT_LEAST = {"figure label": 18.0, "caption": 20.0, "text": 24.0, "code": 24.0}
# An enlargement is the factor by which a picture exceeds its own pixels at 1080 lines.
AT_MOST = {
    "lines of code": 20.0,
    "enlargement": 1.0,
    "overflow": 0.0,
    "no heading": 0.0,
}
ROUNDING = 0.05
SCRIPT = Path(__file__).with_suffix(".js")

# Every fragment is shown; a slide is measured while it is the present one.
_SLIDES = (
    "() => { Reveal.configure({ fragments: false }); return Reveal.getTotalSlides() }"
)
_SLIDE = """([index, measure]) => {
    const slide = Reveal.getSlides()[index];
    const { h, v } = Reveal.getIndices(slide);
    Reveal.slide(h, v);
    return eval(measure)(slide);
}"""


@dataclass(frozen=True)
class Row:
    """One thing on one slide, and what it may be at the least or at the most."""

    slide: int  # from 1
    title: str
    kind: str  # one of AT_LEAST or AT_MOST
    what: str  # the alternative text of a figure, or the first words of a text
    value: float | None  # None for a figure that does not say how large its labels are

    @property
    def limit(self) -> float:
        """The least or the most that it may be."""
        return (AT_LEAST | AT_MOST)[self.kind]

    @property
    def good(self) -> bool:
        """Whether it keeps the limit; an unknown size does not."""
        if self.value is None:
            return False
        if self.kind in AT_LEAST:
            return self.value >= self.limit - ROUNDING
        return self.value <= self.limit + (ROUNDING if self.kind == "overflow" else 0)

    def __str__(self) -> str:
        """Say in a sentence what was measured, and where."""
        place = f"slide {self.slide} ({self.title!r})"
        what = f" {self.what!r}" if self.what else ""
        if self.value is None:
            return (
                f"{place}: it is not known how large the labels of the figure{what} are"
            )
        high = f"{self.value:.1f} px high, less than {self.limit:.0f}"
        said = {
            "figure label": f"the labels of the figure{what} are {high}",
            "caption": f"the caption{what} is {high}",
            "text": f"the text{what} is {high}",
            "code": f"the code{what} is {high}",
            "lines of code": f"{self.value:.0f} lines of code, more than "
            f"{self.limit:.0f}",
            "enlargement": f"at 1080 lines the figure{what} is enlarged "
            f"{self.value:.2f} times beyond its pixels",
            "overflow": f"{self.value:.0f} px stick out of the slide",
            "no heading": f"it begins with{what}, not with a heading",
        }
        return f"{place}: {said[self.kind]}"


def measure(page: Page) -> list[Row]:
    """Go through a deck that is open in the browser; return what is on its slides.

    Every fragment is shown, and every fold. The figures of a prediction are measured
    as they stand beside its choices.
    """
    page.set_viewport_size(SIZE)
    script = SCRIPT.read_text(encoding="utf-8")
    found: dict[tuple, Row] = {}
    for index in range(page.evaluate(_SLIDES)):
        slide = page.evaluate(_SLIDE, [index, script])
        title = " ".join(slide["title"].split())
        for kind, what, value in slide["rows"]:
            what = _short(what)
            row = Row(index + 1, title, kind, what, value)
            same = value if kind in ("caption", "text", "code") else what
            found.setdefault((index, kind, same), row)
    return list(found.values())


def problems(rows: Iterable[Row]) -> list[Row]:
    """Return the rows that do not keep their limits."""
    return [row for row in rows if not row.good]


def table(rows: Iterable[Row]) -> Iterator[str]:
    """Write a line for each thing on the slides; `!` marks what breaks its limit."""
    for row in rows:
        value = "?" if row.value is None else f"{row.value:.1f}"
        mark = " " if row.good else "!"
        yield f"{row.slide:3d} {mark} {row.kind:13} {value:>6}  {row.what or row.title}"


def _short(text: str) -> str:
    """Return the first words of a text."""
    text = " ".join(text.split())
    return text if len(text) <= 50 else text[:50].rsplit(" ", 1)[0] + " …"


def measured(decks: Iterable[Path]) -> Iterator[list[Row]]:
    """Open decks from their files, one after another in one browser; measure them."""
    try:
        from pgm_book.make.browser import offline_context, open_browser
    except ModuleNotFoundError as error:
        raise missing(error.name) from error
    with open_browser() as browser, offline_context(browser, viewport=SIZE) as context:
        for deck in decks:
            with context.new_page() as page:
                page.goto(deck.resolve().as_uri())
                page.wait_for_function("document.documentElement.dataset.ready")
                yield measure(page)


def of_decks(folder: Path, notebooks: list[Path]) -> dict[Path, list[str]]:
    """Return what a hall cannot read of the decks of these notebooks."""
    found = list(measured(folder / f"{notebook.stem}.html" for notebook in notebooks))
    return {
        notebook: [str(row) for row in problems(rows)]
        for notebook, rows in zip(notebooks, found)
    }


def report(notebooks: list[Path]) -> Iterator[str]:
    """Yield the table of each notebook's slides."""
    from pgm_book.make.page import slides_page

    with TemporaryDirectory() as folder:
        decks = [Path(folder, f"{notebook.stem}.html") for notebook in notebooks]
        for notebook, deck in zip(notebooks, decks):
            deck.write_text(slides_page(notebook), encoding="utf-8")
        # The decks come first, so that the browser is closed after the last of them.
        for rows, notebook in zip(measured(decks), notebooks):
            yield from [f"# {notebook.stem}", *table(rows), ""]
