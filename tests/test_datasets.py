"""Data files: complete, documented, undamaged, and named when they are not."""

import hashlib
import json
import shutil
import subprocess
import sys

import cv2
import numpy as np
import pytest
import skimage.data

from pgm_lab import datasets

ORIGINAL = datasets.folder()
OURS = {
    "README.md", "SHA256SUMS", "chapters.csv", "chequerboard_corners.csv",
    "course_short.csv", "course_weeks.csv", "glossary.csv",
}  # fmt: skip
PHOTOS = "chequerboard"  # the folder whose files have checksums too
SUMS = datasets.checksums()


def test_files_measured_elsewhere_have_their_checksums():
    found = {
        name: hashlib.sha256((datasets.folder() / name).read_bytes()).hexdigest()
        for name in SUMS
    }
    assert [name for name in SUMS if found[name] != SUMS[name]] == []


def test_every_file_has_a_checksum_or_is_our_own():
    folder = datasets.folder()
    files = [*folder.iterdir(), *(folder / PHOTOS).glob("*.jpg")]
    found = {p.relative_to(folder).as_posix() for p in files if p.is_file()}
    assert found == OURS | set(SUMS)


def test_every_file_has_an_entry_in_the_readme():
    readme = (datasets.folder() / "README.md").read_text(encoding="utf-8")
    for name in set(SUMS) | OURS - {"README.md"}:
        within, _, _ = name.rpartition("/")
        assert f"`{name}`" in readme or (within and f"`{within}/" in readme), name


def test_bani2010_has_the_printed_values_in_their_places():
    data = datasets.bani2010()
    assert data.pixels.shape == data.photo.shape == (2, 10, 2)
    assert data.point[9] == 10
    np.testing.assert_array_equal(data.pixels[1, 0], (810.2872020, 1127.7055676))
    np.testing.assert_array_equal(data.photo[1, 9], (-1.08881, -4.4396))


def test_bani2010_intersection_has_the_printed_matrices_in_their_places():
    printed = datasets.bani2010_intersection()
    assert printed["exterior"].shape == (2, 6)
    assert printed["A_transposed"].shape == (6, 8)
    assert printed["X"].shape == (5, 1)  # one of the six is missing in the source
    assert printed["exterior"][1, 5] == 1.0051
    assert printed["normal_inverse"][5, 3] == 10.2233
    assert printed["S0"][0, 0] == 1.51554975


def test_muliawan2013_has_the_printed_values_in_their_places():
    data = datasets.muliawan2013()
    assert data.xy.shape == (450, 2)
    assert sorted(set(data.photo)) == list(range(9))
    assert sorted(set(data.point)) == list(range(50))
    np.testing.assert_array_equal(data.xy[0], (-4.23068, 1.052707))
    np.testing.assert_array_equal(
        data.exteriors[0], (111.9599, 373.9012, 362.676, 1.308683, 0.083926, 1.469698)
    )
    assert data.interior[0] == 35.0
    np.testing.assert_array_equal(
        data.published_interior[[0, 3, 9]], (34.999985, -0.001334789, -0.007187672)
    )


def test_harintaka2020_has_the_printed_values_in_their_places():
    data = datasets.harintaka2020()
    assert data.flight["ground_sampling_distance"] == 0.20
    assert data.camera_pixel_size == 0.00549
    np.testing.assert_array_equal(data.test_points, (44, 71, 60))
    np.testing.assert_array_equal(data.automatic, (1.42, 1.75, 1.36))


def test_landsat_pair_shows_the_same_ground_processed_twice():
    one, other = datasets.landsat_pair()
    assert one.grey.shape == other.grey.shape == (600, 1000)
    assert one.grey.dtype == other.grey.dtype == np.uint16
    difference = one.grey.astype(float) - other.grey
    assert np.sqrt(np.mean(difference**2)) == pytest.approx(3.65, abs=0.01)
    assert np.mean(difference == 0) == pytest.approx(0.43, abs=0.01)
    # Row 078 is the scene that `landsat` was cut from
    np.testing.assert_array_equal(
        other.grey[180:], datasets.landsat().grey[:420, :1000]
    )
    # No other shift by whole pixels fits better
    template = other.grey[200:300, 300:500].astype(np.float32)
    score = cv2.matchTemplate(
        one.grey.astype(np.float32), template, cv2.TM_CCOEFF_NORMED
    )
    assert np.unravel_index(np.argmax(score), score.shape) == (200, 300)


@pytest.fixture(scope="module")
def motorcycle():
    return datasets.motorcycle()


def test_motorcycle_is_grey_from_0_to_255(motorcycle):
    left, right, _ = skimage.data.stereo_motorcycle()
    for grey, rgb in ((motorcycle.left, left), (motorcycle.right, right)):
        assert grey.shape == (500, 741) and grey.dtype == float
        assert 0 <= grey.min() < 10 and 245 < grey.max() <= 255
        # OpenCV weights the same way and rounds to whole grey values
        rounded = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        np.testing.assert_allclose(grey, rounded, rtol=0, atol=0.51)


