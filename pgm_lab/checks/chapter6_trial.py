"""Checks of exercises 6.4 to 6.6: a published number, a scaled matrix, five photos."""

from collections.abc import Callable, Collection

import numpy as np

from pgm_lab import bundle, datasets
from pgm_lab.checks import CheckFailed, call, near, report

_RADIUS = 10.0  # mm
_BEST = 20.5  # µm: sd of c from the best five of the nine photos, of 126 choices
_GOOD = 1.25 * _BEST


network_of = bundle.published.network


def rescaled(N: np.ndarray) -> np.ndarray:
    """N with ones on its diagonal, whatever its units are."""
    s = 1 / np.sqrt(np.diagonal(N))
    return N * s * s[:, None]


def largest_difference(photo: int, unknown: str, unit: str, moved_um: float) -> None:
    """Exercise 6.4: what the largest difference in Table 4.19 is, and what it does."""
    data = datasets.muliawan2013()
    difference = np.abs(data.published_exteriors - data.exteriors)
    row, column = np.unravel_index(difference.argmax(), difference.shape)
    unknowns = ("X0", "Y0", "Z0", "omega", "phi", "kappa")
    if not unit:
        raise CheckFailed("the unit is still empty. Your turn!")
    if not isinstance(moved_um, int | float | np.number) or not np.isfinite(moved_um):
        raise CheckFailed("moved_um is not a number")
    if moved_um == 0:
        raise CheckFailed("moved_um is still 0. Your turn!")
    arc = 1000 * _RADIUS * difference.max()
    slips = (
        (-arc, "a distance is wanted, not a negative number"),
        (arc / 1000, "that is in mm, µm are wanted"),
        (arc / (1000 * _RADIUS), "that is the angle itself, not the arc"),
        (np.radians(arc), "the angle was taken for degrees"),
        (np.degrees(arc), "the angle was converted to degrees"),
        (arc / _RADIUS, "that is the arc at 1 mm, not at 10 mm"),
    )
    explained = [hint for wrong, hint in slips if abs(moved_um / wrong - 1) < 0.01]
    explained.append("it is not the arc at 10 mm from the principal point")
    properties = [
        (
            "the right photo and unknown",
            (photo, unknown) == (row + 1, unknowns[column]),
            "another photo or another unknown has the largest |difference|",
        ),
        (
            "the right unit",
            unit in ("rad", "radian", "radians"),
            "this is not the unit: what kind of quantity is it, and what does the"
            " conventions box say of it?",
        ),
        (
            "moved by dozens of micrometres",
            abs(moved_um / arc - 1) < 0.01,
            f"moved_um: {explained[0]}",
        ),
    ]
    report("largest difference", properties)


def unit_diagonal(function: Callable) -> None:
    """Exercise 6.5: a symmetric matrix brought to ones on the diagonal."""
    rng = np.random.default_rng(65)
    hints = []
    for n in (2, 3, 6):
        A = rng.normal(size=(2 * n, n)) * 10.0 ** rng.integers(-3, 4, n)
        N = A.T @ A
        found, d = call(function, N, shape=(n, n)), np.diag(N)
        symmetric = near(found, found.T)
        slips = (
            (N / np.sqrt(d)[:, None], "the rows are scaled, the columns are not"),
            (N / np.sqrt(d), "the columns are scaled, the rows are not"),
            (N / np.outer(d, d), "it divides by the diagonal, without the root"),
            (N / d[:, None], "each row is divided by its diagonal element"),
            (N / d, "each column is divided by its diagonal element"),
            (N * np.sqrt(np.outer(d, d)), "it multiplies where it should divide"),
            (N / d.max(), "one number scales the whole matrix"),
            (np.eye(n), "the elements beside the diagonal are lost"),
        )
        if not near(found, rescaled(N)):
            otherwise = "the elements beside the diagonal are wrong"
            if not symmetric:
                otherwise = "the result is not symmetric"
            if not near(np.diag(found), 1):
                otherwise = "the diagonal of the result is not 1"
            explained = [h for wrong, h in slips if np.allclose(found, wrong)]
            hints += explained[:1] or [otherwise]
    report(
        "unit_diagonal",
        [("ones on the diagonal, symmetric, any units", not hints, (*hints, "")[0])],
    )


def five_photos(photos: Collection[int]) -> None:
    """Exercise 6.6: five of the nine photos that determine c well."""
    try:
        chosen = sorted({int(number) for number in photos})
    except (TypeError, ValueError) as error:
        raise CheckFailed("photos must be five numbers from 1 to 9") from error
    if len(chosen) != 5 or chosen[0] < 1 or chosen[-1] > 9:
        raise CheckFailed("photos must be five different numbers from 1 to 9")
    if chosen == [1, 2, 3, 4, 5]:
        raise CheckFailed("these are still the first five. Your turn!")
    try:
        one = bundle.adjust(network_of(chosen))
    except bundle.NetworkDefect as error:
        raise CheckFailed(f"these five leave something open: {error}") from error
    everything = bundle.adjust(network_of(range(1, 10)))
    sd = 1000 * one.sd_interior[0] * everything.sigma0 / one.sigma0
    hint = (
        f"c has a standard deviation of {sd:.0f} µm, {sd / _BEST:.1f} times that of the"
        " best five. From how many places do yours look, how far apart are these, and"
        " how is the camera rolled at each?"
    )
    text = f"c ± {sd:.0f} µm, from all nine ± {1000 * everything.sd_interior[0]:.0f} µm"
    report("five photos", [(text, sd < _GOOD, hint)])
