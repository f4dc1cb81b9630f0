"""How well chips are found whose shift is known, beside other programs.

``python -m pgm_book.ch07.studies.accuracy`` writes
results/accuracy.csv and results/radius.csv within a few minutes;
tests/ch07/test_studies.py repeats a part.

Fifty chips of 21 x 21, radius 3, gain 0.9, noise 15: on strong corners (`picked`), or
anywhere (`random`). Errors are of what `register` accepts without refinement, the same
chips for all methods; what the method itself then refuses is left out of its errors and
counted in `given`. What is too imprecise depends on the median of all: of aliased
images that are not smoothed, chips with 0.1 px are accepted, even one that the alias
leads astray by 0.77 px (`largest`). The other programs get the chip and the equal
window at the whole pixel that ours found: `phase_cross_correlation` of scikit-image, to
a hundredth of a pixel, with its two normalizations, under a Hanning window, without
which they are two to three times worse; `phaseCorrelate` of OpenCV, under its Hanning
window; and its enhanced correlation coefficient with a shift as the motion, which gets
three pixels more on each side. The table is by OpenCV 5: that of 4 warps to 1/32 px,
and its ECC has errors up to twice as large.
"""

from collections.abc import Callable, Iterator

import cv2
import numpy as np
from skimage.registration import phase_cross_correlation

from pgm_book.ch07.studies import pairs
from pgm_book.common import study
from pgm_lab import registration, simulate

SHIFTS = {
    2: [(1, 0), (1, 1), (3, -1)],
    3: [(1, 0), (1, 1), (1, 2), (-4, 2)],
    4: [(1, 0), (1, 1), (2, 2), (1, 3), (-5, 6)],
}
SEEDS = 4
HALF = pairs.CHIP // 2
SURE = 0.05  # px, predicted standard deviation
COLUMNS = (
    *("blur", "factor", "chips", "method", "tried", "accepted", "given"),
    *("rmse_t", "mean_x_towards_whole", "mean_x", "mean_y", "largest", "rmse_t_sure"),
)
RADII = (
    *("shift_x", "shift_y", "true_distance", "radius", "accepted", "border"),
    *("rmse_t_all", "rmse_t_accepted"),
)
Windows = tuple[np.ndarray, np.ndarray]


def phases(normalization: str | None) -> Callable[[Windows], np.ndarray]:
    """scikit-image, with or without dividing by the amplitudes."""

    def find(windows: Windows) -> np.ndarray:
        chip, window = windows[0], windows[1][3:-3, 3:-3]
        soft = np.outer(np.hanning(pairs.CHIP), np.hanning(pairs.CHIP))
        one, other = ((w - w.mean()) * soft for w in (chip, window))
        (y, x), *_ = phase_cross_correlation(
            other, one, upsample_factor=100, normalization=normalization
        )
        return np.array([x, y])

    return find


def opencv(windows: Windows) -> np.ndarray:
    """cv2.phaseCorrelate with a Hanning window."""
    chip, window = windows
    hanning = cv2.createHanningWindow(chip.shape, cv2.CV_64F)
    return np.array(cv2.phaseCorrelate(chip, window[3:-3, 3:-3].copy(), hanning)[0])


def ecc(windows: Windows) -> np.ndarray:
    """cv2.findTransformECC with a shift."""
    chip, window = (w.astype(np.float32) for w in windows)
    end = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-8)
    T = np.array([[1, 0, 3], [0, 1, 3]], dtype=np.float32)
    try:
        _, T = cv2.findTransformECC(
            chip, window, T, cv2.MOTION_TRANSLATION, end, None, 1
        )
    except cv2.error:
        return np.full(2, np.nan)
    return T[:, 2] - 3.0


OTHERS: dict[str, Callable[[Windows], np.ndarray]] = {
    "scikit-image, phases": phases("phase"),
    "scikit-image, cross-correlation": phases(None),
    "OpenCV phaseCorrelate": opencv,
    "OpenCV ECC": ecc,
}
METHODS = ("integer", "parabola", "lsm", "lsm, not smoothed", *OTHERS)


