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
Lags = tuple[tuple[int, int], ...]
LAGS: Lags = (1, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2)
DECAY = 3  # standard deviations of a Gaussian, up to which what it smoothed is alike
POSITION = [0, 3]  # rows of a0 and b0 in the design matrix
LARGEST = 2.0  # effective pixels over pixels: noise that the texture is blind for


def effective_pixels(
    design: np.ndarray,
    Q: np.ndarray,
    v: np.ndarray,
    gain: np.ndarray,
    smooth: float = 0.0,
) -> np.ndarray:
    """Independent pixels (m,) that would determine the position as well.

    From the design (m, u, k), the inverse Q (m, u, u) of its normal matrix, and the
    residuals v (m, k), row by row of square windows; white noise, when it is
    interpolated, keeps the share `gain` (m,) of its variance in v. If the images were
    smoothed before, by `smooth` px, residuals farther apart are alike, too.

    White noise also shows some correlation, by chance. A factor that differs from one
    by no more than its standard deviation is halved, and a large one is believed.
    """
    _, u, k = design.shape
    # In single precision, for speed: sums of squares near one need no more
    vv = np.einsum("mk,mk->m", v, v)
    v = v * np.sqrt((k - u) / np.where(vv > 0, vv, 1))[:, None]
    lags = _lags(smooth, round(k**0.5))
    design, v = _spaced(design, k, lags), _spaced(v[:, None], k, lags)
    influence = Q.astype(np.float32) @ design
    position = influence[:, POSITION]
    c, s = _covariances(design, influence, v, k, lags)
    g, n = _sums(position, position, k, lags)
    alike = (c * g).sum(axis=0) / g[0]
    weight = (position**2).sum(axis=1)
    larger = _where_texture_is_strong(design, influence, v, weight, c[0], s)
    # With white noise c(d) scatters by c(0)^2 / n(d) (Bartlett 1946), v^2 by 2
    chance = (2 * g[1:] ** 2 / n[1:]).sum(axis=0) / g[0] ** 2
    chance += 2 * (weight**2).sum(axis=1) / weight.sum(axis=1) ** 2
    excess = alike * larger * gain - 1
    factor = 1 + excess**3 / (excess**2 + chance)
    return np.where(vv > 0, k / np.clip(factor, 1 / LARGEST, k / u), k)


def _lags(smooth: float, width: int) -> Lags:
    """Distances at which residuals of smoothed images are compared, in such windows."""
    if not smooth:
        return LAGS
    most = min(DECAY * smooth, width // 2)
    whole = range(-int(most), int(most) + 1)
    half = ((x, y) for x in whole for y in whole if (y, x) > (0, 0))
    return tuple((x, y) for x, y in half if x * x + y * y <= most**2)


def _reach(lags: Lags) -> int:
    return max(max(abs(x), y) for x, y in lags)


def _covariances(
    design: np.ndarray, influence: np.ndarray, v: np.ndarray, k: int, lags: Lags
) -> tuple[np.ndarray, np.ndarray]:
    """Covariances c (lags, m) of two residuals, the first their variance, and s (m,).

    The adjustment has taken u dimensions from the residuals, those that the texture
    occupies: with the projector H = G Q G^T on them, E(v v^T) = (I - H) C (I - H). Let
    s be the mean variance there, and h(d) the sum of all elements of H for pixels d
    apart. Then the products of n(d) pairs of residuals add up to n(d) c(d) - s h(d),
    and s is the mean of c(d) with the weights h(d): both follow from each other.
    """
    u = design.shape[1]
    vv, n = _sums(v, v, k, lags)
    h, _ = _sums(influence, design, k, lags)
    s = (vv * h / n).sum(axis=0) / (u - (h * h / n).sum(axis=0))
    return (vv + s * h) / n, s


def _where_texture_is_strong(
    design: np.ndarray,
    influence: np.ndarray,
    v: np.ndarray,
    weight: np.ndarray,
    variance: np.ndarray,
    s: np.ndarray,
) -> np.ndarray:
    """Variance (m,) of position by each pixel's residual, over that by their mean.

    The squares of the residuals, with the squared influence of their pixels for
    weights (White 1980), over what the adjustment leaves of their variance; of a pixel
    that is taken whole, nothing can be said.
    """
    H = np.einsum("mik,mik->mk", influence, design)
    left = variance[:, None] - s[:, None] * H
    left = np.maximum(left, variance[:, None] / 2)
    found = np.einsum("mk,mk->m", weight, v[:, 0] ** 2)
    return found / np.einsum("mk,mk->m", weight, left)


def _sums(
    a: np.ndarray, b: np.ndarray, k: int, lags: Lags = LAGS
) -> tuple[np.ndarray, np.ndarray]:
    """Sums (lags, m) of a (m, i, k) times b moved by each lag and by its opposite.

    First those without a move. Also the numbers (lags, 1) of pairs of pixels.
    """
    width = round(k**0.5)
    sums, n = [np.vecdot(a, b).sum(axis=1)], [k]
    for x, y in lags:
        shift = y * (width + _reach(lags)) + x
        pairs = np.vecdot(a[..., : a.shape[-1] - shift], b[..., shift:])
        sums.append(2 * pairs.sum(axis=1))
        n.append(2 * (width - abs(x)) * (width - y))
    return np.array(sums), np.array(n, float)[:, None]


def _spaced(rows: np.ndarray, k: int, lags: Lags = LAGS) -> np.ndarray:
    """Windows (..., k) with zeros after each row: no shift leads into another row."""
    width = round(k**0.5)
    spaced = np.zeros((*rows.shape[:-1], width, width + _reach(lags)), np.float32)
    spaced[..., :width] = rows.reshape(*rows.shape[:-1], width, width)
    return spaced.reshape(*rows.shape[:-1], -1)
