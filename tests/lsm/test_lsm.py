"""Least squares matching against known truth and against the dense adjustment.

Not proven here: what happens where (2.7) to (2.9) do not hold, as at a roof's edge.
How precise it is, and how well it knows that, is in test_lsm_statistics.py.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pgm_lab import lsm, simulate
from pgm_lab.lsm import _iteration, _normal_equations, half_pixels

AFFINE = (3.3, 1.015, 0.02, -2.2, -0.025, 0.99)
SOFT = simulate.texture(0.2, seed=4)
SHAPE = (160, 170)


def pair(affine=AFFINE, texture=SOFT, shape=SHAPE, **how):
    return simulate.texture_pair(texture, shape, affine, **how)


def transformed(points, affine=AFFINE):
    a0, a1, a2, b0, b1, b2 = affine
    x, y = np.transpose(points)
    return np.stack([a0 + a1 * x + a2 * y, b0 + b1 * x + b2 * y], axis=-1)


def spread(n, seed=1, margin=30):
    rng = np.random.default_rng(seed)
    return rng.uniform(margin, np.array(SHAPE[::-1]) - margin - 1, (n, 2))


# What interpolation leaves of soft texture is 0.006 grey values, of sharp 0.16; over a
# window of 441 pixels and gradients of some 25 and 50 that is 2e-5 and 2.5e-4 px; the
# largest of 80, in the window with the least texture, is some six times that.
@pytest.mark.parametrize(("cutoff", "largest"), [(0.2, 1e-4), (0.4, 2e-3)])
def test_without_noise_the_truth_is_found_at_points_between_the_pixels(cutoff, largest):
    left, right = pair(texture=simulate.texture(cutoff, seed=4), gain=1.08, offset=4)
    points = spread(40)
    truth = transformed(points)
    found = lsm.match(left, right, points, truth + 0.4)
    assert found.accepted.all()
    np.testing.assert_allclose(found.points, truth, rtol=0, atol=largest)
    a0, a1, a2, b0, b1, b2 = AFFINE
    shape = found.parameters[:, [1, 2, 4, 5]]
    # At ten pixels from the middle a shear of 1e-5 moves a pixel by 1e-4
    np.testing.assert_allclose(
        shape, np.tile([a1, a2, b1, b2], (40, 1)), rtol=0, atol=largest / 5
    )
    # left = h0 + h1 right, right = 1.08 left + 4; interpolation takes 0.02 (soft) to
    # 0.5 per cent (sharp) of the contrast
    h0, h1 = found.parameters[:, 6:].T
    np.testing.assert_allclose(
        h1, 1 / 1.08, rtol=0, atol=3e-4 if cutoff < 0.3 else 5e-3
    )
    np.testing.assert_allclose(h0 + h1 * 4, 120 * (1 - 1.08 * h1), rtol=0, atol=0.3)
    # The window was resampled before the last correction, of up to 0.02 px
    assert found.r.min() > 0.99


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.floats(-0.04, 0.04), min_size=4, max_size=4),
    st.floats(-0.5, 0.5),
    st.floats(-0.5, 0.5),
)
def test_any_small_affine_deformation_is_found(deformation, dx, dy):
    a1, a2, b1, b2 = np.array([1, 0, 0, 1]) + deformation
    affine = (dx + 5, a1, a2, dy + 5, b1, b2)
    left, right = pair(affine, shape=(80, 80))
    truth = transformed([(40, 37)], affine)
    found = lsm.match(left, right, [(40, 37)], np.rint(truth))
    np.testing.assert_allclose(found.points, truth, rtol=0, atol=2e-4)


def test_brightness_and_contrast_of_either_image_change_nothing_but_h():
    left, right = pair(sigma=1.0)
    points = spread(20)
    start = np.rint(transformed(points))
    plain = lsm.match(left, right, points, start)
    other = lsm.match(3 * left + 50, 100 * right + 20_000, points, start)
    np.testing.assert_allclose(other.points, plain.points, rtol=0, atol=1e-6)
    # Noise is thought equal in both images; which one it came from moves a few per cent
    np.testing.assert_allclose(other.covariance, plain.covariance, rtol=0.15)
    equal = lsm.match(3 * left + 50, 3 * right + 50, points, start)
    np.testing.assert_allclose(equal.covariance, plain.covariance, rtol=1e-4)
    np.testing.assert_allclose(equal.r, plain.r, rtol=1e-9)
    np.testing.assert_allclose(equal.sigma0, 3 * plain.sigma0, rtol=1e-6)
    h0, h1 = plain.parameters[:, 6:].T
    np.testing.assert_allclose(other.parameters[:, 7], 3 * h1 / 100, rtol=1e-5)
    np.testing.assert_allclose(
        other.parameters[:, 6], 3 * h0 + 50 - 600 * h1, rtol=0, atol=1e-2
    )


def test_a_point_does_not_feel_what_it_is_matched_together_with():
    left, right = pair(sigma=2.0, texture=simulate.texture(0.35, seed=2))
    points = spread(300, margin=15)
    start = transformed(points) + np.random.default_rng(3).uniform(-1, 1, (300, 2))
    together = lsm.match(left, right, points, start)
    assert len(set(together.iterations)) > 2
    for k in (0, 7, 130, 299):
        alone = lsm.match(left, right, points[[k]], start[[k]])
        assert alone.status[0] == together.status[k]
        # The image around other points is counted from another corner: rounding only
        np.testing.assert_allclose(alone.points[0], together.points[k], atol=1e-4)
        covariance = together.parameter_covariance[k]
        sd = np.sqrt(np.diag(covariance))
        np.testing.assert_allclose(
            alone.parameter_covariance[0] / np.outer(sd, sd),
            covariance / np.outer(sd, sd),
            rtol=0,
            atol=2e-3,
        )


def test_a_fast_match_equals_the_dense_adjustment_within_its_precision():
    left, right = pair(gain=1.08, offset=4, sigma=1.0)
    points = spread(60)
    fast = lsm.match(
        left, right, points, np.rint(transformed(points)), correlated=False
    )
    dense = lsm.adjust(left, right, points, fast.parameters)
    assert set(dense.status) == {"converged"}
    sd = np.sqrt(np.diagonal(fast.parameter_covariance, axis1=1, axis2=2))
    # They weigh noisy gradients of the left or of the right image: at sigma 1 and
    # gradients of 25 that moves the result by a few per cent of its precision.
    difference = (fast.parameters - dense.x) / sd
    assert np.sqrt(np.mean(difference**2)) < 0.1
    assert np.abs(difference).max() < 0.4
    # The dense one knows of no noise in the design matrix: 3 per cent smaller
    np.testing.assert_allclose(dense.sd / sd, 0.97, rtol=0, atol=0.04)
    correlation = fast.parameter_covariance / (sd[:, :, None] * sd[:, None, :])
    np.testing.assert_allclose(dense.correlation, correlation, rtol=0, atol=0.02)
    assert fast.redundancy == dense.redundancy[0] == 433


@pytest.mark.parametrize("radiometric", [True, False])
def test_normal_equations_with_h1_eliminated_solve_the_regression(radiometric):
    left, right = pair(sigma=3.0)
    pixels = np.array([(60, 70), (90, 50)])
    template = _normal_equations.templates(
        left, half_pixels.gradient(left), pixels, 4, radiometric
    )
    rng = np.random.default_rng(5)
    B = left[70, 60] + rng.normal(0, 30, (2, 81))
    found = _normal_equations.solve(template, B)
    for i, b in enumerate(B):
        A, D = template.rows[i, -1], template.rows[i, :-1].T
        if radiometric:
            D = np.column_stack([D, b])
            expected, *_ = np.linalg.lstsq(D, A, rcond=None)
            np.testing.assert_allclose(found.h[i], expected[6:], rtol=1e-8)
        else:
            A = A - b
            expected, *_ = np.linalg.lstsq(D, A, rcond=None)
            np.testing.assert_array_equal(found.h[i], [0, 1])
        np.testing.assert_allclose(found.q[i].ravel(), expected[:6], rtol=1e-7)
        np.testing.assert_allclose(
            found.vv[i], np.sum((A - D @ expected) ** 2), rtol=1e-9
        )
    expected = [np.corrcoef(template.rows[i, -1], B[i])[0, 1] for i in range(2)]
    found = _normal_equations.correlation(template, found)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_without_radiometric_parameters_equal_images_match_as_well():
    left, right = pair(sigma=1.0)
    points = spread(30)
    truth = transformed(points)
    found = lsm.match(left, right, points, np.rint(truth), radiometric=False)
    assert found.accepted.all()
    assert found.redundancy == 435
    np.testing.assert_array_equal(found.parameters[:, 6:], np.tile([0, 1], (30, 1)))
    assert np.all(found.parameter_covariance[:, 6:] == 0)
    # Four to six standard deviations
    np.testing.assert_allclose(found.points, truth, rtol=0, atol=0.02)
    dense = lsm.adjust(left, right, points, found.parameters, radiometric=False)
    assert dense.x.shape == (30, 6)
    np.testing.assert_allclose(dense.x, found.parameters[:, :6], rtol=0, atol=2e-3)


def turned(degrees, size=160):
    """Affine parameters of a turn about the middle of a square image."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, -s], [s, c]])
    a0, b0 = (np.eye(2) - turn) @ np.full(2, size / 2)
    return (a0, c, -s, b0, s, c), turn


