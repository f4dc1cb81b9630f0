"""Images of targets, and what a camera makes of an image."""

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate

# Grey values are integrated over each pixel by Gauss-Legendre quadrature: five nodes a
# side leave less than 1e-3 of a grey value for a blur of half a pixel and more.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_CHUNK = 1 << 18  # nodes at a time: 2 MB, which fits into the cache


def target(
    centre: ArrayLike,
    diameter: float = 10.0,
    shape: tuple[int, int] = (21, 21),
    foreground: float = 200.0,
    background: float = 40.0,
    blur: float = 0.7,
) -> np.ndarray:
    """Images of circular targets with exactly known centres, without noise.

    A disc with a soft edge, integrated over the area of each pixel. The edge falls from
    foreground to background as the distribution function of a normal distribution with
    the standard deviation `blur`, so the centre is exact by symmetry.

    Parameters
    ----------
    centre : array_like (..., 2)
        (column, row) of the centres in pixels, integers at pixel centres.
    diameter : float
        Diameter of the disc at half height, in pixels. Below four times the blur the
        profile has a peak that the quadrature over the pixel misses a little.
    shape : (rows, columns)
        Shape of each image.
    foreground, background : float
        Grey values inside and outside; a dark target has foreground < background.
    blur : float
        Width of the edge (standard deviation), in pixels; at least 0.3.

    Returns
    -------
    ndarray (..., rows, columns)
        Grey values, not rounded.

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite, or the edge is too sharp for the
        quadrature.

    Examples
    --------
    >>> image = target((10.25, 9.5), diameter=8)
    >>> image.shape
    (21, 21)
    >>> print(f"{image.max():.1f}")
    200.0
    """
    centre = _validate.points(centre, 2, "centre")
    diameter = _validate.positive_number(diameter, "diameter", "px")
    if (blur := _validate.number(blur, "blur")) < 0.3:
        raise ValueError(f"blur must be at least 0.3 px to be exact; got {blur}")
    rows, columns = image_shape(shape)
    foreground = _validate.number(foreground, "foreground")
    background = _validate.number(background, "background")
    _validate.size("shape", centre.size, 5 * rows, 5 * columns)
    flat = centre.reshape(-1, 2)
    pieces = max(1, len(flat) * rows * columns * _NODES.size**2 // _CHUNK)
    discs = np.concatenate(
        [
            _disc(part, diameter, rows, columns, blur)
            for part in np.array_split(flat, pieces)
        ]
    ).reshape(*centre.shape[:-1], rows, columns)
    return background + (foreground - background) * discs


def _disc(
    centre: np.ndarray, diameter: float, rows: int, columns: int, blur: float
) -> np.ndarray:
    """Shares (n, rows, columns) of the disc in each pixel, around centres (n, 2)."""
    nodes, n, weights = _NODES / 2, _NODES.size, _WEIGHTS / 2
    x = (np.arange(columns)[:, None] + nodes).ravel() - centre[:, None, 0]
    y = (np.arange(rows)[:, None] + nodes).ravel() - centre[:, None, 1]
    radius = np.hypot(x[:, None, :], y[:, :, None])
    profile = (1 - scipy.special.erf((radius - diameter / 2) / (np.sqrt(2) * blur))) / 2
    fine = profile.reshape(-1, rows, n, columns, n)
    return np.einsum("kinjm,n,m->kij", fine, weights, weights)


def photograph(
    image: ArrayLike,
    noise: float,
    seed: int | Sequence[int],
    bits: int | None = None,
) -> np.ndarray:
    """Add normal noise to an image and, if wanted, round it as a camera does.

    Parameters
    ----------
    image : array_like
        Grey values of any shape; not changed.
    noise : float
        Standard deviation of the noise, in grey values.
    seed : int or sequence of int
        Seed of the random numbers: the same seed gives the same noise.
    bits : int, optional
        Round to whole grey values and clip to 0 ... 2**bits - 1. Not rounded without.

    Returns
    -------
    ndarray
        Noisy grey values as floats.

    Raises
    ------
    ValueError
        If an argument is no such number, or the noise is negative.

    Examples
    --------
    >>> photograph([100.0, 300.0], noise=0.0, seed=1, bits=8)
    array([100., 255.])
    """
    image = _validate.finite(image, "image")
    noise = _validate.not_negative(noise, "noise", "grey values")
    noisy = image + generator(seed).normal(0.0, noise, image.shape)
    if bits is None:
        return noisy
    bits = _validate.whole(bits, "bits", 1, 32)
    return np.clip(np.round(noisy), 0, 2**bits - 1)


def image_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return (rows, columns) of an image that is not too large."""
    size = _validate.positive(shape, "shape", "px")
    if size.shape != (2,) or np.any(size != np.round(size)):
        raise ValueError(
            "shape must be (rows, columns), whole numbers; got"
            f" {_validate.shown(shape)}"
        )
    rows, columns = int(size[0]), int(size[1])
    _validate.size("shape", rows, columns)
    return rows, columns


def generator(seed: int | Sequence[int]) -> np.random.Generator:
    """Return random numbers from a seed: a whole number, not negative, or several."""
    if isinstance(seed, list | tuple):
        return np.random.default_rng(
            [_validate.whole(s, "seed", 0, 2**63) for s in seed]
        )
    return np.random.default_rng(_validate.whole(seed, "seed", 0, 2**63))
