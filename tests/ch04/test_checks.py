"""Exercises of chapter 4: right answers pass, and each slip is named in plain words."""

import numpy as np
import pytest

from pgm_book.ch04 import checks
from pgm_book.common.checks import CheckFailed
from pgm_lab import rotation
from tests.common.slips import unnamed


def turn(axis, angle):
    """Turn of the frame about x, y or z."""
    return rotation.matrix(*[angle if k == axis else 0.0 for k in range(3)])


def product(order="zyx", signs=(1, 1, 1), unit=float):
    """rotation_matrix with the turns multiplied in this order from the left."""

    def rotation_matrix(*angles):
        M = np.eye(3)
        for letter in order:
            axis = "xyz".index(letter)
            M = M @ turn(axis, signs[axis] * unit(angles[axis]))
        return M

    return rotation_matrix


def is_rotation(M, tolerance):
    off = np.abs(M @ M.T - np.eye(3)).max()
    return off <= tolerance and np.linalg.det(M) > 0


def angles(M):
    omega = np.arctan2(-M[2, 1], M[2, 2])
    return np.array([omega, np.arcsin(M[2, 0]), np.arctan2(-M[1, 0], M[0, 0])])


def test_right_answers_pass(capsys):
    checks.plane_turn(frame)
    checks.plane_turn(lambda k: frame(k).tolist())
    checks.rotation_matrix(product())
    checks.rotation_matrix(rotation.matrix)
    checks.is_rotation(is_rotation)
    checks.is_rotation(
        lambda M, t: (
            np.allclose(M @ M.T, np.eye(3), rtol=0, atol=t)
            and abs(np.linalg.det(M) - 1) <= 0.5
        )
    )
    checks.angles(angles)
    checks.angles(rotation.angles)
    assert capsys.readouterr().out.count("✓") == 8


def frame(kappa):
    return rotation.matrix(0, 0, kappa)[:2, :2]


def largest(M):
    return np.abs(M @ M.T - np.eye(3)).max()


def plain(M):
    """Arctangent of the quotient."""
    omega, kappa = np.arctan(-M[2, 1] / M[2, 2]), np.arctan(-M[1, 0] / M[0, 0])
    return np.array([omega, np.arcsin(M[2, 0]), kappa])


def swapped(which, minus=True):
    """angles with the arguments of arctan2 exchanged."""

    def exchanged(M):
        sign = -1 if minus else 1
        answer = angles(M)
        if "omega" in which:
            answer[0] = np.arctan2(M[2, 2], sign * M[2, 1])
        if "kappa" in which:
            answer[2] = np.arctan2(M[0, 0], sign * M[1, 0])
        return answer

    return exchanged


def positive(M):
    return angles(M) % (2 * np.pi)


@pytest.mark.parametrize("off", [1e-6, 1e-4])
def test_near_misses_do_not_pass(off):
    for check, function in [
        (checks.rotation_matrix, product()),
        (checks.angles, angles),
        (checks.plane_turn, frame),
    ]:
        with pytest.raises(CheckFailed):
            check(lambda *a, function=function: function(*a) + off)
    with pytest.raises(CheckFailed):
        checks.is_rotation(lambda M, t: is_rotation(M, t + 300 * off))


