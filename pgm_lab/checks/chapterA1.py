"""Checks of the exercises of appendix A1, least squares adjustment."""

from collections.abc import Callable

import numpy as np

from pgm_lab.adjustment import Adjustment, adjust
from pgm_lab.checks import CheckFailed, call, near, report

# The levelling net of exercise A1.1: P is known, columns are Q, R, S
_LINES = ["PQ", "QR", "SR", "SP", "QS"]
_KNOWN, _UNKNOWN = "P", "QRS"


def design(answer: object) -> None:
    """Check the design matrix (5, 3) of the net of exercise A1.1."""
    if answer is ... or answer is None:
        raise CheckFailed("design is still empty. Your turn!")

    try:
        value = np.asarray(answer, dtype=float)
    except (TypeError, ValueError):
        raise CheckFailed("design must be an array of numbers, (5, 3)") from None
    if value.shape == (5, 4):
        raise CheckFailed("P is known: its height is no parameter and has no column.")
    if value.shape != (5, 3):
        raise CheckFailed(
            "design needs a row for each of five lines and a column for each of three"
            f" unknowns: shape (5, 3), not {value.shape}."
        )
    expected = np.array([[(c == b) - (c == a) for c in _UNKNOWN] for a, b in _LINES])
    wrong = [line for line, row, e in zip(_LINES, value, expected) if not near(row, e)]
    turned = [line for line, row, e in zip(_LINES, value, expected) if near(row, -e)]
    if len(turned) == len(_LINES):
        hint = "all signs are turned round: a difference is the end minus the start"
    elif near(value, expected[:, ::-1]):
        hint = "the columns stand in another order than Q, R, S"
    elif turned and turned == wrong:
        hint = f"turned round: {', '.join(turned)}; the end gets +1 and the start -1"
    elif np.any(np.abs(value).sum(axis=1) > 2):
        hint = "a line joins two bench marks, so no row has more than two entries"
    else:
        hint = f"look again at {', '.join(wrong)}"
    report("design", [("a row for each line", not wrong, hint)])


def heights(function: Callable) -> None:
    """Check the reader's my_adjust(A, p, l) for linear observation equations A x."""
    answers, expected, slips = [], [], {}
    for A, p, observations in _linear_problems():
        answers.append(call(function, A, p, observations, shape=(A.shape[1],)))
        expected.append(_solve(A, p, observations))
        for name, wrong in {
            "the weights are left out": np.ones_like(p),
            "each weight enters twice": p**2,
            "these are standard deviations or variances instead of weights": 1 / p,
            "the roots of the weights were taken": np.sqrt(p),
        }.items():
            slips.setdefault(name, []).append(_solve(A, wrong, observations))
    slips["the sign is turned round"] = [-x for x in expected]
    report(
        "my_adjust",
        [
            (
                "v'Pv is least in three nets",
                _all_near(answers, expected),
                _slip(answers, slips, "v'Pv is not least: look at A'PA x = A'P l"),
            )
        ],
    )


def sigma0(function: Callable) -> None:
    """Check the reader's my_sigma0(v, p, u): residuals, weights, number of unknowns."""
    answers, expected, slips = [], [], {}
    for found, p in _adjustments():
        v, u = found.residuals, len(found.x)
        n, r = len(v), len(v) - u
        answers.append(call(function, v, p, u, shape=()))
        expected.append(np.sqrt(np.sum(p * v**2) / r))
        for name, wrong in {
            "the weights are left out": np.sqrt(np.sum(v**2) / r),
            "the redundancy belongs under the root": np.sqrt(np.sum(p * v**2)) / r,
            "that is the variance: take the root": np.sum(p * v**2) / r,
            "divide by the redundancy, not by the number of observations": np.sqrt(
                np.sum(p * v**2) / n
            ),
            "the redundancy is n - u, not n - 1": np.sqrt(np.sum(p * v**2) / (n - 1)),
            "each weight enters twice": np.sqrt(np.sum((p * v) ** 2) / r),
            "square each residual before it is weighted and summed": np.sqrt(
                np.abs(np.sum(p * v)) / r
            ),
        }.items():
            slips.setdefault(name, []).append(wrong)
    hint = _slip(answers, slips, "the root of v'Pv over the redundancy is another")
    report("my_sigma0", [("right in three nets", _all_near(answers, expected), hint)])


