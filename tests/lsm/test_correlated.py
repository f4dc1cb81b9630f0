"""Noise that neighbouring pixels share, and what it does to the predicted precision."""

import cv2
import numpy as np
import pytest

from pgm_book.ch03.studies import correlated as lsm_correlated
from pgm_book.ch03.studies import scene as lsm_scene
from pgm_book.common import results
from pgm_lab import lsm
from pgm_lab.lsm import _normal_equations

SIZES = 11, 21, pytest.param(31, marks=pytest.mark.slow)


def matched(
    texture, template, sigma=2.0, *, blur=0.0, contrast=40.0, seed=5, **options
):
    """Result and errors (n, 2) of some 1000 windows; noise under a Gaussian blur."""
    scene = lsm_scene.scene(texture, seed, contrast=contrast, margin=20)
    left, right = scene.images(0.0 if blur else sigma, seed=seed)
    if blur:
        rng = np.random.default_rng(seed)
        left, right = (
            image + shared_noise(image.shape, sigma, blur, rng)
            for image in (left, right)
        )
    found = lsm.match(left, right, scene.points, scene.start, template, **options)
    assert found.accepted.all() and len(found.points) > 1000
    return found, found.points - scene.truth


def shared_noise(shape, sigma, blur, rng):
    """Normal noise of `sigma` whose correlation is exp(-d^2 / (4 blur^2))."""
    noise = cv2.GaussianBlur(rng.normal(size=shape), (0, 0), blur)
    return sigma * noise / noise.std()


def over_predicted(found, error):
    """Root mean square of errors over their predicted standard deviations."""
    return np.sqrt(np.mean(lsm_scene.squared(error, found.covariance)))


@pytest.mark.parametrize("template", SIZES)
@pytest.mark.parametrize(
    ("texture", "sigma", "contrast"),
    [
        pytest.param(lsm_scene.SOFT, 1.0, 40.0, marks=pytest.mark.slow),
        pytest.param(lsm_scene.SOFT, 5.0, 40.0, marks=pytest.mark.slow),
        (lsm_scene.SOFT, 2.0, 10.0),
        pytest.param(lsm_scene.SHARP, 1.0, 40.0, marks=pytest.mark.slow),
        pytest.param(lsm_scene.SHARP, 5.0, 40.0, marks=pytest.mark.slow),
    ],
)
def test_white_noise_is_left_alone(texture, sigma, contrast, template):
    """The predictions of 1000 windows and the errors over them, to 2 per cent.

    One in a hundred seems to be curved, and its prediction is some times larger.
    """
    found, error = matched(texture, template, sigma, contrast=contrast)
    plain, _ = matched(texture, template, sigma, contrast=contrast, correlated=False)
    ratio = np.sqrt(found.covariance[:, 0, 0] / plain.covariance[:, 0, 0])
    assert np.sort(ratio)[:-30].mean() == pytest.approx(1, abs=0.02)
    assert 0.98 < ratio.mean() < 1.06
    assert over_predicted(found, error) / over_predicted(plain, error) == (
        pytest.approx(1, abs=0.02)
    )
    np.testing.assert_array_equal(plain.effective_pixels, template**2)
    np.testing.assert_array_equal(plain.sigma0, found.sigma0)


@pytest.mark.parametrize("template", SIZES)
@pytest.mark.parametrize("blur", [0.6, pytest.param(1.0, marks=pytest.mark.slow)])
def test_errors_are_as_predicted_where_neighbours_share_their_noise(blur, template):
    """White noise predicts half of the errors that there are.

    A window of 11 pixels holds some twenty waves of a soft texture, and eight are taken
    by the adjustment: 20 per cent.
    """
    found, error = matched(lsm_scene.SOFT, template, blur=blur)
    assert over_predicted(found, error) == pytest.approx(
        1, abs=0.2 if template == 11 else 0.1
    )
    plain, _ = matched(lsm_scene.SOFT, template, blur=blur, correlated=False)
    assert over_predicted(plain, error) > 1.5
    assert np.median(found.effective_pixels) < template**2 / 2
    # Sharp texture: the noise is blurred, and its frequencies are not
    found, error = matched(lsm_scene.SHARP, template, blur=blur)
    assert 0.75 < over_predicted(found, error) < 1.05