def shifts(pair: simulate.OrthoPair, points: np.ndarray) -> dict[str, tuple]:
    """Shifts (n, 2) by each method, predicted sd, and which are accepted without."""
    images = pair.reference, pair.sensed
    whole = registration.register(*images, points)
    found = {"integer": (whole.shifts, whole.sd)}
    for name, how in (
        ("parabola", {"refine": "parabola"}),
        ("lsm", {"refine": "lsm"}),
        ("lsm, not smoothed", {"refine": "lsm", "smooth": 0.0}),
    ):
        fine = registration.register(*images, points, **how)
        shift = fine.shifts
        shift[~fine.accepted] = np.nan
        found[name] = shift, fine.sd
    start = found["integer"][0]
    for name, method in OTHERS.items():
        shift = np.full_like(start, np.nan)
        for i in np.flatnonzero(whole.accepted):
            chip = cut(pair.reference, points[i], HALF)
            window = cut(pair.sensed, points[i] + start[i], HALF + 3)
            shift[i] = start[i] + method((chip, window))
        found[name] = shift, np.full(len(points), np.nan)
    return {name: (*values, whole.accepted) for name, values in found.items()}


def cut(image: np.ndarray, point: np.ndarray, half: int) -> np.ndarray:
    """Window around a whole pixel."""
    c, r = point.astype(int)
    return image[r - half : r + half + 1, c - half : c + half + 1].astype(float)


def rows(
    blur: float, factor: int, seeds: int = SEEDS, kinds: tuple = ("picked", "random")
) -> Iterator[tuple]:
    """Rows of the table: all shifts and seeds of one sampling."""
    for kind in kinds:
        parts: dict[str, list] = {name: [] for name in METHODS}
        for shift in SHIFTS[factor]:
            for seed in range(seeds):
                pair = pairs.pair(shift, factor, blur, seed=seed)
                choose = pairs.picked if kind == "picked" else pairs.random
                more = {} if kind == "picked" else {"seed": seed}
                points = choose(pair.reference, **more)
                # Towards whole pixels is against the fraction
                fraction = pair.shift - np.rint(pair.shift)
                for name, (found, sd, ok) in shifts(pair, points).items():
                    side = np.tile(np.sign(fraction), (len(points), 1))
                    side[:, np.abs(fraction) == 0.5] = 0
                    parts[name].append((found - pair.shift, side, sd, ok))
        for name, several in parts.items():
            error, side, sd, ok = (np.concatenate(p) for p in zip(*several))
            yield blur, factor, kind, name, len(ok), *summary(error, side, sd, ok)


def summary(
    error: np.ndarray, side: np.ndarray, sd: np.ndarray, ok: np.ndarray
) -> tuple:
    """Numbers of a row."""
    given = ok & np.isfinite(error).all(axis=1)
    e = error[given]
    drawn = -(side[given] * e)[side[given] != 0]
    sure = given & (sd <= SURE)
    return (
        *(f"{ok.mean():.3f}", f"{given.sum() / ok.sum():.3f}", f"{rmse_t(e):.4f}"),
        *(f"{drawn.mean():.4f}" if len(drawn) else "",),
        *(f"{v:.4f}" for v in (*e.mean(axis=0), np.abs(e).max())),
        f"{rmse_t(error[sure]):.4f}" if sure.any() else "",
    )


def rmse_t(error: np.ndarray) -> float:
    """(Br 4)."""
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))


def radii() -> Iterator[tuple]:
    """Rows of the second table: what the method of the paper says of known shifts."""
    for shift in [(0, 0), (5, 0), (6, 4), (10, 7), (14, 0), (15, 5), (21, 0), (21, 14)]:
        pair = pairs.pair(shift, 5, pairs.ALIASED)
        points = pairs.picked(pair.reference)
        for radius in (3, 5):
            found = registration.register(
                pair.reference, pair.sensed, points, radius=radius
            )
            d = found.shifts
            good, border = found.accepted, np.abs(d).max(axis=1) == radius
            yield (
                *(*(f"{v:.1f}" for v in pair.shift), f"{np.hypot(*pair.shift):.3f}"),
                *(radius, f"{good.mean():.2f}", f"{border.mean():.2f}"),
                *(f"{rmse_t(d):.3f}", f"{rmse_t(d[good]):.3f}" if good.any() else ""),
            )


if __name__ == "__main__":
    study.write("ch07", "radius", RADII, radii())
    every = (
        row
        for blur in (pairs.BAND_LIMITED, pairs.ALIASED)
        for factor in SHIFTS
        for row in rows(blur, factor)
    )
    study.write("ch07", "accuracy", COLUMNS, every)