def test_motorcycle_names_unknown_disparities_nan(motorcycle):
    disparity = motorcycle.disparity
    assert disparity.shape == (500, 741) and disparity.dtype == float
    known = np.isfinite(disparity)
    assert np.all(np.isnan(disparity[~known]))
    assert known.mean() == pytest.approx(0.927, abs=0.001)
    assert 7 < disparity[known].min() and disparity[known].max() < 61


WITHOUT_NETWORK = """
import json, sys

def refuse(event, _):
    if event.startswith(("socket.connect", "socket.getaddrinfo", "socket.bind")):
        raise RuntimeError("the network is cut")

sys.addaudithook(refuse)
from pgm_lab import datasets
pair = datasets.motorcycle()
print(json.dumps([pair.disparity.shape, "pooch" in sys.modules]))
"""


def test_motorcycle_needs_no_network():
    result = subprocess.run(
        [sys.executable, "-c", WITHOUT_NETWORK],
        cwd=datasets.folder().parent,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    shape, downloader = json.loads(result.stdout)
    assert shape == [500, 741]
    assert not downloader


@pytest.mark.parametrize(
    "error", [ModuleNotFoundError("pooch"), ConnectionError(), FileNotFoundError()]
)
def test_motorcycle_missing_from_scikit_image_is_named(monkeypatch, error):
    def fail():
        raise error

    monkeypatch.setattr(skimage.data, "stereo_motorcycle", fail)
    with pytest.raises(FileNotFoundError, match="motorcycle.*force-reinstall"):
        datasets.motorcycle()


def test_known_points_of_a_grid_are_those_with_a_disparity_and_no_others():
    pair = datasets.motorcycle()
    points, disparity = pair.known(range(0, 741, 37), range(0, 500, 41))
    grid = {(x, y) for x in range(0, 741, 37) for y in range(0, 500, 41)}
    left_out = grid - set(map(tuple, points.tolist()))
    assert set(map(tuple, points.tolist())) < grid and len(points) < len(grid)
    assert all(np.isnan(pair.disparity[y, x]) for x, y in left_out)
    np.testing.assert_array_equal(disparity, pair.disparity[points[:, 1], points[:, 0]])


def test_glossary_has_every_term_once_and_in_both_languages():
    terms = datasets.rows("glossary.csv")
    assert all(row["english"] and row["indonesian"] and row["meaning"] for row in terms)
    english = [row["english"] for row in terms]
    assert english == sorted(set(english), key=str.lower)


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the data folder that a test may damage."""
    shutil.copytree(datasets.folder(), tmp_path / "data")
    monkeypatch.setattr(datasets, "folder", lambda: tmp_path / "data")
    return tmp_path / "data"


@pytest.mark.parametrize(
    ("load", "name"),
    [
        (datasets.bani2010, "bani2010_photo_points.csv"),
        (datasets.muliawan2013, "muliawan2013_published_exterior_sd.csv"),
        (datasets.yellowstone, "neon_yellowstone_ortho_10cm_gray.png"),
        (datasets.landsat_pair, "landsat8_itaipu_red_30m_row078.png"),
    ],
)
def test_damaged_or_missing_file_is_named_with_the_way_back(copy, load, name):
    content = bytearray((copy / name).read_bytes())
    content[len(content) // 2] ^= 1
    (copy / name).write_bytes(content)
    with pytest.raises(ValueError, match=f"data/{name} is damaged.*git checkout"):
        load()
    (copy / name).unlink()
    with pytest.raises(FileNotFoundError, match=f"data/{name} is missing.*git"):
        load()


def test_installed_data_come_before_those_of_a_clone(monkeypatch, tmp_path):
    package = tmp_path / "site-packages" / "pgm_lab"
    package.mkdir(parents=True)
    monkeypatch.setattr(datasets, "__file__", str(package / "datasets.py"))
    with pytest.raises(FileNotFoundError, match=r"install pgm_lab again.*-e \."):
        datasets.folder()
    for place in (tmp_path / "site-packages" / "data", package / "data"):
        shutil.copytree(ORIGINAL, place)
        assert datasets.folder() == place.resolve()
        assert datasets.path("chapters.csv") == place.resolve() / "chapters.csv"


def test_a_table_is_read_by_its_path_too(tmp_path):
    (tmp_path / "one.csv").write_text("a,b\n1,é\n", encoding="utf-8")
    (tmp_path / "two.csv").write_text("a,b\n2,y\n", encoding="utf-8")
    one, two = {"a": "1", "b": "é"}, {"a": "2", "b": "y"}
    assert datasets.rows(tmp_path / "one.csv") == [one]
    assert datasets.rows(str(tmp_path)) == [one, two]
    with pytest.raises(FileNotFoundError, match="^(?!data).*three.csv is missing"):
        datasets.rows(tmp_path / "three.csv")
