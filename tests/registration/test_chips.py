"""Chips found by Pearson, against other programs; what fails; the table."""

import csv
import io

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import pearsonr

from pgm_lab import datasets, matching, simulate
from pgm_lab.registration import accuracy, register

LANDSAT = datasets.landsat().grey
SCENE = LANDSAT[300:500, 200:420]
POINTS = np.array([(x, y) for x in range(30, 191, 32) for y in range(30, 171, 28)])
TEXTURE = simulate.texture(0.3, contrast=30.0, seed=5)


def moved(image, dx, dy):
    """The image with all that it shows (dx, dy) farther right and down."""
    return np.roll(image, (dy, dx), axis=(0, 1))


def noisy(image, sigma=40.0, seed=0, gain=0.9):
    noise = np.random.default_rng(seed).normal(0, sigma, image.shape)
    return gain * image + 300 + noise


def shifts(found):
    return np.stack([found.dx, found.dy], axis=1)


# --- The peak ---


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32, float])
def test_shifts_and_r_are_those_of_two_other_programs(kind):
    scale = 100 if kind == np.uint8 else 1
    reference = ((SCENE - SCENE.min()) / scale).astype(kind)
    sensed = noisy(moved(reference * 1.0, -2, 1), 400 / scale)
    sensed = sensed.clip(0, 255 * 257 / scale).astype(kind)
    found = register(reference, sensed, POINTS, threshold=-1)
    for i, (x, y) in enumerate(POINTS):
        window = sensed[y - 13 : y + 14, x - 13 : x + 14]
        chip = reference[y - 10 : y + 11, x - 10 : x + 11]
        both = window.astype(np.float32), chip.astype(np.float32)
        r = cv2.matchTemplate(*both, cv2.TM_CCOEFF_NORMED)
        column, row = cv2.minMaxLoc(r)[3]
        assert (found.dx[i], found.dy[i]) == (column - 3, row - 3)
        there = window[row : row + 21, column : column + 21]
        r = pearsonr(chip.ravel().astype(float), there.ravel().astype(float))[0]
        assert abs(found.r[i] - r) < 1e-12
    assert found.accepted.sum() > 20


@settings(max_examples=20)
@given(st.integers(-2, 2), st.integers(-2, 2), st.integers(-3, 3), st.integers(-3, 3))
def test_an_image_that_is_moved_has_its_shifts_moved(dx, dy, p, q):
    """By whole pixels; the points too, so that none of them nears an edge."""
    sensed = noisy(SCENE)
    before = register(SCENE, sensed, POINTS, radius=3)
    after = register(SCENE, moved(sensed, dx, dy), POINTS, radius=3)
    both = before.accepted & after.accepted
    assert both.sum() > 20
    np.testing.assert_array_equal(shifts(after)[both], shifts(before)[both] + (dx, dy))
    # And of the whole pair nothing is changed
    together = register(moved(SCENE, p, q), moved(sensed, p, q), POINTS + (p, q))
    np.testing.assert_array_equal(shifts(together), shifts(before))
    np.testing.assert_allclose(together.r, before.r, atol=1e-12)


@pytest.mark.parametrize(
    ("refine", "limit", "back"),
    [(None, 0.5, 0), ("parabola", 0.12, 0.2), ("lsm", 0.01, 0.01)],
)
def test_parts_of_a_pixel_and_images_exchanged(refine, limit, back):
    """The sign turns; points between the pixels have the shift of the nearest."""
    pair = simulate.texture_pair(TEXTURE, (200, 220), (1.4, 1, 0, -0.7, 0, 1))
    found = register(*pair, POINTS, refine=refine)
    assert found.accepted.all()
    assert np.abs(shifts(found) - (1.4, -0.7)).max() <= limit
    sensed = noisy(moved(SCENE, 2, -1))
    one = register(SCENE, sensed, POINTS, refine=refine)
    other = register(sensed, SCENE, POINTS + (2, -1), refine=refine)
    both = one.accepted & other.accepted
    assert both.sum() > 20
    np.testing.assert_allclose(shifts(other)[both], -shifts(one)[both], atol=back)
    sensed = moved(SCENE, 2, -1)
    between = register(SCENE, sensed, POINTS + (0.3, -0.4), refine=refine)
    whole = register(SCENE, sensed, POINTS, refine=refine)
    np.testing.assert_allclose(shifts(between), shifts(whole), atol=0.005)
    np.testing.assert_array_equal(between.points, POINTS + (0.3, -0.4))


