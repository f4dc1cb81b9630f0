"""Models of a stereo pair from no start, and which of them fit."""

import numpy as np

from pgm_lab import rotation
from pgm_lab.orientation import _model, coplanarity
from pgm_lab.orientation._ambiguity import largest_objective

# Where the search starts: tilts of the right photo (degrees), each in so many
# directions and turned about its axis in so many steps.
TILTS = {0: 1, 35: 6, 70: 10, 105: 10}
SWINGS = 8

# A given start is tried as it is, and turned by so much (radians) about each axis.
AROUND_START = 0.4

# Search on so many points, with so many iterations in each step; try so many models at
# first and keep so many. Five or six points have many solutions, and all are wanted.
POINTS = 12
ITERATIONS = (8, 15, 10)
FEW = 6
KEPT = (100, 12, 6)
KEPT_OF_FEW = (216, 30, 20)

# Models are the same when rotation and base direction differ by less (radians).
SAME_MODEL = 1e-3

# vᵀPv of two models differ by chance less than this quantile of their ratio.
LEVEL = 0.999

# The base has the wrong sign if models with all points behind both cameras fit so many
# times better: points in a plane have such models too, which may fit a little better.
WRONG_SIGN = 100

# Models whose residuals after the first step are a larger part of the principal
# distance are dropped, unless the best one has such residuals.
HOPELESS = 2e-3
HOPELESS_OF_FEW = 0.1

# Cosine between base and x axis below which bx is too small to hold the scale.
ACROSS = 1e-3

# Residuals below this part of the principal distance are rounding.
ROUNDING = 1e-9

Models = tuple[np.ndarray, np.ndarray]  # base (k, 3) and rotation (k, 3, 3)


def models(
    bx: float, left: np.ndarray, right: np.ndarray, near: Models | None = None
) -> Models:
    """Base (k, 3) and rotation (k, 3, 3) of models to rays left and right (n, 3).

    A grid of rotations, each with the base that suits it best, is adjusted to a few
    points at once, then the best of them that differ to all points. The grid lies all
    around, or around the rotation of `near`, whose bases are tried too.
    """
    few = len(left) <= FEW
    some = _spread(left, POINTS)
    R = rotation_grid() if near is None else _around(near[1][0])
    base = base_for(R, left[some], right[some], bx)
    if near is not None:
        given = [np.broadcast_to(one, base.shape) for one in near[0]]
        R = np.concatenate([R] * (1 + len(given)))
        base = np.concatenate([base, *given])
    first, second, last = KEPT_OF_FEW if few else KEPT
    misfit = coplanarity.distances(base, R, left[some], right[some]).distance
    start = np.argsort(np.sum(misfit**2, axis=-1))[:first]
    base, R = base[start], R[start]
    base, R = _hopeful(base, R, left[some], right[some], second)
    base, R = _converged(base, R, left[some], right[some], ITERATIONS[1], last)
    if len(left) > len(some):
        base, R = _converged(base, R, left, right, ITERATIONS[2], last)
    return base, R


def in_front(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray
) -> Models:
    """The models with the base turned round where points lie behind both cameras.

    The base and its opposite fit equally well: only the side of the points differs.
    """
    model = _model.intersect(base, R, left, right)
    behind = np.sum(model.behind_both, axis=-1) > np.sum(model.in_front, axis=-1)
    return np.where(behind[:, None], -base, base), R


def best(
    base: np.ndarray,
    R: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    sigma: float | None,
    near: Models | None = None,
) -> Models:
    """Those of the models that fit the points equally well, the best one first.

    With a model `near` the one with the most similar rotation is first.
    """
    model = _model.intersect(base, R, left, right)
    misfit = np.sum(model.conditions.distance**2, axis=-1)
    front = np.mean(model.in_front, axis=-1)
    behind = np.mean(model.behind_both, axis=-1)
    upright, upside_down = front > 0.5, behind > 0.5
    plausible = upright | upside_down
    if not plausible.any():
        least = [np.argmin(misfit)]
        return base[least], R[least]
    least = np.min(misfit[upright], initial=np.inf)
    if least > WRONG_SIGN * _limit(misfit[plausible].min(), left, sigma):
        raise ValueError(
            f"base = {base[0, 0]:g} has the wrong sign: the points would lie behind"
            f" both cameras. Write base = {-base[0, 0]:g}, or leave base out to have"
            " its sign found"
        )
    fits = upright & (misfit <= _limit(least, left, sigma))
    along = np.abs(base[:, 0]) > ACROSS * np.linalg.norm(base, axis=1)
    if np.any(fits & along):
        fits &= along
    fits &= front == front[fits].max()
    if near is not None:
        misfit = np.linalg.norm(R - near[1][0], axis=(-2, -1))
    order = np.lexsort((misfit, ~fits))[: np.count_nonzero(fits)]
    return base[order], R[order]


