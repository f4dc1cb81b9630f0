"""Checks of the exercises of appendix A1, least squares adjustment."""

from collections.abc import Callable

import numpy as np

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    answer_of,
    call,
    chance,
    compare,
    near,
    report,
    shaken,
    varied,
)
from pgm_lab import _validate


def redundancy_numbers(function: Callable) -> None:
    """Check the reader's redundancy_numbers(A, p)."""
    cases = [(A, p) for A, p, _ in nets()]
    answers = [call(function, *case, shape=case[1].shape) for case in cases]
    sums = [near(a.sum(), len(p) - A.shape[1]) for a, (A, p) in zip(answers, cases)]
    inside = all(np.all((a > -1e-9) & (a < 1 + 1e-9)) for a in answers)
    slips = {
        "that is the share that the unknowns absorb: subtract it from 1": (
            lambda A, p: 1 - _shares(A, p)
        ),
        "the weights are left out": lambda A, p: _shares(A, np.ones_like(p)),
        "one of the weights is missing: the matrix whose diagonal you take has P in it"
        " twice, once inside Q": lambda A, p: 1 - (1 - _shares(A, p)) / p,
        "those are their roots: a redundancy number is a share, not a root": (
            lambda A, p: np.sqrt(_shares(A, p))
        ),
        "those are the roots of the other shares": (
            lambda A, p: np.sqrt(1 - _shares(A, p))
        ),
    }
    otherwise = "the matrix whose diagonal you take is another one: look at Q and at P"
    right, hint = compare(function, cases, _shares, slips, otherwise)
    shares = [_shares(*case) for case in cases]
    if any(all(map(near, answers, [a.round(k) for a in shares])) for k in range(2, 7)):
        hint = hint and "right, but rounded: keep all digits"
    total = "their sum must be the number of observations minus unknowns"
    report(
        "redundancy_numbers",
        [
            ("they add up to the redundancy", all(sums), total),
            (
                "they lie between 0 and 1",
                along_with(inside, all(sums)),
                "some lie outside 0 and 1",
            ),
            ("each is right in three nets", right, hint),
        ],
    )


def _orders(rng: np.random.Generator) -> tuple[list[int], list[int]]:
    """Rows of two nets, 4 the suspect: in the first after 2, in the other in front."""
    order = [2, *rng.permutation([0, 1, 3]).tolist()]
    order.insert(int(rng.integers(1, 4)), 4)
    return order, [4, *rng.permutation(4).tolist()]


def suspect(function: Callable) -> None:
    """Check the reader's suspect(v, sigma, r): a row number, or -1 for none."""
    table = np.array(
        [
            (4.0, -9.0, -7.0, 1.5, -3.0),
            (2.0, 5.0, 2.0, 3.0, 1.2),
            (0.6, 0.7, 0.5, 0.4, 0.12),
        ]
    )
    table, signs = shaken(101, table, 0.02), np.array([-1, -2, 1, -1, -1])
    # w is about (2.6, -2.2, -4.9, 0.8, -7.2), and then (7.2, -0.8, -4.9, 4.3, -2.6)
    order, other = varied(102, ([0, 1, 2, 3, 4], [4, 3, 2, 1, 0]), _orders)
    v, sigma, r = table[:, order]
    turned, *rest = table[:, other]
    cases = [(v, sigma, r), (turned * signs[other], *rest)]
    row = order.index(4)  # of the suspect
    highest = round(float(np.abs(_w(v, sigma, r)).max()), 4)
    found = [_row(function, *case) for case in cases]
    right = found == [_largest(_w(*case)) for case in cases] == [row, 0]
    hint = next(
        (hint for hint, wrong in _SLIPS if found == [wrong(*case) for case in cases]),
        "another observation has the largest |w|",
    )
    quiet = _row(function, v / 4, sigma, r)
    limit = _row(function, v * (3.28 / highest), sigma, r)
    above = _row(function, v * (3.31 / highest), sigma, r)
    clean_hint = "no |w| is above 3.29 here: the answer must be -1"
    if quiet != -1 and _row(function, v / 10, sigma, r) == -1:
        clean_hint += "; divide by the root of r, not by r"
    # Its residual is 0 but for rounding
    alone = [
        _row(function, *(np.insert(a, at, b) for a, b in zip((v, sigma, r), added)))
        for at in (5, 0)
        for added in ((0.0, 1.0, 0.0), (-1e-12, 1.0, 0.0))
    ]
    alone_hint = "an observation with r = 0 has no w: leave it out before dividing"
    if alone == [row] * 4:
        alone_hint = "an observation without w keeps its row: count all of them"
    report(
        "suspect",
        [
            ("the largest |w| is found", right, hint),
            (
                "a clean net has no suspect",
                along_with(quiet == limit == -1, right),
                clean_hint,
            ),
            (
                "one just above the limit is found",
                above == row if right else None,
                "a |w| of 3.31 is passed over: divide by the standard deviation, not by"
                " its square, and compare with 3.29",
            ),
            (
                "an observation that nothing controls is passed over",
                alone == [row, row, row + 1, row + 1] if right else None,
                alone_hint,
            ),
        ],
    )


