"""Errors of least squares matching over what it predicts, where noise is not white.

``python -m pgm_book.ch03.studies.correlated`` writes results/correlated.csv in about a
minute; tests/lsm/test_correlated.py repeats a part.

The orthophoto is photographed twice by a camera that is rotated by 2 degrees between
them, with pixels four times as large as those of the orthophoto; therefore the truth is
known. What happens to the grey values differs: white noise alone, colours
that are interpolated between the pixels of a Bayer mosaic, sharpening, JPEG.
"""

from collections.abc import Iterator

import cv2
import numpy as np

from pgm_book.ch03.studies import scene as lsm_scene
from pgm_book.ch03.studies.interpolation_bias import opencv_cubic
from pgm_book.common import study
from pgm_lab import datasets, lsm

FACTOR = 4  # pixels of the orthophoto in a pixel of the camera, along a side
TURN, SCALE, SHIFT = np.radians(2.0), 1.02, (0.37, -0.21)  # of the second photo
NOISE = 2.0  # grey values
QUALITY = 90  # of JPEG
CAMERAS = {
    "white noise": (),
    "Bayer mosaic": ("mosaic",),
    "JPEG": ("JPEG",),
    "all and sharpened": ("mosaic", "sharpened", "JPEG"),
}
TEMPLATES = 11, 21, 31
FALSE = 1.0  # px
COLUMNS = (
    *("camera", "template", "points", "matched", "median_effective_pixels"),
    *("median_error", "white_median_z", "white_rms_z", "median_z", "rms_z"),
)


def photos(steps: tuple[str, ...], seed: int = 1) -> tuple[np.ndarray, ...]:
    """Left and right photo, and the affine transformation (6,) between them."""
    scene = datasets.yellowstone().grey.astype(np.float32)
    size = np.array(scene.shape[::-1]) // FACTOR - 12
    middle = (size - 1) / 2
    cos, sin = SCALE * np.cos(TURN), SCALE * np.sin(TURN)
    J = np.array([[cos, -sin], [sin, cos]])
    affine = np.column_stack([middle - J @ middle + SHIFT, J]).ravel()
    rng = np.random.default_rng(seed)
    left = camera(seen(scene, size, np.eye(2, 3, 1).ravel()), steps, rng)
    return left, camera(seen(scene, size, affine), steps, rng), affine


def seen(scene: np.ndarray, size: np.ndarray, affine: np.ndarray) -> np.ndarray:
    """Means of the scene over the pixels of a photo, that `affine` leads to."""
    to_scene = np.linalg.inv(affine.reshape(2, 3)[:, 1:])
    pixels = np.stack(np.meshgrid(*(np.arange(n) for n in size)), axis=-1)
    part = (np.arange(FACTOR) + 0.5) / FACTOR - 0.5
    total = np.zeros(pixels.shape[:2])
    for beside in np.stack(np.meshgrid(part, part), axis=-1).reshape(-1, 2):
        at = (pixels + beside - affine[[0, 3]]) @ to_scene.T
        total += opencv_cubic(scene, (at + 6) * FACTOR)
    return total / FACTOR**2


def camera(
    grey: np.ndarray, steps: tuple[str, ...], rng: np.random.Generator
) -> np.ndarray:
    """What a camera makes of grey values: 8 bit, with noise."""
    noisy = grey + rng.normal(0, NOISE, grey.shape)
    photo = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    if "mosaic" in steps:
        photo = cv2.cvtColor(photo, cv2.COLOR_BayerBG2BGR)
    if "sharpened" in steps:
        blurred = cv2.GaussianBlur(photo, (0, 0), 1.5)
        photo = cv2.addWeighted(photo, 1.5, blurred, -0.5, 0)
    if "JPEG" in steps:
        _, file = cv2.imencode(".jpg", photo, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        photo = cv2.imdecode(file, cv2.IMREAD_UNCHANGED)
    return photo if photo.ndim == 2 else cv2.cvtColor(photo, cv2.COLOR_BGR2GRAY)


def rows(name: str, templates: tuple[int, ...] = TEMPLATES) -> Iterator[tuple]:
    """Rows of the table for one camera."""
    left, right, affine = photos(CAMERAS[name])
    for template in templates:
        margin = template // 2 + 12.0
        across, down = (
            np.arange(margin, n - margin, template) for n in left.shape[::-1]
        )
        points = np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)
        truth = lsm_scene.warp(affine, points)
        z = []
        for correlated in (False, True):
            found = lsm.match(
                *(left, right, points, np.rint(truth), template), correlated=correlated
            )
            error = found.points - truth
            good = found.accepted & (np.hypot(*error.T) < FALSE)
            z2 = lsm_scene.squared(error[good], found.covariance[good])
            # Half of normal errors are smaller than 0.6745 standard deviations
            z += [np.sqrt(np.median(z2)) / 0.6745, np.sqrt(np.mean(z2))]
        yield (
            *(name, template, len(points), f"{good.mean():.3f}"),
            f"{np.median(found.effective_pixels[good]):.0f}",
            f"{np.median(np.abs(error[good])):.4f}",
            *(f"{value:.2f}" for value in z),
        )


if __name__ == "__main__":
    table = (row for name in CAMERAS for row in rows(name))
    study.write("ch03", "correlated", COLUMNS, table)
