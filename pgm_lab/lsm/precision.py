"""How precise least squares matching can be."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import normal
from pgm_lab.lsm._normal_equations import window_grid


def cramer_rao(
    grey: ArrayLike,
    gradients: ArrayLike,
    sigma: float,
    *,
    gain: float = 1.0,
    shape: ArrayLike | None = None,
    radiometric: bool = True,
) -> np.ndarray:
    """Smallest covariance that an unbiased match of a window can have.

    White normal noise of `sigma` in both images; the right one has `gain` times the
    contrast. Unknown are the parameters of (B 2.10) and the grey value that each pixel
    would have without noise; therefore the noise of a difference counts, sigma^2
    (1 + 1/gain^2) in grey values of the left image.

    Parameters
    ----------
    grey : array_like (..., w, w)
        Grey values of the left window without noise, w odd.
    gradients : array_like (..., w, w, 2)
        Their derivatives by x and y, in grey values per pixel.
    sigma : float
        Standard deviation of the noise of one image, in grey values.
    gain : float
        Contrast of the right image relative to the left.
    shape : array_like (..., 2, 2), optional
        ((a1, a2), (b1, b2)); default: the identity.
    radiometric : bool
        False if h0 and h1 are known.

    Returns
    -------
    ndarray (..., 2, 2)
        Covariance of the centre point, in the right image, in square pixels;
        infinite where the texture does not determine it.

    Raises
    ------
    ValueError
        If shapes do not fit, or `sigma` or `gain` are not positive.

    References
    ----------
    Foerstner 1982, for shifts; here with the normal matrix of (B 2.11) and the true
    gradients.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=3)
    >>> y, x = np.mgrid[-10:11, -10:11]
    >>> window = np.stack([x, y], axis=-1) + 50.0
    >>> grey = simulate.grey_values(texture, window)
    >>> bound = cramer_rao(grey, simulate.grey_gradients(texture, window), sigma=1.0)
    >>> np.sqrt(np.diag(bound)).round(4)
    array([0.0037, 0.0026])
    """
    grey = _validate.finite(grey, "grey")
    gradients = _validate.points(gradients, 2, "gradients")
    if grey.ndim < 2 or grey.shape[-1] != grey.shape[-2] or grey.shape[-1] % 2 == 0:
        raise ValueError(f"grey must be (..., w, w) with w odd; got {grey.shape}")
    if gradients.shape[:-1] != grey.shape:
        raise ValueError(
            f"gradients must be {(*grey.shape, 2)}, as grey; got {gradients.shape}"
        )
    radiometric = _validate.flag(radiometric, "radiometric")
    sigma = _validate.positive_number(sigma, "sigma", "grey values")
    gain = _validate.positive_number(gain, "gain", "right over left")
    affine = np.eye(2) if shape is None else _validate.finite(shape, "shape")
    if affine.shape[-2:] != (2, 2):
        raise ValueError(f"shape must be (..., 2, 2); got {affine.shape}")
    grid = window_grid(grey.shape[-1] // 2)
    k = grid.shape[1]
    g = gradients.reshape(*grey.shape[:-2], k, 2)
    columns = [g[..., axis] * row for axis in (0, 1) for row in grid]
    if radiometric:
        # Subtract the mean: it is h0, and would only hide the texture
        flat = grey.reshape(g.shape[:-1])
        columns += [np.ones_like(flat), flat - flat.mean(axis=-1, keepdims=True)]
    A = np.stack(columns, axis=-1)
    N = np.swapaxes(A, -1, -2) @ A
    _, Q, _, singular = normal.solve(N, np.zeros(N.shape[:-1]))
    middle = Q[..., [[0], [3]], [[0, 3]]]
    bound = (
        sigma**2 * (1 + 1 / gain**2) * (affine @ middle @ np.swapaxes(affine, -1, -2))
    )
    bound[singular] = np.inf
    return bound
