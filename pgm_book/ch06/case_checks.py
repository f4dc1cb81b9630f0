"""Checks of the exercises of the case of chapter 6, eleven defects."""

from collections.abc import Callable, Collection

import numpy as np

from pgm_book.ch06 import published
from pgm_book.common import checks
from pgm_book.common.checks import CheckFailed, call, compare, near, report
from pgm_lab import _validate, bundle, datasets

_BEST = 20.5  # µm: sd of c from the best five of the nine photos, of 126 choices
_GOOD = 1.25 * _BEST


def largest_difference(
    photo: int | str, unknown: str, unit: str, moved_um: float
) -> None:
    """What the largest difference in Table 4.19 is, and what it does."""
    data = datasets.muliawan2013()
    difference = np.abs(data.published_exteriors - data.exteriors)
    row, column = np.unravel_index(difference.argmax(), difference.shape)
    unknowns = ("X0", "Y0", "Z0", "omega", "phi", "kappa")
    if not isinstance(unit, str) or not isinstance(unknown, str) or not unit:
        raise CheckFailed("unknown and unit must be texts, and not empty. Your turn!")
    photo = int(checks.numbers("photo", photo))
    try:
        moved_um = _validate.number(moved_um, "moved_um")
    except ValueError:
        raise CheckFailed("moved_um is not a number") from None
    if moved_um == 0:
        raise CheckFailed("moved_um is still 0. Your turn!")
    radius = 10.0  # mm
    arc = 1000 * radius * difference.max()
    slips = (
        (-arc, "a distance is wanted, not a negative number"),
        (arc / 1000, "that is in mm, µm are wanted"),
        (arc / (1000 * radius), "that is the angle itself, not the arc"),
        (np.radians(arc), "the angle was taken for degrees"),
        (np.degrees(arc), "the angle was converted to degrees"),
        (arc / radius, "that is the arc at 1 mm, not at 10 mm"),
    )
    explained = [hint for wrong, hint in slips if abs(moved_um / wrong - 1) < 0.01]
    explained.append("it is not the arc at 10 mm from the principal point")
    said = unknown.strip().casefold().replace("κ", "kappa")
    found = (photo, said) == (row + 1, unknowns[column].casefold())
    other = "another photo or another unknown has the largest |difference|"
    kind = "this is not the unit: which units does the conventions box give?"
    right, hint = abs(moved_um / arc - 1) < 0.01, f"moved_um: {explained[0]}"
    report(
        "largest difference",
        [
            ("the right photo and unknown", found, other),
            (
                "the right unit",
                unit.strip().lower() in ("rad", "radian", "radians"),
                kind,
            ),
            ("moved by dozens of micrometres", right, hint),
        ],
    )


def unit_diagonal(function: Callable) -> None:
    """A symmetric matrix brought to ones on the diagonal."""
    rng = checks.chance(65)
    matrices = []
    for n in (2, 3, 6):
        A = rng.normal(size=(2 * n, n)) * 10.0 ** rng.integers(-3, 4, n)
        matrices.append(A.T @ A)
    slips = {
        "the rows are scaled, the columns are not": lambda N: N / _roots(N)[:, None],
        "the columns are scaled, the rows are not": lambda N: N / _roots(N),
        "it divides by the diagonal, without the root": (
            lambda N: N / np.outer(np.diag(N), np.diag(N))
        ),
        "each row is divided by its diagonal element": lambda N: (
            N / np.diag(N)[:, None]
        ),
        "each column is divided by its diagonal element": lambda N: N / np.diag(N),
        "it multiplies where it should divide": (
            lambda N: N * np.outer(_roots(N), _roots(N))
        ),
        "one number scales the whole matrix": lambda N: N / np.diag(N).max(),
        "the elements off the diagonal are lost": lambda N: np.eye(len(N)),
    }
    found = call(function, matrices[0], shape=(2, 2))
    otherwise = "the elements off the diagonal are wrong"
    if not near(found, found.T):
        otherwise = "the result is not symmetric"
    if not near(np.diag(found), 1):
        otherwise = "the diagonal of the result is not 1"
    cases = [(N,) for N in matrices]
    right, hint = compare(function, cases, rescaled, slips, otherwise)
    report(
        "unit_diagonal", [("ones on the diagonal, symmetric, any units", right, hint)]
    )


def rescaled(N: np.ndarray) -> np.ndarray:
    """N with ones on its diagonal, whatever its units are: the right answer."""
    return N / np.outer(_roots(N), _roots(N))


def _roots(N: np.ndarray) -> np.ndarray:
    return np.sqrt(np.diagonal(N))


def five_photos(photos: Collection[int]) -> None:
    """Five of the nine photos that determine c well."""
    try:
        chosen = sorted({_validate.whole(number, "photos", -99) for number in photos})
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed("photos must be five numbers from 1 to 9") from None
    if len(chosen) != 5 or chosen[0] < 1 or chosen[-1] > 9:
        raise CheckFailed("photos must be five different numbers from 1 to 9")
    if chosen == [1, 2, 3, 4, 5]:
        raise CheckFailed("these are still the first five. Your turn!")
    network = published.network()
    try:
        one = bundle.adjust(network.only(np.array(chosen) - 1))
    except bundle.NetworkDefect as error:
        raise CheckFailed(f"these five leave something open: {error}") from error
    everything = bundle.adjust(network)
    sd = 1000 * one.sd_interior[0] * everything.sigma0 / one.sigma0
    hint = (
        f"c has a standard deviation of {sd:.0f} µm, {sd / _BEST:.1f} times that of the"
        " best five. From how many positions were yours taken, how far apart are they,"
        " and how is the camera rolled at each?"
    )
    nine = 1000 * everything.sd_interior[0]
    print(f"c ± {sd:.0f} µm, from all nine ± {nine:.0f} µm")
    text = "they determine c nearly as well as the best five"
    report("five photos", [(text, sd < _GOOD, hint)])
