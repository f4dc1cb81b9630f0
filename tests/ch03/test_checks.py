"""Exercise feedback of chapter 3: right answers pass, each slip is named."""

import numpy as np
import pytest

from pgm_book.ch03 import case_checks, checks
from pgm_book.common.checks import CheckFailed
from pgm_book.program import adjustment, lsm
from tests.common.slips import unnamed

A, B, START = case_checks.PRINTED_A, case_checks.PRINTED_B, case_checks.PRINTED_START
ROW = START[1] + B @ (1, *START)
PRINTED_ROW = 1049.06028818143


def columns(B, Bx, By, x, y, h1):
    gx, gy = h1 * Bx, h1 * By
    return np.array([gx, x * gx, y * gx, gy, x * gy, y * gy, np.ones_like(B), B]).T


def precision(J, v):
    S0 = np.sqrt(v @ v / (J.shape[0] - J.shape[1]))
    return S0, S0 * np.sqrt(np.linalg.inv(J.T @ J)[0, 0])


def stop(q, half, limit=0.01):
    reach = np.abs(q[:6]) * np.tile([1, half, half], 2)
    return reach[:3].sum() <= limit and reach[3:].sum() <= limit


def test_right_answers_pass(capsys):
    case_checks.corrected_row(ROW)
    case_checks.corrected_row(np.float32(ROW))  # 6e-5 px from it
    checks.design(columns)
    case_checks.precision(precision)
    case_checks.precision(lambda J, v: list(precision(J, v)))
    checks.stop(stop)
    assert capsys.readouterr().out.count("✓") == 6


def test_stop_may_name_all_eight_corrections():
    def by_name(step, half):
        a0, a1, a2, b0, b1, b2, h0, h1 = np.abs(step)
        return max(a0 + half * (a1 + a2), b0 + half * (b1 + b2)) <= 0.01

    checks.stop(by_name)


def test_stop_says_two_things_at_most():
    with pytest.raises(CheckFailed) as failed:
        checks.stop(lambda step, half: True)
    assert str(failed.value).count(";") == 1


def test_every_pixel_of_the_window_is_as_good_as_its_corners():
    def by_pixel(q, half):
        y, x = np.mgrid[-half : half + 1, -half : half + 1]
        moved = [q[k] + q[k + 1] * x + q[k + 2] * y for k in (0, 3)]
        return bool(np.max(np.abs(moved)) <= 0.01)

    checks.stop(by_pixel)


def changed(*edits):
    """Right columns, with some of them replaced by what a function of all gives."""

    def function(B, Bx, By, x, y, h1):
        J = columns(B, Bx, By, x, y, h1)
        for k, edit in edits:
            J[:, k] = edit(B, Bx, By, x, y, h1)
        return J

    return function


SWAPPED = (
    (1, lambda B, Bx, By, x, y, h1: y * h1 * Bx),
    (2, lambda B, Bx, By, x, y, h1: x * h1 * Bx),
    (4, lambda B, Bx, By, x, y, h1: y * h1 * By),
    (5, lambda B, Bx, By, x, y, h1: x * h1 * By),
)


def s0(J, v):
    return precision(J, v)[0]


def cofactor(J):
    return np.linalg.inv(J.T @ J)[0, 0]


def test_wrong_s0_carried_on_is_named_once():
    def carried(J, v):
        S0 = np.sqrt(v @ v) / (len(J) - J.shape[1])
        return S0, S0 * np.sqrt(cofactor(J))

    with pytest.raises(CheckFailed) as failed:
        case_checks.precision(carried)
    assert "root ends too early" in str(failed.value)
    assert "does not follow" not in str(failed.value)


def corners(q, half, sides):
    """Look at the corners of one diagonal only: (x, y) = (s, side * s) half windows."""
    at = [(1, s * half, side * s * half) for s in (-1, 1) for side in sides]
    return max(abs(c @ q[k : k + 3]) for c in np.array(at) for k in (0, 3)) <= 0.01


