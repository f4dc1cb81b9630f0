"""Feedback on the exercises of chapter 3, least squares matching."""

from collections.abc import Callable

import numpy as np

from pgm_lab.checks import call, first_slip, near, numbers, report

# The six parameters that Bani 2010, IV.1.3 prints, and the start from correlation
PRINTED_A = np.array([130.337718946127, 0.0109620254677122, -0.127097279435187])
PRINTED_B = np.array([48.5019337490267, -0.0277731169717486, -0.0390846759861233])
PRINTED_START = np.array([268.0, 1049.0])


def corrected_row(answer: object) -> None:
    """Check the corrected row of the printed point by (B 2.16), with the old column."""
    value = numbers("row", answer, wanted="one number, in pixels")
    X, Y = PRINTED_START
    new_X = X + PRINTED_A @ (1, X, Y)
    step = PRINTED_B @ (1, X, Y)
    slips = [
        (
            Y + PRINTED_B @ (1, new_X, Y),
            "that is the printed row: it takes the column that has just been updated;"
            " (B 2.16) takes the old one in both",
        ),
        (step, "that is the correction; add it to the row of the start"),
        (Y - step, "the correction is added, not subtracted"),
        (Y + PRINTED_B @ (1, Y, X), "column and row are exchanged"),
        (X + PRINTED_B @ (1, X, Y), "a row starts from the row of the start"),
        (new_X, "that is the column, worked out above; the row is wanted"),
        (Y + PRINTED_A @ (1, X, Y), "the row takes b0, b1, b2"),
        (Y + PRINTED_B[0], "b1 and b2 are missing"),
    ]
    # The two rows differ by 0.0014 px: a tenth of that is near enough
    hint = first_slip(value, slips, "the row does not follow from (B 2.16)", 1e-7)
    right = abs(value - (Y + step)) < 1.4e-4
    report("row", [("the row by (B 2.16)", right, hint)])


