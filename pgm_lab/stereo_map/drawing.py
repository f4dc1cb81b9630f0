"""A measurement in figures and words: panels that are drawn into given axes, and text.

One figure of all is for slides, paper, and wherever no kernel runs.
"""

import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from pgm_lab import _validate, plot
from pgm_lab._rounding import rounded
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look
from pgm_lab.stereo_map.session import Measurement, Session

WIDTH, LINE = 10.0, 100  # inches, and letters of 13 points in a line
MARK: Look = {"marker": "+", "markersize": 15, "markeredgewidth": 2.2, "linestyle": ""}
HALO: Look = MARK | {"markeredgewidth": 4.4, "color": basic.BLACK}
PEAK: Look = {"marker": "o", "mfc": "none", "mec": basic.RED, "mew": 2.2, "ms": 11}
PROBABILITY = 0.95
UM = 1e3  # micrometres in a millimetre
MINUS = str.maketrans("-", "−")


def draw(session: Session, point: Measurement) -> Figure:
    """Draw a measurement: both photos, template, search, map of r, ellipse, numbers."""
    _validate.instance(session, Session, "session")
    _validate.instance(point, Measurement, "point")
    rows, columns = session.left.grey.shape
    high = float(np.clip(4.5 * rows / columns, 2.0, 3.0))
    text = [textwrap.fill(line, LINE) for line in lines(session, point)]
    written = "\n".join(text)
    heights = high + 0.4, 1.95, 0.25 * (1 + written.count("\n")) + 0.1
    fig = plt.figure(figsize=(WIDTH, sum(heights)), layout="constrained")
    above, middle, below = np.asarray(fig.subfigures(3, 1, height_ratios=heights))
    views = [
        View(ax, levels, title)
        for ax, levels, title in zip(
            above.subplots(1, 2), session.levels, ("left photo", "right photo")
        )
    ]
    mark(views, session, point)
    details(list(middle.subplots(1, 4)), point)
    below.text(0.01, 0.98, written, va="top", fontsize=13, linespacing=1.4)
    return fig


def show(session: Session, point: Measurement) -> None:
    """Show the figure of `draw` with a text for those who cannot see it."""
    fig = draw(session, point)
    plot.show(fig, alt(session, point), colours=256)


def alt(session: Session, point: Measurement) -> str:
    """Return what the figure of a measurement shows, in words."""
    _validate.instance(session, Session, "session")
    _validate.instance(point, Measurement, "point")
    line = " with its epipolar line" if len(point.curve) else ""
    return (
        f"Two photos; the left one with the point that was clicked, the right one{line}"
        " and the match. Below: the template, the part of the right photo that was"
        " searched, the map of the correlation r, and the match with its 95 % ellipse. "
        + " ".join(lines(session, point))
    )


def mark(views: "list[View]", session: Session, point: Measurement | None) -> None:
    """Put the marks of all points, and of a new one, into both views."""
    kept = [p for p in session.points if point is None or p.name != point.name]
    names = [p.name for p in kept]
    nothing = np.zeros((0, 2))
    left = np.array([p.left for p in kept]).reshape(-1, 2)
    right = np.array([p.right for p in kept]).reshape(-1, 2)
    new = (nothing, nothing) if point is None else (point.left, point.right)
    curve = nothing if point is None else point.curve
    views[0].mark(left, names, new[0], nothing)
    views[1].mark(right, names, new[1], curve)


# --- Panels ---


