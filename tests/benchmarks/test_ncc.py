"""Times of normalized correlation beside OpenCV, in one run: `make benchmark`.

Compare the medians within a group; the tests assert that both give the same.
OpenCV works in float32: where it can be trusted, both agree to 1e-4. The times should
not depend on what the process has done before: the groups named "primed" run after a
block of some MB has been freed, after which the C library no longer gives memory back.
Only `test_match_over_the_bare_loop` looks at a time.
"""

import time

import cv2
import numpy as np
import pytest

from pgm_lab import ncc
from tests.ncc import test_stereo

SIZES = [(21, 51), (31, 51), (21, 101), (21, 201), (51, 501), (51, 1000), (201, 201)]
SIZES += [(11, 21), (21, 23)]


@pytest.fixture(autouse=True)
def one_thread():
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    yield
    cv2.setNumThreads(before)


def image(size):
    grey = np.random.default_rng(1).integers(0, 256, (size, size), dtype=np.uint8)
    return cv2.GaussianBlur(grey, (0, 0), 1.5)


def opencv(template, search):
    return cv2.matchTemplate(search, template, cv2.TM_CCOEFF_NORMED)


def windows(n, template=21, search=51):
    """n templates and search windows out of one image."""
    grey, rng = image(600), np.random.default_rng(2)
    every = np.lib.stride_tricks.sliding_window_view(grey, (search, search))
    searches = every[*rng.integers(0, 550, (2, n))].copy()
    return searches[:, 10 : 10 + template, 12 : 12 + template].copy(), searches


FIFTY = "fifty maps, 21 x 21 in 51 x 51"


@pytest.mark.benchmark(group=FIFTY)
def test_fifty_maps(benchmark):
    templates, searches = windows(50)
    r = benchmark(ncc.correlation_map, templates, searches)
    peer = [opencv(t, s) for t, s in zip(templates, searches, strict=True)]
    np.testing.assert_allclose(r, peer, atol=1e-4)


@pytest.mark.benchmark(group=f"{FIFTY}, primed")
def test_fifty_maps_primed(benchmark):
    block = np.empty((1900, 2000))
    del block
    templates, searches = windows(50)
    r = benchmark(ncc.correlation_map, templates, searches)
    assert r.shape == (50, 31, 31)


@pytest.mark.benchmark(group=FIFTY)
def test_fifty_maps_opencv(benchmark):
    templates, searches = windows(50)
    benchmark(lambda: [opencv(t, s) for t, s in zip(templates, searches, strict=True)])


@pytest.mark.parametrize(("template", "search"), SIZES)
def test_one_map(benchmark, template, search):
    benchmark.group = f"one map, {template} in {search}"
    grey = image(search)
    r = benchmark(ncc.correlation_map, grey[:template, :template], grey)
    np.testing.assert_allclose(r, opencv(grey[:template, :template], grey), atol=1e-4)


@pytest.mark.parametrize(("template", "search"), SIZES)
def test_one_map_opencv(benchmark, template, search):
    benchmark.group = f"one map, {template} in {search}"
    grey = image(search)
    benchmark(opencv, grey[:template, :template], grey)


def scene(n=2000):
    left = image(800)
    return (
        left,
        np.roll(left, (3, -5), axis=(0, 1)),
        np.random.default_rng(3).integers(40, 760, (n, 2)),
    )


MATCH = "2000 points, 21 in 51"


@pytest.mark.benchmark(group=MATCH)
def test_match(benchmark):
    left, right, points = scene()
    found = benchmark(ncc.match, left, right, points)
    assert set(found.status) == {"accepted"}
    np.testing.assert_array_equal(found.points, points + [-5, 3])


def bare_loop(left, right, points):
    """Highest value and its place; no second peak, no covariance."""
    found = np.empty(points.shape)
    for i, (x, y) in enumerate(points):
        template = left[y - 10 : y + 11, x - 10 : x + 11]
        r = opencv(template, right[y - 25 : y + 26, x - 25 : x + 26])
        column, row = cv2.minMaxLoc(r)[3]
        found[i] = x + column - 15, y + row - 15
    return found


@pytest.mark.benchmark(group=MATCH)
def test_match_opencv(benchmark):
    left, right, points = scene()
    found = benchmark(bare_loop, left, right, points)
    np.testing.assert_array_equal(found, points + [-5, 3])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_match_over_the_bare_loop(dtype):
    """Processor times in turn, which other programs disturb less; run with -s."""
    left, right, points = scene()
    left, right = left.astype(dtype), right.astype(dtype)
    peer = left.astype(np.float32), right.astype(np.float32)  # OpenCV takes no 16 bit
    peer = (left, right) if dtype == np.uint8 else peer
    times = np.empty((2, 15))
    for i in range(15):
        for row, match, images in (
            (times[0], ncc.match, (left, right)),
            (times[1], bare_loop, peer),
        ):
            start = time.process_time()
            found = match(*images, points)
            row[i] = time.process_time() - start
            np.testing.assert_array_equal(
                np.rint(getattr(found, "points", found)), points + [-5, 3]
            )
    ratio = times[0].min() / times[1].min()
    print(f"\n{np.dtype(dtype).name}: {ratio:.2f} times the bare loop")


ROWS = "4000 points along rows, parallaxes up to 80 px"


@pytest.mark.benchmark(group=ROWS)
def test_match_along_rows(benchmark):
    """Not for its time: of a few points. StereoBM computes all pixels of the image."""
    left, right, points, truth = test_stereo.stereo(4000)
    found = benchmark.pedantic(test_stereo.along_rows, (left, right, points), rounds=2)
    parallax = points[:, 0] - found.points[:, 0]
    assert test_stereo.shares(parallax, found.accepted, truth)[0] > 0.68


@pytest.mark.benchmark(group=ROWS)
def test_match_along_rows_opencv(benchmark):
    left, right, points, truth = test_stereo.stereo(4000)
    peer = cv2.StereoBM_create(test_stereo.LARGEST, 11)
    disparity = benchmark.pedantic(peer.compute, (left, right), rounds=2)
    column, row = points.astype(int).T
    parallax = disparity[row, column] / 16
    assert test_stereo.shares(parallax, parallax > 0, truth)[0] < 0.75
