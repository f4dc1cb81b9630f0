"""The road from the pixel to the network: all of the package in one walk.

Three photos of a hilly ground are simulated, points of the first are found in the
others, and camera stations and ground points follow from nothing but grey values, the
camera, and a rough idea of the flight. What this does not prove: anything of real
photos, whose errors are not white.
"""

from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import (
    bundle,
    camera,
    frames,
    lsm,
    ncc,
    observations,
    orientation,
    report,
    simulate,
)
from pgm_lab.camera import Camera, ideal, imaging

CAMERA = Camera(4.0, 0.02, -0.01)
SIZE, PIXEL, CELL = (320, 240), 0.01, 0.25  # px, mm, m on the ground
HILLS = simulate.texture(0.002, contrast=5.0, mean=0.0, waves=20, seed=5)
GROUND = simulate.texture(0.2, waves=100, seed=6)
STATIONS = {
    "A": (0, 0, 100, 0.01, -0.01, 0.03),
    "B": (20, 1, 101, -0.01, 0.01, -0.02),
    "C": (40, -1, 99, 0.01, -0.02, 0.01),
}
BASE_PX = {"B": 80, "C": 160}  # from the planned flight: 20 m and 40 m
CHOSEN = np.stack(np.meshgrid(np.arange(210, 290, 10), np.arange(40, 205, 15)), -1)
CHOSEN = CHOSEN.reshape(-1, 2).astype(float)
WINDOW = 21  # that of lsm.match


def sharing():
    """Sum of the squared correlations of a point with all others, and with itself.

    The errors of two points correlate by the pixels that their windows share, since
    noise is white. The mean of n squares has the variance 2 / n times this sum.
    """
    apart = np.abs(CHOSEN[:, None] - CHOSEN)
    shared = np.clip(1 - apart / WINDOW, 0, None).prod(axis=-1)
    return (shared**2).sum(axis=1).mean()


def on_relief(exterior, xy):
    """Points of the hills that a photo shows at xy, by Newton's method along rays."""
    exterior = np.asarray(exterior, dtype=float)
    u = np.insert(ideal(CAMERA, xy), 2, -CAMERA.c, axis=-1)
    ray = u @ imaging.attitude(exterior)  # M^T u, row by row
    t = (HILLS.mean - exterior[2]) / ray[..., 2]
    for _ in range(10):
        X = exterior[:3] + t[..., None] * ray
        above = X[..., 2] - simulate.grey_values(HILLS, X[..., :2] / CELL)
        slope = simulate.grey_gradients(HILLS, X[..., :2] / CELL) / CELL
        t = t - above / (ray[..., 2] - np.sum(slope * ray[..., :2], axis=-1))
    assert np.abs(above).max() < 1e-7
    np.testing.assert_allclose(camera.project(CAMERA, exterior, X), xy, atol=1e-9)
    return X


def photos():
    pixels = np.stack(np.meshgrid(*map(np.arange, SIZE)), axis=-1)
    xy = frames.pixel_to_photo(pixels, SIZE, PIXEL)
    return {
        name: simulate.grey_values(GROUND, on_relief(station, xy)[..., :2] / CELL)
        for name, station in STATIONS.items()
    }


def noisy(grey, seed):
    return {
        name: simulate.photograph(one, 8.0, [seed, i])
        for i, (name, one) in enumerate(grey.items())
    }


def walk(grey):
    """From grey values to image observations and an adjusted network."""
    matches = {}
    for name, shift in BASE_PX.items():
        coarse = ncc.match(
            grey["A"], grey[name], CHOSEN, CHOSEN - [shift, 0], search=71
        )
        assert np.all(coarse.status == "accepted")
        matches[name] = lsm.match(grey["A"], grey[name], CHOSEN, coarse.points)
    seen = observations.from_matches(CHOSEN, matches, SIZE, PIXEL, left="A")
    names, (a, b, c) = seen.common("A", "B", "C")
    model = orientation.relative(CAMERA, CAMERA, a, c, base=40.0)
    assert model.status == "converged"
    third = orientation.resect(CAMERA, b, model.points)
    assert third.status == "converged"
    stations = {"A": np.zeros(6), "B": third.exterior, "C": model.exterior}
    points = dict(zip(names, model.points))
    rows = [row for row in seen.rows if row[1] in points]
    network = bundle.Network.of(CAMERA, stations, points, rows)
    return seen, bundle.adjust(network, (), sigma0_prior=1.0)


