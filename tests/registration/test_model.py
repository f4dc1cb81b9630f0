"""A model of all shifts: against other programs, samples, known truth, and blunders."""

import numpy as np
import pytest
from scipy.stats import chi2, norm
from skimage.transform import estimate_transform

from pgm_lab.registration import Registration, fit

CENTRE = np.array([500.0, 400])
TRUTH = {
    "shift": (0.3, -0.2),
    "affine": (0.3, 1e-3, -5e-4, -0.2, 5e-4, 1e-3),
}
CORNERS = np.array([(0.0, 0), (1000, 0), (0, 800), (1000, 800)])


def shift_at(kind, points):
    """The true shift of points (n, 2)."""
    a, b = np.reshape(TRUTH[kind], (2, -1))
    f = np.concatenate([np.ones((len(points), 1)), points - CENTRE], axis=1)
    return f[:, : len(a)] @ np.stack([a, b], axis=1)


def registration(points, shifts, covariance):
    n = len(points)
    r = np.full(n, 0.9), np.full(n, 0.1)
    status = np.full(n, "accepted", "<U40")
    return Registration(points, *shifts.T.copy(), *r, covariance, status)


def scene(kind="affine", n=100, sd=0.03, scale=1.0, seed=0):
    """Shifts with errors of known covariance, `scale` times as large as predicted."""
    random = np.random.default_rng(seed)
    points = random.uniform(0, (1000, 800), (n, 2))
    angle = random.uniform(0, np.pi, n)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    axes = np.moveaxis(turn, 2, 0) * (sd * random.uniform(0.3, 1.5, (n, 1, 2)))
    errors = np.einsum("nij,nj->ni", axes, scale * random.normal(size=(n, 2)))
    covariance = axes @ np.swapaxes(axes, 1, 2)
    return registration(points, shift_at(kind, points) + errors, covariance)


def with_blunders(found, share, where, what, seed=0):
    """A copy with some shifts replaced, and which they are."""
    random = np.random.default_rng(seed)
    n = len(found.points)
    k = int(share * n)
    order = np.argsort(found.points.sum(axis=1))  # from one corner on
    bad = order[:k] if where == "corner" else random.choice(n, k, replace=False)
    shifts = np.stack([found.dx, found.dy], axis=1)
    shifts[bad] = (2.0, -3.0) if what == "alike" else random.uniform(-3, 3, (k, 2))
    return registration(found.points, shifts, found.covariance), bad


def error_at_corners(model, kind):
    true = CORNERS + shift_at(kind, CORNERS)
    return np.abs(model.apply(CORNERS) - true).max()


@pytest.mark.parametrize("kind", TRUTH)
def test_without_blunders_it_is_weighted_least_squares(kind):
    """numpy.linalg.lstsq on the same equations, whitened another way."""
    found = scene(kind)
    model = fit(found, kind)
    assert model.used.all()
    n = len(found.points)
    f = np.ones((n, 1))
    if kind == "affine":
        f = np.concatenate([f, found.points - found.points.mean(axis=0)], axis=1)
    A = np.einsum("ij,nk->nijk", np.eye(2), f).reshape(n, 2, -1)
    values, vectors = np.linalg.eigh(found.covariance)
    whiten = np.swapaxes(vectors, 1, 2) / np.sqrt(values)[..., None]
    l = np.einsum("nij,nj->ni", whiten, np.stack([found.dx, found.dy], 1))  # noqa: E741
    x, squares, _, _ = np.linalg.lstsq((whiten @ A).reshape(2 * n, -1), l.ravel())
    assert model.parameters == pytest.approx(x, rel=1e-8, abs=1e-12)
    assert model.redundancy == 2 * n - len(x)
    assert model.sigma0**2 == pytest.approx(squares[0] / model.redundancy)


@pytest.mark.parametrize("kind", TRUTH)
def test_exact_shifts_give_the_truth_and_the_offset_is_added_once(kind):
    """The affine transformation of skimage takes errors of both images into account."""
    found = scene(kind, scale=0.0)
    plain, model = fit(found, kind), fit(found, kind, offset=(7.5, -3))
    assert error_at_corners(plain, kind) < 1e-9
    places = plain.apply(CORNERS) + (7.5, -3)
    assert model.apply(CORNERS) == pytest.approx(places, abs=1e-9)
    by_matrix = CORNERS @ model.matrix[:, :2].T + model.matrix[:, 2]
    assert by_matrix == pytest.approx(places, abs=1e-9)
    if kind == "affine":
        there = found.points + np.stack([found.dx, found.dy], axis=1)
        other = estimate_transform("affine", found.points, there)
        assert plain.matrix == pytest.approx(other.params[:2], abs=1e-9)


