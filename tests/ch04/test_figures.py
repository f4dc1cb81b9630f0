"""Figures of turned frames and cameras: what they say is what they show."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch04 import case_figures as ch04_case_figures
from pgm_book.ch04 import figures as ch04_figures
from pgm_lab import datasets, plot, rotation


@pytest.fixture(autouse=True, scope="module")
def style():
    with plt.rc_context(plot.STYLE):
        yield


def test_sketches_name_their_parts(alt_of):
    assert "e_x reaches cos kappa along X" in alt_of(ch04_figures.plane_rotation)
    said = alt_of(ch04_figures.three_rotations, 30)
    assert "30 degrees" in said and "phi about y, from Z towards X" in said
    assert "perspective centre" in alt_of(ch04_figures.one_camera)
    assert "the N is written backwards" in alt_of(ch04_figures.mirror)


def test_the_three_turns_go_from_axis_to_axis_as_written():
    for k, (_, axis, start, end, _) in enumerate(ch04_figures.TURNS):
        M = rotation.matrix(*(0.3 * np.eye(3)[k]))
        old, new = "XYZ".index(start), "XYZ".index(end)
        assert "xyz".index(axis) == k
        assert M[old, new] > 0, "the axis that is the first goes towards the second"


def test_the_quadrant_names_what_arctan_answers(alt_of):
    assert "131 degrees and the opposite one of -49" in alt_of(
        ch04_figures.quadrant, 131
    )


def test_views_say_where_north_is_in_the_photo(alt_of):
    names = ["straight", "turned", "level"]
    attitudes = [(0, 0, 0), (0, 0, 20), (0, 90, 0)]
    said = alt_of(ch04_figures.two_views, attitudes, names)
    assert "straight: the arrow to the north points up" in said
    assert "turned: the arrow to the north points 20 degrees to the right" in said
    assert "level: the arrow to the north is not to be seen" in said


def test_views_of_one_camera_by_two_names_say_so(alt_of):
    same = alt_of(ch04_figures.two_views, [(20, 90, 30), (50, 90, 0)], ["one", "two"])
    other = alt_of(ch04_figures.two_views, [(20, 80, 30), (50, 80, 0)], ["one", "two"])
    assert "all cameras and all photos are the same" in same
    assert "are the same" not in other


def test_two_orders_say_how_far_apart_they_are(alt_of):
    said = alt_of(ch04_figures.two_orders, 20, 30, 40)
    assert "One turn of 26.1° leads from one camera to the other;" in said
    assert "their lines of sight are 19.9° apart." in said


def test_one_set_of_cameras_is_compared_with_none(alt_of):
    data = datasets.muliawan2013()
    said = alt_of(
        ch04_figures.around_camera, data.object_points, {"one": data.exteriors}
    )
    assert "fifty targets. one. The axes" in said and "turned away" not in said


def test_around_names_the_cameras_that_look_elsewhere(alt_of):
    data = datasets.muliawan2013()
    other = data.exteriors.copy()
    other[[1, 6], 5] += 0.5
    sets = {"as published": data.exteriors, "turned": other}
    said = alt_of(ch04_figures.around_camera, data.object_points, sets)
    assert "as published: turned away from the first set are none" in said
    assert "turned: turned away from the first set are 2, 7" in said


def test_printed_matrices_fail_where_they_should(alt_of):
    printed = ch04_case_figures.matrices(0.3, 0.4, 0.5)
    said = alt_of(ch04_case_figures.rows_and_columns, printed)
    assert "(M 2.8): none of M Mᵀ, none of Mᵀ M" in said
    rows = "(1, 1) (1, 2) (1, 3) (2, 1) (3, 1) of M Mᵀ"
    assert f"(B 3): {rows}" in said
    assert "0.761" in alt_of(ch04_case_figures.bench, printed)


def test_printed_matrices_are_those_of_the_audit():
    from tests.audit.test_bani2010_rotation import matrix_3
    from tests.audit.test_muliawan2013_rotation import matrix_2_62

    angles = (0.7, -0.3, 1.9)
    printed = ch04_case_figures.matrices(*angles)
    np.testing.assert_allclose(printed["(B 3)"], matrix_3(*angles), atol=1e-15)
    np.testing.assert_allclose(printed["(M 2.62)"], matrix_2_62(*angles), atol=1e-15)
