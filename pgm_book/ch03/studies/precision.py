"""How precise least squares matching is, and what its covariance says of that.

``python -m pgm_book.ch03.studies.precision`` writes results/precision.csv in
minutes; tests/ch03/test_studies.py repeats a part.

Windows of 21 x 21, an affine transformation of 1 to 2 per cent, start values rounded to
whole pixels. The bound is the one of Cramer and Rao for the parameters that are
estimated; grey values rounded to 8 bit have 1/12 more variance, and windows with grey
values that 8 bits cannot hold are left out of these rows.
"""

from collections.abc import Iterator

import numpy as np

from pgm_book.ch03.studies import scene as lsm_scene
from pgm_book.common import study
from pgm_lab import lsm

WINDOW = 21
SEEDS = 3  # textures; each has some 1100 points
SEEDS_8_BIT = 9  # at high contrast, where most windows are left out
TEXTURES = {"soft": lsm_scene.SOFT, "sharp": lsm_scene.SHARP}
# Grey values of the right image over the left, and whether h0 and h1 are estimated
RADIOMETRY = {
    ("same", "estimated"): (1.0, 0.0, True),
    ("same", "left out"): (1.0, 0.0, False),
    ("1.08 and 4", "estimated"): (1.08, 4.0, True),
    ("1.08 and 4", "left out"): (1.08, 4.0, False),
}
# Contrast, noise; 10 and 2 is a shadow or a meadow, 40 a town
CASES = [(40.0, 0.0), (40.0, 1.0), (40.0, 2.0), (40.0, 5.0), (10.0, 2.0)]
KEYS = ("texture", "contrast", "sigma", "grey", "gain_offset", "h0_h1")
COLUMNS = (
    *KEYS,
    *("points", "converged", "rms_px", "rms_over_bound"),
    *("predicted_over_sampled_sd", "largest_z", "sigma0_over_expected"),
    "trouble",
)


def rows(
    kind: str, contrast: float, few: int = SEEDS, many: int = SEEDS_8_BIT
) -> Iterator[tuple]:
    """Rows of the table for one texture and contrast."""
    scenes = [
        lsm_scene.scene(TEXTURES[kind], seed, contrast=contrast)
        for seed in range(many if contrast > 20 else few)
    ]
    for (change, how), (gain, offset, estimated) in RADIOMETRY.items():
        unsaturated = [held(s, gain, offset) for s in scenes]
        everywhere = [np.ones(len(s.points), bool) for s in scenes]
        bounds = [s.bound(WINDOW, gain=gain, radiometric=estimated) for s in scenes]
        for sigma in [s for c, s in CASES if c == contrast]:
            for grey, dtype in (("float", None), ("8 bit", np.uint8)):
                parts, use = [], unsaturated if dtype else everywhere[:few]
                for seed, kept in enumerate(use):
                    s, bound = scenes[seed], bounds[seed]
                    left, right = s.images(
                        sigma, gain=gain, offset=offset, dtype=dtype, seed=seed
                    )
                    found = lsm.match(
                        left,
                        right,
                        s.points[kept],
                        s.start[kept],
                        WINDOW,
                        radiometric=estimated,
                    )
                    parts.append((found, found.points - s.truth[kept], bound[kept]))
                variance = sigma**2 + (1 / 12 if dtype else 0)
                measured = summary(parts, variance, gain)
                yield (kind, contrast, sigma, grey, change, how, *measured)


def held(scene: lsm_scene.Scene, gain: float, offset: float) -> np.ndarray:
    """Points whose windows keep within 0 and 255 in both images, but for noise."""
    left, _ = scene.images(0.0)
    seen = lsm_scene.windows(left, scene.points, WINDOW + 4)
    low, high = seen.min(axis=(1, 2)), seen.max(axis=(1, 2))
    return (np.minimum(low, gain * low + offset) > 0) & (
        np.maximum(high, gain * high + offset) < 255
    )


def summary(parts: list[tuple], variance: float, gain: float) -> tuple:
    """Numbers of a row, from results, errors and bounds for a noise of one."""
    status = np.concatenate([found.status for found, *_ in parts])
    good = status == "accepted"
    names, counts = np.unique(status[~good], return_counts=True)
    trouble = names[counts.argmax()] if len(names) else ""
    counted = len(good), f"{good.mean():.4f}"
    if not np.any(good):
        return *counted, *[""] * 5, trouble
    error = np.concatenate([error for _, error, _ in parts])[good]
    bound = np.concatenate([bound for *_, bound in parts])[good]
    covariance = np.concatenate([found.covariance for found, *_ in parts])[good]
    sigma0 = np.concatenate([found.sigma0 for found, *_ in parts])[good]
    z2 = lsm_scene.squared(error, covariance)
    over = expected = ""  # without noise the bound is zero
    if variance > 0:
        over = np.mean(lsm_scene.squared(error, bound)) / variance
        expected = np.mean(sigma0**2) / (variance * (1 + gain**-2))
        over, expected = f"{np.sqrt(over):.3f}", f"{np.sqrt(expected):.3f}"
    return (
        *(*counted, f"{np.sqrt(np.mean(error**2)):.3g}", over),
        *(f"{1 / np.sqrt(np.mean(z2)):.3f}", f"{np.sqrt(z2.max()):.1f}"),
        *(expected, trouble),
    )


if __name__ == "__main__":
    contrasts = sorted({contrast for contrast, _ in CASES}, reverse=True)
    table = (row for kind in TEXTURES for one in contrasts for row in rows(kind, one))
    study.write("ch03", "precision", COLUMNS, table)
