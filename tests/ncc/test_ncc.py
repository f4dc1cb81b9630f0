"""Normalized cross correlation against its definition, other programs and the truth."""

from fractions import Fraction

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.lib.stride_tricks import sliding_window_view
from scipy import stats
from skimage.feature import match_template

from pgm_lab import ncc, simulate
from pgm_lab.ncc import _map

RNG = np.random.default_rng(2)
RANDOM = np.random.default_rng(3).normal(size=(5, 5))
TEXTURE = simulate.texture(0.2, seed=4)
# float64 sums of some hundred products; the smallest contrasts below cost some digits
ROUNDING = 1e-9


@pytest.fixture(autouse=True)
def _the_same_numbers_in_any_order():
    RNG.bit_generator.state = np.random.default_rng(2).bit_generator.state


def by_definition(template, search):
    """(2.6f) for every position, means subtracted in float64; 0 where flat."""
    t = template.astype(float) - template.astype(float).mean()
    result = []
    for row in sliding_window_view(search.astype(float), t.shape):
        windows = row - row.mean(axis=(1, 2), keepdims=True)
        products, squares = (np.sum(f * windows, axis=(1, 2)) for f in (t, windows))
        norms = np.sqrt(np.sum(t * t)) * np.sqrt(squares)
        result.append(
            np.divide(products, norms, 0 * norms, where=np.ptp(row, axis=(1, 2)) > 0)
        )
    return np.array(result)


def exact_r(a, b):
    """r in rational arithmetic up to the last square root."""
    a, b = ([Fraction(float(v)) for v in np.ravel(x)] for x in (a, b))
    n = len(a)

    def s(p, q):
        return n * sum(x * y for x, y in zip(p, q, strict=True)) - sum(p) * sum(q)

    squared = s(a, b) ** 2 / (s(a, a) * s(b, b))
    return (1 if s(a, b) > 0 else -1) * float(squared) ** 0.5


# -- two windows


def test_correlation_is_that_of_numpy_and_scipy():
    a, b = RNG.normal(size=(2, 21, 21))
    r = ncc.correlation(a, b)
    assert r == pytest.approx(np.corrcoef(a.ravel(), b.ravel())[0, 1], abs=1e-15)
    assert r == pytest.approx(stats.pearsonr(a.ravel(), b.ravel())[0], abs=1e-15)


@given(
    gain=st.floats(0.01, 100),
    offset=st.floats(-1e4, 1e4),
    seed=st.integers(0, 1000),
)
def test_correlation_knows_no_gain_and_no_offset_and_its_sign_follows_the_gain(
    gain, offset, seed
):
    a, b = np.random.default_rng(seed).uniform(0, 255, (2, 7, 9))
    r = ncc.correlation(a, b)
    assert ncc.correlation(gain * a + offset, b) == pytest.approx(r, abs=ROUNDING)
    assert ncc.correlation(-gain * a + offset, b) == pytest.approx(-r, abs=ROUNDING)
    assert ncc.correlation(b, a) == pytest.approx(r, abs=1e-15)
    assert ncc.correlation(a, gain * a + offset) == pytest.approx(1, abs=ROUNDING)
    assert -1 <= r <= 1


def test_correlation_keeps_all_digits_where_the_computing_form_loses_them():
    """16 bit, offset 60000, contrast 0.5: the computing form loses ten of 16 digits."""
    a, b = 60000 + RNG.integers(0, 2, (2, 51, 51))
    truth = exact_r(a, b)
    assert ncc.correlation(a, b) == pytest.approx(truth, abs=1e-15)
    a, b = 1e7 + RNG.integers(0, 2, (2, 51, 51)) / 3
    truth = exact_r(a, b)
    assert ncc.correlation(a, b) == pytest.approx(truth, abs=1e-12)
    assert abs(ncc.regression(a, b).r - truth) > 1e-4


