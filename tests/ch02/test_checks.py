"""Exercise feedback of chapter 2: right answers pass, each slip is named."""

import cv2
import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from pgm_book.ch02 import checks
from pgm_lab import ncc
from tests.common.slips import unnamed

FIVE = checks.FIVE
R = np.corrcoef(FIVE[:, :4].ravel(), FIVE[:, 1:].ravel())[0, 1]

A, B = (window - window.mean() for window in (FIVE[:, :4], FIVE[:, 1:]))


def cosine(a, b):
    return np.sum(a * b) / np.sqrt(np.sum(a**2) * np.sum(b**2))


def line(x, y):
    found = ncc.regression(x, y)
    return found.alpha, found.beta


def parabola(a, b, c):
    return (a - c) / (2 * (a - 2 * b + c))


def correlation_map(template, search):
    (h, w), (H, W) = template.shape, search.shape
    return np.array(
        [
            [
                np.corrcoef(search[i : i + h, j : j + w].ravel(), template.ravel())[
                    0, 1
                ]
                for j in range(W - w + 1)
            ]
            for i in range(H - h + 1)
        ]
    )


def size(template, left, right):
    return template + 2 * np.max(np.abs(right - left)) + 2


def test_right_answers_pass(capsys):
    checks.correlation(ncc.correlation)
    checks.correlation(lambda a, b: [ncc.correlation(a, b)][0])
    checks.shifted(R)
    checks.shifted(round(R, 3))
    checks.line(line)
    checks.peak_of_parabola(parabola)
    checks.correlation_map(correlation_map)
    checks.correlation_map(ncc.correlation_map)
    checks.correlation_map(opencv_map)  # in single precision
    checks.search_width(size)
    assert capsys.readouterr().out.count("✓") == 10


def opencv_map(template, search):
    single = (search.astype(np.float32), template.astype(np.float32))
    return cv2.matchTemplate(*single, cv2.TM_CCOEFF_NORMED)


def centred(a, b):
    return a - a.mean(), b - b.mean()


def no_root(a, b):
    a, b = centred(a, b)
    return np.sum(a * b) / (np.sum(a**2) * np.sum(b**2))


def one_sum_for_both(a, b):
    a, b = centred(a, b)
    return np.sum(a * b) / np.sqrt(np.sum(a**2 * b**2))


def two_kinds_of_sd(a, b):
    return np.cov(a.ravel(), b.ravel())[0, 1] / (a.std() * b.std())


def beta(x, y):
    return line(x, y)[1]


def windows_and_template(template, search):
    w = sliding_window_view(search, template.shape).reshape(-1, template.size)
    shape = np.subtract(search.shape, template.shape) + 1
    return w, template.ravel() - template.mean(), shape


def whole_mean(template, search):
    w, t, shape = windows_and_template(template, search - search.mean())
    return (w @ t / np.sqrt((w * w).sum(axis=1) * (t @ t))).reshape(shape)


def one_sum(template, search):
    w, t, shape = windows_and_template(template, search)
    w = w - w.mean(axis=1, keepdims=True)
    return (w @ t / np.sqrt(np.sum(w**2 * t**2, axis=1))).reshape(shape)


def cosines(template, search):
    return checks.map_of(template, search, centred=False)


def filled(rows, columns):
    """A map of which only these rows and columns are filled."""

    def function(template, search):
        r = np.zeros(np.subtract(search.shape, template.shape) + 1)
        r[rows, columns] = correlation_map(template, search)[rows, columns]
        return r

    return function


def test_map_of_the_check_is_that_of_the_package():
    rng = np.random.default_rng(3)
    search = rng.uniform(0, 9, (11, 8))
    expected = ncc.correlation_map(search[4:8, 2:5], search)
    np.testing.assert_allclose(
        checks.map_of(search[4:8, 2:5], search), expected, atol=1e-6
    )


