"""What a network refuses, and how it names what it does not determine."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import bundle, camera, rotation
from pgm_lab.adjustment import RankDefect
from pgm_lab.camera import Camera
from tests.networks import moved, small

SOME = ("c", "x0", "y0", "K1")


def test_without_a_datum_the_seven_motions_are_named():
    with pytest.raises(RankDefect, match="rank defect 7") as refused:
        bundle.adjust(small(), SOME, "none")
    assert refused.value.null_space.defect == 7
    names = refused.value.null_space.names
    assert names[0] == "shift in X" and names[6] == "scale"


@pytest.mark.parametrize(
    ("changes", "defect"),
    [
        ({"fixed": [0]}, 4),
        ({"fixed": [0, 1]}, 1),
        ({"scale_bars": [(0, 1, 300.0, 0.1)]}, 6),
        ({"fixed": [0], "scale_bars": [(0, 1, 300.0, 0.1)]}, 3),
        ({"control": ([0, 1], np.zeros((2, 3)), [[1, 1, 1], [1, 1, np.inf]])}, 2),
    ],
)
def test_too_little_control_leaves_the_motions_that_geometry_says(changes, defect):
    datum = "fixed" if {"fixed", "control"} & set(changes) else "none"
    with pytest.raises(RankDefect, match=f"rank defect {defect}"):
        bundle.adjust(replace(small(), **changes), SOME, datum)


def test_three_points_in_one_line_do_not_carry_a_datum():
    network = small()
    points = network.points.copy()
    points[2] = (points[0] + points[1]) / 2
    in_line = replace(network, points=points)
    with pytest.raises(RankDefect, match="rank defect 1"):
        bundle.adjust(replace(in_line, fixed=[0, 1, 2]), SOME)
    with pytest.raises(ValueError, match="in one line"):
        bundle.adjust(replace(in_line, datum_points=[0, 1, 2]), SOME)


def fewer_rays(network, of, which, kept):
    """The network with so many rays of one point, or of one photo."""
    return network.without(np.flatnonzero(getattr(network, of) == which)[kept:])


def with_exteriors(rows, columns, values):
    network = small()
    exteriors = network.exteriors.copy()
    exteriors[rows, columns] = values
    return replace(network, exteriors=exteriors)


ONE_PLACE = slice(None), slice(3), small().exteriors[:, :3].mean(axis=0)
IN_A_POINT = 0, slice(None), (*small().points[small().point[0]], 0, 0, 0)


@pytest.mark.parametrize(
    ("network", "error", "message"),
    [
        (fewer_rays(small(), "point", 7, 1), RankDefect, "point 8 has 1"),
        (fewer_rays(small(), "point", 7, 0), RankDefect, "point 8 has none"),
        (fewer_rays(small(), "photo", 2, 2), RankDefect, "photo 3 has 2"),
        (with_exteriors(*ONE_PLACE), RankDefect, "point 1, 2.*parallel or coincide"),
        (with_exteriors(3, 4, np.pi / 2), RankDefect, "photo 4 has phi = .*gimbal lo"),
        (with_exteriors(*IN_A_POINT), ValueError, "check the start values"),
    ],
)
def test_what_cannot_be_determined_is_named(network, error, message):
    with pytest.raises(error, match=message):
        bundle.adjust(network, ())


def test_a_control_point_needs_no_second_ray():
    once = fewer_rays(replace(small(), fixed=[0, 4, 7]), "point", 7, 1)
    assert bundle.adjust(once, SOME).status == "converged"
    weighted = replace(once, fixed=[0, 4], control=([7], once.points[[7]], 0.1))
    assert bundle.adjust(weighted, SOME).status == "converged"


@pytest.mark.parametrize("phi, cosine", [(89.9, 1.7e-3), (89.999, 1.7e-5)])
def test_a_photo_near_the_gimbal_lock_is_adjusted_like_any_other(phi, cosine):
    """The same network, turned until one photo has this phi, fits as well."""
    network = small()
    still = bundle.adjust(network, SOME, tolerance=1e-9)
    level = replace(network, exteriors=still.exteriors, points=still.points)
    M = rotation.matrix(*still.exteriors[3, 3:])
    turn = rotation.matrix(0.2, np.radians(phi), 0.4).T @ M
    near = moved(level, 1.0, turn, np.zeros(3))
    assert np.cos(near.exteriors[3, 4]) == approx(cosine, rel=0.05)
    found = bundle.adjust(near, SOME, tolerance=1e-9)
    assert found.status == "converged"
    assert found.sigma0 == approx(still.sigma0, rel=1e-9)
    close(found.interior, still.interior, rtol=1e-6)
    for locked in (90.0, 89.99999):
        exteriors = near.exteriors.copy()
        exteriors[3, 4] = np.radians(locked)
        with pytest.raises(RankDefect, match="photo 4 has phi = .*gimbal lock"):
            bundle.adjust(replace(near, exteriors=exteriors), SOME)


def nadir(kappa=0.0, phi=0.0, depth=1.0, **options):
    """Six photos with parallel axes, unless they are tilted by phi."""
    X = np.random.default_rng(0).uniform(-100, 100, (30, 3)) * [1, 1, depth]
    centres = [(x, y, 300) for x in (-50, 0, 50) for y in (-40, 40)]
    exteriors = np.zeros((6, 6))
    exteriors[:, :3] = centres
    exteriors[:, 4] = phi * np.sign(exteriors[:, 0])
    exteriors[:, 5] = kappa * (np.arange(6) % 3)
    photo, point = np.divmod(np.arange(180), 30)
    xy = camera.project(Camera(50.0), exteriors[photo], X[point])
    return bundle.Network(Camera(50.0), exteriors, X, photo, point, xy, **options)


def test_parameters_that_parallel_photos_of_a_plane_do_not_determine_are_named():
    with pytest.raises(RankDefect) as refused:
        bundle.adjust(nadir(depth=0), ("c", "x0", "y0"))
    names = refused.value.null_space.names
    # c with the flying height, x0 with X0, y0 with Y0 of all photos
    assert refused.value.null_space.defect == 3
    assert {"c", "x0", "y0"} <= {*names}
    assert "kappa of photo 1" not in names


def test_what_the_message_advises_first_is_what_helps():
    """With parallel axes no depth of the points tells c from a stretch in Z."""
    with pytest.raises(RankDefect) as refused:
        bundle.adjust(nadir(), ("c", "x0", "y0"))
    advice = str(refused.value).partition(": the rays")[2].partition(". ")[2]
    assert advice.startswith("Add photos that converge and are rolled by 90 degrees")
    assert "where there are control points, add some at other depths" in advice
    turned = nadir(kappa=np.pi / 2, phi=0.3)
    assert bundle.adjust(turned, ("c", "x0", "y0")).status == "converged"
    assert bundle.adjust(nadir(), ()).status == "converged"  # parameters left out
    assert bundle.adjust(nadir(fixed=range(8)), ("c",)).status == "converged"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"xy": np.zeros((3, 2))}, "photo must be whole numbers in one row of 3"),
        ({"point": np.arange(72)}, "point must be indices from 0 to 11"),
        ({"sigma": 0.0}, "sigma.* must be positive"),
        (
            {"cameras": [Camera(30.0), Camera(30.0, lens="forward")]},
            "with the same lens direction",
        ),
        ({"camera": [1] * 6}, "camera must be indices from 0 to 0"),
        ({"cameras": [Camera(30.0), Camera(31.0)]}, r"cameras\[1\] have no photo"),
        ({"fixed": [12]}, "fixed must be indices"),
        (
            {"fixed": [1, 2], "control": ([2], np.zeros((1, 3)), 1.0)},
            "point 2 is in `fixed` and in `control`",
        ),
        (
            {"fixed": [1], "check": ([1], np.zeros((1, 3)))},
            "point 1 is in `fixed` and in `check`",
        ),
        ({"control": ([1, 1], np.zeros((2, 3)), 1.0)}, "control has a point twice"),
        ({"control": ([1], np.zeros((1, 3)), -1.0)}, "control must have sigmas"),
        ({"scale_bars": [(0, 0, 5.0, 1.0)]}, "two different points"),
        ({"scale_bars": [(0, 1, 5.0, 0.0)]}, "positive distance and sigma"),
        (
            {"points": np.zeros((12, 3)), "scale_bars": [(0, 1, 5.0, 1.0)]},
            r"scale_bars\[0\] join points with the same start",
        ),
        ({"photo_names": ["a"] * 6}, "photo_names must be 6 different names"),
    ],
)
def test_a_network_says_what_is_wrong_with_it(changes, message):
    with pytest.raises(ValueError, match=message):
        replace(small(), **changes)


def test_nan_and_doubled_observations_are_refused_with_their_place():
    network = small()
    xy = network.xy.copy()
    xy[5, 1] = np.nan
    with pytest.raises(ValueError, match=r"xy\[5, 1\] is not a finite number"):
        replace(network, xy=xy)
    point = network.point.copy()
    same = np.flatnonzero(network.photo == 0)
    point[same[1]] = point[same[0]]
    other = np.flatnonzero(network.photo == 3)
    point[other[:3]] = point[other[0]]
    with pytest.raises(ValueError, match=f"photo 1 has point {point[same[0]] + 1} 2 t"):
        replace(network, point=point)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"estimate": ("c", "k1")}, "estimate must be one of"),
        ({"datum": "free"}, "datum must be one of"),
        ({"datum": "fixed"}, "needs `fixed` or `control`"),
        ({"sigma0_prior": 0}, "sigma0_prior must be positive"),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        bundle.adjust(small(), **options)


def test_inner_constraints_are_refused_beside_control_points():
    with pytest.raises(ValueError, match="is for networks without control"):
        bundle.adjust(replace(small(), fixed=[1, 2, 3]), SOME, "inner")
