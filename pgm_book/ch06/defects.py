"""Self-calibrating bundle adjustment, dense, with one defect put in at a time.

The adjustment is that of Muliawan 2013, (M 2.78) to (M 2.95), as `bundle.dense` has it.
A printed formula or a property of the printed program can be put in by its name, to see
what it costs. For measuring use `bundle.adjust`.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_book.ch06 import published
from pgm_lab.bundle import dense
from pgm_lab.bundle.dense import scaled as scaled  # so it is called in chapter 6
from pgm_lab.camera import imaging

DEFECTS = {
    "sign": "A3 with the sign reversed, as (M 2.89): its parameters go the wrong way",
    "short": "columns of c, x0, y0 without the distortion, as (M 2.89)",
    "rho": "rho where rho^2 belongs in the columns of P1, P2: (M 2.89) alone",
    "rows": "A3 takes row j of the table of image points for point j, in every photo",
    "x/c": "x/c and y/c are added to the misclosure",
    "centre twice": "x0 and y0 are subtracted twice in the misclosure",
    "2 P1 xy": "the misclosure of y lacks 2 P1 xy",
    "pinv": "pinv of the matrix as it is, with the tolerance of MATLAB",
    "pinv of NumPy": "the same with 1e-15 of the largest singular value (to compare)",
    "stop": "ends when the sum of all |corrections| is not below the last one, or 10",
    "unweighted": "S0 in mm, from residuals without weights, for cofactors with them",
    "redundancy": "observations - 6m - 3n: without ten parameters and seven conditions",
    "ten places": "accuracies of the points are read ten places too early",
}
PROGRAM = tuple(name for name in DEFECTS if name not in ("rho", "pinv of NumPy"))

State = tuple[np.ndarray, np.ndarray, np.ndarray]  # interior, exteriors, points

_STILL = 1e-7  # mm: a step that moves no image point by more is the last
_FAR = 1e3  # mm: a metre, in an image of two centimetres


@dataclass(frozen=True)
class Run:
    """An adjustment, step by step; axis 0 of the states begins with the start values.

    Attributes
    ----------
    interior, exteriors, points : ndarray (steps + 1, 10), (..., m, 6), (..., n, 3)
        In the order of `camera.PARAMETERS`, (X0, Y0, Z0, omega, phi, kappa), (X, Y, Z).
    rms, own_rms : ndarray (steps + 1,)
        RMS of an image coordinate, mm: by the right misclosure; with its defects.
    corrections : ndarray (steps,)
        Sums of all |corrections|, mm and radians together, as the listing has them.
    kept : int
        Singular values that the last solution kept; all when it was regular.
    sigma0 : float
    sd_interior, sd_exteriors, sd_points : ndarray (10,), (m, 6), (n, 3)
        As the run itself gives them, with its defects; NaN for a negative variance.
    status : str
        "converged"; "stopped" by the rule of the listing; "diverged"; "not converged".
    """

    interior: np.ndarray
    exteriors: np.ndarray
    points: np.ndarray
    rms: np.ndarray
    own_rms: np.ndarray
    corrections: np.ndarray
    kept: int
    sigma0: float
    sd_interior: np.ndarray
    sd_exteriors: np.ndarray
    sd_points: np.ndarray
    status: str


def network(order: str = "photo") -> tuple[np.ndarray, ...]:
    """Start values and image points of Muliawan 2013, as `adjust` takes them.

    They are (interior, exteriors, points, photo, point, xy). The image points stand by
    "photo", as in Tables 4.4 to 4.12, or by "point", then photo: it matters to "rows".
    """
    net = published.network()
    photo, point = net.photo, net.point
    rows = np.lexsort((photo, point) if order == "point" else (point, photo))
    start = net.interior[0], net.exteriors, net.points
    return *start, photo[rows], point[rows], net.xy[rows]


def adjust(
    interior: ArrayLike,
    exteriors: ArrayLike,
    points: ArrayLike,
    photo: ArrayLike,
    point: ArrayLike,
    xy: ArrayLike,
    defects: Iterable[str] = (),
    *,
    sigma: float = 0.001,
    max_iterations: int = 50,
) -> Run:
    """Adjust a free network with self-calibration, with the defects that are asked for.

    Parameters
    ----------
    interior : array_like (10,)
        Start values of `camera.PARAMETERS`, lens "backward".
    exteriors, points : array_like (m, 6), (n, 3)
        Start values; the object points carry the seven inner constraints.
    photo, point : array_like (k,) of int
        Photo and point of each image point.
    xy : array_like (k, 2)
        Image points as measured, in mm.
    defects : iterable of str
        Names out of `DEFECTS`, such as `PROGRAM`; without any it is correct.
    sigma : float
        Standard deviation of an image coordinate, in mm.
    max_iterations : int
        Most steps, 1 or more. All are full steps.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        If a defect is unknown.

    References
    ----------
    Muliawan 2013, (M 2.78) to (M 2.95) and the listings, here in our own words.

    Examples
    --------
    >>> right = adjust(*network())
    >>> print(right.status, f"{1000 * right.rms[-1]:.2f} micrometres")
    converged 0.31 micrometres
    >>> print(adjust(*network(), ["sign"]).status)
    diverged
    """
    defects = set(defects)
    if unknown := defects - DEFECTS.keys():
        raise ValueError(f"{min(unknown)} is none of the defects {', '.join(DEFECTS)}")
    start = np.asarray(interior, float), np.asarray(exteriors, float)
    state = *start, np.asarray(points, float)
    image = np.asarray(photo), np.asarray(point), np.asarray(xy, float)
    states, status = [state], "not converged"
    sums: list[float] = []
    v, right = [misclosure(*state, *image, defects)], [misclosure(*state, *image)]
    while status == "not converged" and len(sums) < max_iterations:
        A = design(*state, *image, defects)
        Q, kept = inverse(normal_matrix(A, state[2], sigma), defects)
        delta = Q[:, :-7] @ (A.T @ -v[-1].ravel()) / sigma**2  # (M 2.94)
        state = _corrected(state, delta)
        states.append(state)
        sums.append(np.abs(delta).sum())
        v.append(misclosure(*state, *image, defects))
        right.append(misclosure(*state, *image))
        status = _status(v, sums, defects)
    interiors, all_exteriors, all_points = map(np.array, zip(*states, strict=True))
    rms, own_rms = (np.sqrt(np.mean(np.square(w), axis=(1, 2))) for w in (right, v))
    accuracies = _accuracies(v[-1], Q, state, sigma, defects)
    history = interiors, all_exteriors, all_points, rms, own_rms, np.array(sums)
    return Run(*history, kept, *accuracies, status)


def misclosure(
    interior: np.ndarray,
    exteriors: np.ndarray,
    points: np.ndarray,
    photo: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    defects: Iterable[str] = (),
) -> np.ndarray:
    """Computed minus observed (k, 2), in mm: -f of (M 2.86)."""
    v, *_ = imaging.misclosure(
        interior, exteriors[photo], points[point], xy, "backward", ()
    )
    reduced = xy - interior[1:3]
    if "x/c" in defects:
        v = v + reduced / interior[0]
    if "centre twice" in defects:
        v = v + interior[1:3]
    if "2 P1 xy" in defects:
        v = v + reduced.prod(axis=1, keepdims=True) * (0, 2 * interior[6])
    return v


def design(
    interior: np.ndarray,
    exteriors: np.ndarray,
    points: np.ndarray,
    photo: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    defects: Iterable[str] = (),
) -> np.ndarray:
    """Derivatives of the misclosure (2 k, 6 m + 10 + 3 n): A1, A3, A2 of (M 2.78)."""
    if "rows" in defects:
        xy = xy[point]  # A1 and A2 do not depend on it
    _, A1, A3, A2 = dense.derivatives(interior, exteriors, points, photo, point, xy)
    reduced = xy - interior[1:3]
    if "short" in defects:
        A3[..., 0] = reduced / interior[0]
        A3[..., 1:3] = np.eye(2)
    if "rho" in defects:
        rho = np.hypot(*reduced.T)
        A3[:, [0, 1], [6, 7]] += (rho**2 - rho)[:, None]
    if "sign" in defects:
        A3 = -A3
    return dense.design(A1, A3, A2, photo, point, len(exteriors), len(points))


def normal_matrix(A: np.ndarray, points: np.ndarray, sigma: float) -> np.ndarray:
    """N of (M 2.94): the normal matrix of all, bordered by G at the points."""
    return dense.bordered(dense.normal_matrix(A, sigma), dense.G(points))


def tolerance(N: np.ndarray, defects: Iterable[str] = ()) -> float:
    """Singular values up to here count as zero: MATLAB's rule, or 1e-15 of the norm."""
    norm = np.linalg.norm(N, 2)
    relative = 1e-15 * norm if "pinv of NumPy" in defects else len(N) * np.spacing(norm)
    return float(relative)


