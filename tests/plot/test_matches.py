"""Drawings of matches: marks lie at the points, arrows are the parallaxes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.quiver import Quiver

from pgm_lab import plot
from tests.matching import photos

MIXED = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6


@pytest.fixture(scope="module")
def grey():
    return photos.pair()


@pytest.fixture(autouse=True)
def close():
    yield
    plt.close("all")


def test_each_status_has_its_mark_and_each_match_two(grey):
    found = photos.result(status=MIXED)
    left, right = plot.matches.side_by_side(*grey, found).axes
    names = [line.get_label() for line in left.lines]
    assert names == ["accepted: 30", "below threshold: 6", "ambiguous: 4"]
    looks = [(line.get_color(), line.get_marker()) for line in left.lines]
    assert len({c for c, _ in looks}) == len({m for _, m in looks}) == 3
    np.testing.assert_array_equal(left.lines[0].get_xydata(), found.chosen[:30])
    np.testing.assert_array_equal(left.lines[2].get_xydata(), found.chosen[30:34])
    (marks,) = right.lines
    np.testing.assert_array_equal(marks.get_xydata(), found.points[:30])


def test_another_photo_than_the_matched_one_is_refused(grey):
    with pytest.raises(
        ValueError, match="left has 240 x 190 pixels, and the photo that"
    ):
        plot.matches.side_by_side(grey[0][:190], grey[1], photos.result())


def test_affine_residuals_are_what_no_affine_transformation_explains():
    """Of 40 points three are wrong; the others fit all the same."""
    A = np.array([(1.1, 0.2), (-0.15, 0.9)])
    found = photos.result()
    points = found.chosen @ A.T + (30, -7)
    points[[3, 20, 33]] += (25, -12)
    v = plot.matches.affine_residuals(photos.result(points=points))
    good = np.delete(np.arange(40), [3, 20, 33])
    assert np.abs(v[good]).max() < 0.01
    np.testing.assert_allclose(v[[3, 20, 33]], np.tile((25.0, -12), (3, 1)), atol=0.01)


def test_arrows_are_long_as_they_say_and_far_ones_red(grey):
    rng = np.random.default_rng(3)
    found = photos.result()
    points = found.points + rng.normal(0, 0.5, (40, 2))
    points[8] += 30
    found = photos.result(points=points)
    ax = plot.matches.parallaxes(grey[0], found).axes[0]
    far, near = [one for one in ax.collections if isinstance(one, Quiver)]
    v = plot.matches.affine_residuals(found)
    drawn = np.column_stack([near.U, near.V])
    np.testing.assert_allclose(drawn, np.delete(v, 8, axis=0))
    np.testing.assert_array_equal(far.get_offsets(), found.chosen[[8]])
    assert np.hypot(far.U, far.V) < np.hypot(*v[8])
    assert "red ones are longer" in ax.get_title()


def test_histograms_hold_every_point_and_their_limits():
    found = photos.result(status=MIXED)
    above, below = plot.matches.histograms(found, threshold=0.7).axes
    counts = [sum(bar.get_height() for bar in one) for one in above.containers]
    assert counts == [40, 30]
    assert sum(bar.get_height() for bar in below.containers[0]) == 30
    assert above.lines[0].get_xdata()[0] == 0.7
    assert below.lines[0].get_xdata()[0] == pytest.approx(0.04)
