"""camera.json to the last bit and each lie in one; the models of other programs."""

import json
from dataclasses import replace
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from pgm_lab import camera, frames
from pgm_lab.camera import PARAMETERS, Camera, files
from pgm_lab.camera.files import CameraFile

SIZE, PIXEL = (4032, 3024), 0.0014
# A phone: 70 degrees across the diagonal, barrel distortion of 60 pixels in the corner
PHONE = Camera(5.1, 0.021, -0.034, 2.1e-3, -1.3e-4, 3e-6, 1.1e-4, -7e-5, lens="forward")
RNG = np.random.default_rng(1)
FACTOR = RNG.normal(size=(8, 8)) * 10.0 ** -np.arange(3, 11)[:, None]
COVARIANCE = FACTOR @ FACTOR.T
FILE = CameraFile(
    *(PHONE, SIZE, PIXEL, True, PARAMETERS[:8], COVARIANCE, 'board [1  2], "30 °C"')
)
POINTS = RNG.uniform((-0.5, -0.37, -1.0), (0.5, 0.37, -1.0), (200, 3)) * (
    RNG.uniform(1, 9, (200, 1))
)


def of(lens):
    return CameraFile(lens, SIZE, PIXEL)


def pixels(lens):
    """Where our camera sees the points, from the origin along -Z."""
    return frames.photo_to_pixel(camera.project(lens, np.zeros(6), POINTS), SIZE, PIXEL)


# --- camera.json ---


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "camera.json"
    FILE.save(path)
    return path


def test_a_file_gives_back_every_bit(written):
    found = files.read(written)
    assert found.camera == PHONE == Camera.read(written)
    assert found.covariance.tobytes() == COVARIANCE.tobytes()
    for name in ("image_size", "pixel_size", "nominal", "estimate", "about"):
        assert getattr(found, name) == getattr(FILE, name)
    whole = json.loads(written.read_text(encoding="utf-8"))
    assert whole["parameters"]["K2"] == {
        "value": PHONE.K2,
        "sd": pytest.approx(np.sqrt(COVARIANCE[4, 4]), rel=1e-15),
        "unit": "mm^-4",
    }


@pytest.mark.parametrize("lens", ["backward", "forward"])
def test_odd_numbers_and_a_camera_of_unknown_accuracy_come_back(tmp_path, lens):
    odd = Camera(1 / 3, -0.0, 5e-324, 0.1 + 0.2, b1=-2 / 3e5, b2=1e-17, lens=lens)
    CameraFile(odd, (640, 480), 0.001).save(tmp_path / "a.json")
    found = files.read(tmp_path / "a.json")
    assert found.camera.interior.tobytes() == odd.interior.tobytes()
    assert found.camera.lens == lens
    assert (found.covariance, found.estimate, found.nominal) == (None, (), False)


def entry(i, j, value):
    def change(whole):
        whole["covariance"]["matrix"][i][j] = value

    return change


def parameter(name, **change):
    return lambda whole: whole["parameters"][name].update(change)


def negative_eigenvalue(whole):
    """Two correlations of nearly 1 and one of nearly -1 cannot be true together."""
    matrix, sd = whole["covariance"]["matrix"], np.sqrt(np.diag(COVARIANCE))
    for i, j, r in ((0, 1, 0.99), (0, 2, 0.99), (1, 2, -0.99)):
        matrix[i][j] = matrix[j][i] = r * sd[i] * sd[j]


LIES = {
    "another format": (lambda w: w.update(format="other"), "format .* must be 'pgm_l"),
    "a key is missing": (lambda w: w.pop("lens"), "'lens' is missing"),
    "a key too many": (lambda w: w.update(fx=1), '"fx" in the file is .* unknown'),
    "y down": (lambda w: w["convention"].update(photo="y down"), "photo in convention"),
    "no lens": (lambda w: w.update(lens="fisheye"), "lens must be one of"),
    "c in m": (parameter("c", value=0.0051), "are all in mm"),
    "c no number": (parameter("c", value="5.1"), "c must be numbers"),
    "another unit": (parameter("K1", unit="px^-2"), "unit in K1"),
    "another sd": (parameter("c", sd=1.0), "sd in c in .* got 1.0"),
    "an sd of nothing": (parameter("b1", sd=1.0), "sd in b1 .* must be None"),
    "no size": (lambda w: w.update(image_size=[0, 3024]), "image_size must be"),
    "pixels in um": (lambda w: w.update(pixel_size=1400), "are all in mm"),
    "nominal": (lambda w: w.update(pixel_size_is_nominal="no"), "True or False"),
    "not symmetric": (entry(0, 1, 1e-6), "symmetric and positive"),
    "variance 0": (entry(2, 2, 0.0), "variances above zero"),
    "not positive": (negative_eigenvalue, "symmetric and positive"),
    "twice": (lambda w: w["covariance"].update(names=["c"] * 8), "each once"),
    "no parameter": (
        lambda w: w["covariance"]["names"].__setitem__(0, "f"),
        "name of the covariance must be one of",
    ),
}


