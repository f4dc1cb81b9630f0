"""Exercise feedback of chapter 5: right answers pass, each slip is named."""

from pathlib import Path

import nbformat
import numpy as np
import pytest

from pgm_lab import camera, datasets, orientation, rotation
from pgm_lab.checks import CheckFailed, chapter5

NOTEBOOK = Path(__file__).parents[2] / "notebooks" / "05_intersection.ipynb"
F = 35.0
RIGHT = datasets.bani2010_intersection()["exterior"][1]
LEFT = datasets.bani2010_intersection()["exterior"][0]
POINT = np.array([-2.0, -1.2, -1.7])


def image(
    exterior=RIGHT, c=18.5558, sign=-1, transposed=False, degrees=False, turned=True
):
    angles = np.radians(exterior[3:]) if degrees else exterior[3:]
    M = rotation.matrix(*angles) if turned else np.eye(3)
    U, V, W = (M.T if transposed else M) @ (POINT - exterior[:3])
    return np.array([sign * c * U / W, sign * c * V / W])


def both_scales(base, left, right):
    bx, by, _ = base
    D = left[:, 0] * right[:, 1] - left[:, 1] * right[:, 0]
    first = (bx * right[:, 1] - by * right[:, 0]) / D
    return np.array([first, (bx * left[:, 1] - by * left[:, 0]) / D])


def nearest(stations, directions, unit=True):
    d = directions
    if unit:
        d = d / np.linalg.norm(d, axis=1, keepdims=True)
    across = np.eye(3) - d[:, :, None] * d[:, None, :]
    return np.linalg.solve(
        across.sum(0), np.einsum("nij,nj->i", across, np.asarray(stations))
    )


def base(height, c, sigma_um, wanted):
    return height**2 / c * np.sqrt(2) * sigma_um / 1000 / wanted


def test_right_answers_pass(capsys):
    chapter5.misprints(["b13", "b22", "b23", "b26"])
    chapter5.misprints({"B_13", "b22 ", "b26", "b23"})
    chapter5.right_image(image())
    chapter5.right_image(np.round(image(), 3))
    chapter5.scale_factors(both_scales)
    chapter5.intersection(nearest)
    chapter5.base(base)
    assert capsys.readouterr().out.count("✓") == 7


@pytest.mark.parametrize(
    "answer",
    [
        np.array(["b13", "b22", "b23", "b26"]),
        np.array([["b13"], ["b22"], ["b23"], ["b26"]]),
        np.array(["b13", "b22", "b23", "b26"], dtype=object),
        ("b13", "b22", "b23", "b26"),
        frozenset({"b13", "b22", "b23", "b26"}),
        {"b13": 1, "b22": 2, "b23": 3, "b26": 4}.keys(),
        "b13, b22, b23, b26",
        "b13 b22 b23 b26",
    ],
)
def test_misprints_may_stand_in_any_container(answer, capsys):
    chapter5.misprints(answer)
    assert "✓ misprinted" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("answer", "hint"),
    [
        ([], "still empty"),
        (..., "still empty"),
        ("b13", "3 more deviate"),
        ("", "still empty"),
        (None, "still empty"),
        (np.array([]), "still empty"),
        (np.array(["b13", "b22", "b23"]), "1 more deviate"),
        (np.array([True, False]), "no coefficient false, true: write the names"),
        (["b13", "b22"], "2 more deviate"),
        (["b13", "b22", "b23", "b25", "b26"], "1 of your coefficients agree"),
        (["b17"], "no coefficient b17"),
        ([13, 22], 'no coefficient 13, 22: write the names like "b11"'),
    ],
)
def test_slip_in_the_misprints_is_named(answer, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter5.misprints(answer)


def test_misprints_are_not_given_away():
    with pytest.raises(CheckFailed) as failed:
        chapter5.misprints(["b11"])
    assert not any(name in str(failed.value) for name in ("b13", "b22", "b23", "b26"))


@pytest.mark.parametrize(
    ("answer", "hint"),
    [
        (..., "still empty"),
        (image(sign=1), "the sign"),
        (image(transposed=True), "M is transposed"),
        (image(degrees=True), "radians already"),
        (image(np.roll(RIGHT, 3)), "angles stand before the position"),
        (image(LEFT), "that is the left photo"),
        (image()[::-1], "x and y are exchanged"),
        (image(c=1), "principal distance is missing"),
        (image() + 0.1, "not imaged there"),
        (np.round(image(), 2), "not imaged there"),
        (image(turned=False), "M is missing"),
        ((1.0, 2.0, 3.0), "right_image must be two numbers"),
        ("left", "right_image must be two numbers"),
        ((1.0, ...), "right_image must be two numbers"),
    ],
)
def test_slip_in_the_image_is_named(answer, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter5.right_image(answer)


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda b, u, w: both_scales(b, u, w) * [[1], [-1]], "wrong sign"),
        (lambda b, u, w: both_scales(b, u, w)[::-1], "are exchanged"),
        (lambda b, u, w: both_scales(b, u, w)[[0, 0]], "that of the left ray"),
        (lambda b, u, w: both_scales(b * (1, 0, 0), u, w), "do not meet"),
        (lambda b, u, w: both_scales(b, u, w) * 1.001, "do not meet"),
        (lambda b, u, w: None, "returns nothing"),
        (lambda b, u, w: (both_scales(b, u, w)[0], ...), "is still `...`"),
        (lambda b, u, w: both_scales(b, u, w).T, r"use np.array\(\[...\]\)"),
    ],
)
def test_slip_in_the_scale_factors_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter5.scale_factors(function)


