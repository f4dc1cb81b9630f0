"""How good a calibration is, and what to photograph next."""

import numpy as np

from pgm_lab.calibration.solve import Calibration
from pgm_lab.camera import imaging

CELLS = 6, 4  # of the image, along its longer and its shorter side


def coverage(found: Calibration) -> np.ndarray:
    """Number of corners (4, 6) of all photos in the cells of the image."""
    size = np.array(found.image_size)
    cells = np.array(CELLS if size[0] >= size[1] else CELLS[::-1])
    pixels = np.concatenate([one.pixels for one in found.photos])
    column, row = ((pixels + 0.5) / size * cells).astype(int).T
    number = np.zeros(cells[::-1], int)
    np.add.at(number, (row, column), 1)
    return number


def roll(found: Calibration) -> float:
    """Largest angle between the sides of the image in two photos, 0 to 90 degrees.

    Of the board's X axis as it is seen in each, which a photo turned about its axis by
    a right angle shows upright.
    """
    x = imaging.attitude(found.result.exteriors)[:, :2, 0]
    angle = np.degrees(np.arctan2(x[:, 1], x[:, 0]))
    apart = np.abs(angle[:, None] - angle) % 180
    return float(np.minimum(apart, 180 - apart).max())


def zoom(found: Calibration) -> tuple[np.ndarray, np.ndarray]:
    """What c would be larger in each photo alone (m,), and its standard deviation, mm.

    Least squares of the residuals of a photo by its exterior orientation and its own c,
    with the board as it came out.
    """
    result = found.result
    network, covariance = result.network, result.network.covariance
    assert covariance is not None  # of each corner
    dc, sd = np.zeros((2, len(found.photos)))
    for j in range(len(dc)):
        k = np.flatnonzero(network.photo == j)
        v, _, by = imaging.misclosure(
            result.cameras[0].interior,
            result.exteriors[j],
            result.points[network.point[k]],
            network.xy[k],
            result.cameras[0].lens,
            ("interior", "exterior"),
        )
        A = np.concatenate([by["exterior"], by["interior"][..., :1]], axis=2)
        L = np.linalg.cholesky(np.linalg.inv(covariance[k]))
        A, v = (L.swapaxes(1, 2) @ part for part in (A, v[..., None]))
        A, v = A.reshape(-1, 7), v.ravel()
        scale = np.linalg.norm(A, axis=0)
        Q = np.linalg.inv((A / scale).T @ (A / scale)) / np.outer(scale, scale)
        dc[j], sd[j] = -(Q @ A.T @ v)[6], result.sigma0 * np.sqrt(Q[6, 6])
    return dc, sd