SLIPS = {
    checks.plane_turn: [
        (lambda k: frame(-k), "transposed, it leads back"),
        (lambda k: frame(k)[::-1], "exchanged: x comes first"),
        (lambda k: frame(k) * [[1], [-1]], "e_y has the wrong sign"),
        (lambda k: frame(np.pi / 2 - k), "sine and cosine are exchanged"),
        (lambda k: frame(np.radians(k)), "in radians already"),
        (lambda k: frame(np.degrees(k)), "no conversion"),
        (lambda k: np.abs(frame(0.5)) * 0 + frame(k) ** 2, "not e_x and e_y"),
        (
            lambda k: [[np.cos(k), np.sin(k)], [np.sin(k), np.cos(k)]],
            "do not stand at a right angle",
        ),
        (
            lambda k: [[np.cos(k), -np.sin(k)], [-np.sin(k), np.cos(k)]],
            "a minus at both sines",
        ),
        (lambda k: frame(k).round(2), "right, but rounded to 2 decimals"),
        (lambda k: frame(k).round(3), "right, but rounded to 3 decimals"),
        (lambda k: frame(k).astype(np.float32).astype(float), "a float32"),
        (lambda k: None, "returns nothing yet"),
        (lambda k: np.eye(3), r"must return shape \(2, 2\)"),
    ],
    checks.rotation_matrix: [
        (lambda o, p, k: np.full((3, 3), None, float), "Do exercise 4.1 first"),
        (lambda o, p, k: product()(o, p, k).T, "transposed: it leads from image"),
        (product("xyz"), "the turn made first, omega, stands on the right"),
        (product("yzx"), "phi was made last"),
        (product("zxy"), "phi was made first"),
        (product(signs=(1, 1, -1)), "kappa rotates the wrong way"),
        (product(signs=(1, -1, 1)), "phi rotates the wrong way"),
        (product(signs=(-1, 1, 1)), "the turn by omega alone is not right"),
        (lambda o, p, k: np.eye(3), "none of the three turns alone"),
        (product(signs=(-1, -1, 1)), "the turn by omega and phi alone"),
        (product("yxz"), "each turn alone is right, their product is not"),
        (product(unit=np.radians), "radians already"),
        (lambda o, p, k: 2 * product()(o, p, k), "M Mᵀ is not the unit matrix"),
        (
            lambda o, p, k: product()(o, p, k).round(4),
            "rotation_matrix: right, but rounded to 4 decimals",
        ),
        (
            lambda o, p, k: product()(o, p, k).astype(np.float32).astype(float),
            "rotation_matrix: right to six digits only",
        ),
        (lambda o, p, k: turn(2, k) * turn(1, p) * turn(0, o), "matrices with @"),
        (lambda o, p, k: None, "returns nothing yet"),
    ],
    checks.is_rotation: [
        (lambda M, t: largest(M) <= t, "a mirror passes"),
        (lambda M, t: np.linalg.det(M) > 0, "tolerance is not looked at"),
        (lambda M, t: abs(np.linalg.det(M) - 1) <= t, "determinant alone"),
        (
            lambda M, t: largest(M) <= t and abs(np.linalg.det(M) - 1) <= t,
            "of the determinant only the sign",
        ),
        (
            lambda M, t: (
                np.linalg.norm(M @ M.T - np.eye(3), np.inf) <= t
                and np.linalg.det(M) > 0
            ),
            "look at the largest of them",
        ),
        (lambda M, t: is_rotation(M, t) or None, "return False for them"),
        (lambda M, t: None, "returns nothing yet"),
        (lambda M, t: largest(M) == 0, "a true rotation is refused"),
        (lambda M, t: is_rotation(M, 1e-9), "five printed digits is refused"),
        (lambda M, t: is_rotation(M, 1e-4), "tolerance is not looked at"),
        (
            lambda M, t: (
                np.abs((M**2).sum(axis=1) - 1).max() <= t and np.linalg.det(M) > 0
            ),
            "not at right angles pass",
        ),
        (
            lambda M, t: (M @ M.T - np.eye(3)).max() <= t and np.linalg.det(M) > 0,
            "Take absolute values first",
        ),
        (
            lambda M, t: abs((M @ M.T - np.eye(3)).max()) <= t and np.linalg.det(M) > 0,
            "Take absolute values first",
        ),
        (
            lambda M, t: np.all(M @ M.T - np.eye(3) <= t) and np.linalg.det(M) > 0,
            "Take absolute values first",
        ),
        (
            lambda M, t: largest(M) < 0.01 and np.linalg.det(M) > 0,
            "the tolerance is not looked at",
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
        (
            lambda M, t: (
                np.abs(M @ M.T - np.eye(3)).mean() <= t and np.linalg.det(M) > 0
            ),
            "not their mean",
        ),
        (
            lambda M, t: (
                np.linalg.norm(M @ M.T - np.eye(3)) <= t and np.linalg.det(M) > 0
            ),
            "of the determinant only the sign",
        ),
        (
            lambda M, t: (
                np.allclose(M @ M.T, np.eye(3), atol=t) and np.linalg.det(M) > 0
            ),
            "a relative one of its own",
        ),
        (lambda M, t: largest(M) <= t and M[2, 2] > 0, "no single element"),
        (
            lambda M, t: largest(M) <= t and M[0, 0] > 0,
            "a mirror passes",
        ),
        (lambda M, t: largest(M) <= t and np.diag(M).prod() > 0, "may be negative"),
        (lambda M, t: True, "a mirror passes"),
        (lambda M, t: False, "a true rotation is refused"),
    ],
    checks.angles: [
        (lambda M: angles(M) * (-1, 1, -1), "each has a minus in"),
        (swapped("omega and kappa"), "omega and kappa: the numerator comes first"),
        (swapped("omega and kappa", False), "omega and kappa: the numerator"),
        (swapped("omega"), "angles: omega: the numerator comes first"),
        (swapped("kappa"), "angles: kappa: the numerator comes first"),
        (swapped("kappa", False), "angles: kappa: the numerator comes first"),
        (positive, "full turns: omega and phi and kappa are not between"),
        (
            lambda M: np.where([True, False, True], positive(M), angles(M)),
            "full turns: omega and kappa are not between -180 and 180",
        ),
        (lambda M: angles(M) * (2, 1, 3), "omega and kappa are not recovered"),
        (plain, "arctan does not see the quadrant"),
        (
            lambda M: plain(M) * (1, 1, -1),
            "sign of kappa is reversed, and the quad",
        ),
        (
            lambda M: plain(M) * (-1, 1, 1),
            "sign of omega is reversed, and the quad",
        ),
        (lambda M: angles(M)[::-1], "the order is"),
        (lambda M: angles(M)[[1, 0, 2]], "the order is"),
        (lambda M: np.degrees(angles(M)), "give radians"),
        (lambda M: angles(M) * (-1, 1, 1), "sign of omega is reversed.$|omega is t"),
        (lambda M: angles(M) * (1, -1, 1), "sign of phi is reversed"),
        (lambda M: angles(M) * (1, 1, -1), "sign of kappa is reversed"),
        (lambda M: -angles(M), "all signs are reversed"),
        (lambda M: angles(M.T), "of the transposed matrix"),
        (
            lambda M: np.array(
                [
                    np.arctan2(M[2, 1], -M[2, 2]),
                    np.arcsin(M[2, 0]),
                    np.arctan2(M[1, 0], -M[0, 0]),
                ]
            ),
            "omega and kappa are half a turn off",
        ),
        (
            lambda M: angles(M) + (np.pi * np.sign(M[2, 1]), 0, 0),
            "omega is half a turn off",
        ),
        (lambda M: angles(M) * (1, 1, 2), "kappa is not recovered"),
        (lambda M: angles(M).round(4), "right, but rounded to 4 decimals"),
        (
            lambda M: angles(M).astype(np.float32).astype(float),
            "right to six digits only",
        ),
        (lambda M: M, "must return shape"),
    ],
}


@pytest.mark.parametrize("check", SLIPS, ids=lambda check: check.__name__)
def test_each_slip_is_named(check):
    assert unnamed(check, SLIPS[check]) == []
