"""Feedback of appendix A1: right answers pass, each slip is named in plain words."""

import numpy as np
import pytest

from pgm_book.chA1 import checks as chapterA1
from pgm_book.common.checks import CheckFailed
from tests.common.slips import unnamed


def normal_equations(A, p, observed):
    return A.T @ np.diag(p) @ A, A.T @ (p * observed)


def adjust(A, p, observed):
    N = A.T @ np.diag(p) @ A
    if np.linalg.cond(N) > 1e12:
        raise ValueError("nearly singular")
    return unguarded_adjust(A, p, observed)


def unguarded_adjust(A, p, observed):
    Q = np.linalg.inv(A.T @ np.diag(p) @ A)
    x = Q @ A.T @ (p * observed)
    v = A @ x - observed
    return x, v, sigma0(v, p, len(x)), Q


def sigma0(v, p, u):
    return np.sqrt(v @ (p * v) / (len(v) - u))


def redundancy_numbers(A, p):
    return 1 - np.diag(A @ np.linalg.inv(A.T @ np.diag(p) @ A) @ A.T @ np.diag(p))


def suspect(v, sigma, r):
    w = np.zeros(len(v))
    known = r > 1e-9
    w[known] = v[known] / (sigma[known] * np.sqrt(r[known]))
    return np.argmax(np.abs(w)) if np.max(np.abs(w)) > 3.29 else -1


def test_right_answers_pass(capsys):
    chapterA1.normal_equations(normal_equations)
    chapterA1.adjust(adjust)
    chapterA1.redundancy_numbers(redundancy_numbers)
    chapterA1.suspect(suspect)
    assert capsys.readouterr().out.count("✓") == 4


def with_weights(left, right):
    """Normal equations with other weights on the left and on the right."""
    return lambda A, p, d: (A.T @ np.diag(left(p)) @ A, A.T @ (right(p) * d))


def as_is(p):
    return p


def none(p):
    return 1 + 0 * p


def test_slip_in_the_normal_equations_is_named():
    slips = [
        (with_weights(none, as_is), "N: the weights stand on the right-hand side only"),
        (with_weights(as_is, none), "n: the weights stand on the left-hand side only"),
        (with_weights(none, none), "equations: the weights are left out"),
        (with_weights(np.square, np.square), "equations: each weight enters twice"),
        (with_weights(np.square, as_is), "N: each weight enters twice"),
        (with_weights(np.sqrt, np.sqrt), "the roots of the weights"),
        (with_weights(np.reciprocal, np.reciprocal), "divided by the weights"),
        (
            lambda A, p, d: (normal_equations(A, p, d)[0], -A.T @ (p * d)),
            "n: the sign is reversed",
        ),
        (
            lambda A, p, d: (adjust(A, p, d)[3], A.T @ (p * d)),
            "N: that is the inverse, Q",
        ),
        (
            lambda A, p, d: (A.T @ np.diag(p) @ A, adjust(A, p, d)[0]),
            "n: those are the unknowns",
        ),
        (lambda A, p, d: normal_equations(A, p, d)[::-1], "N must have shape .*N, n"),
        (lambda A, p, d: normal_equations(A, p, d)[0], "must return 2 things: N, n"),
        (lambda A, p, d: ("N", "n"), "N must be numbers"),
        (lambda A, p, d: (np.nan * A.T @ A, A.T @ d), "N must be finite"),
        (lambda A, p, d: (A.T @ A + 9, A.T @ d + 9), r"does it hold\? n: .*weight\?$"),
        (
            lambda A, p, d: [one.astype("f4") for one in normal_equations(A, p, d)],
            "N is in single precision",
        ),
        (lambda A, p, d: None, "returns nothing yet"),
    ]
    assert unnamed(chapterA1.normal_equations, slips) == []


def test_a_number_in_brackets_passes_and_a_column_is_refused(capsys):
    chapterA1.adjust(changed(2, lambda a, *_: np.array([a[2]])))
    assert "✓" in capsys.readouterr().out
    with pytest.raises(CheckFailed, match=r"n must have shape \(2,\) here"):
        chapterA1.normal_equations(
            lambda A, p, d: (A.T @ np.diag(p) @ A, A.T @ np.diag(p) @ d[:, None])
        )


def changed(place, of):
    """adjust with one of its four answers changed."""

    def slip(A, p, observed):
        answer = list(adjust(A, p, observed))
        answer[place] = of(answer, A, p, observed)
        return tuple(answer)

    return slip


