"""Feedback on the exercises of chapter 3, least squares matching."""

from collections.abc import Callable
from itertools import product

import numpy as np

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    answer_of,
    call,
    chance,
    first_slip,
    near,
    report,
    shaken,
    shuffled,
    varied,
)
from pgm_book.program import lsm as textbook
from pgm_lab import simulate

SINGLE = 1e-6  # an answer in single precision is right


def row_shift(function: Callable) -> None:
    """Check row_shift(A, B), the step of one unknown."""

    def step(slope: np.ndarray, d: np.ndarray) -> float:
        return slope @ d / (slope @ slope)

    rng = chance(31)
    rounded = "the answer is rounded; keep all its digits"
    across = "the slope is the difference across two pixels, divided by 2"
    one_sided = "the slope at a pixel is taken from both of its neighbours (B 2.12)"
    answers, steps, rows = [], [], []
    for n in (21, 41):
        A, B = np.cumsum(rng.normal(0, 9, (2, n)), axis=1) + 120
        answers.append(float(call(function, A, B, shape=(), single=True)))
        g, d = (B[2:] - B[:-2]) / 2, (A - B)[1:-1]
        own, ahead = (A[2:] - A[:-2]) / 2, np.diff(B)
        a = step(g, d)
        steps.append(a)
        rows.append(
            [
                (-a, "the sign is reversed: what is observed is A minus B"),
                (a / 2, across),
                (2 * a, across),
                (
                    np.mean(d / g),
                    "a mean of all quotients lets flat pixels count as much as steep"
                    " ones",
                ),
                (
                    d.sum() / g.sum(),
                    "the steep pixels count more than the flat ones: use least squares",
                ),
                (g @ d, "the normal equation is not divided by its coefficient"),
                (
                    step(own, d),
                    "those are the slopes of A; B is the one that is moved",
                ),
                (step(ahead[:-1], d), one_sided),
                (step(ahead, (A - B)[:-1]), one_sided),
                (
                    step(np.gradient(B), A - B),
                    "the first and the last pixel have no two neighbours; leave them"
                    " out",
                ),
                (round(a, 2), rounded),
                (round(a, 3), rounded),
            ]
        )
    slips = [([wrong for wrong, _ in pair], pair[0][1]) for pair in zip(*rows)]
    otherwise = "it is not the least squares solution of slope times a = A − B"
    hint = first_slip(answers, slips, otherwise)
    right = near(answers, steps, SINGLE)
    report("row_shift", [("the step of least squares", right, hint)])


def design(function: Callable) -> None:
    """Check design(B, Bx, By, x, y, h1), which answers (k, 8)."""
    rng = chance(32)
    k = 12
    B, Bx, By = rng.normal((120, 3, -4), (30, 8, 6), (k, 3)).T
    x, y = rng.integers(-9, 10, (2, k)).astype(float)
    h1 = shaken(33, 1.7)
    answer = call(function, B, Bx, By, x, y, h1, shape=(k, 8), single=True)
    one = np.ones(k)
    gx, gy = h1 * Bx, h1 * By
    expected = np.array([gx, x * gx, y * gx, gy, x * gy, y * gy, one, B]).T
    shifts, shape = [0, 3], [1, 2, 4, 5]
    mixed = "a1 and a2 go with Bx, b1 and b2 with By"
    without = list(product((1.0, h1), repeat=2))[1:]
    lacking = list(product((1.0, h1), repeat=4))[1:]
    order = ""
    alike = [[near(a, e, SINGLE) for e in expected.T] for a in answer.T]
    if np.any(alike, axis=0).all() and np.any(alike, axis=1).all():
        order = "a column stands in the place of another: look at the order"
    of_shifts = [
        *((expected[:, shifts] / w, "h1 is missing at a slope") for w in without),
        (expected[:, [3, 0]], "the two slopes are exchanged"),
        (expected[:, [0, 0]], "the window moves along By when b0 changes"),
        (-expected[:, shifts], "the sign of the slopes is reversed"),
    ]
    of_shape = [
        *((expected[:, shape] / w, "h1 is missing at a slope") for w in lacking),
        (-expected[:, shape], "the sign of the slopes is reversed"),
        (expected[:, [2, 1, 5, 4]], "x and y are exchanged"),
        (expected[:, [2, 1, 4, 5]], "a1 and a2 are exchanged"),
        (expected[:, [1, 2, 5, 4]], "b1 and b2 are exchanged"),
        *(
            (expected[:, columns], mixed)
            for columns in (
                [1, 4, 2, 5],
                [1, 2, 2, 5],
                [1, 4, 4, 5],
                [4, 5, 1, 2],
                [1, 2, 1, 2],
            )
        ),
    ]
    of_h1 = [
        (one[:, None], "that is the column of h0: the two could not be told apart"),
        (h1 * B[:, None], "the column of h1 does not contain h1"),
        (h1 * one[:, None], "the column of h1 does not contain h1"),
    ]
    moves = "how far does a pixel at (x, y) move when a1, a2, b1 or b2 changes?"
    offset = (
        "an offset changes every grey value by the same amount: what is its column?"
    )
    properties: list[tuple[str, list[int], list[tuple[np.ndarray, str]], str]] = [
        ("shifts", shifts, of_shifts, "how does h1 B change when the window shifts?"),
        ("scales and shears", shape, of_shape, moves),
        ("h0", [6], [], offset),
        ("h1", [7], of_h1, "how does h0 + h1 B change with h1?"),
    ]
    right = {
        name: near(answer[:, which], expected[:, which], SINGLE)
        for name, which, _, _ in properties
    }
    found: list[tuple[str, bool | None, str]] = []
    said = set()
    for name, which, slips, otherwise in properties:
        hint = first_slip(answer[:, which], slips, order or otherwise)
        holds = along_with(right[name], sum(right.values()) > 1)  # ones are h0's
        if holds is False and hint in said:  # one slip is named once
            holds = None
        found.append((name, holds, hint))
        said.add(hint)
    report("design", found)


