"""Times of resampling beside its peers, in one run: `make benchmark`.

Compare the medians within a group; the tests assert that both give the same, no times.
"""

import numpy as np
import pytest
from scipy import ndimage
from skimage import transform

from pgm_lab import image, simulate
from pgm_lab.image.resampling import METHODS

TRANSFORM = transform.AffineTransform(
    matrix=[[0.97, 0.01, 8.3], [-0.01, 0.96, 16.7], [0, 0, 1]]
)
ORDERS = {"nearest": 0, "bilinear": 1, "cubic": 3}
SPLINES = {"spline3": 3, "spline5": 5}


@pytest.fixture(scope="module")
def grey():
    texture = simulate.texture(seed=1)
    return simulate.texture_pair(texture, (1000, 1000), (0, 1, 0, 0, 0, 1))[0]


@pytest.fixture(scope="module")
def points():
    rows, columns = np.indices((1000, 1000))
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=-1)
    return TRANSFORM(pixels)


@pytest.mark.parametrize("method", METHODS)
def test_resample_a_million_points(benchmark, grey, points, method):
    benchmark.group = f"{method}, a million points"
    benchmark(image.resample, grey, points, method)


@pytest.mark.parametrize("method", ORDERS)
def test_skimage_warp(benchmark, grey, points, method):
    """It takes the affine transformation, and does not have to be told each point."""
    benchmark.group = f"{method}, a million points"
    options = {"order": ORDERS[method], "clip": False, "mode": "edge"}
    found = benchmark(transform.warp, grey, TRANSFORM, **options)
    ours = image.resample(grey, points, method)
    # A point half way between two pixels may fall to either
    assert np.mean(np.abs(found.ravel() - ours) > 1e-6) < 1e-3


@pytest.mark.parametrize("method", ["bilinear", *SPLINES])
def test_scipy_map_coordinates(benchmark, grey, points, method):
    benchmark.group = f"{method}, a million points"
    order = SPLINES.get(method, 1)
    yx = np.ascontiguousarray(points.T[::-1])
    found = benchmark(ndimage.map_coordinates, grey, yx, order=order, mode="mirror")
    ours = image.resample(grey, points, method)
    np.testing.assert_allclose(found, ours, rtol=0, atol=1e-9)
