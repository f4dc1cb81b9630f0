"""The table of the interpolation bias: repeated in part, and against theory.

The whole is made by ``python -m pgm_book.ch03.studies.interpolation_bias``. What
neither proves: that texture in real photos ends at a sharp cut-off.
"""

import cv2
import numpy as np
import pytest
from scipy import integrate, optimize
from scipy.interpolate import BSpline

from pgm_book.ch03.studies import interpolation_bias as study
from pgm_book.common import results
from pgm_lab import image

TABLE = results.rows("ch03", "interpolation_bias")
METHODS = study.ALL
SOFT_AND_SHARP = pytest.mark.parametrize(
    "kind", [pytest.param("soft", marks=pytest.mark.slow), "sharp"]
)


def column(kind, method, name):
    rows = [r for r in TABLE if (r["texture"], r["method"]) == (kind, method)]
    return np.array([float(row[name] or "nan") for row in rows])


def largest(kind, method, name="bias_px"):
    return np.abs(column(kind, method, name)).max()


# Weights of the pixels -2 ... 3 at t, written down apart from the package


def keys(t, a):
    s = np.abs(np.arange(-2, 4) - t)
    near = (a + 2) * s**3 - (a + 3) * s**2 + 1
    far = a * s**3 - 5 * a * s**2 + 8 * a * s - 4 * a
    return np.where(s < 1, near, np.where(s < 2, far, 0))


LOCAL = {
    "bilinear": lambda t: np.array([0, 0, 1 - t, t, 0, 0]),
    "cubic": lambda t: keys(t, -0.5),
    study.OPENCV: lambda t: keys(t, -0.75),
}


def response(method, f, t):
    """What interpolation at t makes of the wave exp(2 pi i f x), over the truth."""
    k = np.arange(-2, 4)
    truth = np.exp(2j * np.pi * f * t)
    if method in LOCAL:
        return LOCAL[method](t) @ np.exp(2j * np.pi * f * k) / truth
    degree = int(method[-1])
    half = (degree + 1) / 2
    b = BSpline.basis_element(np.arange(degree + 2) - half, extrapolate=False)
    k = np.arange(-4, 6)
    wave = np.exp(2j * np.pi * f * k)
    # A spline is the sum of basis functions times the filtered pixels
    return np.nan_to_num(b(t - k)) @ wave / (np.nan_to_num(b(-k)) @ wave) / truth


def expected(kind, method, t):
    """Mean bias: the phase error of each wave, weighted by its part in the slope.

    Frequencies spread evenly over a disc have the density sqrt(c^2 - f^2) along x.
    """
    c = study.CUTOFFS[kind]

    def density(f):
        return np.sqrt(c**2 - f**2)

    phase, _ = integrate.quad(
        lambda f: density(f) * f * response(method, f, t).imag, 0, c
    )
    slope, _ = integrate.quad(lambda f: density(f) * 2 * np.pi * f**2, 0, c)
    return phase / slope


@SOFT_AND_SHARP
@pytest.mark.parametrize("method", [*study.METHODS[1:], study.OPENCV])
def test_bias_is_the_phase_error_of_the_interpolation_averaged_over_the_waves(
    kind, method
):
    mean, sd = (column(kind, method, name) for name in ("bias_px", "sd_px"))
    theory = [expected(kind, method, t) for t in study.POSITIONS]
    # Mean of 40 textures: four and a half of its standard deviations, as 21 positions
    # and 10 curves are looked at; and the six printed decimals
    off = np.abs(mean - theory)
    assert np.all(off <= 4.5 * sd / np.sqrt(40) + 1e-6), off.max()


HALF = study.POSITIONS <= 0.5  # the matches beyond mirror these
SLOPES = {"right": np.sin, "left": lambda w: w}  # by (B 2.12), or the true ones


def match_column(kind, method, name):
    return column(kind, method, name)[HALF]