def test_a_turned_image_is_matched_by_its_start_shape():
    affine, turn = turned(70)
    left, right = pair(affine, shape=(160, 160))
    points = np.array([(70.0, 70.0), (60.0, 82.0)])
    truth = transformed(points, affine)
    found = lsm.match(left, right, points, np.rint(truth), shape=turn)
    np.testing.assert_allclose(found.points, truth, rtol=0, atol=2e-4)
    found = lsm.match(left, right, points, np.rint(truth), shape=[turn, turn])
    assert found.accepted.all()
    assert not lsm.match(left, right, points, np.rint(truth)).accepted.any()


def test_each_misfortune_of_a_point_has_its_name():
    left, right = pair((0, 1, 0, 0, 0, 1))
    left[90:130, 20:60] = 77.0  # flat
    left[:, 100:150] = left[0, 100:150]  # lines that run one way
    right[:, 100:150] = left[0, 100:150]
    right[20:60, 20:60] = 99.0
    points = np.array([(40, 110), (125, 80), (5, 80), (75, 60), (40, 40), (75, 75)])
    start = points.astype(float)
    start[3] = (168, 60)
    found = lsm.match(left, right, points, start)
    assert found.status.tolist() == [
        "flat template",
        "position not determined",
        "template leaves the image",
        "window leaves the image",
        "flat window",
        "accepted",
    ]
    bad = ~found.accepted
    for name in ("points", "covariance", "sigma0", "parameters", "r"):
        values = getattr(found, name)
        assert np.isnan(values[bad]).all()
        assert np.isfinite(values[~bad]).all()


