"""From pixel to photo and to the ground: image frames, scale and pixel size.

Pixel coordinates are (column, row): x right, y down, integers at pixel centres, the
origin at the centre of the top-left pixel. Photo coordinates are in millimetres: x
right, y up, the origin at the centre of the image. Arguments that are not as described
raise ValueError.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate

__all__ = [
    "flying_height",
    "ground_sampling_distance",
    "image_centre",
    "interior_matrix",
    "photo_to_pixel",
    "pixel_size_from_sensor",
    "pixel_to_photo",
    "scale_number",
]


# --- From pixel to photo and back ---


def image_centre(image_size: ArrayLike) -> np.ndarray:
    """Pixel coordinates (column, row) of the centre of an image of (columns, rows).

    The centre of n pixels that are counted 0, 1, ..., n - 1 is n/2 - 0.5.

    References
    ----------
    (B 2.4a), (B 2.4b); (M 2.17).

    Examples
    --------
    >>> image_centre((1936, 1296))
    array([967.5, 647.5])
    """
    return _validate.image_size(image_size) / 2 - 0.5


def pixel_to_photo(
    pixels: ArrayLike,
    image_size: ArrayLike,
    pixel_size: ArrayLike,
    check_size: bool = True,
    *,
    covariance: ArrayLike | None = None,
) -> Any:
    """Convert pixel coordinates into photo coordinates, and their covariance if given.

    The formula holds outside the image too.

    Parameters
    ----------
    pixels : array_like (..., 2)
        (column, row) in pixels.
    image_size : (columns, rows)
        In pixels.
    pixel_size : float or (x, y)
        Size of a pixel on the sensor, in mm.
    check_size : bool
        Refuse points outside the image that are inside with columns and rows exchanged;
        False for computed points.
    covariance : array_like (..., 2, 2), optional
        Of (column, row) in square pixels, one for each point or one for all.

    Returns
    -------
    photo : ndarray (..., 2)
        (x, y) in mm.
    covariance : ndarray (..., 2, 2)
        Of (x, y) in mm^2, only if one was given: J C J^T with J = diag(size_x,
        -size_y).

    Raises
    ------
    ValueError
        Also if the image size is evidently (rows, columns).

    References
    ----------
    (B 2.3a), (B 2.3b); (M 2.16).

    Examples
    --------
    >>> pixel_to_photo([[0, 0], [1935, 1295]], (1936, 1296), 0.01)
    array([[-9.675,  6.475],
           [ 9.675, -6.475]])
    >>> C = [[0.04, 0.01], [0.01, 0.09]]
    >>> photo, C = pixel_to_photo([0, 0], (1936, 1296), 0.01, covariance=C)
    >>> C
    array([[ 4.e-06, -1.e-06],
           [-1.e-06,  9.e-06]])
    """
    pixels = _validate.points(pixels, 2, "pixels")
    if _validate.flag(check_size, "check_size"):
        _check_not_exchanged(_validate.image_size(image_size), pixels)
    xc, yc = image_centre(image_size)
    size_x, size_y = _validate.pair(pixel_size, "pixel_size", "mm")
    x = (pixels[..., 0] - xc) * size_x
    y = (yc - pixels[..., 1]) * size_y
    photo = np.stack([x, y], axis=-1)
    if covariance is None:
        return photo
    return photo, _propagated(covariance, photo, size_x, -size_y)


def photo_to_pixel(
    photo: ArrayLike,
    image_size: ArrayLike,
    pixel_size: ArrayLike,
    *,
    covariance: ArrayLike | None = None,
) -> Any:
    """Convert photo coordinates into pixel coordinates: inverse of `pixel_to_photo`.

    Parameters
    ----------
    photo : array_like (..., 2)
        (x, y) in mm.
    image_size, pixel_size
        As for `pixel_to_photo`.
    covariance : array_like (..., 2, 2), optional
        Of (x, y) in mm^2, one for each point or one for all.

    Returns
    -------
    pixels : ndarray (..., 2)
        (column, row) in pixels.
    covariance : ndarray (..., 2, 2)
        Of (column, row) in square pixels, only if one was given.

    References
    ----------
    (B 2.5a); (B 2.5b) with its sign reversed, so that it inverts (B 2.3b).

    Examples
    --------
    >>> photo_to_pixel([0, 0], (1936, 1296), 0.0122)
    array([967.5, 647.5])
    """
    photo = _validate.points(photo, 2, "photo")
    xc, yc = image_centre(image_size)
    size_x, size_y = _validate.pair(pixel_size, "pixel_size", "mm")
    column = photo[..., 0] / size_x + xc
    row = yc - photo[..., 1] / size_y
    pixels = np.stack([column, row], axis=-1)
    if covariance is None:
        return pixels
    return pixels, _propagated(covariance, pixels, 1 / size_x, -1 / size_y)


def _check_not_exchanged(size: np.ndarray, pixels: np.ndarray) -> None:
    """Reject an image size that contains the pixels only with rows for columns."""
    if not pixels.size:
        return
    column, row = pixels[..., 0], pixels[..., 1]
    first = np.array([column.min(), row.min()])
    last = np.array([column.max(), row.max()])

    def holds(size: np.ndarray) -> bool:
        return bool(np.all(first >= -0.5) and np.all(last <= size - 0.5))

    if not holds(size) and holds(size[::-1]):
        columns, rows = size.astype(int)
        raise ValueError(
            f"the pixels lie outside an image of {columns} columns and {rows} rows, but"
            " inside one with the two exchanged: image_size must be (columns, rows),"
            " and image.shape is (rows, columns)"
        )


def _propagated(
    covariance: ArrayLike, points: np.ndarray, by_x: float, by_y: float
) -> np.ndarray:
    """J C J^T for each point (..., 2), with J = diag(by_x, by_y)."""
    C = _validate.covariances(covariance, "covariance")
    try:
        C = np.broadcast_to(C, (*points.shape, 2))
    except ValueError:
        raise ValueError(
            f"covariance must be one (2, 2) or one for each point,"
            f" {(*points.shape, 2)}; got {C.shape}"
        ) from None
    scale = np.array([by_x, by_y])
    return C * scale * scale[:, None]


def pixel_size_from_sensor(sensor_size: ArrayLike, image_size: ArrayLike) -> np.ndarray:
    """Size (x, y) of a pixel, in mm, from the size of the sensor.

    A portrait sensor with a landscape image, or the reverse, is refused.

    Parameters
    ----------
    sensor_size : (width, height)
        Of the part of the sensor that the image shows, in mm.
    image_size : (columns, rows)
        In pixels.

    Examples
    --------
    >>> pixel_size_from_sensor((23.6, 15.8), (1936, 1296)).round(6)
    array([0.01219 , 0.012191])
    """
    sensor = _validate.pair(sensor_size, "sensor_size", "mm")
    image = _validate.image_size(image_size)
    if (sensor[0] - sensor[1]) * (image[0] - image[1]) < 0:
        raise ValueError(
            f"a sensor of (width, height) = ({sensor[0]:g}, {sensor[1]:g}) mm and an"
            f" image of (columns, rows) = ({image[0]:g}, {image[1]:g}) are not"
            " both portrait or both landscape: swap the two of one; image.shape is"
            " (rows, columns)"
        )
    return sensor / image


def interior_matrix(c: float, x0: float = 0.0, y0: float = 0.0) -> np.ndarray:
    """Matrix (3, 3) from photo coordinates (x, y, 1) to the image vector.

    That is (x - x0, y - y0, -c), in mm: the ray from the perspective centre.

    Parameters
    ----------
    c : float
        Principal distance in mm, positive.
    x0, y0 : float
        Principal point in the photo frame, in mm.

    References
    ----------
    (M 2.1), with f for the principal distance c.

    Examples
    --------
    >>> interior_matrix(35.0, 0.1, -0.2) @ (1.1, 0.8, 1.0)
    array([  1.,   1., -35.])
    """
    c = _validate.positive_number(c, "c", "mm")
    x0, y0 = _validate.number(x0, "x0"), _validate.number(y0, "y0")
    return np.array([[1.0, 0.0, -x0], [0.0, 1.0, -y0], [0.0, 0.0, -c]])


# --- From photo to the ground, for vertical photos of level ground ---


def scale_number(
    flying_height: ArrayLike, principal_distance: ArrayLike
) -> np.ndarray | float:
    """Scale number H / c: metres on the ground for each metre in the photo.

    Parameters
    ----------
    flying_height : array_like
        Height H of the perspective centre above the ground, in m.
    principal_distance : array_like
        Principal distance c, in mm; broadcasts against the height.

    References
    ----------
    Harintaka 2020, H/f in "Hasil dan Pembahasan".

    Examples
    --------
    >>> print(f"1 : {scale_number(1000.0, 24.0):.0f}")
    1 : 41667
    """
    height = _validate.positive(flying_height, "flying_height", "m")
    c = _validate.positive(principal_distance, "principal_distance", "mm")
    return height / (c / 1000)


def ground_sampling_distance(
    pixel_size: ArrayLike, flying_height: ArrayLike, principal_distance: ArrayLike
) -> np.ndarray | float:
    """Size of a pixel on the ground (ground sampling distance, GSD), in m.

    Parameters
    ----------
    pixel_size : array_like
        Size of a pixel on the sensor, in mm.
    flying_height : array_like
        Height above the ground, in m.
    principal_distance : array_like
        In mm. All three broadcast against each other.

    References
    ----------
    Harintaka 2020, "Metode": GSD = pixel size times H/f.

    Examples
    --------
    >>> print(f"{ground_sampling_distance(0.00549, 1000.0, 24.0):.3f} m")
    0.229 m
    """
    size = _validate.positive(pixel_size, "pixel_size", "mm")
    return size / 1000 * scale_number(flying_height, principal_distance)


def flying_height(
    gsd: ArrayLike, pixel_size: ArrayLike, principal_distance: ArrayLike
) -> np.ndarray | float:
    """Height above the ground, in m, that gives a required ground sampling distance.

    The inverse of `ground_sampling_distance`, with its arguments.

    Examples
    --------
    >>> print(f"{flying_height(0.20, 0.00549, 24.0):.1f} m")
    874.3 m
    """
    distance = _validate.positive(gsd, "gsd", "m")
    size = _validate.positive(pixel_size, "pixel_size", "mm")
    c = _validate.positive(principal_distance, "principal_distance", "mm")
    return distance * c / size
