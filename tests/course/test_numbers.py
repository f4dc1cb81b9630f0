"""Each answer again, from the numbers on the paper alone and by other means."""

import hashlib
import json
import re
from collections import Counter
from dataclasses import replace
from math import atan, atan2, cos, degrees, hypot, log, pi, radians, sin, sqrt, tan

import cv2
import numpy as np
import pytest

from pgm_book.course.numbers import (
    APART,
    VARIANTS,
    Chance,
    listed,
    matrix,
    number_questions,
    variants,
)

QUESTIONS = number_questions()
# Of the numbers in the texts and the answers; a question changed on purpose has others.
FROZEN = "c76f0008b6ed000c"


def shown(text):
    """Return the numbers of a text in their order, without how to answer."""
    asked = text.rpartition(" Answer ")[0]
    return [float(one) for one in re.findall(r"-?\d+(?:\.\d+)?", asked)]


def ncc(a, b):
    """The correlation coefficient by OpenCV, in 32 bit."""
    a, b = (np.float32(one).reshape(3, 3) for one in (a, b))
    return cv2.matchTemplate(a, b, cv2.TM_CCOEFF_NORMED)[0, 0]


def turned(kappa, x, y):
    """x in a frame that is rotated by kappa degrees."""
    return x * cos(radians(kappa)) + y * sin(radians(kappa))


def gained(n):
    S = n[9] * np.array(n[:9]) + n[10]
    S[4] += n[11]
    return np.corrcoef(n[:9], S)[0, 1]


def step(n):
    A, B = np.array(n[:5]), np.array(n[5:])
    slope, off = np.gradient(B)[1:-1], (A - B)[1:-1]
    return np.linalg.lstsq(slope[:, None], off, rcond=None)[0][0]


def bilinear(n):
    grey = np.float32(n[:4]).reshape(2, 2)
    weights = np.outer([1 - n[9], n[9]], [1 - n[8], n[8]])
    return np.sum(weights * grey)


def peak(n):
    a, b, _ = np.polyfit([-1, 0, 1], n, 2)
    return -b / (2 * a)


def affine(n):
    at = 1, n[13] / 1000, n[14] / 1000
    return n[6] * hypot(np.dot(n[7:10], at), np.dot(n[10:13], at))


def mean(n):
    return np.average(n[:3], weights=1 / np.array(n[3:]))


def element(n):
    """Of the product of three matrices, each made by OpenCV from a vector."""
    axes = np.eye(3) * np.radians([[n[0]], [n[1]], [n[2]]])
    omega, phi, kappa = (cv2.Rodrigues(-one)[0] for one in axes)
    return (kappa @ phi @ omega)[0, 1]


def total_angle(n):
    return degrees(np.linalg.norm(quaternion_vector(n)))


def quaternion_vector(n):
    w, x, y, z = np.array(n) / np.linalg.norm(n)
    length = hypot(x, y, z)
    return 2 * atan2(length, w) * np.array([x, y, z]) / length


def two_rays(n):
    depth = n[1] / (n[2] - n[5])
    return n[2] * depth


def zeros(n):
    """Built and counted: which unknowns meet in a ray."""
    p, m, k = map(int, n)
    blocks = [p] + m * [6] + k * [3]
    meets = np.eye(1 + m + k, dtype=bool)
    meets[0] = meets[:, 0] = True
    meets[1 : 1 + m, 1 + m :] = meets[1 + m :, 1 : 1 + m] = True
    full = np.repeat(np.repeat(meets, blocks, axis=0), blocks, axis=1)
    return 100 * np.mean(~full)


def relief(n):
    H, r, h = n
    return r - r * (H - h) / H


def nmad(n):
    e = np.array(n[:7])
    return 1.4826 * np.median(np.abs(e - np.median(e)))


def ellipse(n):
    return sqrt(np.linalg.svd(np.reshape(n, (2, 2)))[1][0])


def model_scale(n):
    return n[6] / np.linalg.norm(np.subtract(n[3:6], n[:3]))


def free_network(m, n):
    """Unknowns of a network of one camera, less the seven motions."""
    return 10 + 6 * m + 3 * n - 7


