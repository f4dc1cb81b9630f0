"""What interpolation alone does to a match: shift and grey values against the truth.

An image of a known texture is resampled at a part of a pixel to the right. One step of
least squares with the exact gradients tells at which shift the texture itself would
look like that: once with the shift as the only unknown, once with the six affine and
two radiometric parameters of least squares matching. The difference is the bias. A
match that resamples the right image errs by as much, with the other sign.

``python -m tools.studies.interpolation_bias`` writes
data/results/chapter3_interpolation_bias.csv in some seconds; tests/
test_interpolation_bias.py repeats a part of it.
"""

import csv
from pathlib import Path

import numpy as np
from tqdm import tqdm

from pgm_lab import image, simulate
from pgm_lab.image.resampling import _cubic, _weighted_sum
from pgm_lab.lsm import _fine

TABLE = (
    Path(__file__).parents[2] / "data" / "results" / "chapter3_interpolation_bias.csv"
)
CUTOFFS = {"soft": 0.2, "sharp": 0.4}  # cycles per pixel
METHODS = ("nearest", "bilinear", "cubic", "spline3", "spline5")
OPENCV, LSM = "OpenCV cubic", "lsm"
POSITIONS = np.linspace(0, 1, 21)  # px
COLUMNS = (
    *("texture", "method", "position", "textures"),
    *("bias_px", "sd_px", "bias_8_px", "sd_8_px", "rms_grey"),
)
# The window in the middle of a larger image, so that no spline feels the border
WINDOW, MARGIN = 21, 40


def opencv_cubic(grey: np.ndarray, points: np.ndarray) -> np.ndarray:
    """cv2.INTER_CUBIC: cubic convolution with a = -0.75, but at exact coordinates."""
    return _weighted_sum(grey, *points.T, lambda x: _cubic(x, a=-0.75))


def lsm(grey: np.ndarray, points: np.ndarray) -> np.ndarray:
    """What pgm_lab.lsm does: a cubic spline on a grid of half pixels."""
    return _fine.sample(_fine.coefficients(grey), *points.T)


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
        values = [image.resample(grey, points, method) for method in METHODS]
        values += [opencv_cubic(grey, points), lsm(grey, points)]
        difference = np.array(values) - truth
        found.append(
            [
                (np.linalg.pinv(shift) @ difference.T)[0],
                (np.linalg.pinv(eight) @ difference.T)[0],
                np.sqrt(np.mean(difference**2, axis=1)),
            ]
        )
    return np.moveaxis(found, 1, -1)


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
    return [
        (
            *(kind, method, f"{position:.2f}", textures),
            *(f"{bias[p, m, 0]:.6f}", f"{sd[p, m, 0]:.6f}"),
            *(f"{bias[p, m, 1]:.6f}", f"{sd[p, m, 1]:.6f}"),
            f"{rms[p, m, 2]:.4f}",
        )
        for m, method in enumerate((*METHODS, OPENCV, LSM))
        for p, position in enumerate(positions)
    ]


if __name__ == "__main__":
    table = [row for kind in CUTOFFS for row in rows(kind, 40)]
    TABLE.parent.mkdir(exist_ok=True)
    with TABLE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(table)
