"""What the check of the search for one chip (chapter 7) looks at."""

from collections.abc import Callable

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view

from pgm_lab._validate import real
from pgm_lab.checks import CheckFailed, answer_of, near

NOISE = np.random.default_rng(7).normal(0, 100, (84, 96))
SCENE = scipy.ndimage.gaussian_filter(NOISE, 1.2)
SEARCHES = [  # point, chip, radius, shift of the sensed image
    ((38, 47), 9, 3, (2, -1)),
    ((51, 40), 7, 4, (-3, -2)),
    ((44, 36), 11, 2, (0, 1)),
]


def moved(shift: tuple[float, float]) -> np.ndarray:
    """The scene with every point moved by (columns, rows)."""
    return scipy.ndimage.shift(SCENE, shift[::-1], order=3, mode="mirror")


def search_of(
    function: Callable[..., object], *arguments: object
) -> tuple[float, float, np.ndarray]:
    """What the reader's search returns: two whole numbers and a square map."""
    radius = int(arguments[-1])  # type: ignore[call-overload]
    answer = answer_of(function, *arguments)
    try:
        dx, dy, r = answer
        found = np.array([float(dx), float(dy)])
        r = real(r, "r")
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed("best_shift must return three things: dx, dy and r") from None
    n = 2 * radius + 1
    if r.shape != (n, n):
        raise CheckFailed(
            f"best_shift: with radius {radius} the map r must have shape ({n}, {n});"
            f" got {r.shape}"
        )
    return found[0], found[1], r


def judge_maps(maps: list[np.ndarray], wanted: list[np.ndarray]) -> tuple[bool, str]:
    """Whether all maps are right, and the hint to the slip that explains them."""

    def all_near(others: list[np.ndarray]) -> bool:
        return all(near(r, other, 1e-7) for r, other in zip(maps, others))

    if all_near(wanted):
        return True, ""
    cases = [(p, c, k, moved(s)) for p, c, k, s in SEARCHES]
    slips = {
        "rows come first: r[i, j] belongs to the row i and the column j": [
            r.T for r in wanted
        ],
        "the windows move the wrong way: dx is added to the column, dy to the row": [
            r[::-1, ::-1] for r in wanted
        ],
        "point is (column, row), and an image is indexed [row, column]": [
            map_of(SCENE, s, p[::-1], c, k) for p, c, k, s in cases
        ],
        "the chip is cut out of the reference image, the windows out of the sensed": [
            map_of(s, SCENE, p, c, k) for p, c, k, s in cases
        ],
        "both windows come from the reference image": [
            map_of(SCENE, SCENE, p, c, k) for p, c, k, s in cases
        ],
        "the chip moves along: it stays in its place in the reference image": [
            np.array([[_r(SCENE, s, p, (i, j), (i, j), c) for i in range(-k, k + 1)]
                      for j in range(-k, k + 1)])
            for p, c, k, s in cases
        ],
        "the map is still zero at most places: fill it for every dy and dx": [
            r * (r == r.max()) for r in wanted
        ],
        "the last row and column are still 0: the shifts go up to +radius": [
            np.pad(r[:-1, :-1], (0, 1)) for r in wanted
        ],
    }  # fmt: skip
    otherwise = "r is not the correlation of the chip with the window of each shift"
    if not any(np.any(r) for r in maps):
        return False, "the map is still zero: fill it for every dy and dx"
    return False, next(
        (h for h, others in slips.items() if all_near(others)), otherwise
    )


def map_of(
    reference: np.ndarray,
    sensed: np.ndarray,
    point: tuple[int, ...],
    chip: int,
    radius: int,
) -> np.ndarray:
    """All correlations of a search at once: another way than the loop's."""
    x, y = point
    half, room = chip // 2, chip // 2 + radius
    t = reference[y - half : y + half + 1, x - half : x + half + 1]
    area = sensed[y - room : y + room + 1, x - room : x + room + 1]
    windows = sliding_window_view(area, t.shape)
    w, t = windows - windows.mean(axis=(2, 3), keepdims=True), t - t.mean()
    r = np.einsum("ijkl,kl->ij", w, t)
    return r / np.sqrt(np.einsum("ijkl,ijkl->ij", w, w) * np.sum(t * t))


def _r(
    reference: np.ndarray,
    sensed: np.ndarray,
    point: tuple[int, int],
    one: tuple[int, int],
    other: tuple[int, int],
    chip: int,
) -> float:
    """Correlation of two windows, each moved from the point by itself."""
    half, flat = chip // 2, []
    for image, (dx, dy) in ((reference, one), (sensed, other)):
        x, y = point[0] + dx, point[1] + dy
        flat.append(image[y - half : y + half + 1, x - half : x + half + 1].ravel())
    return float(np.corrcoef(flat)[0, 1])


def keeps_inside(function: Callable[..., object]) -> bool:
    """Whether a search near the edge stops, or leaves out what is outside."""
    step = np.arange(-3, 4)
    for x, y in ((5, 40), (40, 5), (90, 40), (40, 79)):
        whole_x = (x + step >= 4) & (x + step < SCENE.shape[1] - 4)
        whole_y = (y + step >= 4) & (y + step < SCENE.shape[0] - 4)
        try:
            _, _, r = answer_of(function, SCENE, SCENE, (x, y), 9, 3)
            left_out = real(r, "r")[~(whole_y[:, None] & whole_x)]
        except (CheckFailed, IndexError, TypeError, ValueError):
            continue
        if len(np.unique(left_out[np.isfinite(left_out)])) > 1:
            return False
    return True
