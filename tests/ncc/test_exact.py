"""`ncc.match` against the exact map of each point, by brute force.

The search is in single precision; no peak may be wrong or missing because of it. Does
not test what is done to the peaks afterwards, but for their r.
"""

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from scipy import ndimage

from pgm_lab import ncc

SIZE = 80
KINDS = {
    "noise": lambda g, rng: g,
    "soft": lambda g, rng: ndimage.gaussian_filter(g, 2.5),
    "very soft": lambda g, rng: ndimage.gaussian_filter(g, 8),
    "ties": lambda g, rng: np.tile(g[:8, :8], (10, 10)),
    "near ties": lambda g, rng: np.tile(g[:8, :8], (10, 10)) + 1e-3 * g,
    "stripes": lambda g, rng: np.arange(SIZE) // 3 % 2 * 100.0 + 0 * g,
    "two values": lambda g, rng: np.where(g > 128, 1.0, 0.0),
    "one pixel": lambda g, rng: np.where(g > 254.8, 90.0, 7.0),
    "saturated": lambda g, rng: np.clip(4 * g - 300, 0, 255),
    "flat half": lambda g, rng: np.where(np.arange(SIZE) < 35, 128.0, g),
    "faint half": lambda g, rng: np.where(np.arange(SIZE) < 40, 100 + g / 100, g),
    "very faint half": lambda g, rng: np.where(np.arange(SIZE) < 40, 9 + 1e-7 * g, g),
    "spikes": lambda g, rng: g / 50 + 3e4 * (rng.uniform(size=g.shape) < 2e-3),
    "slope": lambda g, rng: g / 10 + 100 * np.arange(SIZE),
}
TYPES = {
    "8 bit": lambda g: np.clip(g, 0, 255).round().astype(np.uint8),
    "16 bit": lambda g: np.clip(g, 0, 65535).round().astype(np.uint16),
    "60,000 +- 1": lambda g: (60000 + np.sign(g - g.mean())).astype(np.uint16),
    "single": lambda g: (g / 255).astype(np.float32),
    "double": lambda g: g.astype(float),
    "double, 1e9 + g": lambda g: 1e9 + g,
    "int64": lambda g: 2**60 + g.round().astype(np.int64),
}


def exact(a, b):
    """Correlations of one window with windows b (..., h, w), means taken off twice."""
    a, b = (np.asarray(g, dtype=np.longdouble) for g in (a, b))
    for _ in range(2):
        a = a - a.mean()
        b = b - b.mean(axis=(-2, -1), keepdims=True)
    norm = np.sqrt(np.sum(a * a) * np.sum(b * b, axis=(-2, -1)))
    products = np.sum(a * b, axis=(-2, -1))
    return np.divide(products, norm, out=np.zeros_like(norm), where=norm > 0)


def agrees(left, right, points, found, half, reach):
    """Compare with the maps of all points by definition."""
    wide = np.pad(np.ma.filled(right.astype(np.longdouble), np.nan), half + reach,
                  constant_values=np.nan)  # fmt: skip
    for (x, y), place, r, status in zip(
        points, found.points, found.r, found.status, strict=True
    ):
        around = wide[y : y + 2 * (half + reach) + 1, x : x + 2 * (half + reach) + 1]
        windows = sliding_window_view(around, (2 * half + 1, 2 * half + 1))
        known = np.isfinite(windows).all(axis=(-2, -1))
        template = left[y - half : y + half + 1, x - half : x + half + 1]
        if np.isnan(place[0]):
            flat = np.ptp(np.ma.filled(template.astype(float), 0)) == 0
            assert flat or not known.any() or np.ma.is_masked(template) or np.isnan(
                template.astype(float)
            ).any() or status == "flat window"  # fmt: skip
            continue
        maps = np.where(
            known, exact(template, np.where(np.isfinite(windows), windows, 0)), -2
        )
        column, row = (place - (x, y) + reach).astype(int)
        # The highest, to rounding, and r exactly
        assert abs(r - float(maps[row, column])) < 1e-12
        assert maps.max() - maps[row, column] < 1e-12


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("kind", KINDS)
def test_no_peak_is_wrong_or_missing_and_each_r_is_exact(kind, dtype):
    rng = np.random.default_rng(len(kind) + len(dtype))
    left = KINDS[kind](rng.uniform(0, 255, (SIZE, SIZE)), rng)
    right = np.roll(left, (2, -3), axis=(0, 1))
    noise = rng.normal(0, 2, left.shape) * (rng.uniform() < 0.7)
    left, right = TYPES[dtype](left), TYPES[dtype](right + noise)
    half, reach = 4, 7
    points = rng.integers(half, SIZE - half, (40, 2))
    found = ncc.match(left, right, points, None, 9, 23, -1, 1)
    agrees(left, right, points, found, half, reach)


@pytest.mark.parametrize("dtype", ["8 bit", "single"])
def test_the_same_where_pixels_have_no_data(dtype):
    rng = np.random.default_rng(3)
    left = TYPES[dtype](rng.uniform(0, 255, (SIZE, SIZE)))
    right = np.ma.array(np.roll(left, (2, -3), axis=(0, 1)), mask=False)
    right[rng.uniform(size=right.shape) < 0.004] = np.ma.masked
    points = rng.integers(4, SIZE - 4, (60, 2))
    found = ncc.match(left, right, points, None, 9, 23, -1, 1)
    assert found.accepted.mean() > 0.3
    agrees(left, right, points, found, 4, 7)
