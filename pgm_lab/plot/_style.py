"""What the figures of bundles share: series, units, names, views."""

import re

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter
from mpl_toolkits.mplot3d import Axes3D, proj3d

from pgm_lab.plot import basic, space

ELEVATION = 16.0  # of the reader's eye, in degrees
UM = 1e3  # micrometres in a millimetre
# Each series with a mark of its own, so that none is told by its colour alone
SERIES = (
    (basic.BLUE, "o"),
    (basic.RED, "s"),
    (basic.GREEN, "D"),
    (basic.ORANGE, "^"),
    (basic.PURPLE, "v"),
    (basic.SKY, "P"),
    (basic.BLACK, "X"),
)


def symbol(name: str) -> str:
    """Parameters as formulas: "x0, P1" becomes "$x_0$, $P_1$"."""
    return re.sub(r"\b(omega|phi|kappa|(c|x|y|K|P|b|[XYZ])(\d?))\b", _formula, name)


def _formula(found: re.Match) -> str:
    word, letter, digit = found.groups()
    if letter:
        return f"${letter}_{digit}$" if digit else f"${letter}$"
    return r"$\varphi$" if word == "phi" else rf"$\{word}$"


def plain(axis: Axis, digits: tuple[int, ...] = (1, 2, 5)) -> None:
    """Number a logarithmic axis without powers of ten."""
    axis.set_major_locator(LogLocator(subs=digits, numticks=20))
    axis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.set_minor_formatter(NullFormatter())


def best_view(centres: np.ndarray, points: np.ndarray) -> tuple[float, float]:
    """Elevation and azimuth that show the object most openly, cameras at its side."""
    horizontal = np.concatenate([centres, points])[:, :2]
    x, y = np.linalg.svd(horizontal - horizontal.mean(axis=0))[2][0]
    side = np.degrees(np.arctan2(-x, y))  # lays the longest extent across the picture
    views = [(ELEVATION, side + turn) for turn in (-35.0, 35.0, 145.0, 215.0)]
    area = [np.linalg.det(np.cov(screen(view) @ points.T)) for view in views]
    return views[int(np.argmax(area))]


def screen(view: tuple[float, float]) -> np.ndarray:
    """Directions (2, 3) to the right and upwards as the reader sees them."""
    elevation, azimuth = np.radians(view)
    s, c = np.sin(azimuth), np.cos(azimuth)
    up = (-np.sin(elevation) * c, -np.sin(elevation) * s, np.cos(elevation))
    return np.array([(-s, c, 0.0), up])


def together(centres: np.ndarray, distance: float) -> list[str]:
    """Numbers of the cameras; the first of those at one place bears them all."""
    if not len(centres):
        return []
    near = np.linalg.norm(centres[:, None] - centres[None], axis=2) < distance
    first = near.argmax(axis=1)
    return [
        ", ".join(str(j + 1) for j in np.flatnonzero(first == i))
        for i in range(len(near))
    ]


def fill(
    ax: Axes3D, drawn: np.ndarray, where: tuple[float, float, float, float]
) -> None:
    """Bring what was drawn (n, 3) into a rectangle of the figure, as large as it goes.

    The rectangle is (left, bottom, width, height) as fractions of the figure.
    """
    ax.set_position(where)
    space.fit(ax, drawn)
    low, high = _corners(ax, drawn)
    zoom = np.min(where[2:] / (high - low))
    space.fit(ax, drawn, zoom=zoom)
    low, high = _corners(ax, drawn)
    left, bottom = where[:2] + np.array(where[2:]) / 2 - (low + high) / 2
    ax.set_position((where[0] + left, where[1] + bottom, *where[2:]))


def _corners(ax: Axes3D, drawn: np.ndarray) -> np.ndarray:
    """Lower left and upper right corner of the drawing, as fractions of the figure."""
    ax.apply_aspect()
    x, y, _ = proj3d.proj_transform(*drawn.T, ax.get_proj())
    seen = ax.transData.transform(np.column_stack([x, y]))
    seen = ax.figure.transFigure.inverted().transform(seen)
    return np.array([seen.min(axis=0), seen.max(axis=0)])
