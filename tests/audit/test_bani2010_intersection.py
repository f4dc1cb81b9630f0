"""Proofs of the verdicts on the space intersection of Bani 2010, appendix B.

One reading of the printed inputs gives all printed numbers to all digits: angles in
degrees, the two triplets of the right photo exchanged, f negative throughout, photo
coordinates with six decimals (chapter 1), start values where the rays meet in X and Y,
all ten points, three Gauss-Newton steps. Printed are the inputs; the start was found by
search.
"""

import functools
import itertools
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from pgm_book.ch05.studies import parameters as intersection_parameters
from pgm_lab import datasets, frames, rotation
from pgm_lab.camera import PARAMETERS, collinearity

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


def meeting(exterior, photo, z=18.5558, axes=(0, 1), transposed=False):
    """Where the rays (x, y, z) meet in the given axes: on the left, on the right ray.

    In all three they do not meet; the points are then the nearest to the other ray.
    """
    vectors = np.concatenate([photo, np.full((*photo.shape[:2], 1), z)], axis=2)
    M = rotation.matrix(*exterior.T[3:])
    rays = vectors @ (np.swapaxes(M, 1, 2) if transposed else M)
    base = exterior[1, :3] - exterior[0, :3]
    both = np.stack([rays[0], -rays[1]], axis=-1)[:, axes]
    scales = np.linalg.pinv(both) @ base[list(axes)]
    return exterior[:, None, :3] + scales.T[..., None] * rays


def step(exterior, photo, points, c=-18.5558):
    """One Gauss-Newton step of each point: A (n, 4, 3), L, X, V."""
    result = collinearity(camera(c), exterior[:, None], points, photo, wrt="point")
    A = np.moveaxis(result.point, 0, 1).reshape(-1, 4, 3)
    L = -np.moveaxis(result.v, 0, 1).reshape(-1, 4, 1)
    # (6) in better axes: x and y of the left photo, and the left ray, along which the
    # left photo sees no change and the right one sees the base alone. However far a
    # point has run away, these three columns stay well conditioned
    M = rotation.matrix(*exterior.T[3:])
    ray = points - exterior[0, :3]
    axes = np.stack([*np.broadcast_to(M[0, :2, None], (2, *ray.shape)), ray], axis=-1)
    UVW = (points - exterior[1, :3]) @ M[1].T
    base = M[1] @ (exterior[1, :3] - exterior[0, :3])
    W = UVW[:, 2:]
    turned = A @ axes
    turned[:, :2, 2] = 0
    turned[:, 2:, 2] = -c * (base[:2] * W - UVW[:, :2] * base[2]) / W**2
    correction = np.linalg.pinv(turned) @ L
    X, V = axes @ correction, turned @ correction - L
    return SimpleNamespace(A=A, L=L[..., 0], X=X[..., 0], V=V[..., 0], before=points)


def steps(exterior, photo, n):
    # Harintaka 2020 (4), (5), on the right ray; z = -f with the f of the program
    points, done = meeting(exterior, photo)[1], []
    for _ in range(n):
        done.append(step(exterior, photo, points))
        points = points + done[-1].X
    return done


# As the program reads the orientation, and its steps
MISREAD, PHOTO = exteriors("degrees", exchanged=True), photo_six_decimals()
STEPS = steps(MISREAD, PHOTO, 6)
THIRD = STEPS[2]


def sigma0(V):
    """All points together: four observations and three unknowns each."""
    return np.sqrt(np.sum(V**2) / len(V))


DESIGN = block_diag(*THIRD.A[:2])  # A (8, 6) of points 1 and 2


def test_m_left_is_what_the_angles_give_in_degrees():
    assert_printed(rotation.matrix(*exteriors("degrees")[0, 3:]), "M_left")
    in_radians = rotation.matrix(*exteriors()[0, 3:])
    assert np.abs(in_radians - printed("M_left")[0]).max() > 0.5


