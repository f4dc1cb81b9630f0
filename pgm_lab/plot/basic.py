"""Figures and tables for the notebooks: one look, readable at the back of a hall.

This module has what every lesson and report needs; `space` draws cameras, the other
modules draw results of the library.
"""

import base64
import html
import io
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import ArrayLike
from PIL import Image

from pgm_lab import _validate

if TYPE_CHECKING:
    from ipywidgets import ValueWidget

# The palette of Okabe and Ito (2008), distinct in all common kinds of colour vision.
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SKY, PURPLE, YELLOW, BLACK, GREY = "#56B4E9", "#CC79A7", "#F0E442", "#000000", "#6B6B6B"

# Each series with its own marker, so that none is identified by colour alone
SERIES = (
    (BLUE, "o"),
    (RED, "s"),
    (GREEN, "D"),
    (ORANGE, "^"),
    (PURPLE, "v"),
    (SKY, "P"),
    (BLACK, "X"),
)

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


# --- What reaches the notebook: a figure, a table, a figure that follows sliders ---


def publish_display_data(
    data: dict[str, Any], metadata: dict[str, Any] | None = None
) -> None:
    """Show in a running IPython; without one print the text, and start none.

    IPython's own function would start a shell, which keeps a thread and a file open.
    """
    from IPython import display, get_ipython

    if get_ipython() is None:
        print(data["text/plain"])
    else:
        display.publish_display_data(data, metadata)


def show(fig: Figure, alt: str, dpi: int = 170, colours: int | None = None) -> None:
    """Show a figure with a text for those who cannot see it, and close it.

    The size of its smallest lettering, in points, is stored with the picture; from it
    the slides check whether a hall can read it.

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
        Keep at most this many colours, up to 256: photos then take a third of the
        space.

    Raises
    ------
    ValueError
        If the text is missing.
    """
    if not isinstance(alt, str) or not alt.strip():
        raise ValueError("alt must say in words what the figure shows")
    fig.set_dpi(dpi)
    label = smallest_writing(fig)
    buffer = io.BytesIO()
    # Encoded again below, so it is not worth compressing well here
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
    seen = {"alt": alt, "width": round(fig.get_size_inches()[0] * 96)}
    if label:
        seen["label"] = round(label, 1)
    picture = base64.b64encode(buffer.getvalue()).decode()
    publish_display_data({"image/png": picture, "text/plain": alt}, {"image/png": seen})


class _Reader(RendererBase):
    """Draws nothing, and notes the size of all that is written."""

    def __init__(self, figure: Figure) -> None:
        super().__init__()
        self.size = figure.get_size_inches() * figure.dpi
        self.written: list[float] = []

    def get_canvas_width_height(self):
        return tuple(self.size)

    def points_to_pixels(self, points):
        return points  # lengths do not matter here

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):
        self.written.append(prop.get_size_in_points())

    def draw_nothing(self, *drawn, **how):
        pass

    draw_path = draw_markers = draw_path_collection = draw_nothing
    draw_quad_mesh = draw_gouraud_triangles = draw_image = draw_nothing


def smallest_writing(figure: Figure) -> float | None:
    """Return the size in points of the smallest text that is drawn, if there is any.

    This lays the figure out, and its layout is fixed from now on, so that saving draws
    it only once. Superscripts and subscripts count with the size of their formula.
    """
    reader = _Reader(figure)
    figure.draw(reader)
    figure.set_layout_engine("none")
    return min(reader.written, default=None)


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
    """
    cells = [[str(cell) for cell in row] for row in rows]
    content = header, cells, caption
    page, plain = _html_table(*content), _text_table(*content)
    publish_display_data({"text/html": page, "text/plain": plain})


WORDS = ' class="text" style="text-align: left"'


def _html_table(header: Sequence[str], cells: list[list[str]], caption: str) -> str:
    # Numbers are aligned right, words left by a style of their own: JupyterLab aligns
    # all cells right.
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


def interact(draw: Callable[..., object], **sliders: "ValueWidget") -> None:
    """Show sliders and, below them, what a function draws, redrawn after each move.

    `ipywidgets.interact` gives the picture to a widget of the page. Where a program
    acts as the page, as ``nbconvert --execute`` does, a message between the two is
    sometimes lost, and the run hangs for minutes. Here the picture is an output of the
    cell, which a new one replaces; nothing waits for an answer, and a notebook keeps
    the first picture.

    Parameters
    ----------
    draw : callable
        Called with the values of the sliders; it shows one figure (`show`), or prints.
    **sliders : ipywidgets.ValueWidget
        One for each argument of `draw`, by its name.

    Examples
    --------
    >>> from ipywidgets import IntSlider
    >>> interact(lambda size: print(size, "px"), size=IntSlider(21, 3, 61))
    IntSlider(value=21, max=61, min=3)
    ...21 px...
    """
    from IPython.display import DisplayHandle, display

    place = DisplayHandle()
    display(*sliders.values())
    data, metadata = _drawn(draw, sliders)
    place.display(data, metadata=metadata, raw=True)

    def redraw(_: object) -> None:
        data, metadata = _drawn(draw, sliders)
        place.update(data, metadata=metadata, raw=True)

    for slider in sliders.values():
        slider.observe(redraw, "value")


def _drawn(
    draw: Callable[..., object], sliders: dict[str, "ValueWidget"]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What `draw` shows or prints now, with its metadata, without showing it yet."""
    from IPython.utils.capture import capture_output

    with capture_output(stderr=False) as seen:
        draw(**{name: slider.value for name, slider in sliders.items()})
    if seen.outputs:
        return seen.outputs[-1].data, seen.outputs[-1].metadata
    return {"text/plain": seen.stdout.rstrip()}, {}


