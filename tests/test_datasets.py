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
from scipy import ndimage

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


def test_every_column_of_a_source_table_names_its_unit():
    units = ("_px", "_mm", "_rad", "_m")
    unitless = {"point", "photo", "location", "test_points", "row", "column"}
    texts = {"parameter", "quantity", "unit", "value", "sd", "printed", "place"}
    for name in SUMS:
        if name.endswith(".csv"):
            for column in datasets.rows(name)[0]:
                assert column.endswith(units) or column in unitless | texts, name


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


def test_images_have_their_bits_and_are_neither_stretched_nor_cut():
    photo, image = datasets.yellowstone(), datasets.landsat()
    assert (photo.grey.shape, photo.grey.dtype, photo.gsd) == ((1536, 1536), "u1", 0.1)
    assert (image.grey.shape, image.grey.dtype, image.gsd) == ((1200, 1200), "u2", 30)
    assert 5000 < image.grey.min() < 6000 and 20_000 < image.grey.max() < 30_000


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


def textured(pair, n=500):
    """Places (column, row) with a clear texture and disparities within 1 px around."""
    disparity = np.where(np.isfinite(pair.disparity), pair.disparity, -1e9)
    spread = ndimage.maximum_filter(disparity, 15) - ndimage.minimum_filter(
        disparity, 15
    )
    mean = ndimage.uniform_filter(pair.left, 15)
    variance = ndimage.uniform_filter(pair.left**2, 15) - mean**2
    good = (spread < 1) & (variance > 15**2)
    good[:20], good[-20:], good[:, :80], good[:, -20:] = 0, 0, 0, 0
    rows, columns = np.nonzero(good)
    chosen = np.random.default_rng(1).choice(len(rows), n, replace=False)
    return columns[chosen], rows[chosen]


def windows(image, columns, rows, half=7):
    """Windows (n, k) around real-valued columns, bilinear."""
    offsets = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
    places = rows[:, None] + offsets[0], columns[:, None] + offsets[1]
    return ndimage.map_coordinates(image, places, order=1)


def test_motorcycle_disparity_can_be_trusted_to_a_tenth_of_a_pixel(motorcycle):
    # Least squares along the rows with an offset of the grey values, one step
    half = 5
    columns, rows = textured(motorcycle, 3000)
    left = windows(motorcycle.left, columns, rows, half)
    # The truth differs from pixel to pixel: each pixel goes to its own place
    offsets = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
    r, c = rows[:, None] + offsets[0], columns[:, None] + offsets[1]
    x = c - motorcycle.disparity[r, c]

    def right(shift):
        return ndimage.map_coordinates(motorcycle.right, (r, x + shift), order=5)

    def slope(before, after):
        return (after - before) / 2

    around = [windows(motorcycle.left, columns + s, rows, half) for s in (-1, 1)]
    gradient = (slope(*around) + slope(right(-1), right(1))) / 2
    gradient -= gradient.mean(axis=1, keepdims=True)
    misfit = left - right(0)
    power = np.sum(gradient**2, axis=1)
    clear = power > 10**2 * gradient.shape[1]
    shift = np.sum(gradient * misfit, axis=1)[clear] / power[clear]
    median = np.median(shift)
    sd = 1.4826 * np.median(np.abs(shift - median))
    assert clear.sum() > 1000
    assert median == pytest.approx(-0.08, abs=0.02)
    assert sd == pytest.approx(0.08, abs=0.02)


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


def test_short_row_in_a_table_of_our_own_is_named(copy):
    with (copy / "glossary.csv").open("a", encoding="utf-8") as file:
        file.write("only,two\n")
    with pytest.raises(ValueError, match=r"data/glossary.csv is damaged: .* row \d+"):
        datasets.rows("glossary.csv")


@pytest.mark.parametrize(
    ("field", "file"),
    [
        ("sigma", "image_points"),
        ("exteriors", "exterior_approx"),
        ("object_points", "object_points_approx"),
        ("published_exteriors", "published_exterior"),
        ("published_exteriors_sd", "published_exterior_sd"),
        ("published_exterior_differences", "published_exterior_difference"),
        ("published_object_points", "published_object_points"),
        ("published_object_points_sd", "published_object_points_sd"),
        ("published_object_point_differences", "published_object_points_difference"),
    ],
)
def test_each_table_of_muliawan2013_is_that_of_its_file(field, file):
    found = getattr(datasets.muliawan2013(), field)
    rows = datasets.rows(f"muliawan2013_{file}.csv")
    wanted = ("X_mm", "Y_mm", "Z_mm", "XL_mm", "YL_mm", "ZL_mm", "sx_mm", "sy_mm")
    wanted += ("omega_rad", "phi_rad", "kappa_rad")
    names = [name for name in wanted if name in rows[0]]
    np.testing.assert_array_equal(
        found, [[float(row[name]) for name in names] for row in rows]
    )
