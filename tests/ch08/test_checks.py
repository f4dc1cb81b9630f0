"""Exercise feedback of chapter 8: right answers pass, each slip is named."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from pgm_book.ch08 import checks as chapter8
from pgm_book.common.checks import CheckFailed
from pgm_book.program import stereo as textbook
from pgm_book.program.registration import correlation
from pgm_lab import frames, ncc, stereo
from pgm_lab.simulate import Landscape
from tests.common.slips import unnamed


def passes(check, *arguments, capsys):
    check(*arguments)
    assert capsys.readouterr().out.count("✓") == 1


def fails(check, hint, *arguments):
    with pytest.raises(CheckFailed, match=hint):
        check(*arguments)


def model(x, y, parallax, base, c):
    """The solution of exercise 8.1."""
    scale = base / parallax
    return scale * np.array([x, y, -c])


@pytest.mark.parametrize("function", [model, lambda *a: model(*a).tolist()])
def test_a_right_model_point_passes(function, capsys):
    passes(chapter8.model_point, function, capsys=capsys)


def test_a_slip_of_the_model_point_is_named():
    slips = [
        (lambda x, y, p, B, c: None, "returns nothing"),
        (lambda x, y, p, B, c: B / p * np.array([x, y, c]), "negative"),
        (lambda x, y, p, B, c: p / B * np.array([x, y, -c]), "exchanged"),
        (lambda x, y, p, B, c: c * model(x, y, p, B, c), "that scale is H"),
        (lambda x, y, p, B, c: np.array([x, y, -c * B / p]), "scaled as well"),
        (lambda x, y, p, B, c: np.array([x, y, -c]), "in the photo"),
        (lambda x, y, p, B, c: model(x, y, p, B, c) - (B, 0, 0), "nothing is added"),
        (lambda x, y, p, B, c: -c * B / p, "shape"),
        (lambda *a: model(*a)[:, None], r"shape \(3,\)"),
        (lambda x, y, p, B, c: 2 * model(x, y, p, B, c), "two rays meet"),
    ]
    assert unnamed(chapter8.model_point, slips) == []


@pytest.fixture(scope="module")
def level():
    """A level field at Z = 20 m, seen straight from above; the true disparity too."""
    flat = np.full((40, 40), 20.0, np.float32)
    land = Landscape(flat, flat, flat, flat.astype(np.uint8), (-200.0, 200.0), 10.0)
    grey = np.zeros((100, 120), np.float32)
    stations = np.array([(-50.0, 0, 1000), (50.0, 0, 1000)])
    origin = np.array([(1.2, 0.2), (-1.2, 0.2)])
    pair = stereo.NormalPair(grey, grey, np.eye(3), stations, 24.0, 0.005, origin)
    true = (24 * 100 / 980 - 2.4) / 0.005
    return pair, land, true


@pytest.mark.parametrize("kind", [float, np.array, lambda d: round(d + 0.4)])
def test_a_mark_on_the_ground_passes(kind, level, capsys):
    pair, land, true = level
    passes(chapter8.mark, kind(true), pair, (60, 50), land, capsys=capsys)


@pytest.mark.parametrize(
    ("change", "hint"),
    [
        (lambda d: ..., "still empty"),
        (lambda d: (d, d), "one number"),
        (lambda d: str(d), "without quotation marks"),
        (lambda d: d + 3, "floats above"),
        (lambda d: d - 3, "below the ground"),
        (lambda d: -d, "the sign"),
        (lambda d: 20.0, "that is the height"),
    ],
)
def test_a_mark_that_hangs_elsewhere_is_named(change, hint, level):
    pair, land, true = level
    fails(chapter8.mark, hint, change(true), pair, (60, 50), land)


def line(base, ray, M, c):
    """The solution of exercise 8.3."""
    a, b, w = M @ np.cross(base, ray)
    return np.array([a, b, -c * w])


def test_a_right_line_passes_whatever_its_length_and_sign(capsys):
    for factor in (1, -1, 1e-3):
        passes(chapter8.epipolar_line, lambda *a, f=factor: f * line(*a), capsys=capsys)


def test_a_slip_of_the_line_is_named():
    slips = [
        (lambda b, u, M, c: None, "returns nothing"),
        (lambda b, u, M, c: line(b, u, M, -c), "sign of the third"),
        (lambda b, u, M, c: line(b, u, M, 1.0), "multiplied by c"),
        (lambda b, u, M, c: line(b, u, M, -1.0), "and only it"),
        (lambda b, u, M, c: line(b, u, M.T, c), "transpose"),
        (lambda b, u, M, c: line(b, u, np.eye(3), c), "rotated into the right photo"),
        (lambda b, u, M, c: line(b, M @ u, np.eye(3), c), "both in object space"),
        (lambda b, u, M, c: line(b, u, M, 2 * c), "other heights"),
        (lambda b, u, M, c: line(b, u, M, c)[:2], "shape"),
        (lambda b, u, M, c: np.zeros(3), "still zero"),
    ]
    assert unnamed(chapter8.epipolar_line, slips) == []


def search(left, right, column, row, window, low, high):
    """The solution of exercise 8.4."""
    half, tried = window // 2, np.arange(low, high + 1)
    rows = slice(row - half, row + half + 1)
    target = left[rows, column - half : column + half + 1]
    r = []
    for d in tried:
        middle = column - d
        r.append(
            ncc.correlation(target, right[rows, middle - half : middle + half + 1])
        )
    best = int(np.argmax(r))
    if best in (0, len(r) - 1):
        return np.nan, r[best]
    a, b, c = r[best - 1 : best + 2]
    return tried[best] + (c - a) / 2 / (2 * b - a - c), r[best]


def test_a_right_search_along_the_row_passes(capsys):
    for function in (search, textbook.best_disparity, lambda *a: list(search(*a))):
        passes(chapter8.best_disparity, function, capsys=capsys)


def altered(change):
    """The right search with a slip in its answer."""
    return lambda *a: change(*search(*a), a[5])


def to_the_other_side(left, right, column, row, window, low, high):
    """`column + d` for `column - d`."""
    d, r = search(left, right, column, row, window, -high, -low)
    return -d, r


def too_short(left, right, column, row, window, low, high):
    """`+ half` for `+ half + 1`, in the right window."""
    rows = slice(row - window // 2, row + window // 2 + 1)
    target = left[rows, column - window // 2 : column + window // 2 + 1]
    return 0, correlation(target, right[rows, column - window // 2 : column + 3])


def whatever_the_sign(left, right, column, row, window, low, high):
    """`abs(correlation(...))`, which takes a negative for a match."""
    pairs = (right, -right)
    found = [search(left, one, column, row, window, low, high) for one in pairs]
    return max(found, key=lambda one: one[1])


def without_ends(left, right, column, row, window, low, high):
    d, r = search(left, right, column, row, window, low, high)
    return (low, r) if np.isnan(d) else (d, r)


def test_a_slip_of_the_search_is_named():
    slips = [
        (altered(lambda d, r, low: None), "returns nothing"),
        (altered(lambda d, r, low: d), "two numbers"),
        (altered(lambda d, r, low: (r, d)), "the two are exchanged: [^;]*$"),
        (altered(lambda d, r, low: (-d, r)), "the sign"),
        (altered(lambda d, r, low: (np.round(d), r)), "whole pixels"),
        (altered(lambda d, r, low: (d - np.round(d), r)), "alone"),
        (altered(lambda d, r, low: (2 * np.round(d) - d, r)), "the wrong sign"),
        (altered(lambda d, r, low: (d - low, r)), "begins at low"),
        (altered(lambda d, r, low: (np.round(d) - low, r)), "begins at low"),
        (altered(lambda d, r, low: (d, r**2)), "r is not the highest"),
        (altered(lambda d, r, low: (np.nan, r)), "not that of the highest"),
        (to_the_other_side, "the wrong side: [^;]*$"),
        (whatever_the_sign, "counts with its sign"),
        (without_ends, "no peak"),
        (too_short, "a column, which d is not, .*ends before its last number"),
    ]
    assert unnamed(chapter8.best_disparity, slips) == []


def test_a_right_prediction_passes(capsys):
    passes(chapter8.sigma_height, lambda H, B, g, s: H * g * s / B, capsys=capsys)


def test_a_slip_of_the_prediction_is_named():
    slips = [
        (lambda H, B, g, s: None, "returns nothing"),
        (lambda H, B, g, s: B / H * g * s, "exchanged"),
        (lambda H, B, g, s: H**2 / B * g * s, "enters twice"),
        (lambda H, B, g, s: g * s, "across the ray"),
        (lambda H, B, g, s: -H / B * g * s, "is positive"),
        (lambda H, B, g, s: H / B * s, "the GSD is missing"),
        (lambda H, B, g, s: H / B * g, "sigma_px"),
        (lambda H, B, g, s: H / B * g * s**2, "does not follow"),
        (lambda H, B, g, s: round(H / B * g * s, 2), "rounded"),
    ]
    assert unnamed(chapter8.sigma_height, slips) == []


def normal(
    image,
    M,
    N,
    c,
    px,
    turn=lambda M, N: M @ N.T,
    up=-1,
    order=1,
    sample=map_coordinates,
):
    """A photo resampled to the normal case, with room for a slip."""
    rows, columns = image.shape
    row, column = np.indices(image.shape)
    middle = (columns - 1) / 2, (rows - 1) / 2
    x, y = (column - middle[0]) * px, up * (row - middle[1]) * px
    rays = np.stack([x, y, np.full(x.shape, -c)])
    U, V, W = np.tensordot(turn(M, N), rays, 1)
    place = [middle[1] - c * V / W / (up * px), middle[0] - c * U / W / px]
    return sample(image, place, order=order, cval=np.nan)


def by_the_lesson(at=None, **fixed):
    """The solution of the task, with room for a slip."""

    def function(image, M, N, c, px):
        c, px, size = fixed.get("c", c), fixed.get("px", px), image.shape[::-1]
        pixels = np.stack(np.meshgrid(*map(np.arange, size)), -1).reshape(-1, 2)
        xy = frames.pixel_to_photo(pixels, size, px)
        U, V, W = M @ N.T @ np.insert(xy, 2, -c, axis=1).T
        there = at(U, V, W, c) if at else (-c * U / W, -c * V / W)
        column, row = frames.photo_to_pixel(np.column_stack(there), size, px).T
        return map_coordinates(image, [row, column], order=1).reshape(image.shape)

    return function


def test_a_right_normal_case_passes(capsys):
    passes(chapter8.normal_case, normal, capsys=capsys)
    passes(chapter8.normal_case, by_the_lesson(), capsys=capsys)
    passes(chapter8.normal_case, lambda *a: normal(*a, order=3).tolist(), capsys=capsys)


def test_a_slip_of_the_normal_case_is_named():
    def turned(how):
        return lambda *a: normal(*a, turn=how)

    def exchanged(image, *rest):
        def at(image, place, **how):
            return map_coordinates(image, place[::-1], **how)

        return normal(image, *rest, sample=at)

    slips = [
        (lambda *a: None, "returns nothing"),
        (lambda *a: normal(*a)[1:], "as large as the photo"),
        (lambda *a: "image", "must return grey values"),
        (lambda image, *a: image, "still the photo"),
        (turned(lambda M, N: M @ N), "N rotates into the normal case"),
        (turned(lambda M, N: N.T), "M is missing"),
        (turned(lambda M, N: M.T @ N.T), "its inverse"),
        (turned(lambda M, N: N @ M.T), "exchanged"),
        (turned(lambda M, N: M.T @ N), "both transposed"),
        (lambda *a: normal(*a, up=1), "rows count downwards"),
        (lambda *a: normal(*a)[::-1], "rows count downwards"),
        (lambda *a: normal(*a, order=0), "between four"),
        (turned(lambda M, N: M), "N is missing"),
        (lambda *a: normal(*a).round(), "rounded"),
        (lambda *a: normal(*a) + 0j, "must return grey values"),
        (exchanged, "rows and columns"),
        (by_the_lesson(at=lambda U, V, W, c: (c * U / W, c * V / W)), "the sign"),
        (by_the_lesson(at=lambda U, V, W, c: (-c * U / W, c * V / W)), "downwards"),
        (by_the_lesson(at=lambda U, V, W, c: (U, V)), "no photo coordinates yet"),
        (by_the_lesson(c=8), "the arguments"),
        (by_the_lesson(px=0.02), "the arguments"),
        (by_the_lesson(c=8, px=0.02), "the arguments"),
        (lambda *a: normal(*a).T.reshape(60, 80), "rays' places"),
    ]
    assert unnamed(chapter8.normal_case, slips) == []
