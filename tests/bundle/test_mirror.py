"""Images with an axis turned round: the adjustment and its report say so."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_lab import bundle, rotation
from pgm_lab.bundle.refuse import mirrored_image, mirrored_object
from pgm_lab.camera import PARAMETERS, Camera, imaging
from pgm_lab.report import network as network_report
from tests.networks import real, small

NETWORKS = {
    f"{name} {lens}": replace(
        network, cameras=[Camera(*network.cameras[0].interior, lens=lens)]
    )
    for name, network in (("real", real()), ("backward", small()))
    for lens in ("backward", "forward")
} | {"forward forward": small("forward")}
Y_DOWN, X_LEFT = np.array([1, -1]), np.array([-1, 1])


@pytest.fixture(params=NETWORKS)
def network(request):
    return NETWORKS[request.param]


def image(network, signs):
    return replace(network, xy=network.xy * signs)


def looking_along_z(network):
    """Give the angles as for a camera that looks along +z, with y downwards."""
    exteriors = network.exteriors.copy()
    M = imaging.attitude(exteriors)
    exteriors[:, 3:] = rotation.angles(np.diag([1.0, -1, -1]) @ M)
    return replace(network, exteriors=exteriors)


def found(result):
    return {
        finding.title: finding.words for finding in network_report.Case(result).findings
    }


@pytest.mark.parametrize("lens", ["real backward", "backward backward"])
def test_y_downwards_is_refused_in_words_and_its_cure_is_right(lens):
    """The message asks for the other sign of y; with it the adjustment is as ever."""
    network = NETWORKS[lens]
    wrong = image(network, Y_DOWN)
    with pytest.raises(ValueError, match="image is mirrored: is y counted downw") as e:
        bundle.adjust(wrong)
    assert "c = -" in str(e.value) and "x must point right and y up" in str(e.value)
    assert "Change the sign of y" in str(e.value)
    good = bundle.adjust(image(wrong, Y_DOWN))
    assert good.status == "converged" and good.cameras[0].c > 0
    assert not {"Mirrored image", "Mirrored object"} & set(found(good))


@pytest.mark.parametrize("estimate", [PARAMETERS, ("c",)])
def test_an_image_turned_by_180_degrees_is_refused_and_either_cure_works(
    network, estimate
):
    wrong = image(network, -1)
    with pytest.raises(ValueError, match="turned by 180 degrees") as error:
        bundle.adjust(wrong, estimate)
    assert "add pi to each kappa" in str(error.value)
    rolled = replace(wrong, exteriors=wrong.exteriors + [0, 0, 0, 0, 0, np.pi])
    cured = [bundle.adjust(one, estimate) for one in (rolled, image(wrong, -1))]
    for c in (one.cameras[0].c for one in cured):
        assert c == approx(network.cameras[0].c, rel=0.03)


@pytest.mark.parametrize("estimate", [PARAMETERS, ("c",)])
def test_a_camera_that_looks_along_plus_z_is_recognised(network, estimate):
    """OpenCV's y and angles: all points lie behind the photos, and c is negative."""
    with pytest.raises(ValueError, match="points lie behind their photos") as error:
        bundle.adjust(looking_along_z(image(network, Y_DOWN)), estimate)
    assert "as in OpenCV, change the sign of y" in str(error.value)
    cured = looking_along_z(looking_along_z(network))
    close(imaging.attitude(cured.exteriors), imaging.attitude(network.exteriors))


def test_without_convergence_nothing_is_claimed_but_the_axes_are_asked_for(network):
    """After a few steps c is negative, but no solution is reached yet."""
    with pytest.raises(ValueError, match="Is the image mirrored: y counted") as error:
        bundle.adjust(image(network, -1), ("c",), max_iterations=2)
    assert "check the start values" in str(error.value)


