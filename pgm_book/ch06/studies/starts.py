"""From how far the self-calibrating bundle adjustment finds the solution.

``python -m pgm_book.ch06.studies.starts`` writes results/starts.csv in some minutes;
tests/ch06/test_studies.py repeats a part.

The network is the real one of Muliawan 2013. Its solution from the given start values
is disturbed: the principal distance by a factor, each photo by a turn about any axis
and by a shift in any direction, each point by a shift in any direction.
"""

from dataclasses import replace

import numpy as np
from tqdm import tqdm

from pgm_book.ch06 import published
from pgm_book.common import study
from pgm_lab import bundle, simulate
from pgm_lab.camera import Camera, imaging

AGREE = 1e-8
# Smaller than AGREE: what is still to come after a step is about a thirtieth of it.
TOLERANCE = 1e-8
MAX_ITERATIONS = 50

# Turn in degrees, shift over the distance from the object, of points over its length
CASES = (
    (10, 0.2, 0.0),
    (10, 0.2, 0.1),
    (20, 0.3, 0.0),
    (30, 0.4, 0.0),
    (30, 0.4, 0.1),
    (45, 0.4, 0.0),
    (45, 0.4, 0.1),
    (60, 0.4, 0.0),
)
KEYS = ("turn_deg", "shift_percent", "points_percent", "method")
COLUMNS = (
    *KEYS,
    *("starts", "same_solution", "another", "refused", "not_converged"),
    *("median_iterations", "most_iterations"),
    *("sigma0_relative", "camera_in_sd", "residuals_mm"),
)
network = published.network


def solution(net: bundle.Network) -> bundle.Bundle:
    """The adjusted network, from the start values that come with it."""
    return bundle.adjust(net, tolerance=TOLERANCE)


def disturbed(
    found: bundle.Bundle, rng: np.random.Generator, turn: float, shift: float, aside
) -> bundle.Network:
    """Start values that are wrong in every part, c by a factor from 0.5 to 2."""
    centre = found.points.mean(axis=0)
    about = found.exteriors - np.r_[centre, 0, 0, 0]
    rough = np.array([simulate.rough(one, rng, turn, shift) for one in about])
    interior = found.network.cameras[0].interior
    interior[0] = found.cameras[0].c * 2 ** rng.uniform(-1, 1)
    away = rng.normal(size=found.points.shape)
    away *= aside * np.ptp(found.points, axis=0).max() / _length(away)
    return replace(
        found.network,
        cameras=Camera(*interior),
        exteriors=rough + np.r_[centre, 0, 0, 0],
        points=found.network.points + away,
    )


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vectors, axis=-1, keepdims=True)


def differences(one: bundle.Bundle, other: bundle.Bundle) -> tuple[float, ...]:
    """Largest in sigma0 (relative), camera (in sd) and residuals (mm)."""
    return (
        abs(one.sigma0 / other.sigma0 - 1),
        np.max(np.abs(one.interior - other.interior) / other.sd_interior),
        np.max(np.abs(one.residuals - other.residuals)),
    )


def in_front(one: bundle.Bundle) -> bool:
    """Whether all points lie in front of their photos.

    A network and its mirror image, all points behind their photos, have the same camera
    and the same residuals: nothing else tells them apart.
    """
    network = one.network
    rays, _ = imaging.ray(one.exteriors[network.photo], one.points[network.point])
    return bool(np.all(rays[:, 2] < 0))


def ending(there: bundle.Bundle, found: bundle.Bundle) -> str:
    """How an adjustment ended: "same" solution, "another" or "no"."""
    if there.status != "converged":
        return "no"
    same = max(differences(there, found)) < AGREE and in_front(there)
    return "same" if same else "another"


def row(found, turn, shift, aside, line_search: bool, starts: int) -> tuple:
    """One row of the table; the same starts with and without line search."""
    rng = np.random.default_rng([6, turn, round(100 * shift), round(100 * aside)])
    worst, iterations = np.zeros(3), []
    count = dict.fromkeys(("same", "another", "refused", "no"), 0)
    text = f"{turn} degrees, {shift:.0%}, {aside:.0%}"
    for _ in tqdm(range(starts), text, leave=False):
        start = disturbed(found, rng, turn, shift, aside)
        try:
            with np.errstate(all="ignore"):  # full steps may diverge
                there = bundle.adjust(
                    start,
                    line_search=line_search,
                    tolerance=TOLERANCE,
                    max_iterations=MAX_ITERATIONS,
                )
        except ValueError:  # a rank defect on the way, or numbers that are not finite
            count["refused"] += 1
            continue
        end = ending(there, found)
        count[end] += 1
        if end == "same":
            iterations.append(there.iterations)
            worst = np.maximum(worst, differences(there, found))
    method = "line search" if line_search else "full steps"
    return (
        *(turn, round(100 * shift), round(100 * aside), method),
        *(starts, *count.values()),
        *(f"{np.median(iterations):.0f}", max(iterations)),
        *(f"{value:.0e}" for value in worst),
    )


def rows() -> list[tuple]:
    """Return the whole table: 500 starts of the first case, 100 of the others."""
    found = solution(network())
    return [
        row(found, *case, line_search, 100 if i else 500)
        for i, case in enumerate(CASES)
        for line_search in (True, False)
    ]


if __name__ == "__main__":
    study.write("ch06", "starts", COLUMNS, rows())
