"""Statistics, histogram, equalisation, gradients, pyramid: against other programs."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy import ndimage

from pgm_lab import image, simulate

EIGHT_BIT = arrays.arrays(
    np.uint8, arrays.array_shapes(min_dims=2, max_dims=2, min_side=3)
)
TYPES = (np.uint8, np.uint16, float)


def scene(dtype=np.uint8, shape=(60, 83)):
    """Uneven texture: many dark pixels, few bright ones."""
    rng = np.random.default_rng(5)
    grey = 255 * rng.beta(1.5, 6, shape)
    scaled = grey * (257 if dtype == np.uint16 else 1)
    return scaled if dtype is float else scaled.round().astype(dtype)


# Statistics


@given(EIGHT_BIT)
def test_statistics_are_those_of_numpy_with_one_degree_of_freedom_less(grey):
    found = image.statistics(grey)
    assert found.mean == pytest.approx(np.mean(grey, dtype=float), abs=1e-10)
    assert found.sd == pytest.approx(np.std(grey, ddof=1, dtype=float), abs=1e-10)
    assert (found.minimum, found.maximum) == (grey.min(), grey.max())


def test_standard_deviation_keeps_its_digits_beside_a_large_mean():
    """Sum of squares less square of the sum would lose them all."""
    grey = 1e9 + np.array([[0.0, 1.0], [2.0, 3.0]])
    assert image.statistics(grey).sd == pytest.approx(np.sqrt(5 / 3), rel=1e-9)


# Histogram


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("bins", [1, 16, 256])
def test_every_pixel_is_counted_once_in_the_bin_that_holds_it(dtype, bins):
    grey = scene(dtype)
    counts, edges = image.histogram(grey, bins)
    assert counts.shape == (bins,) and edges.shape == (bins + 1,)
    assert counts.sum() == grey.size
    middle = bins // 2
    inside = (grey >= edges[middle]) & (grey < edges[middle + 1])
    assert bins == 1 or counts[middle] == inside.sum()


def test_each_grey_value_of_an_8_bit_image_has_its_own_bin():
    grey = scene()
    counts, edges = image.histogram(grey)
    np.testing.assert_array_equal(counts, np.bincount(grey.ravel(), minlength=256))
    np.testing.assert_array_equal(edges, np.arange(257) - 0.5)
    other = cv2.calcHist([grey], [0], None, [256], [0, 256]).ravel()
    np.testing.assert_array_equal(counts, other)


# Equalisation


@given(EIGHT_BIT.filter(lambda g: g.min() < g.max()))
def test_equalisation_of_8_bits_is_that_of_opencv(grey):
    found = image.equalize(grey)
    assert found.dtype == np.uint8
    # OpenCV multiplies by a 32 bit 255 / n: a half may fall to the other side
    difference = np.abs(found.astype(int) - cv2.equalizeHist(grey))
    assert difference.max() <= 1
    n = grey.size - np.sum(grey == grey.min())
    share = 255 * (np.searchsorted(np.sort(grey.ravel()), grey, "right") / 1.0)
    share = (share - 255 * np.sum(grey == grey.min())) / n
    half = np.abs(share % 1 - 0.5) < 1e-3
    assert np.all((difference == 0) | half)


@pytest.mark.parametrize("dtype", TYPES)
def test_equalised_values_keep_their_order_and_are_spread_evenly(dtype):
    grey = scene(dtype)
    before = grey.copy()
    found = image.equalize(grey)
    np.testing.assert_array_equal(grey, before)
    assert found.dtype == dtype
    order = np.argsort(grey, axis=None)
    assert np.all(np.diff(found.ravel()[order].astype(float)) >= 0)
    highest = {np.uint8: 255, np.uint16: 65535, float: 1.0}[dtype]
    assert found.min() == 0 and found.max() == highest
    # 8 bits: a dark grey value alone has two per cent of the pixels
    quarters = np.quantile(found, [0.25, 0.5, 0.75]) / highest
    np.testing.assert_allclose(quarters, [0.25, 0.5, 0.75], atol=0.02)


@given(st.floats(0.1, 10), st.floats(-100, 100))
def test_equalising_takes_away_gain_and_offset(gain, offset):
    """Rounded to 1e-6, since sums of floats may tie or part values that are equal."""
    grey = np.round(scene(float), 3)
    found = image.equalize(np.round(gain * grey + offset, 9))
    np.testing.assert_allclose(found, image.equalize(grey), rtol=0, atol=1e-9)


# Gradient


@pytest.mark.parametrize("dtype", TYPES)
def test_gradient_is_half_of_the_sobel_of_size_one_of_opencv(dtype):
    grey = scene(dtype)
    gx, gy = image.gradient(grey)
    assert gx.dtype == gy.dtype == float and gx.shape == gy.shape == grey.shape
    for ours, (dx, dy) in ((gx, (1, 0)), (gy, (0, 1))):
        sobel = cv2.Sobel(grey.astype(float), cv2.CV_64F, dx, dy, ksize=1, scale=0.5)
        inner = np.s_[1:-1, 1:-1]
        np.testing.assert_allclose(ours[inner], sobel[inner], rtol=0, atol=1e-12)
    border = float(grey[7, 1]) - float(grey[7, 0])
    assert gx[7, 0] == border and gy[-1, 5] == float(grey[-1, 5]) - float(grey[-2, 5])


@pytest.mark.parametrize("f", [0.05, 0.2, 0.4])
def test_gradient_sees_a_share_of_the_slope_of_a_wave(f):
    wave = simulate.Texture(np.array([[f, 0.0]]), np.ones(1), np.zeros(1), 0.0)
    grey, _ = simulate.texture_pair(wave, (5, 60), (0, 1, 0, 0, 0, 1))
    rows, columns = np.indices(grey.shape)
    slope = simulate.grey_gradients(wave, np.stack([columns, rows], axis=-1))
    share = np.sin(2 * np.pi * f) / (2 * np.pi * f)
    found = image.gradient(grey)[0][:, 1:-1]
    np.testing.assert_allclose(found, share * slope[:, 1:-1, 0], rtol=0, atol=1e-12)


# Pyramid


@pytest.mark.parametrize("shape", [(64, 48), (61, 45), (33, 70), (9, 10)])
def test_pyramid_is_the_binomial_filter_at_every_second_pixel(shape):
    """Written out by SciPy, whose "mirror" is not its "reflect"."""
    grey = scene(float, shape)[:, ::-1]  # a view that runs backwards
    found = image.pyramid(grey, 3)
    assert len(found) == 3
    expected = grey
    for level in found:
        assert level.dtype == float
        np.testing.assert_allclose(level, expected, rtol=0, atol=1e-11)
        for axis in (0, 1):
            weights = np.array([1, 4, 6, 4, 1]) / 16
            expected = ndimage.correlate1d(expected, weights, axis, mode="mirror")
        expected = expected[::2, ::2]


@pytest.mark.parametrize("shape", [(120, 91), (117, 128)])
def test_pixels_of_level_k_lie_at_2_to_the_k_times_their_coordinates(shape):
    """On a plane, which smoothing leaves alone but for the border."""
    rows, columns = np.indices(shape)
    for k, level in enumerate(image.pyramid(3.0 * columns - 2.0 * rows, 4)):
        r, c = np.indices(level.shape)
        expected = 3.0 * (2**k * c) - 2.0 * (2**k * r)
        inner = np.s_[2:-2, 2:-2]
        np.testing.assert_allclose(level[inner], expected[inner], rtol=0, atol=1e-10)
        assert level.shape == tuple(-(-n // 2**k) for n in shape)


# Bad input


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: image.statistics([[5.0]]), "two pixels or more"),
        (lambda: image.equalize(np.full((3, 3), 7)), "two different grey values"),
        (lambda: image.gradient(np.eye(2)), "at least 3 x 3 pixels"),
        (lambda: image.pyramid(np.eye(9), 4), "levels must be at most 3"),
    ],
)
def test_bad_input_says_what_was_expected(call, message):
    with pytest.raises(ValueError, match=message):
        call()


BYTE_ORDERS = ("<u2", ">u2", "<i4", ">i4", ">f4", ">f8", "u1", "i2", "?")


@pytest.mark.parametrize("dtype", BYTE_ORDERS)
def test_the_byte_order_of_an_image_changes_no_result(dtype):
    """Files of remote sensing are often big-endian; NumPy keeps them so."""
    grey = scene(np.uint8) > 120 if dtype == "?" else scene(np.uint8)
    stored, native = grey.astype(dtype), grey.astype(np.dtype(dtype).newbyteorder("="))
    assert image.statistics(stored) == image.statistics(native)
    for found, expected in zip(
        (*image.histogram(stored), *image.gradient(stored), *image.pyramid(stored, 2)),
        (*image.histogram(native), *image.gradient(native), *image.pyramid(native, 2)),
        strict=True,
    ):
        np.testing.assert_array_equal(found, expected)
    points = [(3.2, 4.7), (20, 10)]
    for method in ("nearest", "bilinear", "cubic", "spline3", "spline5"):
        found, expected = (image.resample(g, points, method) for g in (stored, native))
        np.testing.assert_array_equal(found, expected)
    found, expected = (image.centroid(g[:21, :21]) for g in (stored, native))
    np.testing.assert_array_equal(found.background, expected.background)
    np.testing.assert_array_equal(image.equalize(stored), image.equalize(native))


@pytest.mark.parametrize("dtype", ["i2", ">i4", "<u4", ">f4", "?"])
def test_other_types_are_equalised_to_floats_from_0_to_1(dtype):
    grey = np.array([[0, 1], [1, 1]] if dtype == "?" else [[3, 10], [7, 10]], dtype)
    found = image.equalize(grey)
    assert found.dtype == float and (found.min(), found.max()) == (0, 1)
