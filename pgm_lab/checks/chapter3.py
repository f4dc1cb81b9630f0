"""Feedback on the exercises of chapter 3, least squares matching."""

from collections.abc import Callable
from itertools import product

import numpy as np

from pgm_lab.checks import call, first_slip, near, report
from pgm_lab.checks._iteration import match as match
from pgm_lab.checks._iteration import stop as stop

SINGLE = 1e-6  # an answer in single precision is right


def row_shift(function: Callable) -> None:
    """Check row_shift(A, B), the step of one unknown."""
    rng = np.random.default_rng(31)
    answers, slips, steps = [], [], []
    for n in (21, 41):
        A, B = np.cumsum(rng.normal(0, 9, (2, n)), axis=1) + 120
        g, d = (B[2:] - B[:-2]) / 2, (A - B)[1:-1]
        answers.append(float(call(function, A, B, shape=(), single=True)))
        own, ahead = (A[2:] - A[:-2]) / 2, np.diff(B)
        steps.append(g @ d / (g @ g))
        slips.append(
            [
                -g @ d / (g @ g),
                g @ d / (g @ g) / 2,
                2 * (g @ d) / (g @ g),
                np.mean(d / g),
                d.sum() / g.sum(),
                g @ d,
                own @ d / (own @ own),
                np.diff(B)[:-1] @ d / (np.diff(B)[:-1] @ np.diff(B)[:-1]),
                ahead @ (A - B)[:-1] / (ahead @ ahead),
                np.gradient(B) @ (A - B) / (np.gradient(B) @ np.gradient(B)),
                round(g @ d / (g @ g), 2),
                round(g @ d / (g @ g), 3),
            ]
        )
    rounded = "the answer is rounded; keep all its digits"
    one_sided = "the slope at a pixel is taken from both of its neighbours (B 2.12)"
    hints = (
        "the sign is reversed: what is observed is A less what B gives",
        "the slope is the difference across two pixels, divided by 2",
        "the slope is the difference across two pixels, divided by 2",
        "a mean of all quotients lets flat pixels count as much as steep ones",
        "the steep pixels count more than the flat ones: use least squares",
        "the normal equation is not divided by its coefficient",
        "those are the slopes of A; B is the one that is moved",
        one_sided,
        one_sided,
        "the first and the last pixel have no two neighbours; leave them out",
        rounded,
        rounded,
    )
    hint = first_slip(
        answers,
        list(zip(np.transpose(slips), hints)),
        "it is not the least squares solution of slope times a = A − B",
    )
    right = near(answers, steps, SINGLE)
    report("row_shift", [("the step of least squares", right, hint)])


def design(function: Callable) -> None:
    """Check design(B, Bx, By, x, y, h1), which answers (k, 8)."""
    rng = np.random.default_rng(32)
    k = 12
    B, Bx, By = rng.normal((120, 3, -4), (30, 8, 6), (k, 3)).T
    x, y = rng.integers(-9, 10, (2, k)).astype(float)
    h1 = 1.7
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
    offset = "an offset changes every grey value by as much: what is its column?"
    properties: list[tuple[str, list[int], list[tuple[np.ndarray, str]], str]] = [
        ("shifts", shifts, of_shifts, "how does h1 B change when the window shifts?"),
        ("scales and shears", shape, of_shape, moves),
        ("h0", [6], [], offset),
        ("h1", [7], of_h1, "how does h0 + h1 B change with h1?"),
    ]
    found, said = [], {""}
    for name, which, slips, otherwise in properties:
        holds = near(answer[:, which], expected[:, which], SINGLE)
        hint = first_slip(answer[:, which], slips, order or otherwise)
        if holds or hint not in said:  # one slip is named once
            found.append((name, holds, hint))
            said.add("" if holds else hint)
    report("design", found)


def bilinear(function: Callable) -> None:
    """Check bilinear(image, column, row), which answers one grey value."""
    rng = np.random.default_rng(33)
    image = rng.integers(0, 256, (9, 9)).astype(np.uint8)
    points = [(2.25, 3.5), (6.75, 0.125), (0.5, 4.875), (4.0, 2.0)]
    answers = np.array([float(call(function, image, *p, shape=())) for p in points])

    def surface(
        product: int = 1,
        exchanged: bool = False,
        turned: bool = False,
        dtype: type = float,
    ) -> np.ndarray:
        """Grey values at all points, with the slips asked for."""
        grey: np.ndarray = image.astype(dtype)
        found = []
        for column, row in points:
            c, r = (row, column) if turned else (column, row)
            i, j = int(r), int(c)
            dx, dy = (r - i, c - j) if exchanged else (c - j, r - i)
            (g0, g1), (g2, g3) = grey[i : i + 2, j : j + 2]
            with np.errstate(over="ignore"):
                twist = (g3 + g0 - g1 - g2) * dx * dy * product
                found.append(g0 + (g1 - g0) * dx + (g2 - g0) * dy + twist)
        return np.array(found)

    def mixed(rest: Callable) -> np.ndarray:
        """Grey values with other parts of a pixel than dx and dy."""
        found = []
        for column, row in points:
            j, i = int(column), int(row)
            dx, dy = rest(column - j, row - i)
            found.append([1 - dy, dy] @ image[i : i + 2, j : j + 2] @ [1 - dx, dx])
        return np.array(found)

    expected = surface()
    run_over = "8 bit grey values overflow when they are subtracted: make them float"
    slips = [
        (np.floor(expected), "a fraction of a grey value is cut off"),
        (np.floor(expected + 0.5), "the grey value is rounded; keep its fraction"),
        (surface(product=0), "the term with dx dy is missing"),
        (surface(product=-1), "the sign of the term with dx dy is reversed"),
        (surface(exchanged=True), "dx and dy are exchanged"),
        (surface(turned=True), "an image is indexed [row, column]"),
        ([image[int(r), int(c)] for c, r in points], "that is the pixel before"),
        (surface(dtype=np.uint8), run_over),
        (mixed(lambda dx, dy: (dx, 0)), "dy changes nothing"),
        (mixed(lambda dx, dy: (0, dy)), "dx changes nothing"),
        (mixed(lambda dx, dy: (round(dx), round(dy))), "that is the nearest pixel"),
        ([image[round(r), round(c)] for c, r in points], "that is the nearest pixel"),
        (mixed(lambda dx, dy: (0.5, 0.5)), "dx and dy change nothing"),
        *(
            (mixed(turn), "the pixel that is nearer must count more")
            for turn in (
                lambda dx, dy: (1 - dx, 1 - dy),
                lambda dx, dy: (1 - dx, dy),
                lambda dx, dy: (dx, 1 - dy),
            )
        ),
        (surface(dtype=np.uint8, product=0), run_over),
    ]
    other = "a bilinear surface through the four pixels around has another value there"
    between = near(answers[:3], expected[:3])
    hint = first_slip(answers[:3], [(s[:3], text) for s, text in slips], other)
    at_pixel = near(answers[3], expected[3]) or not between
    report(
        "bilinear",
        [
            ("a pixel keeps its value", at_pixel, "at a pixel, its value is not kept"),
            ("between four pixels", between, hint),
        ],
    )
