"""Checks of the exercises of chapter 2, normalized cross correlation, and its case."""

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    call,
    chance,
    first_slip,
    in_words,
    near,
    numbers,
    report,
    shaken,
    varied,
)

FIVE = np.array(  # Bani 2010, figure 2.8
    [
        [128, 137, 140, 146, 129],
        [100, 114, 121, 119, 110],
        [110, 111, 98, 71, 64],
        [117, 109, 93, 64, 63],
        [126, 110, 96, 78, 80],
    ]
)
# Width of a template, and its place in the left and in the right photo
_SEARCHES = [
    (19, (332, 1063), (268, 1049)),
    (21, (100, 200), (112, 170)),
    (11, (50, 60), (50, 60)),
    (7, (40, 80), (57, 81)),
    (15, (60, 40), (55, 70)),
]
# A map in single precision is right, such as that of OpenCV: on 300 hidden inputs it is
# off by up to 2.5e-6, and two of them differ by twice that.
SINGLE = 1e-5


def _r(a: np.ndarray, b: np.ndarray, centred: bool = True) -> float:
    """Correlation, or the cosine of the grey values as they are."""
    a, b = (g - g.mean() * centred for g in (a.astype(float), b.astype(float)))
    return float(np.sum(a * b) / np.sqrt(np.sum(a * a) * np.sum(b * b)))


def correlation(function: Callable[[np.ndarray, np.ndarray], object]) -> None:
    """Check the correlation of two windows, as a function of the reader's own."""
    rng = chance(25)
    a = rng.integers(20, 200, (6, 4)).astype(float)
    other = rng.integers(20, 200, (6, 4)) + 0.5 * a
    with in_words("Multiply pixel by pixel, with *; np.sum adds all pixels"):
        found = np.array([call(function, a, b, shape=()) for b in (other, -other)])
    line = np.array(
        [call(function, a, gain * a + 40, shape=()) for gain in (0.6, -0.6)]
    )
    right = _r(a, other) * np.array([1, -1])
    x, y = a - a.mean(), other - other.mean()
    signs = np.array([1, -1])
    n = a.size
    common = [(a - m, b - m) for b in (other, -other) for m in ((a + b).mean() / 2,)]
    slips = [
        (
            [_r(a, b, centred=False) for b in (other, -other)],
            "subtract the mean of each window first",
        ),
        (right**2, "that is r squared"),
        (np.abs(right), "r has a sign: it is negative where one is a negative"),
        (signs * np.sum(x * y), "divide by the lengths of the two vectors"),
        (signs * np.mean(x * y), "divide by the lengths of the two vectors"),
        (
            signs * np.sum(x * y) / (np.sum(x * x) * np.sum(y * y)),
            "those are squares of the lengths: a root is missing",
        ),
        (
            signs * np.sum(x * y) / np.sqrt(np.sum(x * x * y * y)),
            "each vector has a length of its own: two sums, then their product",
        ),
        (right * (n - 1) / n, "a sum over n is divided by one over n − 1, or reversed"),
        (right * n / (n - 1), "a sum over n is divided by one over n − 1, or reversed"),
        (right * n, "one of the two is a mean, the other a sum"),
        (right / n, "one of the two is a mean, the other a sum"),
        (
            [_r(*both, centred=False) for both in common],
            "each window has a mean of its own",
        ),
        (
            [_r(a - a.mean(0), b - b.mean(0), False) for b in (other, -other)],
            "the mean is that of all pixels of a window, not of each column",
        ),
    ]
    slips += [
        (-right, "the sign is reversed"),
        (np.arccos(right), "that is the angle; r is its cosine"),
        (np.degrees(np.arccos(right)), "that is the angle; r is its cosine"),
        *rounded(found, right),
    ]
    hint = first_slip(found, slips, "it is not the cosine of the two centred windows")
    report(
        "correlation",
        [
            ("the cosine of the centred windows", near(found, right, 1e-9), hint),
            (
                "a gain and an offset change at most its sign",
                near(line, [1, -1], 1e-9),
                "a window and its copy with a gain and an offset must give 1 or −1",
            ),
        ],
    )


