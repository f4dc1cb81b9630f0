"""How far off the start of least squares matching may be, and which window it needs.

``python -m pgm_book.ch03.studies.pull_in`` writes results/pull_in.csv and windows.csv
in some minutes; tests/ch03/test_studies.py repeats a part.

Gain 1.08, offset 4, noise of one grey value; a point has arrived if it ends within 0.1
px of the truth, and is false if it is reported as converged elsewhere. The time is the
processor's, for 870 points in 1300 x 1300 pixels.
"""

import time
from collections.abc import Iterable

import numpy as np

from pgm_book.ch03.studies import scene as lsm_scene
from pgm_book.common import study
from pgm_lab import lsm

TEXTURES = {"soft": lsm_scene.SOFT, "sharp": lsm_scene.SHARP}
ARRIVED = 0.1  # px
PULL_IN = ("texture", "window", "start_error_px", "points", "arrived", "false")
WINDOWS = (
    *("texture", "window", "points", "converged", "rms_px", "bound_px"),
    *("rms_over_bound", "false", "time_over_window_21"),
)
SIZES = (7, 9, 11, 13, 15, 17, 21, 25, 31, 37, 41)


def pull_in(
    kind: str, window: int, errors: Iterable[float], n: int = 1000
) -> list[tuple]:
    """Rows of the first table: starts off by `errors` pixels, in random directions."""
    scene = lsm_scene.scene(TEXTURES[kind], 1, size=1300, spacing=36, margin=30)
    left, right = scene.images(1.0)
    rng = np.random.default_rng([31, window])
    chosen = rng.permutation(len(scene.points))[:n]
    points, truth = scene.points[chosen], scene.truth[chosen]
    direction = rng.uniform(0, 2 * np.pi, n)
    away = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    table = []
    for error in errors:
        found = lsm.match(left, right, points, truth + error * away, window)
        near = np.hypot(*(found.points - truth).T) < ARRIVED
        false = found.accepted & ~near
        share = f"{near.mean():.3f}", f"{false.mean():.3f}"
        table.append((kind, window, f"{error:.2f}", n, *share))
    return table


def windows(kind: str, sizes: Iterable[int] = SIZES, seeds: int = 2) -> list[tuple]:
    """Rows of the second table: starts rounded to whole pixels."""
    table, reference = [], None
    scenes = [
        lsm_scene.scene(TEXTURES[kind], seed, size=1300, spacing=42, margin=28)
        for seed in range(seeds)
    ]
    pairs = [scene.images(1.0, seed=seed) for seed, scene in enumerate(scenes)]
    for window in sizes:
        good, e2, b2, z2, times = [], [], [], [], []
        for scene, pair in zip(scenes, pairs):
            for _ in range(2):
                started = time.process_time()
                found = lsm.match(*pair, scene.points, scene.start, window)
                times.append(time.process_time() - started)
            error, bound = found.points - scene.truth, scene.bound(window)
            good.append(found.accepted)
            e2.append(error**2)
            b2.append(np.diagonal(bound, axis1=1, axis2=2))
            z2.append(lsm_scene.squared(error, bound))
        good, e2, b2, z2 = map(np.concatenate, (good, e2, b2, z2))
        near = e2.sum(axis=1) < ARRIVED**2
        table.append(
            (
                *(kind, window, len(good), f"{good.mean():.4f}"),
                f"{np.sqrt(e2[near].mean()):.3g}",
                f"{np.sqrt(b2[near].mean()):.3g}",
                f"{np.sqrt(z2[near].mean()):.3f}",
                f"{np.mean(good & ~near):.4f}",
                min(times),
            )
        )
        reference = min(times) if window == 21 else reference
    if reference is None:
        return [(*row[:-1], "") for row in table]
    return [(*row[:-1], f"{row[-1] / reference:.2f}") for row in table]


if __name__ == "__main__":
    starts = np.arange(0, 5.01, 0.25)
    table = (row for kind in TEXTURES for row in windows(kind))
    study.write("ch03", "windows", WINDOWS, table)
    table = (
        row
        for kind in TEXTURES
        for window in (11, 21, 31)
        for row in pull_in(kind, window, starts, 300 if window == 31 else 1000)
    )
    study.write("ch03", "pull_in", PULL_IN, table)
