"""Exercises of chapter 4: right answers pass, and each slip is named in plain words."""

import numpy as np
import pytest

from pgm_lab import rotation
from pgm_lab.checks import CheckFailed, chapter4


def turn(axis, angle):
    """Turn of the frame about x, y or z."""
    return rotation.matrix(*[angle if k == axis else 0.0 for k in range(3)])


def product(order="zyx", signs=(1, 1, 1), unit=float):
    """my_matrix with the turns multiplied in this order from the left."""

    def my_matrix(*angles):
        M = np.eye(3)
        for letter in order:
            axis = "xyz".index(letter)
            M = M @ turn(axis, signs[axis] * unit(angles[axis]))
        return M

    return my_matrix


def my_is_rotation(M, tolerance):
    off = np.abs(M @ M.T - np.eye(3)).max()
    return off <= tolerance and np.linalg.det(M) > 0


def my_angles(M):
    omega = np.arctan2(-M[2, 1], M[2, 2])
    return np.array([omega, np.arcsin(M[2, 0]), np.arctan2(-M[1, 0], M[0, 0])])


def my_unit(attitude, printed):
    degrees = np.abs(rotation.matrix(*np.radians(attitude)) - printed).max()
    radians = np.abs(rotation.matrix(*attitude) - printed).max()
    return "degrees" if degrees < radians else "radians"


def test_right_answers_pass(capsys):
    chapter4.wrong_elements([(2, 2), (1, 3)])
    chapter4.matrix(product())
    chapter4.matrix(rotation.matrix)
    chapter4.is_rotation(my_is_rotation)
    chapter4.angles(my_angles)
    chapter4.angles(rotation.angles)
    chapter4.unit(my_unit)
    assert capsys.readouterr().out.count("✓") == 7


# Where (2.62) differs from (2.8) itself
UNTRANSPOSED = [(1, 2), (1, 3), (2, 1), (2, 2), (2, 3), (3, 1), (3, 2)]


def test_no_hint_gives_a_wrong_element_away():
    for answer in (..., [], 13, [(3, 1), (2, 2)], [(0, 2), (1, 1)], UNTRANSPOSED):
        with pytest.raises(CheckFailed) as failed:
            chapter4.wrong_elements(answer)
        for place in ("(1, 3)", "(2, 2)", "m13", "m22"):
            assert place not in str(failed.value)


@pytest.mark.parametrize(
    ("answer", "hint"),
    [
        (..., "still empty"),
        ([(0, 2), (1, 1)], "count from 1"),
        ([(3, 1), (2, 2)], "row comes first"),
        ([(1, 2), (2, 3)], "cross in other elements"),
        ([(1, 3)], r"1 wrong element\(s\) not found, 0 right"),
        ([(1, 3), (2, 2), (3, 3)], r"0 wrong element\(s\) not found, 1 right"),
        (UNTRANSPOSED, "compare with the transpose"),
        ([(1, 3, 2)], r"must be a list of pairs such as \[\(3, 2\)\]"),
        ([], r"must be a list of pairs such as \[\(3, 2\)\]"),
        ((1, 3), "must be a list of pairs"),
        ([(1, 3), 2], "must be a list of pairs"),
        ("m13 and m22", "must be a list of pairs"),
        (13, "must be a list of pairs"),
        ([(1.5, 3), (2, 2)], r"1 wrong element\(s\) not found, 1 right"),
    ],
)
def test_slip_in_the_wrong_elements_is_named(answer, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter4.wrong_elements(answer)


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda o, p, k: product()(o, p, k).T, "transposed: it leads from image"),
        (product("xyz"), "the turn made first, omega, stands on the right"),
        (product("yzx"), "phi was made last"),
        (product("zxy"), "phi was made first"),
        (product(signs=(1, 1, -1)), "kappa turns the wrong way"),
        (product(signs=(-1, 1, 1)), "the turn by omega alone is not right"),
        (product(signs=(-1, -1, 1)), "the turn by omega and phi alone"),
        (product("yxz"), "each turn alone is right, their product is not"),
        (product(unit=np.radians), "radians already"),
        (lambda o, p, k: 2 * product()(o, p, k), "M Mᵀ is not the unit matrix"),
        (lambda o, p, k: turn(2, k) * turn(1, p) * turn(0, o), "M Mᵀ is not the unit"),
        (lambda o, p, k: None, "returns nothing yet"),
    ],
)
def test_slip_in_the_matrix_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter4.matrix(function)


def largest(M):
    return np.abs(M @ M.T - np.eye(3)).max()


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda M, t: largest(M) <= t, "a mirror passes"),
        (lambda M, t: np.linalg.det(M) > 0, "tolerance is not looked at"),
        (lambda M, t: abs(np.linalg.det(M) - 1) <= t, "determinant alone"),
        (lambda M, t: largest(M) == 0, "a true rotation is refused"),
        (lambda M, t: my_is_rotation(M, 1e-9), "five printed digits is refused"),
        (lambda M, t: my_is_rotation(M, 1e-4), "tolerance is not looked at"),
        (
            lambda M, t: (
                np.abs((M**2).sum(axis=1) - 1).max() <= t and np.linalg.det(M) > 0
            ),
            "not at right angles pass",
        ),
        (
            lambda M, t: (M @ M.T - np.eye(3)).max() <= t and np.linalg.det(M) > 0,
            "a matrix that is too small passes",
        ),
        (
            lambda M, t: abs((M @ M.T - np.eye(3)).sum()) <= t and np.linalg.det(M) > 0,
            "the errors cancel in a sum",
        ),
        (
            lambda M, t: (
                np.abs(M @ M.T - np.eye(3)).min() <= t and np.linalg.det(M) > 0
            ),
            "a row longer than 1 passes",
        ),
        (lambda M, t: True, "a row longer than 1 passes"),
        (lambda M, t: False, "a true rotation is refused"),
    ],
)
def test_slip_in_the_test_of_a_rotation_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter4.is_rotation(function)


