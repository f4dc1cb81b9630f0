"""Dense matching against disparities that are known exactly."""

import numpy as np
import pytest
import skimage.data
from scipy.ndimage import binary_dilation, gaussian_filter, map_coordinates
from tqdm import tqdm

from pgm_lab import stereo
from pgm_lab.camera import Camera, Photo
from pgm_lab.image.grey import eight_bit
from pgm_lab.stereo import dense
from tests.stereo.pairs import noisy, rms, smooth_pair, step_pair

GROUNDS = {
    "level": lambda x, y: 3.3 + 0 * x,
    "ramp": lambda x, y: -5 + 0.12 * x + 0.06 * y,
    "waves": lambda x, y: 2 + 3 * np.sin(x / 14) + 2 * np.cos(y / 17),
}
NUMBER = {name: k for k, name in enumerate(stereo.STATUSES)}


@pytest.fixture(params=["sgm", "ncc"])
def method(request):
    return request.param


@pytest.mark.parametrize("ground", GROUNDS)
def test_disparities_are_right_and_least_squares_is_better_than_correlation(
    method, ground
):
    """Level ground to rounding of the interpolation, curved ground to 0.1 px."""
    left, right, truth = smooth_pair(GROUNDS[ground])
    match = stereo.match_rows(left, right, method=method)
    error = (match.disparity - truth)[match.status == 0]
    assert (match.status[12:-12, 24:-24] == 0).mean() > 0.95
    assert rms(error) < {"level": 0.006, "ramp": 0.012, "waves": 0.018}[ground]
    assert np.abs(error).max() < {"level": 0.05, "ramp": 0.18, "waves": 0.5}[ground]
    left, right = noisy(left, 2, 1), noisy(right, 2, 2)
    coarse, fine = (
        stereo.match_rows(left, right, method="ncc", refine=refine)
        for refine in (False, True)
    )
    both = (coarse.status == 0) & (fine.status == 0)
    errors = [rms((m.disparity - truth)[both]) for m in (coarse, fine)]
    assert errors[1] < 0.8 * errors[0]


@pytest.mark.parametrize("shift", [4.0, 4.27, 4.5])
@pytest.mark.parametrize("sigma", [2, 6])
def test_errors_are_as_large_as_predicted(method, shift, sigma):
    """Monte Carlo: also between pixels, where interpolation correlates the noise."""
    left, right, _ = smooth_pair(lambda x, y: shift + 0 * x)
    errors, predicted = [], []
    for seed in range(2):
        match = stereo.match_rows(
            noisy(left, sigma, seed), noisy(right, sigma, 50 + seed), method=method
        )
        good = match.status == 0
        errors.append(match.disparity[good] - shift)
        predicted.append(match.sd[good])
    errors, predicted = np.concatenate(errors), np.concatenate(predicted)
    # "sgm" asks three windows: where noise makes them differ by chance, it is careful
    careful = {"sgm": 0.75, "ncc": 0.85}[method]
    assert careful < rms(errors) / rms(predicted) < 1.2
    assert abs(errors.mean()) < 0.005 + 0.1 * rms(errors)


def test_noise_that_is_correlated_makes_the_prediction_larger(method):
    """As resampling a photo does: white noise of the same size says more."""
    left, right, _ = smooth_pair(lambda x, y: 4.0 + 0 * x)
    rng = np.random.default_rng(1)
    noise = [gaussian_filter(rng.normal(0, 1, left.shape), 0.6) for _ in range(2)]
    match = stereo.match_rows(
        *(i + 4 * n / n.std() for i, n in zip((left, right), noise)), method=method
    )
    good = match.status == 0
    assert 0.8 < rms(match.disparity[good] - 4) / rms(match.sd[good]) < 1.2


def test_what_a_wall_hides_is_rejected_and_the_wall_is_sharp(method):
    left, right, truth, hidden = step_pair()
    match = stereo.match_rows(noisy(left, 2, 1), noisy(right, 2, 2), method=method)
    good = match.status == 0
    assert hidden.sum() == 8 * len(left)
    assert good[hidden].mean() < 0.06
    # A window of 7 takes the disparity of the better texture up to 3 px off the edge
    wall = truth == truth.max()
    edge = binary_dilation(wall, iterations=5) & ~wall
    edge |= binary_dilation(~wall, iterations=5) & wall
    inside = good & ~edge & ~hidden
    error = np.abs((match.disparity - truth)[inside])
    assert inside[10:-10, 25:-10].mean() > 0.6
    assert error.max() < 1.2
    assert np.mean(error > 0.5) < 0.005