def test_what_is_not_alike_is_below_the_threshold():
    left, right = pair(sigma=8.0)
    points = spread(40)
    start = transformed(points)
    plain = lsm.match(left, right, points, start)
    assert plain.accepted.all()
    middle = np.median(plain.r)
    strict = lsm.match(left, right, points, start, threshold=middle)
    assert np.all((strict.status == "below threshold") == (plain.r < middle))
    negative = lsm.match(left, 255 - right, points, start)
    np.testing.assert_allclose(negative.points, plain.points, rtol=0, atol=1e-6)
    np.testing.assert_allclose(negative.r, -plain.r, rtol=1e-6)


def test_a_window_that_wanders_is_stopped_and_named():
    left, right = pair((0, 1, 0, 0, 0, 1), sigma=2.0)
    points = spread(60, margin=25)
    # Farther than half a window: none may be reached, nor anything be taken for it
    found = lsm.match(left, right, points, points + np.array([12.0, -11.0]))
    assert not found.accepted.any()
    assert {"not converged", "diverged"} < set(found.status)
    once = lsm.match(left, right, points, points + 1.0, max_iterations=1)
    assert set(once.status) == {"not converged"}
    assert np.isnan(once.points).all()


def test_what_a_second_attempt_finds_is_the_match_and_its_iterations_are_counted():
    left, right = pair((0, 1, 0, 0, 0, 1), sigma=2.0)
    points = spread(60, margin=25)
    found = lsm.match(left, right, points, points + np.array([3.2, -3.2]))
    assert found.accepted.mean() > 0.4
    good = found.accepted
    np.testing.assert_allclose(found.points[good], points[good], rtol=0, atol=0.1)
    assert found.iterations[good].max() > 20