def shifted(answer: object) -> None:
    """Check r between the first four and the last four columns of figure 2.8."""
    value = numbers("shifted", answer)
    left, right = FIVE[:, :-1], FIVE[:, 1:]
    r = _r(left, right)
    a, b = left - left.mean(), right - right.mean()
    both = np.std(FIVE) ** 2 * 20  # the contrast of all 25 in place of the windows'
    all_25 = FIVE - FIVE.mean()
    no_root = np.sum(a * b) / (np.sum(a * a) * np.sum(b * b))
    slips = [
        (1.0, "those are two equal windows: take different columns"),
        (_r(left, right, centred=False), "subtract the mean of each window first"),
        (_r(FIVE[:-1], FIVE[1:]), "you dropped rows: columns are the second index"),
        (r**2, "that is r squared"),
        (np.sum(a * b), "divide by the root"),
        (np.sum(a * b) / both, "each window has its own contrast"),
        (
            _r(all_25[:, :-1], all_25[:, 1:], centred=False),
            "you subtracted the mean of all 25: each window of 20 has its own",
        ),
    ]
    otherwise = "it does not follow from (B 2.6f) with the two windows of 5 x 4"
    if np.isclose(value, no_root, rtol=1e-3, atol=0):
        otherwise = "a square root is missing in the denominator"
    hint = first_slip(value, slips, otherwise, tolerance=1e-3)
    report("shifted", [("agrees with (B 2.6f)", near(value, r, 1e-3), hint)])


def line(function: Callable[[np.ndarray, np.ndarray], object]) -> None:
    """Check a function that gives offset and gain of y = alpha + beta x."""
    rng = chance(206)
    x = rng.uniform(20, 200, (3, 7))
    offset, gain = shaken(207, (12.5, 0.7))
    with in_words("alpha is one number: take the means"):
        exact = call(function, x, offset + gain * x, shape=(2,))
    y = 30 + 0.8 * x + rng.normal(0, 9, x.shape)
    found = call(function, x, y, shape=(2,))
    beta, alpha = np.polyfit(x.ravel(), y.ravel(), 1)
    back, _ = np.polyfit(y.ravel(), x.ravel(), 1)
    slips: list[tuple[ArrayLike, str]] = [
        (
            (-beta * x.mean(), beta),
            "the mean of y is missing",
        ),
        ((beta, alpha), "the gain comes last: return alpha, beta"),
        ((y.mean() - x.mean(), beta), "the mean of x has to be multiplied by the gain"),
        ((y.mean() + beta * x.mean(), beta), "look at the sign of the second term"),
        ((y.sum() - beta * x.sum(), beta), "those are sums; take means"),
        ((y.sum() - beta * x.mean(), beta), "the sum over y is not its mean"),
        ((y.mean() - beta * x.sum(), beta), "the sum over x is not its mean"),
        (
            (y[0].mean() - beta * x[0].mean(), beta),
            "the means are those of all pixels, not of the first row",
        ),
        ((x.mean() - beta * y.mean(), beta), "x and y are exchanged"),
        ((x.mean() - back * y.mean(), back), "x and y are exchanged"),
        ((round(alpha), beta), "it is right, but rounded: return all its digits"),
        *rounded(found, np.array([alpha, beta])),
        *(((found[0], beta), hint) for _, hint in rounded(found[0], alpha)),
    ]
    otherwise = "the line does not go through the mean of all points"
    if near(found[0] + found[1] * x.mean(), y.mean()):
        otherwise = "it goes through the mean of all points, but with another gain"
    hint = first_slip(found, slips, otherwise)
    good = near(found, (alpha, beta), 1e-8)
    report(
        "line",
        [
            (
                "exact where y is a line of x",
                near(exact, (offset, gain)),
                "a line without errors is not recovered",
            ),
            ("least squares where it is not", good, hint),
        ],
    )


