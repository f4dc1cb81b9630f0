"""Matching with defects: correct without any; the table of their costs, repeated."""

import numpy as np
import pytest

from pgm_book.ch03 import defects
from pgm_book.ch03.defects import DEFECTS, PROGRAM, match
from pgm_book.ch03.studies import defects as benchmark
from pgm_book.common import results
from pgm_lab import lsm, simulate

TABLE = results.rows("ch03", "defects")
AFFINE = (2.3, 1.01, -0.02, -1.4, 0.015, 0.99)
LEFT = np.array([(40.0, 40.0), (60.0, 45.0), (50.0, 70.0)])
TRUE = LEFT @ np.reshape(AFFINE, (2, 3))[:, 1:].T + (2.3, -1.4)


def images(**options):
    texture = simulate.texture(0.15, seed=2)
    return simulate.texture_pair(texture, (110, 100), AFFINE, **options)


def found(*defects, left=LEFT, gain=1.08, offset=4.0, **options):
    start = np.round(TRUE)[: len(left)]
    return match(*images(gain=gain, offset=offset, **options), left, start, defects)


def test_without_defects_the_true_points_are_found():
    # What is left is the spline: the shortest wave has 6.7 px
    m = found()
    assert np.all(m.status == "converged")
    np.testing.assert_allclose(m.points, TRUE, rtol=0, atol=3e-3)


def test_without_defects_it_agrees_with_lsm_match():
    # That one differentiates the left image: half a standard deviation is allowed
    both = images(sigma=2.0, gain=1.08, offset=4.0)
    ours, other = match(*both, LEFT, np.round(TRUE)), lsm.match(*both, LEFT, TRUE)
    sd = np.sqrt(np.diagonal(other.covariance, axis1=1, axis2=2))
    assert np.all(np.abs(ours.points - other.points) < 0.5 * sd)


def test_sigma0_is_the_noise_of_both_images():
    # Noise 3 in each; 433 residuals give 3.4 per cent; the spline takes up to 8 off
    m = found(sigma=3.0)
    expected = 3 * np.hypot(1, 1 / 1.08)
    assert np.all((m.sigma0 > 0.8 * expected) & (m.sigma0 < 1.12 * expected))


def test_a_stack_is_the_same_as_one_point_at_a_time():
    both = images(sigma=2.0, gain=1.08)
    together = match(*both, LEFT, np.round(TRUE))
    for k in range(3):
        alone = match(*both, LEFT[k : k + 1], np.round(TRUE)[k : k + 1])
        np.testing.assert_allclose(alone.points[0], together.points[k], atol=1e-9)
        assert alone.iterations[0] == together.iterations[k]
        assert alone.sigma0[0] == pytest.approx(together.sigma0[k], rel=1e-9)


def test_uncentred_coordinates_cost_condition_and_steps_but_no_accuracy():
    good, bad = found(sigma=2.0), found("uncentred", sigma=2.0)
    np.testing.assert_allclose(bad.points, good.points, rtol=0, atol=1e-3)
    assert np.all(bad.condition > 3 * good.condition)
    assert np.all(bad.iterations >= good.iterations)


def test_s0_of_the_listing_is_smaller_by_the_root_of_r_and_changes_nothing_else():
    good, bad = found(sigma=2.0), found("S0 of the listing", sigma=2.0)
    np.testing.assert_allclose(good.sigma0 / bad.sigma0, np.sqrt(441 - 8), rtol=1e-12)
    np.testing.assert_array_equal(bad.points, good.points)


def test_2_17_is_singular():
    m = found("h1 without grey value")
    assert np.all(m.status == "singular") and np.all(np.isnan(m.points))


def test_or_stops_while_the_match_still_moves():
    m = found("or")
    assert np.all(m.iterations == 1) and np.all(m.status == "converged")
    assert np.abs(m.points - TRUE).max() > 5e-3


def test_stop_rule_holds_every_correction_against_its_limit():
    limits = np.array([1e-3, 1e-4, 1e-4, 1e-3, 1e-4, 1e-4, np.inf, np.inf])
    below = np.tile(0.9 * np.minimum(limits, 1e6), (7, 1))
    below[range(6), range(6)] = -1.1 * limits[:6]
    np.testing.assert_array_equal(defects._small(below, set()), [False] * 6 + [True])


def test_stop_rule_with_or_is_that_of_the_listing():
    # a0, a1, a2, b0, b1, b2: one scale and one shear are enough, shifts do not count
    X = [(9, 0, 1, 9, 0, 1), (9, 1, 0, 9, 1, 0), (0, 1, 0, 0, 0, 1), (0, 0, 1, 0, 1, 0)]
    small = defects._small(np.array(X, dtype=float), {"or"})
    np.testing.assert_array_equal(small, [True, True, False, False])


