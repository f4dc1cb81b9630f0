"""Texture that is known between the pixels too.

A texture is a sum of plane waves. Its grey value and its gradient follow at any point
from a formula, so that images of it need no interpolation, however they are warped.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

_CHUNK = 1 << 18  # phases at a time: 2 MB, which fits into the cache


@dataclass(frozen=True)
class Texture:
    """Sum of plane waves: g(p) = mean + sum of a_k cos(2 pi f_k . p + phi_k).

    Attributes
    ----------
    frequencies : ndarray (m, 2)
        Along columns and rows, in cycles per pixel.
    amplitudes : ndarray (m,)
        In grey values.
    phases : ndarray (m,)
        At the point (0, 0), in radians.
    mean : float
        Mean grey value.
    """

    frequencies: np.ndarray
    amplitudes: np.ndarray
    phases: np.ndarray
    mean: float


def texture(
    cutoff: float = 0.2,
    *,
    contrast: float = 40.0,
    mean: float = 120.0,
    waves: int = 200,
    seed: int = 0,
) -> Texture:
    """Random texture without detail finer than a cut-off frequency.

    The frequencies are spread evenly over the disc |f| <= cutoff, with equal amplitudes
    and random phases.

    Parameters
    ----------
    cutoff : float
        Highest frequency, in cycles per pixel: 0.2 is soft, 0.4 sharp, and above 0.5 an
        image cannot represent it.
    contrast : float
        Standard deviation of the grey values over the plane. Over a small window it
        differs.
    mean : float
        Mean of the grey values over the plane.
    waves : int
        Number of plane waves. With 200 the grey values are nearly normal.
    seed : int
        Seed of the random numbers: the same seed gives the same texture.

    Raises
    ------
    ValueError
        If the cut-off is not between 0 and 0.5.

    Examples
    --------
    >>> soft = texture(cutoff=0.2, seed=1)
    >>> grey_values(soft, [(10.0, 20.0), (10.25, 20.0)]).round(1)
    array([115.9, 123.7])
    """
    if not 0 < cutoff <= 0.5:
        raise ValueError(
            f"cutoff must lie between 0 and 0.5 cycles per pixel; got {cutoff}"
        )
    rng = np.random.default_rng(seed)
    radius = cutoff * np.sqrt(rng.uniform(size=waves))  # the root: evenly by area
    direction, phases = rng.uniform(0, 2 * np.pi, (2, waves))
    frequencies = np.stack(
        [radius * np.cos(direction), radius * np.sin(direction)], axis=-1
    )
    # A cosine of amplitude a has the variance a^2 / 2
    amplitudes = np.full(waves, contrast * np.sqrt(2 / waves))
    return Texture(frequencies, amplitudes, phases, mean)


def grey_values(texture: Texture, points: ArrayLike) -> np.ndarray:
    """Grey values (...) of a texture at any points, by its formula.

    Parameters
    ----------
    texture : Texture
    points : array_like (..., 2)
        (column, row) in pixels.

    Examples
    --------
    >>> wave = Texture(np.array([[0.25, 0.0]]), np.array([10.0]), np.zeros(1), 100.0)
    >>> grey_values(wave, [(0, 0), (1, 0), (2, 7)]).round(6)
    array([110., 100.,  90.])
    """
    points = np.asarray(points, dtype=float)

    def values(phase: np.ndarray) -> np.ndarray:
        return np.cos(phase) @ texture.amplitudes

    return texture.mean + _over_chunks(values, texture, points).reshape(
        points.shape[:-1]
    )


def grey_gradients(texture: Texture, points: ArrayLike) -> np.ndarray:
    """Derivatives (..., 2) of a texture's grey values at any points, by its formula.

    Parameters
    ----------
    texture : Texture
    points : array_like (..., 2)
        (column, row) in pixels.

    Returns
    -------
    ndarray (..., 2)
        Along columns and rows, in grey values per pixel.

    Examples
    --------
    >>> wave = Texture(np.array([[0.25, 0.0]]), np.array([10.0]), np.zeros(1), 100.0)
    >>> grey_gradients(wave, (1, 0)).round(2)
    array([-15.71,   0.  ])
    """
    points = np.asarray(points, dtype=float)
    factors = -2 * np.pi * texture.amplitudes[:, None] * texture.frequencies

    def gradients(phase: np.ndarray) -> np.ndarray:
        return np.sin(phase) @ factors

    return _over_chunks(gradients, texture, points).reshape(points.shape)


def _over_chunks(
    function: Callable[[np.ndarray], np.ndarray], texture: Texture, points: np.ndarray
) -> np.ndarray:
    """`function` of the phases (points, waves), in pieces that fit into memory."""
    points = points.reshape(-1, 2)
    pieces = max(1, points.shape[0] * texture.phases.size // _CHUNK)
    return np.concatenate(
        [
            function(2 * np.pi * part @ texture.frequencies.T + texture.phases)
            for part in np.array_split(points, pieces)
        ]
    )