def columns(function: Callable) -> None:
    """Check columns(B, Bx, By, x, y, h1), which answers (k, 8)."""
    rng = np.random.default_rng(32)
    k = 12
    B, Bx, By = rng.normal((120, 3, -4), (30, 8, 6), (k, 3)).T
    x, y = rng.integers(-9, 10, (2, k)).astype(float)
    h1 = 1.7
    answer = call(function, B, Bx, By, x, y, h1, shape=(k, 8))
    one = np.ones(k)
    gx, gy = h1 * Bx, h1 * By
    expected = np.array([gx, x * gx, y * gx, gy, x * gy, y * gy, one, B]).T
    shifts, shape = [0, 3], [1, 2, 4, 5]
    mixed = "a1 and a2 go with Bx, b1 and b2 with By"
    of_shifts = [
        (expected[:, shifts] / h1, "h1 is missing at the slopes"),
        (expected[:, [3, 0]], "the two slopes are exchanged"),
        (-expected[:, shifts], "the sign of the slopes is reversed"),
    ]
    of_shape = [
        (expected[:, shape] / h1, "h1 is missing at them"),
        (expected[:, [2, 1, 5, 4]], "x and y are exchanged"),
        (expected[:, [2, 1, 4, 5]], "a1 and a2 are exchanged"),
        (expected[:, [1, 2, 5, 4]], "b1 and b2 are exchanged"),
        *(
            (expected[:, columns], mixed)
            for columns in ([1, 4, 2, 5], [1, 2, 2, 5], [1, 4, 4, 5], [4, 5, 1, 2])
        ),
    ]
    of_h1 = [
        (one[:, None], "with (B 2.17) as printed h0 and h1 cannot be told apart"),
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
    report(
        "my_columns",
        [
            (
                name,
                near(answer[:, k], expected[:, k]),
                first_slip(answer[:, k], slips, otherwise),
            )
            for name, k, slips, otherwise in properties
        ],
    )


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

    expected = surface()
    run_over = "8 bit grey values overflow when they are subtracted: make them float"
    slips = [
        (np.floor(expected), "a fraction of a grey value is cut off"),
        (np.floor(expected + 0.5), "the grey value is rounded; keep its fraction"),
        (surface(product=0), "t3, the term with dx dy, is missing"),
        (surface(product=-1), "the sign of t3, the term with dx dy, is reversed"),
        (surface(exchanged=True), "dx and dy are exchanged"),
        (surface(turned=True), "an image is indexed [row, column]"),
        ([image[int(r), int(c)] for c, r in points], "that is the pixel before"),
        (surface(dtype=np.uint8), run_over),
        (surface(dtype=np.uint8, product=0), run_over),
    ]
    other = "a bilinear surface through the four pixels around has another value there"
    between = near(answers[:3], expected[:3])
    hint = first_slip(answers[:3], [(s[:3], text) for s, text in slips], other)
    at_pixel = near(answers[3], expected[3]) or not between
    report(
        "my_bilinear",
        [
            ("a pixel keeps its value", at_pixel, "at a pixel, its value is not kept"),
            ("between four pixels", between, hint),
        ],
    )


def precision(function: Callable) -> None:
    """Check precision(J, v), which answers S0 and the standard deviation of a0."""
    rng = np.random.default_rng(34)
    names = ("S0", "the standard deviation of a0")
    rows, many = [], []
    for n, u in ((289, 6), (40, 8), (441, 8)):
        J = rng.normal(0, 5, (n, u)) * rng.uniform(1, 20, u)
        v = rng.normal(0, 6.5, n)
        answer = call(function, J, v, shape=(2,))
        S0 = np.sqrt(v @ v / (n - u))
        Q = np.linalg.inv(J.T @ J)
        rows.append((answer, (S0, S0 * np.sqrt(Q[0, 0]))))
        alone = 1 / np.linalg.norm(J[:, 0])
        many.append((n, u, np.sqrt(v @ v), np.sqrt(Q[0, 0]), Q[0, 0], S0, alone))
    answers, expected = np.array(rows).swapaxes(0, 1)
    n, u, root, q, q2, S0, alone = np.array(many).T
    shape = "n and u are the rows and columns of J; do not type them"
    whole = "invert the whole matrix, then take the element"
    of_s0 = [
        (root / (n - u), "the root ends too early: r stands under it, (B 2.14e)"),
        (root / np.sqrt(n), "divide by the redundancy, not by the number of pixels"),
        (S0**2, "that is the variance; take the root"),
        (root, "divide by the redundancy"),
        *((root / np.sqrt(n - typed), shape) for typed in (6, 8)),
        *((root / np.sqrt(typed), shape) for typed in (283, 32, 433, 281)),
    ]
    of_sd = [
        (
            q,
            "the root of the cofactor does not know how noisy the images are",
        ),
        (S0 * q2, "take the root of the element of the inverse"),
        (S0**2 * q2, "that is the variance; take the root"),
        (S0, "S0 is in grey values; the slopes turn it into pixels"),
        (S0 * alone, whole),
        (alone, whole),
    ]
    hint = first_slip(
        answers[:, 1] / expected[:, 1],
        [(wrong / expected[:, 1], text) for wrong, text in of_sd],
        "it does not follow from S0 and the inverse of JᵀJ",
        1e-9,
    )
    good = near(answers[:, 1] / expected[:, 1], 1.0)
    # Right in itself, from an S0 that is wrong and named above
    follows = near(answers[:, 1] / expected[:, 1], answers[:, 0] / S0)
    follows = follows and bool(np.all(answers))
    report(
        "my_precision",
        [
            (
                f"{names[0]}, in grey values",
                near(answers[:, 0], expected[:, 0]),
                first_slip(answers[:, 0], of_s0, "S0 is not that of (B 2.14e)", 1e-9),
            ),
            (
                f"{names[1]}, in pixels",
                good or (follows and bool(np.all(answers))),
                hint,
            ),
        ],
    )


def stop(function: Callable) -> None:
    """Check stop(q, half): whether no pixel moves by more than 0.01 px."""
    half = 10
    small = np.array([0.004, 1e-4, -2e-4, -0.003, 2e-4, 1e-4])
    cases = {
        "small": small,
        "shift": np.array([0.4, 0, 0, 0.0, 0, 0]),
        "back": np.array([-0.4, 0, 0, -0.2, 0, 0]),
        "row": np.array([0.0, 0, 0, 0.3, 0, 0]),
        "log": np.array([-0.0495, 0.01096, -0.12710, 0.0603, -0.02777, -0.03908]),
        "shear": np.array([0.0, 0, 0.004, 0.0, 0, 0]),
        "negative": np.array([0.0, -0.004, 0, 0.0, 0, -0.003]),
        "rows turn": np.array([0.0, 0, 0, 0.0, 0.004, 0]),
        "one diagonal": np.array([0.0, 0.002, -0.002, 0.0, 0, 0]),
        "the other": np.array([0.0, 0, 0, 0.0, 0.002, 0.002]),
        "sum": np.array([0.004, 4e-4, 4e-4, 0.0, 0, 0]),
    }
    answers = {k: bool(call(function, q, half, shape=())) for k, q in cases.items()}
    larger = bool(call(function, 0.9 * small, 40, shape=()))
    hints = [
        ("small steps end it", answers["small"], "it goes on after small steps"),
        (
            "shifts are looked at",
            not (answers["shift"] or answers["row"]),
            "it stops although the window still shifts",
        ),
        ("both signs", not answers["back"], "it stops at a large negative shift"),
        (
            "shape is looked at",
            not (answers["shear"] or answers["negative"] or answers["log"]),
            "it stops although the corners of the window still move",
        ),
        (
            "rows as well as columns",
            not answers["rows turn"],
            "b1 and b2 move the corners, too: it stops although the rows still change",
        ),
        (
            "all four corners",
            not (answers["one diagonal"] or answers["the other"]),
            "there is a corner that it does not look at, and that one still moves",
        ),
        (
            "the parts add up",
            not answers["sum"],
            "each part is small, but in one corner of the window they add up to more",
        ),
        (
            "the size of the window counts",
            not larger,
            "the same step moves the corner of a large window by more than 0.01 px",
        ),
    ]
    report("my_stop", hints)
