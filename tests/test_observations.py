"""Matches that become image observations: names, what is dropped, and covariances."""

from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import bundle, frames, lsm, observations, simulate
from pgm_lab.camera import Camera

SIZE, PIXEL = (200, 160), (0.01, 0.02)
AFFINE = {"B": (3.3, 1.02, 0.1, -2.2, -0.08, 0.97), "C": (-4.6, 1, 0, 1.7, 0, 1)}
POINTS = np.stack(np.meshgrid(np.arange(35, 160, 15), np.arange(40, 125, 15)), -1)
POINTS = POINTS.reshape(-1, 2) + 0.0
NAMES = [f"P{i}" for i in range(len(POINTS))]


def turned(affine, points):
    a = np.reshape(affine, (2, 3))
    return a[:, 0] + points @ a[:, 1:].T


def matches(seed=0, sigma=6.0, points=POINTS):
    """Matches of one noisy image with two others, each with noise of its own."""
    found, texture = {}, simulate.texture(seed=3)
    for i, (name, affine) in enumerate(AFFINE.items()):
        left, right = simulate.texture_pair(texture, SIZE[::-1], affine)
        left = simulate.photograph(left, sigma, [seed, 0])
        right = simulate.photograph(right, sigma, [seed, i + 1])
        found[name] = lsm.match(left, right, points, turned(affine, points))
    return found


def of(found, **changes):
    arguments = dict(left="A", points=NAMES)
    return observations.from_matches(
        POINTS, found, SIZE, PIXEL, **(arguments | changes)
    )


def test_only_accepted_matches_become_rays_and_the_others_are_counted():
    found = matches()
    for name, match in found.items():
        assert np.all(match.accepted), name
    status = found["B"].status.copy()
    status[[0, 1]], status[2] = "diverged", "below threshold"
    bad = replace(found["B"], status=status)
    status = found["C"].status.copy()
    status[2] = "singular"
    seen = of({"B": bad, "C": replace(found["C"], status=status)})
    n = len(POINTS)
    assert [seen.photo.count(name) for name in "ABC"] == [n - 1, n - 3, n - 1]
    assert seen.dropped == {
        ("B", "diverged"): 2,
        ("B", "below threshold"): 1,
        ("C", "singular"): 1,
    }
    assert "P2" not in seen.point  # no photo shows it but the left one
    assert str(seen).split("\n")[1] == (
        f"photo B: {n - 3} points, dropped: 2 diverged, 1 below threshold"
    )
    names, (a, b) = seen.common("A", "B")
    assert names == tuple(NAMES[3:])
    expected = frames.pixel_to_photo(found["B"].points[3:], SIZE, PIXEL)
    np.testing.assert_array_equal(b, expected)
    np.testing.assert_array_equal(a, frames.pixel_to_photo(POINTS[3:], SIZE, PIXEL))


def test_left_and_right_errors_together_are_those_of_the_match():
    found = matches()["B"]
    seen = of({"B": found})
    n = len(POINTS)
    J = found.parameters[:, [[1, 2], [4, 5]]]
    D = np.diag([PIXEL[0], -PIXEL[1]])
    J = D @ J @ np.linalg.inv(D)  # from photo coordinates to photo coordinates
    left, right = seen.covariance[:n], seen.covariance[n:]
    whole = right + J @ left @ J.swapaxes(1, 2)
    np.testing.assert_allclose(whole, D @ found.covariance @ D, rtol=1e-9, atol=1e-20)
    np.testing.assert_allclose(right, whole / 2, rtol=1e-9, atol=1e-20)


@pytest.mark.parametrize("noises", [8, pytest.param(20, marks=pytest.mark.slow)])
def test_half_of_the_error_of_a_match_is_common_to_all_photos(noises):
    """The model of the note in `from_matches`, by noises of all three images."""
    errors = []
    for seed in range(noises):
        found, e = matches(seed), []
        for name, match in found.items():
            J = match.parameters[:, [[1, 2], [4, 5]]]
            off = match.points - turned(AFFINE[name], POINTS)
            L = np.linalg.cholesky(match.covariance)
            in_left = np.linalg.solve(J, off[..., None])  # comparable with each other
            scale = np.linalg.norm(L, axis=(1, 2))[:, None]
            e.append(in_left[..., 0] / scale)
        errors.append(e)
    b, c = np.moveaxis(errors, 1, 0)
    n = b.size / 2  # windows touch each other: not all are independent
    share = np.sum(b * c) / np.sqrt(np.sum(b * b) * np.sum(c * c))
    assert abs(share - 0.5) < 4 * (1 - 0.5**2) / np.sqrt(n)


def test_rows_go_into_a_network_with_their_covariances():
    seen = of(matches())
    photos = {name: (10 * i, 0, 50, 0, 0, 0) for i, name in enumerate("CAB")}
    points = {name: (i, 0, 0) for i, name in enumerate(NAMES)}
    network = bundle.Network.of(Camera(5.0), photos, points, seen.rows)
    np.testing.assert_array_equal(network.xy, seen.xy)
    np.testing.assert_array_equal(network.covariance, seen.covariance)
    assert [network.photo_names[i] for i in network.photo] == list(seen.photo)
    assert [network.point_names[i] for i in network.point] == list(seen.point)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"left": "B"}, "photo 'B' is the left one"),
        ({"points": ["x"] * len(POINTS)}, "must be 54 different names"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        of(matches(), **changes)


def test_matches_of_other_points_and_matches_without_success_are_refused():
    found = matches(points=POINTS[:5])
    with pytest.raises(ValueError, match="photo 'B' has 5 points, but left_points"):
        of(found)
    with pytest.raises(ValueError, match="no match was accepted"):
        none = found["B"]
        none = replace(none, status=np.full(5, "diverged"))
        observations.from_matches(POINTS[:5], {"B": none}, SIZE, PIXEL, left="A")
    with pytest.raises(ValueError, match="no observation was made in photo 'X'"):
        of(matches()).common("A", "X")