def test_m_right_is_what_the_coordinates_of_the_station_give_in_degrees():
    assert_printed(rotation.matrix(*MISREAD[1, 3:]), "M_right")
    for other in (exteriors("degrees"), exteriors(), exteriors(exchanged=True)):
        wrong = np.abs(rotation.matrix(*other[1, 3:]) - printed("M_right")[0])
        assert wrong.max() > 0.04


def test_rqs_follow_from_4_before_the_third_step():
    for exterior, name in zip(MISREAD, ("rqs_left", "rqs_right")):
        M = rotation.matrix(*exterior[3:])
        r, s, q = M @ (THIRD.before[:2] - exterior[:3]).T
        assert_printed(np.column_stack([r, q, s]), name)


def test_adjusted_coordinates_follow_after_the_third_step():
    assert_printed(THIRD.before[:2] + THIRD.X[:2], "adjusted")
    # The print itself shows where that step began: adjusted minus delta
    began = (printed("adjusted")[0] - printed("delta")[0])[0]
    close(began, (0.50142, -2.45449, -4.51726), atol=5e-6)
    close(THIRD.before[0], began, rtol=0, atol=2e-8)


def test_one_of_48_starts_leads_to_the_adjusted_coordinates():
    # Rays (x, y, f) or (x, y, -f), rotated by M' or M, brought together in two axes or
    # in all three, the point on the left ray, on the right one or between: whatever
    # the sign of f in the steps, the coordinates are hit once in 768 iterates
    photo, f = PHOTO[:, :2], (18.5558, -18.5558)
    starts, names = [], []
    for choice in itertools.product(
        f, ((0, 1), (0, 2), (1, 2), (0, 1, 2)), (False, True)
    ):
        left, right = meeting(MISREAD, photo, *choice)
        starts += [left, right, (left + right) / 2]
        names += [(*choice, where) for where in ("left", "right", "between")]
    # And the photo coordinates taken for object coordinates
    for image, z in itertools.product(photo, f):
        starts.append(np.column_stack([image, np.full(2, z)]))
        names.append("image")
    adjusted, half = printed("adjusted")
    repeated = np.tile(photo, (1, len(starts), 1))
    hits = []
    for c in f:
        points = np.concatenate(starts)
        for k in range(8):
            points = points + step(MISREAD, repeated, points, c).X
            off = np.abs(points.reshape(-1, 2, 3) - adjusted)
            here = np.flatnonzero(np.all(off <= half, axis=(1, 2)))
            hits += [(*names[i], c, k + 1) for i in here]
            assert np.sum(off.max(axis=(1, 2)) < 1) == len(here)  # no near miss
    assert len(names) == 48 + 4
    assert hits == [(18.5558, (0, 1), False, "right", -18.5558, 3)]


def test_a_and_l_follow_with_f_negative_and_l_not_with_f_positive():
    positive = step(MISREAD, PHOTO, THIRD.before, c=18.5558)
    assert_printed(DESIGN.T, "A_transposed")
    assert_printed(-block_diag(*positive.A[:2]).T, "A_transposed")
    assert_printed(THIRD.L[:2].reshape(8, 1), "L")
    assert np.abs(positive.L[:2].reshape(8, 1) - printed("L")[0]).max() > 10


def test_normal_matrix_and_its_inverse_follow_from_a():
    normal = DESIGN.T @ DESIGN
    assert_printed(normal, "normal")
    assert_printed(np.linalg.inv(normal), "normal_inverse")
    # The printed four decimals of A'A are not enough for its inverse
    rounded = np.linalg.inv(printed("normal")[0])
    assert np.abs(rounded - printed("normal_inverse")[0]).max() > 0.7


def test_x_is_the_third_step_with_its_last_number_in_the_next_table():
    assert_printed(THIRD.X[:2].reshape(6, 1)[:5], "X")
    assert_printed(THIRD.X[:2], "delta")


