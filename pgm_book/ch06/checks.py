"""Checks of the exercises of chapter 6, self-calibrating bundle adjustment."""

from collections.abc import Callable, Sequence
from unittest import mock

import numpy as np

from pgm_book.common.checks import (
    CheckFailed,
    answer_of,
    call,
    chance,
    first_slip,
    near,
    report,
    shaken,
    varied,
)
from pgm_book.program import bundle as textbook
from pgm_lab import datasets

# Rays, photos, points, parameters, held control points
_NETWORKS = (
    (450, 9, 50, 10, 0),
    (450, 9, 50, 10, 4),
    (120, 4, 30, 0, 0),
    (310, 7, 61, 8, 5),
)

_DIVERGES = (
    "the steps diverge: compare s with the right side of the reduced equations; f and"
    " g contain their minus already"
)


def _other_networks(rng: np.random.Generator) -> tuple:
    """Networks like those above: what is 0 there stays 0."""
    fewer = (rng.integers(1, 6) for _ in range(5))
    more = np.array([(11 * k, k, 2 * k, k % 3 - 1, k % 3 - 1) for k in fewer])[:4]
    return tuple(
        map(tuple, (np.array(_NETWORKS) + more * (np.array(_NETWORKS) > 0)).tolist())
    )


def redundancy(function: Callable) -> None:
    """Check the reader's redundancy(rays, photos, points, parameters, held)."""
    networks = varied(61, _NETWORKS, _other_networks)
    answers = np.array([float(call(function, *case, shape=())) for case in networks])
    rays, photos, points, parameters, held = np.array(networks, dtype=float).T
    free = 7.0 * (held == 0)
    expected = 2 * rays - parameters - 6 * photos - 3 * (points - held) + free
    slips = [
        (expected - rays, "a ray gives two observations, x and y"),
        (expected - 2 * free, "a constraint adds to the redundancy: its sign"),
        (expected - free, "without control the inner constraints are missing"),
        (expected - free + 7, "with held control there are no inner constraints"),
        (
            expected - free + 7 - held,
            "right for 2013; but with held points no inner constraint is needed at"
            " all, not fewer of them",
        ),
        (expected - 3 * held, "held points are still counted as unknowns"),
        (
            expected - 3 * held - free + 7,
            "held points are still counted as unknowns, and constraints come on top",
        ),
        (expected - 6 * held, "held points mean fewer unknowns: check the sign"),
        (expected + 2 * held, "a held point is three coordinates, not one"),
        (expected - 2 * held, "a held point is three coordinates, not one"),
        (expected + parameters, "the parameters of the camera are missing"),
        (
            expected + parameters - parameters * photos,
            "all photos are from one camera: its parameters count once",
        ),
        (expected + 6 * photos, "the six unknowns of a photo are missing"),
        (expected + 3 * photos, "a photo has six unknowns: position and attitude"),
        (expected + points - held, "a point has three coordinates"),
    ]
    known = near(answers[0], expected[0])
    other = "the observations, unknowns or constraints are miscounted"
    if known:
        other = "right for the network of 2013, but not for any: use all arguments"
        if near(answers[held == 0], expected[held == 0]):
            other = "right without held points, not with them"
    hint = first_slip(answers, slips, other)
    report(
        "redundancy",
        [
            ("the network of 2013", known, hint),
            ("any network", near(answers, expected) if known else None, hint),
        ],
    )