class View:
    """One photo in its axes, drawn from the level that the view needs."""

    def __init__(
        self, ax: Axes, levels: list[np.ndarray], title: str, size: int = 14
    ) -> None:
        self.ax, self.levels = ax, levels
        rows, columns = levels[0].shape
        low, top = np.percentile(levels[-1], [0.5, 99.5])
        ax.set_title(title, fontsize=size + 1)
        ax.tick_params(labelsize=size)
        ax.set_facecolor(basic.GREY)
        ax.grid(False)
        self.image: AxesImage = ax.imshow(
            levels[-1], cmap="gray", vmin=low, vmax=top, interpolation="nearest"
        )
        self.line = ax.plot([], [], color=basic.YELLOW, linewidth=1.6)[0]
        self.kept_halo = ax.plot([], [], **HALO)[0]
        self.kept = ax.plot([], [], **MARK, color=basic.SKY)[0]
        self.new_halo = ax.plot([], [], **HALO)[0]
        self.new = ax.plot([], [], **MARK, color=basic.ORANGE)[0]
        self.names: list = []
        ax.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5))
        self.update()
        ax.callbacks.connect("xlim_changed", self.update)
        ax.callbacks.connect("ylim_changed", self.update)

    @property
    def step(self) -> float:
        """Pixels of the photo in a pixel of the drawing."""
        x0, x1 = self.ax.get_xlim()
        return abs(x1 - x0) / max(self.ax.bbox.width, 1.0)

    def update(self, _: object = None) -> None:
        """Draw what the view shows, no finer than it shows it."""
        k = int(np.floor(np.log2(max(self.step, 1.0))))
        k = min(k, len(self.levels) - 1)
        level, size = self.levels[k], 2**k
        limits = np.sort([self.ax.get_xlim(), self.ax.get_ylim()], axis=1) / size
        most = np.array(level.shape[::-1])
        low = np.clip(np.floor(limits[:, 0]).astype(int), 0, most - 1)
        high = np.clip(np.ceil(limits[:, 1]).astype(int) + 1, low + 1, most)
        self.image.set_data(level[low[1] : high[1], low[0] : high[0]])
        left, top = size * (low - 0.5)
        right, bottom = size * (high - 0.5)
        self.image.set_extent((left, right, bottom, top))

    def mark(
        self, points: np.ndarray, names: list[int], new: np.ndarray, curve: np.ndarray
    ) -> None:
        """Put marks on kept points (n, 2) and a new one (1, 2), and a curve (k, 2)."""
        for line in (self.kept, self.kept_halo):
            line.set_data(*points.reshape(-1, 2).T)
        for line in (self.new, self.new_halo):
            line.set_data(*new.reshape(-1, 2).T)
        self.line.set_data(*curve.reshape(-1, 2).T)
        for text in self.names:
            text.remove()
        look: Look = {"textcoords": "offset points", "color": basic.BLACK}
        look |= {"fontsize": 13, "annotation_clip": True}
        look["bbox"] = {"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none"}
        self.names = [
            self.ax.annotate(str(name), point, (7, 6), **look)
            for name, point in zip(names, points)
        ]

    def show(self, centre: np.ndarray, span: float) -> None:
        """Move the view to a place, `span` columns wide."""
        (x, y), shape = centre, self.ax.get_ylim()
        high = span * abs(np.subtract(*shape)) / abs(np.subtract(*self.ax.get_xlim()))
        self.ax.set(xlim=(x - span / 2, x + span / 2))
        self.ax.set(ylim=(y + high / 2, y - high / 2))


def details(axes: list[Axes], point: Measurement, size: int = 13) -> None:
    """Draw template, search window, map of r and ellipse into four axes."""
    for ax in axes:
        ax.clear()
        ax.grid(False)
        ax.set_anchor("N")
    _template(axes[0], point)
    _window(axes[1], point)
    _map(axes[2], point)
    _ellipse(axes[3], point)
    titles = "template", "searched", "correlation r", "match, 95 %"
    for ax, title in zip(axes, titles):
        ax.set_title(title, fontsize=size + 1)
        ax.tick_params(labelsize=size)
        ax.locator_params(nbins=3)
    axes[3].locator_params(axis="x", nbins=2)


