"""Images of targets, and the noise and rounding of a camera."""

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import ArrayLike

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

    A disc integrated over each pixel. Its edge is a normal distribution function with
    the standard deviation `blur`, so the centre is exact by symmetry.

    Parameters
    ----------
    centre : array_like (..., 2)
        (column, row) of the centres in pixels, integers at pixel centres.
    diameter : float
        At half height, in pixels. Below four times the blur the quadrature over the
        pixel misses a little of the peak.
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
        If the edge is too sharp for the quadrature.

    Examples
    --------
    >>> image = target((10.25, 9.5), diameter=8)
    >>> image.shape
    (21, 21)
    >>> print(f"{image.max():.1f}")
    200.0
    """
    if blur < 0.3:
        raise ValueError(f"blur must be at least 0.3 px to be exact; got {blur}")
    centre = np.asarray(centre, dtype=float)
    flat = centre.reshape(-1, 2)
    pieces = max(1, len(flat) * shape[0] * shape[1] * _NODES.size**2 // _CHUNK)
    discs = np.concatenate(
        [_disc(part, diameter, shape, blur) for part in np.array_split(flat, pieces)]
    ).reshape(*centre.shape[:-1], *shape)
    return background + (foreground - background) * discs


def _disc(
    centre: np.ndarray, diameter: float, shape: tuple[int, int], blur: float
) -> np.ndarray:
    """Shares (n, rows, columns) of the disc in each pixel, around centres (n, 2)."""
    (rows, columns), n = shape, _NODES.size
    x = (np.arange(columns)[:, None] + _NODES / 2).ravel() - centre[:, None, 0]
    y = (np.arange(rows)[:, None] + _NODES / 2).ravel() - centre[:, None, 1]
    radius = np.hypot(x[:, None, :], y[:, :, None])
    profile = (1 - scipy.special.erf((radius - diameter / 2) / (np.sqrt(2) * blur))) / 2
    fine = profile.reshape(-1, rows, n, columns, n)
    return np.einsum("kinjm,n,m->kij", fine, _WEIGHTS / 2, _WEIGHTS / 2)


def photograph(
    image: ArrayLike,
    noise: float,
    seed: int | Sequence[int],
    bits: int | None = None,
) -> np.ndarray:
    """Add normal noise to an image and, if requested, round it as a camera does.

    Parameters
    ----------
    image : array_like
        Grey values of any shape; not changed.
    noise : float
        Standard deviation of the noise, in grey values.
    seed : int or sequence of int
        Seed of the random numbers: the same seed gives the same noise.
    bits : int, optional
        Round to whole grey values and clip to 0 ... 2**bits - 1. Default: not rounded.

    Returns
    -------
    ndarray
        Noisy grey values as floats.

    Examples
    --------
    >>> photograph([100.0, 300.0], noise=0.0, seed=1, bits=8)
    array([100., 255.])
    """
    image = np.asarray(image, dtype=float)
    noisy = image + np.random.default_rng(seed).normal(0.0, noise, image.shape)
    if bits is None:
        return noisy
    return np.clip(np.round(noisy), 0, 2 ** int(bits) - 1)
