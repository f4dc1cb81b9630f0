"""A left point on its way through object space, and two rays that meet."""

import numpy as np

from pgm_lab.camera import collinearity, imaging, measured
from pgm_lab.camera.photo import Photo
from pgm_lab.orientation import intersect

SAMPLES = 97  # along an epipolar curve
BEYOND = 1.1  # how far outside of the sensor a lens is asked, in half diagonals


def curve(
    left: Photo, right: Photo, pixel: np.ndarray, depths: tuple[float, float]
) -> np.ndarray:
    """Epipolar curve (k, 2) in pixels of the right photo, between two depths.

    A depth is counted along the axis of the left camera. Only what the sensor may show
    is returned, perhaps nothing. In steps of equal parallax.
    """
    near, far = depths
    t = 1 / np.linspace(1 / near, 1 / far, SAMPLES) / left.camera.c
    points = np.asarray(left.exterior[:3]) + t[:, None] * left.rays(pixel)
    rays, _ = imaging.ray(np.asarray(right.exterior, float), points)
    rays = rays[rays[:, 2] < 0]
    xy, *_ = imaging.perspective(right.camera.c, rays)
    widest = BEYOND * np.hypot(*right.sensor) / 2 * right.pixel_size
    pixels = right.to_pixel(measured(right.camera, xy[np.hypot(*xy.T) < widest]))
    size = np.array(right.grey.shape[::-1]) - 0.5
    return pixels[np.all((pixels > -0.5) & (pixels < size), axis=1)]


def line(curve: np.ndarray, pixel: np.ndarray) -> np.ndarray:
    """The straight line (a, b, d) along a curve, where it passes a pixel.

    a column + b row + d = 0 with a^2 + b^2 = 1.
    """
    middle = (curve[:-1] + curve[1:]) / 2
    k = np.argmin(np.hypot(*(middle - pixel).T))
    (x0, y0), (dx, dy) = curve[k], curve[k + 1] - curve[k]
    a, b = np.array([-dy, dx]) / np.hypot(dx, dy)
    return np.array([a, b, -a * x0 - b * y0])


def meet(
    photos: tuple[Photo, Photo], xy: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, str]:
    """Object point, its covariance, and how the intersection ended.

    Photo coordinates xy (2, 2) in mm and their covariances (2, 2, 2) are of the left
    and the right photo. The orientation is taken as free of errors.
    """
    exteriors = np.array([photo.exterior for photo in photos])
    cameras = [photo.camera for photo in photos]
    first = intersect(cameras, exteriors, xy)
    if first.status != "intersected":
        return np.full(3, np.nan), np.full((3, 3), np.nan), str(first.status)
    # One step with the weights: equal weights have brought it near enough
    parts = [
        collinearity(camera, exterior, first.points, observed, "point")
        for camera, exterior, observed in zip(cameras, exteriors, xy)
    ]
    B = np.concatenate([part.point for part in parts])
    v = np.concatenate([part.v for part in parts])
    P = np.zeros((4, 4))
    P[:2, :2], P[2:, 2:] = np.linalg.inv(covariance)
    C = np.linalg.inv(B.T @ P @ B)
    return first.points - C @ B.T @ P @ v, C, str(first.status)