def test_six_parameters_need_equal_brightness():
    bad, good = found("six parameters"), found("six parameters", gain=1.0, offset=0.0)
    assert np.abs(bad.points - TRUE).max() > 0.01 and bad.sigma0.min() > 5
    np.testing.assert_allclose(good.points, TRUE, rtol=0, atol=3e-3)
    assert good.sigma0.max() < 0.5


def test_diagonal_grid_is_right_without_shear_and_does_not_settle_with_it():
    texture = simulate.texture(0.15, seed=2)
    scaled = simulate.texture_pair(texture, (110, 100), (2.3, 1.01, 0, -1.4, 0, 0.99))
    true = LEFT * (1.01, 0.99) + (2.3, -1.4)
    m = match(*scaled, LEFT, np.round(true), ["diagonal grid"])
    np.testing.assert_allclose(m.points, true, rtol=0, atol=3e-3)
    assert np.all(found("diagonal grid").status == "not converged")


def test_whole_grey_values_and_gradients_are_whole():
    image = images()[1]
    points = np.array([[[20.3, 30.6], [25.5, 31.2]]])
    for name in ("rounded", "truncated"):
        g, *_ = defects._resampled(image, points, {name})
        smooth, *_ = defects._resampled(image, points, {"bilinear"})
        assert np.all(g == np.round(g)) and np.all(np.abs(g - smooth) < 1)
    g, gx, gy = defects._resampled(image, points, {"integer gradients"})
    _, exact_x, exact_y = defects._resampled(image, points, set())
    np.testing.assert_array_equal((gx, gy), np.trunc((exact_x, exact_y)))


def test_window_that_leaves_the_right_image_is_named():
    m = match(*images(), [(40, 40), (50, 70)], [(5, 40), np.round(TRUE[2])])
    assert list(m.status) == ["outside the image", "converged"]
    assert np.all(np.isnan(m.points[0])) and m.iterations[0] == 0


@pytest.mark.parametrize("defects", [*((name,) for name in DEFECTS), PROGRAM])
def test_every_defect_can_be_put_in_and_leaves_the_images_alone(defects):
    both = images(sigma=1.0)
    copies = [image.copy() for image in both]
    m = match(*both, LEFT, np.round(TRUE), defects)
    assert m.points.shape == (3, 2) and m.status.shape == (3,)
    np.testing.assert_array_equal(both, copies)


def test_an_unknown_defect_is_refused():
    with pytest.raises(ValueError, match="defects must be of DEFECTS; got centred"):
        match(*images(), LEFT, TRUE, ["centred"])


# The table


def cost(scene, defect, column="ratio"):
    (row,) = [r for r in TABLE if (r["scene"], r["defect"]) == (scene, defect)]
    return float(row[column])


def test_table_has_every_scene_and_every_defect():
    assert tuple(TABLE[0]) == benchmark.COLUMNS
    expected = [(s, v) for s in benchmark.SCENES for v in benchmark.VARIANTS]
    assert [(row["scene"], row["defect"]) for row in TABLE] == expected


@pytest.mark.parametrize("scene", benchmark.SCENES)
def test_correct_matching_reaches_the_bound_and_no_defect_goes_below(scene):
    # 600 errors: the ratio is known to 3 per cent
    assert 0.95 < cost(scene, "none") < 1.1
    assert cost(scene, "none", "converged") == 300
    for row in TABLE:
        assert row["ratio"] == "" or float(row["ratio"]) > 0.95


@pytest.mark.parametrize("scene", benchmark.SCENES)
def test_what_the_table_says_of_the_defects(scene):
    assert cost(scene, "uncentred") == cost(scene, "none")
    assert cost(scene, "uncentred", "condition") > 1e4 * cost(
        scene, "none", "condition"
    )
    assert cost(scene, "h1 without grey value", "matched") == 0
    assert cost(scene, "diagonal grid", "converged") == 0
    assert cost(scene, "six parameters") > 2.5
    assert cost(scene, "or") > 1.25
    assert cost(scene, "integer gradients") < 1.1
    assert cost(scene, "all of the program") > 3


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["good contrast", "shear as in the log"])
def test_the_script_still_says_what_the_table_does(scene):
    """Forty points: 80 errors give the ratio to 8 per cent; three times that."""
    variants = "none", "or", "bilinear", "six parameters", "S0 of the listing"
    for row in benchmark.rows(scene, variants, 40):
        named = dict(zip(benchmark.COLUMNS, row, strict=True))
        assert float(named["ratio"]) == pytest.approx(
            cost(scene, named["defect"]), rel=0.25
        )
        assert float(named["sigma0"]) == pytest.approx(
            cost(scene, named["defect"], "sigma0"), rel=0.25
        )
