"""Proofs of the verdicts on Muliawan 2013. What chapter 1 touches: (2.1), (2.15) to
(2.17) and the precision of a centroid."""

import numpy as np

from pgm_lab import frames, image, simulate


def test_2_1_gives_the_ray_from_the_perspective_centre():
    # Collinear with the image vector of any camera: (x - x0, y - y0, -c)
    x, y, x0, y0, c = 3.0, -2.0, 0.1, -0.3, 35.0
    vector = frames.interior_matrix(c, x0, y0) @ (x, y, 1)
    np.testing.assert_allclose(vector, (x - x0, y - y0, -c), rtol=0, atol=1e-15)


def _centroid_2_15(window, first_index):
    """(2.15) as printed, with the sums over all rows i and columns j."""
    i, j = np.indices(window.shape) + first_index
    return np.array([(j * window).sum(), (i * window).sum()]) / window.sum()


def test_2_15_counted_from_1_lies_one_pixel_beyond_2_17():
    # A target in the middle of the image must come out at the centre by (2.17)
    window = simulate.target((10, 7), diameter=5, shape=(15, 21), background=0)
    centre = frames.image_centre((21, 15))
    np.testing.assert_allclose(_centroid_2_15(window, 1) - centre, 1, atol=1e-6)
    np.testing.assert_allclose(_centroid_2_15(window, 0) - centre, 0, atol=1e-6)


def test_2_15_needs_rows_up_to_n_and_columns_up_to_m():
    # Printed: i (rows) up to m (columns). In an upright window rows are then missing.
    window = simulate.target((4, 15), diameter=5, shape=(21, 9), background=0)
    rows, columns = window.shape
    printed = window[: min(columns, rows), : min(rows, columns)]
    assert printed.sum() < 1e-6 * window.sum()
    np.testing.assert_allclose(_centroid_2_15(window, 0), (4, 15), atol=1e-6)


def test_2_15_without_background_removal_is_pulled_to_the_window_centre():
    truth = np.array([12.5, 8.0])
    window = simulate.target(truth, diameter=8)
    pull = _centroid_2_15(window, 0) - truth
    assert pull[0] < -1 and pull[1] > 0.8
    np.testing.assert_allclose(
        image.centroid(window, background=40.0, sigma=1.0).position, truth, atol=1e-4
    )


def test_2_16_and_2_17_agree_with_the_camera_matrix_of_opencv():
    import cv2

    size, pixel = (4288, 2848), 0.0055
    pixels = np.array([[0.0, 0.0], [4287.0, 2847.0], [1000.5, 2000.25]])
    focal = 24.0 / pixel
    camera = np.array(
        [[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1.0]]
    )
    normalised = cv2.undistortPoints(pixels[:, None], camera, None)[:, 0]
    expected = normalised * 24.0 * (1, -1)  # OpenCV's y points down
    photo = frames.pixel_to_photo(pixels, size, pixel)
    np.testing.assert_allclose(photo, expected, rtol=0, atol=1e-12)


def test_image_centre_and_principal_point_differ_by_the_interior_orientation():
    # (2.1) has the principal point at (x0, y0), (2.16) has the image centre at (0, 0)
    centre = frames.pixel_to_photo(frames.image_centre((100, 60)), (100, 60), 0.01)
    vector = frames.interior_matrix(35.0, 0.2, -0.1) @ (*centre, 1)
    np.testing.assert_allclose(vector[:2], (-0.2, 0.1), atol=1e-15)


def test_003_px_is_what_a_centroid_reaches_under_stated_conditions():
    # Diameter 10 px, contrast 160, noise 3 grey values, window 21 x 21, 8 bit
    centre = 10 + np.random.default_rng(20131).uniform(-0.5, 0.5, (1500, 2))
    window = simulate.photograph(
        simulate.target(centre, diameter=10.0), noise=3.0, seed=20132, bits=8
    )
    rms = np.std(image.centroid(window).position - centre)
    # 3000 errors give the standard deviation to 1.3 per cent; three of them
    assert 0.030 * 0.96 < rms < 0.031 * 1.04
    rms = np.std(image.centroid(window, threshold=9.0).position - centre)
    assert rms < 0.012
