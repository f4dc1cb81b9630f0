"""Proofs of the verdicts on Harintaka 2020, (2) to (5): intersection by two scales."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close

from pgm_lab import camera as cam
from pgm_lab import rotation
from pgm_lab.camera import Camera

CAMERA = Camera(24.0)
EXTERIORS = np.array(
    [(0.0, 0.0, 1000.0, 0.02, -0.03, 0.4), (310.0, 25.0, 1020.0, -0.04, 0.01, 0.5)]
)
POINTS = np.random.default_rng(6).uniform((0, -200, -50), (300, 200, 50), (40, 3))


def rays(images, exteriors=EXTERIORS):
    """R (x, y, -f), R from image to object: one vector for each photo and point."""
    rows = np.concatenate(
        [images, np.full((*images.shape[:-1], 1), -CAMERA.c)], axis=-1
    )
    return rows @ rotation.matrix(*exteriors[:, 3:].T)  # M'r as a row: r' M


def scales(images, exteriors=EXTERIORS):
    """(4), (5), with R x and R y read as first and second component of R (x, y, -f)."""
    bx, by, _ = exteriors[1, :3] - exteriors[0, :3]
    (x1, y1, _), (x2, y2, _) = np.moveaxis(rays(images, exteriors), -1, 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        first = (bx * y2 - by * x2) / (x1 * y2 - y1 * x2)
        second = (by * x1 - bx * y1) / (y1 * x2 - x1 * y2)
    return first, second


IMAGES = cam.project(CAMERA, EXTERIORS[:, None], POINTS)


@pytest.mark.parametrize("photo", [0, 1])
def test_2_holds_with_r_from_image_to_object_and_a_positive_scale(photo):
    # The scale by depth along the camera's axis, which is (0, 0, 1) R' in the object
    station, angles = EXTERIORS[photo, :3], EXTERIORS[photo, 3:]
    ahead = -(POINTS - station) @ rotation.matrix(*angles)[2]
    scale = ahead / CAMERA.c
    assert np.all(scale > 0) and np.ptp(scale) > 1  # of its own for each point
    ground = station + scale[:, None] * rays(IMAGES)[photo]
    close(ground, POINTS, rtol=0, atol=1e-9)
    wrong = IMAGES[photo].copy()  # R from object to image does not do
    turned = np.column_stack([wrong, np.full(len(wrong), -CAMERA.c)])
    turned = turned @ rotation.matrix(*angles).T
    assert np.abs(station + scale[:, None] * turned - POINTS).max() > 10


def test_3_to_5_give_back_error_free_points_except_above_the_base():
    def ground(images, exteriors=EXTERIORS):
        both = zip(scales(images, exteriors), exteriors[:, :3], rays(images, exteriors))
        return [station + scale[:, None] * ray for scale, station, ray in both]

    for points in ground(IMAGES):
        close(points, POINTS, rtol=0, atol=1e-7)
    # With errors the two still agree in X and Y, whatever happens, but not in Z: it is
    # not used, and the parallax goes there
    noise = np.random.default_rng(1).normal(0, 0.003, IMAGES.shape)
    first, second = ground(IMAGES + noise)
    close(first[:, :2], second[:, :2], rtol=0, atol=1e-6)
    assert np.median(np.abs(first[:, 2] - second[:, 2])) > 0.1
    # Vertical photos one behind the other, points on the line of flight: y = 0 in
    # both, by = 0, and (4), (5) are 0/0, though the rays meet well in x and z
    exteriors = np.array([(0, 0, 1000, 0, 0, 0), (300, 0, 1000, 0, 0, 0)], float)
    points = np.array([(100, 0, 20), (250, 0, -30)], float)
    images = cam.project(CAMERA, exteriors[:, None], points)
    assert np.all(np.isnan(scales(images, exteriors)))
    (x1, _, z1), (x2, _, z2) = np.moveaxis(rays(images, exteriors), -1, 1)
    bx, _, bz = exteriors[1, :3] - exteriors[0, :3]
    scale = (bx * z2 - bz * x2) / (x1 * z2 - z1 * x2)
    met = exteriors[0, :3] + scale[:, None] * rays(images, exteriors)[0]
    close(met, points, rtol=0, atol=1e-9)
    # 3 micrometres of y in one photo: at y = 0.1 mm the scale is off by 1.5 per cent,
    # half of dy/y, since the two rays are symmetric to the base
    y = np.array([0.1, 1.0, 5.0])
    points = np.column_stack([np.full(3, 150), 1000 / 24 * y, np.zeros(3)])
    images = cam.project(CAMERA, exteriors[:, None], points)
    exact, _ = scales(images, exteriors)
    images[1, :, 1] += 0.003
    close(scales(images, exteriors)[0] / exact - 1, 0.003 / y / 2, rtol=0.03)