def test_regression_is_that_of_scipy():
    a, b = RNG.uniform(0, 255, (2, 15, 15))
    line = stats.linregress(a.ravel(), b.ravel())
    ours = ncc.regression(a, b)
    assert ours.alpha == pytest.approx(line.intercept, rel=1e-12)
    assert ours.beta == pytest.approx(line.slope, rel=1e-12)
    assert ours.r == pytest.approx(line.rvalue, rel=1e-12)


def test_regression_says_so_when_no_digit_is_left():
    a = 1e9 + RNG.integers(0, 2, (3, 3))
    with pytest.raises(ValueError, match="lost all digits"):
        for offset in range(100):  # by chance rounding leaves something positive
            ncc.regression(a + offset * 1e8, a)


# -- the map


def test_map_is_that_of_opencv_and_skimage_where_these_are_good():
    search = RNG.integers(0, 256, (51, 51), dtype=np.uint8)
    template = search[7:28, 20:41]
    r = ncc.correlation_map(template, search)
    assert r.shape == (31, 31) and r.dtype == np.float64
    assert r[7, 20] == pytest.approx(1, abs=1e-14)
    opencv = cv2.matchTemplate(search, template, cv2.TM_CCOEFF_NORMED)
    np.testing.assert_allclose(r, opencv, atol=2e-6)  # OpenCV works in float32
    np.testing.assert_allclose(r, match_template(search, template), atol=1e-12)


AWKWARD = {  # contrasts of the positions differ by up to 1e6
    "noise": lambda g, i, j: g,
    "offset": lambda g, i, j: 60000 + g / 10,
    "step": lambda g, i, j: g + 1e5 * (j > 5),
    "slope": lambda g, i, j: g + 1000 * i,
    "spike": lambda g, i, j: np.where((i == 3) & (j == 4), 6e4, g),
    "faint half": lambda g, i, j: np.where(i < 7, 100 + 1e-6 * g, g),
    "flat above": lambda g, i, j: np.where((i < 8) & (j > 0), 255, g),
    "flat below": lambda g, i, j: np.where((i > 8) & (j < 9), 255, g),
}


@settings(max_examples=60)
@given(
    kind=st.sampled_from(sorted(AWKWARD)),
    dtype=st.sampled_from([np.uint8, np.uint16, np.float32, np.float64]),
    size=st.tuples(st.integers(2, 9), st.integers(1, 9)),
    more=st.tuples(*[st.integers(0, 12)] * 2),
    seed=st.integers(0, 10**6),
)
def test_map_is_the_definition_to_1e_6_also_where_contrasts_differ(
    kind, dtype, size, more, seed
):
    rng = np.random.default_rng(seed)
    shape = np.add(size, more)
    search = AWKWARD[kind](rng.normal(100, 20, shape), *np.indices(shape))
    if np.issubdtype(dtype, np.integer):
        search = np.clip(search, 0, np.iinfo(dtype).max).round()
    search = search.astype(dtype)
    template = rng.integers(0, 255, size).astype(dtype)
    template[0, 0] = template[-1, -1] + 1  # not flat
    r = ncc.correlation_map(template, search)
    np.testing.assert_allclose(r, by_definition(template, search), rtol=0, atol=1e-6)


def whole_map(template, search):
    """The map of 8 bit grey values, all sums in whole numbers of 64 bits."""
    t, n = template.astype(np.int64), template.size
    s = sliding_window_view(search.astype(np.int64), t.shape)
    total = s.sum(axis=(2, 3))
    covariance = n * np.einsum("ijkl,kl->ij", s, t) - total * t.sum()
    variance = n * np.einsum("ijkl,ijkl->ij", s, s) - total**2
    norms = np.sqrt(n * np.sum(t * t) - t.sum() ** 2) * np.sqrt(variance)
    return np.divide(covariance, norms, out=np.zeros(norms.shape), where=norms > 0)


