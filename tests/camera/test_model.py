"""The camera model against OpenCV, differences, and its own way back."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pgm_lab import camera as cam
from pgm_lab import rotation
from pgm_lab.camera import Camera, imaging

INTERIOR = (35.2, 0.31, -0.22, -8.3e-5, 4.1e-8, -6.7e-12, 2.9e-5, -1.7e-5, 3e-4, -2e-4)
EXTERIOR = np.array([120.0, -340.0, 900.0, 0.15, -0.2, 2.1])
BOTH = pytest.mark.parametrize("lens", ["backward", "forward"])


def scene(seed=1, n=8):
    """Points that two cameras see; nothing is symmetric."""
    rng = np.random.default_rng(seed)
    points = rng.uniform((-200, -600, -60), (300, 0, 80), (n, 3))
    exteriors = np.array([EXTERIOR, (-80.0, -100.0, 850.0, -0.3, 0.1, -0.7)])
    return points, exteriors


@BOTH
def test_misclosure_is_computed_minus_observed(lens):
    camera = Camera(*INTERIOR, lens=lens)
    points, exteriors = scene()
    measured = cam.project(camera, exteriors[:, None], points)
    result = cam.collinearity(camera, exteriors[:, None], points, measured)
    np.testing.assert_allclose(result.v, 0, atol=1e-13)  # mm, rounding of 20 mm
    assert result.depth.min() > 700
    observed = measured + (0.002, -0.003)
    v = cam.collinearity(camera, exteriors[:, None], points, observed, ()).v
    if lens == "forward":  # backward, the lens corrects the errors a little too
        np.testing.assert_allclose(v - (-0.002, 0.003), 0, atol=1e-13)
    np.testing.assert_allclose(v - (-0.002, 0.003), 0, atol=3e-4)


@BOTH
def test_all_derivatives_agree_with_complex_step(lens):
    """Without truncation and cancellation, whatever their size."""
    points, exteriors = scene(n=1)
    measured = cam.project(Camera(*INTERIOR, lens=lens), exteriors[0], points[0]) + 0.3
    unknowns = np.concatenate([INTERIOR, exteriors[0], points[0]])

    def run(x):
        return imaging.misclosure(x[:10], x[10:16], x[16:], measured, lens, cam.BLOCKS)

    result = run(unknowns)[2]
    analytic = np.concatenate([result[name] for name in cam.BLOCKS], axis=-1)
    checked = cam.collinearity(
        Camera(*INTERIOR, lens=lens), exteriors[0], points[0], measured
    )
    for name in cam.BLOCKS:
        np.testing.assert_array_equal(getattr(checked, name), result[name])
    expected = np.stack(
        [run(unknowns + 1e-30j * unit)[0].imag / 1e-30 for unit in np.eye(19)], axis=-1
    )
    scale = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(analytic / scale, expected / scale, rtol=0, atol=1e-12)


def opencv(camera, exterior, points):
    """Photo coordinates (mm, y up) from OpenCV, whose camera looks along +z, y down."""
    c, x0, y0, K1, K2, K3, P1, P2, _, _ = camera.interior
    flip = np.diag([1.0, -1.0, -1.0])
    turn = flip @ rotation.matrix(*exterior[3:])
    coefficients = np.array([K1 * c**2, K2 * c**4, -P2 * c, P1 * c, K3 * c**6])
    matrix = np.array([[c, 0, x0], [0, c, -y0], [0, 0, 1]])
    image, _ = cv2.projectPoints(
        points, cv2.Rodrigues(turn)[0], -turn @ exterior[:3], matrix, coefficients
    )
    return image[:, 0] * (1, -1)


def test_forward_lens_projects_as_opencv_does():
    camera = Camera(*INTERIOR[:8], lens="forward")
    points, exteriors = scene(n=50)
    for exterior in exteriors:
        np.testing.assert_allclose(
            cam.project(camera, exterior, points),
            opencv(camera, exterior, points),
            atol=1e-11,  # mm; rounding on the way through Rodrigues' vector
        )


@given(
    st.floats(-13, 13),
    st.floats(-10, 10),
    st.floats(-2e-4, 2e-4),
    st.floats(-1e-7, 1e-7),
    st.floats(-5e-5, 5e-5),
    st.floats(-5e-5, 5e-5),
    st.floats(-1e-3, 1e-3),
    st.sampled_from(cam.LENSES),
)
def test_ideal_and_measured_undo_each_other(x, y, K1, K2, P1, P2, b, lens):
    camera = Camera(30.0, 0.2, -0.1, K1, K2, 1e-11, P1, P2, b, -b / 2, lens=lens)
    ideal = cam.ideal(camera, cam.measured(camera, (x, y)))
    np.testing.assert_allclose(ideal, (x, y), rtol=0, atol=1e-12)
    measured = cam.measured(camera, cam.ideal(camera, (x, y)))
    np.testing.assert_allclose(measured, (x, y), rtol=0, atol=1e-12)


def test_ideal_point_and_principal_distance_are_the_ray():
    points, exteriors = scene()
    for lens in cam.LENSES:
        camera = Camera(*INTERIOR, lens=lens)
        ideal = cam.ideal(camera, cam.project(camera, exteriors[1], points))
        ray = np.column_stack([ideal, np.full(len(points), -camera.c)])
        there = (points - exteriors[1, :3]) @ rotation.matrix(*exteriors[1, 3:]).T
        np.testing.assert_allclose(np.cross(ray, there), 0, atol=1e-9)
        assert np.all((ray * there).sum(axis=-1) > 0)


@BOTH
@pytest.mark.parametrize("wrt", [(), ("point",), ("exterior",), ("interior", "point")])
def test_only_the_derivatives_asked_for_are_there_and_they_are_the_same(lens, wrt):
    points, exteriors = scene()
    arguments = Camera(*INTERIOR, lens=lens), exteriors[:, None], points, np.ones(2)
    everything = cam.collinearity(*arguments)
    result = cam.collinearity(*arguments, wrt=wrt)
    np.testing.assert_array_equal(result.v, everything.v)
    for name in cam.BLOCKS:
        if name in wrt:
            block, expected = getattr(result, name), getattr(everything, name)
            np.testing.assert_array_equal(block, expected)
        else:
            assert getattr(result, name) is None


@BOTH
@pytest.mark.parametrize(
    "leading", [((), (), ()), ((), (), (7,)), ((), (7,), ()), ((4, 1), (7,), (4, 7))]
)
def test_leading_axes_broadcast_and_every_result_has_them(lens, leading):
    exterior, points, measured = (
        np.broadcast_to(values, (*axes, len(values)))
        for values, axes in zip((EXTERIOR, (10.0, -20.0, 5.0), (1.0, 2.0)), leading)
    )
    shape = np.broadcast_shapes(*leading)
    camera = Camera(*INTERIOR, lens=lens)
    result = cam.collinearity(camera, exterior, points, measured)
    assert result.v.shape == (*shape, 2) and result.depth.shape == shape
    assert result.interior.shape == (*shape, 2, 10)
    assert result.exterior.shape == (*shape, 2, 6)
    assert result.point.shape == (*shape, 2, 3)


def test_a_point_behind_the_camera_is_named_and_its_depth_is_negative():
    points = [(0.0, 0.0, 0.0), (0.0, 0.0, 200.0), (0.0, 0.0, 100.0)]
    exterior = (0, 0, 100, 0, 0, 0)
    with pytest.raises(ValueError, match=r"points\[1, 2\] are not in front"):
        cam.project(Camera(35.0), exterior, points)
    with pytest.raises(ValueError, match=r"points\[\(1, 0\)\] are not in front"):
        cam.project(Camera(35.0), [[exterior], [(0, 0, -9, 0, 0, 0)]], points[:1])
    depth = cam.collinearity(Camera(35.0), exterior, points[:2], (0, 0)).depth
    np.testing.assert_array_equal(depth, (100, -100))


# x + d(x) = x - x^3 / 300 turns back at x = 10, where it is 20/3 = 6.667 mm
FOLDED = -1 / 300


@pytest.mark.parametrize(
    ("lens", "function"), [("backward", cam.measured), ("forward", cam.ideal)]
)
def test_no_solution_beyond_the_turn_of_the_lens_is_given_out(lens, function):
    camera = Camera(35.0, K1=FOLDED, lens=lens)
    inside = function(camera, (20 / 3 * (1 - 1e-6), 0.0))
    assert inside[0] == pytest.approx(10, abs=0.02)  # flat near the turn
    for x in (6.7, 8.0, 14.0, 40.0, 1e6):
        with pytest.raises(
            ValueError, match=r"\[1\]: the lens displaces no point to here"
        ):
            function(camera, [(1.0, 0.5), (0.0, x)])


@pytest.mark.parametrize(
    ("lens", "function"), [("backward", cam.ideal), ("forward", cam.measured)]
)
def test_no_point_beyond_the_fold_is_imaged_nearer_or_mirrored(lens, function):
    """From x = 10 on the image comes back; at 17.3 it would cross the axis."""
    camera = Camera(35.0, K1=FOLDED, lens=lens)
    assert function(camera, (9.99, 0.0))[0] == pytest.approx(20 / 3, abs=1e-4)
    for x in (10.01, 14.0, 20.0, 1e6, 1e60):
        with pytest.raises(ValueError, match=r"\[1\] lie beyond the fold of the lens"):
            function(camera, [(1.0, 0.5), (0.0, x)])
    with pytest.raises(ValueError, match="the lens"):
        cam.project(camera, (0, 0, 35.0, 0, 0, 0), [(20.0, 0, 0)])


@pytest.mark.parametrize(
    ("K1", "K2", "image"),
    [
        # 1 - 0.03 r^2 + 0.0002 r^4 turns back at 3.83 mm (image at 2.31 mm) and
        # outwards again at 9.17 mm: Newton finds points on the way out there
        (-0.03, 0.0002, np.linspace(2.33, 6.0, 200)),
        # Far beyond the turn at 10 mm it finds points on the other side of the axis
        (FOLDED, 0.0, np.linspace(2075.0, 2085.0, 200)),
    ],
)
def test_ghosts_on_another_branch_are_not_taken_for_solutions(K1, K2, image):
    lens = np.array([K1, K2, 0, 0, 0, 0, 0])
    image = np.column_stack([image, np.zeros_like(image)])
    x, solved = imaging.undistort(lens, image)
    fits = np.abs(x + imaging.distortion(lens, x) - image).max(axis=-1) < 1e-6
    assert fits.any(), "without a ghost this tests nothing"
    assert not solved.any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"wrt": ("points",)}, "wrt must be one of 'interior', 'exterior', 'point'"),
        (
            {"points": np.zeros((4, 3)), "measured": np.zeros((5, 2))},
            "do not broadcast",
        ),
    ],
)
def test_bad_input_to_the_collinearity_equations_is_named(change, message):
    good = {
        "camera": Camera(35.0),
        "exterior": (0, 0, 100, 0, 0, 0),
        "points": (1.0, 2.0, 3.0),
        "measured": (0.1, 0.2),
    }
    with pytest.raises(ValueError, match=message):
        cam.collinearity(**(good | change))
