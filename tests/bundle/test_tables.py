"""A network made of tables with names, and the network of some of its photos."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal

from pgm_lab import bundle
from pgm_lab.camera import Camera
from tests.networks import real, small

PHOTOS = {"A": (0, 0, 1000, 0, 0, 0), "B": (300, 0, 1000, 0, 0, 0)}
POINTS = {"tower": (100, 20, 0), 7: (90, -20, 5), "gate": (120, 10, 3)}
ROWS = [("B", 7, -10, 1), ("A", "tower", 5, 1), ("A", 7, 4, 2), ("B", "gate", 1, 1)]
C = [[4e-6, 1e-6], [1e-6, 9e-6]]


def of(observations=ROWS, **changes):
    arguments = dict(cameras=Camera(50.0), photos=PHOTOS, points=POINTS)
    return bundle.Network.of(observations=observations, **(arguments | changes))


def test_rows_in_any_order_find_their_photos_and_points():
    network = of()
    assert network.photo.tolist() == [1, 0, 0, 1]
    assert network.point.tolist() == [1, 0, 1, 2]
    assert network.photo_names == ("A", "B")
    assert network.point_names == ("tower", 7, "gate")
    assert network.xy[2].tolist() == [4, 2] and np.all(network.sigma == 0.001)


def test_rows_carry_standard_deviations_or_covariances():
    network = of([(*row, 0.002, 0.003) for row in ROWS])
    assert network.sigma[3].tolist() == [0.002, 0.003]
    network = of([(*row, C) for row in ROWS])
    equal(network.covariance[2], C)
    close(network.sigma[2], (0.002, 0.003), rtol=1e-15)


def test_what_is_known_of_points_goes_by_their_names():
    network = of(
        fixed=["gate"],
        control={7: (90, -20, 5, 0.1, 0, np.inf)},
        check={"tower": (1, 2, 3)},
        datum_points=["gate", 7],
        scale_bars=[("gate", 7, 44.0, 0.1)],
    )
    assert network.fixed.tolist() == [2] and network.datum_points.tolist() == [1, 2]
    index, coordinates, sigma = network.control
    assert index.tolist() == [1] and coordinates.tolist() == [[90, -20, 5]]
    assert sigma.tolist() == [[0.1, 0, np.inf]]
    assert network.check[0].tolist() == [0]
    assert network.scale_bars.tolist() == [[2, 1, 44.0, 0.1]]
    expected = [[False] * 3, [True, True, False], [True] * 3]
    assert network.known.tolist() == expected
    assert network.held.tolist() == [[False] * 3, [False, True, False], [True] * 3]


def test_several_cameras_by_name():
    cameras = {"wide": Camera(20.0), "long": Camera(80.0)}
    network = of(cameras=cameras, camera={"B": "wide", "A": "long"})
    assert network.camera.tolist() == [1, 0]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"observations": [*ROWS, ("C", 7, 0, 0)]},
            "observations, row 4: 'C' is not in photos, which has 'A', 'B'",
        ),
        (
            {"observations": [("A", "door", 0, 0)]},
            "row 0: 'door' is not in points, which has 'tower', 7, 'gate'",
        ),
        ({"observations": [*ROWS, ("A", "gate", 1, 2, C)]}, r"rows of \[4, 5\] col"),
        (
            {"observations": [("A", 7, np.nan, 0)]},
            r"observations \(x, y\)\[0, 0\] is not a finite",
        ),
        ({"points": POINTS | {7: (1, 2)}}, "points, 7: 3 finite numbers are needed"),
        ({"fixed": ["door"]}, "fixed: 'door' is not in points"),
        ({"control": {7: (1, 2, 3)}}, "control, 7: 6 numbers are needed"),
        ({"scale_bars": [(7, "x", 1, 1)]}, "scale_bars, row 0: 'x' is not in points"),
        (
            {"cameras": {1: Camera(5.0), 2: Camera(6.0)}},
            "camera must name the camera of each photo",
        ),
        (
            {"cameras": {1: Camera(5.0)}, "camera": {"A": 1}},
            "camera says nothing of photo 'B'",
        ),
        (
            {"cameras": {1: Camera(5.0)}, "camera": {"A": 1, "B": 2}},
            "camera: 2 is not in cameras, which has 1",
        ),
    ],
)
def test_a_name_that_no_table_has_is_told_with_its_place(changes, message):
    with pytest.raises(ValueError, match=message):
        of(**changes)


@pytest.mark.parametrize(
    ("covariance", "message"),
    [
        (np.diag([1e-6, 0]), "a direction has no error at all"),
        (np.ma.masked_equal(np.eye(2), 0), "covariance has masked values"),
        (np.tile(np.eye(2), (3, 1, 1)), r"have shape \(4, 2, 2\)"),
    ],
)
def test_a_covariance_that_is_none_is_refused(covariance, message):
    with pytest.raises(ValueError, match=message):
        replace(of(), sigma=None, covariance=covariance)


def test_some_photos_of_the_real_network_adjust_as_if_only_they_had_been_taken():
    network, some = real(), [0, 3, 5, 6, 7]
    kept = np.isin(network.photo, some)
    alone = bundle.Network(
        network.cameras,
        network.exteriors[some],
        network.points,
        np.searchsorted(some, network.photo[kept]),
        network.point[kept],
        network.xy[kept],
    )
    found = bundle.adjust(network.only(some))
    assert found.network.photo_names == (1, 4, 6, 7, 8)
    equal(found.points, bundle.adjust(alone).points)


def test_points_that_lose_their_rays_go_with_all_that_was_said_of_them():
    network = small(cameras=3, photos=6, points=12)
    unseen = (network.point == 4) & np.isin(network.photo, [1, 2, 4])
    network = network.without(np.flatnonzero(unseen))
    given = (np.array([4, 5]), network.points[[4, 5]], 0.1 * np.ones((2, 3)))
    network = replace(
        network,
        check=given[:2],
        datum_points=[3, 4, 6],
        scale_bars=[(4, 6, 100.0, 1.0), (6, 8, 200.0, 1.0)],
        fixed=[11],
    )
    part = network.only([4, 1, 2])  # photos 1 and 4 are of camera 1, 2 of camera 2
    assert part.photo_names == (2, 3, 5) and part.camera.tolist() == [0, 1, 0]
    assert part.cameras == network.cameras[1:]
    assert part.point_names == (1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12)
    assert part.datum_points.tolist() == [3, 5] and part.fixed.tolist() == [10]
    assert part.scale_bars.tolist() == [[5, 7, 200.0, 1.0]]
    assert part.check[0].tolist() == [4]
    equal(part.check[1], network.points[[5]])
    for ray in range(len(part.xy)):
        photo = part.photo_names[part.photo[ray]] - 1
        point = part.point_names[part.point[ray]] - 1
        (same,) = np.flatnonzero((network.photo == photo) & (network.point == point))
        equal(part.xy[ray], network.xy[same])
        equal(part.sigma[ray], network.sigma[same])