def midpoint(stations, directions):
    """The answer for two rays, given for the first two of any number."""
    return nearest(stations[:2], directions[:2])


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda s, d: nearest(s, d, unit=False), "make it a unit vector"),
        (midpoint, "is not least"),
        (lambda s, d: s.mean(axis=0), "two of the rays alone"),
        (lambda s, d: nearest(s, -d) + 1, "that meet exactly"),
    ],
)
def test_slip_in_the_intersection_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter5.intersection(function)


def test_wrong_point_from_unit_vectors_is_not_told_to_use_them():
    with pytest.raises(CheckFailed) as failed:
        chapter5.intersection(lambda s, d: nearest(s, d) + 1)
    assert "that meet exactly" in str(failed.value)
    assert "unit vector" not in str(failed.value)


def test_scale_factors_may_be_a_pair():
    chapter5.scale_factors(lambda b, u, w: tuple(both_scales(b, u, w)))


def test_rays_of_a_line_have_no_sign():
    chapter5.intersection(lambda s, d: nearest(s, -d))


@pytest.mark.parametrize(
    ("function", "hint"),
    [
        (lambda *a: base(*a) / np.sqrt(2), "difference of two coordinates"),
        (lambda *a: base(*a) * 1000, r"base is 10\^3 times too large\."),
        (lambda *a: base(*a) / 1e6, r"base is 10\^6 times too small\."),
        (lambda *a: -base(*a), "my_base: a length is positive"),
        (
            lambda *a: base(*a) * 1000 / np.sqrt(2),
            r"a factor is missing, and your base is 10\^3 times too large",
        ),
        (lambda *a: 0.0, "does not follow"),
        (lambda *a: np.nan, "got NaN: look for a division"),
        (lambda h, c, s, w: base(h, c, s, w) / h * 1000, "twice the ground, and"),
        (lambda h, c, s, w: base(h, c, s, w) * w, "does not follow"),
    ],
)
def test_slip_in_the_base_is_named(function, hint):
    with pytest.raises(CheckFailed, match=hint):
        chapter5.base(function)


def test_base_agrees_with_the_covariance_of_an_intersection():
    height, c, sigma, wanted = 1000.0, 24.0, 3.0, 0.5
    b = base(height, c, sigma, wanted)
    pair = np.array([(-b / 2, 0, height, 0, 0, 0), (b / 2, 0, height, 0, 0, 0)])
    one = camera.Camera(c)
    point = np.array([3.0, 7.0, 1.0])
    images = camera.project(one, pair[:, None], point[None])
    found = orientation.intersect(one, pair, images, sigma=sigma / 1000)
    # The point is 1 m high: H is 0.1 % less, its square 0.2 %
    assert found.covariance[0, 2, 2] ** 0.5 == pytest.approx(wanted, rel=0.003)


def test_what_stands_around_exercise_5_1_does_not_answer_it():
    """From the start of the chapter to the next section after the check."""
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    sources = [cell.source for cell in notebook.cells]
    check = next(i for i, text in enumerate(sources) if "chapter5.misprints(" in text)
    after = next(
        i for i, text in enumerate(sources) if i > check and text.startswith("## ")
    )
    shown = " ".join(sources[:after]).replace("{", "").replace("}", "")
    assert "Resection" in sources[after]
    for name in ("b13", "b_13", "b22", "b_22", "b23", "b_23", "salah cetak", "four of"):
        assert name not in shown.lower(), name
