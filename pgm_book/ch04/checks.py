"""Checks of the exercises of chapter 4, rotation matrices."""

import warnings
from collections.abc import Callable
from functools import partial
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    call,
    compare,
    first_slip,
    near,
    report,
    shaken,
    shuffled,
)
from pgm_lab import rotation

# Attitudes on which a function is tried (rad): no two angles alike, all quadrants, and
# so many digits that a rounded answer shows
_ATTITUDES = [
    (0.31274915, 0.41826317, 0.52913846),
    (-2.01738264, 0.91462753, 1.12849371),
    (2.53261948, -1.20748316, -2.91354827),
    (-0.71829364, 0.10927364, 2.23847156),
]


def _attitudes() -> np.ndarray:
    """The attitudes, or under a secret others in the same quadrants."""
    return shaken(41, np.array(_ATTITUDES), 0.05)


HALF = "half a turn off: numerator and denominator both have the wrong sign"
_SINGLE = "right to six digits only: rounded, or a float32? Keep all digits"


def _few_digits(right: np.ndarray) -> list[tuple[np.ndarray, str]]:
    """Right numbers with too few digits, and what to say about them."""
    rounded = [
        (right.round(k), f"right, but rounded to {k} decimals: keep all digits")
        for k in range(2, 6)
    ]
    return [*rounded, (right, _SINGLE)]  # within the tolerance of slips, not of `near`


def _rounded(right: Callable, digits: int, kappa: float) -> np.ndarray:
    """What is right but for its last digits."""
    return right(kappa).round(digits)


def plane_turn(function: Callable) -> None:
    """Check the reader's plane_turn(kappa), which answers M (2, 2)."""

    def right(kappa: float) -> np.ndarray:
        return rotation.matrix(0, 0, kappa)[:2, :2]

    slips: dict[str, Callable] = {
        "the sines have the wrong signs: this M is transposed, it leads back from the"
        " rotated frame to the old one": lambda k: right(k).T,
        "both rows are right, but exchanged: x comes first": lambda k: right(k)[::-1],
        "e_y has the wrong sign: a quarter turn counter-clockwise from e_x": lambda k: (
            right(k) * [[1], [-1]]
        ),
        "sine and cosine are exchanged": lambda k: right(np.pi / 2 - k),
        "kappa is in radians already": lambda k: right(np.radians(k)),
        "np.cos and np.sin take radians, and kappa is in radians: no conversion": (
            lambda k: right(np.degrees(k))
        ),
        "both sines have the same sign; the two rows do not stand at a right angle": (
            lambda k: np.array([[np.cos(k), np.sin(k)], [np.sin(k), np.cos(k)]])
        ),
        "there is a minus at both sines; only one of them has it": lambda k: np.array(
            [[np.cos(k), -np.sin(k)], [-np.sin(k), np.cos(k)]]
        ),
    }
    for digits in range(2, 8):
        hint = f"right, but rounded to {digits} decimals: keep all digits"
        slips[hint] = partial(_rounded, right, digits)
    slips[_SINGLE] = lambda k: right(k).astype(np.float32)
    cases = shaken(42, [(0.5,), (-1.1,), (2.4,)])
    otherwise = "the rows are not e_x and e_y in the old frame"
    holds, hint = compare(function, cases, right, slips, otherwise)
    report("plane_turn", [("its rows are the new axes, in the old frame", holds, hint)])


def rotation_matrix(function: Callable) -> None:
    """Check the reader's rotation_matrix(omega, phi, kappa)."""
    attitudes = _attitudes()
    try:
        answers = np.array(
            [call(function, *a, shape=(3, 3)) for a in attitudes.tolist()]
        )
    except CheckFailed as error:
        if "NaN" in str(error):  # what an assigned None becomes
            raise CheckFailed(
                "rotation_matrix contains NaN: does plane_turn return its matrix? Do"
                " exercise 4.1 first"
            ) from None
        raise
    expected = rotation.matrix(*attitudes.T)
    element_by_element = [
        rotation.matrix(*np.diag(attitude)).prod(axis=0) for attitude in attitudes
    ]
    slips: list[tuple[ArrayLike, str]] = [
        (expected.swapaxes(-1, -2), "it is transposed: it leads from image to object"),
        (_ordered("okp"), "phi was made last: kappa is"),
        (_ordered("pok"), "phi was made first: omega is"),
        (_ordered("kpo"), "the order is reversed: the turn made first, omega,"
         " stands on the right"),
        (_ordered("opk", (1, 1, -1)), "kappa rotates the wrong way: a sign in it"),
        (_ordered("opk", (1, -1, 1)), "phi rotates the wrong way: a sign in it"),
        (rotation.matrix(*np.radians(attitudes).T), "the angles are radians already"),
        (element_by_element, "multiply matrices with @, not element by element"),
        *_few_digits(expected),
    ]  # fmt: skip
    failing = [
        name
        for name, angles in zip(("omega", "phi", "kappa"), 0.4 * np.eye(3))
        if not near(call(function, *angles, shape=(3, 3)), rotation.matrix(*angles))
    ]
    otherwise = "each turn alone is right, their product is not"
    if failing:
        otherwise = f"the turn by {' and '.join(failing)} alone is not right"
    if len(failing) == 3:
        otherwise = "none of the three turns alone is right"
    rigid = bool(np.all(rotation.defect(answers) < 1e-9))
    hint = first_slip(answers, slips, otherwise)
    # What is right but for its digits is a rotation, and is told so
    kept = rigid or hint != otherwise
    report(
        "rotation_matrix",
        [
            (
                "lengths and angles are kept",
                along_with(kept, bool(np.ptp(answers, axis=0).any())),
                "M Mᵀ is not the unit matrix",
            ),
            ("it is M_kappa M_phi M_omega", near(answers, expected), hint),
        ],
    )