def _w(v: np.ndarray, sigma: np.ndarray, r: np.ndarray) -> np.ndarray:
    return v / (sigma * np.sqrt(r))


def _largest(w: np.ndarray) -> int:
    return int(np.argmax(np.abs(w)))


def _above(w: np.ndarray) -> int:
    """Row of the largest w above the limit, by its sign, or -1."""
    return int(np.argmax(w)) if w.max() > 3.29 else -1


# What each slip in `suspect` would answer, by the hint to it
_SLIPS: list[tuple[str, Callable[..., int]]] = [
    (
        "the largest residual need not be the suspect: divide by what it should be",
        lambda v, sigma, r: _largest(v),
    ),
    (
        "each residual has its own standard deviation, smaller than sigma: r tells"
        " how much smaller",
        lambda v, sigma, r: _largest(v / sigma),
    ),
    ("Python counts rows from 0", lambda *case: _largest(_w(*case)) + 1),
    (
        "a negative residual can be as suspicious as a positive one",
        lambda *case: _above(_w(*case)),
    ),
    (
        "a positive residual can be as suspicious as a negative one",
        lambda *case: _above(-_w(*case)),
    ),
    (
        "not the first above 3.29, the largest",
        lambda *case: int(np.flatnonzero(abs(_w(*case)) > 3.29)[0]),
    ),
    (
        "not the last above 3.29, the largest",
        lambda *case: int(np.flatnonzero(abs(_w(*case)) > 3.29)[-1]),
    ),
    (
        "row 0 is a row: compare with the limit, not with the row",
        lambda *case: _largest(_w(*case)) or -1,
    ),
    ("one |w| is above 7 in these data: is r in the denominator?", lambda *case: -1),
]


def _row(function: Callable, v: np.ndarray, sigma: np.ndarray, r: np.ndarray) -> float:
    # A division by 0 is no slip as long as nothing comes of it, as in np.where
    with np.errstate(all="ignore"):
        return float(call(function, v, sigma, r, shape=()))


