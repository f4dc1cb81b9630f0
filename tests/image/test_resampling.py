"""Resampling: exact where theory says so, and the same as other programs.

What this does not prove: which method is best for real images; how the bias depends on
texture is measured by pgm_book/ch03/studies/interpolation_bias.py.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import interpolate, ndimage
from skimage import transform

from pgm_lab import image

METHODS = ("nearest", "bilinear", "cubic", "spline3", "spline5")
DEGREES = {"nearest": 0, "bilinear": 1, "cubic": 2, "spline3": 3, "spline5": 5}
# A spline feels the mirror at the border: 0.43 per pixel for the quintic one, so that
# 40 pixels leave 1e-15 of it; cubic convolution reaches two pixels
MARGIN = 42
SEED = st.integers(0, 2**32 - 1)


def random_points(n=200, low=(0, 0), high=(29, 19), seed=1):
    """(column, row) for an image with 20 rows and 30 columns."""
    return np.random.default_rng(seed).uniform(low, high, (n, 2))


@pytest.fixture
def noise():
    return np.random.default_rng(0).uniform(0, 255, (20, 30))


def polynomial(degree, rng):
    """A polynomial in x and y, of this degree in each, of the order of one."""
    coefficients = rng.normal(size=(degree + 1, degree + 1))

    def value(x, y):
        return np.polynomial.polynomial.polyval2d(x / 50 - 1, y / 50 - 1, coefficients)

    return value


@pytest.mark.parametrize("method", METHODS)
@given(seed=SEED)
def test_reproduces_polynomials_up_to_its_degree_in_the_interior(method, seed):
    rng = np.random.default_rng(seed)
    value = polynomial(DEGREES[method], rng)
    rows, columns = np.indices((100, 110))
    points = rng.uniform(MARGIN, 99 - MARGIN, (20, 2))
    found = image.resample(value(columns, rows), points, method)
    # Coefficients of order one, up to 36 of them; splines filter with rounding errors
    np.testing.assert_allclose(found, value(*points.T), rtol=0, atol=1e-10)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
@pytest.mark.parametrize("method", METHODS)
def test_pixel_centres_give_the_pixels_and_the_image_stays(method, dtype):
    highest = 65535 if dtype == np.uint16 else 255
    rng = np.random.default_rng(3)
    grey = rng.integers(0, highest + 1, (20, 30)).astype(dtype)
    before = grey.copy()
    rows, columns = np.indices(grey.shape)
    found = image.resample(grey, np.stack([columns, rows], axis=-1), method)
    assert found.dtype == np.float64 and found.shape == grey.shape
    np.testing.assert_allclose(found, before, rtol=0, atol=1e-11 * highest)
    np.testing.assert_array_equal(grey, before)


def test_nearest_takes_the_pixel_whose_square_holds_the_point(noise):
    points = [(3.49, 4.0), (3.51, 4.0), (3.0, 4.51), (2.5, 3.5), (29.0, 18.6)]
    expected = noise[[4, 4, 5, 4, 19], [3, 4, 3, 3, 29]]
    np.testing.assert_array_equal(image.resample(noise, points, "nearest"), expected)


def test_bilinear_is_that_of_map_coordinates_and_of_skimage(noise):
    points = random_points()
    found = image.resample(noise, points, "bilinear")
    other = ndimage.map_coordinates(noise, points.T[::-1], order=1)
    np.testing.assert_allclose(found, other, rtol=0, atol=1e-11)
    warped = transform.warp(
        noise, points.T[::-1].reshape(2, 10, 20), order=1, mode="edge"
    )
    np.testing.assert_allclose(found, warped.ravel(), rtol=0, atol=1e-11)


def keys(s):
    """Keys 1981, (15), written down once more, as a function of the distance."""
    s = np.abs(s)
    near = 1.5 * s**3 - 2.5 * s**2 + 1
    far = -0.5 * s**3 + 2.5 * s**2 - 4 * s + 2
    return np.where(s < 1, near, np.where(s < 2, far, 0.0))


def test_cubic_convolution_is_the_sum_over_all_pixels_of_keys_kernel(noise):
    """All pixels of the image, mirrored on all sides: 16 of them count."""
    wide = np.pad(noise, 5, mode="reflect")
    for x, y in random_points(50):
        along_rows = keys(np.arange(-5, 25) - y)
        along_columns = keys(np.arange(-5, 35) - x)
        expected = along_rows @ wide @ along_columns
        found = image.resample(noise, (x, y), "cubic")
        assert found == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize(("method", "degree"), [("spline3", 3), ("spline5", 5)])
def test_splines_are_those_through_a_mirrored_image(noise, method, degree):
    """Far from its ends, a spline does not feel how it ends: scipy.interpolate."""
    wide = np.pad(noise, 60, mode="reflect")
    spline = interpolate.RectBivariateSpline(
        np.arange(-60, 80), np.arange(-60, 90), wide, kx=degree, ky=degree, s=0
    )
    points = random_points()
    found = image.resample(noise, points, method)
    expected = spline(points[:, 1], points[:, 0], grid=False)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)


def test_points_may_have_any_leading_axes(noise):
    points = random_points(24).reshape(2, 3, 4, 2)
    for method in METHODS:
        found = image.resample(noise, points, method)
        assert found.shape == (2, 3, 4)
        alone = image.resample(noise, points[1, 2, 3], method)
        assert alone.shape == () and alone == pytest.approx(found[1, 2, 3], abs=1e-10)
        assert image.resample(noise, np.empty((0, 2)), method).shape == (0,)


@pytest.mark.parametrize("method", ["nearest", "spline3"])
@pytest.mark.parametrize("point", [(-1e-6, 3), (29.000001, 3), (3, -0.4), (3, 19.4)])
def test_a_point_outside_is_refused_or_gets_the_value_asked_for(noise, method, point):
    points = [(3.5, 4.5), point, (29.0, 19.0)]
    words = r"1 of 3 points lie outside .* \(29, 19\).*points \[1\]\. Leave them out"
    with pytest.raises(ValueError, match=words):
        image.resample(noise, points, method)
    for value in (np.nan, 0.0, -5):
        found = image.resample(noise, points, method, outside=value)
        inside = image.resample(noise, [points[0], points[2]], method)
        np.testing.assert_array_equal(found, [inside[0], value, inside[1]])


@pytest.mark.parametrize("method", METHODS)
def test_the_smallest_image_has_four_pixels(method):
    grey = [[1.0, 2.0], [3.0, 4.0]]
    corners = [(0, 0), (1, 0), (0, 1), (1, 1)]
    np.testing.assert_allclose(image.resample(grey, corners, method), [1, 2, 3, 4])
    with pytest.raises(ValueError, match="at least 2 x 2 pixels"):
        image.resample(grey[:1], corners, method)