def peak_of_parabola(function: Callable[[float, float, float], object]) -> None:
    """Check a function that gives the top of a parabola through three values."""
    fixed = np.array([(0.1, 0.3, 0.02), (0.41237, -0.25314, 0.09721)])
    curvature, top = shaken(208, fixed)
    height, side = shaken(209, (0.9, 0.5))

    def values(at: float) -> np.ndarray:
        return height - curvature * (at - top) ** 2

    before, summit, after = values(-1.0), values(0.0), values(1.0)
    found = np.array(
        [
            call(function, float(a), float(b), float(c), shape=())
            for a, b, c in zip(before, summit, after, strict=True)
        ]
    )
    even = call(function, side, height, side, shape=())
    slips = [
        (-top, "the sign: the top lies on the side of the higher neighbour"),
        (2 * top, "it is twice as far: a factor of two is missing below"),
        (-2 * top, "the sign, and a factor of two"),
        (top / 2, "it is half as far: one factor of two too many"),
        (
            (before - after) / (2 * (before - summit + after)),
            "the summit counts twice in the curvature",
        ),
        ((before - after) / 2, "that is the slope: how strongly is it curved?"),
        ((after - before) / 2, "that is the slope: how strongly is it curved?"),
        (top + 1, "count from the middle value, not from the one before"),
        (height + 0 * top, "that is how high the top is; where does it lie?"),
        *rounded(found, top),
    ]
    hint = first_slip(found, slips, "the top of an exact parabola is not found")
    report(
        "peak_of_parabola",
        [
            (
                "equal neighbours give 0",
                near(even, 0.0),
                "equal neighbours must give 0",
            ),
            ("exact for parabolas", near(found, top), hint),
        ],
    )


# --- Checks of the search of chapter 2: a map of r, and how wide it must be ---


def rounded(found: np.ndarray, right: np.ndarray) -> list[tuple[np.ndarray, str]]:
    """The slip of an answer that is right to some digits, if it is one."""
    near_enough = near(found, right, 1e-6) or any(
        near(found, np.round(right, k), 1e-9) for k in range(1, 7)
    )
    hint = "it is right, but rounded: return all its digits, as float64 does"
    return [(found, hint)] if near_enough else []


def correlation_map(function: Callable[[np.ndarray, np.ndarray], object]) -> None:
    """Check a correlation map of the reader's own."""
    rng = chance(26)
    search = rng.integers(0, 256, (9, 12)).astype(float)
    row, column = varied(27, (2, 6), lambda rng: tuple(rng.integers(1, 6, 2).tolist()))
    template = search[row : row + 3, column : column + 5].copy()
    expected = map_of(template, search)
    with in_words("Is each part as large as the template, its top left search[i, j]?"):
        found = call(function, template, search, shape=expected.shape, single=True)
    if not np.any(found):
        raise CheckFailed("correlation_map: the map is still all zeros. Your turn!")
    gained = call(
        function, 0.5 * template + 60, search, shape=expected.shape, single=True
    )
    i, j = np.indices(expected.shape)
    last = np.subtract(expected.shape, 1)
    short = "a last row or column is still 0: the number of places is one larger"
    t = template - template.mean()
    w = sliding_window_view(search - search.mean(), template.shape)
    whole = np.einsum("ijkl,kl->ij", w, t)
    whole = whole / np.sqrt(np.einsum("ijkl,ijkl->ij", w, w) * np.sum(t * t))
    w = w - w.mean(axis=(2, 3), keepdims=True)
    one_sum = np.sum(w * t, axis=(2, 3)) / np.sqrt(np.sum(w**2 * t**2, axis=(2, 3)))
    slips = [
        (map_of(template, search, centred=False), "subtract the mean from each window"),
        (map_of(template, search, divided=False), "divide by the two contrasts"),
        (expected**2, "that is r squared"),
        (-expected, "the sign is reversed"),
        (
            whole,
            "subtract the mean of each window, not that of the whole search window",
        ),
        (one_sum, "sum the squares of each window first, and multiply then"),
        (expected[::-1, ::-1], "the template is rotated by 180 degrees"),
        (np.abs(expected), "r has a sign: it is negative where one is a negative"),
        (expected * (i + j == 0), "only r[0, 0] is filled: does it end early?"),
        (
            expected * (j == 0),
            "only the first column is filled: does it end early?",
        ),
        (expected * (i == 0), "only the first row is filled: does it end early?"),
        (expected * (i < last[0]) * (j < last[1]), short),
        (expected * (i < last[0]), short),
        (expected * (j < last[1]), short),
        *rounded(found, expected),
    ]
    hint = first_slip(found, slips, "r is not that of the window at this place")
    place = np.unravel_index(np.argmax(found), found.shape) == (row, column)
    report(
        "correlation_map",
        [
            (
                "highest where the template was cut out",
                place,
                "element [i, j] belongs to the window whose top left is search[i, j]",
            ),
            ("every r as defined", near(found, expected, SINGLE), hint),
            (
                "no gain or offset matters",
                along_with(near(found, gained, SINGLE), place),
                "a gain and an offset of the template change it",
            ),
        ],
    )


