"""Pairs of images with known sub-pixel truth: of a texture, and out of a real image."""

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from pgm_lab import _validate
from pgm_lab.simulate.images import image_shape, photograph
from pgm_lab.simulate.texture import Texture


def texture_pair(
    texture: Texture,
    shape: tuple[int, int],
    affine: ArrayLike,
    *,
    gain: float = 1.0,
    offset: float = 0.0,
    sigma: float = 0.0,
    dtype: DTypeLike | None = None,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Two images of a texture, the right one warped by a known affine transformation.

    left(x, y) = texture(x, y), and right(x', y') = gain * texture(x, y) + offset at
    x' = a0 + a1 x + a2 y, y' = b0 + b1 x + b2 y: exact at every pixel.

    Parameters
    ----------
    texture : Texture
    shape : (rows, columns)
        Shape of both images.
    affine : array_like (6,)
        (a0, a1, a2, b0, b1, b2), from left to right pixel coordinates.
    gain, offset : float
        Of the right image's grey values.
    sigma : float
        Standard deviation of the white noise in each image, in grey values.
    dtype : data type, optional
        numpy.uint8 or numpy.uint16: grey values are rounded and clipped. Float and not
        rounded without.
    seed : int
        Seed of the noise.

    Returns
    -------
    left, right : ndarray (rows, columns)

    Raises
    ------
    ValueError
        If the affine transformation is not six numbers or flattens the plane, or a
        shape, sigma or dtype is not as said.

    Notes
    -----
    Where the transformation shrinks the texture, its frequencies grow; beyond 0.5
    cycles per pixel the right image shows an alias, as a camera's would.

    References
    ----------
    Bani 2010, (B 2.8) and (B 2.9), for the names of the parameters. His (B 2.7) has
    left = h0 + h1 right: h1 is 1 / gain, and h0 is -offset / gain.

    Examples
    --------
    >>> from pgm_lab.simulate import texture
    >>> left, right = texture_pair(texture(), (60, 80), (3, 1, 0, 2, 0, 1))
    >>> bool(np.allclose(right[2:, 3:], left[:-2, :-3]))
    True
    """
    _validate.instance(texture, Texture, "texture")
    rows, columns = image_shape(shape)
    _validate.size("shape and waves", max(rows, columns), len(texture.phases))
    sigma = _validate.not_negative(sigma, "sigma", "grey values")
    seed = _validate.whole(seed, "seed", 0, 2**63)
    gain, offset = _validate.number(gain, "gain"), _validate.number(offset, "offset")
    bits = bits_of(dtype)
    right = gain * _image(_warped(texture, affine), rows, columns) + offset
    left = _image(texture, rows, columns)
    return (
        photograph(left, sigma, [seed, 0], bits).astype(dtype),
        photograph(right, sigma, [seed, 1], bits).astype(dtype),
    )


def _image(texture: Texture, rows: int, columns: int) -> np.ndarray:
    """Grey values at all pixels of an image.

    cos(u + v) = cos u cos v - sin u sin v separates rows from columns: two small
    matrices multiplied, instead of a cosine for each pixel and wave.
    """
    fx, fy = 2 * np.pi * texture.frequencies.T
    u = np.arange(rows)[:, None] * fy + texture.phases
    v = np.arange(columns)[:, None] * fx
    down = np.hstack([texture.amplitudes * np.cos(u), -texture.amplitudes * np.sin(u)])
    return texture.mean + down @ np.hstack([np.cos(v), np.sin(v)]).T


def _warped(texture: Texture, affine: ArrayLike) -> Texture:
    """The texture as seen in the coordinates p' = t + J p: again a sum of waves.

    From p = J^-1 (p' - t) follows f . p = f' . p' - f' . t with f' = J^-T f.
    """
    affine = _validate.finite(affine, "affine")
    if affine.shape != (6,):
        raise ValueError(
            "affine must be six numbers (a0, a1, a2, b0, b1, b2);"
            f" got shape {affine.shape}"
        )
    t, J = affine[[0, 3]], affine.reshape(2, 3)[:, 1:]
    determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
    if abs(determinant) < 1e-12 * np.sum(J**2) or not np.any(J):
        raise ValueError(
            f"affine must not flatten the plane: a1 b2 - a2 b1 is {determinant}; the"
            " identity is (0, 1, 0, 0, 0, 1)"
        )
    frequencies = texture.frequencies @ np.linalg.inv(J)
    phases = texture.phases - 2 * np.pi * frequencies @ t
    return Texture(frequencies, texture.amplitudes, phases, texture.mean)


def bits_of(dtype: DTypeLike | None) -> int | None:
    """Bits of a data type of grey values; None for float."""
    try:
        kind = np.dtype(dtype)
    except Exception:  # whatever NumPy makes of a stranger's object
        kind = np.dtype(object)
    if kind not in (np.uint8, np.uint16, np.float64):
        raise ValueError(
            f"dtype must be uint8, uint16 or float (None); got {_validate.shown(dtype)}"
        )
    return None if kind == np.float64 else 8 * kind.itemsize


def shrunk_pair(
    image: ArrayLike, shift: tuple[int, int], factor: int
) -> tuple[np.ndarray, np.ndarray]:
    """Two small images out of one large, shifted by a known part of a pixel.

    The image is cut twice, the second time shifted by whole pixels, and both parts are
    averaged down. What stands at (x, y) in the left image stands at (x, y) plus
    shift / factor in the right one: a real image with known sub-pixel truth.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values.
    shift : (columns, rows)
        Whole pixels of the large image, of either sign.
    factor : int
        Side of the square of pixels that becomes one, 2 or 4 as a rule.

    Returns
    -------
    left, right : ndarray (m, n)
        Means of factor x factor pixels, not rounded.

    Raises
    ------
    ValueError
        If the image is not 2-D, shift or factor are not whole numbers, or nothing of
        the image is left.

    Notes
    -----
    The mean over a square keeps a part of the detail too fine for the small pixels. It
    appears as an alias that does not move by shift / factor.

    Examples
    --------
    >>> row = np.tile(np.arange(8.0), (2, 1))
    >>> left, right = shrunk_pair(row, shift=(1, 0), factor=2)
    >>> left, right
    (array([[1.5, 3.5, 5.5]]), array([[0.5, 2.5, 4.5]]))
    """
    grey = _validate.image(image)
    both = _validate.finite(shift, "shift")
    if both.shape != (2,) or np.any(both != np.round(both)):
        raise ValueError(f"shift must be two whole numbers (columns, rows); got {both}")
    dx, dy = both.astype(int)
    factor = _validate.whole(factor, "factor", least=2)
    rows = (grey.shape[0] - abs(dy)) // factor
    columns = (grey.shape[1] - abs(dx)) // factor
    if min(rows, columns) < 1:
        raise ValueError(
            f"nothing is left of an image of shape {grey.shape} after a shift of"
            f" ({dx}, {dy}) pixels (columns, rows) and a factor of {factor}"
        )

    def part(x: int, y: int) -> np.ndarray:
        cut = grey[y : y + rows * factor, x : x + columns * factor]
        return cut.reshape(rows, factor, columns, factor).mean(axis=(1, 3))

    # What moves to the right in the image comes from further left in the large one
    x, y = max(dx, 0), max(dy, 0)
    return part(x, y), part(x - dx, y - dy)
