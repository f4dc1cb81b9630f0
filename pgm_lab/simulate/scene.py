"""Photos of a textured relief, through the collinearity equations: no interpolation."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import frames
from pgm_lab.camera import Camera, ideal, imaging
from pgm_lab.simulate.images import photograph
from pgm_lab.simulate.texture import Texture, grey_gradients, grey_values

MAX_ITERATIONS = 50  # of Newton's method; five are enough for hills
PRECISE = 1e-9  # of the distance


def on_relief(
    lens: Camera,
    exterior: ArrayLike,
    image_points: ArrayLike,
    relief: Texture,
    cell: float = 1.0,
) -> np.ndarray:
    """Points (..., 3) of a relief that a photo shows at given photo coordinates.

    Parameters
    ----------
    lens : camera.Camera
    exterior : array_like (6,)
        (X0, Y0, Z0, omega, phi, kappa), looking down.
    image_points : array_like (..., 2)
        Measured photo coordinates, in mm.
    relief : Texture
        Its "grey values" are heights Z, in object units, at (X, Y) / cell. Slopes must
        be gentler than the rays.
    cell : float
        Object units for each pixel of the relief.

    Raises
    ------
    ValueError
        If a ray does not meet the relief.

    References
    ----------
    (M 2.26): the ray through the perspective centre.

    Examples
    --------
    >>> from pgm_lab.simulate import texture
    >>> hills = texture(cutoff=0.01, contrast=3.0, mean=10.0, waves=20)
    >>> photo = (5, 5, 100, 0.02, -0.01, 0.3)
    >>> X = on_relief(Camera(5.0), photo, [(0, 0), (1, 1.5)], hills)
    >>> bool(np.allclose(X[:, 2], grey_values(hills, X[:, :2])))
    True
    """
    exterior = np.asarray(exterior, dtype=float)
    xy = ideal(lens, image_points)
    u = np.concatenate([xy, np.full((*xy.shape[:-1], 1), -lens.c)], axis=-1)
    ray = u @ imaging.attitude(exterior)  # M^T u, row by row
    if np.any(ray[..., 2] >= 0):
        raise ValueError("exterior must look down: a ray does not meet the ground")
    t = (relief.mean - exterior[2]) / ray[..., 2]
    for _ in range(MAX_ITERATIONS):
        X = exterior[:3] + t[..., None] * ray
        above = X[..., 2] - grey_values(relief, X[..., :2] / cell)
        if np.all(np.abs(above) <= PRECISE * np.abs(t * ray[..., 2])):
            return X
        slope = grey_gradients(relief, X[..., :2] / cell) / cell
        t = t - above / (ray[..., 2] - np.sum(slope * ray[..., :2], axis=-1))
    raise ValueError("a ray does not meet the relief, or touches it: it is too steep")


def relief_photo(
    lens: Camera,
    exterior: ArrayLike,
    relief: Texture,
    texture: Texture,
    image_size: ArrayLike,
    pixel_size: ArrayLike,
    *,
    cell: float = 1.0,
    sigma: float = 0.0,
    seed: int = 0,
) -> np.ndarray:
    """Photo (rows, columns) of a relief that carries a texture, not rounded.

    A pixel shows the texture at its centre; `cell` should not be smaller than a pixel
    on the ground.

    Parameters
    ----------
    lens, exterior, relief, cell
        As in `on_relief`.
    texture : Texture
        Grey values of the ground at (X, Y) / cell.
    image_size : (columns, rows)
        In pixels.
    pixel_size : float or (x, y)
        In mm.
    sigma : float
        Standard deviation of the white noise, in grey values.
    seed : int
        Of the noise.

    Raises
    ------
    ValueError
        As `on_relief`.

    Examples
    --------
    >>> from pgm_lab.simulate import texture
    >>> hills = texture(cutoff=0.01, contrast=3.0, mean=10.0, waves=20)
    >>> photo = (5, 5, 100, 0.02, -0.01, 0.3)
    >>> relief_photo(Camera(5.0), photo, hills, texture(), (40, 30), 0.05).shape
    (30, 40)
    """
    columns, rows = np.asarray(image_size)
    pixels = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
    photo = frames.pixel_to_photo(pixels, image_size, pixel_size)
    ground = on_relief(lens, exterior, photo, relief, cell)
    return photograph(grey_values(texture, ground[..., :2] / cell), sigma, seed)