BY_HAND = {
    "photo_y": lambda n: (n[1] / 2 - 0.5 - n[3]) * n[2] / 1000,
    "pixel_column": lambda n: n[4] * 1000 / n[2] + n[0] / 2 - 0.5,
    "gsd": lambda n: n[0] * 1e-6 * n[2] / (n[1] * 1e-3) * 100,
    "flying_height": lambda n: (n[0] / 100) * (n[2] * 1e-3) / (n[1] * 1e-6),
    "principal_point": lambda n: hypot(n[3], n[5]) * n[0] / n[1],
    "centroid": lambda n: np.average(
        [0, 1, 2], weights=np.reshape(n[2:11], (3, 3)).sum(axis=0) - 3 * n[11]
    ),
    "centroid_sd": lambda n: n[3] / n[2] * sqrt(n[0] ** 2 * (n[0] ** 2 - 1) / 12),
    "file_size": lambda n: n[0] * n[1] * n[2] * n[3] * n[4] / 8 / 1024**2,
    "correlation": lambda n: ncc(n[:9], n[9:]),
    "gained": gained,
    "places": lambda n: (n[2] - n[0] + 1) * (n[3] - n[0] + 1),
    "search_width": lambda n: 2 * max(n[0], n[1]) + n[2],
    "map_to_photo": lambda n: n[4] - n[2] // 2 + n[0] // 2 + n[5],
    "gain": lambda n: np.polyfit(n[:5], n[5:], 1)[0],
    "noisy": lambda n: 1 / (1 + (n[1] / n[0]) ** 2),
    "one_step": step,
    "shift_sd": lambda n: n[7] / np.linalg.norm(n[:6]),
    "transformed": lambda n: np.dot([n[1], n[3], n[5]], [1, n[6], n[7]]),
    "scale_of_window": lambda n: hypot(n[2], n[5]),
    "bilinear": bilinear,
    "brightness": lambda n: n[2] - n[3] / n[5] * n[4],
    "match_sigma0": lambda n: sqrt(n[3] / (n[0] ** 2 - n[2])),
    "from_sums": lambda n: (
        (n[6] / 9 - n[0] * n[1] / 81)
        / sqrt((n[3] / 9 - n[0] ** 2 / 81) * (n[5] / 9 - n[1] ** 2 / 81))
    ),
    "rmse_t": lambda n: n[8] * np.linalg.norm(n[:8]) / 2,
    "parabola": peak,
    "scatter": lambda n: sqrt((n[0] - n[1]) * (n[0] + n[1])),
    "affine": affine,
    "ce90": lambda n: n[0] * sqrt(log(10)),
    "whole_pixels": lambda n: n[0] * hypot(n[1] - round(n[1]), n[2] - round(n[2])),
    "weighted_mean": mean,
    "mean_sd": lambda n: 1 / np.linalg.norm(1 / np.array(n)),
    "net_redundancy": lambda n: n[1] - (n[0] - n[2]),
    "sigma0": lambda n: sqrt(
        sum(v * v / km for km, v in zip(n[:5], n[5:10])) / (5 - n[10])
    ),
    "redundancy_number": lambda n: 1 - 1 / (n[0] * (1 / n[0] + 1 / n[1] + 1 / n[2])),
    "baarda": lambda n: n[0] / (n[1] * sqrt(n[2])),
    "blunder": lambda n: n[1] / n[0],
    "error_ellipse": ellipse,
    "plane_rotation": lambda n: turned(n[0], n[1], n[2]),
    "element": element,
    "omega": lambda n: degrees(atan2(-n[1], n[3])),
    "tilt": lambda n: degrees(np.arccos(cos(radians(n[0])) * cos(radians(n[1])))),
    "whole_angle": lambda n: degrees(np.arccos((sum(n) - 1) / 2)),
    "small_kappa": lambda n: n[2] * n[0] * pi / 180 * 1000 / n[1],
    "nadir": lambda n: n[0] * tan(radians(n[1])),
    "quaternion": total_angle,
    "collinearity": lambda n: n[2] * turned(n[1], n[4], n[5]) / n[3],
    "two_rays": two_rays,
    "coplanar": lambda n: np.linalg.det(np.reshape(n, (3, 3))),
    "intersection_redundancy": lambda n: 2 * n[0] * n[1] - 3 * n[1],
    "relative_redundancy": lambda n: n[0] - n[1] - 5,
    "height_sd": lambda n: n[0] ** 2 / n[1] / n[2] * sqrt(2) * n[3] / 10,
    "model_scale": model_scale,
    "to_ground": lambda n: n[0] * turned(-n[1], n[3], n[4]) + n[2],
    "bundle_redundancy": lambda n: 2 * n[3] - free_network(n[1], n[2]),
    "zeros": zeros,
    "radial": lambda n: (
        1000
        * n[0]
        * (
            n[3] * 1e-5 * (n[0] ** 2 + n[1] ** 2)
            + n[7] * 1e-8 * (n[0] ** 2 + n[1] ** 2) ** 2
        )
    ),
    "decentring": lambda n: (
        (n[3] * (3 * n[0] ** 2 + n[1] ** 2) + 2 * n[7] * n[0] * n[1]) / 100
    ),
    "correlated": lambda n: sqrt(
        (n[2] + n[6] * n[5]) ** 2 + (1 - n[6] ** 2) * n[5] ** 2
    ),
    "two_halves": lambda n: 1000 * (n[2] - n[0]) / hypot(n[1], n[3]),
    "elimination": lambda n: (1 + 3 * n[2] / (n[0] + 6 * n[1])) ** 3,
    "after": lambda n: sqrt(n[5] / (2 * n[3] - free_network(n[0], n[1]))),
    "depth": lambda n: n[0] * n[1] / (n[2] - n[3]),
    "mast": lambda n: n[0] * n[1] * (n[3] - n[2]) / (n[2] * n[3]),
    "sigma_z": lambda n: n[0] / n[1] * n[2] * n[3],
    "along_base": lambda n: n[0] * n[3] / n[4],
    "base": lambda n: n[1] * n[2] * 1e-6 * n[3] / (n[0] * 1e-3) * (1 - n[4] / 100),
    "rmse_heights": lambda n: np.linalg.norm(n) / sqrt(5),
    "nmad_heights": nmad,
    "relief": relief,
    "board_redundancy": lambda n: 2 * n[0] * n[1] - free_network(n[1], n[0]),
    "base_of_scale": lambda n: n[2] / n[1],
    "wrong_distance": lambda n: n[2] * (n[1] / n[0]),
    "depth_sd": lambda n: 1000 * n[3] ** 2 / n[1] / n[0] * n[2],
    "view": lambda n: 2 * degrees(atan(n[0] * n[1] / 2000 / n[2])),
    "square": lambda n: n[2] * n[0] / n[1] * cos(radians(n[3])),
    "focus": lambda n: 1 / (1 / n[0] - 1 / n[1]) - n[0],
}


