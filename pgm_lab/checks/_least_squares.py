"""Checks of the reader's least squares: normal equations, and what follows."""

from collections.abc import Callable

import numpy as np

from pgm_lab import _validate
from pgm_lab.checks import CheckFailed, answer_of, near, report


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
    properties = [
        ("N is right in three nets", good_N, hints[0]),
        ("n too", good_n, hints[1]),
    ]
    same = hints[0] == hints[1] and not good_N and not good_n
    report("normal_equations", properties[:1] if same else properties)


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
            "that is what the unknowns say: the observations are not taken off",
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
    properties = []
    for name, claim in (
        ("x", "vᵀPv is least in three nets"),
        ("v", "the residuals have the right sign"),
        ("sigma0", "σ₀ is right"),
        ("Q", "Q too"),
    ):
        hint = next((h for w, h in slips[name] if _same(found[name], w)), other[name])
        properties.append((claim, _same(found[name], right[name]), f"{name}: {hint}"))
    report("adjust", properties)


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
    "np.std knows neither weights nor unknowns": lambda v, p, u: np.std(v),
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
        if array.shape != shape and array.size == np.prod(shape, dtype=int):
            if len(shape) < 2:  # a column, or one number in brackets
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
        rng = np.random.default_rng(seed)
        A = rng.integers(-1, 2, (n, u)) + np.eye(n, u)
        p = rng.uniform(0.2, 5, n).round(1)
        nets.append((A, p, A @ rng.normal(size=u) + 0.1 * rng.normal(size=n)))
    return nets


def solve(A: np.ndarray, p: np.ndarray, observations: np.ndarray) -> np.ndarray:
    return np.linalg.solve(A.T @ (p[:, None] * A), A.T @ (p * observations))
