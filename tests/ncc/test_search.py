"""What `ncc.match` searches: rectangles, lines, up to the edge, past missing pixels."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pgm_lab import ncc, simulate

HALF = 4  # of templates of 9


@pytest.fixture(scope="module")
def noise():
    """A left image of white noise, and the right one shifted by (-5, 3)."""
    left = np.random.default_rng(6).integers(0, 256, (90, 100)).astype(np.uint8)
    return left, np.roll(left, (3, -5), axis=(0, 1))


def correlations(left, right, point, columns, rows):
    """r by definition of the template of 9 with each position; -2 where it leaves."""
    x, y = point
    template = left[y - HALF : y + HALF + 1, x - HALF : x + HALF + 1]
    r = np.full((len(rows), len(columns)), -2.0)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            if HALF <= row < right.shape[0] - HALF:
                if HALF <= column < right.shape[1] - HALF:
                    window = right[
                        row - HALF : row + HALF + 1, column - HALF : column + HALF + 1
                    ]
                    r[i, j] = ncc.correlation(template, window)
    return r


# -- rectangles


@given(seed=st.integers(0, 10**6), refine=st.sampled_from([None, "parabola"]))
@settings(max_examples=20, deadline=None)
def test_of_transposed_images_the_matches_are_transposed(seed, refine):
    rng = np.random.default_rng(seed)
    left = cv2.GaussianBlur(rng.integers(0, 256, (60, 70)).astype(float), (0, 0), 1)
    right = left + rng.normal(0, 20, left.shape)
    points = rng.uniform(0, 70, (20, 2))
    lines = np.column_stack([rng.normal(size=(20, 2)), np.zeros(20)])
    lines[:, 2] = -np.sum(lines[:, :2] * points, axis=1) + rng.normal(size=20)
    for given_lines in (None, lines):
        there = ncc.match(
            *(left, right, points, points, 9, (15, 25)),
            **{"refine": refine, "lines": given_lines, "back": 1.0},
        )
        if given_lines is not None:
            given_lines = lines[:, [1, 0, 2]]
        turned = ncc.match(
            *(left.T, right.T, points[:, ::-1], points[:, ::-1], 9, (25, 15)),
            **{"refine": refine, "lines": given_lines, "back": 1.0},
        )
        np.testing.assert_array_equal(there.status, turned.status)
        np.testing.assert_allclose(there.points, turned.points[:, ::-1], atol=1e-6)
        np.testing.assert_allclose(
            there.covariance, turned.covariance[:, ::-1, ::-1], atol=1e-6
        )


# -- lines


def test_along_a_line_it_is_the_highest_of_what_lies_near(noise):
    left, right = noise
    right = right + np.random.default_rng(1).normal(0, 60, right.shape)
    rng = np.random.default_rng(3)
    points = rng.integers(25, 65, (30, 2))
    a, b = rng.normal(size=(2, 30))
    c = -a * points[:, 0] - b * points[:, 1] + 0.7 * np.hypot(a, b)
    found = ncc.match(
        *(left, right, points, None, 9, (21, 29), -1, 1),
        **{"lines": np.column_stack([a, b, c]), "distance": 1.2},
    )
    away = np.abs(a * found.points[:, 0] + b * found.points[:, 1] + c)
    assert np.all(away <= 1.2 * np.hypot(a, b) + 1e-9)
    for k, (x, y) in enumerate(points):
        length = np.hypot(a[k], b[k])
        off = (a[k] * x + b[k] * y + c[k]) / length
        middle = np.floor(
            (x - off * a[k] / length, y - off * b[k] / length) + np.array(0.5)
        )
        columns = (middle[0] + np.arange(-10, 11)).astype(int)
        rows = (middle[1] + np.arange(-6, 7)).astype(int)
        r = correlations(left, right, (x, y), columns, rows)
        near = np.abs(a[k] * columns + b[k] * rows[:, None] + c[k]) <= 1.2 * length
        r[~near] = -2
        i, j = np.unravel_index(r.argmax(), r.shape)
        np.testing.assert_array_equal(found.points[k], (columns[j], rows[i]))
        assert found.r[k] == pytest.approx(r.max(), abs=1e-12)


def rows_of(points, off=0.0):
    return np.column_stack([0 * points[:, 1], 0 * points[:, 1] + 1, off - points[:, 1]])


@pytest.fixture(scope="module")
def shifted():
    """Soft texture, shifted by 4.3 columns and 0.4 rows; points; and where they are."""
    pair = simulate.texture_pair(
        simulate.texture(0.2, seed=4), (120, 140), (4.3, 1, 0, 0.4, 0, 1), sigma=1.0
    )
    y, x = np.mgrid[30:90:10, 30:100:10].reshape(2, -1)
    points = np.column_stack([x, y]).astype(float)
    return *pair, points, points + (4.3, 0.4)


@pytest.mark.parametrize("off", [-1.0, 0.0, 0.4])
def test_a_peak_at_the_edge_of_the_band_is_no_peak_on_the_border(shifted, off):
    """With three rows to search, and all around them known."""
    left, right, points, truth = shifted
    found = ncc.match(
        *(left, right, points, points, 15, (17, 31)),
        **{"refine": "parabola", "lines": rows_of(points, off), "distance": 1.4},
    )
    assert set(found.status) == {"accepted"}
    np.testing.assert_allclose(found.points, truth, atol=0.15)
    # Without the line the same rows are at the border, and half of the points are lost
    rows = ncc.match(left, right, points + [0, 0], points + [0, 1], 15, (17, 31))
    assert np.mean(rows.accepted) < 0.6


def test_a_peak_at_the_end_of_the_line_is_on_the_border_of_the_search(shifted):
    left, right, points, _ = shifted
    lines = rows_of(points)
    for columns, status in ((23, "peak on the border of the search"), (25, "accepted")):
        found = ncc.match(
            *(left, right, points, None, 15, (17, columns)), **{"lines": lines}
        )
        assert set(found.status) == {status}
    # A line that leaves the search window by its long side ends there too
    slope = np.column_stack(
        [np.full(len(points), 0.9), np.ones(len(points)), -points @ (0.9, 1)]
    )
    moved = cv2.warpAffine(
        left, np.array([[1, 0, 4.0], [0, 1, -4.0]]), left.shape[::-1]
    )
    for rows, status in ((23, "peak on the border of the search"), (25, "accepted")):
        found = ncc.match(
            *(left, moved, points, None, 15, (rows, 41)), **{"lines": slope}
        )
        assert set(found.status) == {status}


def test_the_search_goes_to_the_place_on_the_line_nearest_to_the_start(shifted):
    left, right, points, truth = shifted
    start = truth + [0, 25]
    found = ncc.match(
        *(left, right, points, start, 15, (17, 31)), **{"lines": rows_of(points)}
    )
    assert set(found.status) == {"accepted"}


def test_the_fraction_of_a_point_counts_from_the_line(shifted):
    """The point lies 0.4 rows below the middle of its template, and its line too."""
    left, right, points, truth = shifted
    found = ncc.match(
        *(left, right, points + [0.3, 0.4], points, 15, (17, 31)),
        **{"refine": "parabola", "lines": rows_of(truth + [0.3, 0.4]), "distance": 0.5},
    )
    assert set(found.status) == {"accepted"}
    np.testing.assert_allclose(found.points, truth + [0.3, 0.4], atol=0.15)


def test_a_fraction_of_a_point_stays_on_its_line():
    rng = np.random.default_rng(5)
    steps = cv2.GaussianBlur(rng.normal(0, 60, (1, 100)), (1, 7), 0) + 128
    left = np.tile(steps, (90, 1))
    right = np.roll(left, -5, axis=1)
    points = np.column_stack([np.arange(30.0, 60, 3), np.full(10, 40.4)])
    found = ncc.match(
        *(left, right, points, points - (5, 0), 9, (11, 31), -1, 1, "parabola"),
        **{"lines": np.tile([0.0, 1.0, -40.4], (10, 1)), "distance": 0.5},
    )
    # All edges run down: where a match lies along them, the line alone says
    np.testing.assert_allclose(found.points[:, 1], 40.4, rtol=0, atol=1e-6)


def test_where_an_edge_crosses_the_line_the_match_is_there_and_its_covariance_says_so():
    """Aslant edges: alone they tell nothing along themselves. The error of the line,
    uniform up to `distance`, goes into the covariance along the edge."""
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:60, :400].astype(float)
    shift, slant = 2.3, 0.5
    errors, predicted = [], []
    for _ in range(6):
        left, right = (
            100 * np.sin((x - at - slant * (y - 30)) / 5) + rng.normal(0, 2, x.shape)
            for at in (0.0, shift)
        )
        points = np.column_stack([np.arange(40, 360, 16.0), np.full(20, 30.0)])
        truth = points + [shift, 0]
        off = rng.uniform(-0.5, 0.5, len(points))
        alone = ncc.match(left, right, points, None, 15, (17, 25), ratio=1)
        assert "accepted" not in alone.status
        found = ncc.match(
            *(left, right, points, None, 15, (17, 25), 0.7, 1, "parabola"),
            **{"lines": rows_of(truth, off), "distance": 0.5, "back": 1.0},
        )
        # By chance noise makes a peak of the ridge, or another at its next place
        on = found.accepted & np.isclose(found.points[:, 1], 30 - off)
        assert found.accepted.mean() > 0.9 and on.mean() > 0.7
        errors.append((found.points - truth)[on])
        predicted.append(found.covariance[on])
    errors, predicted = np.concatenate(errors), np.concatenate(predicted)
    scatter = np.mean(errors[:, :, None] * errors[:, None, :], axis=0)
    np.testing.assert_allclose(scatter, predicted.mean(axis=0), rtol=0.2)


# -- the way back


def test_the_way_back_is_a_match_from_the_right(noise):
    left, right = (g.astype(float) for g in noise)
    rng = np.random.default_rng(4)
    right[:, 50:] = cv2.GaussianBlur(rng.normal(128, 300, (90, 50)), (0, 0), 1)
    left, right = (cv2.GaussianBlur(g, (0, 0), 1.5) for g in (left, right))
    points = rng.uniform(20, 75, (80, 2))
    options = {"template": 9, "search": (31, 35), "threshold": 0.3, "ratio": 1}
    there = ncc.match(left, right, points, refine="parabola", **options)
    both = ncc.match(left, right, points, refine="parabola", back=1.0, **options)
    k = np.flatnonzero(there.accepted)
    home = ncc.match(
        *(right, left, there.points[k], points[k], 9, (31, 35), -1, 1, "parabola")
    )
    lost = np.hypot(*(home.points - points[k]).T) > 1
    assert 5 < lost.sum() < len(k) - 5
    expected = there.status.copy()
    expected[k[lost]] = "left-right check failed"
    np.testing.assert_array_equal(both.status, expected)
    assert np.all(np.isnan(both.covariance[~both.accepted]))
    np.testing.assert_array_equal(both.points, there.points)


def test_the_way_back_follows_the_line_of_the_left_image():
    left = np.random.default_rng(8).integers(0, 256, (90, 100)).astype(np.uint8)
    right = np.roll(left, (6, -5), axis=(0, 1))
    points = np.random.default_rng(9).uniform(30, 60, (20, 2)).round()
    # Six rows lower in the right image than in the left one
    lines = np.column_stack([np.zeros(20), np.ones(20), -(points[:, 1] + 6)])
    found = ncc.match(
        *(left, right, points, points + (0, 6), 9, (11, 31)),
        **{"lines": lines, "distance": 0.5, "back": 1},
    )
    assert found.accepted.all()
    np.testing.assert_array_equal(found.points, points + (-5, 6))


# -- the edge of the image


@pytest.mark.parametrize("shift", [(c, r) for c in (-1, 0, 1) for r in (-1, 0, 1)])
@pytest.mark.parametrize(
    "dtype", [np.uint8, pytest.param(float, marks=pytest.mark.slow)]
)
def test_none_is_lost_whose_match_lies_in_the_image(shift, dtype):
    """Points all over the left image, matches up to each edge and corner."""
    grey = np.random.default_rng(5).integers(0, 256, (110, 120)).astype(dtype)
    column, row = 8 * np.array(shift)
    left = grey[20:80, 20:90]
    right = grey[20 - row : 80 - row, 20 - column : 90 - column]
    y, x = np.mgrid[10:50, 10:60].reshape(2, -1)
    points = np.column_stack([x, y])
    found = ncc.match(left, right, points, None, 15, 35)
    truth = points + (column, row)
    room = np.minimum(truth, (69, 59) - truth).min(axis=1)  # px to the nearest edge
    np.testing.assert_array_equal(found.accepted, room > 7)
    np.testing.assert_array_equal(found.points[room >= 7], truth[room >= 7])
    touches = found.status == "peak on the edge of the image"
    assert np.all(touches[room == 7])
    # Where the match lies beyond, the highest of the rest is somewhere
    beyond = np.setdiff1d(found.status[room < 7], found.status[touches])
    assert set(beyond) <= {
        "below threshold",
        "ambiguous",
        "peak on the border of the search",
    }
    place = found.points[touches & (room < 7)]
    assert np.all(np.minimum(place, (69, 59) - place).min(axis=1) == 7)


# -- pixels without data


def holes(image, kind, where):
    """The image without data in some pixels."""
    if kind == "masked":
        mask = np.zeros(image.shape, bool)
        mask[where] = True
        hidden = image.copy()
        hidden[where] = np.random.default_rng(1).integers(0, 256, hidden[where].shape)
        return np.ma.array(hidden, mask=mask)
    image = image.astype(np.float32 if kind == "single" else float)
    image[where] = np.inf if kind == "infinite" else np.nan
    return image


KINDS = ["masked", "NaN", "infinite", "single"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("lines", [False, True])
def test_what_touches_no_data_is_named_and_the_rest_is_as_without(noise, kind, lines):
    left, right = noise
    y, x = np.mgrid[15:75:2, 20:80:3].reshape(2, -1)
    points = np.column_stack([x, y]).astype(float)
    options = {"template": 9, "search": (25, 27), "refine": "parabola"}
    if lines:
        options |= {"lines": rows_of(points + [0, 3])}
    gap = np.s_[40:42, 30:34]  # rows 40 and 41, columns 30 to 33
    whole = ncc.match(left, right, points, **options)
    found = ncc.match(
        holes(left, kind, gap), holes(right, kind, gap), points, **options
    )

    def apart(place):
        outside = np.maximum((30, 40) - place, place - (33, 41)).max(axis=1)
        return outside > HALF, outside == HALF + 1

    free, touches = apart(points)
    assert set(found.status[~free]) == {"no data in the template"}
    assert np.all(np.isnan(found.points[~free])) and np.all(np.isnan(found.r[~free]))
    match_free, beside = apart(points + [-5, 3])
    good = free & match_free & ~beside
    assert np.all(whole.accepted)
    assert np.all(found.accepted[good])
    # What the parabola errs by itself rests on one pixel more on each side
    same = {"points": good, "r": good, "covariance": good & ~touches}
    for name, some in same.items():
        ours, theirs = getattr(found, name)[some], getattr(whole, name)[some]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)
    assert np.any(free & beside)
    assert set(found.status[free & beside]) == {"peak on the edge of the image"}
    lost = found.status[free & ~match_free]
    assert len(lost) and "accepted" not in lost


def test_no_data_beside_the_template_changes_its_precision_little(noise):
    """The row beyond it, which tells of the parabola's own error, is missing."""
    left, right = (cv2.GaussianBlur(g.astype(float), (0, 0), 1.5) for g in noise)
    options = {"template": 9, "search": 25, "refine": "parabola"}
    whole = ncc.match(left, right, [(40, 40)], **options)
    left[35, :] = np.nan
    found = ncc.match(left, right, [(40, 40)], **options)
    np.testing.assert_array_equal(found.points, whole.points)
    assert found.accepted[0]
    assert 0.3 < np.trace(found.covariance[0]) / np.trace(whole.covariance[0]) < 3