# --- What figures are made of ---


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
        Covariance of the position, in its squared units.
    probability : float
        Probability that the true point lies inside; 0.394 gives the standard ellipse.
    magnify : float
        Factor by which the ellipse is enlarged.
    **style
        Passed to `matplotlib.patches.Ellipse`.
    """
    variance, axes = np.linalg.eigh(_validate.covariances(covariance, "covariance"))
    variance = np.maximum(variance, 0.0)  # negative only by rounding
    chi_square = scipy.special.chdtri(2, 1 - probability)
    width, height = 2 * magnify * np.sqrt(variance * chi_square)
    angle = np.degrees(np.arctan2(axes[1, 0], axes[0, 0]))
    style = {"fill": False, "color": RED, "linewidth": 2.2} | style
    x, y = np.asarray(position)
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
    """Draw the two axes of a coordinate frame as arrows, their names at the tips.

    `origin`, `x_end` and `y_end` (2,) are the origin and the tips, in data units.
    """
    look: Look = {"arrowstyle": "-|>", "linewidth": 3.5, "shrinkA": 0, "shrinkB": 0}
    text: Look = {"textcoords": "offset points", "fontsize": 18, "va": "center"}
    (x0, y0), *tips = np.asarray([origin, x_end, y_end])
    for name, (x, y) in zip(names, tips):
        ax.annotate("", (x, y), (x0, y0), arrowprops=look | {"color": color})
        ax.annotate(name, (x, y), xytext=(9, 0), color=color, **text)
    ax.plot(x0, y0, "o", color=color, markersize=12)


def plain(axis: Axis, digits: tuple[int, ...] = (1, 2, 5)) -> None:
    """Label a logarithmic axis without powers of ten."""
    axis.set_major_locator(LogLocator(subs=digits, numticks=20))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(NullFormatter())


# --- Two images of one place, overlaid in two colours ---


def overlay(
    reference: ArrayLike,
    sensed: ArrayLike,
    *,
    paper: bool = False,
    ax: Axes | None = None,
) -> Figure:
    """Overlay two images: reference green, sensed magenta, grey where they are equal.

    Magenta and green can be distinguished in all common kinds of colour vision. Red and
    green, as in Brahmantara 2015, cannot: what fits is yellow there.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values, each image stretched separately; white where masked or NaN.
    paper : bool
        Sensed red and reference green, as in the paper.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if there is none.

    Returns
    -------
    matplotlib.figure.Figure
        Axes in pixels of the reference image.

    References
    ----------
    Brahmantara 2015, figure 1.1.

    Examples
    --------
    >>> import numpy as np
    >>> fig = overlay(np.eye(5), np.eye(5)[:, ::-1])
    >>> plt.close(fig)
    """
    colours = composite(reference, sensed, paper=paper)
    if ax is None:
        _, ax = plt.subplots(figsize=(10, 6.4))
    ax.imshow(colours, interpolation="nearest")
    ax.grid(False)
    ax.set(xlabel="column (px)", ylabel="row (px)")
    one, other, both = ("green", "red", "yellow") if paper else (
        "green", "magenta", "grey"
    )  # fmt: skip
    ax.set_title(f"{one}: reference, {other}: sensed, {both}: equal")
    return ax.get_figure(root=True)  # type: ignore[return-value]


def composite(
    reference: ArrayLike, sensed: ArrayLike, *, paper: bool = False
) -> np.ndarray:
    """Red, green and blue (rows, columns, 3) of `overlay`, from 0 to 1."""
    one, other = grey_levels(reference, "reference"), grey_levels(sensed, "sensed")
    colours = np.stack([other, one, np.zeros_like(one) if paper else other], axis=-1)
    colours[np.isnan(one) | np.isnan(other)] = 1.0
    return colours


def grey_levels(image: ArrayLike, name: str) -> np.ndarray:
    """Grey values from 0 to 1, the extremes beyond; NaN where there are none."""
    grey = _validate.grey_image(image, name)
    mask = np.ma.getmaskarray(grey)
    grey = np.where(mask, np.nan, np.ma.getdata(grey).astype(float))
    known = grey[np.isfinite(grey)]
    if not known.size:
        return np.full(grey.shape, np.nan)
    dark, bright = np.quantile(known, (0.02, 0.98))
    span = bright - dark if bright > dark else 1.0
    return np.asarray(np.clip((grey - dark) / span, 0.0, 1.0))
