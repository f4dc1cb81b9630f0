"""Nine numbers each, on which a test of a rotation matrix is tried."""

import numpy as np

from pgm_lab import rotation

# What holds if the test is right, M, its tolerance, the right answer, and the hint
Case = tuple[str, np.ndarray, float, bool, str]


def nine_numbers() -> list[Case]:
    """Rotations, mirrors and what is neither, each for one slip of a test."""
    M = rotation.matrix(0.3, 0.4, 0.5)
    sheared = M.copy()
    sheared[0] += 0.1 * sheared[1]
    wrong_length = np.diag([1.0, 1.0, 1.1]) @ M
    # Columns of length 1 that are not at right angles
    lengths_only = sheared / np.linalg.norm(sheared, axis=1, keepdims=True)
    unit_determinant = np.diag([2.0, 0.5, 1.0]) @ M
    return [
        ("a rotation is one", M, 1e-9, True, "a true rotation is refused"),
        (
            "so is one of five printed digits",
            M.round(5),
            2e-5,
            True,
            "a matrix of five printed digits is refused, though the tolerance is 2e-5",
        ),
        (
            "within the tolerance only",
            M.round(5),
            1e-9,
            False,
            "the tolerance is not looked at",
        ),
        (
            "a mirror is none",
            np.diag([1.0, 1.0, -1.0]) @ M,
            1e-9,
            False,
            "a mirror passes: it is orthogonal, too. What tells it apart?",
        ),
        (
            "nor is one in another direction",
            np.diag([-1.0, 1.0, 1.0]),
            1e-9,
            False,
            "the mirror diag(-1, 1, 1) passes: no single element tells it apart",
        ),
        (
            "so is a rotation with a negative diagonal element",
            rotation.matrix(*np.radians([131.0, -60.0, 80.0])),
            1e-9,
            True,
            "a rotation with omega = 131 degrees is refused: any of its elements may be"
            " negative",
        ),
        (
            "nor is a matrix with a wrong length",
            wrong_length,
            1e-3,
            False,
            "a matrix with a row longer than 1 passes",
        ),
        (
            "nor one without right angles",
            lengths_only,
            1e-3,
            False,
            "rows of length 1 that are not at right angles pass",
        ),
        (
            "nor any matrix of determinant 1",
            unit_determinant,
            1e-3,
            False,
            "the determinant alone is not enough",
        ),
        (
            "nor one whose errors cancel in a sum",
            np.diag([1.1, np.sqrt(0.79), 1.0]) @ M,
            1e-3,
            False,
            "a matrix passes whose rows are too long and too short: the errors cancel"
            " in a sum, so take the largest of their absolute values",
        ),
        (
            "nor one of which a single element is off",
            np.diag([1.0015, 1.0, 1.0]) @ M,
            1e-3,
            False,
            "a matrix passes with one element of M Mᵀ off by three times the tolerance:"
            " take the largest of the differences, not their mean",
        ),
        (
            "each element has the whole tolerance",
            np.diag([1.0004, 0.9996, 1.0004]) @ M,
            1e-3,
            True,
            "a matrix is refused whose differences are all within the tolerance: look"
            " at the largest of them; of the determinant only the sign counts",
        ),
        (
            "errors of both signs count",
            0.9 * M,
            1e-3,
            False,
            "a matrix that is too small passes: its differences are negative, and the"
            " largest of them is 0. Take absolute values first",
        ),
    ]