def of_sigma0(of):
    return changed(2, lambda a, A, p, d: of(a[1], p, len(a[0])))


def test_slip_in_the_adjustment_is_named():
    slips = [
        (lambda A, p, d: adjust(A, none(p), d), "x: the weights are lost"),
        (changed(0, lambda a, *_: -a[0]), "x: the sign is reversed"),
        (changed(0, lambda a, A, p, d: A.T @ (p * d)), "x: that is n"),
        (changed(0, lambda a, *_: a[0] + 1e-6), "x: vᵀPv is not least"),
        (changed(1, lambda a, *_: -a[1]), "v: the sign: computed minus observed"),
        (changed(1, lambda a, A, p, d: A @ a[0]), "v: .* are not subtracted"),
        (changed(1, lambda a, A, p, d: p * a[1]), "v: residuals are not weighted"),
        (changed(1, lambda a, *_: 2 * a[1]), "v: those are no residuals of your x"),
        (of_sigma0(lambda v, p, u: sigma0(v, none(p), u)), "sigma0: the weights are"),
        (of_sigma0(lambda v, p, u: np.sqrt(v @ (p * v)) / (len(v) - u)), "under the"),
        (of_sigma0(lambda v, p, u: sigma0(v, p, u) ** 2), "take the root"),
        (of_sigma0(lambda v, p, u: sigma0(v, p, 0)), "not by the number of obs"),
        (of_sigma0(lambda v, p, u: sigma0(v, p, 1)), "is not always 1"),
        (of_sigma0(lambda v, p, u: np.sqrt(v @ (p * v))), "not divided yet"),
        (of_sigma0(lambda v, p, u: sigma0(v, p**2, u)), "each weight enters twice"),
        (of_sigma0(lambda v, p, u: sigma0(v, 1 / p, u)), "v² by the weight, do not"),
        (of_sigma0(lambda v, p, u: np.sqrt(abs(p @ v) / (len(v) - u))), "square each"),
        (of_sigma0(lambda v, p, u: np.std(v)), "np.std"),
        (of_sigma0(lambda v, p, u: 1.01 * sigma0(v, p, u)), r"divided by\?$"),
        (changed(3, lambda a, *_: a[2] ** 2 * a[3]), "Q: that is the covariance"),
        (changed(3, lambda a, *_: np.linalg.inv(a[3])), "Q: that is N"),
        (changed(3, lambda a, *_: 2 * a[3]), r"Q: another matrix"),
        (lambda A, p, d: adjust(A, p, d)[0], "must return 4 things: x, v, sigma0, Q"),
        (unguarded_adjust, "plane through raw UTM coordinates comes out wrong"),
        (lambda A, p, d: None, "returns nothing yet"),
    ]
    assert unnamed(chapterA1.adjust, slips) == []


def test_who_left_out_the_normal_equations_is_sent_back_to_them():
    def not_yet(A, p, observed):
        return None

    def adjust(A, p, observed):
        N, n = not_yet(A, p, observed)
        return N, n, 0, 0

    with pytest.raises(CheckFailed, match="do the exercise before this one first"):
        chapterA1.adjust(adjust)


def weightless(A, p):
    return 1 - np.diag(A @ np.linalg.inv(A.T @ np.diag(p) @ A) @ A.T)


def test_slip_in_redundancy_numbers_is_named():
    slips = [
        (lambda A, p: 1 - redundancy_numbers(A, p), "subtract it from 1"),
        (lambda A, p: redundancy_numbers(A, 1 + 0 * p), "weights are left out"),
        (weightless, "one of the weights is missing"),
        (lambda A, p: redundancy_numbers(A, p)[::-1], "diagonal you take is another"),
        (lambda A, p: 2 * redundancy_numbers(A, p), "their sum must be"),
        (lambda A, p: np.sqrt(redundancy_numbers(A, p)), "those are their roots"),
        (lambda A, p: np.sqrt(1 - redundancy_numbers(A, p)), "of the other shares"),
        (lambda A, p: redundancy_numbers(A, p) + 2 * (p - p.mean()), "outside 0 and 1"),
    ]
    assert unnamed(chapterA1.redundancy_numbers, slips) == []


def signed(v, sigma, r):
    w = v[r > 0] / (sigma[r > 0] * np.sqrt(r[r > 0]))
    return np.argmax(w) if np.max(w) > 3.29 else -1


