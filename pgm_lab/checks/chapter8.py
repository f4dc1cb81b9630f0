"""Checks of the exercises of chapter 8, stereo plotting."""

from collections.abc import Callable

import numpy as np
from scipy import ndimage

from pgm_lab.checks import (
    CheckFailed,
    answer_of,
    call,
    compare,
    first_slip,
    near,
    numbers,
    report,
)
from pgm_lab.rotation import matrix
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import NormalPair, textbook

SCENE = ndimage.gaussian_filter(np.random.default_rng(8).normal(0, 100, (60, 120)), 1.2)


def model_point(function: Callable[..., object]) -> None:
    """Check the model point of a parallax."""
    cases = [(6.0, -3.0, 12.0, 400.0, 24.0), (-1.5, 4.0, 9.5, 390.0, 24.2)]

    def right(x: float, y: float, p: float, B: float, c: float) -> np.ndarray:
        return textbook.model_point(x, y, p, B, c)

    slips = {
        "the third is below the camera: it is negative": lambda x, y, p, B, c: (
            B / p * np.array([x, y, c])
        ),
        "parallax and base are exchanged: the larger the parallax, the nearer": (
            lambda x, y, p, B, c: p / B * np.array([x, y, -c])
        ),
        "the depth is right; x and y have to be scaled as well": lambda x, y, p, B, c: (
            np.array([x, y, -c * B / p])
        ),
        "that is still in the photo, in millimetres: multiply by the scale": (
            lambda x, y, p, B, c: np.array([x, y, -c])
        ),
        "x is scaled like y and −c, nothing is added to it": lambda x, y, p, B, c: (
            B / p * np.array([x, y, -c]) - (B, 0, 0)
        ),
    }
    otherwise = "the point does not lie where the two rays meet"
    holds, hint = compare(function, cases, right, slips, otherwise)
    report("model_point", [("both rays meet in it", holds, hint)])


def mark(
    answer: object, pair: NormalPair, place: tuple[int, int], land: Landscape
) -> None:
    """Check the disparity at which the reader's mark stands on the ground."""
    found = float(numbers("measured", answer, (), "one number, in pixels"))
    true = _true_disparity(pair, place, land)
    slips = [
        (-true, "the sign: left column minus right column"),
        (
            float(pair.object_points(*place, true)[2]),
            "that is the height: the disparity, in pixels, is asked for",
        ),
    ]
    otherwise = (
        "the mark floats above the ground: the disparity is too large"
        if found > true
        else "the mark is below the ground: the disparity is too small"
    )
    hint = next((h for wrong, h in slips if abs(found - wrong) < 0.6), otherwise)
    good = abs(found - true) <= 1.0
    report("measured", [("within a pixel of the ground", good, hint)])


def _true_disparity(pair: NormalPair, place: tuple[int, int], land: Landscape) -> float:
    """Where the left ray meets what stands there: the first from above."""
    reach = pair.left.shape[1]
    tried = np.arange(-reach, reach, 0.05)
    tried = tried[pair.parallax(tried) > 0]
    points = pair.object_points(np.full(tried.shape, place[0]), place[1], tried)
    X, Y, Z = points.T
    inside = land.at(land.dsm, X[None], Y[None])[0] >= Z
    return float(tried[np.flatnonzero(inside).max()])


def epipolar_line(function: Callable[..., object]) -> None:
    """Check the epipolar line: conjugate points at all heights lie on it."""
    misses, slips = [], []
    cases = (
        (np.array([390.0, 4.0, -7.0]), matrix(0.02, -0.03, 0.05), 24.0),
        (np.array([250.0, -60.0, 20.0]), matrix(-0.1, 0.08, 0.4), 18.0),
    )
    for base, M, c in cases:
        for ray in (np.array([3.0, 4.0, -24.0]), np.array([-5.0, 2.0, -20.0])):
            line = call(function, base, ray, M, c, shape=(3,))
            depth = np.array([[10.0], [25.0], [60.0]])
            u = (ray * depth - base) @ M.T
            xy = -c * u[:, :2] / u[:, 2:]
            size = np.hypot(*line[:2])
            misses.append(np.abs(xy @ line[:2] + line[2]).max() / max(size, 1e-12))
            slips.append(_slips_of_a_line(line, base, ray, M, c))
    good = max(misses) < 1e-6
    hints = [h for h in slips[0] if all(h in found for found in slips)]
    otherwise = "points of the left ray at other heights do not lie on the line"
    hint = hints[0] if hints else otherwise
    report("epipolar_line", [("it holds the point at every height", good, hint)])


