"""The figures of a registration, each with what it shows in words."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_lab import plot, registration
from pgm_lab._rounding import plain
from pgm_lab.report._figures import png
from pgm_lab.report._layout import count
from pgm_lab.report._registration_case import Case, say
from pgm_lab.report._statuses import lost

PART = 80  # pixels across what the overlay shows


def pictures(name: str, case: Case) -> list[tuple[str, str]]:
    """Return the figures of one kind: PNGs in base64, and what they show."""
    kinds: dict[str, Callable[[Case], Iterator[tuple[Figure, str]]]] = {
        "overlay": _overlay,
        "shifts": _shifts,
        "scatter": _scatter,
        "similarity": _similarity,
    }
    with plt.rc_context(plot.STYLE):
        return [(png(figure), words) for figure, words in kinds[name](case)]


def _overlay(case: Case) -> Iterator[tuple[Figure, str]]:
    """A part of both images, laid over each other before and after."""
    first, last = _part(case)
    size = last - first
    shape = int(size[1]), int(size[0])
    reference = case.reference.values[first[1] : last[1], first[0] : last[0]]
    images = {"before": _before(case, first, shape)}
    words = (
        "A part of both images in two colours: the reference image in green, the"
        " sensed one in magenta, grey where they agree"
    )
    if case.agrees:
        shift = plain(float(np.hypot(*case.shift)))
        words += (
            f". Before, a shift of {shift} px makes coloured fringes along the edges"
        )
    if case.model is not None and case.agrees:
        # The same model, in the pixels of this part
        of_part = replace(
            case.model,
            centre=case.model.centre - first,
            offset=case.model.offset + first,
        )
        title = f"after, by the model: {case.model.kind}"
        images[title] = registration.resample(case.sensed.values, of_part, shape)
        words += "; after resampling by the model, what is left of them is change"
    yield plot.registration.fringes(reference, images, first), f"{words}."


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


def _shifts(case: Case) -> Iterator[tuple[Figure, str]]:
    if not np.any(case.found.accepted):
        return
    a = case.found.accuracy
    words = (
        "The reference image with an arrow at each accepted point, magnified: its shift"
        f" in the sensed image. The median is {plain(a.median_x, 3)} columns and"
        f" {plain(a.median_y, 3)} rows."
    )
    if reasons := lost(case.found):
        others = ", ".join(f"{say(status)} ({number})" for status, number in reasons)
        words += f" Marks show the other points, by reason: {others}."
    yield plot.registration.shifts(case.reference.values, case.found, say=say), words
    if case.model is not None and len(case.found.points) > 2:
        left = np.hypot(*case.errors[case.found.accepted].T)
        words = (
            "The same with what the model leaves of each shift. Half of the arrows are"
            f" shorter than {plain(float(np.median(left)))} px, the longest is"
            f" {plain(float(left.max()))} px. If neighbours point the same way, the"
            " model is too simple there."
        )
        title = f"Shifts less the model: {case.model.kind}"
        figure = plot.registration.shifts(
            case.reference.values, case.found, -case.errors, title, say=say
        )
        yield figure, words


def _scatter(case: Case) -> Iterator[tuple[Figure, str]]:
    a = case.found.accuracy
    off = "their mean" if case.model is None else "the model"
    words = (
        "The accepted shifts as points, dx to the right and dy down. To the left in the"
        f" search window, with the circle of CE90 about zero, {plain(a.ce90)} px: it"
        f" holds nine tenths of them. To the right how far each is off {off}, with the"
        " ellipse that nine tenths should lie in as predicted, and with that of the"
        " shifts."
    )
    errors = None if case.model is None else -case.errors  # observed less computed
    yield plot.registration.scatter(case.found, case.radius, errors), words


def _similarity(case: Case) -> Iterator[tuple[Figure, str]]:
    off = "their median" if case.model is None else "the model"
    points = count(int(np.sum(case.found.accepted)), "accepted point")
    words = (
        f"How far {points} are off {off}: over their r, and over their predicted"
        " standard deviation, with the line that nine tenths should lie below."
    )
    yield plot.registration.similarity(case.found, case.errors), words
