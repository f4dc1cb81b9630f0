"""The ledger's table on slides: one to three verdicts, large, each on a card."""

import copy
import re
from html import escape

from bs4 import BeautifulSoup
from nbformat import NotebookNode

from pgm_book.make import deck

# A mark beside the colour, for those who do not tell the colours apart.
MARKS = {"reproduced": "✓", "corrected": "≠", "not derivable": "?"}
HEADER = ["source", "printed", "what we get", "verdict"]
ON_A_SLIDE = 3
SENTENCE = re.compile(r"(?<=[.?!]) (?=[A-Z])")

Row = list[str]


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
    if [th.get_text() for th in soup.select("thead th")][:4] != HEADER:
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
    shown = rows if len(rows) <= 2 * ON_A_SLIDE else rows[:ON_A_SLIDE]
    if len(shown) < len(rows):
        caption = f"{caption}; {len(rows) - len(shown)} more are in the notebook"
    first, second = shown[:ON_A_SLIDE], shown[ON_A_SLIDE:]
    # A copy before the first cards are put in: it will hold the second.
    more = copy.deepcopy(cell)
    output.data = {"text/html": cards(first, caption)}
    # 0 is the heading that a slide may have for itself, see `prepare.titled`.
    result = [*slide, deck.made(cell, _in_full(first), "notes", 1)]
    if second:
        heading = slide[0].source.partition("\n")[0].lstrip("# ") or "Verdicts"
        more.id, more.metadata.slideshow = f"{cell.id}{deck.MADE}cards", {}
        more.outputs = [copy.deepcopy(output)]
        more.outputs[0].data = {"text/html": cards(second, caption)}
        above = deck.made(cell, f"### {heading}, continued", "subslide", 2)
        result += [above, more, deck.made(cell, _in_full(second), "notes", 3)]
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
