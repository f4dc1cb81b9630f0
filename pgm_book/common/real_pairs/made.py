"""Real photos photographed again: the truth is known, the camera is not kind.

A made photo sees its subject through a lens and a sensor: each pixel is the mean over
its area, the corners are darker, the exposure differs, the three colours are measured
at different pixels and interpolated, grey values are noisy and stored as JPEG.
"""

from dataclasses import dataclass

import cv2
import numpy as np

FINER = 3  # samples along a pixel
WHITE = (0.6, 1.0, 0.75)  # what the sensor gets of blue, green, red


@dataclass(frozen=True)
class Camera:
    """What a photo suffers."""

    gain: float = 1.0
    vignetting: float = 0.15  # of the light is missing in the corners
    noise: float = 2.0  # grey values, standard deviation at the sensor
    quality: int = 92  # of the JPEG
    seed: int = 0


def seen(subject: np.ndarray, H: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Grey values (rows, columns) of a subject under a homography, mean over pixels.

    H (3, 3) takes (column, row, 1) of the subject to the photo of `size` (columns,
    rows), integers at pixel centres.
    """
    n = FINER
    fine = np.array([[n, 0, (n - 1) / 2], [0, n, (n - 1) / 2], [0, 0, 1.0]])
    return cv2.resize(
        cv2.warpPerspective(
            subject.astype(np.float32),
            fine @ H,
            (n * size[0], n * size[1]),
            flags=cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REFLECT,
        ),
        size,
        interpolation=cv2.INTER_AREA,
    )


def photo(light: np.ndarray, camera: Camera) -> np.ndarray:
    """Grey values of 8 bits that a camera stores of the light (rows, columns)."""
    rows, columns = light.shape
    y, x = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j]
    light = light * camera.gain * (1 - camera.vignetting * (x**2 + y**2) / 2)
    # Blue, green and red at different pixels (Bayer), then interpolated
    mosaic = light.copy()
    mosaic[0::2, 0::2] *= WHITE[0]
    mosaic[1::2, 1::2] *= WHITE[2]
    rng = np.random.default_rng(camera.seed)
    mosaic = _grey_of_8_bits(mosaic + rng.normal(0, camera.noise, light.shape))
    colours = cv2.cvtColor(mosaic, cv2.COLOR_BayerBGGR2BGR) / np.array(WHITE)
    ok, coded = cv2.imencode(
        ".jpg", _grey_of_8_bits(colours), [cv2.IMWRITE_JPEG_QUALITY, camera.quality]
    )
    if not ok:
        raise ValueError("the photo could not be stored as JPEG")
    return cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE)


def similarity(degrees: float, scale: float, centre: tuple[float, float]) -> np.ndarray:
    """Homography (3, 3) that turns and scales about a centre, and shifts a little."""
    a = np.radians(degrees)
    A = scale * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    H = np.eye(3)
    H[:2, :2] = A
    H[:2, 2] = centre - A @ centre + (0.37, -0.21)
    return H


def transformed(H: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (n, 2) under a homography."""
    homogeneous = np.column_stack([points, np.ones(len(points))]) @ H.T
    return homogeneous[:, :2] / homogeneous[:, 2:]


@dataclass(frozen=True)
class Layer:
    """A flat thing in front of two cameras side by side.

    `disparity` (3,) is d = d0 + dx column + dy row, of the left photo; `outline` are
    the corners (n, 2) in the left photo, None for a background.
    """

    subject: np.ndarray
    disparity: tuple[float, float, float]
    outline: np.ndarray | None = None

    def to_right(self) -> np.ndarray:
        """Homography (3, 3) from left to right: column less disparity."""
        H = np.eye(3)
        d0, dx, dy = self.disparity
        H[0] = 1 - dx, -dy, -d0
        return H


def stereo(
    layers: list[Layer], size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Light in two photos of layers, the nearest last, and the left disparities."""
    columns, rows = size
    left, right = np.zeros((2, rows, columns))
    y, x = np.indices((rows, columns))
    disparity = np.zeros((rows, columns))
    for layer in layers:
        H = layer.to_right()
        mask = np.ones(layer.subject.shape, np.float32)
        if layer.outline is not None:
            mask = np.zeros((rows, columns), np.float32)
            cv2.fillPoly(mask, [np.round(layer.outline).astype(np.int32)], 1.0)
        sides = []
        for light, side in ((left, np.eye(3)), (right, H)):
            covered = seen(mask, side, size)
            sides.append(light + covered * (seen(layer.subject, side, size) - light))
        left, right = sides
        d0, dx, dy = layer.disparity
        there = seen(mask, np.eye(3), size) > 0.5
        disparity[there] = (d0 + dx * x + dy * y)[there]
    return left, right, disparity


def _grey_of_8_bits(values: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