@pytest.mark.parametrize("lie", LIES)
def test_a_file_that_lies_is_refused_in_a_sentence(written, lie):
    change, words = LIES[lie]
    whole = json.loads(written.read_text(encoding="utf-8"))
    change(whole)
    written.write_text(json.dumps(whole))
    with pytest.raises(ValueError, match=f"camera.json: .*{words}") as error:
        Camera.read(written)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("end", [0.0, 0.3, 0.995])
def test_a_file_that_was_cut_off_is_refused(written, end):
    content = written.read_bytes()
    written.write_bytes(content[: int(end * len(content))])
    with pytest.raises(ValueError, match=r"camera\.json: .*(char|empty)"):
        files.read(written)


@pytest.mark.parametrize("content", [b"[1]", b"{}", b"\xff\xfe{}", b"[" * 10**5])
def test_a_foreign_file_is_refused(tmp_path, content):
    (tmp_path / "x.json").write_bytes(content)
    with pytest.raises(ValueError, match=r"x\.json: this is no camera\.json: "):
        files.read(tmp_path / "x.json")


# --- Other programs ---


def cv2_project(matrix, distortion, points=POINTS):
    """OpenCV's camera looks along +z, with y down."""
    points, still = points * (1, -1, -1), np.zeros(3)
    return cv2.projectPoints(points, still, still, matrix, distortion)[0][:, 0]


def test_a_forward_camera_is_that_of_cv2_and_comes_back():
    matrix, distortion, departure = files.to_opencv(of(PHONE))
    expected = pixels(PHONE)
    assert np.all(np.ptp(expected, axis=0) > (3500, 2500)) and departure == 0
    seen = cv2_project(matrix, distortion)
    np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-9)
    again = files.from_opencv(matrix, distortion, SIZE, PIXEL)
    np.testing.assert_allclose(again.interior, PHONE.interior, rtol=1e-14, atol=1e-17)
    assert again.lens == "forward"


def test_cv2_reads_its_file_bit_by_bit(tmp_path):
    path = tmp_path / "camera.yml"
    path.write_text(files.exchange(of(PHONE), "opencv"))
    stored = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    names = "camera_matrix", "distortion_coefficients"
    for name, expected in zip(names, files.to_opencv(of(PHONE))):
        assert stored.getNode(name).mat().tobytes() == expected.tobytes()
    size = [stored.getNode(f"image_{one}").real() for one in ("width", "height")]
    stored.release()
    assert size == [*SIZE]


def colmap_project(text):
    """The formula of COLMAP's sensor/models.h, in the camera's frame, y down."""
    _, model, width, height, *numbers = text.splitlines()[-1].split()
    fx, fy, cx, cy, k1, k2, p1, p2, *more = map(float, numbers)
    k3, k4, k5, k6 = more or [0] * 4
    assert (model == "FULL_OPENCV") == (len(more) == 4)
    assert (int(width), int(height)) == SIZE
    u, v = (POINTS[:, :2] * (1, -1) / -POINTS[:, 2:]).T
    r2 = u * u + v * v
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (
        1 + k4 * r2 + k5 * r2**2 + k6 * r2**3
    )
    x = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u)
    y = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v)
    return np.stack([fx * x + cx, fy * y + cy], -1)


@pytest.mark.parametrize("K3", [0.0, PHONE.K3])
def test_colmap_sees_the_same_with_pixel_centres_at_a_half(K3):
    lens = replace(PHONE, K3=K3)
    seen = colmap_project(files.exchange(of(lens), "colmap"))
    np.testing.assert_allclose(seen - 0.5, pixels(lens), rtol=0, atol=1e-9)


@pytest.mark.parametrize("K3", [0.0, PHONE.K3])
def test_pycolmap_sees_the_same(K3):
    pycolmap = pytest.importorskip("pycolmap")
    lens = replace(PHONE, K3=K3)
    _, model, *numbers = files.exchange(of(lens), "colmap").splitlines()[-1].split()
    width, height, *params = map(float, numbers)
    size = {"width": int(width), "height": int(height)}
    theirs = pycolmap.Camera(model=model, params=params, **size)
    seen = theirs.img_from_cam(POINTS * (1, -1, -1))
    np.testing.assert_allclose(seen - 0.5, pixels(lens), rtol=0, atol=1e-9)


