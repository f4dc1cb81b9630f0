"""Checks of the exercises of appendix A1, least squares adjustment."""

from collections.abc import Callable

import numpy as np

from pgm_lab.checks import (
    call,
    compare,
    first_slip,
    near,
    numbers,
    report,
)

# The levelling net of exercise A1.1: P is known, columns are Q, R, S
_LINES = (("P", "Q"), ("Q", "R"), ("S", "R"), ("S", "P"), ("Q", "S"))
_UNKNOWN = ("Q", "R", "S")


def design(answer: object) -> None:
    """Check the design matrix (5, 3) of the net of exercise A1.1."""
    wanted = (
        "an array (5, 3), with a row for each line and a column for each unknown height"
        " (that of P is known)"
    )
    value = numbers("design", answer, (5, 3), wanted)
    expected = np.array(
        [[1.0 * (c == b) - (c == a) for c in _UNKNOWN] for a, b in _LINES]
    )
    rows = list(zip(map("".join, _LINES), value, expected))
    wrong = [line for line, row, right in rows if not near(row, right)]
    turned = [line for line, row, right in rows if near(row, -right)]
    if len(turned) == len(_LINES):
        hint = "all signs are reversed: a difference is the end minus the start"
    elif near(value, expected[:, ::-1]):
        hint = "the columns stand in another order than Q, R, S"
    elif turned and turned == wrong:
        hint = f"reversed: {', '.join(turned)}; the end gets +1 and the start -1"
    elif np.any(np.abs(value).sum(axis=1) > 2):
        hint = "a line joins two bench marks, so no row has more than two entries"
    else:
        hint = f"look again at {', '.join(wrong)}"
    report("design", [("a row for each line", not wrong, hint)])


def heights(function: Callable) -> None:
    """Check the reader's my_adjust(A, p, l) for linear observation equations A x."""
    slips = {
        "the weights are left out": lambda A, p, d: _solve(A, np.ones_like(p), d),
        "each weight enters twice": lambda A, p, d: _solve(A, p**2, d),
        "these are standard deviations or variances instead of weights": (
            lambda A, p, d: _solve(A, 1 / p, d)
        ),
        "the roots of the weights were taken": lambda A, p, d: _solve(A, p**0.5, d),
        "the weights stand on the right-hand side only": (
            lambda A, p, d: np.linalg.solve(A.T @ A, A.T @ (p * d))
        ),
        "the weights stand on the left-hand side only": (
            lambda A, p, d: np.linalg.solve(A.T @ (p[:, None] * A), A.T @ d)
        ),
        "the sign is reversed": lambda A, p, d: -_solve(A, p, d),
    }
    otherwise = "vᵀPv is not least: look at the normal equations"
    right, hint = compare(function, _nets(), _solve, slips, otherwise)
    report("my_adjust", [("vᵀPv is least in three nets", right, hint)])


def sigma0(function: Callable) -> None:
    """Check the reader's my_sigma0(v, p, u): residuals, weights, number of unknowns."""

    def expected(v: np.ndarray, p: np.ndarray, u: int) -> float:
        return np.sqrt(np.sum(p * v**2) / (len(v) - u))

    slips = {
        "the weights are left out": lambda v, p, u: expected(v, p**0, u),
        "the redundancy belongs under the root": (
            lambda v, p, u: np.sqrt(np.sum(p * v**2)) / (len(v) - u)
        ),
        "that is the variance: take the root": lambda v, p, u: expected(v, p, u) ** 2,
        "divide by the redundancy, not by the number of observations": (
            lambda v, p, u: expected(v, p, 0)
        ),
        "the number of unknowns is not always 1": lambda v, p, u: expected(v, p, 1),
        "each weight enters twice": lambda v, p, u: expected(v, p**2, u),
        "multiply by the weight, do not divide": lambda v, p, u: expected(v, 1 / p, u),
        "square each residual before it is weighted and summed": (
            lambda v, p, u: np.sqrt(np.abs(np.sum(p * v)) / (len(v) - u))
        ),
        "np.std knows neither weights nor unknowns": lambda v, p, u: np.std(v),
    }
    cases = [
        (A @ _solve(A, p, d) - d, p, A.shape[1])  # v = computed - observed
        for A, p, d in _nets()
    ]
    otherwise = "it is another number: what is summed, and what is it divided by?"
    right, hint = compare(function, cases, expected, slips, otherwise)
    report("my_sigma0", [("right in three nets", right, hint)])


def redundancy_numbers(function: Callable) -> None:
    """Check the reader's my_redundancy_numbers(A, p)."""
    cases = [(A, p) for A, p, _ in _nets()]
    answers = [call(function, *case, shape=case[1].shape) for case in cases]
    sums = [near(a.sum(), len(p) - A.shape[1]) for a, (A, p) in zip(answers, cases)]
    inside = all(np.all((a > -1e-9) & (a < 1 + 1e-9)) for a in answers)
    slips = {
        "that is the share that the unknowns swallow: subtract it from 1": (
            lambda A, p: 1 - _shares(A, p)
        ),
        "the weights are left out": lambda A, p: _shares(A, np.ones_like(p)),
        "one of the weights is missing: the matrix whose diagonal you take has P in it"
        " twice, once inside Q": lambda A, p: 1 - (1 - _shares(A, p)) / p,
    }
    otherwise = "they belong to other observations"
    right, hint = compare(function, cases, _shares, slips, otherwise)
    total = "their sum must be the number of observations minus unknowns"
    report(
        "my_redundancy_numbers",
        [
            ("they add up to the redundancy", all(sums), total),
            ("they lie between 0 and 1", inside, "some lie outside 0 and 1"),
            ("each is right in three nets", right, hint),
        ],
    )