def test_a_twin_without_data_is_no_second_peak():
    left = np.random.default_rng(6).integers(0, 256, (60, 100)).astype(float)
    right = left.copy()
    right[20:40, 60:80] = left[20:40, 20:40]
    options = {"template": 9, "search": (13, 91), "ratio": 0.8}
    twins = ncc.match(left, right, [(30, 30)], [(50, 30)], **options)
    assert twins.status[0] == "ambiguous"
    right[30, 70] = np.nan
    found = ncc.match(left, right, [(30, 30)], [(50, 30)], **options)
    assert found.accepted[0] and found.second[0] < 0.6


@pytest.mark.parametrize("kind", KINDS)
def test_no_data_in_all_that_is_searched(noise, kind):
    left, right = noise
    gap = np.s_[20:60:8, 20:60:8]
    found = ncc.match(left, holes(right, kind, gap), [(40, 40)], None, 9, 15)
    assert found.status[0] == "no data in the window"
    nothing = holes(right, kind, np.s_[:, :])
    found = ncc.match(left, nothing, [(40, 40), (2, 2)], None, 9, 15)
    assert list(found.status) == ["no data in the window", "template leaves the image"]
    found = ncc.match(nothing, left, [(40, 40)], None, 9, 15)
    assert found.status[0] == "no data in the template" and np.isnan(found.r[0])