def expected_match(kind, method, slopes, t):
    """Where a match converges: its slopes A' and what is left of A add up to zero.

    Of a wave exp(i w x) the resampled window shows |H| of the height, rotated by arg H;
    h0 and h1 drop out. With slopes S(w) the sum of S |H| sin(w e + arg H) is zero. The
    slopes of the right window are damped by H and by (B 2.12) to sin(w).
    """
    c = study.CUTOFFS[kind]
    f = (np.arange(120) + 0.5) / 120 * c
    weight = np.sqrt(c**2 - f**2) * SLOPES[slopes](2 * np.pi * f)

    def normal_equation(e):
        H = np.array([response(method, wave, t + e) for wave in f])
        return weight @ (H * np.exp(2j * np.pi * f * e)).imag

    return optimize.brentq(normal_equation, -0.15, 0.15)


@pytest.mark.parametrize("slopes", SLOPES)
@SOFT_AND_SHARP
@pytest.mark.parametrize("method", [*study.METHODS[1:], study.OPENCV])
def test_converged_matches_rest_where_the_theory_of_waves_says(kind, method, slopes):
    mean, sd, n = (
        match_column(kind, method, f"{slopes}_slopes_{name}")
        for name in ("px", "sd_px", "converged")
    )
    whole = np.flatnonzero(n >= 35)  # of 40: the others would be a selection
    assert len(whole) >= 5
    some = whole[2::4]
    theory = [expected_match(kind, method, slopes, t) for t in study.POSITIONS[some]]
    # As above, and three per cent for the second order in windows of 21 px
    off = mean[some] - theory
    allowed = 4.5 * sd[some] / np.sqrt(n[some]) + 0.03 * np.abs(theory) + 2e-6
    assert np.all(np.abs(off) <= allowed), off


@pytest.mark.parametrize("slopes", SLOPES)
@pytest.mark.parametrize("method", [*study.METHODS[1:], study.OPENCV, study.LSM])
def test_on_soft_texture_a_match_errs_by_as_much_as_one_step_the_other_way(
    method, slopes
):
    """To nine per cent; the curve itself is shifted by what the match errs."""
    one_step = column("soft", method, "bias_px")[HALF]
    match = match_column("soft", method, f"{slopes}_slopes_px")
    here, there = (values[np.abs(values).argmax()] for values in (one_step, match))
    assert there == pytest.approx(-here, rel=0.09, abs=4e-6)


@pytest.mark.parametrize(
    ("method", "right", "left"),
    [
        ("bilinear", 1.07, 1.32),
        ("cubic", 0.91, 1.11),
        ("spline3", 0.74, 1.04),
        ("spline5", 0.66, 1.01),
        (study.OPENCV, 0.50, 1.06),
        (study.LSM, 0.65, 1.00),
    ],
)
def test_on_sharp_texture_it_errs_the_other_way_but_not_by_as_much(method, right, left):
    """Largest of a converged match over that of one step with the true slopes."""
    one_step = column("sharp", method, "bias_px")[HALF]
    for slopes, ratio in (("right", right), ("left", left)):
        match = match_column("sharp", method, f"{slopes}_slopes_px")
        largest = np.nanargmax(np.abs(match))
        assert np.sign(match[largest]) == -np.sign(one_step[largest])
        found = np.nanmax(np.abs(match)) / np.abs(one_step).max()
        assert found == pytest.approx(ratio, abs=0.015)


def test_bilinear_with_slopes_of_the_right_photo_often_finds_no_rest_on_sharp_texture():
    for method in ("bilinear", "cubic"):
        rested = match_column("sharp", method, "right_slopes_converged")
        assert rested[:4].min() == 40 and rested[-3:].max() <= 1
    for method in ("spline3", "spline5", study.OPENCV, study.LSM):
        assert match_column("sharp", method, "right_slopes_converged").min() >= 35
    for method in (*study.METHODS[1:], study.OPENCV, study.LSM):
        for kind in study.CUTOFFS:
            assert match_column(kind, method, "left_slopes_converged").min() == 40


@pytest.mark.parametrize("kind", study.CUTOFFS)
def test_nearest_pixel_moves_a_texture_by_the_whole_fraction(kind):
    """To 13 per cent only, since one step of least squares is not enough for 0.5 px."""
    position = study.POSITIONS
    expected = np.floor(position + 0.5 + 1e-9) - position
    found = column(kind, "nearest", "bias_px")
    np.testing.assert_allclose(found, expected, rtol=0.13, atol=1e-6)