@pytest.mark.parametrize("refine", [None, "lsm"])
def test_an_offset_is_not_part_of_the_shift(refine):
    """A sensed image that begins 17 columns and 9 rows farther, and is smaller."""
    sensed = moved(SCENE, 2, -1)
    whole = register(SCENE, sensed, POINTS, refine=refine)
    part = register(SCENE, sensed[9:, 17:190], POINTS, refine=refine, offset=(-17, -9))
    inside = part.accepted
    assert 15 < inside.sum() < len(POINTS)
    np.testing.assert_allclose(shifts(part)[inside], shifts(whole)[inside], atol=1e-3)
    assert set(part.status[~inside]) <= {
        "peak on the edge of the image",
        "window leaves the image",
        *(set(whole.status) - {"accepted"}),
    }
    # Of half a pixel as well
    half = register(SCENE, sensed, POINTS, refine=refine, offset=(0.5, 0.25))
    known = whole.accepted & half.accepted
    expected = shifts(whole)[known] - (0.5, 0.25)
    np.testing.assert_allclose(shifts(half)[known], expected, atol=1e-3)


# --- Statuses ---


@pytest.mark.parametrize("refine", [None, "parabola", "lsm"])
def test_no_data_is_told_in_two_ways(refine):
    sensed = moved(SCENE, 1, 1).astype(float)
    hole = np.zeros(SCENE.shape, bool)
    hole[60:90, 60:100] = True
    masked, nan = (np.ma.array(one, mask=hole) for one in (sensed, SCENE * 1.0))
    by_mask = register(SCENE, masked, POINTS, refine=refine)
    found = register(SCENE, masked.filled(np.nan), POINTS, refine=refine)
    np.testing.assert_array_equal(found.status, by_mask.status)
    np.testing.assert_array_equal(found.dx, by_mask.dx)
    lost = set(found.status)
    assert "no data in the window" in lost or "peak on the edge of the image" in lost
    found = register(nan.filled(np.nan), sensed, POINTS, refine=refine)
    touching = [hole[y - 10 : y + 11, x - 10 : x + 11].any() for x, y in POINTS]
    np.testing.assert_array_equal(found.status == "no data in the template", touching)


def test_a_shift_as_large_as_the_radius_is_reported_but_not_accepted():
    found = register(SCENE, moved(SCENE, 3, 0), POINTS)
    assert set(found.status) == {"peak on the border of the search"}
    assert np.all(shifts(found) == (3, 0)) and np.all(found.r > 0.999)
    wider = register(SCENE, moved(SCENE, 3, 0), POINTS, radius=4)
    assert wider.accepted.sum() > 30 and np.all(shifts(wider)[wider.accepted] == (3, 0))


def test_the_statuses_of_single_chips():
    reference = SCENE.astype(float)
    reference[50:85, 50:85] = 7000  # flat
    y, x = np.indices(SCENE.shape)
    rows = 7000 + 900 * np.sin(np.pi / 2 * y + 0.5) + 300 * np.sin(x / 2)
    rows += 0.05 * (SCENE - SCENE.mean())
    reference[120:160, 60:110] = rows[120:160, 60:110]
    expected = {
        (5, 50): "template leaves the image",
        (500, 20): "template leaves the image",
        (67, 67): "flat template",
        (85, 140): "ambiguous",
        (180, 100): "accepted",
        (12, 100): "accepted",
    }
    found = register(reference, moved(reference, 0, 1), list(expected))
    assert list(found.status) == list(expected.values())
    assert np.array_equal(np.isnan(found.dx), [True, True, True, False, False, False])
    assert set(found.status) <= set(matching.STATUSES)