def test_water_is_not_matched(method):
    """Neither where nothing varies, nor where there is nothing but noise."""
    left, right, _ = smooth_pair(GROUNDS["level"])
    for image in (left, right):
        image[20:60, 30:90] = 80.0
    still = stereo.match_rows(left, right, method=method)
    water = np.s_[24:56, 40:80]
    assert (still.status[water] == NUMBER["flat template"]).all()
    lively = stereo.match_rows(noisy(left, 2, 1), noisy(right, 2, 2), method=method)
    assert (lively.status[water] != 0).all()
    assert np.isnan(lively.disparity[water]).all()
    assert np.isnan(lively.sd[water]).all()


def test_no_window_reaches_beyond_the_image_and_what_fills_a_hole_does_not_matter(
    method,
):
    left, right, truth = smooth_pair(GROUNDS["level"])
    hole = np.zeros(left.shape, bool)
    hole[30:50, 60:80] = True
    # Where windows of least squares fail, semiglobal matching takes smaller ones
    near = binary_dilation(hole, np.ones({"sgm": (7, 7), "ncc": (9, 9)}[method]))
    ring = binary_dilation(near, np.ones((3, 3))) & ~near
    matches = [
        stereo.match_rows(holed, right, method=method)
        for holed in (
            np.where(hole, np.nan, left),
            np.ma.array(left, mask=hole),
            np.ma.array(np.where(hole, 1e6, left), mask=hole),
        )
    ]
    for match in matches:
        assert (match.status[near] == NUMBER["no data in the window"]).all()
        assert (match.status[ring] == 0).mean() > 0.5
        np.testing.assert_array_equal(match.disparity, matches[0].disparity)
        np.testing.assert_array_equal(match.status, matches[0].status)
    match = stereo.match_rows(
        left, np.where(np.roll(hole, -3, 1), np.nan, right), method=method
    )
    near = binary_dilation(hole, np.ones({"sgm": (5, 5), "ncc": (9, 9)}[method]))
    assert (match.status[near] != 0).all()
    inner = np.s_[34:46, 66:74]  # windows that no offset brings out of the right hole
    if method == "ncc":
        assert (match.status[inner] == NUMBER["no data in the window"]).all()
        assert np.isnan(match.r[inner]).all()
    assert np.abs((match.disparity - truth)[match.status == 0]).max() < 0.1


def test_gain_and_offset_between_the_images_do_not_matter(method):
    left, right, _ = smooth_pair(GROUNDS["ramp"])
    one = stereo.match_rows(left, right, method=method)
    other = stereo.match_rows(left / 255, 1.3 * right + 40, method=method)
    assert (one.status == other.status).mean() > 0.999
    assert np.nanmax(np.abs(one.disparity - other.disparity)) < 0.01


def test_the_pyramid_reaches_far_and_a_short_search_says_so(method):
    left, right, truth = smooth_pair(lambda x, y: 30 + 0 * x, (170, 220))
    match = stereo.match_rows(left, right, search=10, method=method)
    error = (match.disparity - truth)[match.status == 0]
    assert (match.status == 0).mean() > 0.6
    assert np.abs(error).max() < 0.1
    short = stereo.match_rows(left, right, levels=1, search=12, method=method)
    assert (short.status == 0).mean() < 0.01
    assert sum(short.counts().values()) == left.size


def test_the_search_reaches_as_far_as_the_heights_do():
    """Steep ground: disparities far beyond what the default searches in any image."""
    left, right, truth = smooth_pair(lambda x, y: 40 + 0 * x, (90, 220))
    own = np.eye(3), np.zeros((2, 3)), 1.0, 1.0, np.zeros((2, 2))
    for reach, found in ((0.0, False), (45.0, True)):
        pair = stereo.NormalPair(left, right, *own, reach=reach)
        match = stereo.match_dense(pair)
        near = np.abs(match.disparity - truth)[20:-20, 80:-20] < 0.1
        assert (near.mean() > 0.9) == found
    # As far as the points on both limits are apart
    photos = [
        Photo(np.zeros((200, 300)), Camera(24.0), (x, 0, 1000, 0, 0, 0), 0.08)
        for x in (-200, 200)
    ]
    pair = stereo.epipolar_pair(*photos, (-200, 300))
    ends = np.array([(0.0, 0, -200), (0, 0, 300)])
    one, other = (
        pair.from_photo(k, photo.project(ends))[:, 0] for k, photo in enumerate(photos)
    )
    assert (one - other).tolist() == pytest.approx([-pair.reach, pair.reach])


