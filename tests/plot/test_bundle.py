"""Figures of a bundle adjustment show its numbers; looks, a person must judge."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex
from scipy.stats import beta, norm, t

from pgm_book.ch06 import case_figures as ch06_case_figures
from pgm_lab import _rounding, bundle, datasets, plot
from pgm_lab.camera import PARAMETERS, Camera
from pgm_lab.plot import _style
from tests.stand_in import stand_in

LENS = Camera(30.0, 0.2, -0.1, 2e-5, -3e-7, 2e-9, 3e-6, -4e-6)


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def result(
    cameras=(LENS,), photos=3, per_photo=12, estimate=PARAMETERS, seed=1, **other
):
    """What `bundle.adjust` returns, as far as it is drawn, with random numbers."""
    rng = np.random.default_rng(seed)
    k, u = photos * per_photo, len(estimate) * len(cameras)
    size = np.tile(np.abs(LENS.interior[[PARAMETERS.index(n) for n in estimate]]), 2)
    root = 0.1 * rng.normal(size=(u + 6 * photos, u + 6 * photos))
    root[:u] *= (size[:u] + 1e-6)[:, None]
    covariance = root @ root.T
    sd = np.sqrt(np.diag(covariance))
    network = SimpleNamespace(
        photo=np.repeat(np.arange(photos), per_photo),
        point=np.tile(np.arange(per_photo), photos),
        xy=rng.uniform(-9, 9, (k, 2)),
        camera=np.arange(photos) % len(cameras),
        photo_names=range(1, photos + 1),
        point_names=range(1, per_photo + 1),
    )
    unknowns = [
        bundle.Unknown("camera", i + 1, name)
        for i in range(len(cameras))
        for name in estimate
    ]
    v = 3e-4 * rng.normal(size=(k, 2))
    whole = dict(
        network=network,
        cameras=cameras,
        exteriors=np.zeros((photos, 6)),
        unknowns=tuple(unknowns),
        interior_names=tuple(one.parameter for one in unknowns),
        covariance_interior=covariance[:u, :u],
        sd_interior=sd[:u],
        correlation=covariance / np.outer(sd, sd),
        residuals=v,
        standardized=v / 3e-4,
        redundancy=40,
        residual_test="tau",
    )
    return stand_in(bundle.Bundle, **whole | other)


def head(ax):
    return ax.get_title(loc="left") or ax.get_title()  # wherever the style puts it


@pytest.fixture(scope="module")
def nine_photos():
    d = datasets.muliawan2013()
    exteriors, points = d.exteriors, d.object_points
    network = bundle.Network(
        Camera(*d.interior), exteriors, points, d.photo, d.point, d.xy, d.sigma
    )
    return bundle.adjust(network)


def test_figures_of_a_real_adjustment(nine_photos):
    above, below = plot.bundle.lens_curve(nine_photos, decentring=True).axes
    r, half = below.lines[0].get_data()
    assert np.all(np.diff(half[r > 2]) > 0)
    # K1 alone, as if it were not correlated, would say three times as much
    edge = np.searchsorted(r, 10.0)
    assert half[edge] < 1e3 * 1.96 * nine_photos.sd_interior[3] * 10**3
    fig = plot.bundle.residual_vectors(nine_photos)
    assert [head(ax).split(":")[0] for ax in fig.axes] == [
        f"photo {i}" for i in range(1, 10)
    ]
    (ax,) = plot.bundle.standardized_histogram(nine_photos).axes
    assert "photo 6, point 29: x −8.1" in ax.texts[0].get_text()
    left, right = ch06_case_figures.correlation_matrix(nine_photos).axes
    assert texts(left)[4, 5] == "−0.98"  # K2, K3
    assert len(texts(right)) == 60


def test_lens_curve_draws_profile_and_band_in_micrometres():
    adjusted = result()
    above, below = plot.bundle.lens_curve(adjusted, rho_max=10.0).axes
    r, drawn = above.lines[0].get_data()
    value, sd = bundle.lens.profile(adjusted, r)
    assert r[-1] == 10
    np.testing.assert_allclose(drawn, 1e3 * value)
    half = 1e3 * t.ppf(0.975, 40) * sd
    band = above.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx((1e3 * value + half).max())
    assert band[:, 1].min() == pytest.approx((1e3 * value - half).min())
    np.testing.assert_allclose(below.lines[0].get_ydata(), half)
    assert above.get_ylabel() == "correction (µm)"
    assert below.get_xlabel() == "distance from the principal point (mm)"
    assert "95 %" in head(above)


def test_lens_curve_shades_where_points_of_the_camera_were_measured():
    adjusted = result((LENS, Camera(30.0, 0.5, 0.5)))
    network = adjusted.network
    own = network.photo == 1  # the only photo of camera 2
    r = np.hypot(*(network.xy[own] - 0.5).T)
    above, _ = plot.bundle.lens_curve(adjusted, camera=1).axes
    x, _ = above.patches[0].get_bbox().get_points().T
    np.testing.assert_allclose(x, (r.min(), r.max()))
    assert above.get_xlim()[1] == pytest.approx(1.1 * r.max())


def test_lens_curve_of_a_forward_lens_shows_its_distortion():
    lens = Camera(30.0, K1=1e-5, lens="forward")
    above, _ = plot.bundle.lens_curve(result((lens,)), decentring=True).axes
    assert above.get_ylabel() == "distortion (µm)"
    names = [text.get_text() for text in above.get_legend().get_texts()]
    assert names == ["radial", "decentring"]


def arrows(ax):
    """Start, vector and colour of all that is drawn in an axes."""
    parts = []
    for q in ax.collections:
        if q.N:
            parts += [(q.XY, np.column_stack([q.U, q.V]), to_hex(q.get_facecolor()[0]))]
    return parts


def test_residuals_stand_at_their_points_enlarged_and_outliers_are_named():
    adjusted = result()
    adjusted.standardized[:] = np.clip(adjusted.standardized, -3, 3)
    adjusted.standardized[17] = (0.1, -3.5)  # photo 2, point 6
    fig = plot.bundle.residual_vectors(adjusted, magnify=5000)
    here = np.flatnonzero(adjusted.network.photo == 1)
    good = here[here != 17]
    ax = fig.axes[1]
    (xy, vectors, color), (xy_out, vector_out, color_out) = arrows(ax)
    np.testing.assert_allclose(xy, adjusted.network.xy[good])
    np.testing.assert_allclose(vectors, 5000 * adjusted.residuals[good])
    np.testing.assert_allclose(xy_out, adjusted.network.xy[[17]])
    np.testing.assert_allclose(vector_out, 5000 * adjusted.residuals[[17]])
    assert (color, color_out) == (plot.BLUE.lower(), plot.RED.lower())
    assert "6" in [text.get_text() for text in ax.texts]
    assert len(arrows(fig.axes[0])) == 1
    assert "5,000 times too large" in fig.get_suptitle()
    rms = 1e3 * np.sqrt(np.mean(adjusted.residuals[here] ** 2))
    assert head(ax) == f"photo 2: {rms:.2f} µm"


def test_bar_is_as_long_as_a_residual_of_its_size():
    fig = plot.bundle.residual_vectors(result(), magnify=4000)
    ax = fig.axes[0]
    (bar,) = [line for line in ax.lines if line.get_marker() == "|"]
    length = np.ptp(bar.get_xdata())
    stated = ax.texts[-1].get_text()
    assert stated.endswith(" µm")
    assert 4000 * 1e-3 * float(stated.removesuffix(" µm")) == pytest.approx(length)


def test_frame_holds_the_longest_residual_and_the_bar():
    adjusted = result()
    adjusted.residuals[5] = (0.004, -0.004)
    fig = plot.bundle.residual_vectors(adjusted, magnify=3000)
    tips = adjusted.network.xy + 3000 * adjusted.residuals
    for ax in fig.axes[:3]:  # the fourth is empty
        assert ax.get_xlim()[0] < tips[:, 0].min() < tips[:, 0].max() < ax.get_xlim()[1]
        assert ax.get_ylim()[0] < tips[:, 1].min() < tips[:, 1].max() < ax.get_ylim()[1]
        (bar,) = [line for line in ax.lines if line.get_marker() == "|"]
        assert ax.get_ylim()[0] < bar.get_ydata()[0] < tips[:, 1].min()


def test_residuals_have_one_scale_a_photo_an_axes_and_given_names():
    adjusted = result(photos=5)
    adjusted.network.photo_names = tuple("abcde")
    fig = plot.bundle.residual_vectors(adjusted, photo=[3, 1])
    titles = [head(ax) for ax in fig.axes]
    assert [title.split(":")[0] for title in titles] == ["photo d", "photo b"]
    assert fig.axes[0].get_xlim() == fig.axes[1].get_xlim()
    assert len(plot.bundle.residual_vectors(adjusted, photo=2).axes) == 1


def test_of_many_photos_those_with_the_largest_residuals_are_shown():
    adjusted = result(photos=20, per_photo=4)
    adjusted.residuals[:] = 1e-4
    adjusted.residuals[adjusted.network.photo > 3] = 2e-4
    fig = plot.bundle.residual_vectors(adjusted)
    assert len(fig.axes) == 16
    assert head(fig.axes[0]) == "photo 5: 0.20 µm"
    assert "the 16 of 20 photos with the largest" in fig.get_suptitle()


def test_photo_without_observations_cannot_be_drawn():
    adjusted = result()
    adjusted.network.photo[adjusted.network.photo == 1] = 0
    with pytest.raises(ValueError, match=r"photo\[0\] has no observations"):
        plot.bundle.residual_vectors(adjusted, photo=1)


def test_histogram_counts_all_and_lists_outliers_the_largest_first():
    adjusted = result(photos=9, per_photo=30)
    adjusted.standardized[:] = np.clip(adjusted.standardized, -3, 3)
    adjusted.standardized[35, 0] = 4.14  # photo 2, point 6
    adjusted.standardized[60, 1] = -7.2  # photo 3, point 1
    (ax,) = plot.bundle.standardized_histogram(adjusted).axes
    assert sum(bar.get_height() for bar in ax.patches) == 540
    edges = np.array([bar.get_x() for bar in ax.patches])
    counts = [bar.get_height() for bar in ax.patches]
    expected = np.histogram(adjusted.standardized, np.append(edges, edges[-1] + 0.25))
    np.testing.assert_array_equal(counts, expected[0])
    lines = ax.texts[0].get_text().splitlines()
    assert lines[0] == "2 of 540 beyond ±3.13"  # tau of redundancy 40
    assert lines[1] == "(0.5 expected by chance)"
    assert lines[2:] == ["photo 3, point 1: y −7.2", "photo 2, point 6: x +4.1"]
    np.testing.assert_allclose(np.sort(ax.lines[-1].get_xdata()), (-7.2, 4.14))
    assert ax.get_xlabel() == "standardised residual, Pope's τ (no unit)"


def test_histogram_says_which_test_it_shows_and_takes_its_limit_and_its_curve():
    adjusted = result(redundancy=6)  # few: tau differs much from w
    adjusted.standardized[:] = np.clip(adjusted.standardized, -2, 2)
    adjusted.standardized[3, 0] = 2.4
    (ax,) = plot.bundle.standardized_histogram(adjusted).axes
    assert ax.texts[0].get_text().startswith("1 of 72 beyond ±2.33")
    x, y = ax.lines[0].get_data()
    x, y = x[x != 0], y[x != 0]  # tau^2 / 6 follows beta(1/2, 5/2)
    density = np.abs(x) / 6 * beta(0.5, 2.5).pdf(np.minimum(x**2 / 6, 1))
    np.testing.assert_allclose(y, 72 * 0.25 * density, rtol=1e-9, atol=1e-12)
    assert ax.lines[0].get_label() == "distribution of τ"
    shown = adjusted.standardized
    adjusted = result(redundancy=6, residual_test="w", standardized=shown)
    (ax,) = plot.bundle.standardized_histogram(adjusted).axes
    assert ax.texts[0].get_text().startswith("0 of 72 beyond ±3.29")
    assert ax.get_xlabel() == "standardised residual, Baarda's w (no unit)"
    x, y = ax.lines[0].get_data()
    np.testing.assert_allclose(y, 72 * 0.25 * norm.pdf(x), rtol=1e-12)
    chance = f"({144 * norm.sf(2.5):.1f} expected by chance)"
    (ax,) = plot.bundle.standardized_histogram(adjusted, critical=2.5).axes
    assert ax.texts[0].get_text().splitlines()[1] == chance


def test_red_residuals_are_beyond_the_limit_of_their_own_test():
    adjusted = result(redundancy=6)
    adjusted.standardized[:] = np.clip(adjusted.standardized, -2, 2)
    adjusted.standardized[17] = (0.1, -2.4)  # beyond 2.33 of tau, not 3.29 of w
    fig = plot.bundle.residual_vectors(adjusted)
    assert fig.get_suptitle().endswith("; red: |τ| > 2.33")
    shown = adjusted.standardized
    adjusted = result(redundancy=6, residual_test="w", standardized=shown)
    assert "red" not in plot.bundle.residual_vectors(adjusted).get_suptitle()
    fig = plot.bundle.residual_vectors(adjusted, critical=2.35)
    assert fig.get_suptitle().endswith("; red: |w| > 2.35")


@pytest.mark.parametrize("bad", [0, 1, -0.5, 95, np.nan])
def test_a_band_without_a_probability_is_refused(bad):
    with pytest.raises(ValueError, match="confidence"):
        plot.bundle.lens_curve(result(), confidence=bad)


def test_normal_curve_holds_as_many_residuals_as_the_histogram():
    (ax,) = plot.bundle.standardized_histogram(result()).axes
    curve = next(line for line in ax.lines if len(line.get_xdata()) > 100)
    x, y = curve.get_data()
    # 72 residuals in steps of 0.25; the tails beyond 3.5 hold 0.05 % of them
    assert np.trapezoid(y, x) == pytest.approx(72 * 0.25, rel=2e-3)


def test_histogram_without_outliers_says_so():
    adjusted = result()
    adjusted.standardized[:] = np.clip(adjusted.standardized, -3, 3)
    (ax,) = plot.bundle.standardized_histogram(adjusted).axes
    assert ax.texts[0].get_text().startswith("0 of 72 beyond")


def texts(ax):
    return {tuple(map(int, text.get_position())): text.get_text() for text in ax.texts}


def test_correlations_stand_in_their_cells_once():
    adjusted = result()
    left, right = ch06_case_figures.correlation_matrix(adjusted).axes
    found = texts(left)
    assert len(found) == 45
    for (column, row), text in found.items():
        assert column < row
        value = float(text.replace("−", "-"))
        assert value == pytest.approx(adjusted.correlation[row, column], abs=0.0051)
    assert [tick.get_text() for tick in left.get_yticklabels()][:2] == ["$c$", "$x_0$"]
    outer = np.abs(adjusted.correlation[:10, 10:]).reshape(10, 3, 6).mean(axis=1)
    for (column, row), text in texts(right).items():
        assert float(text) == pytest.approx(outer[row, column], abs=0.0051)
    assert len(texts(right)) == 60


def test_correlations_of_a_camera_are_with_its_own_photos():
    adjusted = result((LENS, LENS), photos=4, estimate=("c", "K1"))
    _, right = ch06_case_figures.correlation_matrix(adjusted, camera=1).axes
    outer = np.abs(adjusted.correlation[2:4, 4:]).reshape(2, 4, 6)[:, [1, 3]]
    expected = outer.mean(axis=1)[1, 5]
    assert float(texts(right)[5, 1]) == pytest.approx(expected, abs=0.0051)


def test_no_correlation_is_written_minus_zero():
    adjusted = result()
    adjusted.correlation[2, 1] = -0.001
    left, _ = ch06_case_figures.correlation_matrix(adjusted).axes
    assert texts(left)[1, 2] == "0.00"


@pytest.mark.parametrize(
    ("value", "expected"), [(1, 1), (1.99, 1), (2, 2), (4999, 2000), (0.07, 0.05)]
)
def test_round_numbers_do_not_exceed_the_value(value, expected):
    assert _rounding.round_number(value) == pytest.approx(expected)


def test_names_of_parameters_become_formulas():
    assert _style.symbol("c, x0") == "$c$, $x_0$"
    assert _style.symbol("omega and Z0") == r"$\omega$ and $Z_0$"
    assert _style.symbol("without rolls") == "without rolls"
