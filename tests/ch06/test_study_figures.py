"""Figures of experiments with bundles show the numbers they are given."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch06 import case_figures as ch06_case_figures


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def legend(fig):
    found = [ax.get_legend() for ax in fig.axes if ax.get_legend()] + fig.legends
    return [text.get_text() for box in found for text in box.get_texts()]


def test_bars_reach_the_residuals_of_their_photo_in_micrometres():
    rms = {"start": [0.13, 0.2, 0.09], "adjusted": [3e-4, 2e-4, 4e-4]}
    fig = ch06_case_figures.residuals_by_photo(rms, ["A", "B", "C"])
    (ax,) = fig.axes
    tops = [bar.get_y() + bar.get_height() for bar in ax.patches]
    np.testing.assert_allclose(tops, [130, 200, 90, 0.3, 0.2, 0.4])
    middles = [bar.get_x() + bar.get_width() / 2 for bar in ax.patches]
    np.testing.assert_allclose(np.round(middles), [0, 1, 2, 0, 1, 2])
    assert len(set(np.round(middles, 6))) == 6  # side by side
    assert all(bar.get_height() > 0 for bar in ax.patches)
    assert legend(fig) == ["start", "adjusted"]
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["A", "B", "C"]
    assert ax.get_ylabel().endswith("(µm)")
    assert ax.get_yscale() == "log"


def test_solutions_must_have_the_same_photos():
    with pytest.raises(ValueError, match="rms must hold lists of the same length"):
        ch06_case_figures.residuals_by_photo({"a": [1.0, 2.0], "b": [1.0]})


def test_ratio_of_sampled_to_predicted_stands_over_each_parameter():
    fig = ch06_case_figures.predicted_against_sampled(
        [2e-3, 5.0], {"free": [2.2e-3, 4.5], "wrong": [8e-3, 60.0]}, ["c", "X0"], 500
    )
    (ax,) = fig.axes
    series = {line.get_label(): line.get_ydata() for line in ax.lines}
    np.testing.assert_allclose(series["free"], (1.1, 0.9))
    np.testing.assert_allclose(series["wrong"], (4, 12))
    assert ax.get_yscale() == "log"
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["$c$", "$X_0$"]
    assert legend(fig)[1:] == ["free", "wrong"]


def test_band_holds_the_standard_deviations_of_so_many_samples():
    fig = ch06_case_figures.predicted_against_sampled([1.0], [1.0], ["c"], 200)
    (ax,) = fig.axes
    assert ax.get_ylim()[0] < 0.9 and ax.get_ylim()[1] > 1.1
    (_, low), (_, high) = ax.patches[0].get_bbox().get_points()
    samples = np.random.default_rng(1).normal(size=(20_000, 200))
    found = np.quantile(samples.std(axis=1, ddof=1), (0.025, 0.975))
    # 20,000 repetitions know such a quantile to 0.001 of the standard deviation
    np.testing.assert_allclose((low, high), found, atol=0.004)


def test_every_parameter_needs_a_name():
    with pytest.raises(ValueError, match="sampled must hold lists of the same length"):
        ch06_case_figures.predicted_against_sampled([1.0, 2.0], [1.0, 2.0], ["c"], 500)


def test_time_and_memory_stand_over_the_rays_of_their_network():
    seconds = {"pgm_lab": [0.01, 0.7, 2.0], "another": [0.003, 1.4, 4.0]}
    fig = ch06_case_figures.size_study(
        [450, 8e4, 2e5], seconds, [3, 140, 330], list("abc")
    )
    left, right = fig.axes
    drawn = {line.get_label(): line.get_xydata().T for line in left.lines}
    assert set(drawn) == set(seconds)
    for name, values in seconds.items():
        np.testing.assert_array_equal(drawn[name], ([450, 8e4, 2e5], values))
    (line,) = right.lines
    np.testing.assert_array_equal(line.get_xydata().T, ([450, 8e4, 2e5], [3, 140, 330]))
    assert line.get_color() == left.lines[0].get_color()  # whose memory it is
    places = {text.get_text(): text.xy for text in right.texts}
    assert places == {"a": (450, 3), "b": (8e4, 140), "c": (2e5, 330)}
    assert legend(fig) == ["pgm_lab", "another"]
    for ax, unit in ((left, "(s)"), (right, "(MB)")):
        assert ax.get_xscale() == ax.get_yscale() == "log"
        assert ax.get_xlabel() == "rays" and ax.get_ylabel().endswith(unit)


def test_every_network_needs_its_time():
    with pytest.raises(ValueError, match="seconds and megabytes must hold lists"):
        ch06_case_figures.size_study([450, 900], {"a": [1.0]}, [1.0, 2.0], ["a", "b"])