@pytest.mark.parametrize("estimate", [PARAMETERS, ("c", "b1", "b2")])
def test_x_to_the_left_is_said_before_all_else(network, estimate):
    """It fits as well as ever: only b1 = -2 betrays it."""
    result = bundle.adjust(image(network, X_LEFT), estimate)
    assert result.status == "converged"
    assert result.cameras[0].b1 == approx(-2, abs=0.01)
    first, what = next(iter(found(result).items()))
    assert first == "Image coordinates" and "count x to the left" in what
    words = mirrored_image(result)
    assert words.startswith(f"b1 = {result.cameras[0].b1:.3f} reverses x")
    assert "are the two exchanged?" in words


@pytest.mark.parametrize(
    ("axis", "called"),
    [
        ("y down", "count y downwards"),
        ("x left", "count x to the left"),
        ("exchanged", "have x and y exchanged"),
    ],
)
def test_a_fixed_camera_mirrors_the_object_and_the_report_says_so_first(
    network, axis, called
):
    """With c held it converges to a mirror image; its fit is that of the right one."""
    xy = {
        "y down": network.xy * Y_DOWN,
        "x left": network.xy * X_LEFT,
        "exchanged": network.xy[:, ::-1],
    }[axis]
    result = bundle.adjust(replace(network, xy=xy), ())
    assert result.status == "converged"
    # exchanged axes also exchange their sigmas, which differ in the small networks
    right = bundle.adjust(network, ())
    assert result.sigma0 == approx(right.sigma0, rel=0.1)
    first, what = next(iter(found(result).items()))
    assert first == "Image coordinates" and called in what
    words = mirrored_object(result)
    assert "better as a mirror image" in words and "x must point right" in words
    assert not mirrored_object(right)
    assert "Image coordinates" not in found(right)


@pytest.fixture(scope="module")
def plain():
    return bundle.adjust(small(), ("c",))


def with_points(result, start, points):
    network = replace(result.network, points=start)
    return replace(result, network=network, points=points)


@pytest.mark.parametrize("thickness", [0.0, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("error", [1e-6, 0.01, 0.1])
def test_rough_start_values_of_a_flat_object_are_no_mirror_image(
    plain, thickness, error
):
    """In a plane the mirror fits as well: chance must not decide."""
    rng = np.random.default_rng(4)
    for _ in range(50):
        points = rng.uniform(-1, 1, (12, 3)) * [1, 1, thickness]
        start = points + error * rng.normal(size=points.shape)
        assert mirrored_object(with_points(plain, start, points)) is None


@pytest.mark.parametrize("turn", [(0, 0, 0), (1, -0.5, 2), (3, 0.1, -3)])
def test_a_mirror_image_is_seen_wherever_it_lies(plain, turn):
    rng = np.random.default_rng(4)
    start = rng.uniform(-1, 1, (12, 3))
    there = 7 * start @ rotation.matrix(*turn).T + [100, -50, 3]
    assert mirrored_object(with_points(plain, start, there)) is None
    for mirror in ([-1, 1, 1], [1, 1, -1], [-1, -1, -1]):
        assert mirrored_object(with_points(plain, start, there * mirror))


def test_where_nothing_converged_no_mirror_is_claimed(plain):
    mirrored = replace(plain, points=plain.points * [1, 1, -1])
    turned = replace(plain, cameras=(replace(plain.cameras[0], b1=-2.0),))
    for result in (mirrored, turned):
        assert {"Mirrored image", "Mirrored object"} & set(found(result))
        early = replace(result, status="diverged")
        assert not {"Mirrored image", "Mirrored object"} & set(found(early))
        assert "x points right and y up" in found(early)["No solution"]


def test_rays_from_behind_are_those_of_a_negative_depth(plain):
    network = plain.network
    assert plain.behind.size == 0
    k = 17
    points = plain.points.copy()
    centre = plain.exteriors[network.photo[k], :3]
    points[network.point[k]] = 2 * centre - points[network.point[k]]
    result = replace(plain, points=points)
    M = rotation.matrix(*result.exteriors[network.photo, 3:].T)
    X = points[network.point] - result.exteriors[network.photo, :3]
    expected = np.flatnonzero(np.einsum("ki,ki->k", M[:, 2], X) >= 0)
    assert k in expected and len(expected) < len(network.xy) / 2
    equal(result.behind, expected)
    assert "check the start values" in found(result)["Behind the camera"]
