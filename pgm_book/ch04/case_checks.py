"""Checks of the exercises of case 4c, three printed rotation matrices."""

import numpy as np

from pgm_book.common.checks import CheckFailed, report
from pgm_lab import _validate


def wrong_elements(answer: object) -> None:
    """Check the list of (row, column) of the wrong elements of (M 2.62), from 1."""
    if answer is ... or answer is None:
        raise CheckFailed("wrong is still empty. Your turn!")

    try:
        found = _validate.finite(answer, "wrong")
    except ValueError:
        found = np.empty(0)
    if found.ndim != 2 or found.shape[1] != 2:
        raise CheckFailed("wrong must be a list of pairs such as [(3, 2)]")
    places = {(row, column) for row, column in found.tolist()}
    expected = {(1, 3), (2, 2)}
    off_diagonal = {(i, j) for i in (1, 2, 3) for j in (1, 2, 3) if i != j}
    hints = {
        frozenset({(0, 2), (1, 1)}): "rows and columns of a formula count from 1",
        frozenset({(3, 1), (2, 2)}): "row comes first, then column: m21 is (2, 1)",
        frozenset({(1, 2), (2, 3)}): "these rows and columns do fail, but they cross in"
        " other elements, too: compare single elements with (M 2.8) transposed",
        frozenset(off_diagonal | {(2, 2)}): "(M 2.62) leads from image to object:"
        " compare with the transpose of (M 2.8)",
    }
    missing, extra = expected - places, places - expected
    hint = hints.get(
        frozenset(places),
        f"{len(missing)} wrong element(s) not found, {len(extra)} right one(s) named",
    )
    report(
        "the wrong elements of (M 2.62)",
        [("all found, no right one named", places == expected, hint)],
    )
