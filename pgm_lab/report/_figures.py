"""The figures of the reports, each with the numbers that its alt text states."""

import base64
import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from pgm_lab import plot, registration, rotation
from pgm_lab._rounding import fixed, plain, round_number
from pgm_lab.bundle.result import Bundle
from pgm_lab.matching import Match
from pgm_lab.plot.basic import Look
from pgm_lab.report._tables import UM

Case = Any  # that of network.py or registration.py, which import this module
Drawn = Iterator[tuple[Figure, dict[str, Any]]]

DPI = 100
# Of a network
DENSE = 400  # rays a photo: more vectors than a small picture can show
CELLS = 12  # across the image, for means
MAX_CAMERAS = 60  # drawn with their photo planes; more would cover the points
MAX_NAMES = 30
RAYS = 41  # a side, at which their standard deviation is drawn
MAX_POINTS = 5000  # a picture shows no more of them
CAMERA_SIZE = 0.12  # in diameters of the network
# Of a matching and of a registration
LINES = 12  # that join matches
PART = 80  # pixels across what the overlay shows


def png(figure: Figure) -> str:
    """Return a figure as PNG in base64, and close it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, metadata={"Software": None})
    plt.close(figure)
    return base64.b64encode(buffer.getvalue()).decode()


def _drawer(*kinds: Callable[..., Drawn], **given: Any) -> Callable[[str], list]:
    """Return a function that draws the figures of a name, that of a function."""
    named = {kind.__name__: kind for kind in kinds}

    def draw(name: str) -> list[tuple[str, dict[str, Any]]]:
        with plt.rc_context(plot.STYLE):
            return [(png(figure), shown) for figure, shown in named[name](**given)]

    return draw


# --- A network ---


def of_network(case: Case) -> Callable[[str], list]:
    """Return what draws the figures of network.j2."""
    return _drawer(residuals, lens, precision, stations, case=case)


def residuals(case: Case) -> Drawn:
    """Residual vectors of the photos, or their means where they would be a blot."""
    result, network = case.result, case.network
    if len(network.xy) > DENSE * len(network.exteriors):
        yield mean_residuals(result)
        return
    rms = UM * np.sqrt(np.mean(result.residuals**2))
    shown = {"single": True, "rms": rms, "suspects": len(case.suspects)}
    yield plot.bundle.residual_vectors(result), shown


def mean_residuals(result: Bundle) -> tuple[Figure, dict[str, Any]]:
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
    shown = {"single": False, "cells": np.sum(filled)}
    return figure, shown | {"largest": length.max(), "beyond": np.sum(beyond)}


def lens(case: Case) -> Drawn:
    """Radial distortion of each camera with its confidence band."""
    result = case.result
    for number, camera in enumerate(result.cameras):
        own = result.network.camera[result.network.photo] == number
        if np.any(own) and np.any(camera.interior[3:6]):
            of_camera = f" of camera {number + 1}" if len(result.cameras) > 1 else ""
            curve = plot.bundle.lens_curve(result, camera=number)
            yield curve, {"of_camera": of_camera}


def precision(case: Case) -> Drawn:
    """Where points are precise: in the coordinate plane in which they spread most."""
    result, points = case.result, case.result.points
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
    ends = {"least": np.min(largest), "largest": np.max(largest)}
    yield figure, {"plane": "".join(names), "worst": worst_names, **ends}


def stations(case: Case) -> Drawn:
    """Stations and points in space, the last step of Muliawan's program."""
    result = case.result
    centres, points = result.exteriors[:, :3], result.points
    everything = np.concatenate([centres, points])
    low, high = everything.min(axis=0), everything.max(axis=0)
    figure = plt.figure(figsize=(10, 8))
    ax = plot.space.space(figure)
    ax.set_axis_on()
    shown = points[:: -(-len(points) // MAX_POINTS)]
    ax.scatter(*shown.T, s=14, color=plot.BLUE, label="object points", depthshade=False)
    look: dict = {"color": plot.RED, "label": "projection centres", "marker": "s"}
    ax.scatter(*centres.T, s=30, depthshade=False, **look)
    drawn = [everything]
    if len(centres) <= MAX_CAMERAS:
        size = CAMERA_SIZE * float(np.linalg.norm(high - low))
        drawn += _cameras(ax, result, size)
    plot.space.fit(ax, np.concatenate(drawn), zoom=0.85)
    _axes(ax)
    figure.legend(loc="upper right")
    decimals = 2 - np.floor(np.log10(np.max(high - low)))
    spans = "; ".join(
        f"{axis} from {' to '.join(fixed(np.array(ends), decimals))}"
        for axis, *ends in zip("XYZ", low, high)
    )
    distance = np.linalg.norm(centres - points.mean(axis=0), axis=1)
    numbers = {"stations": len(centres), "points": len(points)}
    yield figure, numbers | {"spans": spans, "distance": np.mean(distance)}


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
    if len(result.exteriors) > MAX_NAMES:
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


# --- A calibration ---


def of_calibration(case: Case) -> Callable[[str], list]:
    """Return what draws the figures of calibration.j2."""
    return _drawer(coverage, lens, residuals, stations, board, case=case)


def coverage(case: Case) -> Drawn:
    """The corners of all photos in the image, over how well a ray is known there."""
    found = case.found
    columns, rows = found.image_size
    axes = [np.linspace(0, n - 1, RAYS) for n in (columns, rows)]
    grid = np.stack(np.meshgrid(*axes), axis=-1)
    sd = found.ray_sd(grid.reshape(-1, 2)).reshape(RAYS, RAYS)
    figure, ax = plt.subplots(figsize=(9, 6.5))
    drawn = ax.contourf(*axes, np.log10(sd), levels=12, cmap="cividis_r")
    bar = figure.colorbar(drawn, label="sd of a ray (px)")
    ticks = list(bar.get_ticks()[::2])
    bar.set_ticks(ticks, labels=[plain(10**t) for t in ticks])
    pixels = np.concatenate([one.pixels for one in found.photos])
    ax.plot(*pixels.T, ".", color=plot.RED, markersize=3)
    ax.set(xlabel="column (px)", ylabel="row (px)", aspect="equal")
    ax.set(xlim=(0, columns - 1), ylim=(rows - 1, 0))
    shown = {"corners": len(pixels), "least": float(sd.min())}
    yield figure, shown | {"largest": float(sd.max())}


def board(case: Case) -> Drawn:
    """How the board is bent."""
    found = case.found
    if np.any(found.sd_shape > 0):
        points = found.printed
        (x, y), height = points[:, :2].T, found.shape[:, 2]
        high = np.abs(height).max()
        longest = np.hypot(*found.shape[:, :2].T).max()
        magnify = round_number(0.08 * np.ptp(points[:, :2], axis=0).max() / longest)
        figure, ax = plt.subplots(figsize=(9, 6.5))
        look: Look = {"cmap": "RdBu_r", "vmin": -high, "vmax": high}
        marks = ax.scatter(x, y, 130, height, edgecolors=plot.BLACK, **look)
        arrows = (magnify * found.shape[:, :2]).T
        look = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.004}
        ax.quiver(x, y, *arrows, **look)
        ax.set(aspect="equal", xlabel="X (mm)", ylabel="Y (mm)")
        ax.margins(0.1)
        figure.colorbar(marks, label="height off the plane (mm)", shrink=0.7)
        ends = {"low": float(height.min()), "high": float(height.max())}
        yield figure, {"magnify": float(magnify), **ends}


# --- A matching ---


def of_matching(
    found: Match, left: Any, right: Any, threshold: float | None
) -> Callable[[str], list]:
    """Return what draws the figures of matching.j2."""

    def photos() -> Drawn:
        yield plot.matches.side_by_side(left, right, found, LINES), {}

    def histograms() -> Drawn:
        yield plot.matches.histograms(found, threshold), {"threshold": threshold}

    def parallaxes() -> Drawn:
        length = np.hypot(*plot.matches.affine_residuals(found).T)
        shown = {"median": float(np.median(length)), "longest": float(length.max())}
        yield plot.matches.parallaxes(left, found), shown

    return _drawer(photos, histograms, parallaxes)


# --- A registration ---


def of_registration(case: Case) -> Callable[[str], list]:
    """Return what draws the figures of registration.j2."""
    return _drawer(overlay, shifts, scatter, similarity, case=case)


def overlay(case: Case) -> Drawn:
    """A part of both images, laid over each other before and after."""
    first, last = _part(case)
    size = last - first
    shape = int(size[1]), int(size[0])
    reference = case.reference.values[first[1] : last[1], first[0] : last[0]]
    images = {"before": _before(case, first, shape)}
    if case.model is not None and case.agrees:
        # The same model, in the pixels of this part
        moved = {"centre": case.model.centre - first}
        of_part = replace(case.model, offset=case.model.offset + first, **moved)
        title = f"after, by the model: {case.model.kind}"
        images[title] = registration.resample(case.sensed.values, of_part, shape)
    yield plot.registration.fringes(reference, images, first), {}


def _part(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """First and last (column, row) of the part around the most precise point."""
    sd = np.where(case.found.accepted, case.found.sd, np.inf)
    middle = np.array(case.size) / 2
    if case.asked["refine"] is None:  # all alike: the one in the middle
        away = np.hypot(*(case.found.points - middle).T)
        sd = np.where(case.found.accepted, away, np.inf)
    at = case.found.points[np.argmin(sd)] if np.isfinite(sd).any() else middle
    size = np.minimum(PART, case.size)
    first = np.clip(np.round(at - size / 2), 0, case.size - size).astype(int)
    return first, first + size


def _before(case: Case, first: np.ndarray, shape: tuple[int, int]) -> np.ma.MaskedArray:
    """The sensed image in the pixels of a part, moved by whole pixels only."""
    start = first + np.round(case.offset).astype(int)
    rows, columns = shape
    inside = np.ma.masked_all(shape, float)
    left, top = np.maximum(-start, 0)
    found = case.sensed.values[
        max(start[1], 0) : max(start[1] + rows, 0),
        max(start[0], 0) : max(start[0] + columns, 0),
    ]
    inside[top : top + found.shape[0], left : left + found.shape[1]] = found
    return inside


def shifts(case: Case) -> Drawn:
    """The shifts as arrows, and what the model leaves of them."""
    if not np.any(case.found.accepted):
        return
    say = case.label
    grey = case.reference.values
    yield plot.registration.shifts(grey, case.found, say=say), {"left": None}
    if case.model is not None and len(case.found.points) > 2:
        left = np.hypot(*case.errors[case.found.accepted].T)
        title = f"Shifts minus the model: {case.model.kind}"
        arrows = -case.errors
        yield (
            plot.registration.shifts(grey, case.found, arrows, title, say=say),
            {"left": float(np.median(left)), "longest": float(left.max())},
        )


def scatter(case: Case) -> Drawn:
    """The shifts as points of the search window."""
    errors = None if case.model is None else -case.errors  # observed less computed
    yield plot.registration.scatter(case.found, case.radius, errors), {}


def similarity(case: Case) -> Drawn:
    """Errors over r, and over the predicted sd."""
    yield plot.registration.similarity(case.found, case.errors), {}