def test_what_is_predicted_to_be_uncertain_is_not_accepted():
    """Weak texture under noise: r would let it pass, its precision does not."""
    weak = simulate.texture(0.08, contrast=10.0, waves=8, seed=5)
    pair = simulate.texture_pair(
        weak, (200, 220), (0.5, 1, 0, 0.25, 0, 1), sigma=1.0, seed=1
    )
    free = register(*pair, POINTS, refine="lsm", largest_sd=10.0)
    limit = np.nanmedian(free.sd)
    tight = register(*pair, POINTS, refine="lsm", largest_sd=limit)
    too_much = free.sd > limit
    assert 3 < too_much.sum() and 3 < tight.accepted.sum()
    assert np.all(tight.status[too_much & free.accepted] == "not precise enough")
    np.testing.assert_array_equal(tight.accepted, free.accepted & ~too_much)
    assert np.isnan(tight.covariance[too_much]).all()
    error = np.hypot(*(shifts(free) - (0.5, 0.25)).T)
    assert error[too_much].mean() > error[tight.accepted].mean()


def test_least_squares_matching_keeps_near_the_peak_or_fails():
    """Whatever it does, the shift stays within a pixel of the highest whole one."""
    sensed = noisy(moved(SCENE, 1, 0), 900.0)
    whole = register(SCENE, sensed, POINTS, threshold=0.2)
    fine = register(SCENE, sensed, POINTS, refine="lsm", threshold=0.2, largest_sd=10.0)
    assert np.abs(shifts(fine) - shifts(whole)).max() <= 1
    failed = whole.accepted & ~fine.accepted
    np.testing.assert_array_equal(shifts(fine)[failed], shifts(whole)[failed])


def test_no_points_give_no_shifts():
    found = register(SCENE, SCENE, np.zeros((0, 2)), refine="lsm")
    assert found.dx.shape == (0,) and found.covariance.shape == (0, 2, 2)
    with pytest.raises(ValueError, match="there are no chips.*Give points"):
        found.rmse_t  # noqa: B018


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensed": SCENE[:-1]}, "Cut both to the area.*offset="),
        ({"chip": 20}, "chip must be an odd number of pixels"),
        ({"largest_sd": 0}, "largest_sd must be positive"),
        ({"smooth": 9}, "smooth must be 0, or from 0.3 to 3 px"),
    ],
)
def test_bad_arguments_are_told_with_what_to_do(changes, message):
    good = {"reference": SCENE, "sensed": SCENE, "points": POINTS}
    with pytest.raises(ValueError, match=message):
        register(**good | changes)


# --- Changed ground: named so, and no other ---

SIDE = 31  # px, of a field that is replaced: a chip with the radius, and two to spare


