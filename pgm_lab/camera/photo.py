"""A photo that is oriented: grey values with their camera and exterior orientation."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import frames
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.model import Camera, ideal, project


@dataclass(frozen=True, eq=False)
class Photo:
    """Grey values of a photo, or of a part of it, with its orientation.

    Attributes
    ----------
    grey : ndarray (rows, columns)
        Grey values.
    camera : Camera
        Interior orientation and lens, in mm.
    exterior : ndarray (6,)
        (X0, Y0, Z0, omega, phi, kappa).
    pixel_size : float
        In mm.
    image_size : (columns, rows), optional
        Of the whole sensor; that of `grey` when missing.
    corner : (column, row)
        Where pixel (0, 0) of `grey` lies on the sensor.

    Examples
    --------
    >>> photo = Photo(np.zeros((40, 60)), Camera(24.0), (0, 0, 100, 0, 0, 0), 0.005)
    >>> photo.project([(0.0, 0.0, 0.0)])
    array([[29.5, 19.5]])
    """

    grey: np.ndarray = field(repr=False)
    camera: Camera
    exterior: np.ndarray
    pixel_size: float
    image_size: tuple[int, int] | None = None
    corner: tuple[int, int] = (0, 0)

    @property
    def sensor(self) -> tuple[int, int]:
        """Columns and rows of the whole sensor."""
        return self.image_size or self.grey.shape[::-1]

    def to_photo(self, pixels: ArrayLike) -> np.ndarray:
        """Photo coordinates (n, 2) in mm, as measured, of pixels of `grey`."""
        moved = np.asarray(pixels, float) + self.corner
        return frames.pixel_to_photo(moved, self.sensor, self.pixel_size)

    def to_pixel(self, photo: ArrayLike) -> np.ndarray:
        """Pixels (n, 2) of `grey` of measured photo coordinates in mm."""
        return frames.photo_to_pixel(photo, self.sensor, self.pixel_size) - self.corner

    def rays(self, pixels: ArrayLike) -> np.ndarray:
        """Directions (n, 3) in object space, of length c and more, of pixels."""
        xy = ideal(self.camera, self.to_photo(pixels))
        image = np.concatenate([xy, np.full((*xy.shape[:-1], 1), -self.camera.c)], -1)
        return image @ attitude(np.asarray(self.exterior, float))

    def project(self, points: ArrayLike) -> np.ndarray:
        """Pixels (n, 2) of `grey` that object points (n, 3) are imaged on."""
        return self.to_pixel(project(self.camera, self.exterior, points))