def _limit(best: float, left: np.ndarray, sigma: float | None) -> float:
    """Sum of squares up to which a model fits as well as the best one."""
    redundancy = len(left) - 5
    rounding = len(left) * (ROUNDING * left[0, 2]) ** 2
    if redundancy:
        best = largest_objective(best, redundancy, sigma, LEVEL)
    return best + rounding


def _hopeful(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray, count: int
) -> Models:
    """First step: adjust roughly and keep what may still come near the best one."""
    result, base, R = _model.fit(base, R, left, right, max_iterations=ITERATIONS[0])
    misfit = np.sum(result.residuals**2, axis=-1)
    hopeless = HOPELESS_OF_FEW if len(left) <= FEW else HOPELESS
    hopeless = len(left) * (hopeless * left[0, 2]) ** 2
    kept = misfit <= max(1e4 * np.nanmin(misfit, initial=np.inf), hopeless)
    return _first_that_differ(base[kept], R[kept], left, right, misfit[kept], count)


def _converged(
    base: np.ndarray,
    R: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    iterations: int,
    count: int,
) -> Models:
    """Later steps: adjust and keep what has converged, or is better all the same."""
    result, base, R = _model.fit(base, R, left, right, max_iterations=iterations)
    misfit = np.sum(result.residuals**2, axis=-1)
    kept = result.status == "converged"
    # In weak geometry the best one may be slow
    kept |= misfit < np.min(misfit[kept], initial=np.inf)
    return _first_that_differ(base[kept], R[kept], left, right, misfit[kept], count)


def _first_that_differ(
    base: np.ndarray,
    R: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    misfit: np.ndarray,
    count: int,
) -> Models:
    """So many models that differ, those with the points on one side first."""
    if not len(base):
        raise ValueError(
            "no model was found: the points do not determine the five unknowns. Are"
            " they spread over the common area, and in the same order in both photos?"
        )
    model = _model.intersect(base, R, left, right)
    # In front of both cameras or, if the base has the wrong sign, behind both
    one_side = np.mean(model.in_front | model.behind_both, axis=-1) > 0.5
    first = different(base, R, np.lexsort((misfit, ~one_side)))[:count]
    return base[first], R[first]


def different(base: np.ndarray, R: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Those of the models in `order` that differ from all before them."""
    b = base / np.linalg.norm(base, axis=-1, keepdims=True)
    apart = np.linalg.norm(b[:, None] - b, axis=-1)
    apart = apart + np.linalg.norm(R[:, None] - R, axis=(-2, -1))
    near = (apart < SAME_MODEL)[np.ix_(order, order)]
    return order[~np.any(np.tril(near, -1), axis=1)]


def _spread(left: np.ndarray, count: int) -> np.ndarray:
    """Indices of some points, in all directions from the middle of the photo."""
    from_middle = left[:, :2] - left[:, :2].mean(axis=0)
    order = np.argsort(np.arctan2(from_middle[:, 1], from_middle[:, 0]))
    count = min(count, len(left))
    return order[np.linspace(0, len(left) - 1, count).round().astype(int)]


def rotation_grid() -> np.ndarray:
    """Rotations (k, 3, 3), image to object, some 40 degrees apart."""
    tilt = np.radians(np.repeat(list(TILTS), list(TILTS.values())))
    azimuth = np.concatenate(
        [np.arange(k) * 2 * np.pi / k + 0.1 for k in TILTS.values()]
    )
    swing = np.arange(SWINGS) * 2 * np.pi / SWINGS
    M = rotation.from_tilt_azimuth_swing(
        tilt[:, None], azimuth[:, None], swing + azimuth[:, None]
    )
    return np.swapaxes(M.reshape(-1, 3, 3), -1, -2)


def _around(R: np.ndarray) -> np.ndarray:
    """R (3, 3) and R turned about each axis either way, (7, 3, 3)."""
    turns = AROUND_START * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
    return rotation.matrix(*turns.T) @ R


def base_for(
    R: np.ndarray, left: np.ndarray, right: np.ndarray, bx: float
) -> np.ndarray:
    """For each rotation the base most nearly at right angles to all u' x u''."""
    u1 = left / np.linalg.norm(left, axis=-1, keepdims=True)
    u2 = right / np.linalg.norm(right, axis=-1, keepdims=True) @ np.swapaxes(R, -1, -2)
    n = np.cross(u1, u2)
    b = np.linalg.eigh(np.swapaxes(n, -1, -2) @ n)[1][..., 0]
    along = np.where(np.abs(b[..., :1]) < 0.1, np.copysign(0.1, b[..., :1]), b[..., :1])
    return bx * np.concatenate([np.ones_like(along), b[..., 1:] / along], axis=-1)
