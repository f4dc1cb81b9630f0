"""Figures and tables for the notebooks: one look, readable at the back of a hall."""

import base64
import html
import io
import re
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import ArrayLike
from PIL import Image

from pgm_lab import _validate
from pgm_lab._shown import publish_display_data
from pgm_lab.plot import _doors, _labels

# The palette of Okabe and Ito (2008), told apart in all common kinds of colour vision.
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SKY, PURPLE, YELLOW, BLACK, GREY = "#56B4E9", "#CC79A7", "#F0E442", "#000000", "#6B6B6B"

Look = dict[str, Any]  # keywords of matplotlib: colours, widths, alignments

# For plt.style.use, in the first cell of a notebook.
STYLE: dict[Any, Any] = {
    "axes.grid": True,
    "axes.labelsize": 15,
    "axes.prop_cycle": plt.cycler(color=[BLUE, RED, GREEN, ORANGE, PURPLE, SKY, BLACK]),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 16,
    "figure.constrained_layout.use": True,
    "figure.figsize": (10.0, 5.0),
    "font.size": 14,
    "grid.alpha": 0.35,
    "image.cmap": "gray",
    "legend.fontsize": 13,
    "legend.frameon": False,
    "lines.linewidth": 2.2,
    "lines.markersize": 8,
    "xtick.labelsize": 13,
    "ytick.labelsize": 13,
}


def show(fig: Figure, alt: str, dpi: int = 170, colours: int | None = None) -> None:
    """Show a figure with a text for those who cannot see it, and close it.

    With the picture goes the size of its smallest writing, in points, from which the
    slides tell whether a hall can read it.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
        The figure; it is closed afterwards, so that it does not appear twice.
    alt : str
        What the figure shows, in a sentence or two; kept with the picture in the
        notebook, the slides and the handout.
    dpi : int
        Resolution of the picture; with 170, ten inches fill a slide at 1080 lines.
    colours : int, optional
        Keep at most so many colours, up to 256: photos then take a third of the space.

    Raises
    ------
    ValueError
        If the text is missing.
    """
    _validate.instance(fig, Figure, "fig")
    dpi = _validate.whole(dpi, "dpi", 1, 1200)
    if colours is not None:
        colours = _validate.whole(colours, "colours", 2, 256)
    if not isinstance(alt, str) or not alt.strip():
        raise ValueError("alt must say in words what the figure shows")
    buffer = io.BytesIO()
    # what is encoded once more needs no effort the first time
    effort = {} if colours is None else {"compress_level": 1}
    fig.savefig(
        buffer, format="png", dpi=dpi, metadata={"Software": None}, pil_kwargs=effort
    )
    plt.close(fig)
    if colours is not None:
        few = Image.open(buffer).convert("RGB")
        few = few.quantize(
            colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
        )
        few.save(buffer := io.BytesIO(), format="png", optimize=True)
    seen: dict[str, str | float] = {"alt": alt}
    seen["width"] = round(fig.get_size_inches()[0] * 96)
    label = _labels.smallest(fig)
    if label is not None:
        seen["label"] = round(label, 1)
    picture = base64.b64encode(buffer.getvalue()).decode()
    publish_display_data({"image/png": picture, "text/plain": alt}, {"image/png": seen})


def table(
    header: Sequence[str], rows: Sequence[Sequence[object]], caption: str
) -> None:
    """Show a table with a caption; the first column names the rows.

    Parameters
    ----------
    header : sequence of str
        Column heads, with units.
    rows : sequence of sequences
        Cells, already rounded; shown with `str`.
    caption : str
        What the table shows.

    Raises
    ------
    ValueError
        If a row has another length than the header.
    """
    header = _validate.texts(header, "header")
    _validate.text(caption, "caption")
    several = _validate.several(rows, "rows")
    cells = [[_cell(one) for one in _validate.several(r, "rows")] for r in several]
    for number, row in enumerate(cells):
        if len(row) != len(header):
            raise ValueError(
                f"row {number} has {len(row)} cells, the header has {len(header)}"
            )
    content = header, cells, caption
    page, plain = _html_table(*content), _text_table(*content)
    publish_display_data({"text/html": page, "text/plain": plain})


def _cell(value: object) -> str:
    try:
        return str(value)
    except Exception:  # of a stranger's object
        raise ValueError("rows has a cell that cannot be written as text") from None


WORDS = ' class="text" style="text-align: left"'