# --- The iteration of least squares matching: when it ends, what it finds ---

LAST = "sigma0 and Q are not those of the last adjustment"


def stop(function: Callable) -> None:
    """Check stop(step, half): whether no pixel moves by more than 0.01 px.

    The last two of a step, of h0 and h1, move no pixel; here they are large.
    """
    small = (0.004, 1e-4, -2e-4, -0.003, 2e-4, 1e-4)
    log = (-0.0495, 0.01096, -0.12710, 0.0603, -0.02777, -0.03908)
    shear, negative = (0, 0, 0.004, 0, 0, 0), (0, -0.004, 0, 0, 0, -0.003)
    diagonals = (0, 0.002, -0.002, 0, 0, 0), (0, 0, 0, 0, 0.002, 0.002)
    # The corner of a window of 21 pixels moves by 0.0095 px, or by 0.0105 px
    rest = (0, 9.5e-4, 0, 0, 0, 0), (0, 0, 0, 0, 0, -9.5e-4)
    aslant = (0.009, 0, 0, 0.009, 0, 0)  # 0.0127 px, but less than the limit in both
    sums = (0.004, 4e-4, 4e-4, 0, 0, 0), (0.004, 6.5e-4, 0, 0, 0, 0)
    # What holds, whether these steps end it, in windows how many times as large
    claims: list[tuple[str, bool, int, tuple, str]] = [
        ("small steps end it", True, 1, (small,), "it goes on after small steps"),
        (
            "shifts are looked at",
            False,
            1,
            ((0.4, 0, 0, 0, 0, 0), (0, 0, 0, 0.3, 0, 0)),
            "it stops although the window still shifts",
        ),
        (
            "both signs",
            False,
            1,
            ((-0.4, 0, 0, -0.2, 0, 0),),
            "it stops at a large negative shift",
        ),
        (
            "shape is looked at",
            False,
            1,
            (shear, negative, log),
            "it stops although the corners of the window still move",
        ),
        (
            "rows as well as columns",
            False,
            1,
            ((0, 0, 0, 0, 0.004, 0),),
            "b1 and b2 move the corners, too: it stops although the rows still change",
        ),
        (
            "all four corners",
            False,
            1,
            diagonals,
            "there is a corner that it does not look at, and that one still moves",
        ),
        (
            "the parts add up",
            False,
            1,
            sums,
            "each part is small, but in one corner of the window they add up to more",
        ),
        (
            "the size of the window counts",
            False,
            4,
            (tuple(0.9 * np.array(small)),),
            "the same step moves the corner of a large window by more than 0.01 px",
        ),
        (
            "the window ends at half",
            True,
            1,
            rest,
            "it goes on although no pixel from −half to half moves by 0.01 px",
        ),
        (
            "x and y each have the limit",
            True,
            1,
            (aslant,),
            "it goes on although no pixel moves by more than 0.01 px in x or in y:"
            " compare each with the limit, not the distance",
        ),
    ]
    trials = [
        (k, times, step)
        for k, (_, _, times, steps, _) in enumerate(claims)
        for step in steps
    ]
    answers = _stops(function, trials)
    holds = [
        all(said == ends for (which, *_), said in zip(trials, answers) if which == k)
        for k, (_, ends, *_) in enumerate(claims)
    ]
    # One slip fails many: the first two are enough to read
    read = [k for k, good in enumerate(holds) if not good][:2]
    both = len(set(answers)) == 2
    counted = [
        along_with(good, both) if good or k in read else None
        for k, good in enumerate(holds)
    ]
    told = [(text, good, hint) for good, (text, *_, hint) in zip(counted, claims)]
    report("stop", told, "small steps end it, and no other")


