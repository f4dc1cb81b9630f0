"""The network in space: where the photos were taken, and the points they show."""

from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from pgm_lab import plot, rotation
from pgm_lab._rounding import fixed, plain
from pgm_lab.bundle.result import Bundle
from pgm_lab.report._layout import count

MOST_CAMERAS = 60  # drawn with their photo planes; more would cover the points
MOST_NAMES = 30
MOST_POINTS = 5000  # a picture shows no more of them
SIZE = 0.12  # of a camera, in diameters of the network


def stations(result: Bundle) -> Iterator[tuple[Figure, str]]:
    """Stations and points in space, the last step of Muliawan's program."""
    centres, points = result.exteriors[:, :3], result.points
    everything = np.concatenate([centres, points])
    low, high = everything.min(axis=0), everything.max(axis=0)
    figure = plt.figure(figsize=(10, 8))
    ax = plot.space.space(figure)
    ax.set_axis_on()
    shown = points[:: -(-len(points) // MOST_POINTS)]
    ax.scatter(*shown.T, s=14, color=plot.BLUE, label="object points", depthshade=False)
    label: dict = {
        "label": "projection centres",
        "color": plot.RED,
        "depthshade": False,
    }
    ax.scatter(*centres.T, s=30, marker="s", **label)
    drawn = [everything]
    if len(centres) <= MOST_CAMERAS:
        size = SIZE * float(np.linalg.norm(high - low))
        drawn += _cameras(ax, result, size)
    plot.space.fit(ax, np.concatenate(drawn), zoom=0.85)
    _axes(ax)
    figure.legend(loc="upper right")
    decimals = 2 - np.floor(np.log10(np.max(high - low)))
    spans = "; ".join(
        f"{axis} from {' to '.join(fixed(np.array(ends), decimals))}"
        for axis, *ends in zip("XYZ", low, high)
    )
    words = (
        f"The network in space: {count(len(centres), 'projection centre')} as squares,"
        f" and {count(len(points), 'object point')} as dots. In object units {spans}."
        f" The centres lie {plain(_distance(centres, points), 3)} from the middle of"
        " the points on average; the numbers stand in the tables of photos and points."
    )
    yield figure, words


def _cameras(ax: Axes3D, result: Bundle, size: float) -> list[np.ndarray]:
    """Draw the photo plane of each photo before its centre, and write the names."""
    network, drawn = result.network, []
    for i, exterior in enumerate(result.exteriors):
        camera = result.cameras[network.camera[i]]
        own = network.xy[network.photo == i]
        form = 2 * np.abs(own).max(axis=0) / camera.c if len(own) else np.ones(2)
        width, height = np.clip(form, 0.1, 2.0)
        look: dict = {"form": (width, height), "color": plot.RED, "axes": False}
        drawn.append(plot.space.draw_camera(ax, exterior, size, **look))
    if len(result.exteriors) > MOST_NAMES:
        return drawn
    for photos in _neighbours(result.exteriors[:, :3], 0.3 * size):
        axes = [rotation.matrix(*result.exteriors[i, 3:])[2] for i in photos]
        behind = result.exteriors[photos, :3].mean(axis=0) + 0.55 * size * axes[0]
        names = ", ".join(str(network.photo_names[i]) for i in photos)
        text: dict = {"ha": "center", "va": "center", "parse_math": False}
        ax.text(*behind, names, fontsize=13, **text)
        drawn.append(behind[None])
    return drawn


def _neighbours(centres: np.ndarray, near: float) -> list[list[int]]:
    """Group stations so close together that their names would cover each other."""
    groups: list[list[int]] = []
    for i, centre in enumerate(centres):
        for group in groups:
            if np.linalg.norm(centres[group[0]] - centre) < near:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _axes(ax: Axes3D) -> None:
    """Name the axes with their unit, and keep their numbers apart."""
    for axis, pad in (("x", 16), ("y", 18), ("z", 24)):
        look = getattr(ax, f"{axis}axis")
        low, high = getattr(ax, f"get_{axis}lim")()
        widest = max(np.ptp(getattr(ax, f"get_{one}lim")()) for one in "xyz")
        look.set_major_locator(
            plt.MaxNLocator(max(2, round(5 * (high - low) / widest)))
        )
        getattr(ax, f"set_{axis}label")(
            f"{axis.upper()} (object units)", labelpad=pad, fontsize=13
        )
        ax.tick_params(axis=axis, labelsize=11, pad=5)


def _distance(centres: np.ndarray, points: np.ndarray) -> float:
    return float(np.mean(np.linalg.norm(centres - points.mean(axis=0), axis=1)))
