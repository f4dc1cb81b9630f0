"""Checks of the exercises of chapter 8, stereo plotting."""

from collections.abc import Callable

import numpy as np
import scipy

from pgm_book.common.checks import (
    CheckFailed,
    answer_of,
    call,
    chance,
    compare,
    first_slip,
    in_words,
    near,
    numbers,
    report,
    shaken,
    varied,
)
from pgm_book.program import stereo as textbook
from pgm_lab import frames
from pgm_lab._validate import real
from pgm_lab.rotation import matrix
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import NormalPair

# Column, row, window, least and greatest disparity, the true one, and 1 or a negative
SEARCHES = [
    (48, 30, 7, -6, 6, 2.3, 1),
    (60, 25, 9, 0, 12, 5.6, 1),
    (70, 33, 5, -12, 0, -7.4, 1),
    (48, 30, 7, -6, 6, 2.3, -1),
]


def scene() -> np.ndarray:
    """Smoothed noise, in which every window differs from the others."""
    noise = chance(8).normal(0, 100, (60, 120))
    return scipy.ndimage.gaussian_filter(noise, 1.2)


def model_point(function: Callable[..., object]) -> None:
    """Check the model point of a parallax."""
    fixed = [(6.0, -3.0, 12.0, 400.0, 24.0), (-1.5, 4.0, 9.5, 390.0, 24.2)]
    cases = shaken(81, fixed)

    def right(x: float, y: float, p: float, B: float, c: float) -> np.ndarray:
        return textbook.model_point(x, y, p, B, c)

    slips = {
        "the third is below the camera: it is negative": lambda x, y, p, B, c: (
            B / p * np.array([x, y, c])
        ),
        "that scale is H, the depth: photo coordinates are in mm, so it is base by"
        " parallax": lambda x, y, p, B, c: c * B / p * np.array([x, y, -c]),
        "parallax and base are exchanged: the larger the parallax, the nearer": (
            lambda x, y, p, B, c: p / B * np.array([x, y, -c])
        ),
        "the depth is right; x and y have to be scaled as well": lambda x, y, p, B, c: (
            np.array([x, y, -c * B / p])
        ),
        "that is still in the photo, in millimetres: multiply by the scale": (
            lambda x, y, p, B, c: np.array([x, y, -c])
        ),
        "x and y keep their signs": lambda x, y, p, B, c: B / p * np.array([x, -y, -c]),
        "x and y keep their signs: only the depth is reversed": lambda x, y, p, B, c: (
            B / p * np.array([-x, -y, -c])
        ),
        "x is scaled like y and −c, nothing is added to it": lambda x, y, p, B, c: (
            B / p * np.array([x, y, -c]) - (B, 0, 0)
        ),
    }
    otherwise = "the point does not lie where the two rays meet"
    call(function, *cases[0], shape=(3,), column=False)
    holds, hint = compare(function, cases, right, slips, otherwise)
    report("model_point", [("both rays meet in it", holds, hint)])


