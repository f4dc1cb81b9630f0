"""Simulated networks: what is asked for is what comes, and an adjustment finds it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pgm_lab import bundle, camera, rotation, simulate
from pgm_lab.simulate import photos

LENSES = [
    camera.Camera(35.0),
    camera.Camera(35.0, 0.1, -0.2, K1=-1e-4, K2=1e-7, P1=1e-5, P2=-1e-5, b1=1e-4),
    camera.Camera(35.0, 0.1, -0.2, K1=5e-5, P2=1e-5, b2=-1e-4, lens="forward"),
    camera.Camera(5.0),  # so wide that some points lie behind some cameras
]


def rng(seed=1):
    return np.random.default_rng(seed)


def true_image(net):
    exteriors, points = net.exteriors[net.photo], net.points[net.point]
    return camera.project(net.camera, exteriors, points)


def axes(net):
    """Directions in which the cameras look."""
    return -rotation.matrix(*net.exteriors[:, 3:].T)[:, 2]


@settings(max_examples=60, deadline=None)
@given(
    lens=st.sampled_from(LENSES),
    photos=st.integers(2, 20),
    points=st.integers(1, 60),
    convergent=st.booleans(),
    rolled=st.booleans(),
    flat=st.booleans(),
    share=st.floats(0, 1),
    seed=st.integers(0, 10**6),
)
def test_every_ray_is_in_front_of_its_camera_and_inside_the_image(
    lens, photos, points, convergent, rolled, flat, share, seed
):
    rays = 2 + share * (photos - 2)
    net = simulate.network(
        lens,
        photos,
        points,
        rng(seed),
        rays,
        convergent=convergent,
        rolled=rolled,
        flat=flat,
        sigma=0.0,
    )
    # project refuses points behind a camera
    np.testing.assert_array_equal(net.xy, true_image(net))
    assert np.all(np.abs(net.xy) < (18, 12))
    # as many rays as asked for, none twice, sorted
    assert len(net.xy) == int(rays) * points + round((rays - int(rays)) * points)
    count = np.bincount(net.point, minlength=points)
    assert set(count) <= {int(rays), int(rays) + 1}
    assert np.all(np.diff(net.photo * points + net.point) > 0)
    assert np.all(net.points[:, 2] == 0) == flat


@pytest.mark.parametrize("rays", [2, 3.4, 5])
@pytest.mark.parametrize("convergent", [False, True])
def test_a_block_has_the_rays_asked_for_and_no_photo_sees_all_of_it(rays, convergent):
    net = simulate.network(
        LENSES[1], 30, 2000, rng(), rays, block=True, convergent=convergent
    )
    assert len(net.xy) == rays * 2000
    assert np.bincount(net.photo, minlength=30).min() > 30
    # no photo sees the terrain from end to end
    X = net.points[:, 0]
    widths = [np.ptp(X[net.point[net.photo == photo]]) for photo in range(30)]
    assert max(widths) < 0.9 * np.ptp(X)


def test_errors_have_the_standard_deviation_asked_for():
    net = simulate.network(LENSES[1], 20, 500, rng(), sigma=0.002)
    error = (net.xy - true_image(net)) / 0.002
    # 20,000 of them: their sd is known to 0.5 %, their mean to 0.007 of one
    assert abs(np.std(error) - 1) < 0.02
    assert np.abs(error.mean(axis=0)).max() < 0.03
    assert net.sigma == 0.002


@pytest.mark.parametrize("block", [False, True])
def test_axes_are_parallel_or_convergent(block):
    inclined = {}
    for convergent in (False, True):
        net = simulate.network(
            LENSES[0], 12, 20, rng(), 3, convergent=convergent, block=block
        )
        inclined[convergent] = np.degrees(np.arccos(-axes(net)[:, 2]))
    assert inclined[False].max() < 3  # pointing errors of half a degree
    assert inclined[True].max() > 18
    assert inclined[True].max() < 38


@pytest.mark.parametrize("rolled", [False, True])
def test_rolled_photos_are_turned_by_quarters(rolled):
    net = simulate.network(LENSES[0], 8, 20, rng(), rolled=rolled)
    expected = np.arange(8) % 4 * 90 if rolled else 0
    assert np.abs(np.degrees(net.exteriors[:, 5]) - expected).max() < 3


@pytest.mark.parametrize("lens", LENSES[1:3], ids=["backward", "forward"])
def test_an_adjustment_finds_the_true_camera_as_precisely_as_it_says(lens):
    """Twenty networks: the errors of the camera in their sd have a mean square of 1."""
    squares = []
    for seed in range(20):
        net = simulate.network(lens, 8, 40, rng(seed), sigma=0.001)
        start = camera.Camera(35.2, lens=lens.lens)
        network = bundle.Network(
            start,
            net.exteriors,
            net.points,
            net.photo,
            net.point,
            net.xy,
            net.sigma,
        )
        found = bundle.adjust(network, sigma0_prior=1.0)
        assert found.status == "converged"
        error = found.cameras[0].interior - lens.interior
        squares.append(error @ np.linalg.solve(found.covariance_interior, error) / 10)
    # chi squared with 200 degrees of freedom over 200: 1 +- 0.1
    assert abs(np.mean(squares) - 1) < 0.4


@pytest.mark.parametrize("make", [simulate.pair, simulate.control_photo])
def test_a_lens_that_shows_too_little_ends_the_search_for_a_photo(make, monkeypatch):
    monkeypatch.setattr(photos, "TRIES", 50)
    with pytest.raises(ValueError, match="in 50 tries.* 40 points.*c = 180 mm"):
        make(camera.Camera(180.0), 40, rng())