def inverse(N: np.ndarray, defects: Iterable[str] = ()) -> tuple[np.ndarray, int]:
    """Invert a bordered N; the second number is of the singular values kept.

    Without "pinv" it is scaled first, and regular: nothing has to be dropped.
    """
    if {"pinv", "pinv of NumPy"} & set(defects):
        # np.linalg.svd loses digits
        s, U, V, scale, *_ = scipy.linalg.lapack.dgejsv(N, joba=2)
        s *= scale[0] / scale[1]
        kept = int(np.sum(s > tolerance(N, defects)))
        return (V[:, :kept] / s[:kept]) @ U[:, :kept].T, kept
    return dense.inverse(N), len(N)


def _corrected(state: State, delta: np.ndarray) -> State:
    """O + delta1, the ten parameters + delta3, X + delta2: (M 2.79)."""
    interior, exteriors, points = state
    d1, d3, d2 = np.split(delta[:-7], [exteriors.size, exteriors.size + 10])
    d1 = d1.reshape(exteriors.shape)[:, dense.ANGLES_FIRST]
    return interior + d3, exteriors + d1, points + d2.reshape(points.shape)


def _status(
    v: Sequence[np.ndarray], sums: list[float], defects: Collection[str]
) -> str:
    """Say whether the run ends here, by the image or by the rule of the listing."""
    if not np.sqrt(np.mean(v[-1] ** 2)) < _FAR:
        return "diverged"
    if "stop" in defects:
        if sums[-1] < 1e-5:
            return "converged"
        return "not converged" if sums[-1] < ([10.0] + sums)[-2] else "stopped"
    still = np.abs(v[-1] - v[-2]).max() < _STILL
    return "converged" if still else "not converged"


def _accuracies(
    v: np.ndarray, Q: np.ndarray, state: State, sigma: float, defects: Collection[str]
) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Sigma0, and standard deviations in the shapes of interior, exteriors, points."""
    _, exteriors, points = state
    redundancy = v.size - len(Q) + 14  # Q counts the seven multipliers as well
    if "redundancy" in defects:
        redundancy = v.size - exteriors.size - points.size
    unit = 1.0 if "unweighted" in defects else sigma
    sigma0 = float(np.sqrt((v**2).sum() / redundancy) / unit)
    sd = sigma0 * np.sqrt(np.where(np.diagonal(Q) < 0, np.nan, np.diagonal(Q)))
    own, other = exteriors.size, exteriors.size + 10
    first = own if "ten places" in defects else other
    sd_exteriors = sd[:own].reshape(exteriors.shape)[:, dense.ANGLES_FIRST]
    sd_points = sd[first:][: points.size].reshape(points.shape)
    return sigma0, sd[own:other], sd_exteriors, sd_points
