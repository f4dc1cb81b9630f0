"""From photo to the ground: scale, size of a pixel on the ground, flying height."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


def scale_number(
    flying_height: ArrayLike, principal_distance: ArrayLike
) -> np.ndarray | float:
    """Scale number H / c of a vertical photo of level ground.

    The image scale is 1 : scale number; in a tilted photo or over hilly ground it
    changes from point to point.

    Parameters
    ----------
    flying_height : array_like
        Height H of the perspective centre above the ground, in m.
    principal_distance : array_like
        Principal distance c, in mm; broadcasts against the height.

    Returns
    -------
    float or ndarray
        Metres on the ground for each metre in the photo.

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
    """Size of a pixel on level ground (ground sampling distance, GSD).

    Parameters
    ----------
    pixel_size : array_like
        Size of a pixel on the sensor, in mm.
    flying_height : array_like
        Height above the ground, in m.
    principal_distance : array_like
        Principal distance, in mm. All three broadcast against each other.

    Returns
    -------
    float or ndarray
        Ground sampling distance, in m.

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
    """Height above level ground that gives a wanted ground sampling distance.

    Parameters
    ----------
    gsd : array_like
        Ground sampling distance, in m.
    pixel_size : array_like
        Size of a pixel on the sensor, in mm.
    principal_distance : array_like
        Principal distance, in mm. All three broadcast against each other.

    Returns
    -------
    float or ndarray
        Flying height, in m.

    Examples
    --------
    >>> print(f"{flying_height(0.20, 0.00549, 24.0):.1f} m")
    874.3 m
    """
    distance = _validate.positive(gsd, "gsd", "m")
    size = _validate.positive(pixel_size, "pixel_size", "mm")
    c = _validate.positive(principal_distance, "principal_distance", "mm")
    return distance * c / size