def _html_table(header: Sequence[str], cells: list[list[str]], caption: str) -> str:
    # Numbers stand to the right, below each other; words to the left, and say so
    # themselves: JupyterLab sets all cells to the right.
    columns = zip(*cells) if cells else [()] * len(header)
    kinds = ["" if all(map(_is_number, c)) else WORDS for c in columns]

    def row(texts: Sequence[str], first: str, other: str) -> str:
        tags = [first, *[other] * (len(texts) - 1)]
        cells = (
            f"<{tag}{kind}>{html.escape(text, quote=False)}</{tag.split()[0]}>"
            for tag, kind, text in zip(tags, kinds, texts, strict=True)
        )
        return f"<tr>{''.join(cells)}</tr>"

    head = row(header, 'th scope="col"', 'th scope="col"')
    body = "\n".join(row(texts, 'th scope="row"', "td") for texts in cells)
    return (
        f'<table class="pgm-table">\n<caption>{html.escape(caption)}</caption>\n'
        f"<thead>{head}</thead>\n<tbody>\n{body}\n</tbody>\n</table>"
    )


def _is_number(text: str) -> bool:
    """Whether a cell is a number, perhaps with sign, precision and unit."""
    return bool(re.match(r"[-+±−]?\d[\d.,]*( ±.*| \S+)?$", text))


def _text_table(header: Sequence[str], cells: list[list[str]], caption: str) -> str:
    widths = [max(map(len, column)) for column in zip(header, *cells, strict=True)]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True))
        for row in (header, *cells)
    ]
    return "\n".join([caption, *(line.rstrip() for line in lines)])


def error_ellipse(
    ax: Axes,
    position: ArrayLike,
    covariance: ArrayLike,
    probability: float = 0.95,
    magnify: float = 1.0,
    **style: Any,
) -> Ellipse:
    """Draw the confidence ellipse of a point of known covariance.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw, in the units of the position.
    position : array_like (2,)
        Centre of the ellipse.
    covariance : array_like (2, 2)
        Covariance of the position, in squared units of it.
    probability : float
        Probability that the true point lies inside; 0.394 gives the standard ellipse.
    magnify : float
        Factor by which the ellipse is drawn too large.
    **style
        Handed to `matplotlib.patches.Ellipse`.

    Returns
    -------
    matplotlib.patches.Ellipse
    """
    _doors.axes(ax)
    x, y = _validate.one_point(position, 2, "position")
    C = _validate.covariances(covariance, "covariance")
    C = _validate.of_shape(C, (2, 2), "covariance")
    probability = _validate.probability(probability, "probability")
    magnify = _validate.positive_number(magnify, "magnify", "a factor")
    variance, axes = np.linalg.eigh(C)
    variance = np.maximum(variance, 0.0)  # but for rounding
    width, height = (
        2 * magnify * np.sqrt(variance * scipy.stats.chi2.ppf(probability, df=2))
    )
    angle = np.degrees(np.arctan2(axes[1, 0], axes[0, 0]))
    style = {"fill": False, "color": RED, "linewidth": 2.2} | style
    ellipse = Ellipse((x, y), width, height, angle=angle, **style)
    ax.add_patch(ellipse)
    return ellipse


def frame(
    ax: Axes,
    origin: ArrayLike,
    x_end: ArrayLike,
    y_end: ArrayLike,
    names: tuple[str, str] = ("x", "y"),
    color: str = BLUE,
) -> None:
    """Draw the two axes of a coordinate frame as arrows.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    origin, x_end, y_end : array_like (2,)
        Origin and the tips of the two arrows, in data units.
    names : (str, str)
        What to write at the tips.
    color : str
        Colour of the frame.
    """
    _doors.axes(ax)
    x0, y0 = _validate.one_point(origin, 2, "origin")
    x_end = _validate.one_point(x_end, 2, "x_end")
    y_end = _validate.one_point(y_end, 2, "y_end")
    tips = zip(_validate.texts(names, "names", 2), (x_end, y_end))
    _doors.colour(color, "color")
    look: Look = {"arrowstyle": "-|>", "linewidth": 3.5, "shrinkA": 0, "shrinkB": 0}
    text: Look = {"textcoords": "offset points", "fontsize": 18, "va": "center"}
    for name, (x, y) in tips:
        ax.annotate("", (x, y), (x0, y0), arrowprops=look | {"color": color})
        ax.annotate(name, (x, y), xytext=(9, 0), color=color, **text)
    ax.plot(x0, y0, "o", color=color, markersize=12)
