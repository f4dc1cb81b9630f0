"""Checks of the exercises of chapter 6, self-calibrating bundle adjustment."""

from collections.abc import Callable, Collection

import numpy as np

from pgm_lab import _validate, bundle, checks, datasets
from pgm_lab.checks import CheckFailed, call, compare, first_slip, near, report

# Rays, photos, points, parameters, held control points
_NETWORKS = (
    (450, 9, 50, 10, 0),
    (450, 9, 50, 10, 4),
    (120, 4, 30, 0, 0),
    (310, 7, 61, 8, 5),
)
_BEST = 20.5  # µm: sd of c from the best five of the nine photos, of 126 choices
_GOOD = 1.25 * _BEST


def redundancy(function: Callable) -> None:
    """Check the reader's redundancy(rays, photos, points, parameters, held)."""
    answers = np.array([float(call(function, *case, shape=())) for case in _NETWORKS])
    rays, photos, points, parameters, held = np.array(_NETWORKS, dtype=float).T
    free = 7.0 * (held == 0)
    expected = 2 * rays - parameters - 6 * photos - 3 * (points - held) + free
    slips = [
        (expected - rays, "a ray gives two observations, x and y"),
        (expected - 2 * free, "a constraint adds to the redundancy: its sign"),
        (expected - free, "without control the inner constraints are missing"),
        (expected - free + 7, "with held control there are no inner constraints"),
        (
            expected - free + 7 - held,
            "right for 2013; but with held points the photos need no inner constraint"
            " any more, not fewer of them",
        ),
        (expected - 3 * held, "held points are still counted as unknowns"),
        (
            expected - 3 * held - free + 7,
            "held points are still counted as unknowns, and constraints come on top",
        ),
        (expected - 6 * held, "held points: the sign; they are fewer unknowns"),
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
    other = "observations, unknowns or constraints are counted otherwise"
    if known:
        other = "right for the network of 2013, but not for any: use all arguments"
        if near(answers[held == 0], expected[held == 0]):
            other = "right without held points, not with them"
    hint = first_slip(answers, slips, other)
    report(
        "my_redundancy",
        [
            ("the network of 2013", known, hint),
            ("any network", not known or near(answers, expected), hint),
        ],
    )


def reduced(function: Callable) -> None:
    """Check the reader's reduced(K, E, V), normal equations without the points."""
    rng = np.random.default_rng(62)
    J = rng.normal(size=(60, 7 + 3 * 5))
    J[:, 7:] *= np.kron(np.arange(60)[:, None] % 5 == np.arange(5), np.ones(3))
    N = J.T @ J
    K, E = N[:7, :7], N[:7, 7:].reshape(7, 5, 3).swapaxes(0, 1)
    V = np.array([N[i : i + 3, i : i + 3] for i in range(7, 22, 3)])
    expected = np.linalg.inv(np.linalg.inv(N)[:7, :7])  # another way to the same
    answer = call(function, K, E, V, shape=(7, 7))
    free = _free_network(function, J)
    one_point = call(function, K, E[:1], V[:1], shape=(7, 7))
    first = K - E[0] @ np.linalg.inv(V[0]) @ E[0].T
    by_points = E @ np.linalg.inv(V) @ E.swapaxes(1, 2)
    slips = [
        (K + by_points.sum(axis=0), "the sign: the points take something away"),
        (by_points.sum(axis=0), "K is missing"),
        (K - (E @ V @ E.swapaxes(1, 2)).sum(axis=0), "V is to be inverted"),
        (K - (E @ (1 / V) @ E.swapaxes(1, 2)).sum(axis=0), "1 / V is not the inverse"),
        (K - by_points[0], "all points take part, not the first alone"),
        (K - by_points[-1], "all points take part, not the last alone"),
        (K - by_points.mean(axis=0), "the sum over the points, not their mean"),
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
        "my_reduced",
        [
            ("the same solution with fewer rows", whole and alone, hint),
            (
                "also in a free network",
                not (whole and alone) or free,
                "a free network fails: its whole normal matrix is singular and has no"
                " inverse; invert the 3 × 3 blocks of the points alone",
            ),
        ],
    )


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


def band(function: Callable) -> None:
    """Check the reader's band(r, C), standard deviation of the radial correction."""
    r = np.array([0.0, 1.5, 4.0, 8.0])
    rng = np.random.default_rng(63)
    root = rng.normal(size=(3, 3)) * np.array([[3e-6], [6e-8], [4e-10]])
    C = root @ root.T
    answer = call(function, r, C, shape=(4,))
    powers = r[:, None] ** (3, 5, 7)

    def spread(J: np.ndarray, covariance: np.ndarray) -> np.ndarray:
        return np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", J, covariance, J), 0))

    expected = spread(powers, C)
    sd = np.sqrt(np.diagonal(C))
    slips = [
        (expected**2, "that is the variance: take the root"),
        (spread(powers, np.diag(sd**2)), "the covariances between K1, K2, K3 count"),
        (spread(powers, np.diag(sd**4)), "the diagonal of C holds variances"),
        (
            np.sqrt(np.abs(powers @ sd**2)),
            "the derivatives enter twice, before C and behind it",
        ),
        (
            spread(powers, (C + np.diag(sd**2)) / 2),
            "each covariance counts twice: C has it above and below the diagonal",
        ),
        (powers @ sd, "standard deviations do not simply add: use all of C"),
        (
            spread(r[:, None] ** (2, 4, 6), C),
            "the radial correction has other powers",
        ),
        (
            spread(r[:, None] ** (1, 2, 3), C),
            "the radial correction has other powers",
        ),
        (1.96 * expected, "one standard deviation, not 95 per cent"),
        (2 * expected, "one standard deviation, not two"),
        (1000 * expected, "millimetres, not micrometres"),
    ]
    size = expected.max()  # the numbers are small: compare them with their own size
    hint = first_slip(
        answer / size,
        [(wrong / size, text) for wrong, text in slips],
        "it does not follow from the covariance of K1, K2 and K3",
    )
    right = near(answer / size, expected / size, 1e-6)
    report(
        "my_band",
        [
            ("nothing at the centre", abs(answer[0]) < 1e-12, "at r = 0 it is not 0"),
            ("all of the covariance counts", right, hint),
        ],
    )


def largest_difference(photo: int, unknown: str, unit: str, moved_um: float) -> None:
    """Exercise 6.4: what the largest difference in Table 4.19 is, and what it does."""
    data = datasets.muliawan2013()
    difference = np.abs(data.published_exteriors - data.exteriors)
    row, column = np.unravel_index(difference.argmax(), difference.shape)
    unknowns = ("X0", "Y0", "Z0", "omega", "phi", "kappa")
    if not isinstance(unit, str) or not isinstance(unknown, str) or not unit:
        raise CheckFailed("unknown and unit must be texts, and not empty. Your turn!")
    photo = int(checks.numbers("photo", photo))
    try:
        moved_um = _validate.number(moved_um, "moved_um")
    except ValueError:
        raise CheckFailed("moved_um is not a number") from None
    if moved_um == 0:
        raise CheckFailed("moved_um is still 0. Your turn!")
    radius = 10.0  # mm
    arc = 1000 * radius * difference.max()
    slips = (
        (-arc, "a distance is wanted, not a negative number"),
        (arc / 1000, "that is in mm, µm are wanted"),
        (arc / (1000 * radius), "that is the angle itself, not the arc"),
        (np.radians(arc), "the angle was taken for degrees"),
        (np.degrees(arc), "the angle was converted to degrees"),
        (arc / radius, "that is the arc at 1 mm, not at 10 mm"),
    )
    explained = [hint for wrong, hint in slips if abs(moved_um / wrong - 1) < 0.01]
    explained.append("it is not the arc at 10 mm from the principal point")
    found = (photo, unknown) == (row + 1, unknowns[column])
    other = "another photo or another unknown has the largest |difference|"
    kind = "this is not the unit: what does the conventions box say of such a quantity?"
    right, hint = abs(moved_um / arc - 1) < 0.01, f"moved_um: {explained[0]}"
    report(
        "largest difference",
        [
            ("the right photo and unknown", found, other),
            ("the right unit", unit in ("rad", "radian", "radians"), kind),
            ("moved by dozens of micrometres", right, hint),
        ],
    )


def unit_diagonal(function: Callable) -> None:
    """Exercise 6.5: a symmetric matrix brought to ones on the diagonal."""
    rng = np.random.default_rng(65)
    matrices = []
    for n in (2, 3, 6):
        A = rng.normal(size=(2 * n, n)) * 10.0 ** rng.integers(-3, 4, n)
        matrices.append(A.T @ A)
    slips = {
        "the rows are scaled, the columns are not": lambda N: N / _roots(N)[:, None],
        "the columns are scaled, the rows are not": lambda N: N / _roots(N),
        "it divides by the diagonal, without the root": (
            lambda N: N / np.outer(np.diag(N), np.diag(N))
        ),
        "each row is divided by its diagonal element": lambda N: (
            N / np.diag(N)[:, None]
        ),
        "each column is divided by its diagonal element": lambda N: N / np.diag(N),
        "it multiplies where it should divide": (
            lambda N: N * np.outer(_roots(N), _roots(N))
        ),
        "one number scales the whole matrix": lambda N: N / np.diag(N).max(),
        "the elements off the diagonal are lost": lambda N: np.eye(len(N)),
    }
    found = call(function, matrices[0], shape=(2, 2))
    otherwise = "the elements off the diagonal are wrong"
    if not near(found, found.T):
        otherwise = "the result is not symmetric"
    if not near(np.diag(found), 1):
        otherwise = "the diagonal of the result is not 1"
    cases = [(N,) for N in matrices]
    right, hint = compare(function, cases, rescaled, slips, otherwise)
    report(
        "unit_diagonal", [("ones on the diagonal, symmetric, any units", right, hint)]
    )


def rescaled(N: np.ndarray) -> np.ndarray:
    """N with ones on its diagonal, whatever its units are: the answer of 6.5."""
    N = _validate.of_shape(N, (None, None), "N")
    if N.shape[0] != N.shape[1] or np.any(np.diagonal(N) <= 0):
        raise ValueError("N must be square, with a diagonal above zero")
    return N / np.outer(_roots(N), _roots(N))


def _roots(N: np.ndarray) -> np.ndarray:
    return np.sqrt(np.diagonal(N))


def five_photos(photos: Collection[int]) -> None:
    """Exercise 6.6: five of the nine photos that determine c well."""
    try:
        chosen = sorted({_validate.whole(number, "photos", -99) for number in photos})
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed("photos must be five numbers from 1 to 9") from None
    if len(chosen) != 5 or chosen[0] < 1 or chosen[-1] > 9:
        raise CheckFailed("photos must be five different numbers from 1 to 9")
    if chosen == [1, 2, 3, 4, 5]:
        raise CheckFailed("these are still the first five. Your turn!")
    network = bundle.published.network()
    try:
        one = bundle.adjust(network.only(np.array(chosen) - 1))
    except bundle.NetworkDefect as error:
        raise CheckFailed(f"these five leave something open: {error}") from error
    everything = bundle.adjust(network)
    sd = 1000 * one.sd_interior[0] * everything.sigma0 / one.sigma0
    hint = (
        f"c has a standard deviation of {sd:.0f} µm, {sd / _BEST:.1f} times that of the"
        " best five. From how many places do yours look, how far apart are these, and"
        " how is the camera rolled at each?"
    )
    text = f"c ± {sd:.0f} µm, from all nine ± {1000 * everything.sd_interior[0]:.0f} µm"
    report("five photos", [(text, sd < _GOOD, hint)])