@pytest.mark.parametrize(
    ("method", "soft", "sharp"),
    [
        ("bilinear", 0.012, 0.044),
        ("cubic", 0.013, 0.054),
        ("spline3", 0.0007, 0.017),
        ("spline5", 0.00003, 0.005),
        (study.OPENCV, 0.032, 0.022),
        (study.LSM, 0.00003, 0.0005),
    ],
)
def test_largest_bias_is_that_of_the_text(method, soft, sharp):
    """On soft texture OpenCV's cubic is worse than bilinear; that of lsm is best."""
    assert largest("soft", method) == pytest.approx(soft, rel=0.1, abs=1e-5)
    assert largest("sharp", method) == pytest.approx(sharp, rel=0.05, abs=5e-4)


@pytest.mark.parametrize("kind", study.CUTOFFS)
def test_grey_values_order_the_methods_differently_than_shifts_do(kind):
    grey = [largest(kind, m, "rms_grey") for m in METHODS]
    nearest, bilinear, cubic, spline3, spline5, opencv, _ = grey
    assert nearest > bilinear > max(cubic, opencv) > min(cubic, opencv) > spline3
    assert spline3 > spline5
    assert largest(kind, "cubic") > largest(kind, "bilinear")


@pytest.mark.parametrize("kind", study.CUTOFFS)
@pytest.mark.parametrize("method", METHODS)
def test_eight_parameters_do_not_take_the_bias_away(kind, method):
    two, eight = (column(kind, method, n) for n in ("bias_px", "bias_8_px"))
    np.testing.assert_allclose(eight, two, rtol=0.05, atol=6e-4)


@pytest.mark.slow
@SOFT_AND_SHARP
def test_the_script_still_says_what_the_table_does(kind):
    """Three textures: biases as of forty, within the scatter of textures."""
    positions = study.POSITIONS[[3, 5, 14]]
    for row in study.rows(kind, 3, positions):
        new = dict(zip(study.COLUMNS, row, strict=True))
        keys = ("texture", "method", "position")
        (stored,) = [t for t in TABLE if all(t[k] == new[k] for k in keys)]
        bias, sd = float(stored["bias_px"]), float(stored["sd_px"])
        assert abs(float(new["bias_px"]) - bias) <= 4 * sd / np.sqrt(3) + 1e-6
        grey = float(stored["rms_grey"])
        assert float(new["rms_grey"]) == pytest.approx(grey, rel=0.25, abs=1e-3)
        for slopes in SLOPES:
            name, spread = f"{slopes}_slopes_px", f"{slopes}_slopes_sd_px"
            assert (new[name] == "") >= (stored[name] == "")
            if new[name]:
                off = abs(float(new[name]) - float(stored[name]))
                assert off <= 4 * float(stored[spread]) / np.sqrt(2) + 1e-6


def test_opencv_cubic_of_the_study_is_that_of_opencv():
    """At multiples of 1/32 px, to which older OpenCV rounds the coordinates."""
    rng = np.random.default_rng(2)
    grey = rng.uniform(0, 255, (30, 40))
    x, y = rng.integers(4 * 32, 25 * 32, (2, 100)) / 32
    theirs = cv2.remap(
        grey, x.astype(np.float32), y.astype(np.float32), cv2.INTER_CUBIC
    )
    points = np.stack([x, y], axis=-1)
    # OpenCV's weights are 32 bit floats
    np.testing.assert_allclose(
        study.opencv_cubic(grey, points), theirs.ravel(), rtol=0, atol=1e-3
    )
    keys = image.resample(grey, points, "cubic")
    assert np.abs(keys - theirs.ravel()).max() > 1


def test_table_is_complete():
    assert tuple(TABLE[0]) == study.COLUMNS
    assert len(TABLE) == 2 * len(METHODS) * len(study.POSITIONS)
    assert {row["textures"] for row in TABLE} == {"40"}