EIGHT_BIT = {  # also such that no photo comes near to
    "noise": lambda g, i, j: g,
    "texture": lambda g, i, j: cv2.GaussianBlur(g.astype(float), (0, 0), 1.5),
    "one grey value of contrast": lambda g, i, j: 250 + (g < 128),
    "one grey value, once": lambda g, i, j: np.where(
        (i == len(i) // 2) & (j == len(i) // 3), 251, 250
    ),
    "saturated": lambda g, i, j: np.where(
        i < len(i) // 2, 255, np.clip(3 * g - 100, 0, 255)
    ),
    "black and white": lambda g, i, j: np.where(g < 128, 0, 255),
    "stripes": lambda g, i, j: np.where(j // 3 % 2, 255, 0),
    "faint beside a step": lambda g, i, j: np.where(2 * j < len(i), 250 + (g < 128), 0),
}


def eight_bit(kind, rng, size):
    grey = rng.integers(0, 256, (size, size))
    return EIGHT_BIT[kind](grey, *np.indices(grey.shape)).astype(np.uint8)


@pytest.mark.parametrize(("width", "size"), [(3, 9), (11, 51), (21, 23), (21, 51)])
@pytest.mark.parametrize("kind", EIGHT_BIT)
def test_map_of_8_bit_is_that_of_whole_numbers(kind, width, size):
    search = eight_bit(kind, np.random.default_rng(size), size)
    top, left = size // 2 - width // 2, size // 3 - width // 3
    template = search[top : top + width, left : left + width]
    r = ncc.correlation_map(template, search)
    np.testing.assert_allclose(r, whole_map(template, search), rtol=0, atol=1e-12)
    assert np.abs(r).max() <= 1


@pytest.mark.parametrize("error", [0.2, 0.3, 0.9, 1.0, 5.3])
def test_sums_that_opencv_did_not_get_whole_are_not_taken(error, monkeypatch):
    """Whatever the precision of its transforms: their fractions tell the error."""
    search = eight_bit("texture", RNG, 51)
    template = search[10:31, 12:33]
    truth, exact = whole_map(template, search), cv2.matchTemplate

    def in_low_precision(*args):
        sums = exact(*args)
        noise = np.random.default_rng(1).uniform(-error, error, sums.shape)
        return sums + noise.astype(np.float32)

    monkeypatch.setattr(cv2, "matchTemplate", in_low_precision)
    taken = _map._from_whole_sums(template, search) is not None
    assert taken == (error < 0.25)
    r = ncc.correlation_map(template, search)
    np.testing.assert_allclose(r, truth, rtol=0, atol=1e-12)


def test_single_precision_is_not_asked_for_what_it_cannot_hold():
    """Norms so large that the fractions of the sums would be lost."""
    search = eight_bit("black and white", RNG, 50)
    for width, taken in ((5, True), (21, False)):
        template = search[5 : 5 + width, 7 : 7 + width]
        assert (_map._from_whole_sums(template, search) is not None) == taken
        r = ncc.correlation_map(template, search)
        np.testing.assert_allclose(r, whole_map(template, search), atol=1e-12)


OTHER_TYPES = [
    pytest.param(one, marks=pytest.mark.slow)
    for one in (np.uint8, np.float32, np.float64)
]


@pytest.mark.parametrize("dtype", [np.uint16, *OTHER_TYPES])
def test_a_large_map_is_put_together_from_tiles(dtype):
    """Two by three, the last ones smaller; contrasts differ between them."""
    search = RNG.integers(0, 100, (250, 380)).astype(dtype)
    search[:, :200] *= 2
    search[180:, 300:] = 7
    template = search[100:121, 190:205]
    r = ncc.correlation_map(template, search)
    np.testing.assert_allclose(r, by_definition(template, search), atol=ROUNDING)
    assert np.all(r[180:, 300:] == 0)


def test_map_of_a_stack_is_the_stack_of_maps():
    searches = RNG.integers(0, 256, (3, 70, 31, 33)).astype(np.uint8)  # several chunks
    templates = RNG.integers(0, 256, (70, 5, 7)).astype(np.uint8)
    r = ncc.correlation_map(templates, searches)
    assert r.shape == (3, 70, 27, 27)
    for i, j in [(0, 0), (1, 69), (2, 33)]:
        alone = ncc.correlation_map(templates[j], searches[i, j])
        np.testing.assert_allclose(r[i, j], alone, atol=1e-12)


@pytest.mark.parametrize("size", [(1, 5), (5, 1), (1, 2)])
def test_templates_of_one_row_or_column_with_flat_places(size):
    search = RNG.integers(0, 3, (12, 13)).astype(float)
    search[4:9] = 2.0
    search[0, 0] = 1e9  # everything else is faint beside it
    template = np.arange(size[0] * size[1], dtype=float).reshape(size)
    r = ncc.correlation_map(template, search)
    np.testing.assert_allclose(r, by_definition(template, search), atol=1e-9)


def test_inputs_are_not_changed_and_may_be_views():
    search = RNG.integers(0, 256, (60, 62)).astype(np.uint8)[::-2, ::2]
    search.flags.writeable = False
    before = search.copy()
    r = ncc.correlation_map(search[3:10, 5:12], search)
    np.testing.assert_allclose(r, by_definition(search[3:10, 5:12], search), atol=1e-12)
    np.testing.assert_array_equal(search, before)


@pytest.mark.parametrize(
    ("a", "b", "words"),
    [
        (RANDOM, np.full((5, 5), 7), "b is flat: all its grey values are 7"),
        (np.zeros((5, 5)), RANDOM, "a is flat"),
        (RANDOM, RANDOM[1:], "same shape"),
        ([1.0], [2.0], "two pixels"),
    ],
)
def test_windows_that_have_no_correlation(a, b, words):
    for function in (ncc.correlation, ncc.regression):
        with pytest.raises(ValueError, match=words):
            function(a, b)


@pytest.mark.parametrize(
    ("template", "search", "words"),
    [
        (RANDOM, RANDOM[1:], "larger than search"),
        (np.ones((3, 3)), RANDOM, "template is flat"),
        (np.stack([RANDOM] * 2), np.stack([RANDOM] * 3), "do not broadcast"),
    ],
)
def test_windows_that_have_no_map(template, search, words):
    with pytest.raises(ValueError, match=words):
        ncc.correlation_map(template, search)


# -- many points


def grid(low, high, step):
    columns, rows = np.meshgrid(np.arange(low, high, step), np.arange(low, high, step))
    return np.column_stack([columns.ravel(), rows.ravel()]).astype(float)


@pytest.fixture(scope="module")
def noise():
    """A left image of white noise, and the right one shifted by (-5, 3)."""
    left = np.random.default_rng(6).integers(0, 256, (150, 160)).astype(np.uint8)
    return left, np.roll(left, (3, -5), axis=(0, 1))


@pytest.mark.parametrize("refine", [None, "parabola"])
def test_match_finds_whole_pixels(noise, refine):
    points = grid(40, 110, 3)  # more than one chunk
    found = ncc.match(*noise, points, refine=refine)
    assert set(found.status) == {"accepted"}
    # 0.03 px: the map of noise is not quite symmetrical about its peak
    tolerance = 0 if refine is None else 0.03
    np.testing.assert_allclose(
        found.points - points, [[-5, 3]] * len(points), atol=tolerance
    )
    np.testing.assert_allclose(found.r, 1, atol=1e-12)
    assert found.second.max() < 0.5


def test_match_adds_the_fraction_of_a_pixel_that_was_rounded_off(noise):
    points = np.array([[60.25, 61.5], [59.5, 60.9], [70.0, 70.49]])
    start = points + [[-5.4, 3.3]]
    found = ncc.match(*noise, points, start, search=31)
    np.testing.assert_allclose(found.points - points, [[-5, 3]] * 3, atol=1e-12)


def test_without_another_peak_the_second_is_minus_one():
    y, x = np.mgrid[:21, :21] - 10.0
    bump = 100 * np.exp(-(x**2 + y**2) / 60)
    found = ncc.match(bump, bump, [(10, 10)], template=15, search=17)
    assert found.status[0] == "accepted" and found.second[0] == -1


# -- statuses


def test_template_and_search_window_that_leave_the_image(noise):
    left, right = noise
    points = [(10, 60), (9, 60), (80, 139), (80, 140), (149, 60), (150, 60), (60, 9.4)]
    found = ncc.match(left, right, points, [(80, 70)] * 7, search=31)
    leaves = found.status == "template leaves the image"
    np.testing.assert_array_equal(leaves, [0, 1, 0, 1, 0, 1, 1])
    # Of a window of 31 that reaches 21 pixels into the image one position is left
    start = [(5, 60), (4, 60), (80, 144), (80, 145), (154, 60), (155, 60), (1e9, 60)]
    found = ncc.match(left, right, [(80, 70)] * 7, start, search=31)
    leaves = found.status == "window leaves the image"
    np.testing.assert_array_equal(leaves, [0, 1, 0, 1, 0, 1, 1])
    np.testing.assert_array_equal(found.points[[0, 2, 4], [0, 1, 0]], (10, 139, 149))
    for values in (found.points[leaves], found.r[leaves], found.second[leaves]):
        assert np.all(np.isnan(values))


def test_flat_template_and_flat_search_window(noise):
    left, right = (image.copy() for image in noise)
    left[40:61, 40:61] = 200
    right[75:126, 75:126] = 255
    found = ncc.match(left, right, [(50, 50), (100, 100), (51, 50)])
    assert list(found.status[:2]) == ["flat template", "flat window"]
    assert found.status[2] != "flat template"
    assert np.all(np.isnan(found.points[:2])) and np.all(np.isnan(found.r[:2]))


def test_peak_on_the_border_of_the_search_window(noise):
    # five pixels to the left lies on the border when five pixels are searched
    found = ncc.match(*noise, [(80, 80)] * 2, template=21, search=31)
    assert set(found.status) == {"peak on the border of the search"}
    np.testing.assert_array_equal(found.points, [(75, 83)] * 2)
    assert found.r[0] == pytest.approx(1)
    assert np.all(np.isnan(found.covariance))
    assert ncc.match(*noise, [(80, 80)], search=33).status[0] == "accepted"


def test_below_threshold(noise):
    left, right = noise
    other = np.random.default_rng(9).normal(size=right.shape)
    found = ncc.match(left, other, grid(40, 110, 12), search=51)
    rejected = found.status == "below threshold"
    assert rejected.mean() > 0.6  # the others have their highest value on the border
    assert np.all(found.r < 0.7) and not np.any(found.status == "accepted")
    assert np.all(np.isfinite(found.points[rejected]))


def test_ambiguous_where_the_texture_repeats():
    tile = np.random.default_rng(3).integers(0, 256, (12, 12))
    left = np.tile(tile, (12, 12)).astype(np.uint8)
    found = ncc.match(left, left, [(70, 70)], search=51)
    assert found.status[0] == "ambiguous" and found.second[0] > 0.999
    assert ncc.match(left, left, [(70, 70)], search=31).status[0] == "accepted"
    noisy = left + np.random.default_rng(3).normal(0, 40, left.shape)
    found = ncc.match(left, noisy, [(70, 70)], search=51)
    assert found.status[0] == "ambiguous" and found.r[0] < 0.9
    once = ncc.match(left, noisy, [(70, 70)], search=51, ratio=1)
    assert once.status[0] == "accepted"  # nobody asked


def test_ridge_instead_of_a_peak_on_an_edge():
    """Along a straight edge nothing tells one position from the next."""
    edge = np.where(np.arange(100) < 50, 50.0, 200.0) + np.zeros((100, 1))
    edge = cv2.GaussianBlur(edge, (0, 0), 2)
    points = grid(46, 56, 2)
    found = ncc.match(edge, edge, points, template=11, search=31, ratio=1)
    assert "accepted" not in found.status
    assert "position not determined" in found.status
    rng = np.random.default_rng(8)
    left, right = edge + rng.normal(0, 3, (2, *edge.shape))
    found = ncc.match(left, right, points, template=11, search=31)
    # Noise makes peaks along the ridge, one as high as the other
    assert "accepted" not in found.status and "ambiguous" in found.status


@given(seed=st.integers(0, 10**6))
@settings(max_examples=25)
def test_what_is_matched_is_finite_and_above_the_threshold(seed):
    rng = np.random.default_rng(seed)
    left = rng.integers(0, 256, (60, 60)).astype(float)
    right = left + rng.normal(0, rng.choice([0, 5, 50, 200]), left.shape)
    right[rng.integers(60) :] = rng.choice([0, 255])
    points = rng.uniform(-5, 65, (30, 2))
    refine = rng.choice([None, "parabola"])
    found = ncc.match(left, right, points, template=7, search=15, refine=refine)
    good = found.status == "accepted"
    assert np.all(np.isfinite(found.points[good]))
    assert np.all(np.isfinite(found.covariance[good]))
    # Without noise it is d d', with one variance that is zero up to rounding
    assert np.all(np.linalg.eigvalsh(found.covariance[good]) >= -1e-12)
    assert np.all(found.r[good] >= 0.7)
    assert np.all(np.isnan(found.covariance[~good]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": [(50, 50)] * 2}, r"start must have shape \(1, 2\)"),
        ({"template": 20}, "template must be an odd number"),
        ({"search": 21}, "at least template . 2"),
        ({"threshold": 1.5}, "threshold must lie between"),
        ({"ratio": 0}, "ratio must be above 0"),
        ({"search": (31, 21)}, "at least template . 2"),
        ({"lines": [(0, 0, 1)]}, r"lines.0. have a = b = 0"),
        ({"distance": 0.4}, "distance must be at least 0.5 px"),
        ({"back": 0}, "back must be positive"),
    ],
)
def test_match_refuses(noise, change, message):
    arguments = {"left": noise[0], "right": noise[1], "points": [(50, 50)]}
    with pytest.raises(ValueError, match=message):
        ncc.match(**(arguments | change))


# -- sub-pixel


def repeated(sigma, shift, times=30, refine="parabola", texture=TEXTURE):
    points = grid(40, 200, 22)
    affine = (shift[0], 1, 0, shift[1], 0, 1)
    found = []
    for seed in range(times):
        left, right = simulate.texture_pair(
            texture, (240, 240), affine, gain=1.08, offset=4, sigma=sigma, seed=seed
        )
        found.append(ncc.match(left, right, points, search=31, refine=refine))
    errors = np.array([m.points for m in found]) - points - shift
    return errors, np.array([m.covariance for m in found])


@pytest.mark.parametrize("sigma", [2, pytest.param(5, marks=pytest.mark.slow)])
@pytest.mark.parametrize("cutoff", [0.1, 0.2, 0.35])
@pytest.mark.parametrize("moved", [False, True])
def test_covariance_of_the_parabola_is_the_error_over_points(cutoff, moved, sigma):
    """RMS over the predicted SD: for windows that differ in noise only from 0.9 to 1.1,
    with random shifts from 0.8 to 1.2. Pixel locking is predicted from the template's
    curvature alone, a little large for soft and too small for sharp texture; without
    it the sharp would have 2.1 to 2.3, without the template's own asymmetry the soft,
    unmoved, 1.4 to 2.5."""
    errors, predicted = [], []
    rng = np.random.default_rng(3)
    points = grid(40, 260, 24)
    for seed in range(10 if moved else 3):
        shift = rng.uniform(-0.5, 0.5, 2) * moved
        left, right = simulate.texture_pair(
            simulate.texture(cutoff, seed=seed),
            *((300, 300), (shift[0], 1, 0, shift[1], 0, 1)),
            **{"gain": 1.08, "offset": 4, "sigma": sigma, "seed": seed},
        )
        found = ncc.match(left, right, points, search=31, refine="parabola")
        good = found.status == "accepted"
        assert good.mean() > 0.95
        errors.append((found.points - points - shift)[good])
        predicted.append(np.diagonal(found.covariance, axis1=1, axis2=2)[good])
    ratio = np.sqrt(
        np.mean(np.square(np.concatenate(errors))) / np.mean(np.concatenate(predicted))
    )
    low, high = (0.8, 1.2) if moved else (0.9, 1.1)
    assert low < ratio < high


def test_covariance_of_the_parabola_at_the_edge_of_the_left_image():
    """There the row beyond the template is missing; still 0.75 to 1.25."""
    errors, predicted = [], []
    for seed in range(30):
        right, left = simulate.texture_pair(
            simulate.texture(0.2, seed=seed),
            *((60, 300), (0, 1, 0, 0, 0, 1)),
            **{"sigma": 2.0, "seed": seed},
        )
        points = np.column_stack([np.arange(30, 280, 24), np.full(11, 20)]) * 1.0
        found = ncc.match(
            left[10:], right, points - [0, 10], points, search=31, refine="parabola"
        )
        assert set(found.status) == {"accepted"}
        errors.append(found.points - points)
        predicted.append(np.diagonal(found.covariance, axis1=1, axis2=2))
    ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(predicted))
    assert 0.75 < ratio < 1.25


def test_positions_of_the_parabola_are_the_textbooks():
    """The errors that the covariance knows are not taken off the position."""
    left, right = simulate.texture_pair(TEXTURE, (60, 60), (0.2, 1, 0, -0.3, 0, 1))
    found = ncc.match(left, right, [(30, 30)], search=31, refine="parabola")
    r = ncc.correlation_map(left[20:41, 20:41], right[19:42, 19:42])
    D = np.array([r[1, 2] - r[1, 0], r[2, 1] - r[0, 1]]) / 2
    Kxy = (r[0, 2] + r[2, 0] - r[0, 0] - r[2, 2]) / 4
    K = [
        [2 * r[1, 1] - r[1, 2] - r[1, 0], Kxy],
        [Kxy, 2 * r[1, 1] - r[2, 1] - r[0, 1]],
    ]
    np.testing.assert_allclose(found.points[0] - 30, np.linalg.solve(K, D), atol=1e-9)


def test_covariance_of_whole_pixels_is_that_of_rounding():
    points = grid(40, 200, 12)
    rng = np.random.default_rng(4)
    errors, covariance = [], []
    for seed in range(12):
        shift = rng.uniform(-0.5, 0.5, 2)
        affine = (shift[0], 1, 0, shift[1], 0, 1)
        pair = simulate.texture_pair(TEXTURE, (240, 240), affine, sigma=5.0, seed=seed)
        found = ncc.match(*pair, points, search=31)
        errors.append(found.points - points - shift)
        covariance.append(found.covariance)
    scatter = np.mean(np.square(errors), axis=(0, 1))
    np.testing.assert_allclose(scatter, 1 / 12, rtol=0.5)  # only twelve shifts
    predicted = np.mean(covariance, axis=(0, 1)).diagonal()
    np.testing.assert_allclose(predicted, 1 / 12, rtol=0.05)


def test_parabola_is_biased_towards_whole_pixels_and_not_at_all_by_symmetry_at_half():
    """Fine texture, no noise: the error is an odd function of the shift."""
    texture = simulate.texture(0.35, seed=2)
    bias = {}
    for shift in (0.0, 0.25, 0.75):
        errors, _ = repeated(0.0, (shift, 0.0), times=1, texture=texture)
        bias[shift] = errors[0, :, 0].mean()
    assert abs(bias[0.0]) < 0.004
    assert -0.08 < bias[0.25] < -0.01
    assert 0.01 < bias[0.75] < 0.08
