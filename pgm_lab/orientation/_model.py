"""The adjustment of a stereo model, from many starts at once or from one."""

from dataclasses import dataclass

import numpy as np

from pgm_lab import imaging, rotation
from pgm_lab.adjustment import adjust
from pgm_lab.orientation import _turns, coplanarity, scale_factors

NAMES = ("by", "bz", "turn about X", "turn about Y", "turn about Z")

# Where the search starts: tilts of the right photo (degrees), each in so many
# directions and turned about its axis in so many steps.
TILTS = {0: 1, 35: 6, 70: 10, 105: 10}
SWINGS = 8
SEARCH_POINTS = 12
SEARCH_ITERATIONS = 12
CANDIDATES = 12

# Models are the same when rotation and base direction differ by less (radians).
SAME_MODEL = 1e-3


def fit(bx, base, R, left, right, sigma=None, max_iterations=50):
    """Adjust (by, bz) and the rotation of the right photo to rays left, right (n, 3).

    Starts from base (..., 2), R (..., 3, 3). Returns the adjustment, base (..., 3), R.
    """
    base, R = np.asarray(base, float), np.asarray(R, float)
    start = np.concatenate([base, np.zeros((*base.shape[:-1], 3))], axis=-1)

    def distances(x, R0):
        # Small turns of the start: unlike angles they have no gimbal lock
        found = coplanarity.distances(_base(bx, x), _turned(x, R0), left, right)
        by_turns = found.by_turns @ _turns.axes(x[..., 2:])
        A = np.concatenate([found.by_base[..., 1:], by_turns], axis=-1)
        return found.distance, A

    result = adjust(
        distances,
        start,
        np.zeros(len(left)),
        sigma0_prior=sigma,
        args=(R,),
        names=NAMES,
        max_iterations=max_iterations,
    )
    x = result.x
    bad = ~np.isfinite(x).all(axis=-1)
    x = np.where(bad[..., None], start, x)
    return result, _base(bx, x), _turned(x, R)


def _base(bx, x):
    return np.concatenate([np.full((*x.shape[:-1], 1), bx), x[..., :2]], axis=-1)


def _turned(x, R0):
    return np.swapaxes(rotation.matrix(*np.moveaxis(x[..., 2:], -1, 0)), -1, -2) @ R0


@dataclass(frozen=True)
class Model:
    """Points (..., n, 3) of a model, and on which side of the cameras they lie."""

    conditions: coplanarity.Coplanarity
    points: np.ndarray
    in_front: np.ndarray
    behind_both: np.ndarray
    parallel: np.ndarray


def intersect(base, R, left, right) -> Model:
    """Intersect the corrected rays, which meet."""
    found = coplanarity.distances(base, R, left, right)
    u1 = coplanarity.corrected(left, found.left)
    u2 = coplanarity.corrected(right, found.right) @ np.swapaxes(R, -1, -2)
    factors, parallel = scale_factors.nearest(base[..., None, :], u1, u2)
    return Model(
        conditions=found,
        points=factors[..., :1] * u1,
        in_front=np.all(factors > 0, axis=-1),
        behind_both=np.all(factors < 0, axis=-1),
        parallel=parallel,
    )


def points_cofactor(base, R, left, right, Q) -> np.ndarray:
    """Cofactors (n, 3, 3) of the points from those (5, 5) of the orientation.

    The collinearity equations of all points have the same solution; there one point
    is N_pp^-1 + N_pp^-1 N_pe Q N_ep N_pp^-1.
    """
    points = intersect(base, R, left, right).points
    away = points - base
    by_left = imaging.perspective(-left[0, 2], points)[2]
    by_right = imaging.perspective(-right[0, 2], away @ R)[2] @ R.T
    # A turn psi of the photo moves the point, seen from it, by -psi x away
    by_turns = by_right @ _turns.cross_matrix(away)
    by_orientation = np.concatenate([-by_right[..., 1:], by_turns], axis=-1)
    across = np.swapaxes(by_right, -1, -2)
    N = np.swapaxes(by_left, -1, -2) @ by_left + across @ by_right
    N_inverse = np.linalg.inv(N)
    G = N_inverse @ across @ by_orientation
    return N_inverse + G @ Q @ np.swapaxes(G, -1, -2)


def search(bx, left, right):
    """Find models from no start; those with the points in front of both cameras first.

    A grid of rotations, each with the base that suits it best, is followed on a few
    points, then the best different models on all of them. Returns base (k, 3) and
    R (k, 3, 3).
    """
    some = _spread(left, SEARCH_POINTS)
    R = rotation_grid()
    base = base_for(R, left[some], right[some], bx)
    result, base, R = fit(
        bx, base, R, left[some], right[some], max_iterations=SEARCH_ITERATIONS
    )
    misfit = np.sum(result.residuals**2, axis=-1)
    misfit = np.where(np.isfinite(misfit), misfit, np.inf)
    sides = intersect(base, R, left[some], right[some])
    # In front of both cameras or, if the base has the wrong sign, behind both
    one_side = np.mean(sides.in_front | sides.behind_both, axis=-1) > 0.5
    best = different(base, R, np.lexsort((misfit, ~one_side)))[:CANDIDATES]
    result, base, R = fit(bx, base[best, 1:], R[best], left, right)
    misfit = np.where(
        result.status == "converged", np.sum(result.residuals**2, axis=-1), np.inf
    )
    best = different(base, R, np.argsort(misfit))
    best = best[np.isfinite(misfit[best])]
    return base[best], R[best]


def different(base, R, order) -> np.ndarray:
    """Those of the models in `order` that differ from all before them."""
    b = base / np.linalg.norm(base, axis=-1, keepdims=True)
    apart = np.linalg.norm(b[:, None] - b, axis=-1)
    apart = apart + np.linalg.norm(R[:, None] - R, axis=(-2, -1))
    near = (apart < SAME_MODEL)[np.ix_(order, order)]
    first = np.argmax(near, axis=1) == np.arange(len(order))
    return order[first]


def _spread(left, count) -> np.ndarray:
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


def base_for(R, left, right, bx):
    """For each rotation the base most nearly at right angles to all u' x u''."""
    u1 = left / np.linalg.norm(left, axis=-1, keepdims=True)
    u2 = right / np.linalg.norm(right, axis=-1, keepdims=True) @ np.swapaxes(R, -1, -2)
    n = np.cross(u1, u2)
    b = np.linalg.eigh(np.swapaxes(n, -1, -2) @ n)[1][..., 0]
    along = np.where(np.abs(b[..., :1]) < 0.1, np.copysign(0.1, b[..., :1]), b[..., :1])
    return bx * b[..., 1:] / along
