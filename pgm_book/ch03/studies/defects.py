"""What each defect of a least squares matching costs, over 300 points a row.

``python -m pgm_book.ch03.studies.defects`` writes results/defects.csv in some minutes;
tests/ch03/test_defects.py repeats a part.
"""

import numpy as np
from tqdm import tqdm

from pgm_book.ch03 import defects
from pgm_book.ch03.studies.scene import cramer_rao
from pgm_book.common import study
from pgm_lab import simulate

COLUMNS = (
    *("scene", "contrast", "sigma", "defect", "points", "converged", "matched"),
    *("rms_px", "bound_px", "ratio", "iterations", "condition"),
    *("sigma0", "true_sigma0"),
)
SHAPE, HALF, GAIN, OFFSET = (1300, 640), 10, 1.08, 4.0
# Where the log of Bani 2010 has its match, some 1083 px from the corner of the image
CENTRE, SHIFT = np.array([268.0, 1049.0]), (2.4, -1.7)
MILD = np.array([[1.015, -0.02], [0.018, 0.985]])
# One plus the increments that the log prints
AS_IN_THE_LOG = np.array([[1.011, -0.127], [-0.028, 0.961]])
SCENES = {
    "good contrast": (40.0, 1.0, MILD),
    "more noise": (40.0, 2.0, MILD),
    "poor contrast": (10.0, 1.0, MILD),
    "shear as in the log": (40.0, 2.0, AS_IN_THE_LOG),
    "all as in the log": (9.0, 4.5, AS_IN_THE_LOG),
}
VARIANTS = {
    "none": (),
    **{name: (name,) for name in defects.DEFECTS},
    "all of the program": defects.PROGRAM,
}


def scene(name: str, points: int = 300):
    """Images, points (left, right), the least RMS error (n,) in px, the true sigma0."""
    contrast, sigma, J = SCENES[name]
    texture = simulate.texture(0.2, contrast=contrast, seed=3)
    t = CENTRE + SHIFT - J @ CENTRE
    images = simulate.texture_pair(
        *(texture, SHAPE, (t[0], *J[0], t[1], *J[1])),
        **{"gain": GAIN, "offset": OFFSET, "sigma": sigma, "seed": 5},
    )
    # 20 columns and 15 rows, apart by more than a window
    row, column = np.divmod(np.arange(points), 20)
    left = CENTRE + np.column_stack([23 * column - 208, 23 * row - 160])
    pixels = np.moveaxis(np.mgrid[-HALF : HALF + 1, -HALF : HALF + 1][::-1], 0, -1)
    windows = left[:, None, None] + pixels
    covariance = cramer_rao(
        simulate.grey_values(texture, windows),
        simulate.grey_gradients(texture, windows),
        **{"sigma": sigma, "gain": GAIN, "shape": J},
    )
    bound = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 2)
    return images, left, left @ J.T + t, bound, sigma * np.hypot(1, 1 / GAIN)


def rows(name: str, variants=tuple(VARIANTS), points: int = 300) -> list[tuple]:
    """Rows of the table for one scene."""
    images, left, right, bound, true_sigma0 = scene(name, points)
    contrast, sigma, _ = SCENES[name]
    table = []
    for variant in tqdm(variants, name, leave=False):
        # Correlation leaves the nearest whole pixel
        found = defects.match(*images, left, np.round(right), VARIANTS[variant])
        converged = found.status == "converged"
        error = found.points - right
        known = np.isfinite(error[:, 0])
        square = error[known] ** 2
        numbers = [""] * 7
        if known.any():
            numbers = [
                f"{np.sqrt(square.mean()):.4f}",
                f"{np.sqrt((bound**2).mean()):.4f}",
                f"{np.sqrt((square / bound[known, None] ** 2).mean()):.2f}",
                f"{found.iterations.mean():.1f}",
                f"{np.median(found.condition):.0e}",
                f"{np.median(found.sigma0[known]):.3g}",
                f"{true_sigma0:.3g}",
            ]
        counts = points, converged.sum(), known.sum()
        table.append((name, contrast, sigma, variant, *counts, *numbers))
    return table


if __name__ == "__main__":
    table = [row for name in SCENES for row in rows(name)]
    study.write("ch03", "defects", COLUMNS, table)