def mark(
    answer: object, pair: NormalPair, place: tuple[int, int], land: Landscape
) -> None:
    """Check the disparity at which the reader's mark stands on the ground."""
    if isinstance(answer, str):  # the same cell reckons with it
        raise CheckFailed("measured must be a number, without quotation marks")
    found = float(numbers("measured", answer, (), "one number, in pixels"))
    true = _true_disparity(pair, place, land)
    slips = [
        (
            -true if abs(true) > 2 else np.inf,
            "the sign: left column minus right column",
        ),
        (
            float(pair.object_points(*place, true)[2]),
            "that is the height: the disparity, in pixels, is asked for",
        ),
        (
            float(pair.parallax(np.float64(true))),
            "that is the parallax in mm: the disparity, in pixels, is asked for",
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
    lines, misses, slips = [], [], []
    bases = shaken(82, np.array([(390.0, 4.0, -7.0), (250.0, -60.0, 20.0)]))
    angles = shaken(83, [(0.02, -0.03, 0.05), (-0.1, 0.08, 0.4)])
    rays = shaken(84, np.array([(3.0, 4.0, -24.0), (-5.0, 2.0, -20.0)]))
    for base, turns, c in zip(bases, angles, shaken(85, (24.0, 18.0)), strict=True):
        M = matrix(*turns)
        for ray in rays:
            line = call(function, base, ray, M, c, shape=(3,))
            depth = np.array([[10.0], [25.0], [60.0]])
            u = (ray * depth - base) @ M.T
            xy = -c * u[:, :2] / u[:, 2:]
            size = np.hypot(*line[:2]) or 1e-12
            lines.append(line)
            misses.append(
                np.abs(xy @ line[:2] + line[2]).max() / size if line.any() else 1
            )
            slips.append(_slips_of_a_line(line, base, ray, M, c))
    good = max(misses) < 1e-6
    hints = [h for h in slips[0] if all(h in found for found in slips)]
    otherwise = "points of the left ray at other heights do not lie on the line"
    hint = hints[0] if hints else otherwise
    if not any(np.any(line) for line in lines):
        hint = "the line is still zero"
    report("epipolar_line", [("it holds the point at every height", good, hint)])


def _slips_of_a_line(
    line: np.ndarray, base: np.ndarray, ray: np.ndarray, M: np.ndarray, c: float
) -> list[str]:
    """Hints to the slips that give this line, up to its length."""
    normal = np.cross(base, ray)
    a, b, w = M @ normal
    s, t, q = M.T @ normal
    n, m, k = normal
    others = {
        "the sign of the third: a photo has −c there": (a, b, c * w),
        "the third is not multiplied by c yet": (a, b, -w),
        "the third, and only it, is multiplied by the −c of the photo": (a, b, w),
        "M has to rotate the normal, not its transpose": (s, t, -c * q),
        "the normal has to be rotated into the right photo by M": (n, m, -c * k),
        "base and ray are both in object space: M rotates their product": (
            *np.cross(base, M @ ray)[:2],
            -c * np.cross(base, M @ ray)[2],
        ),
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
    searches = _searches()
    found = [_search(function, *case) for case in searches]
    wanted = [_search(textbook.best_disparity, *case) for case in searches]
    positive = [_search(textbook.best_disparity, *case[:6], 1)[0] for case in searches]
    (d, r), (true, highest) = np.nan_to_num(
        [np.transpose(found), np.transpose(wanted)], nan=1e3
    )
    low = np.array([case[3] for case in searches], float)
    whole = np.round(true)
    slips = [
        (highest, "the two are exchanged: first the disparity, then its r"),
        (-true, "the sign: the disparity is left column minus right column"),
        (-whole, "the sign: the disparity is left column minus right column"),
        (whole, "those are whole pixels: add the peak of the parabola"),
        (
            true - whole,
            "that is the peak of the parabola alone: add the best whole one",
        ),
        (
            2 * whole - true,
            "the peak has the wrong sign: hand over r in the order left, middle, right,"
            " and add it",
        ),
        (
            _on_the_other_side(),
            "the right window goes to the wrong side: the disparity is left column"
            " minus right column. Which right column does d belong to?",
        ),
        (positive, "r counts with its sign: a window's negative does not fit it"),
        (true - low, "that is the index in the list of r, which begins at low"),
        (whole - low, "that is the index in the list of r, which begins at low"),
    ]
    otherwise = (
        "the disparity is not that of the highest r: each is that of the left window,"
        " which stays, with a right one"
    )
    column, row, window, *_, shift, sign = searches[0]
    ends = [
        _search(function, column, row, window, *ends, shift, sign)[0]
        for ends in ((3, 9), (-6, 2))
    ]
    good = near(d, true, 1e-6)
    report(
        "best_disparity",
        [
            ("the disparity of the highest r", good, first_slip(d, slips, otherwise)),
            (
                "its r",
                near(r, highest, 1e-6) if good else None,
                "r is not the highest of the search",
            ),
            (
                "NaN at both ends of the search",
                bool(np.isnan(ends).all()) if good else None,
                "a highest r at an end of the search is no peak: return NaN there",
            ),
        ],
    )


def _searches() -> list[tuple]:
    """The searches, or under a secret others with larger windows."""

    def drawn(rng: np.random.Generator) -> list[tuple]:
        return [
            (
                *(case[:2] + rng.integers(-3, 4, 2)).tolist(),
                case[2] + 6,
                *case[3:5],
                case[5] + rng.uniform(-0.25, 0.15),
                case[6],
            )
            for case in SEARCHES
        ]

    return varied(86, SEARCHES, drawn)


def _on_the_other_side() -> np.ndarray:
    """Disparities that a search finds which adds d to the column."""
    turned = [(*case[:3], -case[4], -case[3], *case[5:]) for case in _searches()]
    found = [-_search(textbook.best_disparity, *case)[0] for case in turned]
    return np.nan_to_num(found, nan=1e3)


def _search(function: Callable[..., object], *case: float) -> tuple[float, float]:
    """Disparity and r that a function finds in a scene that was moved."""
    column, row, window, low, high, shift, sign = case
    right = sign * scipy.ndimage.shift(scene(), (0, -shift), order=3, mode="mirror")
    with in_words(
        "Is the middle of the right window a column, which d is not, and the window as"
        " large? A slice ends before its last number"
    ):
        answer = answer_of(function, scene(), right, column, row, window, low, high)
    try:
        d, r = real(answer, "the answer").astype(float).reshape(2)
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed(
            "best_disparity must return two numbers: the disparity and r"
        ) from None
    return float(d), float(r)


def sigma_height(function: Callable[..., object]) -> None:
    """Check the standard deviation of a height."""
    fixed = [
        (1000.0, 400.0, 0.2, 0.1),
        (650.0, 300.0, 0.15, 0.4),
        (900.0, 370.0, 0.21, 0.07),
    ]
    cases = shaken(87, fixed)
    slips = {
        "base and height are exchanged": lambda H, B, g, s: B / H * g * s,
        "H enters twice: the GSD already contains it": lambda H, B, g, s: (
            H**2 / B * g * s
        ),
        "that is the error across the ray, not along it": lambda H, B, g, s: g * s,
        "the GSD is missing: the answer is in metres": (lambda H, B, g, s: H / B * s),
        "sigma_px is missing": lambda H, B, g, s: H / B * g,
        "a standard deviation is positive": lambda H, B, g, s: -H / B * g * s,
        "it is rounded: return all digits": lambda H, B, g, s: round(H / B * g * s, 2),
    }
    holds, hint = compare(
        function, cases, textbook.sigma_height, slips, "it does not follow from dZ/dp"
    )
    report("sigma_height", [("proportional to H/B", holds, hint)])


def normal_case(function: Callable[..., object]) -> None:
    """Check a photo resampled to the normal case, on a scene known in each direction.

    The function takes image, M, N, c and pixel size; M and N rotate object space into
    the photo and into the normal case, c and the size stay.
    """
    M = matrix(*shaken(88, (0.08, -0.05, 0.3)))
    N = matrix(*shaken(89, (0.03, 0.04, 0.05)))
    size, (c, pixel) = (80, 60), shaken(90, (9.0, 0.06), 0.03)
    pixels = np.stack(np.meshgrid(*map(np.arange, size)), -1)
    xy = frames.pixel_to_photo(pixels, size, pixel)

    def seen(R: np.ndarray, x_mm: np.ndarray, y_mm: np.ndarray) -> np.ndarray:
        """Grey values by their directions in object space: nothing is interpolated."""
        X, Y, Z = np.moveaxis(np.stack([x_mm, y_mm, 0 * x_mm - c], -1) @ R, -1, 0)
        return 120 + 50 * np.sin(8 * X / Z + 1) + 40 * np.cos(7 * Y / Z - 0.5 * X / Z)

    x, y = np.moveaxis(xy, -1, 0)
    arguments = (seen(M, x, y), M, N, c, pixel)
    answer = answer_of(function, *arguments)
    try:
        found = real(answer, "the answer")
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed("normal_case must return grey values") from None
    if found.shape != size[::-1]:
        raise CheckFailed(
            f"normal_case must return an image of shape {size[::-1]} here, as large as"
            f" the photo; got {found.shape}"
        )

    def rays(c: float = c, pixel: float = pixel) -> np.ndarray:
        """Rays of all pixels, row by row, in the frame of the photo."""
        xy = frames.pixel_to_photo(pixels.reshape(-1, 2), size, pixel)
        return M @ N.T @ np.insert(xy, 2, -c, 1).T

    def to(x: np.ndarray, y: np.ndarray, pixel: float = pixel) -> np.ndarray:
        """Pixels of photo coordinates, in the shape of the image."""
        there = frames.photo_to_pixel(np.column_stack([x, y]), size, pixel)
        return there.reshape(*found.shape, 2)

    U, V, W = rays()
    place = to(-c * U / W, -c * V / W)
    # Where the photo has grey values around the pixel
    inside = np.all((place > 2) & (place < np.subtract(size, 3)), axis=-1)

    def taken(pixels: np.ndarray) -> np.ndarray:
        """Grey values that the photo has at these pixels, NaN outside."""
        there = frames.pixel_to_photo(pixels, size, pixel)
        outside = np.any((pixels < 1) | (pixels > np.subtract(size, 2)), axis=-1)
        return np.where(outside, np.nan, seen(M, *np.moveaxis(there, -1, 0)))

    def typical(image: np.ndarray) -> float:
        """How far most grey values are from those that an image has."""
        off = np.abs(found - image)[inside & np.isfinite(image)]
        return float(np.median(np.nan_to_num(off, nan=1e6)))

    S = np.diag([1, -1, 1])
    right = seen(N, x, y)
    fixed = "that is for 8 and 0.02 mm: take c and pixel_size, the arguments"
    slips = [
        (arguments[0], "the image is still the photo"),
        (seen(N.T, x, y), "N rotates into the normal case; here rays come out of it"),
        (seen(N @ M, x, y), "the rays have to end in the photo: M is missing"),
        (seen(np.eye(3), x, y), "the rays begin in the normal case: N is missing"),
        (seen(N @ M @ M, x, y), "M rotates into the photo: its inverse is used here"),
        (seen(M @ N.T @ M, x, y), "M and N are exchanged"),
        (seen(N.T @ M @ M, x, y), "M and N are both transposed: it is M N^T"),
        (seen(N, x, -y), "y points up, and rows count downwards"),
        (seen(S @ N @ M.T @ S @ M, x, y), "y points up, and rows count downwards"),
        (taken(place[..., ::-1]), "rows and columns are exchanged"),
        (taken(to(-c * U / W, c * V / W)), "y points up, and rows count downwards"),
        (taken(to(c * U / W, c * V / W)), "the sign: x is −c U/W, and y is −c V/W"),
        (taken(to(U, V)), "U and V are no photo coordinates yet: x is −c U/W"),
        (taken(place + 0.5), "it is half a pixel off"),
        (taken(place - 0.5), "it is half a pixel off"),
        (
            taken(np.round(place)),
            "the nearest pixel is not near enough: interpolate between four",
        ),
        (
            np.round(right),
            "the grey values are rounded: an image may have values from 0 to 1",
        ),
        (
            np.floor(right),
            "the grey values are rounded: an image may have values from 0 to 1",
        ),
    ]
    for k, px in ((8, 0.02), (8, pixel), (c, 0.02)):  # of the task
        a, b, depth = rays(k, px)
        slips.append((taken(to(-k * a / depth, -k * b / depth, pixel=px)), fixed))
    near_by = [(typical(image), words) for image, words in slips]
    off, words = min(near_by)
    hint = "the grey values do not come from the rays' places in the photo"
    if off < 0.2:
        hint = words
    error = np.abs(found - right)[inside]
    whole = bool(np.all(found[inside] == np.round(found[inside])))
    holds = bool(np.all(error < 0.5)) and not whole
    report("normal_case", [("each ray in its place", holds, hint)])
