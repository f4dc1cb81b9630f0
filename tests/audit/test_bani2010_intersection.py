"""Proofs of the verdicts on the space intersection of Bani 2010, appendix B.

One reading of the printed inputs gives all printed numbers to all digits: angles in
degrees, the two triplets of the right photo exchanged, f negative in A and L, photo
coordinates with six decimals (chapter 1), start values where the rays meet in X and Y,
all ten points, three Gauss-Newton steps.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from pgm_lab import datasets, frames, rotation
from pgm_lab.camera import collinearity

PIXEL = 0.01219  # mm


def printed(name):
    """A printed matrix and the half of its last digit; zeros stand for rounded ones."""
    matrix = datasets.bani2010_intersection()[name]
    texts = [
        row["value"]
        for row in datasets.rows("bani2010_intersection.csv")
        if row["quantity"] == name
    ]
    digits = [len(text.partition(".")[2]) for text in texts]
    digits = [4 if text == "0" else n for text, n in zip(texts, digits)]
    half = 0.5 * 10.0 ** -np.array(digits) * (1 + 1e-6)
    return matrix, half.reshape(matrix.shape)


def assert_printed(computed, name):
    matrix, half = printed(name)
    assert np.all(np.abs(computed - matrix) <= half), f"{name}: {computed - matrix}"


def exteriors(unit="radians", exchanged=False):
    """The printed orientations (2, 6), as one reads them."""
    left, right = datasets.bani2010_intersection()["exterior"]
    if exchanged:
        right = np.roll(right, 3)
    both = np.array([left, right])
    if unit == "degrees":
        both[:, 3:] = np.radians(both[:, 3:])
    return both


def photo_six_decimals():
    """The photo coordinates behind Tables 4.1 and 4.2 (2, 10, 2), in mm."""
    data = datasets.bani2010()
    size = frames.pixel_size_from_sensor(data.sensor_size, data.image_size)
    # (2.5), which the tables follow: y with the rows
    return np.round((data.pixels - frames.image_centre(data.image_size)) * size, 6)


def camera(c=18.5558, x0=0.0, y0=0.0, K1=0.0):
    return np.array([c, x0, y0, K1, 0, 0, 0, 0, 0, 0])


def start(exterior, photo, f=18.5558):
    """Where the rays (x, y, +f) meet in X and Y: Harintaka 2020 (4), (5)."""
    vectors = np.concatenate([photo, np.full((2, 10, 1), f)], axis=2)
    left, right = vectors @ rotation.matrix(*exterior.T[3:])
    bx, by, _ = exterior[1, :3] - exterior[0, :3]
    scale = (by * left[:, 0] - bx * left[:, 1]) / (
        left[:, 1] * right[:, 0] - left[:, 0] * right[:, 1]
    )
    return exterior[1, :3] + scale[:, None] * right


def step(exterior, photo, points, c=-18.5558):
    """One Gauss-Newton step of each point: A (n, 4, 3), L, X, V."""
    result = collinearity(camera(c), exterior[:, None], points, photo, wrt="point")
    A = np.moveaxis(result.point, 0, 1).reshape(-1, 4, 3)
    L = -np.moveaxis(result.v, 0, 1).reshape(-1, 4, 1)
    # As (A'A)^-1 A'L, but bearable for points that have run away
    X = np.linalg.pinv(A) @ L
    V = A @ X - L
    return SimpleNamespace(A=A, L=L[..., 0], X=X[..., 0], V=V[..., 0], before=points)


def steps(exterior, photo, n, c=-18.5558):
    points, done = start(exterior, photo), []
    for _ in range(n):
        done.append(step(exterior, photo, points, c))
        points = points + done[-1].X
    return done


@pytest.fixture(scope="module")
def published():
    return exteriors("degrees", exchanged=True)


@pytest.fixture(scope="module")
def iterations(published):
    return steps(published, photo_six_decimals(), 5)


@pytest.fixture(scope="module")
def third(iterations):
    return iterations[2]


def sigma0(V):
    """All points together: four observations and three unknowns each."""
    return np.sqrt(np.sum(V**2) / len(V))


def design(third):
    """A (8, 6) of points 1 and 2."""
    A = np.zeros((8, 6))
    A[:4, :3], A[4:, 3:] = third.A[:2]
    return A


def test_m_left_is_what_the_angles_give_in_degrees():
    assert_printed(rotation.matrix(*exteriors("degrees")[0, 3:]), "M_left")
    in_radians = rotation.matrix(*exteriors()[0, 3:])
    assert np.abs(in_radians - printed("M_left")[0]).max() > 0.5


def test_m_right_is_what_the_coordinates_of_the_station_give_in_degrees(published):
    assert_printed(rotation.matrix(*published[1, 3:]), "M_right")
    for other in (exteriors("degrees"), exteriors(), exteriors(exchanged=True)):
        wrong = np.abs(rotation.matrix(*other[1, 3:]) - printed("M_right")[0])
        assert wrong.max() > 0.04


def test_m_left_was_not_computed_with_m12_as_printed_in_3():
    omega, _, kappa = exteriors("degrees")[0, 3:]
    as_printed = np.sin(omega) * np.cos(kappa) + np.cos(omega) * np.sin(kappa)
    assert abs(as_printed - printed("M_left")[0][0, 1]) > 0.005


def test_rqs_follow_from_4_before_the_third_step(published, third):
    for exterior, name in zip(published, ("rqs_left", "rqs_right")):
        M = rotation.matrix(*exterior[3:])
        r, s, q = M @ (third.before[:2] - exterior[:3]).T
        assert_printed(np.column_stack([r, q, s]), name)


def test_start_values_are_the_points_where_the_rays_meet_in_x_and_y(
    published, iterations
):
    # Known to five digits from the printed r, q, s and steps; any other of the usual
    # ways to start ends elsewhere after the third step
    adjusted = iterations[2].before[:2] + iterations[2].X[:2]
    assert_printed(adjusted, "adjusted")
    photo = photo_six_decimals()
    for other in (photo[0], photo[1]):
        for z in (-18.5558, 18.5558):
            points = np.column_stack([other, np.full(10, z)])
            for _ in range(3):
                done = step(published, photo, points)
                points = points + done.X
            assert np.abs(points[1] - adjusted[1]).max() > 1


def test_a_follows_with_f_negative(published, third):
    assert_printed(design(third).T, "A_transposed")
    positive = step(published, photo_six_decimals(), third.before, c=18.5558)
    assert_printed(-design(positive).T, "A_transposed")


def test_l_follows_with_f_negative_and_not_with_f_positive(published, third):
    assert_printed(third.L[:2].reshape(8, 1), "L")
    positive = step(published, photo_six_decimals(), third.before, c=18.5558)
    assert np.abs(positive.L[:2].reshape(8, 1) - printed("L")[0]).max() > 10


def test_normal_matrix_and_its_inverse_follow_from_a(third):
    normal = design(third).T @ design(third)
    assert_printed(normal, "normal")
    assert_printed(np.linalg.inv(normal), "normal_inverse")
    # The printed four decimals of A'A are not enough for its inverse
    rounded = np.linalg.inv(printed("normal")[0])
    assert np.abs(rounded - printed("normal_inverse")[0]).max() > 0.7


def test_x_is_the_third_step_with_its_last_number_in_the_next_table(third):
    assert_printed(third.X[:2].reshape(6, 1)[:5], "X")
    assert_printed(third.X[:2], "delta")


def test_ax_and_v_follow(third):
    AX = np.einsum("nij,nj->ni", third.A[:2], third.X[:2])
    assert_printed(AX.reshape(8, 1), "AX")
    assert_printed(third.V[:2].reshape(8, 1), "V")


def test_s0_is_that_of_all_ten_points_in_the_third_step(iterations):
    # 40 observations, 30 unknowns: redundancy 10
    assert_printed(sigma0(iterations[2].V), "S0")
    others = [sigma0(iterations[k].V) for k in (0, 1, 3, 4)]
    np.testing.assert_allclose(others, (1.5314, 1.5207, 1.5139, 1.5361), atol=5e-5)


def test_s0_does_not_follow_from_the_two_points_whose_v_is_printed(third):
    # 8 observations, 6 unknowns
    two = np.sqrt(np.sum(printed("V")[0] ** 2) / 2)
    np.testing.assert_allclose(two, 1.6067, atol=5e-5)
    # Nor from V of any one point, or of the first n points but all ten
    for n in range(1, 10):
        assert abs(sigma0(third.V[:n]) - printed("S0")[0][0, 0]) > 0.03


def test_s0_needs_the_photo_coordinates_with_six_decimals(published):
    # Table 4.2 has five: S0 then differs in its seventh digit
    third = steps(published, datasets.bani2010().photo, 3)[2]
    assert 2e-7 < abs(sigma0(third.V) - printed("S0")[0][0, 0]) < 6e-7


def test_three_points_run_away_and_the_published_values_are_on_their_way(iterations):
    heights = np.array([done.before[[0, 1, 4, 9], 2] for done in iterations])
    expected = [
        (-3.297, -4.308, -4.517, -4.470, -4.469),
        (-3.268, -7.240, -18.29, -61.55, -407.6),
        (5.492, 11.54, 25.60, 64.32, 214.1),
    ]
    np.testing.assert_allclose(heights.T[[0, 1, 3]], expected, rtol=1e-3)
    # Point 5 starts far off: its rays are nearly parallel in X and Y
    assert np.all(heights[1:3, 2] < -1e4)


def converged(exterior, interior=(), free_right=(), c=18.5558, photo=None):
    """Adjust the points with parameters of the camera or elements of the right photo.

    Returns RMS and sigma0 of the residuals, the estimates and standard deviations.
    """
    photo = photo_six_decimals() if photo is None else photo
    n, k = len(interior), len(free_right)

    def misclosure(unknown):
        now = camera(**({"c": c} | dict(zip(interior, unknown[:n]))))
        both = exterior.copy()
        both[1, list(free_right)] += unknown[n : n + k]
        points = unknown[n + k :].reshape(10, 3)
        return collinearity(now, both[:, None], points, photo, wrt=())

    first = [c if name == "c" else 0.0 for name in interior] + [0.0] * k
    first = np.concatenate([first, nearest_to_both_rays(exterior, photo, c).ravel()])
    found = least_squares(
        lambda unknown: misclosure(unknown).v.ravel(),
        first,
        x_scale="jac",
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    s0 = np.sqrt(2 * found.cost / (40 - len(first)))
    sd = s0 * np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)))
    return SimpleNamespace(
        rms=np.sqrt(np.mean(found.fun**2)),
        sigma0=s0,
        values=found.x[: n + k],
        sd=sd[: n + k],
        points=found.x[n + k :].reshape(10, 3),
        in_front=np.all(misclosure(found.x).depth > 0),
    )


def nearest_to_both_rays(exterior, photo, c):
    vectors = np.concatenate([photo, np.full((2, 10, 1), -c)], axis=2)
    rays = vectors @ rotation.matrix(*exterior.T[3:])
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    across = np.eye(3) - rays[..., None] * rays[..., None, :]
    right = np.einsum("pnij,pj->ni", across, exterior[:, :3])
    return np.linalg.solve(across.sum(axis=0), right[..., None])[..., 0]


def test_angles_are_radians_and_each_triplet_stands_in_its_columns(published):
    read = converged(exteriors())
    assert read.in_front
    np.testing.assert_allclose(read.rms, 0.02554, atol=5e-6)
    for other in (
        published,
        exteriors("degrees"),
        exteriors(exchanged=True),
    ):
        found = converged(other)
        assert found.rms > 20 * read.rms and not found.in_front


def test_f_is_positive_for_the_printed_orientation():
    read = converged(exteriors())
    negative = converged(exteriors(), c=-18.5558)
    assert negative.rms > 15 * read.rms


def test_y_of_table_4_2_agrees_with_the_printed_orientation():
    turned_round = converged(exteriors(), photo=photo_six_decimals() * (1, -1))
    assert turned_round.rms > 30 * converged(exteriors()).rms


def test_adjusted_coordinates_are_not_the_points_of_the_object(third):
    points = converged(exteriors(), interior=("x0", "y0", "K1")).points
    np.testing.assert_allclose(points[0], (-2.803, -0.841, -1.736), atol=2e-3)
    adjusted = printed("adjusted")[0]
    assert np.linalg.norm(adjusted - points[:2], axis=1).min() > 4


def test_right_orientation_adjusted_leaves_a_sixth_of_a_pixel():
    # Relative orientation: the base component X is held, 40 - 30 - 5 redundancies
    found = converged(exteriors(), free_right=(1, 2, 3, 4, 5))
    np.testing.assert_allclose(found.rms, 0.00065, atol=5e-6)
    np.testing.assert_allclose(found.sigma0, 0.00184, atol=5e-6)
    degrees, sd = np.degrees(found.values[2:]), np.degrees(found.sd[2:])
    np.testing.assert_allclose(degrees, (-0.87, -0.21, -1.05), atol=0.005)
    assert np.all(np.abs(degrees) > 2 * sd) and abs(degrees[2]) > 25 * sd[2]


def test_principal_point_and_k1_fit_better_than_five_elements_of_orientation():
    found = converged(exteriors(), interior=("x0", "y0", "K1"))
    np.testing.assert_allclose(found.rms, 0.000228, atol=1e-6)
    np.testing.assert_allclose(found.sigma0, 0.000544, atol=1e-6)
    assert found.sigma0 / PIXEL < 0.05
    np.testing.assert_allclose(found.values, (0.247, 0.069, 2.53e-4), atol=5e-4)
    assert np.all(found.values > 15 * found.sd)
    assert found.sigma0 < converged(exteriors(), free_right=(1, 2, 3, 4, 5)).sigma0 / 3
    # Two unknowns are enough to fall from 0.0255 to 0.0014 mm
    assert converged(exteriors(), interior=("x0", "y0")).rms < 0.0014


def test_principal_distance_follows_from_the_ten_points():
    # Nothing in the data knows the printed 18.5558 but the camera itself
    found = converged(exteriors(), interior=("c", "x0", "y0", "K1"))
    np.testing.assert_allclose(found.values[0], 18.559, atol=5e-4)
    np.testing.assert_allclose(found.sd[0], 0.025, atol=5e-4)
    assert abs(found.values[0] - 18.5558) < found.sd[0]


def test_rounded_orientation_does_not_explain_the_residuals():
    # Four decimals move a ray by 1.3 micrometres at most; RMS over all 0.05
    exact = converged(exteriors()).rms
    rng = np.random.default_rng(5)
    for _ in range(5):
        rounded = exteriors() + rng.uniform(-5e-5, 5e-5, (2, 6))
        assert abs(converged(rounded).rms - exact) < 0.0004
