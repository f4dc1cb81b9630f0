"""Sizes of template and search window against success, precision and time.

Bani 2010 asks for it in V.2; here on three pairs of images with known truth.
``python -m pgm_book.ch02.studies.windows`` writes results/windows.csv in about four
minutes; tests/ch02/test_studies.py repeats a part.

The start is the truth plus a random offset of up to the reach less two pixels in each
axis (the epipolar lines of the stereo pair are not used). success: share of the points
within 1 px of the truth, whatever their status; matched: share with that status; wrong:
share of the matched that are more than 1 px off; rms_px: of the parabola's result in
each axis, over the matched that are right; predicted_px: the same from the covariances.
time: per point, over that of a template of 21 and a reach of 15 pixels; the shortest of
several rounds through all sizes, so that neither a cold start nor another program that
runs for a while falls upon one size alone.
"""

import itertools
import time

import numpy as np
from tqdm import tqdm

from pgm_book.common import study
from pgm_lab import datasets, ncc, simulate

TEMPLATES = (5, 9, 15, 21, 31, 41)
REACHES = (5, 10, 15, 25, 40)
POINTS = 1000
ROUNDS = 9
COLUMNS = (
    *("scene", "template", "reach_px", "search", "points"),
    *("success", "matched", "wrong", "rms_px", "predicted_px", "time"),
)
# Far enough from the edges for the largest search window and the largest offset
MARGIN = 41 // 2 + 2 * REACHES[-1] + 1


def stereo(n: int) -> tuple:
    """Middlebury's motorcycle: parallax, occlusions, repetition; disparities known."""
    pair = datasets.motorcycle()
    left, right, disparity = pair.left, pair.right, pair.disparity
    rng = np.random.default_rng(1)
    y = rng.integers(MARGIN, left.shape[0] - MARGIN, 20 * n)
    x = rng.integers(MARGIN, left.shape[1] - MARGIN, 20 * n)
    d = disparity[y, x]
    inside = np.isfinite(d) & (x - d >= MARGIN)
    x, y, d = (values[inside][:n] for values in (x, y, d))
    return (
        left,
        right,
        np.column_stack([x, y]).astype(float),
        np.column_stack([x - d, y]),
    )


def orthophoto(n: int) -> tuple:
    """An aerial photo of fields, shrunk, shifted by (2.5, -1.25) px, with noise."""
    pair = simulate.shrunk_pair(datasets.yellowstone().grey, (10, -5), 4)
    rng = np.random.default_rng(2)
    left, right = (g + rng.normal(0, 2, g.shape) for g in pair)
    points = inner(left.shape, n, rng)
    return left, right, points, points + (2.5, -1.25)


def texture(n: int) -> tuple:
    """Soft texture under a slope (5 per cent of scale, 3 of shear), gain and noise."""
    affine = np.array([3.4, 1.05, 0.03, -2.7, 0.0, 1.0])
    pair = simulate.texture_pair(
        *(simulate.texture(0.2, seed=2), (400, 400), affine),
        **{"gain": 1.08, "offset": 4, "sigma": 3, "dtype": np.uint8, "seed": 2},
    )
    points = inner((380, 360), n, np.random.default_rng(3))
    return *pair, points, points @ affine.reshape(2, 3)[:, 1:].T + affine[[0, 3]]


def inner(shape: tuple[int, int], n: int, rng: np.random.Generator) -> np.ndarray:
    """Points (n, 2) at random, far from the edges."""
    high = np.subtract(shape[::-1], MARGIN)
    return rng.integers(MARGIN, high, (n, 2)).astype(float)


SCENES = {"stereo pair": stereo, "orthophoto": orthophoto, "texture": texture}


def row(scene: tuple, template: int, reach: int) -> list[float]:
    """success, matched, wrong, rms, predicted, and seconds a point."""
    left, right, points, truth = scene
    rng = np.random.default_rng([template, reach])
    start = truth + rng.uniform(2 - reach, reach - 2, truth.shape)
    search = template + 2 * reach
    began = time.thread_time()
    found = ncc.match(left, right, points, start, template, search, refine="parabola")
    seconds = (time.thread_time() - began) / len(points)
    error = found.points - truth
    right_one = np.abs(error).max(axis=1) <= 1  # False where NaN
    matched = found.accepted
    good = matched & right_one
    return [
        np.mean(right_one),
        np.mean(matched),
        np.mean(~right_one[matched]) if matched.any() else np.nan,
        np.sqrt(np.mean(error[good] ** 2)),
        np.sqrt(np.trace(found.covariance[good], axis1=1, axis2=2).mean() / 2),
        seconds,
    ]


def main() -> None:
    """Write the table."""
    rows = []
    for name, make in SCENES.items():
        scene = make(POINTS)
        sizes = list(itertools.product(TEMPLATES, REACHES))
        row(scene, 21, 15)  # warm up
        found = {size: row(scene, *size) for size in tqdm(sizes, name)}
        for _ in range(ROUNDS - 1):
            for size in tqdm(sizes, f"{name}, time again"):
                found[size][-1] = min(found[size][-1], row(scene, *size)[-1])
        for (template, reach), (*shares, rms, predicted, seconds) in found.items():
            rows.append(
                [name, template, reach, template + 2 * reach, len(scene[2])]
                + [f"{share:.3f}" for share in shares]
                + [f"{rms:.4f}", f"{predicted:.4f}"]
                + [f"{seconds / found[21, 15][-1]:.2g}"]
            )
    study.write("ch02", "windows", COLUMNS, rows)


if __name__ == "__main__":
    main()