def test_ax_and_v_follow():
    AX = np.einsum("nij,nj->ni", THIRD.A[:2], THIRD.X[:2])
    assert_printed(AX.reshape(8, 1), "AX")
    assert_printed(THIRD.V[:2].reshape(8, 1), "V")


def test_s0_is_that_of_all_ten_points_in_the_third_step():
    # 40 observations, 30 unknowns: redundancy 10
    assert_printed(sigma0(THIRD.V), "S0")
    others = [sigma0(STEPS[k].V) for k in (0, 1, 3, 4, 5)]
    expected = (1.5314081, 1.5207431, 1.5138699, 1.5133099, 1.5131193)
    close(others, expected, rtol=0, atol=6e-8)
    # V is printed for points 1 and 2: alone, with 8 observations and 6 unknowns
    close(np.sqrt(np.sum(printed("V")[0] ** 2) / 2), 1.6067, atol=5e-5)
    # Nor is it that of point 1, beside which Table 4.2 shows it, of any other one
    # point, or of the first n points but all ten
    S0 = printed("S0")[0][0, 0]
    for n in range(10):
        assert abs(sigma0(THIRD.V[n : n + 1]) - S0) > 0.03
        assert n == 0 or abs(sigma0(THIRD.V[:n]) - S0) > 0.03
    # Its last digits need the six decimals behind Table 4.1; Table 4.2 has five
    five = steps(MISREAD, datasets.bani2010().photo, 3)[2]
    close(sigma0(five.V), 1.51554935, rtol=0, atol=1e-8)


def exact_step(exterior, photo, point, c=Fraction("-18.5558")):
    """V of one point by (4) to (7) as printed, in fractions: nothing is rounded."""

    def exact(x):
        return np.vectorize(Fraction, otypes=[object])(x)

    A, L = [], []
    for one, xy in zip(exterior, exact(photo)):
        m = exact(rotation.matrix(*one[3:]))
        r, s, q = m @ (exact(point) - exact(one[:3]))
        A += [c / q**2 * (r * m[2] - q * m[0]), c / q**2 * (s * m[2] - q * m[1])]
        L += [xy[0] + c * r / q, xy[1] + c * s / q]
    A, L = np.array(A), np.array(L)
    N = A.T @ A
    rows = [np.cross(N[1], N[2]), np.cross(N[2], N[0]), np.cross(N[0], N[1])]
    X = np.array(rows).T @ (A.T @ L) / (N[0] @ rows[0])
    return (A @ X - L).astype(float)


def test_s0_has_the_unit_of_the_photo_coordinates():
    # Photo coordinates and f in micrometres: the same points, S0 a thousand times
    # larger. The unknowns are X, Y, Z alone, no parameter of the matching among them
    again = step(MISREAD, 1000 * PHOTO, THIRD.before, c=-18555.8)
    assert sigma0(again.V) == approx(1515.54975, abs=6e-6)
    close(again.X[:2], THIRD.X[:2], rtol=1e-9)


def test_published_points_are_on_the_way_of_an_unfinished_iteration():
    heights = np.array([done.before[[0, 1, 4, 9], 2] for done in STEPS])
    expected = [
        (-3.297, -4.308, -4.517, -4.470, -4.469),
        (-3.268, -7.240, -18.29, -61.55, -407.6),
        (5.492, 11.54, 25.60, 64.32, 214.1),
    ]
    close(heights.T[[0, 1, 3], :5], expected, rtol=1e-3)
    # Point 5 starts far off: its rays are nearly parallel in X and Y
    assert np.all(np.diff(np.log10(np.abs(heights[:, 2]))) > 1.5)
    # These are the steps of (6) in exact arithmetic, also where points have diverged
    for done, i in itertools.product(STEPS, (0, 1, 4)):
        exact = exact_step(MISREAD, PHOTO[:, i], done.before[i])
        close(done.V[i], exact, rtol=0, atol=1e-12)
    # S0 goes on falling and gives no warning
    assert np.all(np.diff([sigma0(done.V) for done in STEPS]) < 0)
    # (6) in double precision, which resolves 1 / eps: the third step is within it,
    # the fourth is not. cond(A'A) is cond(A) squared
    conditions = [np.linalg.cond(done.A[4]) ** 2 for done in STEPS[:4]]
    close(conditions[:3], (1.17e6, 1.55e9, 2.41e15), rtol=0.01)
    assert conditions[2] < 1 / np.finfo(float).eps < conditions[3]
    # The points of the object: orientation in radians, interior estimated
    points = converged(interior=LENS).points[:2]
    close(points, [(-2.803, -0.841, -1.736), (-1.933, -0.932, -1.728)], 0, 2e-3)
    assert np.linalg.norm(printed("adjusted")[0] - points, axis=1).min() > 4