def test_a_correlation_that_still_rises_at_the_end_of_the_search_is_no_match():
    """Smooth texture, so that r is high long before its peak, 2 px too far away."""
    texture = gaussian_filter(np.random.default_rng(4).normal(size=(60, 120)), 6)
    match = stereo.match_rows(
        texture, np.roll(texture, -6, axis=1), method="ncc", levels=1, search=4
    )
    inner = match.status[12:-12, 30:-30]
    assert (inner == NUMBER["peak on the border of the search"]).mean() > 0.8
    assert (inner != 0).all()


def test_the_way_back_gives_the_same_disparities():
    """Semiglobal matching takes the mean of both; one alone differs 3 times as much."""
    left, right, _ = smooth_pair(GROUNDS["level"])
    left, right = noisy(left, 6, 1), noisy(right, 6, 2)
    there = stereo.match_rows(left, right).disparity
    back = stereo.match_rows(right[:, ::-1], left[:, ::-1]).disparity[:, ::-1]
    rows, columns = np.indices(there.shape)
    back = map_coordinates(back, [rows, columns - there], order=1, cval=np.nan)
    assert np.nanmedian(np.abs(there - back)) < 0.004


def test_a_small_patch_that_differs_is_isolated():
    """A jump of more than half a pixel makes a patch; a slope does not."""
    d = np.tile(np.linspace(0, 20, 60, dtype=np.float32), (40, 1))
    good = np.ones(d.shape, bool)
    good[:, 45] = False
    d[5:14, 5:15] += 3  # 90 cells
    d[20:30, 20:30] += 3  # 100 cells
    alone = dense._isolated(d, good, 98, dense.MAX_JUMP)
    assert alone[5:14, 5:15].all()
    assert alone.sum() == 90


def test_bands_of_rows_leave_no_trace(monkeypatch, method):
    left, right, _ = smooth_pair(GROUNDS["waves"])
    left, right = noisy(left, 2, 1), noisy(right, 2, 2)
    whole = stereo.match_rows(left, right, method=method)
    monkeypatch.setattr(dense, "BAND", 17)
    bands = stereo.match_rows(left, right, method=method)
    np.testing.assert_array_equal(whole.status, bands.status)
    # Planes through 1/16 px, as semiglobal matching gives them, are rounded up or down
    limits = {"sgm": 1 / 32, "ncc": 1e-4}[method]
    np.testing.assert_allclose(whole.disparity, bands.disparity, atol=limits / 2)
    differ = np.abs(bands.sd / whole.sd - 1) > limits
    assert np.mean(differ) < {"sgm": 0.005, "ncc": 1e-9}[method]


def test_tiles_overlap_so_far_that_they_leave_hardly_a_trace(monkeypatch):
    """With noise of a third of the texture; an overlap of 1 px moves 1 % of cells."""
    left, right, truth = smooth_pair(GROUNDS["waves"], (130, 180))
    left, right = noisy(left, 12, 1), noisy(right, 12, 2)
    whole = stereo.match_rows(left, right)
    monkeypatch.setattr(dense, "TILE", 48)
    tiles = stereo.match_rows(left, right)
    differ = np.abs(whole.disparity - tiles.disparity)[12:-12, 24:-24]
    assert np.isfinite(differ).mean() > 0.95
    assert np.mean(differ > 0.1) < 0.001


def test_a_bar_counts_what_there_is_to_do(method, monkeypatch):
    """Also where tiles and bands end before the image does."""
    bars = []

    class Watched(tqdm):
        def close(self):
            bars.append((self.n, self.total))
            super().close()

    monkeypatch.setattr("tqdm.auto.tqdm", Watched)
    monkeypatch.setattr(dense, "TILE", 48)
    monkeypatch.setattr(dense, "BAND", 50)
    left, right, _ = smooth_pair(GROUNDS["level"], (85, 121))
    stereo.match_rows(left, right, method=method, progress=True)
    done, total = bars[0]
    assert done == total > 2 * left.size


def test_semiglobal_matching_is_denser_and_fill_denser_still_with_an_honest_sd():
    """At a wall, with noise of the size of the texture that ncc gives up."""
    left, right, truth, hidden = step_pair()
    left, right = noisy(left, 12, 1), noisy(right, 12, 2)
    ways = ({"method": "ncc"}, {}, {"fill": True})
    matches = [stereo.match_rows(left, right, **way) for way in ways]
    shares = [(match.status == 0).mean() for match in matches]
    assert shares[1] > 1.1 * shares[0] and shares[2] > 1.05 * shares[1]
    for match in matches[1:]:
        error = (match.disparity - truth)[~hidden]
        right_ones = np.abs(error) < 1
        assert np.mean(~right_ones[np.isfinite(error)]) < 0.05
        ratio = rms(error[right_ones]) / rms(match.sd[~hidden][right_ones])
        assert 0.6 < ratio < 1.2
    # What is hidden has two directions that do not agree, even if flat
    left[binary_dilation(hidden, np.ones((1, 9))) & (truth < truth.max())] = 80
    flat = stereo.match_rows(left, right, fill=True)
    assert (flat.status[hidden] == 0).mean() < 0.2
    filled = np.isfinite(matches[2].disparity) & np.isnan(matches[1].disparity)
    assert np.median(matches[2].sd[filled]) > 2 * np.nanmedian(matches[1].sd)
    for way in ({"method": "ncc", "fill": True}, {"refine": False}):
        with pytest.raises(ValueError, match="does not go with"):
            stereo.match_rows(left, right, **way)


