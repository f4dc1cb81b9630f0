"""Can the back row read the slides? Measure decks in the installed browser, and judge.

A lesson or a case in ``data/chapters.csv`` must keep the limits of `sizes`; of the
others the list says what does not.
"""

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from pgm_book.make.errors import PublishError
from pgm_book.make.forms import form_of
from pgm_book.make.sizes import SIZE, Row, measure, problems, summary, table


class Meter:
    """A browser in which decks are measured, one after another."""

    def __init__(self, stack: ExitStack):
        try:
            from pgm_book.make.browser import offline_context, open_browser
        except ModuleNotFoundError as error:
            raise PublishError(
                f"the Python package {error.name} is missing. "
                'Install what publishing needs with: pip install -e ".[publish]"'
            ) from error
        browser = stack.enter_context(open_browser())
        self._context = stack.enter_context(offline_context(browser, viewport=SIZE))

    def rows(self, deck: Path) -> list[Row]:
        """Open a deck from its file and measure it."""
        with self._context.new_page() as page:
            page.goto(deck.resolve().as_uri())
            page.wait_for_function("document.documentElement.dataset.ready")
            return measure(page)


def check(folder: Path, notebooks: list[Path]) -> None:
    """Measure the decks of these notebooks; refuse lessons and cases that fail.

    What the others do not keep is printed to stderr, and so is that nothing was
    measured where there is no browser.

    Raises
    ------
    PublishError
        If a lesson or a case has a problem; it names each slide.
    """
    refused = []
    with ExitStack() as stack:
        try:
            meter = Meter(stack)
        except PublishError as error:
            _say(f"the sizes on the slides were not measured: {error}")
            return
        for notebook in notebooks:
            found = problems(meter.rows(folder / f"{notebook.stem}.html"))
            if found and form_of(notebook):
                refused += [f"{notebook.name}, {row}" for row in found]
            else:
                for row in found:
                    _say(f"{notebook.name}, {row}")
    if refused:
        said = "the slides are written, but a hall cannot read all of them:"
        raise PublishError(
            "\n  ".join([said, *refused])
            + "\nMake the writing in a figure larger, or leave it more of the slide; "
            "divide what is too much for one slide."
        )


def report(notebooks: list[Path]) -> Iterator[str]:
    """Yield the table of each notebook's slides, and what was counted in all."""
    from tempfile import TemporaryDirectory

    from pgm_book.make.page import slides_page

    every = []
    with ExitStack() as stack:
        meter = Meter(stack)
        folder = Path(stack.enter_context(TemporaryDirectory()))
        for notebook in notebooks:
            deck = folder / f"{notebook.stem}.html"
            deck.write_text(slides_page(notebook), encoding="utf-8")
            rows = meter.rows(deck)
            every += rows
            yield from [f"# {notebook.stem}", *table(rows), ""]
    yield from summary(every)


def _say(text: str) -> None:
    print(f"publish: {text}", file=sys.stderr)