def _ordered(order: str, signs: tuple[int, int, int] = (1, 1, 1)) -> np.ndarray:
    """Matrices with the turns made in another order, the first letter first."""
    matrices = []
    for attitude in _attitudes():
        angles = dict(zip("opk", np.diag(np.multiply(signs, attitude)), strict=True))
        first, second, third = (rotation.matrix(*angles[letter]) for letter in order)
        matrices.append(third @ second @ first)
    return np.array(matrices)


def is_rotation(function: Callable) -> None:
    """Check the reader's is_rotation(M, tolerance), which answers True or False."""
    cases = nine_numbers()
    order = shuffled(45, len(cases))
    cases = [cases[k] for k in order]
    answers = []
    for _, M, limit, _, _ in cases:
        try:
            answers.append(bool(call(function, M, limit, shape=())))
        except CheckFailed as failed:
            if "returns nothing" not in str(failed) or not any(answers):
                raise
            raise CheckFailed(
                "is_rotation returns True for a rotation, and nothing for the others:"
                " return False for them"
            ) from None
    properties = []
    # One slip fails many: the first two are enough to read
    left, both = 2, len(set(answers)) > 1
    for k in np.argsort(order):
        text, _, _, expected, hint = cases[k]
        holds = along_with(answers[k] == expected, both)
        left -= holds is False
        properties.append((text, None if holds is False and left < 0 else holds, hint))
    report("is_rotation", properties, "rotations and others are told apart")


def angles(function: Callable) -> None:
    """Check the reader's angles(M), which answers (omega, phi, kappa) in radians."""
    expected = _attitudes()
    M = rotation.matrix(*expected.T)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a division by zero would pass unseen
        answers = np.array([call(function, one, shape=(3,)) for one in M])
    half = np.arctan(np.tan(expected))
    half[:, 1] = expected[:, 1]
    opposite = expected - np.pi * np.sign(expected) * (1, 0, 1)
    transposed = [rotation.angles(one.T) for one in M]
    slips = [
        (half, "right where cos is positive only: arctan does not see the quadrant"),
        (half * (1, 1, -1), "the sign of kappa is reversed, and the quadrant is lost"),
        (half * (-1, 1, 1), "the sign of omega is reversed, and the quadrant is lost"),
        *(
            (expected[:, order], "the order is (omega, phi, kappa)")
            for order in list(permutations(range(3)))[1:]
        ),
        (np.degrees(expected), "the answer is in degrees; give radians"),
        (expected * (-1, 1, 1), "the sign of omega is reversed"),
        (expected * (1, -1, 1), "the sign of phi is reversed"),
        (expected * (1, 1, -1), "the sign of kappa is reversed"),
        (-expected, "all signs are reversed: is it the transposed matrix?"),
        (
            expected * (-1, 1, -1),
            "the signs of omega and kappa are reversed: each has a minus in (M 2.10)",
        ),
        *(
            (np.where(turned, opposite, expected), f"{names} {HALF}")
            for names, turned in (
                ("omega and kappa are", (1, 0, 1)),
                ("omega is", (1, 0, 0)),
                ("kappa is", (0, 0, 1)),
            )
        ),
        *_swapped(expected),
        *_few_digits(expected),
        (transposed, "these are the angles of the transposed matrix"),
    ]
    good = near(answers, expected)
    wrong = [n for k, n in enumerate(("omega", "phi", "kappa"))
             if not near(answers[:, k], expected[:, k])]  # fmt: skip
    verb = "is" if len(wrong) == 1 else "are"
    otherwise = f"{' and '.join(wrong)} {verb} not recovered"
    if wrong == ["phi"]:
        otherwise += ": sin phi is m31"
    hint = first_slip(answers, slips, otherwise)
    found, wanted = (np.stack([np.cos(a), np.sin(a)]) for a in (answers, expected))
    if near(found, wanted):
        hint = (
            f"right but for full turns: {' and '.join(wrong)} {verb} not between"
            " -180 and 180 degrees; let arctan2 decide"
        )
    report("angles", [("the angles come back in all quadrants", good, hint)])


def _swapped(expected: np.ndarray) -> list[tuple[np.ndarray, str]]:
    """Angles with the arguments of arctan2 exchanged, with and without the minus."""
    slips = []
    for name, columns in (
        ("omega and kappa", [0, 2]),
        ("omega", [0]),
        ("kappa", [2]),
    ):
        for sign in (-1, 1):
            turned = expected.copy()
            turned[:, columns] = np.pi / 2 + sign * turned[:, columns]
            turned = np.arctan2(np.sin(turned), np.cos(turned))
            slips.append((turned, f"{name}: the numerator comes first in arctan2"))
    return slips


# --- Nine numbers each, on which a test of a rotation matrix is tried ---

# What holds if the test is right, M, its tolerance, the right answer, and the hint
Case = tuple[str, np.ndarray, float, bool, str]


def nine_numbers() -> list[Case]:
    """Rotations, mirrors and what is neither, each for one slip of a test."""
    M = rotation.matrix(*shaken(43, (0.3, 0.4, 0.5)))
    turned = rotation.matrix(*np.radians(shaken(44, [131.0, -60.0, 80.0], 0.003)))
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
            turned,
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
            np.linalg.cholesky(np.eye(3) + 0.9e-3) @ M,  # also det M - 1 is 1.35e-3
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
        (
            "the tolerance is the only one",
            (1 + 2e-6) * M,
            1e-9,
            False,
            "a matrix passes whose differences are 4e-6, at a tolerance of 1e-9:"
            " np.allclose adds a relative one of its own; set rtol=0",
        ),
    ]
