"""Checks of the search of chapter 2: a map of r, and how wide it must be."""

from collections.abc import Callable

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pgm_lab.checks import CheckFailed, call, first_slip, near, report


def rounded(found: np.ndarray, right: np.ndarray) -> list[tuple[np.ndarray, str]]:
    """The slip of an answer that is right to some digits, if it is one."""
    near_enough = near(found, right, 1e-6) or any(
        near(found, np.round(right, k), 1e-9) for k in range(1, 7)
    )
    hint = "it is right, but rounded: return all its digits, as float64 does"
    return [(found, hint)] if near_enough else []


def correlation_map(function: Callable[[np.ndarray, np.ndarray], object]) -> None:
    """Check a correlation map of the reader's own."""
    rng = np.random.default_rng(26)
    search = rng.integers(0, 256, (9, 12)).astype(float)
    template = search[2:5, 6:11].copy()  # 3 x 5
    expected = map_of(template, search)
    found = call(function, template, search, shape=expected.shape)
    if not np.any(found):
        raise CheckFailed("correlation_map: the map is still all zeros. Your turn!")
    gained = call(function, 0.5 * template + 60, search, shape=expected.shape)
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
        (expected[::-1, ::-1], "the template is turned by 180 degrees"),
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
    place = np.unravel_index(np.argmax(found), found.shape)
    report(
        "correlation_map",
        [
            (
                "highest where the template was cut out",
                place == (2, 6),
                "element [i, j] belongs to the window whose top left is search[i, j]",
            ),
            ("every r as defined", near(found, expected, 1e-9), hint),
            (
                "no gain or offset matters",
                near(found, gained, 1e-9),
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


def search_width(function: Callable[[int, np.ndarray, np.ndarray], object]) -> None:
    """Check the width of a search window that holds the match and its neighbours."""
    cases = [  # template, left, right, shift
        (19, (332, 1063), (268, 1049), 64),
        (21, (100, 200), (112, 170), 30),
        (11, (50, 60), (50, 60), 0),
        (7, (40, 80), (57, 81), 17),
        (15, (60, 40), (55, 70), 30),
    ]
    answers = np.array(
        [
            call(function, w, np.array(left), np.array(right), shape=())
            for w, left, right, _ in cases
        ]
    )
    template, largest = np.array([(w, shift) for w, _, _, shift in cases]).T
    expected = template + 2 * largest + 2
    down = np.array([abs(b[1] - a[1]) for _, a, b, _ in cases])
    shifts = np.array([np.subtract(b, a) for _, a, b, _ in cases])
    late = np.abs(shifts.max(axis=1))
    # the size of one shift or of none is taken, however the difference is formed
    signed = [
        np.maximum(*(sign * part for sign, part in zip(signs, parts)))
        for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1))
        for parts in (shifts.T, (abs(shifts[:, 0]), shifts[:, 1]),
                      (shifts[:, 0], abs(shifts[:, 1])))
    ]  # fmt: skip
    sums = np.array([np.sum(np.abs(np.subtract(b, a))) for _, a, b, _ in cases])
    along = np.array([abs(b[0] - a[0]) for _, a, b, _ in cases])
    far = np.array([np.hypot(*np.subtract(b, a)) for _, a, b, _ in cases])
    slips = [
        (
            expected - 2,
            "the match lies on the border: its neighbours need a pixel more",
        ),
        (
            template + 2 * largest + 1,
            "a pixel is missing on one side",
        ),
        (template + largest, "the window reaches out on both sides"),
        (template + largest + 1, "the window reaches out on both sides"),
        (template + largest + 2, "the window reaches out on both sides"),
        (2 * largest + 2, "the template itself needs room, too"),
        (2 * largest + 3, "the template itself needs room, too"),
        *(
            (template + 2 * one + more, "a shift may be negative, in columns and rows")
            for one in signed
            for more in (2, 0)
        ),
        (
            template + 2 * late + 2,
            "sizes first, then the largest: shifts may be negative",
        ),
        (
            template + 2 * sums + 2,
            "the window is square: the larger shift, not their sum",
        ),
        (template + 2 * along + 2, "rows may differ more than columns"),
        (template + 2 * down + 2, "columns may differ more than rows"),
        (
            template + 2 * np.ceil(far) + 2,
            "the window is square: take the larger shift",
        ),
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
