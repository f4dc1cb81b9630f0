"""Checks of the exercises in the case of chapter 8, the three locations."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    first_slip,
    near,
    numbers,
    report,
)
from pgm_lab import datasets
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import NormalPair

REACH = 60  # px, how far from zero a disparity of these photos can be
GOOD = 1.5  # px, how well a mark is set by eye on enlarged pixels


def weighted(answer: object) -> None:
    """Check the means of all 175 points, interactive and automatic."""
    form = "two numbers, interactive and automatic"
    found = numbers("weighted", answer, (2,), form)
    data = datasets.harintaka2020()
    both = np.stack([data.interactive, data.automatic])
    right = both @ data.test_points / data.test_points.sum()
    slips = [
        (both.mean(axis=1), "a location with more points counts more: use the numbers"),
        (both @ data.test_points, "divide the sum by the number of all points"),
        (both @ data.test_points / 3, "divide by the points, not by the locations"),
        (right[::-1], "the two are exchanged"),
    ]
    otherwise = "each mean counts as often as it has points"
    hint = next((h for wrong, h in slips if np.allclose(found, wrong, atol=0.006)), "")
    good = bool(np.all(np.abs(found - right) < 0.006))
    report("weighted", [("the means of all 175 points", good, hint or otherwise)])


def marks(answer: object, pair: NormalPair, places: ArrayLike, land: Landscape) -> None:
    """Check the reader's disparities, and say what they mean in metres.

    Parameters
    ----------
    answer : array_like (n,)
        Disparities in px.
    pair : NormalPair
        The photos.
    places : array_like (n, 2)
        (column, row) of the left marks.
    land : Landscape
        The truth.
    """
    at = np.asarray(places)
    found = numbers("mine", answer, (len(at),), f"{len(at)} disparities, in pixels")
    true = np.array([_on_the_ground(pair, place, land) for place in at])
    off = found - true
    if np.all(np.abs(found + true) < GOOD) and np.any(np.abs(off) > GOOD):
        raise CheckFailed("mine: the sign is lost; read the scale with its minus")
    several = bool(np.ptp(found) > 0)  # the same everywhere is no measurement
    said = []
    for name, place, d, e in zip("ABCD", at, found, off):
        metres = float(
            np.diff(pair.object_points(place[0], place[1], [d - e, d])[:, 2])[0]
        )
        side = "above" if metres > 0 else "below"
        print(
            f"{name}: the mark is {abs(metres):.2f} m {side} the ground ({e:+.1f} px)"
        )
        hint = f"{abs(e):.0f} pixels too {'large' if e > 0 else 'small'}; look again"
        holds = along_with(bool(abs(e) <= GOOD), several)
        said.append((f"{name} on the ground", holds, hint))
    report("mine", said)


def fewer(answer: object) -> None:
    """Check how many times fewer positions a line has than a square, for 30 pixels."""
    found = float(numbers("fewer", answer, (), "one number"))
    slips = [
        (30, "the search goes to both sides, and the centre is a position as well"),
        (60, "the centre is a position as well"),
        (61**2, "that is the number of positions in the square"),
        (1 / 61, "the other way round: the square over the line"),
        (49 * 61, "the window is the same in both: it cancels"),
    ]
    hint = first_slip(found, slips, "count the positions in the square and on the line")
    report("fewer", [("square over line", near(found, 61, 1e-6), hint)])


def _on_the_ground(pair: NormalPair, place: np.ndarray, land: Landscape) -> float:
    """Disparity at which the ray of a left pixel meets the ground."""
    tried = np.arange(-REACH, REACH, 0.02)
    X, Y, Z = pair.object_points(place[0], place[1], tried).T
    return float(tried[np.abs(Z - land.at(land.dtm, X, Y)).argmin()])
