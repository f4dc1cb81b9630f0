"""How many independent pixels the grey values of a window are worth.

White noise is as large everywhere and independent from pixel to pixel. What is left
between two photos is neither: neighbours are alike where colours were interpolated or
an image was compressed, blurred or resampled; and residuals are larger where the
texture is strong, if the windows are not quite related by (B 2.7) to (B 2.9).

For residuals with the covariance matrix C the covariance of the parameters is
``N^-1 (G^T C G) N^-1``. The functions here find by how much it is larger for the
position than with white noise. Nothing is checked: that is done in `matching`.
"""

import numpy as np

# Distances (x, y) in pixels at which residuals are compared, with their opposites
LAGS = (1, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2)
REACH = 2
POSITION = [0, 3]  # rows of a0 and b0 in the design matrix
LARGEST = 2.0  # effective pixels over pixels: noise that the texture is blind for


def effective_pixels(
    design: np.ndarray, Q: np.ndarray, v: np.ndarray, gain: np.ndarray
) -> np.ndarray:
    """Independent pixels (m,) that would determine the position as well.

    From the design (m, u, k), the inverse Q (m, u, u) of its normal matrix, and the
    residuals v (m, k), row by row of square windows; white noise, when it is
    interpolated, keeps the share `gain` (m,) of its variance in v.

    White noise also shows some correlation, by chance. A factor that differs from one
    by no more than its standard deviation is halved, and a large one is believed.
    """
    _, u, k = design.shape
    # In single precision, for speed: sums of squares near one need no more
    vv = np.einsum("mk,mk->m", v, v)
    v = v * np.sqrt((k - u) / np.where(vv > 0, vv, 1))[:, None]
    design, v = _spaced(design, k), _spaced(v[:, None], k)
    influence = Q.astype(np.float32) @ design
    alike, chance = _neighbours(design, influence, v, k)
    larger, chance_larger = _where_texture_is_strong(design, influence, v)
    excess = alike * larger * gain - 1
    factor = 1 + excess**3 / (excess**2 + chance + chance_larger)
    return np.where(vv > 0, k / np.clip(factor, 1 / LARGEST, k / u), k)


def _neighbours(
    design: np.ndarray, influence: np.ndarray, v: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Variance (m,) of position if neighbours are alike, over that if they are not.

    With c(d), the covariance of two residuals that lie d apart, the variance of a
    parameter is the sum of c(d) times the products of its influence function with
    itself, moved by d.

    The adjustment has taken u dimensions from the residuals, those that the texture
    occupies: with the projector H = Q G^T G on them, E(v v^T) = (I - H) C (I - H). Let
    s be the mean variance there, and h(d) the sum of all elements of H for pixels d
    apart. Then the products of n(d) pairs of residuals add up to n(d) c(d) - s h(d),
    and s is the mean of c(d) with the weights h(d): both follow from each other.

    Also returns the variance of the result with white noise, where c(d) scatters by
    c(0)^2 / n(d) (Bartlett 1946).
    """
    position, width, u = influence[:, POSITION], round(k**0.5), design.shape[1]
    vv, h, g, n = np.empty((4, 1 + len(LAGS), len(v)))
    for i, (x, y) in enumerate(((0, 0), *LAGS)):
        shift = y * (width + REACH) + x
        vv[i] = _product(v, v, shift)
        h[i] = _product(influence, design, shift)
        g[i] = _product(position, position, shift)
        n[i] = (width - abs(x)) * (width - y)
    for products in (vv, h, g, n):
        products[1:] *= 2  # -x, -y
    s = (vv * h / n).sum(axis=0) / (u - (h * h / n).sum(axis=0))
    c = (vv + s * h) / n
    g /= g[0]
    return (c * g).sum(axis=0), (2 * g[1:] ** 2 / n[1:]).sum(axis=0)


def _where_texture_is_strong(
    design: np.ndarray, influence: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Variance (m,) of position by each pixel's residual, over that by their mean.

    The squares of the residuals, with the squared influence of their pixels for
    weights, over what white noise would leave of them, 1 - H (White 1980). Also its
    variance with white noise.
    """
    weight = (influence[:, POSITION] ** 2).sum(axis=1)
    left = 1 - np.einsum("mik,mik->mk", influence, design)
    found = np.einsum("mk,mk->m", weight, v[:, 0] ** 2)
    expected = np.einsum("mk,mk->m", weight, left)
    chance = 2 * (weight**2).sum(axis=1) / weight.sum(axis=1) ** 2
    return found / expected, chance


def _spaced(rows: np.ndarray, k: int) -> np.ndarray:
    """Windows (..., k) with zeros after each row: no shift leads into another row."""
    width = round(k**0.5)
    spaced = np.zeros((*rows.shape[:-1], width, width + REACH), np.float32)
    spaced[..., :width] = rows.reshape(*rows.shape[:-1], width, width)
    return spaced.reshape(*rows.shape[:-1], -1)


def _product(a: np.ndarray, b: np.ndarray, shift: int) -> np.ndarray:
    """Sums (m,) of a (m, i, k) times b, moved by `shift` pixels."""
    return np.vecdot(a[..., : a.shape[-1] - shift], b[..., shift:]).sum(axis=1)
