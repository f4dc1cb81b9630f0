"""Standard deviations of a bundle adjustment tested, and errors of control.

``python -m pgm_book.ch06.studies.precision`` writes results/precision.csv and
results/control.csv in two minutes; tests/ch06/test_studies.py repeats a part.

The adjusted network of Muliawan 2013 is taken as true, and measured again and again
with normally distributed errors, as large as those of the real images.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy
from tqdm import tqdm

from pgm_book.ch06.studies import starts
from pgm_book.common import study
from pgm_lab import bundle, camera
from pgm_lab.camera import PARAMETERS
from pgm_lab.orientation import absolute

COLUMNS = (
    *("quantity", "unit", "networks", "predicted_sd", "sampled_sd", "ratio"),
    *("mean_error_in_sd", "inside_percent", "expected_percent", "mean_square"),
)
CONTROL_COLUMNS = (
    *("control", "error_mm", "networks", "sigma0", "c_error_mm", "c_sd_mm"),
    *("points_error_mm", "points_sd_mm", "largest_w", "control_residual_mm"),
)
NETWORKS = 2000
BLANK = ("",) * 4
ALARM = 3.29  # what Baarda's w exceeds once in a thousand
CORNERS = np.array([0, 9, 30, 39])  # of the object: control points
MM = ("mm", "mm^-2", "mm^-4", "mm^-6", "mm^-1")
UNITS = [MM[i] for i in (0, 0, 0, 1, 2, 3, 4, 4)] + ["1", "1"]
PARTS = (
    (
        *("interior", "interior", "all ten parameters"),
        [(name, unit, i) for i, (name, unit) in enumerate(zip(PARAMETERS, UNITS))],
    ),
    (
        *("exteriors", "exteriors", "exterior orientations"),
        [("stations", "mm", slice(3)), ("angles", "rad", slice(3, 6))],
    ),
    ("points", "points", "ellipsoids of points", [("points", "mm", slice(3))]),
)


def true_network() -> bundle.Network:
    """What is true: start values without errors, and image points that fit exactly."""
    found = starts.solution(starts.network())
    net, cam = found.network, found.cameras[0]
    xy = camera.project(cam, found.exteriors[net.photo], found.points[net.point])
    return replace(
        net,
        cameras=cam,
        exteriors=found.exteriors,
        points=found.points,
        xy=xy,
        sigma=found.sigma0 * net.sigma,
    )


def measured(
    truth: bundle.Network, networks: int, seed: int = 0
) -> Iterator[bundle.Network]:
    """Networks that differ by the errors of their image points."""
    rng = np.random.default_rng([66, seed])
    for _ in tqdm(range(networks), leave=False):
        error = truth.sigma * rng.normal(size=truth.xy.shape)
        yield replace(truth, xy=truth.xy + error)


def errors(e: np.ndarray, C: np.ndarray, redundancy: int) -> tuple[np.ndarray, ...]:
    """Whether errors (..., u) lie in their intervals and ellipsoids of 95 per cent.

    After each of the two the squares over the variances, the second divided by u.
    """
    u = e.shape[-1]
    alone = e**2 / np.diagonal(C, axis1=-2, axis2=-1)
    # sigma0 is itself estimated: t and F instead of normal and chi square
    together = np.einsum("...i,...i->...", e, np.linalg.solve(C, e[..., None])[..., 0])
    together /= u
    within = alone <= scipy.stats.f.ppf(0.95, 1, redundancy)
    inside = together <= scipy.stats.f.ppf(0.95, u, redundancy)
    return within, alone, inside, together


def precision(networks: int = NETWORKS) -> list[tuple]:
    """Rows of the first table.

    The datum is that of the inner constraints on all points. Every adjustment starts
    from the truth, so its corrections are the errors, and contain no motion.
    """
    truth = true_network()
    exact = bundle.adjust(truth, sigma0_prior=1.0)
    found = [bundle.adjust(net, sigma0_prior=1.0) for net in measured(truth, networks)]
    r = exact.redundancy

    def collected(name: str) -> np.ndarray:
        return np.array([getattr(one, name) for one in found])

    def compared(name: str, what: str):
        """Errors, predicted sds for sigma0 = 1, and the four results of `errors`."""
        e, C = collected(name), f"covariance_{what}"
        e = e - getattr(exact, name)
        Q = getattr(exact, C) / exact.sigma0**2
        sd = np.sqrt(np.diagonal(Q, axis1=-2, axis2=-1))
        return e, sd, *errors(e, collected(C), r)

    rows = []
    for name, what, together_name, parts in PARTS:
        e, sd, within, alone, inside, together = compared(name, what)
        for title, unit, part in parts:
            values = (a[..., part] for a in (e, sd, within, alone))
            rows.append((title, unit, networks, *described(*values)))
        rows.append((together_name, "", networks, *BLANK, *rate(inside, 95, together)))

    sigma0 = collected("sigma0")
    low, high = np.sqrt(scipy.stats.chi2.ppf([0.025, 0.975], r) / r)
    within = (low < sigma0) & (sigma0 < high)
    e, sd = sigma0 - 1, np.array(1 / np.sqrt(2 * r))
    rows.append(("sigma0", "1", networks, *described(e, sd, within, (e / sd) ** 2)))
    w = collected("standardized")
    within = np.abs(w) < scipy.stats.norm.ppf(0.975)
    one = np.array(1.0)
    title = "standardised residuals, w"  # Baarda: sigma0 = 1 is given
    rows.append((title, "1", networks, *described(w, one, within, w**2)))
    for title, quiet, expected in (
        (f"|w| below {ALARM}", np.abs(w) < ALARM, 99.9),
        (
            f"networks with all |w| below {ALARM}",
            np.all(np.abs(w) < ALARM, axis=(1, 2)),
            100 * 0.999 ** w[0].size,  # if they were independent
        ),
    ):
        rows.append((title, "", networks, *BLANK, *rate(quiet, expected), ""))
    return rows


def described(e, sd, within, squares) -> tuple[str, ...]:
    """Predicted and sampled sd, their ratio, bias, coverage, mean square."""
    sampled, predicted = np.sqrt(np.mean(e**2)), np.sqrt(np.mean(sd**2))
    return (
        *(f"{predicted:.3g}", f"{sampled:.3g}", f"{sampled / predicted:.3f}"),
        *(f"{np.mean(e / sd):.3f}", *rate(within, 95, squares)),
    )


def rate(within, expected: float, squares=None) -> tuple[str, ...]:
    """Found and expected percentage, and the mean square if there is one."""
    found = f"{100 * np.mean(within):.2f}", f"{expected:.1f}"
    return found if squares is None else (*found, f"{np.mean(squares):.3f}")


def control(size: float, networks: int = 50) -> list[tuple]:
    """Rows of the second table: one of four control points is wrong by `size` in mm.

    In any direction, another one in each network. Errors are those of the 46 points
    that are no control points, so that what control is does not count.
    """
    truth = true_network()
    X = truth.points
    others = np.setdiff1d(np.arange(len(X)), CORNERS)
    minimum = np.full((4, 3), np.inf)  # seven coordinates: nothing contradicts them
    minimum[:2] = 0
    minimum[2, _across(X[CORNERS[:3]])] = 0
    sigmas = {
        "four points fixed": 0.0,
        "four points of 0.1 mm": 0.1,
        "seven coordinates fixed": minimum,
    }
    rng = np.random.default_rng([67, round(1000 * size)])
    collected = {name: [] for name in (*sigmas, "free, then transformed")}
    for net in measured(truth, networks, 1):
        given = X[CORNERS].copy()
        direction = rng.normal(size=3)
        given[0] += size * direction / np.linalg.norm(direction)
        for name, sigma in sigmas.items():
            held = replace(net, control=(CORNERS, given, sigma))
            one = bundle.adjust(held, sigma0_prior=1.0)
            own = numbers(one, truth, one.points, one.covariance_points, others)
            free = np.isfinite(np.broadcast_to(sigma, (4, 3)))
            collected[name].append((*own, np.abs(one.control_residuals[free]).max()))
        one = bundle.adjust(net, sigma0_prior=1.0)
        moved = absolute(one.points[CORNERS], given)
        C = moved.apply_covariance(one.points) + one.covariance_points
        own = numbers(one, truth, moved.apply(one.points), C, others)
        collected["free, then transformed"].append(
            (*own, np.abs(moved.residuals).max())
        )
    return [
        (name, size, networks, *(f"{value:.3g}" for value in rms(values)))
        for name, values in collected.items()
    ]


def _across(corners: np.ndarray) -> int:
    """The axis most nearly at right angles to a triangle."""
    a, b, c = corners
    return int(np.argmax(np.abs(np.cross(b - a, c - a))))


def numbers(one, truth, points, C, others) -> tuple[float, ...]:
    """sigma0, error and sd of c, and of the points as root mean square, largest w."""
    e = points - truth.points
    return (
        *(one.sigma0, one.cameras[0].c - truth.cameras[0].c, one.sd_interior[0]),
        np.sqrt(np.mean(e[others] ** 2)),
        np.sqrt(np.mean(np.diagonal(C[others], axis1=1, axis2=2))),
        np.abs(one.standardized).max(),
    )


def rms(values: list[tuple]) -> np.ndarray:
    """Root mean square of each column."""
    return np.sqrt(np.mean(np.square(values), axis=0))


if __name__ == "__main__":
    study.write("ch06", "precision", COLUMNS, precision())
    rows = [row for size in (0.0, 0.1, 1.0) for row in control(size)]
    study.write("ch06", "control", CONTROL_COLUMNS, rows)
