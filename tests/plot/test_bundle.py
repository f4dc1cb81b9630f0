"""Figures of a bundle adjustment show its numbers; looks, a person must judge."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from scipy.stats import t

from pgm_lab import _rounding, bundle, plot
from pgm_lab.camera import PARAMETERS, Camera
from tests.networks import real
from tests.stand_in import stand_in

LENS = Camera(30.0, 0.2, -0.1, 2e-5, -3e-7, 2e-9, 3e-6, -4e-6)
pytestmark = pytest.mark.usefixtures("closed")


def result(cameras=(LENS,), photos=3, per_photo=12, **other):
    """What `bundle.adjust` returns, as far as it is drawn, with random numbers."""
    rng = np.random.default_rng(1)
    k, u = photos * per_photo, len(PARAMETERS) * len(cameras)
    root = 0.1 * rng.normal(size=(u, u))
    root *= np.tile(np.abs(LENS.interior) + 1e-6, len(cameras))[:, None]
    covariance = root @ root.T
    v = 3e-4 * rng.normal(size=(k, 2))
    whole = dict(
        network=SimpleNamespace(
            photo=np.repeat(np.arange(photos), per_photo),
            point=np.tile(np.arange(per_photo), photos),
            xy=rng.uniform(-9, 9, (k, 2)),
            camera=np.arange(photos) % len(cameras),
            photo_names=range(1, photos + 1),
            point_names=range(1, per_photo + 1),
        ),
        cameras=cameras,
        exteriors=np.zeros((photos, 6)),
        unknowns=tuple(
            bundle.Unknown("camera", i + 1, name)
            for i in range(len(cameras))
            for name in PARAMETERS
        ),
        interior_names=PARAMETERS * len(cameras),
        covariance_interior=covariance,
        sd_interior=np.sqrt(np.diag(covariance)),
        residuals=v,
        standardized=np.clip(v / 3e-4, -2, 2),
        redundancy=40,
        residual_test="tau",
    )
    return stand_in(bundle.Bundle, **whole | other)


def head(ax):
    return ax.get_title(loc="left") or ax.get_title()  # wherever the style puts it


def test_figures_of_a_real_adjustment():
    nine_photos = bundle.adjust(real())
    _, below = plot.bundle.lens_curve(nine_photos).axes
    r, half = below.lines[0].get_data()
    assert np.all(np.diff(half[r > 2]) > 0)
    # K1 alone, as if it were not correlated, would say three times as much
    edge = np.searchsorted(r, 10.0)
    assert half[edge] < 1e3 * 1.96 * nine_photos.sd_interior[3] * 10**3
    fig = plot.bundle.residual_vectors(nine_photos)
    assert [head(ax).split(":")[0] for ax in fig.axes] == [
        f"photo {i}" for i in range(1, 10)
    ]


def test_lens_curve_draws_profile_and_band_in_micrometres():
    adjusted = result()
    above, below = plot.bundle.lens_curve(adjusted).axes
    r, drawn = above.lines[0].get_data()
    value, sd = bundle.lens.profile(adjusted, r)
    np.testing.assert_allclose(drawn, 1e3 * value)
    half = 1e3 * t.ppf(0.975, 40) * sd
    band = above.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx((1e3 * value + half).max())
    assert band[:, 1].min() == pytest.approx((1e3 * value - half).min())
    np.testing.assert_allclose(below.lines[0].get_ydata(), half)
    assert below.get_ylim()[0] == 0
    assert above.get_ylabel() == "correction (µm)"
    assert below.get_xlabel() == "distance from the principal point (mm)"
    assert "95 %" in head(above)


def arrows(ax):
    """Start, vector and colour of all that is drawn in an axes."""
    return [
        (q.XY, np.column_stack([q.U, q.V]), to_hex(q.get_facecolor()[0]))
        for q in ax.collections
        if q.N
    ]


def test_residuals_stand_at_their_points_enlarged_and_outliers_are_named():
    adjusted = result()
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
    assert "enlarged 5,000 times" in fig.get_suptitle()
    rms = 1e3 * np.sqrt(np.mean(adjusted.residuals[here] ** 2))
    assert head(ax) == f"photo 2: {rms:.2f} µm"


def test_red_residuals_are_beyond_the_limit_of_their_own_test():
    adjusted = result(redundancy=6)  # few: tau differs much from w
    adjusted.standardized[17] = (0.1, -2.4)  # beyond 2.33 of tau, not 3.29 of w
    fig = plot.bundle.residual_vectors(adjusted)
    assert fig.get_suptitle().endswith("; red: |τ| > 2.33")
    shown = adjusted.standardized
    adjusted = result(redundancy=6, residual_test="w", standardized=shown)
    assert "red" not in plot.bundle.residual_vectors(adjusted).get_suptitle()
    adjusted.standardized[17] = (0.1, -3.3)
    fig = plot.bundle.residual_vectors(adjusted)
    assert fig.get_suptitle().endswith("; red: |w| > 3.29")


@pytest.mark.parametrize(
    ("value", "expected"), [(1, 1), (1.99, 1), (2, 2), (4999, 2000), (0.07, 0.05)]
)
def test_round_numbers_do_not_exceed_the_value(value, expected):
    assert _rounding.round_number(value) == pytest.approx(expected)


def test_names_of_parameters_become_formulas():
    assert plot.bundle.symbol("c, x0") == "$c$, $x_0$"
    assert plot.bundle.symbol("omega and Z0") == r"$\omega$ and $Z_0$"
    assert plot.bundle.symbol("without rolls") == "without rolls"
