"""camera.json to the last bit and each lie in one; the models of other programs."""

import json
from dataclasses import replace
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest

from pgm_lab import camera, frames
from pgm_lab.camera import PARAMETERS, Camera, files

SIZE, PIXEL = (4032, 3024), 0.0014
GIVEN = {"image_size": SIZE, "pixel_size": PIXEL}
# A phone: 70 degrees across the diagonal, barrel distortion of 60 pixels in the corner
PHONE = Camera(5.1, 0.021, -0.034, 2.1e-3, -1.3e-4, 3e-6, 1.1e-4, -7e-5, lens="forward")
RNG = np.random.default_rng(1)
FACTOR = RNG.normal(size=(8, 8)) * 10.0 ** -np.arange(3, 11)[:, None]
COVARIANCE = FACTOR @ FACTOR.T
POINTS = RNG.uniform((-0.5, -0.37, -1.0), (0.5, 0.37, -1.0), (200, 3)) * (
    RNG.uniform(1, 9, (200, 1))
)


def pixels(lens, size=SIZE, pixel=PIXEL):
    """Where our camera sees the points, from the origin along -Z."""
    return frames.photo_to_pixel(camera.project(lens, np.zeros(6), POINTS), size, pixel)


# --- camera.json ---


@pytest.fixture
def written(tmp_path):
    path = tmp_path / "camera.json"
    given = GIVEN | {"covariance": COVARIANCE, "names": PARAMETERS[:8]}
    files.write(path, PHONE, **given, nominal=True, about="board [1  2], 30 °C")
    return path


def test_a_file_gives_back_every_bit(written):
    found = files.read(written)
    assert found.camera == PHONE == Camera.read(written)
    assert found.covariance.tobytes() == COVARIANCE.tobytes()
    assert found.estimate == PARAMETERS[:8]
    assert (found.image_size, found.pixel_size, found.nominal) == (SIZE, PIXEL, True)
    assert found.about == "board [1  2], 30 °C"
    assert found.text() == written.read_text(encoding="utf-8")
    sd = json.loads(found.text())["parameters"]["K2"]["sd"]
    assert sd == pytest.approx(np.sqrt(COVARIANCE[4, 4]), rel=1e-15)


@pytest.mark.parametrize("lens", ["backward", "forward"])
def test_odd_numbers_and_a_camera_of_unknown_accuracy_come_back(tmp_path, lens):
    odd = Camera(1 / 3, -0.0, 5e-324, 0.1 + 0.2, b1=-2 / 3e5, b2=1e-17, lens=lens)
    files.write(tmp_path / "a.json", odd, image_size=(640, 480), pixel_size=0.001)
    found = files.read(tmp_path / "a.json")
    assert found.camera.interior.tobytes() == odd.interior.tobytes()
    assert found.camera.lens == lens
    assert (found.covariance, found.estimate, found.nominal) == (None, (), False)


def test_a_file_is_not_replaced_unless_it_may_be(written):
    old = written.read_bytes()
    with pytest.raises(FileExistsError, match="overwrite=True"):
        files.write(written, Camera(4.0), **GIVEN)
    assert written.read_bytes() == old and len(list(written.parent.iterdir())) == 1
    files.write(written, Camera(4.0), **GIVEN, overwrite=True)
    assert Camera.read(written) == Camera(4.0)


def parameter(name, **change):
    return lambda whole: whole["parameters"][name].update(change)


def entry(i, j, value):
    def change(whole):
        whole["covariance"]["matrix"][i][j] = value

    return change


def negative_eigenvalue(whole):
    """Two correlations of nearly 1 and one of nearly -1 cannot be true together."""
    matrix, sd = whole["covariance"]["matrix"], np.sqrt(np.diag(COVARIANCE))
    for i, j, r in ((0, 1, 0.99), (0, 2, 0.99), (1, 2, -0.99)):
        matrix[i][j] = matrix[j][i] = r * sd[i] * sd[j]