def true_points(seen, names):
    shown, (xy,) = seen.common("A")
    place = {name: i for i, name in enumerate(shown)}
    xy = xy[[place[name] for name in names]]
    return on_relief(STATIONS["A"], xy)


@pytest.fixture(scope="module", params=[2, pytest.param(4, marks=pytest.mark.slow)])
def walks(request):
    """As many as the noises that are drawn."""
    grey = photos()
    return [walk(noisy(grey, seed)) for seed in range(request.param)]


def test_heights_above_the_true_relief_are_as_large_as_predicted(walks):
    """Measured across the relief, since a point may slip on it with its window.

    The prediction is that before the adjustment, sigma0 = 1: everything from the noise
    of the grey values on has to be right for it.
    """
    squares = []
    for seen, found in walks:
        truth = true_points(seen, found.network.point_names)
        fit = orientation.absolute(found.points, truth)
        error = fit.apply(found.points) - truth
        turn = fit.scale * fit.rotation
        C = turn @ found.covariance_points @ turn.T / found.sigma0**2
        slope = simulate.grey_gradients(HILLS, truth[:, :2] / CELL) / CELL
        across = np.column_stack([-slope, np.ones(len(slope))])
        height = np.sum(error * across, axis=1)
        variance = np.einsum("ni,nij,nj->n", across, C, across)
        assert 0.005 < np.sqrt(variance).mean() < 0.05  # m, from 100 m above
        squares.append(height**2 / variance)
    assert abs(np.mean(squares) - 1) < 4 * np.sqrt(2 * sharing() / np.size(squares))


def test_sigma0_of_the_network_is_the_one_that_matching_promised(walks):
    values = np.array([found.sigma0**2 for _, found in walks])
    redundancy = walks[0][1].redundancy
    assert redundancy == 3 * 2 * len(CHOSEN) - 3 * 6 - 3 * len(CHOSEN) + 7
    assert abs(values.mean() - 1) < 4 * np.sqrt(
        2 * sharing() / (len(walks) * redundancy)
    )


def test_stations_come_out_where_they_were(walks):
    for seen, found in walks:
        truth = true_points(seen, found.network.point_names)
        fit = orientation.absolute(found.points, truth)
        centres = fit.apply(found.exteriors[:, :3])
        expected = np.array(list(STATIONS.values()))[:, :3]
        turn = fit.scale * fit.rotation
        C = turn @ found.covariance_exteriors[:, :3, :3] @ turn.T / found.sigma0**2
        sd = np.sqrt(np.diagonal(C, axis1=1, axis2=2))
        # slipping windows move the truth along the ground: up to 5/3 of the variance
        assert np.abs((centres - expected) / sd).max() < 4 * np.sqrt(5 / 3)


def test_the_report_tells_of_the_same_network(walks):
    seen, found = walks[0]
    text = " ".join(report.text(found).split())
    assert "3 photos" in text and f"{len(found.points)} points" in text
    assert "the inverse covariances of the rays" in text
    assert set(seen.photo) == {"A", "B", "C"} and not seen.dropped


def test_a_wrong_match_is_found_by_name(walks):
    _, found = walks[0]
    network = found.network
    ray = int(np.flatnonzero((network.photo == 1) & (network.point == 40))[0])
    xy = network.xy.copy()
    xy[ray] += (0.003, -0.004)  # half a pixel
    snooping = bundle.snoop(replace(network, xy=xy), (), sigma0_prior=1.0)
    first = snooping.removed[0]
    assert (first.photo, first.point) == ("B", network.point_names[40])
