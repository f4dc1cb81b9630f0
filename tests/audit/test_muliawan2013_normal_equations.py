"""Proofs of the verdicts on Muliawan 2013, (2.70) to (2.95), and on section 3.3.2."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import adjustment, rotation
from pgm_lab import camera as cam
from pgm_lab.camera import Camera, imaging

from . import as_printed
from . import muliawan2013_network as net
from .muliawan2013_network import EXTERIOR, INTERIOR, OBJECT, PRINTED


@pytest.fixture(scope="module")
def solved():
    """Correct adjustment: result, unknowns, residuals, derivatives and N."""
    result, x = net.adjusted()
    v, A = net.misclosure(x)
    return result, x, v, A, A.T @ A / net.SIGMA**2


def ray(k=7, i=5):
    """Photo i, point k of the start values: what (2.83) to (2.86) speak of."""
    return PRINTED.exteriors[i], PRINTED.object_points[k]


# Weights and solution


def weighted_line():
    """Straight line through five points of different precision: A, f, sigma."""
    t = np.array([0.0, 1.0, 2.0, 4.0, 5.0])
    f = np.array([1.02, 2.9, 5.1, 9.0, 10.7])
    return np.stack([np.ones(5), t], -1), f, np.array([0.1, 0.1, 0.2, 0.05, 0.4])


def test_weights_are_inversely_proportional_to_variances():
    # The same measurements, weighted in both ways; standard deviations by propagation
    A, _, sigma = weighted_line()

    def sd(W):
        G = np.linalg.solve(A.T @ (W[:, None] * A), A.T * W)
        return np.sqrt(np.diag(G @ np.diag(sigma**2) @ G.T))

    as_2_69_has_it, as_the_sentence_has_it = sd(1 / sigma**2), sd(sigma**2)
    assert np.all(as_2_69_has_it < sd(np.ones(5)))  # the least that is possible
    ratio = as_the_sentence_has_it / as_2_69_has_it
    close(ratio, (2.7, 4.6), rtol=0, atol=0.05)


def test_2_69_weighs_as_repeated_measurements_do():
    # Measured four times and averaged, sigma halves: the weight is that of four
    A, f, _ = weighted_line()
    count = np.array([1, 4, 1, 1, 2])
    W = 0.3**2 / (0.3 / np.sqrt(count)) ** 2
    close(W, count, rtol=1e-14)
    repeated, *_ = np.linalg.lstsq(A.repeat(count, axis=0), f.repeat(count), rcond=None)
    found = np.linalg.solve(A.T @ (W[:, None] * A), A.T @ (W * f))
    close(found, repeated, rtol=1e-12)


def test_2_75_and_2_76_make_v_w_v_least_with_v_observed_minus_computed():
    A, f, sigma = weighted_line()
    w = 1 / sigma**2
    delta = np.linalg.inv(A.T * w @ A) @ (A.T * w) @ f
    result = adjustment.adjust(lambda x: (A @ x, A), [0.0, 0.0], f, weights=w)
    close(delta, result.x, rtol=1e-10)
    V = f - A @ delta  # (2.75)
    close(V, -result.residuals, rtol=0, atol=1e-10)
    for move in np.eye(2):
        assert w @ (f - A @ (delta + 0.01 * move)) ** 2 > w @ V**2


def test_2_70_gives_the_same_solution_for_any_sigma0():
    # (2.69) with sigma0 = 1. Another one multiplies N and t alike: Delta stays, and
    # sigma0^2 Q stays too
    _, A = net.misclosure(net.START)
    A = A[:, INTERIOR]
    f = -net.misclosure(net.START)[0].ravel()
    found = []
    for sigma0 in (1.0, 0.35, 1000.0):
        W = np.full(900, sigma0**2 / net.SIGMA**2)
        N = A.T @ (W[:, None] * A)
        s = np.sqrt(np.diag(N))
        inverse = np.linalg.inv(N / np.outer(s, s)) / np.outer(s, s)
        delta = inverse @ (A.T @ (W * f))
        v = f - A @ delta
        found.append((delta, v @ (W * v) / 890 * np.diag(inverse)))
    for delta, variance in found[1:]:
        close(delta, found[0][0], rtol=1e-7)
        close(variance, found[0][1], rtol=1e-7)


def test_2_71_to_2_74_are_weights_of_observed_unknowns_and_2_90_does_not_use_them():
    # Two unknowns, one of them observed besides: its weight adds to the diagonal of N
    A = np.array([[1.0, 2.0], [1.0, -1.0], [0.5, 1.0]])
    observed, known, W = np.array([3.0, 0.2, 1.4]), np.array([0.9, 0.0]), (4.0, 0.0)
    result = adjustment.adjust(
        lambda x: (A @ x, A),
        [0.0, 0.0],
        observed,
        parameter_weights=W,
        parameter_values=known,
    )
    x = np.linalg.solve(A.T @ A + np.diag(W), A.T @ observed + W * known)
    close(result.x, x, rtol=1e-12)
    # (2.90) has blocks A' P A alone; were (2.71), (2.73) in it, no datum were missing
    _, D = net.misclosure(net.START)
    N = D.T @ D / net.SIGMA**2
    s = np.sqrt(np.diag(N))
    assert np.linalg.eigvalsh(N / np.outer(s, s))[6] < 1e-12
    weighted = N.copy()
    weighted[OBJECT, OBJECT] += np.eye(150) / 1.0**2  # each coordinate to 1 mm
    assert np.linalg.eigvalsh(weighted / np.outer(s, s))[0] > 1e-12


# Linearisation


def test_2_77_needs_the_derivatives_of_f_and_2_83_has_their_negatives():
    # f is J, K of (2.86): observed - computed. To first order (2.77) then wants df/dO;
    # (2.83) and (2.85) hold +d(computed), which is -df
    exterior, point = ray()
    b = as_printed.muliawan_listing(35.0, exterior, point)
    printed = np.array(
        [[b[n] for n in r] for r in (as_printed.ROW_X, as_printed.ROW_Y)]
    )
    move = np.array([1e-5, -2e-5, 1e-5, 0.003, -0.002, 0.004])

    def f(turn, shift):
        e = exterior + np.concatenate([np.zeros(3), turn])
        return -cam.collinearity(Camera(35.0), e, point + shift, (0, 0)).v

    change = f(move[:3], move[3:]) - f(np.zeros(3), np.zeros(3))
    close(change, -printed @ move, rtol=0, atol=2e-7)
    assert np.abs(change).min() > 1e-4


def test_2_78_holds_for_v_observed_minus_computed():
    # v + A1 d1 + A2 d2 + A3 d3 = f: with f = observed - computed before the correction,
    # v is observed - computed after it, the opposite of (2.22)
    v0, A = net.misclosure(net.START)
    rng = np.random.default_rng(6)
    size = np.full(214, 1e-3)
    size[net.ANGLES] = 1e-6
    size[INTERIOR] = (1e-3, 1e-3, 1e-3, 1e-7, 1e-9, 1e-11, 1e-7, 1e-7, 1e-6, 1e-6)
    delta = rng.normal(size=214) * size
    f = -v0.ravel()
    v = f - A @ delta
    after = net.misclosure(net.START + delta)[0].ravel()
    close(v, -after, rtol=0, atol=1e-7)
    assert np.abs(v - after).max() > 0.1


def test_2_79_corrects_the_start_values_and_needs_delta_3_too(solved):
    v, A = net.misclosure(net.START)
    Q = net.cofactor(A.T @ A, net.constraints(PRINTED.object_points))
    once = net.START - Q @ (A.T @ v.ravel())
    assert net.rms(once) == approx(0.00031, abs=1e-5)
    assert net.rms(once) > net.rms(solved[1])
    assert net.rms(net.START) == approx(0.133, abs=0.001)
    without = once.copy()
    without[INTERIOR] = PRINTED.interior
    assert net.rms(without) > 0.9 * net.rms(net.START)


def test_2_80_is_the_unit_matrix_to_half_a_per_cent(solved):
    # (2.78) puts 1 before v. With the lens on the side of the observation A is
    # 1 + the derivatives of the distortion
    interior = net.unpack(solved[1])[0]
    reduced = PRINTED.xy - interior[1:3]
    off = np.abs(imaging.distortion_by_image(interior[3:], reduced))
    assert 1e-4 < off.max() < 5e-3


def test_2_84_needs_three_coordinates_and_both_rows():
    # As printed, twice: d fx / d Xi six times, a matrix of rank 1. Three such photos
    # do not determine a point; with (2.85) two do
    point = PRINTED.object_points[7]
    as_it_stands, right = [], []
    for exterior in PRINTED.exteriors[[0, 5, 7]]:
        D = cam.collinearity(Camera(35.0), exterior, point, (0, 0)).point
        as_it_stands.append(np.full((2, 3), D[0, 0]))
        right.append(D)
    assert np.linalg.matrix_rank(np.vstack(as_it_stands)) == 1
    assert np.linalg.matrix_rank(np.vstack(right[:2])) == 3


def test_2_86_is_observed_minus_computed_and_refers_to_equations_of_other_subjects():
    # "(2.35 and 2.57)" are a component of a ray and the turn by omega; the elements
    # stand in (2.24), the misclosures in (2.28) and (2.29)
    exterior, point = ray()
    measured = np.array([1.0, 2.0])
    *_, (r, s, q) = as_printed.terms(exterior, point)
    J_K = measured + 35.0 * np.array([r, s]) / q
    v = cam.collinearity(Camera(35.0), exterior, point, measured).v
    close(J_K, -v, rtol=0, atol=1e-12)
    w = (rotation.matrix(*exterior[3:]).T @ (*measured, -35.0))[2]  # (2.35)
    turned = rotation.matrix(exterior[3], 0, 0).T @ point  # (2.57)
    assert np.abs(np.array([w, *turned])[:, None] - J_K).min() > 1


def test_lens_belongs_to_the_collinearity_of_2_20_and_not_to_2_64():
    # x - x0 + dx = -c r/q: ten unknowns more beside the exterior. (2.64) is a resection
    # with the camera known: its design has six columns, all of the exterior
    camera = Camera(35.0, 0.2, -0.1, 2e-5, -3e-7, 2e-9, -2e-6, 5e-6, -3e-4, -2e-4)
    exterior, point = ray()
    *_, (r, s, q) = as_printed.terms(exterior, point)
    measured = cam.project(camera, exterior, point)
    image = -35.0 * np.array([r, s]) / q
    close(cam.ideal(camera, measured), image, atol=1e-12)
    result = cam.collinearity(camera, exterior, point, measured)
    assert result.exterior.shape == (2, 6) and result.interior.shape == (2, 10)


def printed_2_89(c, x, y, r_or_r2):
    """The two rows of (2.89) in the order c, x0, y0, K1 ... b2, reduced x, y."""
    r2 = x**2 + y**2
    r = np.sqrt(r2) if r_or_r2 == "r" else r2
    nil, one = np.zeros_like(x), np.ones_like(x)
    row_x = [-x / c, -one, nil, x * r2, x * r2**2, x * r2**3]
    row_y = [-y / c, nil, -one, y * r2, y * r2**2, y * r2**3]
    row_x += [2 * x**2 + r, 2 * x * y, x, y]
    row_y += [2 * x * y, 2 * y**2 + r, nil, nil]
    return np.moveaxis(np.array([row_x, row_y]), -1, 0)


def derivatives_by_interior(x):
    """d(computed - observed) by the ten parameters, by complex step (450, 2, 10)."""
    interior, exteriors, points = net.unpack(x)
    rays = exteriors[net.PHOTO], points[net.POINT], PRINTED.xy, "backward", ()
    columns = [
        imaging.misclosure(interior + 1e-30j * unit, *rays)[0].imag / 1e-30
        for unit in np.eye(10)
    ]
    return np.moveaxis(np.array(columns), 0, -1)


def test_2_89_has_the_opposite_sign_of_2_83_and_2_85():
    # At the printed start: all that is not P1, P2 agrees with minus the derivative of
    # the computed coordinate, while (2.83) and (2.85) have plus; (2.78) adds all three
    A3 = printed_2_89(35.0, *PRINTED.xy.T, "r")
    D = derivatives_by_interior(net.START)
    others = [1, 2, 3, 4, 5, 8, 9]
    close(A3[..., others], -D[..., others], rtol=1e-12, atol=1e-12)
    # c: -x/c against -x(computed)/c, which differ by the misclosure
    close(A3[..., 0], -D[..., 0], rtol=0, atol=0.4 / 35)


def test_2_89_needs_r_squared_with_p1_and_p2():
    D = derivatives_by_interior(net.START)[..., [6, 7]]
    r = printed_2_89(35.0, *PRINTED.xy.T, "r")[..., [6, 7]]
    r2 = printed_2_89(35.0, *PRINTED.xy.T, "r2")[..., [6, 7]]
    close(r2, -D, rtol=1e-12, atol=1e-12)
    assert np.abs(r + D).max() > 80  # mm^2: r = 10 mm for r^2 = 100 mm^2


# Normal equations


def test_2_90_blocks_are_those_of_a_transposed_p_a(solved):
    A = solved[3] / np.linalg.norm(solved[3], axis=0)
    parts = A[:, EXTERIOR], A[:, INTERIOR], A[:, OBJECT]
    blocks = np.block([[a.T @ b for b in parts] for a in parts])
    close(blocks, A.T @ A, rtol=0, atol=1e-13)


def test_2_90_needs_w_minus_f_and_3_3_2_4_has_t_plus():
    # N delta + C = 0 with C = A'Pw: w = -f. With w = f of (2.86) the step goes the
    # wrong way. Section 3.3.2.4 and the listing solve N delta = t with t = A'Pf
    v, A = net.misclosure(net.START)
    f = -v.ravel()
    Q = net.cofactor(A.T @ A, net.constraints(PRINTED.object_points))
    right = Q @ (A.T @ f)
    assert net.rms(net.START + right) < net.rms(net.START) / 10
    small = 0.1  # a tenth of the wrong step is enough to see it
    assert net.rms(net.START - small * right) > 1.05 * net.rms(net.START)


def test_2_91_uses_one_name_for_two_blocks():
    _, A = net.misclosure(net.START)
    photos = A[:, EXTERIOR].T @ A[:, EXTERIOR]
    points = A[:, OBJECT].T @ A[:, OBJECT]
    assert photos.shape == (54, 54) and points.shape == (150, 150)
    for block, size in ((photos, 6), (points, 3)):  # block diagonal both
        k = np.arange(len(block)) // size
        assert np.all(block[k[:, None] != k] == 0)


def test_2_93_needs_sums_in_the_blocks_of_a_photo_and_of_a_point():
    # N tilde i = sum over j, N hat j = sum over i; the double sums of N p are printed
    v, A = net.misclosure(net.START)
    rays, N = A.reshape(450, 2, 214), A.T @ A
    i, j = 2, 11
    one = np.flatnonzero((net.PHOTO == i) & (net.POINT == j))[0]
    photo = slice(6 * i, 6 * i + 6)
    point = slice(OBJECT.start + 3 * j, OBJECT.start + 3 * j + 3)
    for rows, columns, seen, count in (
        (photo, INTERIOR, net.PHOTO == i, 50),
        (INTERIOR, point, net.POINT == j, 9),
        (INTERIOR, INTERIOR, net.PHOTO >= 0, 450),
    ):
        part = np.einsum(
            "kri,krj->kij", rays[seen][..., rows], rays[seen][..., columns]
        )
        assert len(part) == count
        close(part.sum(axis=0), N[rows, columns], rtol=1e-9, atol=1e-6)
        single = rays[one][:, rows].T @ rays[one][:, columns]
        assert np.abs(single).sum() < 0.5 * np.abs(N[rows, columns]).sum()
    C_p = np.einsum("kri,kr->i", rays[..., INTERIOR], v)
    close(C_p, (A.T @ v.ravel())[INTERIOR], rtol=1e-10)


def test_rank_defect_of_n_is_seven(solved):
    for x in (net.START, solved[1]):
        A = net.misclosure(x)[1]
        values = np.linalg.svd(A / np.linalg.norm(A, axis=0), compute_uv=False)
        values = values / values[0]
        assert values[-7] < 1e-14 and values[-8] > 5e-4


def test_2_92_needs_the_bordered_matrix_and_speaks_of_all_unknowns(solved):
    # N^-1 does not exist; the upper left block of (2.94) takes its place. Ten of its
    # 214 rows belong to the additional parameters
    result, x, v, A, N = solved
    Q = net.cofactor(N, net.constraints(net.unpack(x)[2]))
    assert Q.shape == (214, 214) and Q[INTERIOR, INTERIOR].shape == (10, 10)
    sigma0 = np.sqrt(np.sum(v**2) / net.SIGMA**2 / 693)
    close(sigma0 * np.sqrt(np.diag(Q)), result.sd, rtol=1e-6)
    # Not the inverse of the block of the additional parameters alone
    alone = np.linalg.inv(N[INTERIOR, INTERIOR])
    assert np.all(np.diag(Q)[INTERIOR] > 2 * np.diag(alone))


def test_2_94_is_regular_and_keeps_the_adjusted_photo_coordinates(solved):
    # Any other datum gives the same residuals: here photo 1 and the distance to photo 8
    result, x, v, A, N = solved
    border = np.zeros((214, 7))
    border[[0, 1, 2, 3, 4, 5], range(6)] = 1
    border[6 * 7 + 2, 6] = 1
    delta = 1e-3 * np.random.default_rng(2).normal(size=900)  # other observations
    moved = []
    for B in (net.constraints(net.unpack(x)[2]), border):
        Q = net.cofactor(N, B)
        step = Q @ (A.T @ delta) / net.SIGMA**2
        assert np.abs(B.T @ step).max() < 1e-6 * np.abs(B).max()
        moved.append(A @ step)
    close(moved[0], moved[1], rtol=0, atol=1e-9)


def test_2_94_needs_n_hat_in_both_triangles():
    # Row 3 has the transpose of N tilde (54 x 10) where 150 x 10 belong
    _, A = net.misclosure(net.START)
    N_tilde = A[:, EXTERIOR].T @ A[:, INTERIOR]
    N_hat = A[:, INTERIOR].T @ A[:, OBJECT]
    assert N_tilde.T.shape == (10, 54) and N_hat.T.shape == (150, 10)


def similarity(points, p):
    """Shift p0..p2, turn by the right-hand rule p3..p5, scale 1 + p6."""
    a = np.asarray(p[3:6])
    angle = np.linalg.norm(a)
    R = np.eye(3)
    if angle:
        k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]]) / angle
        R = R + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
    return (1 + p[6]) * points @ R.T + p[:3]


def test_2_95_is_the_derivative_of_a_similarity_transformation():
    points = PRINTED.object_points
    G = net.helmert(points)
    for column, unit in zip(G.T, np.eye(7), strict=True):
        h = 1e-6
        there = similarity(points, h * unit) - similarity(points, -h * unit)
        close(column, there.ravel() / (2 * h), atol=1e-6)


def test_2_95_is_the_part_of_the_points_in_the_null_space_of_n(solved):
    # A similarity moves the stations and turns the photos too. With these rows A times
    # the whole is zero, with the zeros of (2.94) it is not. (2.94) does not need it: it
    # only demands G' d2 = 0, seven conditions that a similarity cannot meet
    _, x, _, A, _ = solved
    _, exteriors, points = net.unpack(x)
    G = net.constraints(points)
    whole = G.copy()
    whole[net.STATIONS] = net.helmert(exteriors[:, :3])
    h = 1e-6
    for i, (*_, omega, phi, kappa) in enumerate(exteriors):
        M = rotation.matrix(omega, phi, kappa)
        for k in range(3):
            turns = []
            for sign in (1, -1):
                R = similarity(np.eye(3), sign * h * np.eye(7)[3 + k]).T
                turns.append(rotation.angles(M @ R.T))
            whole[6 * i + 3 : 6 * i + 6, 3 + k] = (turns[0] - turns[1]) / (2 * h)
    size = np.linalg.norm(A, axis=0)
    scaled = A / size
    for column in range(7):
        full, part = size * whole[:, column], size * G[:, column]
        assert np.linalg.norm(scaled @ full) < 1e-6 * np.linalg.norm(full)
        assert np.linalg.norm(scaled @ part) > 1e-2 * np.linalg.norm(part)
    assert np.linalg.matrix_rank(G[OBJECT].T @ whole[OBJECT]) == 7


def test_2_94_with_2_95_is_the_technique_the_text_asks_for(solved):
    # Least trace of the covariance of the points: against inner constraints on the
    # stations, and against seven fixed coordinates of points 1, 10 and 41
    result, x, _, _, N = solved
    trace = np.trace(result.cofactor[OBJECT, OBJECT])
    photos = np.zeros((214, 7))
    photos[net.STATIONS] = net.helmert(net.unpack(x)[1][:, :3])
    fixed = np.zeros((214, 7))
    rows = OBJECT.start + np.array([0, 1, 2, 27, 28, 29, 120])
    fixed[rows, range(7)] = 1
    for border in (photos, fixed):
        other = np.trace(net.cofactor(N, border)[OBJECT, OBJECT])
        assert other > 1.5 * trace


# Chapter III


def test_v_of_3_3_2_5_is_zero_for_any_data():
    # delta solves N delta = t: nothing is left over, whatever was measured, and v has
    # 221 numbers where 900 coordinates were measured
    _, A = net.misclosure(net.START)
    G = net.constraints(PRINTED.object_points)
    s = np.linalg.norm(A, axis=0)
    A, G = A / s, G / s[:, None]
    G = G / np.linalg.norm(G, axis=0)
    N = np.block([[A.T @ A, G], [G.T, np.zeros((7, 7))]])
    rng = np.random.default_rng(1)
    for f in (-net.misclosure(net.START)[0].ravel(), rng.normal(size=900)):
        t = np.concatenate([A.T @ f, np.zeros(7)])
        delta = np.linalg.solve(N, t)
        assert len(N @ delta - t) == 221
        assert np.linalg.norm(N @ delta - t) < 1e-10 * np.linalg.norm(t)
        residuals = A @ delta[:214] - f
        assert np.linalg.norm(residuals) > 1e-3 * np.linalg.norm(f)


def test_delta_3_of_3_3_2_6_is_a_correction_and_not_the_parameter(solved):
    interior = net.unpack(solved[1])[0]
    assert interior[0] - PRINTED.interior[0] == approx(-0.419, abs=0.001)
    assert np.all(PRINTED.interior[1:] == 0)