def where(v, sigma, r):
    """Right: w is computed everywhere, but that of r = 0 is thrown away."""
    w = np.abs(np.where(r > 0, v / (sigma * np.sqrt(r)), 0))
    return np.argmax(w) if w.max() > 3.29 else -1


def plain(v, sigma, r):
    w = np.abs(v / (sigma * np.sqrt(r)))
    return np.argmax(w) if w.max() > 3.29 else -1


def ignoring_nan(v, sigma, r):
    w = np.abs(v / (sigma * np.sqrt(r)))
    return np.nanargmax(w) if np.nanmax(w) > 3.29 else -1


def without_root(v, sigma, r):
    return where(v, sigma, r**2)


def other_limit(limit):
    def found(v, sigma, r):
        w = np.abs(np.where(r > 0, v / (sigma * np.sqrt(r)), 0))
        return np.argmax(w) if w.max() > limit else -1

    return found


def test_a_division_by_zero_that_is_thrown_away_passes(capsys):
    chapterA1.suspect(where)
    assert "✓" in capsys.readouterr().out


def argmin(v, sigma, r):
    """The smallest w with its sign, as if only negative residuals were suspicious."""
    w = np.where(r > 0, v / (sigma * np.sqrt(r)), 0)
    return np.argmin(w) if w.min() < -3.29 else -1


def above(v, sigma, r):
    """All rows above the limit, or -1."""
    w = np.abs(np.where(r > 0, v / (sigma * np.sqrt(r)), 0))
    return np.append(np.flatnonzero(w > 3.29), [] if w.max() > 3.29 else -1).astype(int)


def unguarded(v, sigma, r):
    with np.errstate(all="ignore"):
        w = np.abs(v / (sigma * np.sqrt(r)))
    return np.argmax(w) if not np.max(w) <= 3.29 else -1


def test_slip_in_the_search_for_a_suspect_is_named():
    slips = [
        (lambda v, sigma, r: np.argmax(np.abs(v)), "largest residual need not"),
        (lambda v, sigma, r: np.argmax(np.abs(v / sigma)), "smaller than sigma"),
        (lambda v, sigma, r: suspect(v, sigma, r) + 1, "counts rows from 0"),
        (signed, "negative residual can be as suspicious"),
        (lambda v, sigma, r: 3, "another observation has the largest"),
        (lambda v, sigma, r: argmin(v, sigma, r), "positive residual can be as"),
        (lambda v, sigma, r: above(v, sigma, r)[0], "not the first above 3.29"),
        (lambda v, sigma, r: above(v, sigma, r)[-1], "not the last above 3.29"),
        (lambda v, sigma, r: suspect(v, sigma, r) or -1, "row 0 is a row"),
        (
            lambda v, sigma, r: suspect(v[r > 0], sigma[r > 0], r[r > 0]),
            "keeps its row",
        ),
        (lambda v, sigma, r: where(v, sigma / r, r), "is r in the denominator"),
        (lambda v, sigma, r: np.argmax(abs(v / sigma * r)), "r tells how much smaller"),
        (
            lambda v, sigma, r: np.argmax(np.abs(v / (sigma * np.sqrt(r + 1e-12)))),
            "the answer must be -1",
        ),
        (without_root, "divide by the root of r, not by r"),
        (lambda v, sigma, r: where(v, sigma**2, r), "not by its square"),
        (other_limit(3.5), "a .w. of 3.31 is passed over"),
        (other_limit(1.96), r"no \|w\| is above 3.29 here"),
        (other_limit(3.2), r"the answer must be -1\.$"),
        (other_limit(0), r"the answer must be -1\.$"),
        (unguarded, "r = 0 has no w: leave it out before dividing"),
        (plain, "r = 0 has no w: leave it out before dividing"),
        (ignoring_nan, "r = 0 has no w: leave it out before dividing"),
    ]
    assert unnamed(chapterA1.suspect, slips) == []


@pytest.mark.parametrize("off", [1e-6, 1e-4])
def test_near_misses_do_not_pass(off):
    with pytest.raises(CheckFailed):
        chapterA1.redundancy_numbers(lambda *a: redundancy_numbers(*a) * (1 + off))
    for check, function in [
        (chapterA1.normal_equations, normal_equations),
        (chapterA1.adjust, adjust),
    ]:
        with pytest.raises(CheckFailed):
            check(lambda *a, function=function: [(1 + off) * b for b in function(*a)])
