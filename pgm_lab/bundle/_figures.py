"""The figures of the report, each with what it shows in words."""

import base64
import io
from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_lab import plot, plot_bundle
from pgm_lab.bundle._findings import suspected
from pgm_lab.bundle._words import UM, count, listed
from pgm_lab.bundle.result import Bundle

DPI = 100


def pictures(name: str, result: Bundle) -> list[tuple[str, str]]:
    """Return the figures of one kind: PNGs in base64, and what they show."""
    draw = {"residuals": residuals, "lens": lens, "precision": precision}[name]
    with plt.rc_context(plot.STYLE):
        return [(_png(figure), words) for figure, words in draw(result)]


def _png(figure: Figure) -> str:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})
    plt.close(figure)
    return base64.b64encode(buffer.getvalue()).decode()


def residuals(result: Bundle) -> Iterator[tuple[Figure, str]]:
    """Residual vectors of the photos."""
    rms = UM * np.sqrt(np.mean(result.residuals**2))
    outliers = count(len(suspected(result)), "ray")
    words = (
        "Residual vectors of the image points, photo by photo, with the suspected"
        f" blunders in another colour: {outliers}. Their root mean square is"
        f" {rms:.2f} µm; the numbers stand in the table of the photos."
    )
    yield plot_bundle.residual_vectors(result), words


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
            yield plot_bundle.lens_curve(result, camera=number), words


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
    size = 40 + 160 * largest / np.max(largest)
    marks = ax.scatter(*points[:, axes].T, size, largest, cmap="cividis_r")
    marks.set_edgecolor(plot.BLACK)
    figure.colorbar(marks, label="largest semi-axis of the sd (object units)")
    worst = np.argsort(-largest, kind="stable")[:3]
    worst_names = [result.network.point_names[j] for j in worst]
    for j, name in zip(worst, worst_names):
        away = {"xytext": (9, 6), "textcoords": "offset points"}
        ax.annotate(str(name), points[j, axes], parse_math=False, **away)
    ax.set(xlabel=f"{names[0]} (object units)", ylabel=f"{names[1]} (object units)")
    ax.set_aspect("equal", adjustable="datalim")
    words = (
        f"Precision of the object points in the {''.join(names)} plane: the larger and"
        " darker a point, the larger its standard deviation, from"
        f" {np.min(largest):.2g} to {np.max(largest):.2g} object units. The least"
        f" precise are {listed(worst_names)}; all stand in the table of the points."
    )
    yield figure, words