LIES = {
    "not of this program": (lambda w: w.update(format="other"), "not a camera.json"),
    "a key is missing": (lambda w: w.pop("lens"), 'lacks "lens"'),
    "a parameter is missing": (lambda w: w["parameters"].pop("b2"), 'lacks "b2"'),
    "a key too many": (lambda w: w.update(fx=1), '"fx" in the file is unknown'),
    "y down": (
        lambda w: w["convention"].update(photo="y down"),
        'another convention for "photo"',
    ),
    "no lens": (lambda w: w.update(lens="fisheye"), "lens must be one of"),
    "c negative": (parameter("c", value=-5.1), "c must be positive"),
    "c in m": (parameter("c", value=0.0051), "are all in mm"),
    "c no number": (parameter("c", value="5.1"), "c must be numbers"),
    "c true": (parameter("c", value=True), "c must be a number"),
    "another unit": (parameter("K1", unit="px^-2"), "unit of K1"),
    "NaN": (parameter("x0", value=np.nan), "NaN is not a number"),
    "infinite": (parameter("x0", value=np.inf), "Infinity is not a number"),
    "another sd": (parameter("c", sd=1.0), "sd of c is 1.0"),
    "an sd of nothing": (parameter("b1", sd=1.0), "sd of b1 is 1.0.*None"),
    "no sd": (parameter("x0", sd=None), "sd of x0 is None"),
    "size in mm": (lambda w: w.update(image_size=[5.6, 4.2]), "image_size must be"),
    "size as text": (lambda w: w.update(image_size="4032 x 3024"), "image_size must"),
    "no size": (lambda w: w.update(image_size=[0, 3024]), "image_size must be"),
    "pixels in um": (lambda w: w.update(pixel_size=1400), "are all in mm"),
    "nominal": (lambda w: w.update(pixel_size_is_nominal="no"), "True or False"),
    "not symmetric": (entry(0, 1, 1e-6), "not symmetric"),
    "variance 0": (entry(2, 2, 0.0), "y0 a variance that is not positive"),
    "not positive": (negative_eigenvalue, "not positive semi-definite"),
    "not square": (lambda w: w["covariance"]["matrix"].pop(), "must have shape"),
    "a name twice": (
        lambda w: w["covariance"].update(names=["c"] * 8),
        "each of them once",
    ),
    "no parameter": (
        lambda w: w["covariance"]["names"].__setitem__(0, "f"),
        "name of the covariance must be one of",
    ),
    "units": (lambda w: w["covariance"]["units"].reverse(), "units of the covariance"),
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


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[1, 2]", b"\xff\xfe{}", b"[" * 10**5, b"35 0 0"],
)
def test_a_damaged_or_foreign_file_is_refused(tmp_path, content):
    path = tmp_path / "x.json"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"x\.json: .*(empty|JSON|not a camera)"):
        files.read(path)


def test_a_number_that_stands_there_twice_is_refused(written):
    once = f'"pixel_size": {PIXEL}'
    text = written.read_text(encoding="utf-8")
    written.write_text(text.replace(once, f'{once}, "pixel_size": 0.002'))
    with pytest.raises(ValueError, match='"pixel_size" stands there twice'):
        files.read(written)


@pytest.mark.parametrize("end", [0.3, 0.9, 0.995])
def test_a_file_that_was_cut_off_is_refused(written, end):
    content = written.read_bytes()
    written.write_bytes(content[: int(end * len(content))])
    with pytest.raises(ValueError, match="not a whole JSON file"):
        files.read(written)


@pytest.mark.parametrize(
    "change, words",
    [
        ({"image_size": (4032.5, 3024)}, "image_size must be"),
        ({"pixel_size": 1.4}, "are all in mm"),
        ({"covariance": np.eye(3)}, r"must have shape \(10, 10\)"),
        ({"covariance": -np.eye(10)}, "not positive"),
        ({"covariance": np.eye(1), "names": ["f"]}, "must be one of"),
        ({"covariance": np.full((10, 10), np.nan)}, "not a finite number"),
        ({"about": None}, "about must be a text"),
    ],
)
def test_what_read_would_refuse_is_not_written(tmp_path, change, words):
    with pytest.raises(ValueError, match=words):
        files.write(tmp_path / "a.json", PHONE, **(GIVEN | change))
    assert not list(tmp_path.iterdir())


# --- Other programs ---