def reduced(function: Callable) -> None:
    """Check the reader's reduced(K, E, V), normal equations without the points."""
    rng = chance(62)
    J = rng.normal(size=(60, 7 + 3 * 5))
    J[:, 7:] *= np.kron(np.arange(60)[:, None] % 5 == np.arange(5), np.ones(3))
    N = J.T @ J
    K, E = N[:7, :7], N[:7, 7:].reshape(7, 5, 3).swapaxes(0, 1)
    V = np.array([N[i : i + 3, i : i + 3] for i in range(7, 22, 3)])
    expected = np.linalg.inv(np.linalg.inv(N)[:7, :7])  # by another method
    answer = call(function, K, E, V, shape=(7, 7))
    free = _free_network(function, J)
    one_point = call(function, K, E[:1], V[:1], shape=(7, 7))
    first = K - E[0] @ np.linalg.inv(V[0]) @ E[0].T
    by_points = E @ np.linalg.inv(V) @ E.swapaxes(1, 2)
    slips = [
        (K + by_points.sum(axis=0), "the sign: the part of the points is subtracted"),
        (by_points.sum(axis=0), "K is missing"),
        (K - (E @ V @ E.swapaxes(1, 2)).sum(axis=0), "V must be inverted"),
        (K - (E @ (1 / V) @ E.swapaxes(1, 2)).sum(axis=0), "1 / V is not the inverse"),
        (K - by_points[0], "all points take part, not the first alone"),
        (K - by_points[-1], "all points take part, not the last alone"),
        (K - by_points.mean(axis=0), "the sum over the points, not their mean"),
        (K - by_points.sum(), "the sum over the points alone, not over rows as well"),
        (
            K - E.sum(axis=0) @ np.linalg.inv(V.sum(axis=0)) @ E.sum(axis=0).T,
            "each point with its own E and V first, the sum over the points last",
        ),
        (np.linalg.inv(expected), "that is the inverse of it: leave it as equations"),
    ]
    other = "its solution is not that of the whole normal equations"
    hint = first_slip(answer, slips, other)
    symmetric = near(answer, answer.T, 1e-6)
    alone = near(one_point, first, 1e-6)
    whole = near(answer, expected, 1e-6)
    if whole and not alone:
        hint = "with a single point it is another matrix"
    elif not symmetric:
        hint = "it is not symmetric, and normal equations are"
    report(
        "reduced",
        [
            ("the same solution with fewer rows", whole and alone, hint),
            (
                "also in a free network",
                free if whole and alone else None,
                "a free network fails: its whole normal matrix is singular and has no"
                " inverse; invert the 3 × 3 blocks of the points alone",
            ),
            (
                "nothing larger than 3 × 3 is inverted",
                _small_blocks(function, K, E, V) if whole and alone and free else None,
                "right, but it inverts a matrix larger than 3 × 3, with three rows for"
                " each point: invert the small blocks, one by one or as a stack",
            ),
        ],
    )


def _small_blocks(
    function: Callable, K: np.ndarray, E: np.ndarray, V: np.ndarray
) -> bool:
    """Whether the function inverts blocks of points alone.

    A function in a box of its own, which says so by its attribute `boxed`, cannot be
    watched. There it gets 6000 points: the blocks are small, and the matrix of all
    points, of 2.6 GB, has no room.
    """
    if not getattr(function, "boxed", False):
        return _largest_inverted(function, K, E, V) <= 3
    rng = chance(64)
    many = rng.normal(size=(6000, 7, 3))
    own = rng.normal(size=(6000, 3, 3))
    own = own @ own.swapaxes(1, 2) + 3 * np.eye(3)
    try:
        found = call(function, K, many, own, shape=(7, 7))
    except CheckFailed:
        return False
    return near(found, textbook.reduced(K, many, own), 1e-6)


def _largest_inverted(function: Callable, *arguments: np.ndarray) -> int:
    """Rows of the largest matrix that the function inverts or solves with NumPy."""
    rows = [0]

    def watched(original: Callable) -> Callable:
        def watching(matrix: np.ndarray, *others: object, **named: object) -> object:
            rows.append(np.shape(matrix)[-1])
            return original(matrix, *others, **named)

        return watching

    names = ("inv", "pinv", "solve")
    solvers = {name: watched(getattr(np.linalg, name)) for name in names}
    with mock.patch.dict(vars(np.linalg), solvers):
        answer_of(function, *arguments)
    return max(rows)


def _free_network(function: Callable, J: np.ndarray) -> bool:
    """Whether the function eliminates points when the whole matrix is singular."""
    J = J.copy()
    J[:, 0] = J[:, 1:] @ np.linspace(-1, 1, J.shape[1] - 1)  # a motion no ray notices
    N = J.T @ J
    E = N[:7, 7:].reshape(7, 5, 3).swapaxes(0, 1)
    V = np.array([N[i : i + 3, i : i + 3] for i in range(7, 22, 3)])
    Q = np.linalg.qr(J[:, 7:])[0]
    rest = J[:, :7] - Q @ (Q.T @ J[:, :7])  # what the points cannot take up
    try:
        answer = call(function, N[:7, :7], E, V, shape=(7, 7))
    except CheckFailed:  # it did return something in the network before
        return False
    return near(answer, rest.T @ rest, 1e-6)