def _shares(A: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Redundancy numbers, by the residuals that an error of 1 leaves: Q_vv P."""
    Q = np.linalg.inv(A.T @ (p[:, None] * A))
    return 1 - np.einsum("ni,ij,nj->n", A, Q, A) * p


# --- Checks of the reader's least squares: normal equations, and what follows ---


def normal_equations(function: Callable) -> None:
    """Check the reader's normal_equations(A, p, observed) -> N, n."""
    right_N, right_n = [], []
    found_N, found_n = [], []
    cases = nets()
    for A, p, d in cases:
        u = A.shape[1]
        N, n = _parts(function, (A, p, d), [("N", (u, u)), ("n", (u,))])
        found_N.append(N)
        found_n.append(n)
        right_N.append(A.T @ (p[:, None] * A))
        right_n.append(A.T @ (p * d))

    def left(of: Callable) -> list[np.ndarray]:
        return [A.T @ (of(p)[:, None] * A) for A, p, _ in cases]

    def side(of: Callable) -> list[np.ndarray]:
        return [A.T @ (of(p) * d) for A, p, d in cases]

    weights = {
        "the weights are left out": lambda p: np.ones_like(p),
        "each weight enters twice": lambda p: p**2,
        "the roots of the weights were taken": lambda p: p**0.5,
        "divided by the weights: a large weight must count much": lambda p: 1 / p,
    }
    good_N, good_n = _same(found_N, right_N), _same(found_n, right_n)
    without = next(iter(weights.values()))
    hint_N = next((h for h, w in weights.items() if _same(found_N, left(w))), "")
    hint_n = next((h for h, w in weights.items() if _same(found_n, side(w))), "")
    if good_n and _same(found_N, left(without)):
        hint_N = "the weights stand on the right-hand side only"
    if good_N and _same(found_n, side(without)):
        hint_n = "the weights stand on the left-hand side only"
    if _same(found_n, [-one for one in right_n]):
        hint_n = "the sign is reversed"
    if _same(found_N, [np.linalg.inv(one) for one in right_N]):
        hint_N = "that is the inverse, Q: the matrix itself is asked for"
    solved = [solve(*net) for net in cases]
    if _same(found_n, solved):
        hint_n = "those are the unknowns: return the right-hand side, not yet solved"
    other_N = "which products of the columns of A does it hold?"
    other_n = "which observations does each unknown meet, and with which weight?"
    hints = [f"N: {hint_N or other_N}", f"n: {hint_n or other_n}"]
    if hint_N and hint_N == hint_n:
        hints = [hint_N, hint_N]
    properties: list[tuple[str, bool | None, str]] = [
        ("N is right in three nets", good_N, hints[0]),
        ("n too", good_n, hints[1]),
    ]
    same = hints[0] == hints[1] and not good_N and not good_n
    if same:  # one slip is named once
        properties[1] = ("n too", None, "")
    report("normal_equations", properties)


def adjust(function: Callable) -> None:
    """Check the reader's adjust(A, p, observed) -> x, v, sigma0, Q."""
    found: dict[str, list[np.ndarray]] = {
        name: [] for name in ("x", "v", "sigma0", "Q")
    }
    cases = nets()
    for A, p, d in cases:
        n, u = A.shape
        shapes = [("x", (u,)), ("v", (n,)), ("sigma0", ()), ("Q", (u, u))]
        for (name, _), one in zip(shapes, _parts(function, (A, p, d), shapes)):
            found[name].append(one)
    x = [solve(*net) for net in cases]
    v = [A @ one - d for one, (A, _, d) in zip(x, cases)]
    Q = [np.linalg.inv(A.T @ (p[:, None] * A)) for A, p, _ in cases]

    def sigma0(of: Callable) -> list[np.ndarray]:
        return [np.array(of(one, p, A.shape[1])) for one, (A, p, _) in zip(v, cases)]

    s = sigma0(_sigma0)
    of_x = [
        ([solve(A, np.ones_like(p), d) for A, p, d in cases], "the weights are lost"),
        ([-one for one in x], "the sign is reversed"),
        (
            [A.T @ (p * d) for A, p, d in cases],
            "that is n: the normal equations are not solved yet",
        ),
    ]
    of_v = [
        ([-one for one in v], "the sign: computed minus observed"),
        (
            [A @ one for one, (A, _, _) in zip(x, cases)],
            "that is computed from the unknowns: the observations are not subtracted",
        ),
        ([one * p for one, (_, p, _) in zip(v, cases)], "residuals are not weighted"),
    ]
    of_sigma0 = [(sigma0(wrong), hint) for hint, wrong in _SLIPS_OF_SIGMA0.items()]
    of_Q = [
        (
            [f**2 * one for f, one in zip(s, Q)],
            "that is the covariance: Q is without sigma0",
        ),
        ([np.linalg.inv(one) for one in Q], "that is N: Q is its inverse"),
    ]
    other = {
        "x": "vᵀPv is not least",
        "v": "those are no residuals of your x",
        "sigma0": "another number: what is summed, and what is it divided by?",
        "Q": "another matrix: what does the lesson call Q?",
    }
    slips = {"x": of_x, "v": of_v, "sigma0": of_sigma0, "Q": of_Q}
    right = {"x": x, "v": v, "sigma0": s, "Q": Q}
    properties: list[tuple[str, bool | None, str]] = []
    for name, claim in (
        ("x", "vᵀPv is least in three nets"),
        ("v", "the residuals have the right sign"),
        ("sigma0", "σ₀ is right"),
        ("Q", "Q too"),
    ):
        hint = next((h for w, h in slips[name] if _same(found[name], w)), other[name])
        properties.append((claim, _same(found[name], right[name]), f"{name}: {hint}"))
    hint = (
        "a plane through raw UTM coordinates comes out wrong, and nothing says so: keep"
        " the lines that stop where columns of A nearly depend on one another"
    )
    solved = all(holds for _, holds, _ in properties[:2])
    good = along_with(_spoils_none(function), solved)
    properties.append(("raw UTM columns stop it, or come out right", good, hint))
    report("adjust", properties)


def _spoils_none(function: Callable) -> bool:
    """Whether exact planes through raw UTM columns stop, or come out right."""
    X, Y = np.indices((5, 5)).reshape(2, -1) / 2  # two metres of ground
    east, north = shaken(106, (500000, 9200000), 0.01)
    A = np.column_stack([east + X, north + Y, np.ones(25)])
    for a, b, c in ((1, 2, 100), (0.5, 0, 100), (0.1, -0.05, 100), (1, 0, 0)):
        try:
            v = function(A.copy(), np.ones(25), a * X + b * Y + c)[1]
        except Exception:  # in whatever way it stops
            continue
        if np.abs(v).max() > 1e-6:
            return False
    return True


def _sigma0(v: np.ndarray, p: np.ndarray, u: int) -> float:
    return np.sqrt(np.sum(p * v**2) / (len(v) - u))


_SLIPS_OF_SIGMA0: dict[str, Callable] = {
    "the weights are left out": lambda v, p, u: _sigma0(v, p**0, u),
    "the redundancy belongs under the root": (
        lambda v, p, u: np.sqrt(np.sum(p * v**2)) / (len(v) - u)
    ),
    "that is the variance: take the root": lambda v, p, u: _sigma0(v, p, u) ** 2,
    "divide by the redundancy, not by the number of observations": (
        lambda v, p, u: _sigma0(v, p, 0)
    ),
    "divide by the redundancy: the number of unknowns is not always 1": (
        lambda v, p, u: _sigma0(v, p, 1)
    ),
    "that is the root of the sum: it is not divided yet": (
        lambda v, p, u: np.sqrt(np.sum(p * v**2))
    ),
    "each weight enters twice": lambda v, p, u: _sigma0(v, p**2, u),
    "multiply v² by the weight, do not divide": lambda v, p, u: _sigma0(v, 1 / p, u),
    "square each residual before it is weighted and summed": (
        lambda v, p, u: np.sqrt(np.abs(np.sum(p * v)) / (len(v) - u))
    ),
    "np.std ignores weights and unknowns": lambda v, p, u: np.std(v),
}


def _same(found: list[np.ndarray], others: list[np.ndarray]) -> bool:
    return all(near(a, b, 1e-8) for a, b in zip(found, others, strict=True))


def _parts(
    function: Callable, arguments: tuple, wanted: list[tuple[str, tuple[int, ...]]]
) -> list[np.ndarray]:
    """Parts of an answer that is a tuple, each as an array of its shape."""
    name = getattr(function, "__name__", "your function")
    names = ", ".join(part for part, _ in wanted)
    answer = answer_of(function, *arguments, first="the exercise before this one")
    if not isinstance(answer, tuple | list) or len(answer) != len(wanted):
        raise CheckFailed(f"{name} must return {len(wanted)} things: {names}")
    found = []
    for part, (what, shape) in zip(answer, wanted, strict=True):
        try:
            array = _validate.real(part, what)
        except ValueError:
            raise CheckFailed(f"{name}: {what} must be numbers") from None
        if shape == () and array.size == 1:  # one number in brackets
            array = array.reshape(shape)
        if array.shape != shape:
            raise CheckFailed(
                f"{name}: {what} must have shape {shape} here; got {array.shape}."
                f" The order is {names}"
            )
        if not np.all(np.isfinite(array)):
            raise CheckFailed(f"{name}: {what} must be finite: look for a division")
        if np.asarray(part).dtype in (np.float32, np.float16):
            raise CheckFailed(f"{name}: {what} is in single precision: use float64")
        found.append(array)
    return found


def nets() -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Design matrix, weights and observations of three nets, without symmetry."""
    nets = []
    for seed, n, u in ((1, 5, 2), (2, 7, 3), (3, 9, 4)):
        rng = chance(seed)
        A = np.zeros((n, u))
        while np.linalg.cond(A) > 10:  # unknowns that depend on one another
            A = rng.integers(-1, 2, (n, u)) + np.eye(n, u)
        p = rng.uniform(0.2, 5, n).round(1)
        nets.append((A, p, A @ rng.normal(size=u) + 0.1 * rng.normal(size=n)))
    return nets


def solve(A: np.ndarray, p: np.ndarray, observations: np.ndarray) -> np.ndarray:
    """Unknowns by the normal equations."""
    return np.linalg.solve(A.T @ (p[:, None] * A), A.T @ (p * observations))