def by_distance(q, half):
    at = np.array([(1, x, y) for x in (-half, half) for y in (-half, half)])
    return np.hypot(at @ q[:3], at @ q[3:6]).max() <= 0.01


def limits_of_the_listing(q, half):
    a0, a1, a2, b0, b1, b2 = np.abs(q[:6])
    return (a1 <= 0.03 or b2 <= 0.03) and (a2 <= 0.03 or b1 <= 0.03)


def test_answers_are_not_given_away():
    for check, wrong in (
        (case_checks.corrected_row, 1050.0),
        (case_checks.precision, lambda J, v: (0.0, 0.0)),
    ):
        with pytest.raises(CheckFailed) as failed:
            check(wrong)
        text = str(failed.value)
        assert "1049" not in text and "sqrt" not in text


def row_shift(A, B):
    g, d = (B[2:] - B[:-2]) / 2, (A - B)[1:-1]
    return g @ d / (g @ g)


def matched(*edits):
    """The book's match, its answer changed by functions of trail, sigma0 and Q."""

    def match(left, right, point, start, size):
        answer = list(lsm.match(left, right, point, start, size))
        for k, edit in edits:
            answer[k] = edit(answer[k])
        return answer

    return match


def with_a_matrix(adjust):
    """A match whose weights are a matrix, as in many textbooks."""

    def match(left, right, point, start, size):
        return adjust(np.ones((size**2, 8)), np.eye(size**2), np.ones(size**2))

    return match


def adjust_unasked(A, p, observed):
    """The reader's own, which doesn't look at what it gets."""
    return np.linalg.solve(A.T @ (p[:, None] * A), A.T @ (p * observed))


def test_a_right_match_passes():
    checks.row_shift(row_shift)
    checks.row_shift(lambda A, B: np.float32(row_shift(A, B)))
    checks.design(lambda *a: columns(*a).astype(np.float32))
    checks.match(matched())
    checks.match(lambda *a: tuple(matched()(*a)))


def in_a_loop(kept, weight=1.0):
    """The match of the lesson: `kept` gives the trail after a step."""

    def match(left, right, point, start, size):
        y, x = np.mgrid[:size, :size].reshape(2, -1) - size // 2
        A = left[point[1] + y, point[0] + x].astype(float)
        trail = [np.array(start, dtype=float)]
        for _ in range(12):
            p = trail[-1]
            B, Bx, By = lsm.resampled(right, p, x, y)
            J = lsm.design(B, Bx, By, x, y, p[7])
            missing = A - (p[6] + p[7] * B)
            step, _, sigma0, Q = adjustment.adjust(J, np.full(len(A), weight), missing)
            trail = kept(trail, p, step)
        return np.array(trail), sigma0, Q

    return match


