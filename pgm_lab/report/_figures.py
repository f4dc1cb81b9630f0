"""The figures of the report, each with what it shows in words."""

import base64
import io
from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_lab import plot
from pgm_lab._rounding import round_number
from pgm_lab.bundle.result import Bundle
from pgm_lab.plot.basic import Look
from pgm_lab.report._layout import count, listed
from pgm_lab.report._misfit import suspected
from pgm_lab.report._space import stations
from pgm_lab.report._words import UM

DPI = 100
DENSE = 400  # rays a photo: more vectors than a small picture can show
CELLS = 12  # across the image, for means


def pictures(name: str, result: Bundle) -> list[tuple[str, str]]:
    """Return the figures of one kind: PNGs in base64, and what they show."""
    kinds = {
        "residuals": residuals,
        "lens": lens,
        "precision": precision,
        "stations": stations,
    }
    draw = kinds[name]
    with plt.rc_context(plot.STYLE):
        return [(png(figure), words) for figure, words in draw(result)]


def png(figure: Figure) -> str:
    """Return a figure as PNG in base64, and close it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})
    plt.close(figure)
    return base64.b64encode(buffer.getvalue()).decode()


def residuals(result: Bundle) -> Iterator[tuple[Figure, str]]:
    """Residual vectors of the photos, or their means where they would be a blot."""
    network = result.network
    if len(network.xy) > DENSE * len(network.exteriors):
        yield mean_residuals(result)
        return
    rms = UM * np.sqrt(np.mean(result.residuals**2))
    outliers = count(len(suspected(result)), "ray")
    words = (
        "Residual vectors of the image points, photo by photo, with the suspected"
        f" blunders in another colour: {outliers}. Their root mean square is"
        f" {rms:.2f} µm; the numbers stand in the table of the photos."
    )
    yield plot.bundle.residual_vectors(result), words


def mean_residuals(result: Bundle) -> tuple[Figure, str]:
    """Mean residuals of all photos in cells of the image: what the camera leaves."""
    xy, v = result.network.xy, UM * result.residuals
    low, width = xy.min(axis=0), np.ptp(xy, axis=0).max()
    cell = np.minimum((CELLS * (xy - low) / width).astype(int), CELLS - 1)
    cell = cell @ [CELLS, 1]
    number = np.bincount(cell, minlength=CELLS**2)
    filled = number >= 10
    sums = [np.bincount(cell, a, minlength=CELLS**2)[filled] for a in (*xy.T, *v.T)]
    x, y, vx, vy = sums / number[filled]
    length = np.hypot(vx, vy)
    beyond = length > 3.3 * np.sqrt(np.mean(v**2) / number[filled])  # one in 230
    unit = round_number(length.max())  # half as long as a cell

    figure, ax = plt.subplots(figsize=(9, 7))
    for which, colour in ((~beyond, plot.BLUE), (beyond, plot.RED)):
        look: Look = {"angles": "xy", "scale_units": "xy", "color": colour}
        scale = 2 * CELLS * unit / width
        arrows = ax.quiver(
            x[which], y[which], vx[which], vy[which], scale=scale, width=0.004, **look
        )
    ax.quiverkey(arrows, 0.82, 1.02, unit, f"{unit:g} µm", labelpos="E", color="black")
    ax.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    ax.set_title("Mean residuals of all photos")
    ax.margins(0.08)
    words = (
        f"Mean residual vectors of all photos in {np.sum(filled)} cells of the image."
        f" The largest is {length.max():.2g} µm long; {np.sum(beyond)} are longer than"
        " chance explains and drawn in another colour."
    )
    return figure, words


def lens(result: Bundle) -> Iterator[tuple[Figure, str]]:
    """Radial distortion of each camera with its confidence band."""
    for number, camera in enumerate(result.cameras):
        own = result.network.camera[result.network.photo] == number
        if np.any(own) and np.any(camera.interior[3:6]):
            of_camera = f" of camera {number + 1}" if len(result.cameras) > 1 else ""
            words = (
                f"Radial distortion of the lens{of_camera} over the distance from the"
                " principal point, with its 95 % band; the numbers stand in the table."
            )
            yield plot.bundle.lens_curve(result, camera=number), words


def precision(result: Bundle) -> Iterator[tuple[Figure, str]]:
    """Where points are precise: in the coordinate plane in which they spread most."""
    points = result.points
    spread = np.cov(points.T)
    planes = [[0, 1], [0, 2], [1, 2]]
    axes = max(planes, key=lambda plane: np.linalg.det(spread[np.ix_(plane, plane)]))
    if not np.any(result.sd_points > 0):  # held, or not known without redundancy
        return
    largest = np.sqrt(np.linalg.eigvalsh(result.covariance_points)[:, -1])
    names = ["XYZ"[axis] for axis in axes]
    figure, ax = plt.subplots(figsize=(9, 6.5))
    size = (40 + 160 * largest / np.max(largest)) / max(1, len(points) / 300)
    order = np.argsort(largest)  # what is worse lies on top
    x, y = points[order][:, axes].T
    marks = ax.scatter(x, y, size[order], largest[order], cmap="cividis_r")
    if len(points) <= 300:
        marks.set_edgecolor(plot.BLACK)
    figure.colorbar(marks, label="largest semi-axis of the sd (object units)")
    worst = np.argsort(-largest, kind="stable")[:3]
    worst_names = [result.network.point_names[j] for j in worst]
    for j, name in zip(worst, worst_names):
        away: Look = {"xytext": (9, 6), "textcoords": "offset points"}
        place = (points[j, axes[0]], points[j, axes[1]])
        ax.annotate(str(name), place, parse_math=False, **away)
    ax.set(xlabel=f"{names[0]} (object units)", ylabel=f"{names[1]} (object units)")
    ax.set_aspect("equal", adjustable="datalim")
    words = (
        f"Precision of the object points in the {''.join(names)} plane: the larger and"
        " darker a point, the larger its standard deviation, from"
        f" {np.min(largest):.2g} to {np.max(largest):.2g} object units. The least"
        f" precise are {listed(worst_names)}; all stand in the table of the points."
    )
    yield figure, words
