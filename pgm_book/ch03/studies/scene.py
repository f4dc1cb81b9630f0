"""Pairs of textured images with known truth, for the experiments of chapter 3."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import DTypeLike

from pgm_lab import simulate
from pgm_lab.adjustment import normal

SOFT, SHARP = 0.2, 0.4  # cycles per pixel
IDENTITY = np.eye(2)
PART = 250  # points whose windows are held at a time


@dataclass(frozen=True)
class Scene:
    """A texture seen twice, and points (n, 2) whose windows do not overlap.

    The right image is warped by `affine`: each of its four elements differs by 1 to 2
    per cent from the identity.
    """

    texture: simulate.Texture
    affine: np.ndarray
    shape: tuple[int, int]
    points: np.ndarray

    @property
    def truth(self) -> np.ndarray:
        """The points in the right image (n, 2)."""
        return warp(self.affine, self.points)

    @property
    def start(self) -> np.ndarray:
        """The truth rounded to whole pixels, as correlation would find it."""
        return np.rint(self.truth)

    def images(
        self,
        sigma: float,
        *,
        gain: float = 1.08,
        offset: float = 4.0,
        dtype: DTypeLike = None,
        seed: int = 0,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Left and right image with noise."""
        return simulate.texture_pair(
            self.texture,
            self.shape,
            self.affine,
            gain=gain,
            offset=offset,
            sigma=sigma,
            dtype=dtype,
            seed=seed,
        )

    def bound(
        self, window: int = 21, *, gain: float = 1.08, radiometric: bool = True
    ) -> np.ndarray:
        """Cramer-Rao bound (n, 2, 2) of the points for a noise of one grey value."""
        grey, *gradient = self._noise_free
        found = []
        for part in np.array_split(self.points, max(len(self.points) // PART, 1)):
            found.append(
                cramer_rao(
                    windows(grey, part, window),
                    np.stack([windows(g, part, window) for g in gradient], axis=-1),
                    1.0,
                    gain=gain,
                    shape=self.affine.reshape(2, 3)[:, 1:],
                    radiometric=radiometric,
                )
            )
        return np.concatenate(found)

    @cached_property
    def _noise_free(self) -> list[np.ndarray]:
        """Left image and its derivatives by x and y."""
        return [
            simulate.texture_pair(t, self.shape, (0, 1, 0, 0, 0, 1))[0]
            for t in (self.texture, *derivatives(self.texture))
        ]


def cramer_rao(
    grey: np.ndarray,
    gradients: np.ndarray,
    sigma: float,
    *,
    gain: float = 1.0,
    shape: np.ndarray = IDENTITY,
    radiometric: bool = True,
) -> np.ndarray:
    """Smallest covariance (..., 2, 2) of the centres that unbiased matches can have.

    White normal noise of `sigma` in both images; the right one has `gain` times the
    contrast. Unknown are the parameters of (B 2.10), with or without h0 and h1, and the
    grey value that each pixel would have without noise; therefore the noise of a
    difference counts. Infinite where the texture does not determine the centre.
    Foerstner 1982, for shifts; here with the normal matrix of (B 2.11).
    """
    half = grey.shape[-1] // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
    flat = grey.reshape(*grey.shape[:-2], -1)
    g = gradients.reshape(*flat.shape, 2)
    columns = [g[..., axis] * row for axis in (0, 1) for row in (1.0, x, y)]
    if radiometric:
        # Without its mean: that is h0, and would only hide the texture
        columns += [np.ones_like(flat), flat - flat.mean(axis=-1, keepdims=True)]
    A = np.stack(columns, axis=-1)
    N = np.swapaxes(A, -1, -2) @ A
    _, Q, _, singular = normal.solve(N, np.zeros(N.shape[:-1]))
    bound = shape @ Q[..., [[0], [3]], [[0, 3]]] @ np.swapaxes(shape, -1, -2)
    bound *= sigma**2 * (1 + 1 / gain**2)
    bound[singular] = np.inf
    return bound


def scene(
    cutoff: float,
    seed: int,
    *,
    contrast: float = 40.0,
    size: int = 900,
    spacing: int = 26,
    margin: int = 12,
) -> Scene:
    """Scene of size x size pixels with points on a grid, `margin` around each."""
    rng = np.random.default_rng([3, seed])
    texture = simulate.texture(cutoff, contrast=contrast, seed=seed)
    J = np.eye(2) + rng.choice([-1, 1], (2, 2)) * rng.uniform(0.01, 0.02, (2, 2))
    middle = np.full(2, (size - 1) / 2)
    shift = middle - J @ middle + rng.uniform(-1, 1, 2)
    affine = np.column_stack([shift, J]).ravel()
    return Scene(texture, affine, (size, size), grid(size, spacing, margin, affine))


def grid(size: int, spacing: int, margin: int, affine: np.ndarray) -> np.ndarray:
    """Points of a square grid that have `margin` in both images."""
    at = np.arange(margin, size - margin, float(spacing))
    points = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    right = warp(affine, points)
    return points[
        np.all((right > 1.1 * margin) & (right < size - 1.1 * margin), axis=1)
    ]


def warp(affine: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Where points of the left image are in the right one."""
    T = affine.reshape(2, 3)
    return T[:, 0] + points @ T[:, 1:].T


def derivatives(texture: simulate.Texture) -> list[simulate.Texture]:
    """Derivatives by x and y: again waves, a quarter of a period ahead."""
    return [
        simulate.Texture(
            texture.frequencies,
            2 * np.pi * f * texture.amplitudes,
            texture.phases + np.pi / 2,
            0.0,
        )
        for f in texture.frequencies.T
    ]


def windows(image: np.ndarray, points: np.ndarray, window: int) -> np.ndarray:
    """Windows (n, window, window) around whole pixels."""
    x, y = points.astype(int).T - window // 2
    views = np.lib.stride_tricks.sliding_window_view(image, (window, window))
    return views[y, x]


def squared(error: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Squared errors (n, 2) over their variances."""
    return error**2 / np.diagonal(covariance, axis1=1, axis2=2)