def map_of(
    template: np.ndarray, search: np.ndarray, centred: bool = True, divided: bool = True
) -> np.ndarray:
    """By Einstein's sum over all windows: another way than the solution's."""
    windows = sliding_window_view(search, template.shape)
    t = template - template.mean() * centred
    w = windows - windows.mean(axis=(2, 3), keepdims=True) * centred
    r = np.einsum("ijkl,kl->ij", w, t)
    if divided:
        r = r / np.sqrt(np.einsum("ijkl,ijkl->ij", w, w) * np.sum(t * t))
    return r


def _other_searches(rng: np.random.Generator) -> list:
    """Searches like those above, with other widths, places and lengths of the shift."""
    searches = []
    for template, left, right in _SEARCHES:
        place = rng.integers(80, 900, 2)
        shift = np.round(np.subtract(right, left) * rng.uniform(0.7, 1.3)).astype(int)
        wider = int(2 * rng.integers(0, 5))
        searches.append((template + wider, place, place + shift))
    return searches


def search_width(function: Callable[[int, np.ndarray, np.ndarray], object]) -> None:
    """Check the width of a search window that holds the match and its neighbours."""
    cases = varied(210, _SEARCHES, _other_searches)
    template, left, right = (np.array(column) for column in zip(*cases))
    largest = np.abs(right - left).max(axis=1)
    answers = np.array(
        [call(function, w, np.array(p), np.array(q), shape=()) for w, p, q in cases]
    )
    expected = template + 2 * largest + 2
    shift = right - left
    along, down = np.abs(shift).T
    # the size of one shift or of none is taken, however the difference is formed
    (x, y), signs = shift.T, (1, -1)
    signed = [
        np.maximum(i * u, j * v)
        for u, v in ((x, y), (along, y), (x, down))
        for i, j in product(signs, signs)
    ]
    one_side = "the window reaches out on both sides"
    no_room = "the template itself needs room, too"
    reaches = [
        (
            abs(shift.max(axis=1)),
            "sizes first, then the largest: shifts may be negative",
        ),
        (along + down, "the window is square: the larger shift, not their sum"),
        (along, "rows may differ more than columns"),
        (down, "columns may differ more than rows"),
        (
            np.ceil(np.hypot(along, down)),
            "the window is square: take the larger shift",
        ),
    ]
    slips = [
        (
            expected - 2,
            "the match lies on the border: its neighbours need a pixel more",
        ),
        (expected - 1, "a pixel is missing on one side"),
        *((template + largest + more, one_side) for more in (0, 1, 2)),
        *((2 * largest + more, no_room) for more in (2, 3)),
        *(
            (template + 2 * one + more, "a shift may be negative, in columns and rows")
            for one in signed
            for more in (2, 0)
        ),
        *((template + 2 * reach + 2, hint) for reach, hint in reaches),
    ]
    otherwise = "a match or one of its neighbours is no place of the search"
    if np.all(answers >= expected):
        otherwise = "every match is inside, but the window could be smaller"
    hint = first_slip(answers, slips, otherwise)
    report(
        "search_width",
        [
            ("odd", bool(np.all(answers % 2 == 1)), "the width must be odd"),
            ("smallest that holds the match", near(answers, expected), hint),
        ],
    )