SLIPS = {
    case_checks.corrected_row: [
        (..., "still empty"),
        (None, "still empty"),
        ("ten", "must be one number"),
        ((1.0, 2.0), "must be one number"),
        (PRINTED_ROW, "that is the printed row"),
        (ROW - START[1], "that is the correction"),
        (2 * START[1] - ROW, "added, not subtracted"),
        (START[1] + B @ (1, *START[::-1]), "column and row are exchanged"),
        (START[0] + B @ (1, *START), "starts from the row of the start"),
        (START[0] + A @ (1, *START), "that is the column"),
        (START[1] + A @ (1, *START), "takes b0, b1, b2"),
        (START[1] + B[0], "b1 and b2 are missing"),
        (ROW + 0.001, "does not follow"),
    ],
    checks.design: [
        (lambda *a: None, "returns nothing"),
        (lambda *a: columns(*a).T, "must return shape"),
        (lambda B, Bx, By, x, y, h1: columns(B, Bx, By, x, y, 1.0), "h1 is missing at"),
        (lambda B, Bx, By, x, y, h1: columns(B, By, Bx, x, y, h1), "two slopes are"),
        (lambda B, Bx, By, x, y, h1: columns(B, -Bx, -By, x, y, h1), "sign of the slo"),
        (changed(*SWAPPED), "x and y are exchanged"),
        (lambda *a: columns(*a)[:, [0, 2, 1, 3, 4, 5, 6, 7]], "a1 and a2 are exch"),
        (lambda *a: columns(*a)[:, [0, 1, 2, 3, 5, 4, 6, 7]], "b1 and b2 are exch"),
        (lambda *a: columns(*a)[:, [0, 1, 4, 3, 2, 5, 6, 7]], "a1 and a2 go with Bx"),
        (lambda *a: columns(*a)[:, [0, 1, 2, 3, 2, 5, 6, 7]], "b1 and b2 with By"),
        (lambda *a: columns(*a)[:, [0, 1, 4, 3, 4, 5, 6, 7]], "a1 and a2 go with Bx"),
        (lambda *a: columns(*a)[:, [0, 4, 5, 3, 1, 2, 6, 7]], "a1 and a2 go with Bx"),
        (
            lambda *a: columns(*a)[:, [0, 3, 1, 2, 4, 5, 6, 7]],
            "look at the order",
        ),
        (changed((1, lambda *a: np.zeros_like(a[0]))), "how far does a pixel at"),
        (changed((6, lambda *a: a[0])), "offset changes every grey value"),
        (changed((7, lambda *a: np.ones_like(a[0]))), "the column of h0: the two"),
        (changed((7, lambda *a: a[5] * a[0])), "does not contain h1"),
        (changed((1, lambda *a: a[3] * a[1])), "h1 is missing at a slope"),
        (changed((3, lambda *a: a[2])), "h1 is missing at a slope"),
        (lambda *a: columns(*a)[:, [0, 1, 2, 0, 1, 2, 6, 7]], "along By .*; a1 and a2"),
        (lambda *a: columns(*a)[:, [0, 3, 1, 4, 2, 5, 6, 7]], "look at the order"),
        (changed((7, lambda *a: np.zeros_like(a[0]))), "how does h0"),
    ],
    case_checks.precision: [
        (lambda J, v: None, "returns nothing"),
        (lambda J, v: s0(J, v), "must return shape"),
        (
            lambda J, v: (np.sqrt(v @ v) / (len(J) - J.shape[1]), precision(J, v)[1]),
            "root ends too early",
        ),
        (
            lambda J, v: (np.sqrt(v @ v / len(J)), precision(J, v)[1]),
            "not by the number of pixels",
        ),
        (lambda J, v: (s0(J, v) ** 2, precision(J, v)[1]), "that is the variance"),
        (lambda J, v: (np.sqrt(v @ v), precision(J, v)[1]), "divide by the redundancy"),
        (lambda J, v: (s0(J, v), np.sqrt(cofactor(J))), "the noise of the images"),
        (lambda J, v: (s0(J, v), s0(J, v) * cofactor(J)), "root of the element"),
        (lambda J, v: (s0(J, v), s0(J, v) ** 2 * cofactor(J)), "that is the variance"),
        (lambda J, v: (s0(J, v), s0(J, v)), "the slopes convert it into pixels"),
        (lambda J, v: (s0(J, v), s0(J, v) / np.linalg.norm(J[:, 0])), "the whole mat"),
        (lambda J, v: (s0(J, v), 1 / np.linalg.norm(J[:, 0])), "the whole matrix"),
        (lambda J, v: (np.sqrt(v @ v / (len(J) - 8)), 0.01), "rows and columns of J"),
        (lambda J, v: (np.sqrt(v @ v / 283), 0.01), "rows and columns of J"),
        (lambda J, v: (s0(J, v), 0.01), "does not follow from S0"),
        (lambda J, v: (0.5, precision(J, v)[1]), "not that of"),
    ],
    checks.stop: [
        (lambda q, half: None, "returns nothing"),
        (lambda q, half: False, "goes on after small steps"),
        (lambda q, half: True, "the window still shifts"),
        (limits_of_the_listing, "the window still shifts"),
        (
            lambda q, half: np.hypot(q[0], q[3]) <= 0.01,
            "corners of the window still move",
        ),
        (
            lambda q, half: (np.abs(q[:6]) * np.tile([1, half, half], 2)).max() <= 0.01,
            "add up to more",
        ),
        (lambda q, half: stop(q, 10), "a large window"),
        (
            lambda q, half: max(q[:3].sum(), q[3:6].sum()) <= 0.01,
            "large negative shift",
        ),
        (
            lambda q, half: np.abs(q[:6]).max() <= 0.01,
            "corners of the window still move",
        ),
        (lambda q, half: corners(q, half, (1,)), "a corner that it does not look at"),
        (lambda q, half: corners(q, half, (-1,)), "a corner that it does not look at"),
        (lambda q, half: stop(q[:6] * [1, 1, 1, 1, 0, 0], half), "b1 and b2 move"),
        (lambda q, half: stop(q[:6] * [1, 1, 1, 1, 0, 1], half), "b1 and b2 move"),
        (lambda q, half: np.abs(q).max() <= 0.01, "goes on after small steps"),
        (lambda q, half: stop(q, 2 * half), "although no pixel from"),
        (lambda q, half: stop(q, half + 1), "although no pixel from"),
        (lambda q, half: stop(q, half * 2**0.5), "although no pixel from"),
        (lambda q, half: stop(q, half - 1), "add up to more"),
        (by_distance, "not the distance"),
    ],
    checks.row_shift: [
        (lambda A, B: -row_shift(A, B), "sign is reversed"),
        (lambda A, B: row_shift(A, B) / 2, "divided by 2"),
        (
            lambda A, B: np.mean(((A - B) / np.gradient(B))[1:-1]),
            "flat pixels count as much",
        ),
        (lambda A, B: round(row_shift(A, B), 3), "rounded"),
        (
            lambda A, B: np.diff(B)[:-1] @ (A - B)[1:-1] / (np.diff(B)[:-1] ** 2).sum(),
            "from both of its neighbours",
        ),
        (
            lambda A, B: np.diff(B) @ (A - B)[:-1] / (np.diff(B) ** 2).sum(),
            "from both of its neighbours",
        ),
        (
            lambda A, B: row_shift(A, B) * 1.3,
            "not the least squares solution",
        ),
    ],
    checks.match: [
        (lambda *a: None, "returns nothing"),
        (lambda *a: matched()(*a)[0], "three things"),
        (matched((0, lambda t: t[-1])), "trail of shape"),
        (with_a_matrix(adjustment.adjust), "an array .n,. and no matrix"),
        (with_a_matrix(adjust_unasked), "an array .n,. and no matrix"),
        (matched((0, lambda t: t + [0.2, 0, 0, 0, 0, 0, 0, 0])), "not found"),
        (matched((0, lambda t: np.diff(t, axis=0))), "added to the parameters"),
        (matched((0, lambda t: t + 0.5 * np.eye(8)[7])), "h0 and h1 are not those"),
        (matched((1, lambda s: s**2 * 9)), "sigma0 and Q"),
        (matched((2, lambda Q: np.linalg.inv(Q))), "sigma0 and Q"),
        (matched((1, lambda s: s**2)), "not its square"),
        (matched((0, lambda t: 2 * t[0] - t)), "the wrong sign"),
        (matched((2, lambda Q: 0.465 * Q)), "stays outside of Q"),
        (matched((0, lambda t: np.tile(t[-1], (len(t), 1)))), "first row of the trail"),
        (matched((0, lambda t: np.r_[t[:1], t[1:].round(2)])), "or it is rounded"),
        (
            matched((0, lambda t: np.r_[t[:1], t[:2].mean(0)[None], t[1:]])),
            "only a part of a step",
        ),
        (in_a_loop(lambda trail, p, step: [*trail, step]), "Append p . step"),
        (in_a_loop(lambda trail, p, step: [p + step]), "begun anew"),
        (in_a_loop(lambda trail, p, step: [*trail, p + step], 0.5), "the weight 1"),
    ],
}


@pytest.mark.parametrize("check", SLIPS, ids=lambda check: check.__name__)
def test_each_slip_is_named(check):
    assert unnamed(check, SLIPS[check]) == []
