"""Which one, two or three parameters explain best what the points of Bani 2010 leave.

The ten points, intersected with the orientation as printed (angles in radians, f
positive), leave 4.2 pixels. Of all choices of parameters the study asks which brings
the rays together best: the ten of the camera for both photos, the ten for the right
photo alone, the six elements of the right photo, 26 in all; with those of the left
photo 42. Choices of one size have the same redundancy: their sigma0 can be compared.

``python -m pgm_book.ch05.studies.parameters`` writes results/parameters.csv in two
minutes; tests/ch05/test_parameters.py repeats a part.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from tqdm import tqdm

from pgm_book.common import study
from pgm_lab import datasets, frames, orientation
from pgm_lab.camera import PARAMETERS, Camera, imaging

COLUMNS = ("out_of", "number", "choices", "settled", "rank", "parameters", "sigma0_px")
ELEMENTS = ("X0", "Y0", "Z0", "omega", "phi", "kappa")
NAMES = (
    *PARAMETERS,
    *(f"{name} of the right photo" for name in (*PARAMETERS, *ELEMENTS)),
    *(f"{name} of the left photo" for name in (*PARAMETERS, *ELEMENTS)),
)
CAMERA, RIGHT, LEFT = slice(0, 10), slice(10, 26), slice(26, 42)
PIXEL, STEPS, BEST, AT_ONCE = 0.01219, 20, 5, 500
SETTLED = 1e-6  # of sigma0: what the last two steps may change


def ten_points() -> np.ndarray:
    """Photo coordinates (2, 10, 2) with the six decimals behind Tables 4.1 and 4.2."""
    data = datasets.bani2010()
    size = frames.pixel_size_from_sensor(data.sensor_size, data.image_size)
    return np.round((data.pixels - frames.image_centre(data.image_size)) * size, 6)


PHOTO = ten_points()
PRINTED = datasets.bani2010_intersection()["exterior"]
START = orientation.intersect(Camera(18.5558), PRINTED, PHOTO).points


def misclosure(x: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Computed - observed (n, 10, 4), its derivatives by all 42 and by the points.

    x (n, 42) are the changes of the parameters, points (n, 10, 3).
    """
    n = len(x)
    both, own = x[:, None, CAMERA], np.stack([x[:, LEFT], x[:, RIGHT]], axis=1)
    interior = Camera(18.5558).interior + both + own[..., :10]
    v, _, by = imaging.misclosure(
        interior.reshape(-1, 10),
        (PRINTED + own[..., 10:]).reshape(-1, 6),
        np.repeat(points, 2, axis=0).reshape(-1, 3),
        np.tile(PHOTO.reshape(-1, 2), (n, 1)),
        "backward",
        ("interior", "exterior", "point"),
        np.repeat(np.arange(2 * n), 10),
    )
    one = np.concatenate([by["interior"], by["exterior"]], axis=2)
    one = one.reshape(n, 2, 10, 2, 16).swapaxes(1, 2)
    A = np.zeros((n, 10, 2, 2, len(NAMES)))
    A[..., CAMERA] = one[..., :10]
    A[:, :, 0, :, LEFT], A[:, :, 1, :, RIGHT] = one[:, :, 0], one[:, :, 1]
    B = by["point"].reshape(n, 2, 10, 2, 3).swapaxes(1, 2).reshape(n, 10, 4, 3)
    v = v.reshape(n, 2, 10, 2).swapaxes(1, 2).reshape(n, 10, 4)
    return v, A.reshape(n, 10, 4, -1), B


def sigma0(choices: Sequence[Sequence[int]]) -> tuple[np.ndarray, np.ndarray]:
    """Adjust the points with each choice of parameters; sigma0 in px, and if settled.

    A point leaves one combination of its four coordinates: the one at right angles to
    the columns of the point. It is what the parameters have to explain.
    """
    chosen = np.array(choices)
    n, k = chosen.shape
    x, points, history = np.zeros((n, len(NAMES))), np.tile(START, (n, 1, 1)), []
    for _ in range(STEPS):
        v, A, B = misclosure(x, points)
        across = np.linalg.svd(B)[0][..., 3]
        left_over = np.einsum("npi,npi->np", across, v)
        history.append(np.sqrt(np.sum(left_over**2, axis=1) / (10 - k)) / PIXEL)
        A = np.take_along_axis(A, chosen[:, None, None, :], axis=3)
        explained = np.einsum("npi,npik->npk", across, A)
        size = np.linalg.norm(explained, axis=1, keepdims=True)
        size[size == 0] = 1  # a parameter without effect: no correction
        step = -np.linalg.pinv(explained / size, rcond=1e-10) @ left_over[..., None]
        step = step[..., 0] / size[:, 0]
        moved = v + np.einsum("npik,nk->npi", A, step)
        points = points - (np.linalg.pinv(B) @ moved[..., None])[..., 0]
        x[np.arange(n)[:, None], chosen] += step
    change = np.abs(np.diff(history[-3:], axis=0)).max(axis=0)
    return history[-1], change <= SETTLED * history[-1]


def every(out_of: int, number: int) -> tuple[list, np.ndarray, np.ndarray]:
    """All choices of so many parameters, best first, their sigma0, and if settled."""
    choices = list(combinations(range(out_of), number))
    parts = range(0, len(choices), AT_ONCE)
    with np.errstate(all="ignore"):  # what diverges has not settled
        found = [
            sigma0(choices[i : i + AT_ONCE])
            for i in tqdm(parts, f"{number} of {out_of}", leave=False)
        ]
    values, settled = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.argsort(np.where(settled, values, np.inf), kind="stable")
    return [choices[i] for i in order], values[order], settled[order]


def rows(out_of: int, number: int) -> list[tuple]:
    """The best choices, as rows of the table."""
    choices, values, settled = every(out_of, number)
    head = out_of, number, len(choices), int(settled.sum())
    return [
        (*head, i + 1, "; ".join(NAMES[j] for j in choices[i]), f"{values[i]:.4f}")
        for i in range(BEST)
    ]


if __name__ == "__main__":
    sizes = (26, 1), (26, 2), (26, 3), (42, 2), (42, 3)
    study.write(
        "ch05", "parameters", COLUMNS, (r for size in sizes for r in rows(*size))
    )
