"""What interpolation alone does to a match: shift and grey values against the truth.

An image of a known texture is resampled at a part of a pixel to the right. One step of
least squares with the exact gradients tells at which shift the texture itself would
look like that: once with the shift as the only unknown, once with the six affine and
two radiometric parameters of least squares matching. The difference is the bias.

A match that resamples the right image errs in the opposite direction. Converged
matches of eight parameters show by how much: once with the slopes of the resampled
right window (B 2.12), as in the program of chapter 3, and once with those of the left
window, as in `lsm.match`. On soft texture they err by as much as in the one step. On
sharp texture they do not, because both the slopes and the contrast of the resampled
window count. Positions beyond half a pixel mirror the others, and are left empty there.

``python -m pgm_book.ch03.studies.interpolation_bias`` writes
results/interpolation_bias.csv in a few minutes; tests/ch03 repeats a part.
"""

from functools import partial

import numpy as np
from tqdm import tqdm

from pgm_book.common import study
from pgm_lab import image, simulate
from pgm_lab.adjustment import adjust
from pgm_lab.image.resampling import cubic_weights, weighted_sum
from pgm_lab.lsm import half_pixels

CUTOFFS = {"soft": 0.2, "sharp": 0.4}  # cycles per pixel
METHODS = ("nearest", "bilinear", "cubic", "spline3", "spline5")
OPENCV, LSM = "OpenCV cubic", "lsm"
ALL = (*METHODS, OPENCV, LSM)
POSITIONS = np.linspace(0, 1, 21)  # px
COLUMNS = (
    *("texture", "method", "position", "textures"),
    *("bias_px", "sd_px", "bias_8_px", "sd_8_px", "rms_grey"),
    *("right_slopes_px", "right_slopes_sd_px", "right_slopes_converged"),
    *("left_slopes_px", "left_slopes_sd_px", "left_slopes_converged"),
)
# The window at the centre of a larger image, beyond the reach of its border
WINDOW, MARGIN = 21, 40


def opencv_cubic(grey: np.ndarray, points: np.ndarray) -> np.ndarray:
    """cv2.INTER_CUBIC: cubic convolution with a = -0.75, but at exact coordinates."""
    x, y = np.moveaxis(points, -1, 0)
    return weighted_sum(grey, x, y, lambda x: cubic_weights(x, a=-0.75))


def lsm(grey: np.ndarray, points: np.ndarray) -> np.ndarray:
    """What pgm_lab.lsm does: a cubic spline on a grid of half pixels."""
    return half_pixels.sample(half_pixels.coefficients(grey), *points.T)


def errors(cutoff: float, seed: int, positions: np.ndarray) -> np.ndarray:
    """Errors of all methods in one texture, shape (positions, methods, 3).

    The last axis holds the error of the shift, the same with eight parameters, and the
    root mean square error of the grey values of the window.
    """
    texture = simulate.texture(cutoff, seed=seed)
    n = WINDOW + 2 * MARGIN
    grey, _ = simulate.texture_pair(texture, (n, n), (0, 1, 0, 0, 0, 1))
    y, x = np.mgrid[MARGIN : MARGIN + WINDOW, MARGIN : MARGIN + WINDOW].reshape(2, -1)
    dx, dy = x - n // 2, y - n // 2
    found = []
    for position in positions:
        points = np.stack([x + position, y], axis=-1)
        truth = simulate.grey_values(texture, points)
        gx, gy = simulate.grey_gradients(texture, points).T
        shift = np.stack([gx, gy], axis=-1)
        eight = np.stack(
            [gx, gx * dx, gx * dy, gy, gy * dx, gy * dy, np.ones_like(gx), truth],
            axis=-1,
        )
        values = [resampled(grey, points, method) for method in ALL]
        difference = np.array(values) - truth
        found.append(
            [
                (np.linalg.pinv(shift) @ difference.T)[0],
                (np.linalg.pinv(eight) @ difference.T)[0],
                np.sqrt(np.mean(difference**2, axis=1)),
            ]
        )
    return np.moveaxis(found, 1, -1)


def resampled(grey: np.ndarray, points: np.ndarray, method: str) -> np.ndarray:
    """Grey values of an image at points (..., 2) by one of the methods."""
    if method not in (OPENCV, LSM):
        return image.resample(grey, points, method)
    own = opencv_cubic if method == OPENCV else lsm
    return own(grey, points.reshape(-1, 2)).reshape(points.shape[:-1])