def _template(ax: Axes, point: Measurement) -> None:
    if not point.template.size:
        return _nothing(ax)
    rows, columns = point.template.shape
    corner = np.floor(point.left + 0.5) - np.array([columns // 2, rows // 2])
    _grey(ax, point.template, corner)
    ax.plot(*point.left, **HALO)
    ax.plot(*point.left, **MARK, color=basic.ORANGE)


def _window(ax: Axes, point: Measurement) -> None:
    if not point.window.size:
        return _nothing(ax)
    _grey(ax, point.window, point.corner)
    _curve(ax, point)
    if np.isfinite(point.right).all():
        h = point.template.shape[0] / 2
        square = np.array([(-h, -h), (h, -h), (h, h), (-h, h), (-h, -h)])
        ax.plot(*(point.right + square @ point.shape.T).T, color=basic.ORANGE)
        ax.plot(*point.right, **HALO)
        ax.plot(*point.right, **MARK, color=basic.ORANGE)


def _map(ax: Axes, point: Measurement) -> None:
    if not point.map.size:
        return _nothing(ax)
    corner = point.corner + (np.array(point.template.shape[::-1]) - 1) / 2
    extent = _extent(point.map, corner)
    ax.imshow(point.map, cmap="cividis", extent=extent)
    _curve(ax, point)
    if np.isfinite(point.correlated).all():
        ax.plot(*point.correlated, **PEAK)


def _ellipse(ax: Axes, point: Measurement) -> None:
    if not np.isfinite(point.right).all():
        return _nothing(ax)
    ax.set_aspect("equal")
    _curve(ax, point)
    ax.plot(*point.correlated, **PEAK)
    ax.plot(*point.right, **MARK, color=basic.ORANGE)
    basic.error_ellipse(
        ax, point.right, point.covariance, PROBABILITY, color=basic.ORANGE
    )
    largest = np.sqrt(np.linalg.eigvalsh(point.covariance)[-1])
    away = np.abs(point.correlated - point.right).max()
    half = 1.3 * max(3 * largest, away)
    (x, y) = point.right
    ax.set(xlim=(x - half, x + half), ylim=(y + half, y - half))
    ax.grid(True)


def _grey(ax: Axes, window: np.ndarray, corner: np.ndarray) -> None:
    ax.imshow(window, cmap="gray", extent=_extent(window, corner))


def _curve(ax: Axes, point: Measurement) -> None:
    """Epipolar curve, where the axes are already as large as they are to be."""
    limits = ax.get_xlim(), ax.get_ylim()
    ax.plot(*point.curve.T, color=basic.YELLOW, linewidth=1.6)
    ax.set(xlim=limits[0], ylim=limits[1])


def _extent(values: np.ndarray, corner: np.ndarray) -> tuple:
    """Limits (left, right, bottom, top) of an array, the first pixel at a corner."""
    (column, row), (rows, columns) = corner - 0.5, values.shape
    return column, column + columns, row + rows, row


def _nothing(ax: Axes) -> None:
    ax.set(xticks=[], yticks=[])
    ax.text(0.5, 0.5, "–", transform=ax.transAxes, ha="center", fontsize=20)


# --- In words ---


def lines(session: Session, point: Measurement) -> list[str]:
    """Return what is known of a point, a line for each kind of coordinates."""
    name = f"Point {point.name}" if point.name else "New point"
    sought = point.reason and point.status != "template leaves the image"
    where = f" Sought {point.reason}" if sought else ""
    if np.isfinite(point.r):
        where += f"; r = {point.r:.2f} by correlation"
    if np.isfinite(point.r_fine):
        where += f", {point.r_fine:.2f} by least squares"
    found = [f"{name}: {point.why}{where}{'.' * bool(where)}"]
    left = _rounded(point.left, np.full(2, 0.1))
    if not np.isfinite(point.right).all():
        return [*found, f"Pixels: left ({left})"]
    sd = np.sqrt(np.diagonal(point.covariance))
    right, error = _rounded(point.right, sd), _rounded(sd, sd)
    found.append(f"Pixels: left ({left}), right ({right}) ± ({error})")
    sides = (
        f"{side} ({xy[0]:.4f}, {xy[1]:.4f}) ± ({s[0]:.2f}, {s[1]:.2f}) µm"
        for side, xy, s in zip(("left", "right"), point.photo, UM * point.photo_sd)
    )
    found.append(f"Photo, mm: {', '.join(sides)}".translate(MINUS))
    if session.space == "none" or not np.isfinite(point.xyz).all():
        return [*found, "Object: not oriented yet; keep points, then orient."]
    place = "; ".join(
        f"{axis} = {rounded(v, s)[0]} ± {rounded(s, s)[0]}"
        for axis, v, s in zip("XYZ", point.xyz[:, None], point.sd[:, None])
    )
    off = f"y parallax {point.y_parallax:.2f} px"
    base = f"Model (base in x: {session.right.exterior[0]:.0f})"
    kind = base if session.space == "model" else "Object"
    found.append(f"{kind}: {place}; {off}".translate(MINUS))
    return found


def pixels(values: np.ndarray) -> str:
    """Write (column, row) with two decimals."""
    return ", ".join(f"{value:.2f}" for value in values)


def _rounded(values: np.ndarray, sd: np.ndarray) -> str:
    return ", ".join(rounded(values, sd)).translate(MINUS)
