"""A photo that is oriented: grey values with their camera and exterior orientation."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, frames
from pgm_lab.camera.imaging import attitude, beyond_fold, distortion, undistort
from pgm_lab.camera.model import Camera, ideal, measured, project


@dataclass(frozen=True, eq=False)
class Photo:
    """Grey values of a photo, or of a part of it, with its orientation.

    Pixels are (column, row) of `grey`, integers at pixel centres. After a relative
    orientation the left exterior is zero, the right one that of `orientation.relative`.

    Attributes
    ----------
    grey : ndarray (rows, columns)
        Grey values, neither copied nor converted; NaN or masked where there are none.
    camera : Camera
        Interior orientation and lens, in mm.
    exterior : ndarray (6,)
        (X0, Y0, Z0, omega, phi, kappa); a copy, which cannot be written to.
    pixel_size : float
        Side of a pixel in mm.
    image_size : (columns, rows), optional
        Of the whole photo; that of `grey` when missing.
    corner : (column, row)
        Where pixel (0, 0) of `grey` lies in the whole photo.
    crs : str, optional
        Coordinate reference system of the exterior: "EPSG:32748", for example.

    Raises
    ------
    ValueError
        Also if the image is in colour, or the part not inside the whole photo.

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
    crs: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        grey = _validate.grey_image(self.grey, "grey")
        _validate.instance(self.camera, Camera, "camera")
        exterior = np.array(_validate.one_point(self.exterior, 6, "exterior"))
        exterior.flags.writeable = False
        pixel_size = _validate.positive_number(self.pixel_size, "pixel_size", "mm")
        corner = _validate.of_shape(self.corner, (2,), "corner")
        column, row = (_validate.whole(v, "corner", 0) for v in corner)
        if self.crs is not None:
            _validate.text(self.crs, "crs")
        size = None
        if self.image_size is not None:
            columns, rows = (int(n) for n in _validate.image_size(self.image_size))
            size = columns, rows
        end = column + grey.shape[1], row + grey.shape[0]
        whole = size or grey.shape[::-1]
        if end[0] > whole[0] or end[1] > whole[1]:
            raise ValueError(
                f"grey from corner ({column}, {row}) to ({end[0]}, {end[1]}) does not"
                f" lie inside an image_size of {whole[0]} columns and {whole[1]} rows."
                " Both are (column, row) of the whole photo; grey.shape is (rows,"
                " columns)"
            )
        for name, value in (
            ("grey", grey),
            ("exterior", exterior),
            ("pixel_size", pixel_size),
            ("image_size", size),
            ("corner", (column, row)),
        ):
            object.__setattr__(self, name, value)

    @property
    def sensor(self) -> tuple[int, int]:
        """Columns and rows of the whole photo."""
        rows, columns = self.grey.shape
        return self.image_size or (columns, rows)

    def to_photo(self, pixels: ArrayLike) -> np.ndarray:
        """Photo coordinates (..., 2) in mm, as measured, of pixels of `grey`."""
        moved = _validate.points(pixels, 2, "pixels") + self.corner
        return frames.pixel_to_photo(
            moved, self.sensor, self.pixel_size, check_size=False
        )

    def to_pixel(self, photo: ArrayLike) -> np.ndarray:
        """Pixels (..., 2) of `grey` of measured photo coordinates in mm."""
        return frames.photo_to_pixel(photo, self.sensor, self.pixel_size) - self.corner

    def ideal(self, pixels: ArrayLike) -> np.ndarray:
        """Ideal coordinates (..., 2) in mm of pixels: freed from lens and x0, y0."""
        return ideal(self.camera, self.to_photo(pixels))

    def without_lens(self, pixels: ArrayLike) -> np.ndarray:
        """Pixels (..., 2) of the same rays if the lens had no distortion."""
        return self.to_pixel(self.ideal(pixels) + (self.camera.x0, self.camera.y0))

    def rays(self, pixels: ArrayLike) -> np.ndarray:
        """Directions (..., 3) in object space, of length c and more, of pixels."""
        xy = self.ideal(pixels)
        image = np.concatenate([xy, np.full((*xy.shape[:-1], 1), -self.camera.c)], -1)
        return image @ attitude(self.exterior)

    def of_rays(self, directions: ArrayLike) -> np.ndarray:
        """Pixels (..., 2) of directions (..., 3) in object space, all in front."""
        u = _validate.points(directions, 3, "directions") @ attitude(self.exterior).T
        _validate.refuse(
            u[..., 2] >= 0, "directions{} do not lie in front of the camera"
        )
        xy = -self.camera.c * u[..., :2] / u[..., 2:]
        return self.to_pixel(measured(self.camera, xy))

    def seen_at(self, directions: ArrayLike) -> np.ndarray:
        """As `of_rays`; NaN behind the camera, or too far outside for the lens."""
        u = _validate.points(directions, 3, "directions") @ attitude(self.exterior).T
        ahead = u[..., 2] < 0
        xy = -self.camera.c * u[..., :2] / np.where(ahead, u[..., 2], -1)[..., None]
        lens, centre = self.camera.interior[3:], self.camera.interior[1:3]
        if self.camera.lens == "backward":
            moved, solved = undistort(lens, xy)
        else:
            moved, solved = xy + distortion(lens, xy), ~beyond_fold(lens, xy)
        good = (ahead & solved)[..., None]
        return np.where(good, self.to_pixel(np.where(good, moved, 0) + centre), np.nan)

    def project(self, points: ArrayLike) -> np.ndarray:
        """Pixels (..., 2) of `grey` that object points (..., 3) are imaged on."""
        return self.to_pixel(project(self.camera, self.exterior, points))

    def outline(self, n: int = 30) -> np.ndarray:
        """Pixels (4 n, 2) along the edge of `grey`, n a side, all around."""
        n = _validate.whole(n, "n", 1, 10**6)
        t, o = np.arange(n) / n, np.zeros(n)
        around = [(t, o), (o + 1, t), (1 - t, o + 1), (o, 1 - t)]
        rows, columns = self.grey.shape
        edge = np.concatenate([np.stack(side, -1) for side in around])
        return edge * (columns, rows) - 0.5
