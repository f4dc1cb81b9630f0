"""Drawings of a registration: colours, arrows, circles and ellipses are true."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.patches import Circle
from matplotlib.quiver import Quiver

from pgm_lab import plot, registration
from tests.registration import images

MIXED = ["accepted"] * 30 + ["ambiguous"] * 4 + ["below threshold"] * 6


@pytest.fixture(scope="module")
def pair():
    return images.pair()


@pytest.fixture(autouse=True)
def close():
    yield
    plt.close("all")


def test_two_colours_are_grey_where_images_agree():
    grey = np.arange(100.0).reshape(10, 10)
    other = grey.copy()
    other[:, :5] = other[:, :5].mean()
    other = np.ma.array(other, mask=np.zeros((10, 10), bool))
    other[9, 9] = np.ma.masked
    ax, again = plot.registration.fringes(grey, {"a": grey, "b": other}, (30, 5)).axes
    red, green, blue = np.moveaxis(ax.images[0].get_array(), -1, 0)
    np.testing.assert_allclose(red, blue)
    np.testing.assert_allclose(red, green)
    np.testing.assert_array_equal(again.images[0].get_array()[9, 9], 1)
    assert ax.images[0].get_extent() == [29.5, 39.5, 14.5, 4.5]
    part = again.images[0].get_array()[:, :5]
    assert np.ptp(part[..., 0] - part[..., 1]) > 0.1


def test_arrows_are_the_shifts_and_marks_the_lost_points(pair):
    found = images.result(status=MIXED)
    fig = plot.registration.shifts(pair[0], found)
    (arrows,) = [one for one in fig.axes[0].collections if isinstance(one, Quiver)]
    np.testing.assert_allclose(arrows.U, found.dx[:30])
    np.testing.assert_allclose(arrows.V, found.dy[:30])
    np.testing.assert_array_equal(arrows.get_offsets(), found.points[:30])
    names = [one.get_label() for one in fig.axes[0].lines]
    assert names == ["below threshold: 6", "ambiguous: 4"]
    np.testing.assert_array_equal(fig.axes[0].lines[0].get_xydata(), found.points[34:])


def test_the_circle_holds_nine_tenths_of_the_shifts():
    found = images.result(400, scatter=0.2)
    whole, near = plot.registration.scatter(found, radius=3).axes
    (circle,) = [one for one in whole.patches if isinstance(one, Circle)]
    inside = np.hypot(found.dx, found.dy) <= circle.get_radius()
    assert np.mean(inside) == pytest.approx(0.9, abs=0.005)
    predicted, own = near.patches
    assert predicted.width == pytest.approx(2 * 0.02 * np.sqrt(2 * np.log(10)))
    assert own.width == pytest.approx(2 * 0.2 * np.sqrt(2 * np.log(10)), rel=0.15)
    x, y = near.lines[0].get_xydata().T
    np.testing.assert_allclose(x, found.dx - found.dx.mean())
    model = registration.fit(found)
    _, off = plot.registration.scatter(found, 3, -model.residuals).axes
    x, _ = off.lines[0].get_xdata(), off.lines[0].get_ydata()
    np.testing.assert_allclose(x, found.dx - model.parameters[0])
    assert whole.yaxis_inverted() and near.yaxis_inverted()  # rows count down


def test_the_line_of_the_prediction_has_nine_tenths_below():
    found = images.result(2000, scatter=0.05, sd=0.05)
    errors = np.column_stack([found.dx, found.dy]) - images.SHIFT
    by_r, by_sd = plot.registration.similarity(found, errors).axes
    dots, line = by_sd.lines
    x, y = line.get_xydata().T
    slope = y[0] / x[0]
    below = dots.get_ydata() <= slope * dots.get_xdata()
    assert below.mean() == pytest.approx(0.9, abs=0.02)
    np.testing.assert_array_equal(by_r.lines[0].get_xdata(), found.r)
