"""Figures and tables for the notebooks: one look, readable at the back of a hall."""

import base64
import html
import io
import re
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import publish_display_data
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import ArrayLike
from PIL import Image
from scipy.stats import chi2

from pgm_lab.datasets import Orthophoto

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


def show(fig: Figure, alt: str, dpi: int = 130, colours: int | None = None) -> None:
    """Show a figure with a text for those who cannot see it, and close it.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
        The figure; it is closed afterwards, so that it does not appear twice.
    alt : str
        What the figure shows, in a sentence or two; kept with the picture in the
        notebook, the slides and the handout.
    dpi : int
        Resolution of the picture.
    colours : int, optional
        Keep at most so many colours, up to 256: photos then take a third of the space.

    Raises
    ------
    ValueError
        If the text is missing.
    """
    if not alt.strip():
        raise ValueError("alt must say in words what the figure shows")
    buffer = io.BytesIO()
    fig.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    plt.close(fig)
    if colours is not None:
        few = Image.open(buffer).convert("RGB")
        few = few.quantize(
            colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
        )
        few.save(buffer := io.BytesIO(), format="png", optimize=True)
    width = round(fig.get_size_inches()[0] * 96)
    picture = base64.b64encode(buffer.getvalue()).decode()
    publish_display_data(
        {"image/png": picture, "text/plain": alt},
        {"image/png": {"alt": alt, "width": width}},
    )


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
    cells = [[str(cell) for cell in row] for row in rows]
    for number, row in enumerate(cells):
        if len(row) != len(header):
            raise ValueError(
                f"row {number} has {len(row)} cells, the header has {len(header)}"
            )
    content = header, cells, caption
    page, plain = _html_table(*content), _text_table(*content)
    publish_display_data({"text/html": page, "text/plain": plain})


def _html_table(header: Sequence[str], cells: list[list[str]], caption: str) -> str:
    # Numbers stand to the right, below each other; words to the left.
    columns = zip(*cells) if cells else [()] * len(header)
    kinds = ["" if all(map(_is_number, c)) else ' class="text"' for c in columns]

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
    variance, axes = np.linalg.eigh(np.asarray(covariance, dtype=float))
    width, height = 2 * magnify * np.sqrt(variance * chi2.ppf(probability, df=2))
    angle = np.degrees(np.arctan2(axes[1, 0], axes[0, 0]))
    style = {"fill": False, "color": RED, "linewidth": 2.2} | style
    x, y = np.asarray(position, dtype=float)
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
    look: Look = {"arrowstyle": "-|>", "linewidth": 3.5, "shrinkA": 0, "shrinkB": 0}
    text: Look = {"textcoords": "offset points", "fontsize": 18, "va": "center"}
    x0, y0 = np.asarray(origin, dtype=float)
    for name, end in zip(names, (x_end, y_end)):
        x, y = np.asarray(end, dtype=float)
        ax.annotate("", (x, y), (x0, y0), arrowprops=look | {"color": color})
        ax.annotate(name, (x, y), xytext=(9, 0), color=color, **text)
    ax.plot(x0, y0, "o", color=color, markersize=12)


def pixel_on_ground(ortho: Orthophoto, height: float = 110.0) -> Figure:
    """Draw a camera above a real orthophoto, and the rays of one pixel.

    The camera is drawn far too large, and its pixels are, or they could not be seen.

    Parameters
    ----------
    ortho : datasets.Orthophoto
        What lies on the ground.
    height : float
        Flying height in m.

    Returns
    -------
    matplotlib.figure.Figure
    """
    side = ortho.grey.shape[0] * ortho.gsd / 2
    scale = 0.3  # of the image, large enough to be seen and to hold the whole ground
    image_height = height * (1 - scale)
    centre = np.array([0.0, 0.0, height])
    lines = np.linspace(-side, side, 9) * scale
    pixel = np.array([[5, 1], [6, 1], [6, 2], [5, 2]])
    image = np.column_stack([lines[pixel], np.full(4, image_height)])
    ground = centre + (image - centre) / scale

    fig = plt.figure(figsize=(10, 6.6), layout="none")
    where = (-0.25, -0.2, 1.5, 1.5)
    ax: Any = fig.add_axes(where, projection="3d", computed_zorder=False)
    ax.set_proj_type("ortho")
    azimuth = -62
    ax.view_init(elev=20, azim=azimuth)
    _lay_out(ax, ortho, side, 0.0, pixels=192, zorder=1)
    _lay_out(ax, ortho, side * scale, image_height, pixels=48, zorder=4)
    for at in lines:
        for x, y in ((lines[[0, -1]], [at, at]), ([at, at], lines[[0, -1]])):
            ax.plot(x, y, image_height, color="white", linewidth=0.8, zorder=5)
    ax.add_collection3d(Poly3DCollection([image], color=RED, zorder=6))
    ax.add_collection3d(Poly3DCollection([ground], color=RED, alpha=0.75, zorder=2))
    for top, bottom in zip(image, ground, strict=True):
        ax.plot(*zip(top, bottom, strict=True), color=RED, linewidth=1.6, zorder=3)
        ax.plot(*zip(centre, top, strict=True), color=RED, linewidth=1.6, zorder=7)
    ax.plot(*centre, "o", color=BLACK, markersize=10, zorder=8)
    # Straight to the left as the reader sees it, so that heights compare
    left = np.array([np.sin(np.radians(azimuth)), -np.cos(np.radians(azimuth))])
    bars = ("H", 0.0, 1.33 * side), ("c", image_height, 0.46 * side)
    for name, low, distance in bars:
        x, y = distance * left
        ax.plot([x, x], [y, y], [low, height], "-_", color=BLACK, markersize=13)
        x, y = (distance + 5) * left
        ax.text(x, y, (low + height) / 2, name, fontsize=21, ha="right", va="center")
    ax.text(*(centre + (6, 0, 3)), "perspective centre", fontsize=17)
    ax.text(side * scale + 9, 6, image_height, "image", fontsize=17)
    label = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 3}
    at = ground[1] + (5, -2, 0)
    ax.text(*at, "GSD", fontsize=21, color=RED, weight="bold", bbox=label, zorder=9)
    ax.set(xlim=(-side, side), ylim=(-side, side), zlim=(0, height))
    ax.set_box_aspect((2 * side, 2 * side, height), zoom=0.93)
    ax.set_axis_off()
    return fig


def _lay_out(
    ax: Axes3D, ortho: Orthophoto, side: float, height: float, pixels: int, zorder: int
) -> None:
    """Lay the orthophoto, averaged to pixels x pixels, on a plane at a height."""
    n = ortho.grey.shape[0] // pixels
    blocks = ortho.grey[: n * pixels, : n * pixels].reshape(pixels, n, pixels, n)
    colour = plt.get_cmap("gray")(blocks.mean(axis=(1, 3)) / 255)
    x, y = np.meshgrid(*2 * [np.linspace(-side, side, pixels + 1)])
    z = np.full_like(x, height)
    options: Look = {"rstride": 1, "cstride": 1, "shade": False, "antialiased": False}
    ax.plot_surface(x, -y, z, facecolors=colour, zorder=zorder, **options)
