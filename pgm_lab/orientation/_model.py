"""One stereo model: its adjustment, its points and their precision."""

from dataclasses import dataclass

import numpy as np

from pgm_lab import rotation
from pgm_lab.adjustment import Adjustment, adjust
from pgm_lab.camera import imaging
from pgm_lab.orientation import _turns, coplanarity, scale_factors

NAMES = ("by", "bz", "turn about X", "turn about Y", "turn about Z")


def fit(
    base: np.ndarray,
    R: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    sigma: float | None = None,
    max_iterations: int = 50,
) -> tuple[Adjustment, np.ndarray, np.ndarray]:
    """Adjust (by, bz) and the rotation of the right photo to rays left, right (n, 3).

    Starts from base (..., 3) and R (..., 3, 3), which keep their shapes on return; all
    models have the same bx.
    """
    bx = base.flat[0]
    # Counted from c instead of zero, because the adjustment takes the size of the
    # observations for that of the numbers which were rounded
    c = -left[0, 2]
    start = np.concatenate([base[..., 1:], np.zeros_like(base)], axis=-1)

    def distances(x, R0):
        # Small turns of the start: unlike angles they have no gimbal lock
        found = coplanarity.distances(_base(bx, x), _turned(x, R0), left, right)
        by_turns = found.by_turns @ _turns.axes(x[..., 2:])
        A = np.concatenate([found.by_base[..., 1:], by_turns], axis=-1)
        return c + found.distance, A

    result = adjust(
        distances,
        start,
        np.full(len(left), c),
        sigma0_prior=sigma,
        args=(R,),
        names=NAMES,
        max_iterations=max_iterations,
    )
    finite = np.isfinite(result.x).all(axis=-1, keepdims=True)
    x = np.where(finite, result.x, start)
    return result, _base(bx, x), _turned(x, R)


def _base(bx: float, x: np.ndarray) -> np.ndarray:
    return np.concatenate([np.full((*x.shape[:-1], 1), bx), x[..., :2]], axis=-1)


def _turned(x: np.ndarray, R0: np.ndarray) -> np.ndarray:
    return np.swapaxes(rotation.matrix(*np.moveaxis(x[..., 2:], -1, 0)), -1, -2) @ R0


@dataclass(frozen=True)
class Model:
    """Points (..., n, 3) of a model, and on which side of the cameras they lie."""

    conditions: coplanarity.Coplanarity
    points: np.ndarray
    in_front: np.ndarray
    behind_both: np.ndarray
    parallel: np.ndarray


def intersect(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray
) -> Model:
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


def points_cofactor(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray, Q: np.ndarray
) -> np.ndarray:
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