def _stops(function: Callable, trials: list[tuple[int, int, tuple]]) -> list[bool]:
    """What the reader's function says to steps of a0, a1, a2, b0, b1, b2."""
    half = varied(35, 10, lambda rng: int(rng.choice([7, 8, 9, 11, 12])))
    scale = np.array([1, 10 / half, 10 / half, 1, 10 / half, 10 / half, 1, 1])
    scale = scale * shaken(36, np.ones(8), 0.003)
    said = [False] * len(trials)
    for k in shuffled(40, len(trials)):
        _, times, step = trials[k]
        full = np.array([*step, 0.3, -0.02]) * scale
        said[k] = bool(call(function, full, times * half, shape=()))
    return said


def match(function: Callable) -> None:
    """Check match(left, right, point, start, size), which answers trail, sigma0, Q."""
    fixed = np.array([2.3, 1.02, 0.05, -1.6, -0.03, 0.99])
    reach = np.array([0.4, 0.02, 0.02, 0.4, 0.02, 0.02])
    affine = varied(37, fixed, lambda rng: fixed + reach * rng.uniform(-1, 1, 6))
    gain, offset = shaken(38, (1.1, 5.0))
    texture, noise = varied(39, (1, 3), lambda rng: tuple(rng.integers(1000, size=2)))
    left, right = simulate.texture_pair(
        simulate.texture(seed=texture),
        (70, 70),
        affine,
        sigma=0.5,
        seed=noise,
        gain=gain,
        offset=offset,
    )
    point = (33, 36)
    place = affine.reshape(2, 3) @ (1, *point)
    start = np.array([round(place[0]), 1, 0, round(place[1]), 0, 1, 0, 1.0])
    try:
        answer = answer_of(function, left, right, point, start, 21)
    except CheckFailed as error:
        if "broadcast" in str(error) or "p must" in str(error):
            raise CheckFailed(
                "match: the arrays of adjust do not fit. Wanted are J (n, 8), one"
                " weight for each pixel, an array (n,) and no matrix, and the n"
                " observed values"
            ) from error
        if "outside the image" in str(error):
            raise CheckFailed(
                "match: the parameters lead out of the photo. Append p + step, the"
                " improved parameters, as one row; observed is A minus (h0 + h1 B)"
            ) from error
        raise
    if not isinstance(answer, tuple | list) or len(answer) != 3:
        raise CheckFailed("match must return three things: trail, sigma0, Q")
    trail, sigma0, Q = (np.asarray(part, dtype=float) for part in answer)
    if trail.ndim != 2 or trail.shape[1] != 8 or Q.shape != (8, 8) or sigma0.shape:
        raise CheckFailed(
            "match must return trail of shape (k, 8), the number sigma0 and Q of shape"
            f" (8, 8); got {trail.shape}, {sigma0.shape} and {Q.shape}"
        )
    found = trail[-1]
    off = float(np.hypot(*(found[[0, 3]] - place)))
    away = (
        "the observed values are A minus (h0 + h1 B): the parameters diverge"
        if not off < 2
        else "the position is not found"
    )
    if len(trail) > 1 and np.all(np.abs(found[[1, 5]]) < 0.5):
        away = "a step is added to the parameters; it does not replace them"
    elif np.allclose(found[6:], (0, 1)):
        away = "h0 and h1 are left where they began"
    book = textbook.match(left, right, point, start, 21)
    first = book[0][1] - start
    if len(trail) > 1 and near(trail[1, :6] - start[:6], -first[:6], 1e-3):
        away = (
            "the steps have the wrong sign: add those that explain A minus (h0 + h1 B)"
        )
    on_place = off < 0.01
    light = abs(found[7] - 1 / gain) < 0.02 and abs(found[6] + offset / gain) < 2.5
    squared = [(book[1] ** 2, "sigma0 is a standard deviation, not its square")]
    of_Q = "the cofactor matrix is asked for: sigma0 squared stays outside of Q"
    own, wanted = np.diag(Q), np.diag(book[2])
    alike = near(sigma0 / book[1], 1, 0.05)
    said = first_slip(sigma0, squared, LAST, 0.05)
    if not alike and np.allclose(sigma0**2 * own, book[1] ** 2 * wanted, 0.05):
        said = "sigma0 and Q fit together, but every pixel has the weight 1"
    if alike and near(own / (book[1] ** 2 * wanted), 1, 0.1):
        said = of_Q
    whole = len(trail) > 1 and near(trail[1, :6], book[0][1, :6], 2e-5)
    report(
        "match",
        [
            ("the place, to a hundredth of a pixel", on_place, away),
            (
                "contrast and brightness",
                light if on_place else None,
                "the place is right; h0 and h1 are not those of left = h0 + h1 right",
            ),
            (
                "sigma0 and Q",
                alike and near(own / wanted, 1, 0.1) if on_place else None,
                said,
            ),
            (
                "the trail",
                near(trail[0], start) and whole if on_place and light else None,
                "only a part of a step is added to the parameters, or it is rounded"
                if near(trail[0], start)
                else "the first row of the trail is not the start any more: p += step"
                " changes the row that p stands for, or the trail was begun anew",
            ),
        ],
    )