def test_a_window_that_leaves_the_image_on_its_way_is_named():
    left, right = pair((-14.0, 1, 0, 0, 0, 1))
    # The true place, column 9, is too near to the border for the window; the start not
    found = lsm.match(left, right, [(23, 80)], [(10.2, 80)])
    assert found.status[0] == "window leaves the image"


def test_noise_is_not_taken_for_a_match():
    rng = np.random.default_rng(1)
    left, right = rng.normal(100, 2, (2, 120, 120))
    points = rng.uniform(30, 90, (50, 2))
    found = lsm.match(left, right, points, points)
    assert not found.accepted.any()
    for name in ("points", "covariance", "sigma0", "parameters", "r"):
        assert np.isnan(getattr(found, name)).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(template=20), "odd number"),
        (dict(template=3), "at least 5"),
        (dict(left=np.zeros((10, 40))), "at least 21 x 21"),
        (dict(start=[(20, 20), (3, 4)]), "start must have shape"),
        (dict(shape=np.zeros((3, 2, 2))), "shape must be"),
        (dict(tolerance=0), "tolerance must be positive"),
        (dict(threshold=1.5), "threshold must lie between 0 and 1"),
        (dict(smooth=0.1), "smooth"),
        (dict(smooth=3.5), "smooth"),
    ],
)
def test_bad_input_is_refused_with_a_reason(change, message):
    image = np.random.default_rng(0).normal(size=(40, 40))
    given = dict(left=image, right=image, points=[(20, 20)], template=21)
    given = given | dict(start=[(20, 20)]) | change
    with pytest.raises(ValueError, match=message):
        lsm.match(**given)


def test_points_farther_apart_than_opencv_can_address_are_matched():
    image = np.random.default_rng(0).integers(0, 256, (30, 33_000), dtype=np.uint8)
    points = np.array([(15.0, 15), (32_900, 15)])
    found = lsm.match(image, image, points)
    np.testing.assert_allclose(found.points, points, rtol=0, atol=0.01)


@pytest.mark.parametrize("side", [(1, 0), (-1, 0), (0, 1), (0, -1)])
@pytest.mark.parametrize("stretch", [1.0, 1.3])
def test_a_window_may_reach_to_the_outermost_pixel_centres_and_no_farther(
    side, stretch
):
    rows, columns = 60, 80
    half, side = 10, np.array(side)
    reach = stretch * half
    low, high = np.full(2, reach), np.array([columns - 1, rows - 1]) - reach
    edge = np.where(side > 0, high, np.where(side < 0, low, (low + high) / 2))
    T = np.tile(np.eye(2, 3, 1) * stretch, (2, 1, 1))
    T[:, :, 0] = edge - 1e-9 * side, edge + 1e-3 * side
    outside = _iteration.outside(T, half, (rows, columns))
    np.testing.assert_array_equal(outside, [False, True])


def test_a_match_whose_covariance_is_singular_is_none(monkeypatch):
    precision = _normal_equations.precision

    def singular_first(*given):
        Q, sigma0, pixels, singular = precision(*given)
        singular[0] = True
        return Q, sigma0, pixels, singular

    monkeypatch.setattr(_normal_equations, "precision", singular_first)
    left, right = pair()
    points = spread(4)
    found = lsm.match(left, right, points, transformed(points))
    np.testing.assert_array_equal(found.accepted, [False, True, True, True])
    assert found.status[0] == "position not determined"
    for values in (found.points, found.covariance, found.sigma0, found.parameters):
        assert np.isnan(values[0]).all() and np.isfinite(values[1:]).all()