SLIPS = {
    checks.correlation: [
        (lambda a, b: cosine(a, b), "subtract the mean of each"),
        (lambda a, b: ncc.correlation(a, b) ** 2, "r squared"),
        (lambda a, b: abs(ncc.correlation(a, b)), "has a sign"),
        (lambda a, b: np.sum(np.multiply(*centred(a, b))), "divide by the lengths"),
        (lambda a, b: np.mean(np.multiply(*centred(a, b))), "divide by the lengths"),
        (no_root, "a root is missing"),
        (one_sum_for_both, "a length of its own"),
        (lambda a, b: cosine(*np.array([a, b]) - np.mean([a, b])), "mean of its own"),
        (lambda a, b: cosine(a - a.mean(axis=0), b - b.mean(axis=0)), "of each column"),
        (two_kinds_of_sd, "n − 1"),
        (lambda a, b: ncc.correlation(a, b) * a.size, "the other a sum"),
        (lambda a, b: round(ncc.correlation(a, b), 2), "rounded"),
        (lambda a, b: np.float32(ncc.correlation(a, b)), "single precision"),
        (lambda a, b: -ncc.correlation(a, b), "sign is reversed"),
        (lambda a, b: np.arccos(ncc.correlation(a, b)), "that is the angle"),
        (lambda a, b: np.degrees(np.arccos(ncc.correlation(a, b))), "is the angle"),
        (lambda a, b: round(ncc.correlation(a, b), 5), "rounded"),
        (lambda a, b: sum(a * b), r"got an array of shape \(4,\). .*np.sum adds all"),
        (lambda a, b: 0.5, "must give 1 or −1"),
        (lambda a, b: np.sum(a @ b), r"ValueError.*pixel by pixel, with \*"),
        (lambda a, b: None, "returns nothing"),
    ],
    checks.shifted: [
        (..., "still empty"),
        ([0.5, 0.6], "one number"),
        ("high", "one number"),
        (1.0, "two equal windows"),
        (R**2, "r squared"),
        (R - 0.01, "does not follow"),
        (-R, "does not follow"),
        (
            cosine(FIVE[:, :4] - FIVE.mean(), FIVE[:, 1:] - FIVE.mean()),
            "mean of all 25",
        ),
        (np.sum(A * B) / (np.sum(A**2) * np.sum(B**2)), "missing in the denominator"),
        (0.0, "does not follow"),
        (np.sum(A * B), "divide by the root"),
        (np.sum(A * B) / (20 * FIVE.var()), "its own contrast"),
        (np.corrcoef(FIVE[:4].ravel(), FIVE[1:].ravel())[0, 1], "dropped rows"),
        (cosine(FIVE[:, :4], FIVE[:, 1:]), "subtract the mean of each window first"),
    ],
    checks.line: [
        (lambda x, y: (-beta(x, y) * x.mean(), beta(x, y)), "mean of y is missing"),
        (lambda x, y: line(x, y)[::-1], "gain comes last"),
        (lambda x, y: (y.mean() - x.mean(), beta(x, y)), "multiplied by the gain"),
        (lambda x, y: (y.mean() + beta(x, y) * x.mean(), beta(x, y)), "the sign"),
        (lambda x, y: (y.sum() - beta(x, y) * x.sum(), beta(x, y)), "those are sums"),
        (lambda x, y: (x.mean() - beta(x, y) * y.mean(), beta(x, y)), "exchanged"),
        (lambda x, y: line(y, x), "x and y are exchanged"),
        (lambda x, y: (0.0, beta(x, y)), "through the mean"),
        (lambda x, y: (0.0, beta(x, y)), "line without errors is not rec"),
        (lambda x, y: (..., beta(x, y)), "still `...`"),
        (
            lambda x, y: (y - beta(x, y) * x, beta(x, y)),
            r"parts of shapes \(3, 7\), \(\). alpha is one number: take the means",
        ),
        (lambda x, y: (y.sum() - beta(x, y) * x.mean(), beta(x, y)), "sum over y"),
        (lambda x, y: (y.mean() - beta(x, y) * x.sum(), beta(x, y)), "sum over x"),
        (lambda x, y: (y.sum() - beta(x, y) * x.sum() / x.size, beta(x, y)), "over y"),
        (
            lambda x, y: (y[0].mean() - beta(x, y) * x[0].mean(), beta(x, y)),
            "first row",
        ),
        (lambda x, y: line(x[0], y[0]), "through the mean"),
        (lambda x, y: (y.mean() - x.mean(), 1.0 + 0 * beta(x, y)), "recovered"),
        (
            lambda x, y: (y.mean() - y.std() / x.std() * x.mean(), y.std() / x.std()),
            "with another gain",
        ),
        (lambda x, y: (round(line(x, y)[0]), beta(x, y)), "rounded"),
        (lambda x, y: (round(line(x, y)[0], 2), beta(x, y)), "rounded"),
        (lambda x, y: np.round(line(x, y), 3), "rounded"),
        (lambda x, y: np.float32(line(x, y)), "single precision"),
    ],
    checks.peak_of_parabola: [
        (lambda a, b, c: -parabola(a, b, c), "the sign: the top"),
        (lambda a, b, c: 2 * parabola(a, b, c), "twice as far"),
        (lambda a, b, c: -2 * parabola(a, b, c), "and a factor of two"),
        (lambda a, b, c: parabola(a, b, c) / 2, "half as far"),
        (lambda a, b, c: (a - c) / (2 * (a - b + c)), "counts twice"),
        (lambda a, b, c: (c - a) / 2, "that is the slope"),
        (lambda a, b, c: round(parabola(a, b, c), 2), "rounded"),
        (lambda a, b, c: np.float32(parabola(a, b, c)), "single precision"),
        (lambda a, b, c: parabola(a, b, c) + 1, "from the middle value"),
        (lambda a, b, c: b + parabola(a, b, c) * (c - a) / 4, "how high the top is"),
        (lambda a, b, c: (b - a) / (c - b), "equal neighbours must give 0"),
        (lambda a, b, c: 0.0, "exact parabola is not found"),
        (lambda a, b, c: None, "returns nothing"),
    ],
    checks.correlation_map: [
        (
            lambda t, s: [np.sum(t * s[i : i + len(t), 9:]) for i in range(3)],
            r"ValueError.*as large as the template, its top left search\[i, j\]",
        ),
        (filled(slice(0), slice(0)), "all zeros. Your turn!"),
        (filled(slice(1), slice(1)), r"only r\[0, 0\] is filled"),
        (filled(slice(1), slice(None)), "only the first row"),
        (filled(slice(None), slice(1)), "only the first column"),
        (filled(slice(-1), slice(-1)), "is still 0"),
        (filled(slice(-1), slice(None)), "is still 0"),
        (filled(slice(None), slice(-1)), "is still 0"),
        (lambda t, s: np.abs(correlation_map(t, s)), "has a sign"),
        (lambda t, s: correlation_map(t, s).round(2), "rounded"),
        (cosines, "subtract the mean from each"),
        (
            lambda t, s: checks.map_of(t, s, divided=False),
            "divide by the two contrasts",
        ),
        (lambda t, s: checks.map_of(t, s, divided=False), "a gain and an offset"),
        (lambda t, s: correlation_map(t, s) ** 2, "r squared"),
        (lambda t, s: -correlation_map(t, s), "sign is reversed"),
        (lambda t, s: correlation_map(t, s)[::-1, ::-1], "180 degrees"),
        (lambda t, s: correlation_map(t, s)[::-1, ::-1], r"top left is search\[i, j\]"),
        (lambda t, s: np.roll(correlation_map(t, s), 1), "r is not that of the window"),
        (lambda t, s: correlation_map(t, s).T, "rows and columns are exchanged"),
        (whole_mean, "not that of the whole search window"),
        (one_sum, "squares of each window first"),
        (lambda t, s: np.zeros((9, 12)), "must return shape"),
    ],
    checks.search_width: [
        (lambda w, a, b: size(w, a, b) - 2, "on the border"),
        (lambda w, a, b: size(w, a, b) - 1, "must be odd; a pixel is missing"),
        (lambda w, a, b: w + 2 * np.max(a - b) + 2, "may be negative"),
        (lambda w, a, b: w + 2 * max(a - b), "may be negative"),
        (lambda w, a, b: w + 2 * max(abs(b[0] - a[0]), a[1] - b[1]) + 2, "and rows"),
        (lambda w, a, b: w + 2 * max(abs(b[0] - a[0]), b[1] - a[1]) + 2, "and rows"),
        (lambda w, a, b: w + 2 * max(a[0] - b[0], abs(b[1] - a[1])) + 2, "and rows"),
        (lambda w, a, b: w + np.max(np.abs(b - a)), "on both sides"),
        (lambda w, a, b: size(0, a, b), "template itself"),
        (lambda w, a, b: w + 2 * np.max(b - a) + 2, "may be negative"),
        (lambda w, a, b: w + 2 * abs(b[0] - a[0]) + 2, "rows may differ"),
        (lambda w, a, b: w + 2 * np.ceil(np.hypot(*(b - a))) + 2, "larger shift"),
        (lambda w, a, b: w + 2 * abs(np.max(b - a)) + 2, "sizes first"),
        (lambda w, a, b: w + 2 * np.sum(np.abs(b - a)) + 2, "not their sum"),
        (lambda w, a, b: size(w, a, b) + 2, "could be smaller"),
        (lambda w, a, b: w + 2 * np.min(np.abs(b - a)) + 2, "no place of the search"),
        (lambda w, a, b: w + 2 * abs(b[1] - a[1]) + 2, "columns may differ more"),
    ],
}


@pytest.mark.parametrize("check", SLIPS, ids=lambda check: check.__name__)
def test_each_slip_is_named(check):
    assert unnamed(check, SLIPS[check]) == []
