"""The epipolar (normalised) pair: equal rows of both images show the same ground."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from pgm_lab.camera import measured
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo


@dataclass(frozen=True, eq=False)
class NormalPair:
    """Two photos resampled to the normal case.

    Attributes
    ----------
    left, right : ndarray (rows, columns) of float32
        Grey values; NaN where the photo shows nothing.
    rotation : ndarray (3, 3)
        Turns object space into the frame of the normal images: x along the base.
    stations : ndarray (2, 3)
        Projection centres in object space.
    c, pixel_size : float
        Principal distance and pixel size of both images, in mm.
    origin : ndarray (2, 2)
        (x, y) in mm of the middle of pixel (0, 0), left and right; the same y.
    """

    left: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)
    rotation: np.ndarray
    stations: np.ndarray
    c: float
    pixel_size: float
    origin: np.ndarray

    @property
    def base(self) -> float:
        """Length of the base."""
        return float(np.linalg.norm(self.stations[1] - self.stations[0]))

    def parallax(self, disparity: np.ndarray) -> np.ndarray:
        """X' - x'' in mm of a disparity (left column - right column) in pixels."""
        return self.origin[0, 0] - self.origin[1, 0] + self.pixel_size * disparity

    def object_points(self, columns, rows, disparity) -> np.ndarray:
        """Object points (..., 3) of left pixels and their disparities."""
        x = self.origin[0, 0] + self.pixel_size * np.asarray(columns, float)
        y = self.origin[0, 1] - self.pixel_size * np.asarray(rows, float)
        scale = self.base / self.parallax(np.asarray(disparity, float))
        model = np.stack(np.broadcast_arrays(scale * x, scale * y, -self.c * scale), -1)
        return self.stations[0] + model @ self.rotation


def epipolar_pair(
    left: Photo, right: Photo, heights: tuple[float, float]
) -> NormalPair:
    """Resample two oriented photos to the normal case.

    heights: (least, greatest) Z of the ground, which says what both show.
    """
    stations = np.array([left.exterior[:3], right.exterior[:3]], float)
    R = _rotation(stations, left, right)
    c, pixel = left.camera.c, left.pixel_size
    box = [_box(photo, R, c) for photo in (left, right)]
    base = np.linalg.norm(stations[1] - stations[0])
    depth = (R @ (stations.mean(0) - [*stations[0, :2], np.mean(heights)]))[2]
    shift = c * base / depth  # parallax at the mean height
    least = max(box[0][0], box[1][0] + shift)
    most = min(box[0][1], box[1][1] + shift)
    low, high = max(box[0][2], box[1][2]), min(box[0][3], box[1][3])
    size = int((most - least) / pixel), int((high - low) / pixel)
    if min(size) < 32:
        raise ValueError("the photos have no ground in common; check orientations")
    origin = np.array([(least, high), (least - shift, high)])
    images = [_resample(p, o, R, c, pixel, size) for p, o in zip((left, right), origin)]
    return NormalPair(*images, R, stations, c, pixel, origin)


def _rotation(stations, left, right):
    """Object to normal frame: x along the base, z against the mean view."""
    x = stations[1] - stations[0]
    x = x / np.linalg.norm(x)
    z = attitude(left.exterior)[2] + attitude(right.exterior)[2]
    z = z - x * (z @ x)
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


def _box(photo, R, c):
    """Least and most x, least and most y of a photo in the normal image, mm."""
    rows, columns = photo.grey.shape
    t = np.linspace(0, 1, 30)
    edge = np.concatenate([[(a, 0), (a, 1), (0, a), (1, a)] for a in t]) * [
        columns - 1,
        rows - 1,
    ]
    u = photo.rays(edge) @ R.T
    xy = -c * u[:, :2] / u[:, 2:]
    (x0, y0), (x1, y1) = xy.min(0), xy.max(0)
    return x0, x1, y0, y1


def _resample(photo, origin, R, c, pixel, size):
    columns, rows = size
    x = origin[0] + pixel * np.arange(columns)
    y = origin[1] - pixel * np.arange(rows)
    image = np.stack([*np.meshgrid(x, y), np.full((rows, columns), -c)], -1)
    u = image @ (R @ attitude(photo.exterior).T)
    p = -photo.camera.c * u[..., :2] / u[..., 2:]
    px = photo.to_pixel(measured(photo.camera, p)).astype(np.float32)
    return cv2.remap(
        photo.grey.astype(np.float32),
        px[..., 0],
        px[..., 1],
        cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=float("nan"),
    )
