"""Essential and fundamental matrix: the coplanarity of two photos in nine numbers.

`geometry` derives them.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, frames
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.epipolar._base import base, base_of


def essential(left_exterior: ArrayLike, right_exterior: ArrayLike) -> np.ndarray:
    """Essential matrix E of two oriented photos: x'ᵀ E x'' = 0 for each object point.

    Parameters
    ----------
    left_exterior, right_exterior : array_like (6,)
        (X0, Y0, Z0, omega, phi, kappa) in one unit and radians. Of two photos with
        relative orientation only: zeros, and the exterior of `orientation.relative`.

    Returns
    -------
    ndarray (3, 3)
        In the unit of the base: xᵀ E x of rays (x, y, -c) in the frames of their photos
        is F of `orientation.coplanarity.condition`.

    Raises
    ------
    ValueError
        If the input is not what is described here, or the stations are the same.

    Notes
    -----
    Derived in `geometry`. Exchanged photos have the transpose. Two
    of its singular values are the length of the base, the third one is zero.

    References
    ----------
    (M 2.30) to (M 2.35); Longuet-Higgins 1981, Nature 293.

    Examples
    --------
    >>> essential((0, 0, 0, 0, 0, 0), (60, 0, 0, 0, 0, 0)) + 0.0
    array([[  0.,   0.,   0.],
           [  0.,   0.,  60.],
           [  0., -60.,   0.]])
    """
    left = _validate.one_point(left_exterior, 6, "left_exterior")
    right = _validate.one_point(right_exterior, 6, "right_exterior")
    # Row i of `crossed` is b x (row i of M'')
    crossed = np.cross(base(left, right), attitude(right))
    return -attitude(left) @ crossed.T


def fundamental(left: Photo, right: Photo, *, corrected: bool = False) -> np.ndarray:
    """Fundamental matrix F in pixels, as OpenCV has it.

    Parameters
    ----------
    left, right : Photo
    corrected : bool
        Whether the pixels that F is for are freed from lens distortion, as
        `Photo.without_lens` does it. Without lens distortion it makes no difference.

    Returns
    -------
    ndarray (3, 3)
        pᵀ F q = 0 for p = (column, row, 1) in the right and q in the left photo, so
        that F q is the epipolar line of q. Scaled to a Frobenius norm of 1.

    Raises
    ------
    ValueError
        If an argument is not what is described here, both photos stand at the same
        place, or a photo has lens distortion and the pixels are not corrected.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(24.0), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> abs(np.array([12, 9.5, 1]) @ fundamental(left, right) @ (40, 9.5, 1)) < 1e-12
    np.True_
    """
    base_of(left, right)
    if not _validate.flag(corrected, "corrected"):
        for name, photo in (("left", left), ("right", right)):
            if photo.camera.interior[3:].any():
                raise ValueError(
                    f"{name} has lens distortion: its epipolar lines are no straight"
                    " lines, see `curve`. Free the pixels from it (Photo.without_lens)"
                    " and say corrected=True"
                )
    E = essential(left.exterior, right.exterior)
    F = _to_image(right).T @ E.T @ _to_image(left)
    return F / np.linalg.norm(F)


def _to_image(photo: Photo) -> np.ndarray:
    """Matrix (3, 3) from (column, row, 1) to the ray (x, y, -c), without lens."""
    camera, s = photo.camera, photo.pixel_size
    x, y = photo.to_photo((0.0, 0.0))
    pixel = np.array([[s, 0, x], [0, -s, y], [0, 0, 1.0]])
    return frames.interior_matrix(camera.c, camera.x0, camera.y0) @ pixel