def test_a_window_across_a_depth_edge_is_worth_fewer_pixels_but_never_nonsense():
    """Half of the right window is a different texture: residuals like outliers."""
    scene = lsm_scene.scene(lsm_scene.SOFT, 3, size=300)
    other = lsm_scene.scene(lsm_scene.SOFT, 4, size=300)
    left, right = scene.images(1.0)
    _, behind = other.images(1.0)
    x, y = scene.truth.T
    points, start = scene.points[x > 200], scene.start[x > 200]
    for column in np.unique(start[:, 0]):
        right[:, int(column) + 4 : int(column) + 13] = behind[
            :, int(column) + 4 : int(column) + 13
        ]
    found = lsm.match(left, right, points, start, threshold=0.3)
    good = found.accepted
    assert good.sum() > 10
    assert np.all(np.linalg.eigvalsh(found.covariance[good]) > 0)
    assert np.all(
        (found.effective_pixels[good] >= 8) & (found.effective_pixels[good] <= 882)
    )
    assert np.median(found.effective_pixels[good]) < 441 / 2


def test_sums_over_lags_count_each_pair_of_pixels_twice():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 3, 2, 7, 7))
    spaced = [_normal_equations._spaced(c.reshape(3, 2, 49), 49) for c in (a, b)]
    found, n = _normal_equations._sums(*spaced, 49)
    at = np.stack(np.mgrid[:7, :7][::-1], axis=-1).reshape(-1, 2)
    apart = at[None] - at[:, None]
    a, b = a.reshape(3, 2, 49), b.reshape(3, 2, 49)
    for k, lag in enumerate(((0, 0), *_normal_equations.LAGS)):
        pairs = np.all(apart == lag, axis=-1)
        twice = 2 if k else 1
        assert n[k, 0] == twice * pairs.sum()
        expected = twice * np.einsum("mip,miq,pq->m", a, b, pairs)
        np.testing.assert_allclose(found[k], expected, rtol=1e-4, atol=1e-4)


def table():
    """The rows of the table that the script wrote."""
    return results.rows("ch03", "correlated")


@pytest.mark.slow
def test_the_script_still_says_what_the_table_of_cameras_does():
    *_, new = lsm_correlated.rows("all and sharpened", templates=(21,))
    old = next(
        row
        for row in table()
        if (row["camera"], row["template"]) == ("all and sharpened", "21")
    )
    assert list(old) == list(lsm_correlated.COLUMNS)
    numbers = [float(old[name]) for name in lsm_correlated.COLUMNS[1:]]
    # Another version of OpenCV may compress colours a little differently
    np.testing.assert_allclose(np.array(new[1:], float), numbers, rtol=0.05)


def test_errors_of_photos_are_at_most_a_fifth_larger_than_predicted():
    """From 21 pixels; each row has 121 windows or more, which give it to 7 per cent."""
    for row in table():
        assert 0.9 < float(row["median_z"]) < (1.25 if row["template"] == "11" else 1.2)
        if row["camera"] == "white noise":
            assert float(row["median_z"]) == pytest.approx(
                float(row["white_median_z"]), rel=0.07
            )


def test_a_window_is_worth_its_parameters_at_least_and_twice_its_pixels_at_most():
    """Residuals as smooth as the texture and only where it is; differences of noise."""
    y, x = np.mgrid[-7:8, -7:8].reshape(2, -1)
    bump = np.exp(-(x**2 + y**2) / 8.0)
    rows = [bump, x * bump, y * bump, x * y, x * y * bump, x**2 * bump]
    design = np.array([rows])
    Q = np.linalg.inv(design @ np.swapaxes(design, 1, 2))
    noise = np.random.default_rng(2).normal(size=(16, 16))
    rough = np.diff(np.diff(noise, axis=0), axis=1).ravel()
    for v, expected in ((bump, 6), (rough, 2 * 225)):
        found = _normal_equations.effective_pixels(design, Q, v[None], np.ones(1))
        np.testing.assert_allclose(found, expected)
