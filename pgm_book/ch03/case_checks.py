"""Feedback on the exercises of the case of chapter 3, the log of 2010."""

from collections.abc import Callable

import numpy as np

from pgm_book.common.checks import call, chance, first_slip, near, numbers, report

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


def precision(function: Callable) -> None:
    """Check precision(J, v), which answers S0 and the standard deviation of a0."""
    rng = chance(34)
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
            "the root of the cofactor does not contain the noise of the images",
        ),
        (S0 * q2, "take the root of the element of the inverse"),
        (S0**2 * q2, "that is the variance; take the root"),
        (S0, "S0 is in grey values; the slopes convert it into pixels"),
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
        "precision",
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
