"""Data files: complete, documented, undamaged, and named when they are not."""

import hashlib
import shutil

import numpy as np
import pytest

from pgm_lab import datasets

OURS = {"README.md", "SHA256SUMS", "audit.csv", "glossary.csv", "questions.csv"}
SUMS = datasets._checksums()


@pytest.mark.parametrize("name", sorted(SUMS))
def test_file_measured_elsewhere_has_its_checksum(name):
    content = (datasets.folder() / name).read_bytes()
    assert hashlib.sha256(content).hexdigest() == SUMS[name]


def test_every_file_has_a_checksum_or_is_our_own():
    files = {path.name for path in datasets.folder().iterdir() if path.is_file()}
    assert files == OURS | set(SUMS)


def test_every_file_has_an_entry_in_the_readme():
    readme = (datasets.folder() / "README.md").read_text(encoding="utf-8")
    for name in set(SUMS) | OURS - {"README.md"}:
        assert f"`{name}`" in readme


def test_every_column_of_a_source_table_names_its_unit():
    units = ("_px", "_mm", "_rad", "_m")
    unitless = {"point", "photo", "location", "test_points", "row", "column"}
    texts = {"parameter", "quantity", "unit", "value", "printed", "place"}
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
    assert data.xy.shape == data.sigma.shape == (450, 2)
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
    np.testing.assert_array_equal(
        data.published_exteriors_sd[0, 3:5], (1.65e-6, 1.7e-6)
    )
    np.testing.assert_array_equal(data.sigma[[0, -1]], 0.001)
    np.testing.assert_array_equal(data.object_points[1], (-84.6681, 1724.214, -162.295))
    assert data.published_exteriors[0, 3] == 1.303606
    assert np.any(data.published_object_points != data.object_points)
    np.testing.assert_array_equal(
        data.published_object_points_sd[1], (1.6e-6, 9.33e-8, 1.32e-9)
    )


def test_harintaka2020_has_the_printed_values_in_their_places():
    data = datasets.harintaka2020()
    assert data.flight["ground_sampling_distance"] == 0.20
    assert data.camera_pixel_size == 0.00549
    np.testing.assert_array_equal(data.test_points, (44, 71, 60))
    np.testing.assert_array_equal(data.automatic, (1.42, 1.75, 1.36))


def test_yellowstone_is_an_8_bit_image():
    photo = datasets.yellowstone()
    assert photo.grey.shape == (1536, 1536)
    assert photo.grey.dtype == np.uint8
    assert photo.gsd == 0.1


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


LOADERS = [
    (datasets.bani2010, "bani2010_photo_points.csv"),
    (datasets.bani2010_intersection, "bani2010_intersection.csv"),
    (datasets.muliawan2013, "muliawan2013_published_exterior_sd.csv"),
    (datasets.harintaka2020, "harintaka2020_table1.csv"),
    (datasets.yellowstone, "neon_yellowstone_ortho_10cm_gray.png"),
]


@pytest.mark.parametrize(("load", "name"), LOADERS)
def test_missing_file_is_named_with_the_way_back(copy, load, name):
    (copy / name).unlink()
    with pytest.raises(
        FileNotFoundError, match=f"data/{name} is missing.*git checkout"
    ):
        load()


@pytest.mark.parametrize(("load", "name"), LOADERS)
def test_damaged_file_is_named_with_the_way_back(copy, load, name):
    content = bytearray((copy / name).read_bytes())
    content[len(content) // 2] ^= 1
    (copy / name).write_bytes(content)
    with pytest.raises(ValueError, match=f"data/{name} is damaged.*git checkout"):
        load()


def test_short_row_in_a_table_of_our_own_is_named(copy):
    with (copy / "glossary.csv").open("a", encoding="utf-8") as file:
        file.write("only,two\n")
    with pytest.raises(ValueError, match=r"data/glossary.csv is damaged: row \d+"):
        datasets.rows("glossary.csv")


def test_folder_outside_a_clone_says_how_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(datasets, "__file__", str(tmp_path / "a" / "b.py"))
    with pytest.raises(FileNotFoundError, match=r"pip install -e \."):
        datasets.folder()