def test_ground_that_is_no_plane_makes_the_prediction_larger():
    """Without noise all error is the shape's: 4 times what least squares predicts."""
    left, right, truth = smooth_pair(GROUNDS["waves"])
    ratios = []
    for method in ("ncc", "sgm"):
        match = stereo.match_rows(left, right, method=method)
        good = match.status == 0
        ratios.append(rms((match.disparity - truth)[good]) / rms(match.sd[good]))
    assert ratios[0] > 3 and 0.4 < ratios[1] < 1.2


@pytest.mark.parametrize("scale", [1.0, 1.5])
def test_few_errors_are_beyond_three_standard_deviations_where_texture_is_uneven(scale):
    """Sharp joints between dull bricks on curved ground; by residuals alone a sixth."""
    rows, columns = np.mgrid[:200, :260].astype(float)

    def disparity(x):
        return 3 + 3 * np.sin(x / 20) + 2 * np.cos(rows / 25)

    x = columns
    for _ in range(60):
        x = columns + disparity(x)
    wall = skimage.data.brick().astype(float)
    left, right = (
        map_coordinates(wall, scale * np.array([rows + 9, at + 9]), order=1)
        for at in (columns, x)
    )
    match = stereo.match_rows(noisy(left, 2, 1), noisy(right, 2, 2))
    error = match.disparity - disparity(columns)
    z = (error / match.sd)[np.abs(error) < 1]
    assert 0.8 < np.median(np.abs(z)) / 0.6745 < 1.25
    assert np.mean(np.abs(z) > 3) < 0.05
    assert np.nanmin(match.sd) > 0


def test_glare_in_sixteen_bits_leaves_the_contrast_of_the_rest():
    left, right, truth = smooth_pair(GROUNDS["ramp"])
    left, right = ((1000 + 2 * a).astype(np.uint16) for a in (left, right))
    left[50, 60:64], right[20, 30:33] = 65535, 65535
    assert eight_bit(left).std() > 30
    match = stereo.match_rows(left, right)
    good = match.status[12:-12, 24:-24] == 0
    assert good.mean() > 0.9
    assert rms((match.disparity - truth)[12:-12, 24:-24][good]) < 0.05


def test_images_that_show_nothing_alike_or_nothing_at_all(method):
    left, right = np.random.default_rng(0).normal(100, 20, (2, 90, 120))
    assert (stereo.match_rows(left, right, method=method).status == 0).mean() < 0.002
    constant = stereo.match_rows(
        np.full((50, 60), 7.0), np.full((50, 60), 7.0), method=method
    )
    assert set(np.unique(constant.status)) == {1, 2}
    with pytest.raises(ValueError, match="left has no data"):
        stereo.match_rows(np.full((50, 60), np.nan), right[:50, :60], method=method)
    with pytest.raises(ValueError, match="the same size"):
        stereo.match_rows(left, right[:, 1:], method=method)


@pytest.mark.parametrize("how", [{}, {"fill": True}, {"method": "ncc"}], ids=str)
def test_what_is_accepted_has_a_standard_deviation(how, monkeypatch):
    """Of equal images, few grey values, holes; and where residuals tell nothing."""
    scene, moved, _ = smooth_pair(GROUNDS["ramp"])
    holed = np.where(np.indices(scene.shape).sum(axis=0) % 70 < 12, np.nan, scene)
    real = dense._inflation
    for left, right in ((scene, scene), (scene // 40, moved // 40), (holed, moved)):
        match = stereo.match_rows(left, right, **how)
        np.testing.assert_array_equal(np.isfinite(match.sd), match.status == 0)
        # Half of it without residuals to tell
        some = np.indices(scene.shape)[1] < 60
        monkeypatch.setattr(
            dense,
            "_inflation",
            lambda *a, some=some: np.where(some[: len(a[1])], np.nan, real(*a)),
        )
        lost = stereo.match_rows(left, right, **how)
        monkeypatch.undo()
        np.testing.assert_array_equal(np.isfinite(lost.sd), lost.status == 0)
        assert np.sum(lost.status == 0) < np.sum(match.status == 0)