def redundancy_numbers(function: Callable) -> None:
    """Check the reader's my_redundancy_numbers(A, p)."""
    answers, expected, totals, slips = [], [], [], {}
    for (A, p, _), (found, _) in zip(_linear_problems(), _adjustments()):
        answers.append(call(function, A, p, shape=p.shape))
        share = found.redundancy_numbers
        expected.append(share)
        totals.append(near(answers[-1].sum(), found.redundancy))
        plain = A @ np.linalg.inv(A.T @ A) @ A.T
        for name, wrong in {
            "that is the share that the unknowns swallow: subtract it from 1": 1
            - share,
            "the weights are left out": 1 - np.diag(plain),
            "the weight of the observation is missing in A Q A' P": 1 - (1 - share) / p,
        }.items():
            slips.setdefault(name, []).append(wrong)
    inside = all(np.all((a > -1e-9) & (a < 1 + 1e-9)) for a in answers)
    right = _all_near(answers, expected)
    report(
        "my_redundancy_numbers",
        [
            (
                "they add up to the redundancy",
                all(totals),
                "their sum must be the number of observations minus unknowns",
            ),
            ("they lie between 0 and 1", inside, "some lie outside 0 and 1"),
            (
                "each is right in three nets",
                right,
                _slip(answers, slips, "they belong to other observations"),
            ),
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
        2: "each residual has its own standard deviation, sigma times the root of r",
        5: "Python counts rows from 0",
        -1: "a negative residual can be as suspicious as a positive one",
    }
    hint = hints.get(found, "another observation has the largest |w|")
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
            (
                "a clean net has no suspect",
                quiet == -1 and limit == -1,
                clean_hint,
            ),
            (
                "an observation that nothing controls is passed over",
                found != 4 or alone == [4, 4],
                "an observation with r = 0 has no w: leave it out before dividing",
            ),
        ],
    )


def _row(function: Callable, v, sigma, r) -> float:
    # A division by 0 is no slip as long as nothing comes of it, as in np.where
    with np.errstate(all="ignore"):
        return float(call(function, v, sigma, r, shape=()))


def ellipse(function: Callable) -> None:
    """Check the reader's my_ellipse(covariance): a, b, direction of a in degrees."""
    answers, expected, slips = [], [], {}
    for a, b, direction in [(5.0, 2.0, 30.0), (3.0, 0.7, 115.0), (40.0, 9.0, 170.0)]:
        t = np.radians(direction)
        axes = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
        covariance = axes @ np.diag([a**2, b**2]) @ axes.T
        one, two, angle = call(function, covariance, shape=(3,))
        answers.append([one, two, angle % 180])
        in_radians = near(np.degrees(angle) % 180, direction, 1e-8)
        expected.append([a, b, direction])
        sd = np.sqrt(np.diag(covariance))
        for name, wrong in {
            "eigenvalues are variances: take the roots": [a**2, b**2, direction],
            "the longer semi-axis comes first": [b, a, direction],
            "that is the direction of the short axis": [a, b, (direction + 90) % 180],
            "the longer semi-axis comes first, with its direction": [
                b,
                a,
                (direction + 90) % 180,
            ],
            "the direction must be in degrees": [
                a,
                b,
                angle % 180 if in_radians else np.nan,
            ],
            "the direction is measured from the x axis, not from y": [
                a,
                b,
                (90 - direction) % 180,
            ],
            "the direction runs the wrong way round": [a, b, -direction % 180],
        }.items():
            slips.setdefault(name, []).append(wrong)
        slips.setdefault("sx and sy are not the semi-axes", []).append(
            [*sd, answers[-1][2]]
        )
        slips.setdefault("sx and sy are not the semi-axes ", []).append(
            [*np.sort(sd)[::-1], answers[-1][2]]
        )
    another = "another ellipse: look at the eigenvalues and vectors"
    another += "; is the direction in degrees, or is it in radians?"
    hint = _slip(answers, slips, another)
    right = _all_near(answers, expected)
    report("my_ellipse", [("semi-axes and direction of three ellipses", right, hint)])


def _linear_problems() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Design matrix, weights and observations of three nets, without symmetry."""
    problems = []
    for seed, n, u in ((1, 5, 2), (2, 7, 3), (3, 9, 4)):
        rng = np.random.default_rng(seed)
        A = rng.integers(-1, 2, (n, u)) + np.eye(n, u)
        p = rng.uniform(0.2, 5, n).round(1)
        problems.append((A, p, (A @ rng.normal(size=u) + 0.1 * rng.normal(size=n))))
    return problems


def _adjustments() -> list[tuple[Adjustment, np.ndarray]]:
    return [
        (adjust(lambda x, A=A: (A @ x, A), np.zeros(A.shape[1]), d, weights=p), p)
        for A, p, d in _linear_problems()
    ]


def _solve(A: np.ndarray, p: np.ndarray, observations: np.ndarray) -> np.ndarray:
    return np.linalg.solve(A.T @ (p[:, None] * A), A.T @ (p * observations))


def _all_near(answers: list, expected: list) -> bool:
    return all(near(a, e, 1e-8) for a, e in zip(answers, expected, strict=True))


def _slip(answers: list, slips: dict[str, list], otherwise: str) -> str:
    """Name the slip that explains the answers in all problems."""
    for name, wrong in slips.items():
        if _all_near(answers, wrong):
            return name.strip()
    return otherwise