@pytest.fixture(scope="module")
def made():
    return {one.name: variants(one) for one in QUESTIONS}


def test_every_lesson_has_at_least_six_and_no_two_are_alike():
    lessons = Counter(one.lesson for one in QUESTIONS)
    assert set(lessons) == {"1", "2", "3", "4", "5", "6", "7", "8", "9", "A1"}
    assert min(lessons.values()) >= 6
    for what in ("name", "title", "text"):
        assert len({getattr(one, what) for one in QUESTIONS}) == len(QUESTIONS)
    assert {one.name for one in QUESTIONS} == set(BY_HAND)


@pytest.mark.parametrize("name", BY_HAND)
def test_the_answer_follows_from_the_numbers_shown(made, name):
    for one in made[name]:
        expected = BY_HAND[name](shown(one.text))
        half = 0.5 * 10.0**-one.digits
        # what was a tie before rounding may fall to the other side; 32 bit for ncc
        assert abs(one.answer - expected) <= half * 1.001 + 1e-9, (one.text, expected)


def test_a_tolerance_is_a_unit_of_the_last_digit_asked_for(made):
    for one in (one for some in made.values() for one in some):
        if one.digits:
            assert one.tolerance == pytest.approx(10**-one.digits)
            decimals = f"to {one.digits} decimal"
        else:
            assert one.tolerance == 0 and one.answer == int(one.answer)
            decimals = "with a whole number"
        asked = one.text.rpartition(" Answer ")[2]
        assert decimals in asked and (f"in **{one.unit}**" in asked) == bool(one.unit)


def test_usual_slips_are_wrong(made):
    for one in (one for some in made.values() for one in some):
        assert len(one.slips) >= 3
        for words, value in one.slips.items():
            assert np.isfinite(value), one.number
            least = APART * one.tolerance or 0.5
            assert abs(value - one.answer) > least, (one.number, words)


def test_degrees_for_radians_and_a_reversed_sign_are_wrong(made):
    """Slips that are not listed with the question are not right either."""
    for name in ("plane_rotation", "omega", "coplanar", "photo_y", "one_step"):
        for one in made[name]:
            assert abs(-one.answer - one.answer) > one.tolerance
    for name in ("tilt", "nadir", "view", "whole_angle", "quaternion"):
        for one in made[name]:
            assert abs(radians(one.answer) - one.answer) > one.tolerance


def test_fifty_variants_each_with_its_own_numbers_and_solution(made):
    for some in made.values():
        assert len(some) == VARIANTS == 50
        assert len({one.text for one in some}) == 50
        assert len({one.number for one in some}) == 50
        for one in some:
            answer = f"{one.answer:.{one.digits}f}"
            assert answer in one.solution and "%(" not in one.text + one.solution
            assert not re.search(r"\b(nan|inf)\b", one.text + one.solution)


def test_the_variants_are_the_same_everywhere(made):
    numbers = {k: [(shown(v.text), v.answer) for v in some] for k, some in made.items()}
    digest = hashlib.sha256(json.dumps(numbers).encode()).hexdigest()
    assert digest[:16] == FROZEN


def test_the_first_variants_stay_when_more_are_asked_for(made):
    (gsd,) = (one for one in QUESTIONS if one.name == "gsd")
    assert variants(gsd, 5) == made["gsd"][:5]


def test_a_question_whose_slips_are_right_is_refused():
    (gsd,) = (one for one in QUESTIONS if one.name == "gsd")

    def careless(draw):
        given, answer, slips = gsd.draw(draw)
        return given, answer, [answer * 1.0001, *slips[1:]]

    with pytest.raises(ValueError, match="gsd: too few"):
        variants(replace(gsd, draw=careless), 3)


def test_chance_has_the_digits_that_are_shown():
    draw = Chance("test")
    values = [draw(0.1, 0.7, 0.05) for _ in range(200)]
    assert {f"{one:g}" for one in values} == {f"{0.1 + 0.05 * k:g}" for k in range(13)}
    assert isinstance(draw(3, 9), int) and sorted(draw.order("abc")) == list("abc")


def test_lists_and_matrices_in_tex():
    assert listed([1, -0.5]) == r"1,\ -0.5"
    assert matrix([[1, 2], [3, 4]]) == r"\begin{pmatrix} 1 & 2 \\ 3 & 4 \end{pmatrix}"
