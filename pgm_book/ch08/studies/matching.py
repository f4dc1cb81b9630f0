"""What dense matching finds, beside another program and with other settings.

``python -m pgm_book.ch08.studies.matching`` writes results/matching.csv
and results/matching_size.csv within a few minutes; tests/ch08/test_matching_study.py
repeats a part.

A cell is right within 1 px of the true disparity. Scenes: "open" and "objects", ground
that both photos show of `simulate.aerial_pair`, further or nearer than 2.3 m from
houses and trees, or on a house (not in the trees); "hidden", what the right photo does
not show; "motorcycle", the pair of the Middlebury benchmark. `density` is the share of
cells that get a disparity, `wrong` the share of these that are not right, `right` the
share of all cells. `rmse` is that of the right ones in px, `predicted` the root mean
square of their standard deviations, `lost` the share of cells right without the
threshold that the threshold costs. SGBM is OpenCV's `StereoSGBM`, with the settings of
its sample and windows of 5 x 5.
"""

import time
import tracemalloc
from collections.abc import Iterator
from functools import cache

import cv2
import numpy as np

from pgm_book.common import study
from pgm_lab import datasets, simulate, stereo
from pgm_lab.camera import measured
from pgm_lab.camera.imaging import attitude

NEAR = 2.3  # m
COLUMNS = (
    *("scene", "method", "window", "threshold", "levels", "refine"),
    *("density", "wrong", "right", "rmse", "predicted", "lost"),
)
SIZES = (
    *("columns", "rows", "million_cells"),
    *("bytes_a_cell", "us_a_cell", "ours_to_sgbm"),
)
THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
WINDOWS = (5, 7, 9, 11, 15)
PAIR = (700, 500)
Scene = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def true_disparity(
    pair: simulate.AerialPair, normal: stereo.NormalPair
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Disparity, object point (..., 3) and whether both see it, of each left pixel.

    The ground of the pixels of the left photo, interpolated at those of the normal
    image, is projected into both normal images.
    """
    rows, columns = normal.left.shape
    x = normal.origin[0, 0] + normal.pixel_size * np.arange(columns)
    y = normal.origin[0, 1] - normal.pixel_size * np.arange(rows)
    image = np.stack([*np.meshgrid(x, y), np.full((rows, columns), -normal.c)], -1)
    rays = image @ (normal.rotation @ attitude(pair.left.exterior).T)
    ideal = -pair.left.camera.c * rays[..., :2] / rays[..., 2:]
    pixels = pair.left.to_pixel(measured(pair.left.camera, ideal)).astype(np.float32)

    def at(layer: np.ndarray) -> np.ndarray:
        return cv2.remap(
            layer.astype(np.float32),
            *np.moveaxis(pixels, -1, 0).copy(),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=(np.nan,) * 4,
        )

    middle = pair.ground[0].reshape(-1, 3).mean(0)
    ground = at(pair.ground[0] - middle) + middle
    column = []
    for station, origin in zip(normal.stations, normal.origin, strict=True):
        u = (ground - station) @ normal.rotation.T
        column.append(
            (-normal.c * u[..., 0] / u[..., 2] - origin[0]) / normal.pixel_size
        )
    seen = at(pair.hidden[0]) == 0
    return column[0] - column[1], ground, seen & np.isfinite(ground).all(-1)


@cache
def aerial(part: tuple[int, int] = PAIR) -> dict[str, Scene]:
    """Left and right normal image, true disparities, and the cells of each scene."""
    pair = simulate.aerial_pair(part)
    land = pair.landscape
    heights = float(land.dsm.min()), float(land.dsm.max())
    normal = stereo.epipolar_pair(pair.left, pair.right, heights)
    truth, ground, seen = true_disparity(pair, normal)
    X, Y = np.nan_to_num(ground[..., 0]), np.nan_to_num(ground[..., 1])
    side = 2 * int(NEAR / land.cell) + 1
    objects = cv2.dilate(np.minimum(land.kind, 1), np.ones((side, side), np.uint8))
    near = land.at(objects, X, Y, cv2.INTER_NEAREST) > 0
    tree = land.at(land.kind, X, Y, cv2.INTER_NEAREST) == 2
    images = normal.left, normal.right, truth
    cells = {
        "open": seen & ~near,
        "objects": seen & near & ~tree,
        "hidden": ~seen & np.isfinite(truth),
    }
    return {name: (*images, where) for name, where in cells.items()}


@cache
def motorcycle() -> dict[str, Scene]:
    """The same of the motorcycle."""
    pair = datasets.motorcycle()
    known = np.isfinite(pair.disparity)
    return {"motorcycle": (pair.left, pair.right, pair.disparity, known)}


def sgbm(left: np.ndarray, right: np.ndarray, least: int, number: int) -> np.ndarray:
    """Disparities of OpenCV, NaN where there are none."""
    grey = [np.nan_to_num(np.clip(np.rint(a), 0, 255)) for a in (left, right)]
    matcher = cv2.StereoSGBM.create(
        least,
        number,
        5,
        P1=8 * 5**2,
        P2=32 * 5**2,
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=2,
    )
    found = matcher.compute(*(a.astype(np.uint8) for a in grey)) / 16
    return np.where(found >= least, found, np.nan)


def span(truth: np.ndarray) -> tuple[int, int]:
    """Least disparity and number of them, as SGBM asks for."""
    least = int(np.floor(np.nanmin(truth[np.isfinite(truth)]))) - 2
    most = int(np.ceil(np.nanmax(truth[np.isfinite(truth)]))) + 2
    return least, -(-(most - least) // 16) * 16


def judged(
    found: np.ndarray,
    truth: np.ndarray,
    where: np.ndarray,
    sd: np.ndarray | None = None,
) -> tuple:
    """Numbers of a row but the last."""
    error = np.abs(found - truth)[where]
    given, right = np.isfinite(error), error <= 1
    predicted = "" if sd is None else f"{rms(sd[where][right]):.4f}"
    return (
        f"{given.mean():.3f}",
        f"{1 - right.sum() / max(given.sum(), 1):.4f}",
        f"{right.mean():.3f}",
        f"{rms(error[right]):.4f}" if right.any() else "",
        predicted if right.any() else "",
    )


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values, dtype=float))))


def rows(
    scenes: dict[str, Scene], window: int, thresholds: tuple, levels: int, refine: bool
) -> Iterator[tuple]:
    """Rows of one setting: all scenes of a pair, all thresholds."""
    left, right, truth, _ = next(iter(scenes.values()))
    how = {"method": "ncc", "window": window, "levels": levels, "refine": refine}
    every = stereo.match_rows(left, right, threshold=-1, **how)
    for threshold in thresholds:
        match = stereo.match_rows(left, right, threshold=threshold, **how)
        for name, (*_, where) in scenes.items():
            before = (np.abs(every.disparity - truth) <= 1) & where
            after = (np.abs(match.disparity - truth) <= 1) & where
            lost = 1 - (before & after).sum() / max(before.sum(), 1)
            yield (
                *(name, "pgm_lab", window, f"{threshold:.2f}", levels, refine),
                *judged(match.disparity, truth, where, match.sd),
                f"{lost:.3f}",
            )


def peer(scenes: dict[str, Scene]) -> Iterator[tuple]:
    """Rows of SGBM."""
    left, right, truth, _ = next(iter(scenes.values()))
    found = sgbm(left, right, *span(truth))
    for name, (*_, where) in scenes.items():
        yield (name, "SGBM", 5, "", "", "", *judged(found, truth, where), "")


def table() -> Iterator[tuple]:
    """All rows."""
    for scenes in (aerial(), motorcycle()):
        yield from peer(scenes)
        for refine in (True, False):
            yield from rows(scenes, 7, THRESHOLDS, 6, refine)
        for window in WINDOWS:
            if window != 7:
                yield from rows(scenes, window, (0.8,), 6, True)
        yield from rows(scenes, 7, (0.8,), 1, True)


def waves(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Disparity of what the right image of `wide` shows at (x, y)."""
    return 6 * np.sin(y / 90) + 6 * np.cos(x / 110)


def true_waves(columns: int, lines: int) -> np.ndarray:
    """Disparity of the left pixels of `wide`: what is at x is at x - d in the right."""
    x, y = np.meshgrid(np.arange(columns), np.arange(lines))
    d = np.zeros(x.shape)
    for _ in range(10):
        d = waves(x - d, y)
    return d


def wide(columns: int, lines: int) -> tuple[np.ndarray, np.ndarray]:
    """Pair of this size, of a texture on waves of up to 12 px."""
    texture = cv2.GaussianBlur(
        np.random.default_rng(8).normal(0, 1, (lines, columns + 80)).astype(np.float32),
        *((0, 0), 1.2),
    )
    texture = 120 + 40 * texture / texture.std()
    x, y = np.meshgrid(
        np.arange(columns, dtype=np.float32), np.arange(lines, dtype=np.float32)
    )
    shifted = x + 40 + waves(x, y)
    return (
        cv2.remap(texture, x + 40, y, cv2.INTER_CUBIC),
        cv2.remap(texture, shifted, y, cv2.INTER_CUBIC),
    )


def sizes() -> Iterator[tuple]:
    """Processor time beside SGBM, and memory, against size; both on one thread."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    sgbm(*wide(640, 400), -32, 64)  # OpenCV starts
    for columns, lines in ((640, 400), (1280, 800), (2560, 1600), (4288, 2848)):
        left, right = wide(columns, lines)
        began = time.process_time()
        sgbm(left, right, -32, 64)
        middle = time.process_time()
        stereo.match_rows(left, right, method="ncc")
        end = time.process_time()
        tracemalloc.start()
        stereo.match_rows(left, right, method="ncc")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        cells = columns * lines
        ratio = (end - middle) / (middle - began)
        each = 1e6 * (end - middle) / cells
        yield (
            *(columns, lines, f"{cells / 1e6:.2f}", round(peak / cells)),
            *(f"{each:.1f}", f"{ratio:.1f}"),
        )
    cv2.setNumThreads(threads)


if __name__ == "__main__":
    study.write("ch08", "matching", COLUMNS, table())
    study.write("ch08", "matching_size", SIZES, sizes())