def _root(xy: np.ndarray, camera: np.ndarray) -> np.ndarray:
    """Ideal points by a program that takes ρ for ρ²."""
    _, x0, y0, K1, K2, K3, P1, P2, b1, b2 = camera
    x, y = (xy - (x0, y0)).T
    rho = np.hypot(x, y)
    radial = K1 * rho + K2 * rho**2 + K3 * rho**3
    dx = x * radial + P1 * (rho + 2 * x**2) + 2 * P2 * x * y + b1 * x + b2 * y
    dy = y * radial + P2 * (rho + 2 * y**2) + 2 * P1 * x * y
    return np.column_stack([x + dx, y + dy])


def without_lens(function: Callable) -> None:
    """Check without_lens(xy, camera), the ideal image points."""
    fixed = np.array([(3.0, 4.0), (-8.5, 2.0), (0.5, -6.0), (-4.0, -5.5)])
    xy = shaken(66, fixed)
    base = np.zeros(10)
    base[0] = 35.0
    fixed = np.array([35, 0.2, -0.1, 3e-5, -4e-7, 2e-9, 4e-6, -7e-6, 3e-4, -2e-4])
    full = shaken(67, fixed)
    answer = call(function, xy, full, shape=(4, 2))
    expected = textbook.without_lens(xy, full)

    def wrong(**changed: float | str) -> np.ndarray:
        """The answer with parameters negated, exchanged or left out."""
        names = ["c", "x0", "y0", "K1", "K2", "K3", "P1", "P2", "b1", "b2"]
        camera = full.copy()
        for name, by in changed.items():
            k = names.index(name)
            camera[k] = full[names.index(by)] if isinstance(by, str) else by * full[k]
        return textbook.without_lens(xy, camera)

    rho = np.hypot(*(xy - full[1:3]).T)[:, None]
    radial = full[3] * rho**2 + full[4] * rho**4 + full[5] * rho**6
    ideal = xy - full[1:3]
    slips = [
        (2 * ideal - expected, "the correction is added to the measured point"),
        (expected - ideal, "that is the correction alone; add it to the point"),
        (expected + full[1:3], "x0 and y0 are subtracted first, and stay subtracted"),
        (wrong(x0=0, y0=0), "the principal point is missing"),
        (_root(xy, full), "ρ² is x² + y², not the root of it"),
        (wrong(x0=-1, y0=-1), "x0 and y0 are subtracted, not added"),
        (wrong(P1="P2", P2="P1"), "P1 and P2 are exchanged"),
        (wrong(b1="b2", b2="b1"), "b1 and b2 are exchanged"),
        (wrong(K1="K2", K2="K1"), "K1 and K2 are exchanged"),
        (wrong(P1=0, P2=0), "the decentring, P1 and P2, is missing"),
        (wrong(b1=0, b2=0), "the affinity, b1 and b2, is missing"),
        (wrong(K3=0), "K3 is missing"),
        (
            expected - ideal * (radial - radial / rho),
            "x and y are multiplied by K1 ρ² and so on; ρ is not divided out",
        ),
        *((expected.round(k), "rounded; keep all digits") for k in (3, 4, 5, 6)),
    ]
    parts = []
    for k, name in enumerate(("K1", "K2", "K3", "P1", "P2", "b1", "b2"), 3):
        one = base.copy()
        one[k] = 1e3 ** (-1 - (k - 3)) if k < 6 else 1e-4
        mine = call(function, xy, one, shape=(4, 2))
        if not near(mine - xy, textbook.without_lens(xy, one) - xy, 1e-9):
            parts.append(name)
    other = f"the part of {', '.join(parts)} is wrong"
    if not parts:
        other = (
            "right if x0 and y0 are 0; with others x, y and ρ must all be counted from"
            " the principal point"
        )
    if not near(call(function, xy, base, shape=(4, 2)), xy):
        other = "a camera with all parameters zero but c must change nothing"
    hint = first_slip(answer, slips, other, 1e-9)
    report("without_lens", [("the ideal points", near(answer, expected, 1e-10), hint)])


