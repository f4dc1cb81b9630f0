"""Predictions: the reader clicks a choice, and only then sees what follows."""

import csv
from html import escape
from pathlib import Path

from pgm_lab.plot.basic import publish_display_data

BOOK = Path(__file__).parents[1]

# What the cell shows after the choices waits until one of them is open, and so does a
# text without heading right below the cell; of several predictions in one cell, each
# waits for the one before. Nothing here needs a kernel. JupyterLab and pages made from
# it name an output .jp-..., our slides and handouts .html; there the place is kept, so
# that a slide need not grow. On paper nothing opens, and so nothing waits. Where styles
# are dropped, as JupyterLab drops them in the stored outputs of a notebook that it does
# not trust, or where an output has other names, all is shown at once, and with it a
# line that says so.
STYLE = """\
.pgm-predict summary { cursor: pointer; }
.pgm-predict details p { margin: 0.3em 0 0.3em 1.1em; }
.jp-OutputArea .pgm-shown, .cell .pgm-shown { display: none; }
@media screen {
  .jp-OutputArea-child:has(.pgm-predict):not(:has(.pgm-predict [open]))
    ~ .jp-OutputArea-child,
  .jp-Cell:has(.pgm-predict):not(:has(.pgm-predict [open]))
    + .jp-MarkdownCell:not(:has(h1, h2, h3)) { display: none; }
  .html:has(.pgm-predict):not(:has(.pgm-predict [open])) ~ * { visibility: hidden; }
}"""
SHOWN = "Choose before you read on: this viewer shows what follows at once."


def predict(number: str) -> None:
    """Show the choices of a prediction; what the cell shows next waits for a click.

    Each choice opens to a sentence on it. A figure that the same cell draws afterwards
    appears once a choice is open, also in a page or a slide without a kernel. `number`
    is that in the chapter's ``predictions.csv``, for example "2.1".

    Examples
    --------
    >>> predict("2.1")
    Choose: 1: they count as equal
            0.6: the gain stays
            near 0: every grey value has changed
    """
    choices = choices_of(number)
    plain = "\n        ".join(row["choice"] for row in choices)
    publish_display_data(
        {"text/html": page(number, choices), "text/plain": f"Choose: {plain}"}
    )


def choices_of(number: str) -> list[dict[str, str]]:
    """Return the rows of a prediction, one a choice."""
    chapter, _, _ = number.partition(".")
    name = "case_predictions.csv" if chapter.endswith("c") else "predictions.csv"
    path = BOOK / f"ch{chapter.removesuffix('c').zfill(2)}" / name
    found = []
    if path.is_file():
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file, strict=True))
        found = [row for row in rows if row["prediction"] == number]
    if not found:
        raise ValueError(f"number: there is no prediction {number} in pgm_book")
    return found


def page(number: str, choices: list[dict[str, str]]) -> str:
    """Write the choices in HTML; those of one name close each other."""
    name = f"predict-{escape(number)}"
    folded = [
        f'<details name="{name}"><summary>{escape(row["choice"], quote=False)}'
        f"</summary><p>{'✓' if row['right'] == 'yes' else '✗'} "
        f"{escape(row['feedback'], quote=False)}</p></details>"
        for row in choices
    ]
    shown = f'<p class="pgm-shown">{SHOWN}</p>'
    lines = [f"<style>\n{STYLE}\n</style>", "<p>Choose one:</p>", *folded, shown]
    return '<div class="pgm-predict">\n' + "\n".join(lines) + "\n</div>"