def cv2_project(matrix, distortion, points=POINTS):
    """OpenCV's camera looks along +z, with y down."""
    points, still = points * (1, -1, -1), np.zeros(3)
    return cv2.projectPoints(points, still, still, matrix, distortion)[0][:, 0]


def test_a_forward_camera_is_that_of_cv2_and_comes_back():
    found = files.to_opencv(PHONE, **GIVEN)
    expected = pixels(PHONE)
    assert np.all(np.ptp(expected, axis=0) > (3500, 2500)) and found.departure == 0
    seen = cv2_project(found.matrix, found.distortion)
    np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-9)
    again = files.from_opencv(found.matrix, found.distortion, SIZE, PIXEL)
    np.testing.assert_allclose(again.interior, PHONE.interior, rtol=1e-14, atol=1e-17)
    assert again.lens == "forward"


def test_cv2_reads_its_file_bit_by_bit(tmp_path):
    path = tmp_path / "camera.yml"
    path.write_text(files.exchange(PHONE, "opencv", **GIVEN))
    stored = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    found = files.to_opencv(PHONE, **GIVEN)
    K = stored.getNode("camera_matrix").mat()
    d = stored.getNode("distortion_coefficients").mat()
    size = [stored.getNode(f"image_{one}").real() for one in ("width", "height")]
    stored.release()
    assert K.tobytes() == found.matrix.tobytes()
    assert d.tobytes() == found.distortion.tobytes() and size == [*SIZE]


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
    seen = colmap_project(files.exchange(lens, "colmap", **GIVEN))
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
    seen = metashape_project(files.exchange(PHONE, "metashape", **GIVEN))
    np.testing.assert_allclose(seen - 0.5, pixels(PHONE), rtol=0, atol=1e-9)


BACKWARD = Camera(5.1, 0.02, -0.03, 1e-3, -2e-5, P1=1e-4, P2=-7e-5)


def test_another_camera_is_fitted_and_departs_as_stated():
    lens = replace(BACKWARD, b1=3e-4)
    found = files.to_opencv(lens, **GIVEN)
    corners = np.array([(-0.5, -0.5), (4031.5, -0.5), (-0.5, 3023.5), (4031.5, 3023.5)])
    ideal = camera.ideal(lens, frames.pixel_to_photo(corners, SIZE, PIXEL))
    rays = np.c_[ideal, np.full(4, -lens.c)]
    seen = cv2_project(found.matrix, found.distortion, rays)
    off = np.hypot(*(seen - corners).T).max()
    assert off == pytest.approx(found.departure, rel=1e-6) and 0.01 < off < 0.1
    off = np.hypot(*(cv2_project(found.matrix, found.distortion) - pixels(lens)).T)
    assert off.max() < found.departure
    assert f"by up to {found.departure:.2g} px" in files.exchange(
        lens, "colmap", **GIVEN
    )


def test_a_shear_is_refused_where_the_model_has_none_and_kept_by_metashape():
    lens = replace(BACKWARD, b1=5e-4, b2=3e-4)
    for program in ("opencv", "colmap"):
        with pytest.raises(ValueError, match=r"departs by up to 0\.4\d+ px.*0\.1"):
            files.exchange(lens, program, **GIVEN)
    assert files.to_opencv(lens, **GIVEN, largest=1).departure > 0.4
    seen = metashape_project(files.exchange(lens, "metashape", **GIVEN))
    np.testing.assert_allclose(seen - 0.5, pixels(lens), rtol=0, atol=0.05)


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
        ({"distortion": [0.1, 0.2]}, "4, 5, 8, 12 or 14 numbers"),
        ({"distortion": [0.0] * 12 + [0.1, 0.1]}, "departs by up to .* px"),
        ({"matrix": K.T}, "matrix must be"),
        ({"matrix": -K}, "matrix must be"),
        ({"matrix": K + np.eye(3, k=1)}, "matrix must be"),
    ],
)
def test_what_is_no_camera_of_opencv_is_refused(change, words):
    given = {"matrix": K, "distortion": np.zeros(5)} | change
    with pytest.raises(ValueError, match=words):
        files.from_opencv(**given, image_size=SIZE, pixel_size=PIXEL)
