"""What chapter 2 says of correlation and does not compute before the reader's eyes."""

import numpy as np
import pytest

from pgm_book.program.registration import peak_of_parabola
from pgm_lab import datasets, image, ncc, simulate

STEP = np.stack(np.meshgrid(np.arange(-10, 11), np.arange(-10, 11)), axis=-1)


def seen_again(matrix):
    """Median r of 40 windows of the meadow, 21 x 21, seen again through a matrix."""
    meadow = datasets.yellowstone().grey
    places = np.random.default_rng(2).integers(100, 1436, (40, 2))
    around = [image.cut(meadow, place, 63) for place in places]
    after = [image.resample(part, 31 + STEP @ matrix.T) for part in around]
    return np.median(
        [ncc.correlation(a[21:42, 21:42], b) for a, b in zip(around, after)]
    )


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]])


def test_five_degrees_or_a_tenth_of_the_width_bring_r_below_0_7():
    assert seen_again(np.eye(2)) > 0.999
    assert 0.6 < (seen_again(turned(4)) + seen_again(turned(6))) / 2 < 0.75
    assert 0.6 < seen_again(np.diag([1 / 0.9, 1])) < 0.75
    assert seen_again(turned(9)) < seen_again(turned(6)) < 0.7


def test_a_pyramid_finds_nearly_as_many_from_a_fourteenth_of_the_places():
    pair = datasets.motorcycle()
    x, y = np.meshgrid(np.arange(80, 720, 20), np.arange(44, 460, 20))
    points = np.column_stack([x.ravel(), y.ravel()])
    points = points[np.isfinite(pair.disparity[points[:, 1], points[:, 0]])]
    inside = np.all((points > 84) & (points < (656, 416)), axis=1)
    chosen = points[inside][::2]
    pyramids = [image.pyramid(photo, 3) for photo in (pair.left, pair.right)]
    place, positions = chosen, 0
    for level, size, reach in ((2, 11, 15), (1, 15, 3), (0, 21, 3)):
        scale, photos = 2**level, [photo[level] for photo in pyramids]
        window = size + 2 * reach
        step = ncc.match(*photos, chosen / scale, place / scale, size, window, -1, 1)
        place, positions = scale * step.points, positions + (2 * reach + 1) ** 2
    full = ncc.match(pair.left, pair.right, chosen, None, 21, 141, -1, 1).points
    full_search = (141 - 21 + 1) ** 2
    disparity = pair.disparity[chosen[:, 1], chosen[:, 0]]
    aim = chosen - np.column_stack([disparity, 0 * disparity])
    share = [np.mean(np.abs(p - aim).max(axis=1) <= 1) for p in (place, full)]
    assert positions == 1059 and positions < full_search / 13
    assert np.allclose(share, (0.55, 0.56), atol=0.015)


@pytest.mark.parametrize(
    ("finest", "alone", "both"),
    [(0.2, 0.041, 0.0145), pytest.param(0.4, 0.043, 0.035, marks=pytest.mark.slow)],
)
def test_a_paraboloid_is_better_than_a_parabola_along_each_axis(finest, alone, both):
    grid = np.arange(35, 300, 32.5).astype(int)
    points = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    surface, errors = simulate.texture(finest, seed=3), []
    for shift in np.random.default_rng(1).uniform(-0.5, 0.5, (8, 2)):
        affine = (shift[0], 1, 0, shift[1], 0, 1)
        one, other = simulate.texture_pair(surface, (330, 330), affine, sigma=1)
        whole = ncc.match(one, other, points, template=21, search=31).points
        top = ncc.match(
            one, other, points, template=21, search=31, refine="parabola"
        ).points
        for point, peak, fine in zip(points, whole, top, strict=True):
            around = image.cut(other, peak, 23)
            r = ncc.correlation_map(image.cut(one, point, 21), around)
            axes = peak_of_parabola(*r[1]), peak_of_parabola(*r[:, 1])
            errors.append([peak + axes - point - shift, fine - point - shift])
    rms = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))
    assert np.allclose(rms, (alone, both), atol=0.003)