@pytest.mark.parametrize("kind", TRUTH)
@pytest.mark.parametrize("scale", [1.0, 4.0])
@pytest.mark.parametrize("samples", [80, pytest.param(400, marks=pytest.mark.slow)])
def test_the_covariance_is_that_of_repeated_samples(kind, scale, samples):
    """Each standard deviation, and all together, to three of their own.

    Leaving out one good point in 1000 makes sigma0 smaller by 0.4 per cent.
    """
    models = [fit(scene(kind, 60, scale=scale, seed=s), kind) for s in range(samples)]
    # Points differ from sample to sample: errors over their own standard deviations
    true = [
        np.linalg.solve(
            np.linalg.cholesky(m.covariance), m.parameters - truth_of(m, kind)
        )
        for m in models
    ]
    for variance, n in (
        (np.var(true, axis=0, ddof=1), samples - 1),
        (np.mean(np.square(true)), np.size(true)),
    ):
        low, high = chi2.ppf(norm.cdf([-3, 3]), n) / n
        assert np.all((low < variance) & (variance < high))
    sigma0 = np.sqrt(np.mean([m.sigma0**2 for m in models]))
    few = 3 / np.sqrt(2 * samples * models[0].redundancy)
    assert sigma0 == pytest.approx(scale, rel=0.004 + few)


def truth_of(model, kind):
    """True parameters, counted from the model's own centre."""
    if kind == "shift":
        return TRUTH[kind]
    a0, b0 = shift_at(kind, model.centre[None])[0]
    return (a0, *TRUTH[kind][1:3], b0, *TRUTH[kind][4:])


@pytest.mark.parametrize("what", ["anything", "alike"])
@pytest.mark.parametrize("where", ["anywhere", "corner"])
@pytest.mark.parametrize("kind", TRUTH)
def test_forty_per_cent_of_blunders_do_no_harm(kind, where, what):
    """Three standard deviations of the largest of eight numbers, each 0.01 px."""
    for seed in range(5):
        found, bad = with_blunders(scene(kind, seed=seed), 0.4, where, what, seed)
        model = fit(found, kind)
        far = np.hypot(*model.residuals.T) > 0.3  # ten predicted standard deviations
        assert not model.used[bad][far[bad]].any()
        assert np.sum(model.used) >= 0.97 * (100 - len(bad))
        assert error_at_corners(model, kind) < (0.02 if kind == "shift" else 0.06)
        assert model.sigma0 == pytest.approx(1, abs=0.25)
        assert np.isfinite(model.residuals).all()
        assert model.redundancy == 2 * model.used.sum() - len(model.parameters)


def test_predicted_deviations_that_are_too_small_cost_no_points():
    """As with alias: all errors ten times what is predicted, and no blunder."""
    model = fit(scene(n=300, scale=10.0), "affine")
    assert model.sigma0 == pytest.approx(10, rel=0.1)
    assert model.used.mean() > 0.99


def test_few_points_within_their_predicted_deviations_are_all_kept():
    for seed in range(50):
        assert fit(scene(n=5, seed=seed), "affine").used.sum() >= 4


def test_what_was_not_accepted_does_not_count():
    found = scene()
    for one in (found.dx, found.dy, found.covariance):
        one[::2] = np.nan
    found.status[::2] = "ambiguous"
    model = fit(found, "affine")
    assert not model.used[::2].any() and model.used[1::2].all()
    assert np.isnan(model.residuals[::2]).all()


@pytest.mark.parametrize("kind, fewest", [("shift", 2), ("affine", 4)])
def test_one_point_more_than_parameters_need_is_enough(kind, fewest):
    assert fit(scene(kind, fewest), kind).redundancy == 2
    few = rf"{fewest - 1} of {fewest - 1} points .* at least {fewest},.*found.status"
    with pytest.raises(ValueError, match=few):
        fit(scene(kind, fewest - 1), kind)


def on_a_line(*beside):
    """Points on one line, but for some beside it, whose shifts are anything."""
    found = scene("shift")
    found.points[:, 1] = 0.3 * found.points[:, 0] + 20
    for i, (place, shift) in enumerate(beside):
        found.points[i] = place
        found.dx[i], found.dy[i] = shift
    return found


def test_points_on_one_line_leave_an_affine_open():
    assert fit(on_a_line()).used.all()
    with pytest.raises(ValueError, match="lie on one line.*'shift'"):
        fit(on_a_line(), "affine")
    # Whatever the shift of a point beside it is, the transformation takes it over
    beside = ((100, 700), (3, 3)), ((900, 600), (-3, 1))
    for n in (1, 2):
        with pytest.raises(ValueError, match="alone determines a part of the affine"):
            fit(on_a_line(*beside[:n]), "affine")


def test_equal_whole_shifts_have_no_residuals_and_no_warning():
    found = scene("shift")
    found.dx[:], found.dy[:] = 1.0, -2.0
    model = fit(found)
    assert model.sigma0 == 0 and model.parameters == pytest.approx((1, -2))