def matches(
    cutoff: float, seed: int, positions: np.ndarray, method: str, left_slopes: bool
) -> np.ndarray:
    """Errors along x (positions,) in px of converged eight-parameter matches.

    The right image holds the texture at its pixels, the left window at the positions
    beside them, both without any error. NaN where the iteration does not converge.
    """
    texture = simulate.texture(cutoff, seed=seed)
    n = WINDOW + 2 * MARGIN
    right, _ = simulate.texture_pair(texture, (n, n), (0, 1, 0, 0, 0, 1))
    half, middle = WINDOW // 2, n // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1).astype(float)
    at = np.stack(
        [x + middle + positions[:, None], np.tile(y + middle, (len(positions), 1))], -1
    )
    left = simulate.grey_values(texture, at)
    slopes = np.moveaxis(simulate.grey_gradients(texture, at), -1, 1)
    sample = partial(resampled, method=method)

    def grey_values(p, slopes):
        """Computed grey values (B 2.10) and their derivatives (B 2.11)."""
        a0, a1, a2, b0, b1, b2, h0, h1 = (p[:, [i]] for i in range(8))
        at = np.stack([a0 + a1 * x + a2 * y, b0 + b1 * x + b2 * y], axis=-1)
        B = sample(right, at)
        if left_slopes:
            gx, gy = slopes[:, 0], slopes[:, 1]
        else:  # (B 2.12), (B 2.13)
            gx = h1 * (sample(right, at + (1, 0)) - sample(right, at - (1, 0))) / 2
            gy = h1 * (sample(right, at + (0, 1)) - sample(right, at - (0, 1))) / 2
        columns = gx, x * gx, y * gx, gy, x * gy, y * gy, np.ones_like(B), B
        return h0 + h1 * B, np.stack(columns, axis=-1)

    start = np.tile([middle, 1, 0, middle, 0, 1, 0, 1.0], (len(positions), 1))
    start[:, 0] += positions
    # The slopes are not the derivatives of what is computed: no line search
    found = adjust(
        grey_values, start, left, args=(slopes,), line_search=False, tolerance=0.01
    )
    error = found.x[:, 0] - start[:, 0]
    return np.where(found.status == "converged", error, np.nan)


def match_columns(
    kind: str, method: str, textures: int, positions: np.ndarray
) -> list[tuple]:
    """Mean, standard deviation and number of converged matches, for both slopes."""
    if method == "nearest":  # its grey values jump: nothing converges
        return [6 * ("",)] * len(positions)
    near = positions <= 0.5  # the others mirror them
    found = []
    for left_slopes in (False, True):
        errors = [
            matches(CUTOFFS[kind], seed, positions[near], method, left_slopes)
            for seed in tqdm(range(textures), f"{kind}, {method}", leave=False)
        ]
        few = iter(np.transpose(errors))
        found.append([_summary(next(few)) if one else 3 * ("",) for one in near])
    return [(*right, *left) for right, left in zip(*found, strict=True)]


def _summary(error: np.ndarray) -> tuple[str, str, int]:
    """Mean, standard deviation, number; no mean of less than half of the textures."""
    good = error[np.isfinite(error)]
    if len(good) < max(2, len(error) / 2):
        return "", "", len(good)
    return f"{good.mean():.6f}", f"{good.std(ddof=1):.6f}", len(good)


def rows(kind: str, textures: int, positions: np.ndarray = POSITIONS) -> list[tuple]:
    """Rows of the table for one kind of texture."""
    all_errors = np.array(
        [
            errors(CUTOFFS[kind], seed, positions)
            for seed in tqdm(range(textures), kind, leave=False)
        ]
    )
    bias, sd = all_errors.mean(axis=0), all_errors.std(axis=0, ddof=1)
    rms = np.sqrt(np.mean(all_errors**2, axis=0))
    matched = [match_columns(kind, method, textures, positions) for method in ALL]
    return [
        (
            *(kind, method, f"{position:.2f}", textures),
            *(f"{bias[p, m, 0]:.6f}", f"{sd[p, m, 0]:.6f}"),
            *(f"{bias[p, m, 1]:.6f}", f"{sd[p, m, 1]:.6f}"),
            f"{rms[p, m, 2]:.4f}",
            *matched[m][p],
        )
        for m, method in enumerate(ALL)
        for p, position in enumerate(positions)
    ]


if __name__ == "__main__":
    table = [row for kind in CUTOFFS for row in rows(kind, 40)]
    study.write("ch03", "interpolation_bias", COLUMNS, table)