def fields(factor, seed, share=0.3, shift=(1, 2), blur=0.0, sigma=15.0):
    """A pair, points on a grid, and which of them stand on replaced ground.

    What stands there instead is ground from elsewhere in the same image.
    """
    pair = simulate.ortho_pair(
        LANDSAT, shift, factor, blur=blur, gain=0.9, offset=300, sigma=sigma, seed=seed
    )
    rows, columns = pair.sensed.shape
    x, y = np.meshgrid(np.arange(20, columns - 20, 34), np.arange(20, rows - 20, 34))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    random = np.random.default_rng(seed)
    changed = random.random(len(points)) < share
    elsewhere = moved(pair.sensed, columns // 3, rows // 2)
    sensed, half = pair.sensed.copy(), SIDE // 2
    for x, y in points[changed]:
        part = np.s_[y - half : y + half + 1, x - half : x + half + 1]
        sensed[part] = elsewhere[part]
    return pair.reference, sensed, points, changed


SIZES = [
    (2, 0.6),
    *(pytest.param(*one, marks=pytest.mark.slow) for one in [(3, 0.7), (4, 0.8)]),
]


@pytest.mark.parametrize("refine", [None, pytest.param("lsm", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("factor", "least"), SIZES)
def test_most_changed_chips_are_named_and_hardly_any_other(refine, factor, least):
    """Those that are not lie where one of the two grounds has too little texture.

    Measured with two seeds: see the assertions; nothing replaced is ever accepted.
    """
    named, wrongly, accepted = [], [], []
    for seed in (1, 2):
        reference, sensed, points, changed = fields(factor, seed)
        found = register(reference, sensed, points, refine=refine)
        named.append((found.status == "changed")[changed])
        wrongly.append((found.status == "changed")[~changed])
        accepted.append(found.accepted[changed])
    assert np.mean(np.concatenate(named)) >= least
    assert np.mean(np.concatenate(wrongly)) <= 0.01
    assert not np.any(np.concatenate(accepted))


@pytest.mark.parametrize("sigma", [15.0, 400.0])
def test_noise_is_no_change(sigma):
    """Weak texture sinks in it, and is then below the threshold."""
    found = register(*fields(3, 3, share=0.0, sigma=sigma)[:3])
    assert 0 < found.accepted.sum()
    assert np.mean(found.status == "changed") <= 0.01


def test_a_flat_cloud_cannot_be_told_from_weak_texture():
    """By its definition: textured in both images."""
    reference, sensed, points, _ = fields(4, 1, share=0.0)
    sensed[100:200, 100:200] = 9000
    found = register(reference, sensed, points)
    under = np.all((points > 116) & (points < 184), axis=1)
    assert under.sum() >= 2
    assert set(found.status[under]) == {"flat window"}


def test_without_a_measure_of_what_is_usual_nothing_is_called_changed():
    """Nothing is accepted; neighbours reach r = 1, where a rounding error is none."""
    found = register(LANDSAT[:400, :400], LANDSAT[600:1000, 600:1000], [(50, 60)] * 9)
    assert "changed" not in found.status
    sensed = moved(LANDSAT.astype(float), 1, 1)
    found = register(LANDSAT, 1.1 * sensed + 0.3, fields(3, 1)[2])
    assert "changed" not in found.status and np.all(found.r > 0.999)


def test_what_moved_farther_than_the_radius_is_named_too():
    """As all that is matched by nothing within it; the docstring says so."""
    reference, sensed, points, _ = fields(4, 1, share=0.0, blur=0.7)
    far, half = sensed.copy(), 20
    one = int(np.argmin(np.abs(points - 150).sum(axis=1)))
    x, y = points[one]
    part = np.s_[y - half : y + half, x - half : x + half]
    far[part] = moved(sensed, 9, 0)[part]
    assert register(reference, sensed, points).status[one] == "accepted"
    assert register(reference, far, points).status[one] == "changed"


# --- Sums and the table ---

HERE, ELSEWHERE = LANDSAT[:400, :400], LANDSAT[600:1000, 700:1100]
GRID = np.array([(x, y) for x in range(20, 381, 40) for y in range(20, 381, 40)])


@pytest.fixture(scope="module")
def result():
    return register(HERE, moved(HERE, -2, 1), [(3, 9), *GRID])


def test_the_sums_are_those_of_the_accepted_shifts(result):
    assert 50 < result.accepted.sum() < len(result.points)
    dx, dy = result.dx[result.accepted], result.dy[result.accepted]
    assert result.accuracy == accuracy(dx, dy) and result.accuracy.n == len(dx)
    for name in ("rmse_t", "ce90"):
        assert getattr(result, name) == getattr(result.accuracy, name)
    C = result.covariance
    np.testing.assert_allclose(result.sd**2, (C[:, 0, 0] + C[:, 1, 1]) / 2)


@pytest.mark.parametrize(("refine", "radius"), [(None, 10), ("lsm", 3)])
def test_of_two_different_places_nothing_is_accepted(refine, radius):
    one = register(HERE, ELSEWHERE, GRID, radius=radius, refine=refine)
    assert not one.accepted.any()
    for name in ("accuracy", "rmse_t", "ce90"):
        with pytest.raises(ValueError, match="transformation is undetermined") as error:
            getattr(one, name)
        words = str(error.value)
        for status in set(one.status):
            assert f"{np.sum(one.status == status)} {status}" in words


def test_the_table_is_read_again_as_it_was(tmp_path, result):
    path = tmp_path / "new" / "shifts.csv"
    result.save(path)
    with pytest.raises(FileExistsError):
        result.save(path)
    text = path.read_text(encoding="utf-8")
    assert text == result.csv()
    head, *rows = csv.reader(io.StringIO(text))
    assert all(len(row) == len(head) for row in rows)
    assert head[3] == "shift of the column (px; sensed minus reference)"
    numbers = np.array([[float(v) if v else np.nan for v in row[:-1]] for row in rows])
    columns = result.dx, result.dy, result.r, result.second
    entries = result.covariance[:, [0, 0, 1], [0, 1, 1]]
    expected = [np.arange(len(rows)), result.points, np.stack(columns, axis=1), entries]
    np.testing.assert_array_equal(numbers, np.column_stack(expected))
    assert [row[-1] for row in rows] == list(result.status)
