"""Checks of where rays meet: intersection, and the base that a height asks for."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pgm_lab.checks import CheckFailed, call, first_slip, near, report


def filled(
    function: Callable[..., object], *arguments: Any, shape: tuple[int, ...]
) -> np.ndarray:
    """As `call`; says in plain words that a loop has not been filled yet."""
    name = getattr(function, "__name__", "your function")
    try:
        return call(function, *arguments, shape=shape)
    except CheckFailed as failed:
        if "at least one array" in str(failed):
            raise CheckFailed(f"{name}: there is no column yet. Your turn!") from None
        if "Singular matrix" in str(failed):
            raise CheckFailed(
                f"{name}: the matrix has no inverse. Is every ray added to it?"
            ) from None
        raise


def intersection(function: Callable) -> None:
    """Check the reader's intersection(stations, directions), which answers (3,)."""
    rng = np.random.default_rng(51)
    point = np.array([12.0, -7.0, 3.0])
    stations = point + rng.normal(0, 1, (4, 3)) * (40, 25, 5) + (0, 0, 100)
    exact = point - stations
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    long = np.array([1.0, 30.0, 200.0, 0.2])[:, None]
    skew = exact + rng.normal(0, 0.02, (4, 3))
    skew /= np.linalg.norm(skew, axis=1, keepdims=True)

    found = filled(function, stations, exact, shape=(3,))
    meets = near(found, point, 1e-6)
    slip = "" if meets else _intersection_slips(found, stations, exact)
    two = near(call(function, stations[:2], exact[:2], shape=(3,)), point, 1e-6)
    any_length = near(call(function, stations, exact * long, shape=(3,)), point, 1e-6)
    answer = call(function, stations, skew, shape=(3,))
    stretched = call(function, stations, skew * long, shape=(3,))
    least = near(answer, _nearest(stations, skew), 1e-6)
    report(
        "intersection",
        [
            (
                "rays that meet",
                meets,
                slip or "rays that meet exactly are not given their point",
            ),
            (
                "two rays are enough",
                two or bool(slip),
                "two of the rays alone give another point",
            ),
            (
                "any length",
                not meets or (any_length and near(answer, stretched, 1e-6)),
                "the length of a direction changes the point: make it a unit vector",
            ),
            (
                "least squares",
                least or bool(slip),
                "for rays that do not meet, the sum of squared distances is not least",
            ),
        ],
    )


def _intersection_slips(found: np.ndarray, stations: np.ndarray, d: np.ndarray) -> str:
    """What is wrong with a point (3,), from stations and unit vectors (n, 3)."""
    along, identity = d[:, :, None] * d[:, None, :], np.eye(3)
    P = identity - along

    def solved(matrices: np.ndarray, right_side: np.ndarray) -> np.ndarray:
        return np.linalg.lstsq(matrices.sum(axis=0), right_side, rcond=None)[0]

    def times(matrices: np.ndarray) -> np.ndarray:
        return np.einsum("nij,nj->i", matrices, stations)

    slips = [
        (
            solved(P, stations.sum(axis=0)),
            "on the right side, too, each station is multiplied by its P",
        ),
        (
            solved(P, -times(P)),
            "the sign of the right side: sort the equation once more",
        ),
        (solved(along, times(along)), "that is the part along the ray: P takes it off"),
        (
            solved(identity + along, times(identity + along)),
            "P takes the part along the ray off: look at the sign",
        ),
    ]
    number = identity - np.ones((4, 3, 3))  # d @ d is 1
    slips.append(
        (
            solved(number, times(number)),
            "that is the mean of the stations: d d^T is a 3 x 3 matrix, no number",
        )
    )
    if hint := first_slip(found, slips, ""):
        return hint
    if np.ptp(found) < 1e-6 * np.abs(found).max():  # d * d leaves (1, 1, 1) open
        return "d d^T has every element of d times every other, d * d only its own"
    way = found - stations[-1]
    if near(P[-1] @ way / np.linalg.norm(way), np.zeros(3), 1e-6):
        return "only the last ray counts: add with += to the matrix and the right side"
    return ""


def base(function: Callable) -> None:
    """Check the reader's base(height_m, c_mm, sigma_um, wanted_m) in metres."""
    cases = np.array([(1000.0, 24.0, 3.0, 0.5), (120.0, 35.0, 1.0, 0.02)])
    answers = np.array([float(call(function, *case, shape=())) for case in cases])
    height, c, sigma, wanted = cases.T
    expected = height**2 / c * np.sqrt(2) * sigma / 1000 / wanted
    ratio = answers / expected
    nearly = near(ratio, 1.0, 0.03)
    higher = float(call(function, 2000.0, 24.0, 3.0, 0.5, shape=()))
    report(
        "base",
        [
            (
                "twice as high, four times the base",
                nearly or near(higher / expected[0], 4.0 * ratio[0]),
                "twice as high, a pixel covers twice the ground, and the rays meet at"
                " half the angle",
            ),
            ("the precision is as wanted", near(ratio, 1.0), _base_slips(ratio)),
        ],
    )


def _base_slips(ratio: np.ndarray) -> str:
    """What is wrong with bases (2,), from their ratio to the right ones."""
    if near(ratio, 1.0, 0.03):
        return "nearly: do not round, neither a factor nor the base"
    if near(ratio, np.sqrt(2), 1e-6):
        return "of a difference the variances add, not the standard deviations"
    if near(ratio, 0.5, 1e-6):
        return "a difference of two coordinates is less certain than one of them"
    half = "a parallax is the difference of two coordinates: a factor is missing"
    for factor, slips in ((1.0, []), (np.sqrt(2), [half])):
        decade = np.log10(np.clip(np.abs(factor * ratio), 1e-99, 1e99))
        power = np.round(decade[0])
        if abs(power) > 9 or not near(decade, power, 1e-6):
            continue
        if power:
            size = "large" if power > 0 else "small"
            slips.append(f"your base is 10^{abs(power):.0f} times too {size}")
        if np.any(ratio < 0):
            slips.append("a length is positive: look at the sign")
        return ", and ".join(slips)
    return "the base does not follow from the height, the scale and the parallax"


def _nearest(stations: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """By projection of the rays' scales: another way than the solution's."""
    n = len(stations)
    # X - X0_i - t_i d_i = 0 for all i; unknowns X and t
    A = np.hstack([np.tile(np.eye(3), (n, 1)), np.zeros((3 * n, n))])
    for i, d in enumerate(directions):
        A[3 * i : 3 * i + 3, 3 + i] = -d
    return np.linalg.lstsq(A, stations.ravel(), rcond=None)[0][:3]