@pytest.mark.parametrize(
    "dtype", [bool, np.int16, np.uint64, np.float16, np.longdouble]
)
def test_no_data_in_images_of_all_types(noise, dtype):
    grey = noise[0] > 128 if dtype is bool else noise[0].astype(dtype)
    masked = np.ma.array(grey, mask=np.zeros(grey.shape, bool))
    masked[30:33, 30:33] = np.ma.masked
    found = ncc.match(masked, masked, [(50, 50), (31, 31), (38, 38)], None, 9, 25)
    assert list(found.status) == ["accepted", "no data in the template", "accepted"]
    np.testing.assert_array_equal(found.points[[0, 2]], [(50, 50), (38, 38)])
    assert found.r[2] == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_memory_is_that_of_the_points(dtype):
    import tracemalloc

    image = np.zeros((3000, 3000), dtype)
    image[1000:1100, 1000:1100] = np.random.default_rng(1).integers(0, 256, (100, 100))
    masked = np.ma.array(image, mask=np.zeros(image.shape, bool))
    # Work memory, which a thread keeps from its first call on, is not of the image
    ncc.match(image[1000:1100, 1000:1100], image[1000:1100, 1000:1100], [(50, 50)] * 50)
    for one in (image, masked):
        tracemalloc.start()
        found = ncc.match(one, one, [(1050, 1050)] * 50)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert found.accepted.all()
        assert peak < image.nbytes / 2


# -- what is flat, what leaves


def test_a_match_without_contrast_is_none(noise):
    """Of nine positions eight are saturated, r = 0, and one is the contrary."""
    left, right = noise[0].copy(), np.full((90, 100), 255, np.uint8)
    left[36, 36] = 255
    right[35, 35] = 0
    found = ncc.match(left, right, [(40, 40)], None, 9, 11, -1, 1)
    assert found.r[0] == 0 and found.status[0] == "flat window"
    assert np.all(np.isfinite(found.points)) and np.all(np.isnan(found.covariance))


def test_a_line_beyond_the_image_leaves_nothing_to_search(noise):
    found = ncc.match(*noise, [(40, 40)], None, 9, 21, lines=[(0, 1, 6)])
    assert list(found.status) == ["window leaves the image"]
    found = ncc.match(*noise, [(40, 40)], None, 9, 21, lines=[(0, 1, -2)])
    assert list(found.status) == ["window leaves the image"]  # rows 0.5 to 3.5
    assert np.all(np.isnan(found.points))