def metashape_project(text):
    """Appendix "Camera models" of Agisoft's manual: frame cameras."""
    found = ElementTree.fromstring(text.encode())
    assert found.tag == "calibration" and found.findtext("projection") == "frame"
    get = {one.tag: float(one.text) for one in found if one.tag != "projection"}
    x, y = (POINTS[:, :2] * (1, -1) / -POINTS[:, 2:]).T
    r2 = x * x + y * y
    radial = 1 + get["k1"] * r2 + get["k2"] * r2**2 + get["k3"] * r2**3
    xs = x * radial + get["p1"] * (r2 + 2 * x * x) + 2 * get["p2"] * x * y
    ys = y * radial + get["p2"] * (r2 + 2 * y * y) + 2 * get["p1"] * x * y
    u = get["width"] / 2 + get["cx"] + xs * get["f"] + xs * get["b1"] + ys * get["b2"]
    return np.stack([u, get["height"] / 2 + get["cy"] + ys * get["f"]], -1)


def test_metashape_sees_the_same_by_the_formula_of_its_manual():
    seen = metashape_project(files.exchange(of(PHONE), "metashape"))
    np.testing.assert_allclose(seen - 0.5, pixels(PHONE), rtol=0, atol=1e-9)


BACKWARD = Camera(5.1, 0.02, -0.03, 1e-3, -2e-5, P1=1e-4, P2=-7e-5)


def test_another_camera_is_fitted_and_departs_as_stated():
    lens = replace(BACKWARD, b1=3e-4)
    matrix, distortion, departure = files.to_opencv(of(lens))
    corners = np.array([(-0.5, -0.5), (4031.5, -0.5), (-0.5, 3023.5), (4031.5, 3023.5)])
    ideal = camera.ideal(lens, frames.pixel_to_photo(corners, SIZE, PIXEL))
    seen = cv2_project(matrix, distortion, np.c_[ideal, np.full(4, -lens.c)])
    off = np.hypot(*(seen - corners).T).max()
    assert off == pytest.approx(departure, rel=1e-6) and 0.01 < off < 0.1
    expected = pixels(lens)
    assert np.hypot(*(cv2_project(matrix, distortion) - expected).T).max() < departure
    readers = {"colmap": colmap_project, "metashape": metashape_project}
    for program, project in readers.items():
        text = files.exchange(of(lens), program)
        assert f"by up to {departure:.2g} px" in text
        assert np.hypot(*(project(text) - 0.5 - expected).T).max() < departure


def test_a_shear_is_refused():
    with pytest.raises(ValueError, match=r"has no b1, b2.*departs by up to 0\.4\d+ px"):
        files.exchange(of(replace(BACKWARD, b1=5e-4, b2=3e-4)), "opencv")


K = np.array([[3640.0, 0, 2030], [0, 3641.5, 1490], [0, 0, 1]])


@pytest.mark.parametrize(
    "fx, distortion",
    [
        (3640, [0.05, -0.1, 1e-3, -5e-4, 0.05]),
        (3641.5, [0.1, -0.1, 0, 0, 0, 0.05, 0, 0]),
    ],
)
def test_unequal_scales_and_rational_coefficients_are_fitted(fx, distortion):
    matrix = K + np.diag([fx - 3640, 0, 0])
    lens = files.from_opencv(matrix, distortion, SIZE, PIXEL)
    seen = cv2_project(matrix, np.array(distortion))
    np.testing.assert_allclose(pixels(lens), seen, rtol=0, atol=0.1)
    assert lens.b1 == pytest.approx(fx / 3641.5 - 1, abs=2e-4)


@pytest.mark.parametrize(
    "change, words",
    [
        ({"distortion": [0.1, 0.2]}, "5, 8, 12 or 14 numbers"),
        ({"distortion": [0.0] * 12 + [0.1, 0.1]}, "departs by up to .* px"),
        ({"matrix": K.T}, "matrix must be"),
        ({"matrix": -K}, "matrix must be"),
    ],
)
def test_what_is_no_camera_of_opencv_is_refused(change, words):
    given = {"matrix": K, "distortion": np.zeros(5)} | change
    with pytest.raises(ValueError, match=words):
        files.from_opencv(**given, image_size=SIZE, pixel_size=PIXEL)