def _adjusted(function: Callable, *arguments: object) -> Sequence:
    """What the reader's bundle returns; steps that diverge are called so."""
    try:
        return answer_of(function, *arguments, first="exercises 6.1 to 6.3")
    except CheckFailed as error:
        cause = error.__cause__
        if isinstance(cause, UnboundLocalError):  # its message names the variable
            raise CheckFailed(
                "bundle uses a name that has no value yet: the lines for s and sigma0"
                " are yours to write. Your turn!"
            ) from error
        gone = "must be positive" in str(cause) or "in front of" in str(cause)
        if gone or isinstance(cause, np.linalg.LinAlgError):
            raise CheckFailed(f"bundle: {_DIVERGES}") from error
        raise


def adjust(function: Callable) -> None:
    """Check bundle(photo, point, xy, sigma, camera, exteriors, points)."""
    data = datasets.muliawan2013()
    xy = varied(68, data.xy, lambda rng: data.xy + rng.normal(0, 5e-4, data.xy.shape))
    arguments = data.photo, data.point, xy, 0.001
    start = np.array(data.interior, float), data.exteriors, data.object_points
    answer = _adjusted(function, *arguments, *start)
    if not isinstance(answer, tuple | list) or len(answer) != 4:
        raise CheckFailed("bundle must return four things: camera, C, sigma0, points")
    camera, C, sigma0, points = (np.asarray(part, dtype=float) for part in answer)
    shapes = camera.shape, C.shape, sigma0.shape, points.shape
    if shapes != ((10,), (10, 10), (), (50, 3)):
        raise CheckFailed(
            "bundle must return shapes (10,), (10, 10), one number and (50, 3); got"
            f" {', '.join(map(str, shapes))}"
        )
    right, cofactors, s0, _ = textbook.adjust(*arguments, *start)
    sd = np.sqrt(np.diag(cofactors))
    off = np.abs(camera - right) / sd
    away = "the camera is not the best one: the iteration has not converged there"
    if near(camera, start[0]):
        away = "the camera stays at its start: add the step"
    elif not np.all(np.isfinite(camera)) or np.abs(camera[0] - 35) > 5:
        away = _DIVERGES
    variance = np.diag(C)
    hint = "C is not sigma0² times the cofactors of the camera"
    if near(variance / sd**2, 1 / s0**2, 1e-3):
        hint = "C lacks the factor sigma0²: these are cofactors"
    elif near(variance / sd**2, 1 / s0, 1e-3):
        hint = "C lacks a factor sigma0: it is to be squared"
    spread = "sigma0 is the root of the sum of v² over the redundancy"
    if near(sigma0, s0 * np.sqrt(693 / 900), 1e-4):
        spread = "the sum of v² is divided by the redundancy, not by all observations"
    elif near(sigma0, s0 * np.sqrt(693 / 686), 1e-4):
        spread = "seven unknowns are held: they are not unknowns any more"
    elif near(sigma0, s0 * np.sqrt(693 / 707), 1e-4):
        spread = "`held` of redundancy counts control points, and there are none here"
    elif near(sigma0, s0 * np.sqrt(693 / 1593), 1e-4):
        spread = "redundancy wants the rays, not their coordinates: len(xy)"
    elif near(sigma0, s0**2, 1e-4):
        spread = "take the root"
    found = bool(np.all(off < 0.02))
    good = near(sigma0, s0, 1e-4)
    few = data.photo < 6  # another redundancy: nothing of 2013 may be typed in
    arguments = data.photo[few], data.point[few], xy[few], 0.001
    start = start[0], data.exteriors[:6], data.object_points
    again = found and good and float(_adjusted(function, *arguments, *start)[2])
    other = near(again, textbook.adjust(*arguments, *start)[2], 1e-4)
    report(
        "bundle",
        [
            ("the camera", found, away),
            ("sigma0", good if found else None, spread),
            (
                "sigma0 with fewer photos",
                other if found and good else None,
                "with six photos sigma0 is different: count what the arrays hold",
            ),
            (
                "the covariance",
                near(variance / sd**2, 1, 1e-2) if found and good else None,
                hint,
            ),
        ],
    )
