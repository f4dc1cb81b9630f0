"""Figures of rotated frames and cameras: their alt texts say what they show."""

import numpy as np
import pytest

from pgm_book.ch04 import case_figures, figures, printed_matrices
from pgm_lab import datasets, rotation

DATA = datasets.muliawan2013()
OTHER = DATA.exteriors.copy()
OTHER[[1, 6], 5] += 0.5
PRINTED = printed_matrices.matrices(0.3, 0.4, 0.5)
STEEP = [(20, 90, 30), (50, 90, 0)], ["one", "two"]
FIGURES = [
    (figures.plane_rotation, (), ["e_x reaches cos kappa along X"]),
    (figures.three_rotations, (), ["25 degrees", "phi about y, from Z towards X"]),
    (figures.one_camera, (), ["perspective centre"]),
    (figures.mirror, (), ["the N is written backwards"]),
    (figures.quadrant, (131,), ["131 degrees and the opposite one of -49"]),
    (
        figures.two_views,
        ([(0, 0, 0), (0, 0, 20), (0, 90, 0)], ["straight", "turned", "level"]),
        [
            "straight: the arrow to the north points up",
            "turned: the arrow to the north points 20 degrees to the right",
            "level: the arrow to the north is out of sight",
        ],
    ),
    (figures.two_views, STEEP, ["all cameras and all photos are the same"]),
    (
        figures.two_orders,
        (20, 30, 40),
        [
            "A rotation by 26.1° leads from one camera to the other;",
            "their lines of sight are 19.9° apart.",
        ],
    ),
    (
        figures.around_camera,
        (DATA.object_points, {"one": DATA.exteriors}),
        ["fifty targets. one. The axes"],
    ),
    (
        figures.around_camera,
        (DATA.object_points, {"as published": DATA.exteriors, "turned": OTHER}),
        [
            "as published: rotated against the first set: none",
            "turned: rotated against the first set: 2, 7",
        ],
    ),
    (
        case_figures.rows_and_columns,
        (PRINTED,),
        [
            "(M 2.8): none of M Mᵀ, none of Mᵀ M",
            "(B 3): (1, 1) (1, 2) (1, 3) (2, 1) (3, 1) of M Mᵀ",
        ],
    ),
    (case_figures.bench, (PRINTED,), ["0.761"]),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), FIGURES, ids=[f[0].__name__ for f in FIGURES]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    said = alt_of(draw, *arguments)
    assert [one for one in words if one not in said] == []


def test_sliders_turn_the_camera(alt_of, monkeypatch):
    monkeypatch.setattr(figures, "interact", lambda draw, **_: draw(0, 0, -20))
    assert "κ = −20°, and its photo" in alt_of(figures.attitude_by_hand)


def test_the_three_turns_go_from_axis_to_axis_as_written():
    for k, (_, axis, start, end, _) in enumerate(figures.TURNS):
        M = rotation.matrix(*(0.3 * np.eye(3)[k]))
        assert "xyz".index(axis) == k
        assert M["XYZ".index(start), "XYZ".index(end)] > 0


def test_printed_matrices_are_those_of_the_audit():
    from tests.audit.test_bani2010_rotation import matrix_3
    from tests.audit.test_muliawan2013_rotation import matrix_2_62

    angles = (0.7, -0.3, 1.9)
    printed = printed_matrices.matrices(*angles)
    np.testing.assert_allclose(printed["(B 3)"], matrix_3(*angles), atol=1e-15)
    np.testing.assert_allclose(printed["(M 2.62)"], matrix_2_62(*angles), atol=1e-15)


# --- The meadow: no symmetry hides a wrong rotation ---


def test_village_has_no_symmetry():
    corners = np.concatenate([polygon for polygon, _ in figures.village()])
    high = corners[corners[:, 2] > 0.5]
    for turned in (high * (-1, 1, 1), high * (1, -1, 1), high[:, [1, 0, 2]]):
        gap = np.linalg.norm(turned[:, None] - high[None], axis=-1).min(axis=1)
        assert gap.max() > 0.5