def converged(exterior=None, interior=(), free_right=(), c=18.5558, photo=PHOTO):
    """Adjust the points with parameters of the camera or elements of the right photo.

    Returns RMS and sigma0 of the residuals, the estimates and standard deviations.
    """
    exterior = exteriors() if exterior is None else exterior
    return _converged(exterior.tobytes(), interior, free_right, c, photo.tobytes())


@functools.cache
def _converged(exterior, interior, free_right, c, photo):
    exterior = np.frombuffer(exterior).reshape(2, 6)
    photo = np.frombuffer(photo).reshape(2, 10, 2)
    n, k = len(interior), len(free_right)

    def misclosure(unknown, *wrt):
        now = camera(**({"c": c} | dict(zip(interior, unknown[:n]))))
        both = exterior.copy()
        both[1, list(free_right)] += unknown[n : n + k]
        points = unknown[n + k :].reshape(10, 3)
        return collinearity(now, both[:, None], points, photo, wrt=wrt)

    def derivatives(unknown):
        by = misclosure(unknown, "interior", "exterior", "point")
        J = np.zeros((2, 10, 2, len(unknown)))
        J[..., :n] = by.interior[..., [PARAMETERS.index(name) for name in interior]]
        J[1, ..., n : n + k] = by.exterior[1][..., list(free_right)]
        for i in range(10):
            J[:, i, :, n + k + 3 * i : n + k + 3 * i + 3] = by.point[:, i]
        return J.reshape(40, -1)

    first = [c if name == "c" else 0.0 for name in interior] + [0.0] * k
    first = np.concatenate([first, nearest_to_both_rays(exterior, photo, c).ravel()])
    found = least_squares(
        lambda unknown: misclosure(unknown).v.ravel(),
        first,
        derivatives,
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


def test_angles_are_radians_and_each_triplet_stands_in_its_columns():
    read = converged()
    assert read.in_front
    close(read.rms, 0.02554, atol=5e-6)
    close(converged(MISREAD).rms, 0.761, atol=5e-4)
    for other in (MISREAD, exteriors("degrees"), exteriors(exchanged=True)):
        found = converged(other)
        assert found.rms > 20 * read.rms and not found.in_front
    # With y as in Table 4.2; reversed, the rays of the printed orientation miss
    assert converged(photo=PHOTO * (1, -1)).rms > 30 * read.rms


def test_f_is_positive_for_the_printed_orientation():
    assert converged(c=-18.5558).rms > 15 * converged().rms


RIGHT = (1, 2, 3, 4, 5)  # relative orientation: the base component X is held
LENS = ("x0", "y0", "K1")


def test_right_photo_adjusted_leaves_015_px_and_with_k1_a_twentieth():
    # What S0 = 1.5155 mm is made of: converged, the misread orientation leaves as much,
    # with f of either sign
    for c in (18.5558, -18.5558):
        assert converged(MISREAD, c=c).sigma0 == approx(1.517, abs=0.005)
    assert converged().sigma0 == approx(0.05108, abs=5e-6)
    found = converged(free_right=RIGHT)
    close((found.rms, found.sigma0), (0.00065, 0.00184), atol=5e-6)
    degrees, sd = np.degrees(found.values[2:]), np.degrees(found.sd[2:])
    close(degrees, (-0.87, -0.21, -1.05), atol=0.005)
    assert np.all(np.abs(degrees) > 2 * sd) and abs(degrees[2]) > 25 * sd[2]
    # Three parameters of the lens: 0.045 px, if the printed orientation owes nothing to
    # these ten points. If it was adjusted with them, five redundancies of seven are
    # spent. Either way below a tenth of a pixel
    lens = converged(interior=LENS).sigma0 / PIXEL
    close(lens, 0.0446, atol=5e-5)
    close(lens * np.sqrt(7 / 2), 0.0835, atol=1e-4)


def test_x0_y0_and_k1_fit_as_well_as_the_right_photo_and_k1():
    lens = converged(interior=LENS)
    close(lens.sigma0, 0.000544, atol=1e-6)
    assert np.all(np.abs(lens.values - (0.247, 0.069, 2.53e-4)) < (5e-4, 5e-4, 1e-6))
    close(lens.sd, (0.00106, 0.00080, 1.6e-5), rtol=0.01)
    close(lens.values[:2] / PIXEL, (20.3, 5.7), atol=0.05)
    # Like with like. Without K1 the right photo rotated fits better ...
    shifted, turned = converged(interior=("x0", "y0")), converged(free_right=RIGHT)
    close((shifted.sigma0 / PIXEL, turned.sigma0 / PIXEL), (0.254, 0.151), atol=5e-4)
    # ... with K1 both fit to a twentieth of a pixel. Neither contains the other: no F
    # test compares them
    both = converged(interior=("K1",), free_right=RIGHT)
    close(both.sigma0 / PIXEL, 0.0528, atol=5e-5)
    # All eight free: two photos of ten points do not separate them
    all_free = converged(interior=LENS, free_right=RIGHT)
    close((all_free.values[0], all_free.sd[0]), (0.56, 1.19), atol=0.005)
    # That the orientation is printed with four decimals explains nothing: they move a
    # ray by 1.3 micrometres at most
    rng = np.random.default_rng(5)
    for _ in range(5):
        rounded = exteriors() + rng.uniform(-5e-5, 5e-5, (2, 6))
        assert abs(converged(rounded).rms - converged().rms) < 0.0004


@pytest.mark.parametrize(
    ("count", "first", "sigmas"),
    [
        (325, ["x0", "y0"], (0.2544, 0.2684)),
        pytest.param(2600, [*LENS], (0.0446, 0.0833), marks=pytest.mark.slow),
    ],
)
def test_of_all_pairs_x0_y0_fit_best_and_of_all_triples_x0_y0_k1(count, first, sigmas):
    # Of the ten parameters of the camera for both photos, the ten of the right photo
    # alone and its six elements; choices of one size have the same redundancy
    choices, sigma0, settled = intersection_parameters.every(26, len(first))
    names = [[intersection_parameters.NAMES[j] for j in one] for one in choices[:2]]
    assert len(choices) == count and names[0] == first
    if len(first) == 2:  # narrowly
        assert names[1] == ["x0", "phi of the right photo"]
    close(sigma0[:2], sigmas, rtol=0, atol=1e-4)
    # What does not settle is worse than a pixel, and none was near
    assert np.all(sigma0[~settled] > 1)
    # Another adjustment finds the same
    other = converged(interior=tuple(first)).sigma0 / PIXEL
    assert other == approx(sigma0[0], abs=1e-4)


def test_principal_distance_is_consistent_with_the_orientation_it_belongs_to():
    # The orientation was computed with some c, and is held here: a consistency of two
    # inputs. It needs K1; without it c is more than four standard deviations off
    for interior, c, sd in (
        (("x0", "y0", "K1"), 18.559, 0.025),
        (("x0", "y0"), 18.398, 0.037),
    ):
        found = converged(interior=("c", *interior))
        close((found.values[0], found.sd[0]), (c, sd), atol=5e-4)
    assert abs(found.values[0] - 18.5558) > 4 * found.sd[0]