def suspect(function: Callable) -> None:
    """Check the reader's my_suspect(v, sigma, r): a row number, or -1 for none."""
    v = np.array([4.0, -9.0, -7.0, 1.5, -3.0])
    sigma = np.array([2.0, 5.0, 2.0, 3.0, 1.2])
    r = np.array([0.6, 0.7, 0.5, 0.4, 0.12])
    # w is about (2.6, -2.2, -4.9, 0.8, -7.2)
    found = _row(function, v, sigma, r)
    hints = {
        1: "the largest residual need not be the suspect: divide by what it should be",
        2: "each residual has its own standard deviation, smaller than sigma: r tells"
        " how much smaller",
        5: "Python counts rows from 0",
        -1: "a negative residual can be as suspicious as a positive one",
    }
    hint = hints.get(int(found), "another observation has the largest |w|")
    quiet = _row(function, v / 4, sigma, r)
    limit = _row(function, v * (3.28 / 7.2169), sigma, r)
    clean_hint = "no |w| is above 3.29 here: the answer must be -1"
    if quiet != -1 and _row(function, v / 10, sigma, r) == -1:
        clean_hint += "; divide by the root of r, not by r"
    # Its residual is 0 but for rounding
    alone = [
        _row(function, np.append(v, noise), np.append(sigma, 1.0), np.append(r, 0.0))
        for noise in (0.0, -1e-12)
    ]
    report(
        "my_suspect",
        [
            ("the largest |w| is found", found == 4, hint),
            ("a clean net has no suspect", quiet == limit == -1, clean_hint),
            (
                "an observation that nothing controls is passed over",
                found != 4 or alone == [4, 4],
                "an observation with r = 0 has no w: leave it out before dividing",
            ),
        ],
    )


def _row(function: Callable, v: np.ndarray, sigma: np.ndarray, r: np.ndarray) -> float:
    # A division by 0 is no slip as long as nothing comes of it, as in np.where
    with np.errstate(all="ignore"):
        return float(call(function, v, sigma, r, shape=()))


def ellipse(function: Callable) -> None:
    """Check the reader's my_ellipse(covariance): a, b, direction of a in degrees."""
    semi_axes = np.array([(5.0, 2.0), (3.0, 0.7), (40.0, 9.0)])
    directions = np.array([30.0, 115.0, 170.0])
    covariances = np.array(
        [
            [[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]
            @ np.diag(axes**2)
            @ [[np.cos(t), np.sin(t)], [-np.sin(t), np.cos(t)]]
            for axes, t in zip(semi_axes, np.radians(directions))
        ]
    )
    answers = np.array([call(function, one, shape=(3,)) for one in covariances])
    found, angles = answers[:, :2], answers[:, 2]
    sd = np.sqrt(covariances[:, [0, 1], [0, 1]])
    of_axes = [
        (semi_axes**2, "eigenvalues are variances: take the roots"),
        (semi_axes[:, ::-1], "the longer semi-axis comes first"),
        (sd, "sx and sy are not the semi-axes"),
        (np.sort(sd)[:, ::-1], "sx and sy are not the semi-axes"),
    ]
    of_direction = [
        (np.degrees(angles), directions, "the direction must be in degrees"),
        (angles, directions + 90, "that is the direction of the short axis"),
        (angles, 90 - directions, "the direction counts from the x axis, not from y"),
        (angles, -directions, "the direction runs the wrong way round"),
    ]
    other = "the longer axis points elsewhere: look at its eigenvector"
    slip = (hint for a, b, hint in of_direction if _parallel(a, b))
    size = "the semi-axes are those of another ellipse: look at the eigenvalues"
    lengths = near(found, semi_axes, 1e-8)
    report(
        "my_ellipse",
        [
            ("semi-axes of three ellipses", lengths, first_slip(found, of_axes, size)),
            ("their direction", _parallel(angles, directions), next(slip, other)),
        ],
    )


def _parallel(angles: np.ndarray, others: np.ndarray) -> bool:
    """Whether axes have the same directions; half a turn makes no difference."""
    return near((angles - others + 90) % 180, 90, 1e-8)


def _nets() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Design matrix, weights and observations of three nets, without symmetry."""
    nets = []
    for seed, n, u in ((1, 5, 2), (2, 7, 3), (3, 9, 4)):
        rng = np.random.default_rng(seed)
        A = rng.integers(-1, 2, (n, u)) + np.eye(n, u)
        p = rng.uniform(0.2, 5, n).round(1)
        nets.append((A, p, A @ rng.normal(size=u) + 0.1 * rng.normal(size=n)))
    return nets


def _solve(A: np.ndarray, p: np.ndarray, observations: np.ndarray) -> np.ndarray:
    return np.linalg.solve(A.T @ (p[:, None] * A), A.T @ (p * observations))


def _shares(A: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Redundancy numbers, by the residuals that an error of 1 leaves: Q_vv P."""
    Q = np.linalg.inv(A.T @ (p[:, None] * A))
    return 1 - np.einsum("ni,ij,nj->n", A, Q, A) * p