def _slips_of_a_line(line, base, ray, M, c) -> list[str]:
    normal = np.cross(base, ray)
    a, b, w = M @ normal
    s, t, q = M.T @ normal
    n, m, k = normal
    others = {
        "the sign of d: the third coordinate in the photo is −c": (a, b, c * w),
        "w is not multiplied by c yet": (a, b, -w),
        "d needs the third coordinate of the photo, −c, not w alone": (a, b, w),
        "M has to turn the normal, not its transpose": (s, t, -c * q),
        "the normal has to be turned into the right photo by M": (n, m, -c * k),
        "the line holds points of the plane: its normal is a cross product": (
            *(M @ (np.asarray(base) + ray))[:2],
            -c * (M @ (np.asarray(base) + ray))[2],
        ),
    }
    unit = line / max(np.linalg.norm(line), 1e-12)
    return [
        hint
        for hint, other in others.items()
        if abs(abs(unit @ np.array(other)) / np.linalg.norm(other) - 1) < 1e-9
    ]


def best_disparity(function: Callable[..., object]) -> None:
    """Check the search along a row."""
    cases = [
        (48, 30, 7, -6, 6, 2.3),
        (60, 25, 9, 0, 12, 5.6),
        (70, 33, 5, -12, 0, -7.4),
    ]
    found, wanted = [], []
    for column, row, window, low, high, shift in cases:
        right = ndimage.shift(SCENE, (0, -shift), order=3, mode="mirror")
        answer = answer_of(function, SCENE, right, column, row, window, low, high)
        try:
            d, r = (float(v) for v in answer)  # type: ignore[union-attr]
        except (TypeError, ValueError):
            raise CheckFailed(
                "best_disparity must return two numbers: the disparity and r"
            ) from None
        found.append((d, r))
        wanted.append(
            textbook.best_disparity(SCENE, right, column, row, window, low, high)
        )
    one, all_ = np.array(found), np.array(wanted)
    lows = np.array([case[3] for case in cases], float)
    d, true = one[:, 0], all_[:, 0]
    whole = np.round(true)
    slips = [
        (-true, "the sign: the disparity is left column minus right column"),
        (whole, "those are whole pixels: add the peak of the parabola"),
        (
            true - whole,
            "that is the peak of the parabola alone: add the best whole one",
        ),
        (2 * whole - true, "the peak of the parabola has to be added"),
        (true - lows, "that is the place in the list of r, which begins at low"),
        (whole - lows, "that is the place in the list of r, which begins at low"),
    ]
    otherwise = "the disparity is not that of the highest r along the row"
    report(
        "best_disparity",
        [
            (
                "the disparity of the highest r",
                near(d, true, 1e-6),
                first_slip(d, slips, otherwise),
            ),
            (
                "its r",
                near(one[:, 1], all_[:, 1], 1e-6),
                "r is not the highest of the search",
            ),
        ],
    )


def sigma_height(function: Callable[..., object]) -> None:
    """Check the standard deviation of a height."""
    cases = [(1000.0, 400.0, 0.2, 0.1), (650.0, 300.0, 0.15, 0.4)]
    slips = {
        "base and height are exchanged": lambda H, B, g, s: B / H * g * s,
        "H is not squared: one H is in the pixel on the ground": lambda H, B, g, s: (
            H**2 / B * g * s
        ),
        "that is in pixels of the ground, across: H/B is missing": lambda H, B, g, s: (
            g * s
        ),
        "the pixel on the ground is missing: the answer is in metres": (
            lambda H, B, g, s: H / B * s
        ),
        "sigma_px is missing": lambda H, B, g, s: H / B * g,
    }
    holds, hint = compare(
        function, cases, textbook.sigma_height, slips, "it does not follow from dZ/dp"
    )
    report("sigma_height", [("proportional to H/B", holds, hint)])


def row_points(function: Callable[..., object], pair: NormalPair) -> None:
    """Check the object points along one row."""
    row, columns = pair.left.shape[0] // 2, np.arange(180, 240, 6)
    arguments = (pair, row, columns, 9, -40, 40)
    right = textbook.row_points(*arguments)
    answer = answer_of(function, *arguments)
    found = np.asarray(answer, float)
    if found.shape != right.shape:
        raise CheckFailed(
            f"row_points must return shape {right.shape}; got {found.shape}"
        )
    known = np.isfinite(right).all(axis=1)
    station = pair.stations[0]
    slips = [
        (right - station, "the left perspective centre has to be added"),
        (
            station + (right - station) @ pair.rotation.T,
            "the model has to be turned into object space by pair.rotation",
        ),
        (
            station + (right - station) @ pair.rotation.T @ pair.rotation.T,
            "pair.rotation turns object space into the photo: the other way is needed",
        ),
    ]
    otherwise = "the points are not where the rays of the row meet"
    good = near(found[known], right[known], 1e-6)
    report(
        "row_points",
        [
            (
                "each is where its rays meet",
                good,
                first_slip(found[known], [(s[known], h) for s, h in slips], otherwise),
            ),
            (
                "NaN where r is below 0.8",
                bool(np.isnan(found[~known]).all()),
                "below 0.8, and at the end of the search, the row stays NaN",
            ),
        ],
    )