def plain(M):
    """Arctangent of the quotient."""
    omega, kappa = np.arctan(-M[2, 1] / M[2, 2]), np.arctan(-M[1, 0] / M[0, 0])
    return np.array([omega, np.arcsin(M[2, 0]), kappa])


def swapped(which, minus=True):
    """my_angles with the arguments of arctan2 exchanged."""

    def my_angles_swapped(M):
        sign = -1 if minus else 1
        answer = my_angles(M)
        if "omega" in which:
            answer[0] = np.arctan2(M[2, 2], sign * M[2, 1])
        if "kappa" in which:
            answer[2] = np.arctan2(M[0, 0], sign * M[1, 0])
        return answer

    return my_angles_swapped


def positive(M):
    return my_angles(M) % (2 * np.pi)


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda M: my_angles(M) * (-1, 1, -1), "each has a minus in"),
        (swapped("omega and kappa"), "omega and kappa: the numerator comes first"),
        (swapped("omega and kappa", False), "omega and kappa: the numerator"),
        (swapped("omega"), "my_angles: omega: the numerator comes first"),
        (swapped("kappa"), "my_angles: kappa: the numerator comes first"),
        (swapped("kappa", False), "my_angles: kappa: the numerator comes first"),
        (positive, "full turns: omega and phi and kappa are not between"),
        (
            lambda M: np.where([True, False, True], positive(M), my_angles(M)),
            "full turns: omega and kappa are not between -180 and 180",
        ),
        (lambda M: my_angles(M) * (2, 1, 3), "omega and kappa are not recovered"),
        (plain, "arctan cannot know the quadrant"),
        (
            lambda M: plain(M) * (1, 1, -1),
            "sign of kappa is reversed, and the quad",
        ),
        (
            lambda M: plain(M) * (-1, 1, 1),
            "sign of omega is reversed, and the quad",
        ),
        (lambda M: my_angles(M)[::-1], "the order is"),
        (lambda M: np.degrees(my_angles(M)), "give radians"),
        (lambda M: my_angles(M) * (-1, 1, 1), "sign of omega is reversed.$|omega is t"),
        (lambda M: my_angles(M) * (1, -1, 1), "sign of phi is reversed"),
        (lambda M: my_angles(M) * (1, 1, -1), "sign of kappa is reversed"),
        (lambda M: -my_angles(M), "all signs are reversed"),
        (lambda M: my_angles(M.T), "of the transposed matrix"),
        (
            lambda M: np.array(
                [
                    np.arctan2(M[2, 1], -M[2, 2]),
                    np.arcsin(M[2, 0]),
                    np.arctan2(M[1, 0], -M[0, 0]),
                ]
            ),
            "half a turn off",
        ),
        (lambda M: my_angles(M) * (1, 1, 2), "kappa is not recovered"),
        (lambda M: M, "must return shape"),
    ],
)
def test_slip_in_the_angles_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter4.angles(function)


def nearly_unit(attitude, printed):
    """The rule that small angles in radians and large ones in degrees break."""
    return "degrees" if np.abs(printed - np.eye(3)).max() < 0.1 else "radians"


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda a, M: "degrees", "made of radians is taken for one of degrees"),
        (lambda a, M: "radians", "made of degrees is taken for one of radians"),
        (
            lambda a, M: (
                "degrees"
                if np.array_equal(rotation.matrix(*np.radians(a)), M)
                else "radians"
            ),
            "equality fails",
        ),
        (lambda a, M: "degrees" if np.abs(a).max() > 1 else "radians", "taken for"),
        (nearly_unit, "degrees is taken for one of radians, at angles of 20.0, 30.0"),
        (
            lambda a, M: my_unit(a, M) if np.abs(a).max() > 1 else nearly_unit(a, M),
            "radians is taken for one of degrees, at angles of 0.02, 0.01, 0.03",
        ),
        (
            lambda a, M: "radians" if my_unit(a, M) == "degrees" else "degrees",
            "taken for",
        ),
        (lambda a, M: "gon", 'must be "degrees" or "radians"'),
        (lambda a, M: None, "returns nothing yet"),
        (lambda a, M: 1 / 0, "stopped with ZeroDivisionError"),
        (..., "not a function yet"),
    ],
)
def test_slip_in_the_unit_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter4.unit(function)


@pytest.mark.parametrize("off", [1e-6, 1e-4])
def test_near_misses_do_not_pass(off):
    for check, function in [
        (chapter4.matrix, product()),
        (chapter4.angles, my_angles),
    ]:
        with pytest.raises(CheckFailed):
            check(lambda *a, function=function: function(*a) + off)
    with pytest.raises(CheckFailed):
        chapter4.is_rotation(lambda M, t: my_is_rotation(M, t + 300 * off))
    with pytest.raises(CheckFailed):
        chapter4.wrong_elements([(1 + off, 3), (2, 2)])
