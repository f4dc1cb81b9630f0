"""A covariance on its way from pixels to photo coordinates and back."""

import numpy as np
import pytest

from pgm_lab import frames

SIZE, PIXEL = (400, 300), (0.01, 0.02)
C = np.array([[0.04, 0.03], [0.03, 0.09]])


def test_the_covariance_is_that_of_many_points_turned_one_by_one():
    rng = np.random.default_rng(1)
    pixels = rng.multivariate_normal((150, 120), C, 200_000)
    sample = np.cov(frames.pixel_to_photo(pixels, SIZE, PIXEL).T)
    photo, found = frames.pixel_to_photo((150, 120), SIZE, PIXEL, covariance=C)
    np.testing.assert_array_equal(photo, frames.pixel_to_photo((150, 120), SIZE, PIXEL))
    # an element of a sampled covariance scatters by sqrt(2 / n) of the variances
    sd = np.sqrt(np.diag(found))
    assert np.all(np.abs(sample - found) < 5 * np.sqrt(2 / 200_000) * np.outer(sd, sd))


def test_y_turns_round_and_with_it_the_sign_between_x_and_y():
    _, found = frames.pixel_to_photo((0, 0), SIZE, PIXEL, covariance=C)
    np.testing.assert_allclose(
        found, [[0.04e-4, -0.03 * 2e-4], [-0.03 * 2e-4, 0.09 * 4e-4]], rtol=1e-14
    )


@pytest.mark.parametrize("shape", [(2, 2), (5, 2, 2), (3, 5, 2, 2)])
def test_there_and_back_is_the_same_for_one_covariance_or_one_a_point(shape):
    pixels = np.random.default_rng(2).uniform(0, 300, (3, 5, 2))
    given = np.broadcast_to(C, shape)
    photo, there = frames.pixel_to_photo(pixels, SIZE, PIXEL, covariance=given)
    back, again = frames.photo_to_pixel(photo, SIZE, PIXEL, covariance=there)
    assert there.shape == again.shape == (3, 5, 2, 2)
    np.testing.assert_allclose(again, np.broadcast_to(C, again.shape), rtol=1e-13)
    np.testing.assert_allclose(back, pixels, rtol=1e-13)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.full((2, 2), np.nan), r"covariance\[0, 0\] is not a finite number"),
        ([0.1, 0.2], r"must have shape \(\.\.\., 2, 2\)"),
        ([[1, 0.5], [0.4, 1]], "not symmetric"),
        ([[1, 2], [2, 1]], "not positive semi-definite"),
        (np.tile(C, (3, 1, 1)), "one for each point"),
    ],
)
def test_what_is_no_covariance_is_refused(wrong, message):
    for turn in (frames.pixel_to_photo, frames.photo_to_pixel):
        with pytest.raises(ValueError, match=message):
            turn([(1, 2), (3, 4)], SIZE, PIXEL, covariance=wrong)
