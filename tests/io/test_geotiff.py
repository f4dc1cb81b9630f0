"""Files with their place on the map: written by rasterio and read by us, and back."""

import os
import subprocess
import sys
import warnings
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image

from pgm_lab import registration
from pgm_lab.io import geotiff as _geotiff
from pgm_lab.registration import Raster, offset, read, read_points, write

GREY = np.arange(1, 601, dtype=np.uint16).reshape(20, 30)
NOWHERE = np.zeros(GREY.shape, bool)
UTM = np.array([[6.0, 0, 700_000], [0, -6, 9_320_000]])


@pytest.fixture
def rasterio():
    return pytest.importorskip("rasterio")


@pytest.fixture
def without_rasterio(monkeypatch):
    """As on a computer where rasterio was never installed."""
    monkeypatch.setitem(sys.modules, "rasterio", None)
    assert not _geotiff.installed()


def geotiff(path, grey=GREY, transform=UTM, crs="EPSG:32748", **more):
    """A file written by rasterio alone."""
    rasterio = pytest.importorskip("rasterio")
    bands = grey if grey.ndim == 3 else grey[None]
    tags, mask, names = (more.pop(name, None) for name in ("tags", "mask", "names"))
    if transform is not None:
        more |= {"transform": rasterio.Affine(*np.ravel(transform)), "crs": crs}
    profile = dict(driver="GTiff", count=len(bands), dtype=bands.dtype, **more)
    rows, columns = bands.shape[1:]
    profile |= {"height": rows, "width": columns}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a file without georeference
        file = rasterio.open(path, "w", **profile)
    with file:
        if tags:
            file.update_tags(**tags)
        file.write(bands)
        if names:
            file.descriptions = names
        if mask is not None:
            file.write_mask(~mask)
    return path


def on_map(**more):
    return replace(Raster(GREY, NOWHERE, UTM, "EPSG:32748"), **more)


def test_what_rasterio_wrote_is_read(tmp_path):
    found = read(geotiff(tmp_path / "a.tif"))
    assert np.array_equal(found.grey, GREY) and found.grey.dtype == np.uint16
    assert not found.mask.any() and found.values is found.grey
    assert np.array_equal(found.transform, UTM)
    assert found.crs == "EPSG:32748" and found.nodata is None
    assert np.array_equal(found.pixel_size, (6, 6)) and found.remark == ""
    assert found.path == str(tmp_path / "a.tif")


def test_what_is_written_is_read_by_rasterio(tmp_path, rasterio):
    mask = GREY > 590
    path = write(tmp_path / "a.tif", on_map(mask=mask))
    with rasterio.open(path) as file:
        assert np.array_equal(np.ravel(file.transform[:6]), UTM.ravel())
        assert file.crs == rasterio.CRS.from_epsg(32748)
        assert file.dtypes == ("uint16",) and file.nodata == 0
        assert np.array_equal(file.read(1, masked=True).mask, mask)
        assert np.array_equal(file.read(1)[~mask], GREY[~mask])


@pytest.mark.parametrize("turned", [0.0, 0.3])
def test_places_are_those_of_rasterio(tmp_path, rasterio, turned):
    """A pixel's centre has whole numbers here, and .5 in a GeoTIFF."""
    turn = [[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]]
    transform = np.column_stack([turn @ UTM[:, :2], UTM[:, 2]])
    path = geotiff(tmp_path / "a.tif", transform=transform)
    found = read(path)
    row, column = np.mgrid[0:20, 0:30].reshape(2, -1)
    pixels = np.stack([column, row], axis=1)
    with rasterio.open(path) as file:
        theirs = np.transpose(file.xy(row, column))
        corner = file.xy(0, 0, offset="ul")
        index = [file.index(*one) for one in theirs]
    assert found.map(pixels) == pytest.approx(theirs, abs=1e-6)
    assert found.map((-0.5, -0.5)) == pytest.approx(corner, abs=1e-6)
    assert found.pixels(theirs) == pytest.approx(pixels, abs=1e-6)
    assert np.array_equal(np.round(found.pixels(theirs))[:, ::-1], index)


def test_a_tag_that_counts_from_centres_moves_nothing(tmp_path):
    """AREA_OR_POINT=Point: GDAL turns it into corners both ways."""
    found = read(geotiff(tmp_path / "a.tif", tags={"AREA_OR_POINT": "Point"}))
    assert np.array_equal(found.transform, UTM)


@pytest.mark.parametrize(
    "dtype", ["uint8", "int16", "uint16", "float32", "float64", "int32", "uint32"]
)
def test_types(tmp_path, rasterio, dtype):
    grey = (GREY % 200).astype(dtype)
    found = read(geotiff(tmp_path / "a.tif", grey))
    assert np.array_equal(found.grey, grey)
    kept = dtype not in ("int32", "uint32")  # OpenCV cannot match these
    assert found.grey.dtype == (dtype if kept else "float64")
    if kept:
        again = read(write(tmp_path / "b.tif", found))
        assert again.grey.dtype == dtype and np.array_equal(again.grey, grey)


@pytest.mark.parametrize(
    "dtype, kept",
    [("bool", "uint8"), (">u2", "uint16"), ("float16", "float32"), ("i8", "float64")],
)
def test_types_that_no_file_has_become_the_next(tmp_path, rasterio, dtype, kept):
    grey = (GREY % 2).astype(dtype)
    found = read(write(tmp_path / "a.tif", Raster(grey, NOWHERE)))
    assert found.grey.dtype == kept and np.array_equal(found.grey, grey)


def test_complex_values_are_refused(tmp_path):
    path = geotiff(tmp_path / "a.tif", GREY.astype(np.complex64))
    with pytest.raises(ValueError, match="complex numbers; take their modulus"):
        read(path)


def test_no_data_from_the_tag_the_mask_the_argument_and_nan(tmp_path):
    none = GREY == 77
    assert np.array_equal(read(geotiff(tmp_path / "t.tif", nodata=77)).mask, none)
    masked = read(geotiff(tmp_path / "m.tif", mask=none))
    assert np.array_equal(masked.mask, none)
    assert np.array_equal(np.ma.getmaskarray(masked.values), none)
    forced = read(geotiff(tmp_path / "a.tif", nodata=5), nodata=77)
    assert np.array_equal(forced.mask, none) and forced.nodata == 77
    grey = np.where(none, np.nan, GREY).astype(np.float32)
    assert np.array_equal(read(geotiff(tmp_path / "n.tif", grey)).mask, none)


def test_nothing_but_no_data_is_an_error(tmp_path):
    path = geotiff(tmp_path / "a.tif", np.zeros_like(GREY), nodata=0)
    with pytest.raises(ValueError, match=r"a\.tif: there is no data in it"):
        read(path)


def test_several_bands_are_named_and_chosen(tmp_path):
    bands = np.stack([GREY, GREY + 1, GREY + 2])
    path = geotiff(tmp_path / "a.tif", bands, names=("red", "green", "nir"))
    with pytest.raises(ValueError, match=r"3 bands, 1 \(red\), .*3 \(nir\).* band=1"):
        read(path)
    assert np.array_equal(read(path, 2).grey, GREY + 1)
    assert np.array_equal(read(path, band=3).grey, GREY + 2)
    with pytest.raises(ValueError, match="no band 4"):
        read(path, band=4)


def test_an_alpha_channel_is_a_mask_and_no_band(tmp_path):
    alpha = np.where(GREY == 77, 0, 65535).astype(np.uint16)
    path = geotiff(tmp_path / "a.tif", np.stack([GREY, alpha]), alpha="yes")
    found = read(path)
    assert np.array_equal(found.grey, GREY)
    assert np.array_equal(found.mask, GREY == 77)


def test_feet_become_metres(tmp_path):
    found = read(geotiff(tmp_path / "a.tif", crs="EPSG:2225"))  # US survey feet
    assert found.pixel_size == pytest.approx(6 * 1200 / 3937)


def test_degrees_have_no_size_in_metres_and_the_remark_says_so(tmp_path):
    degrees = np.array([[5e-5, 0, 106.8], [0, -5e-5, -6.2]])
    found = read(geotiff(tmp_path / "a.tif", transform=degrees, crs="EPSG:4326"))
    assert found.pixel_size is None and "degrees" in found.remark
    assert "gdalwarp -t_srs" in found.remark
    assert found.map((0, 0)) == pytest.approx((106.800025, -6.200025))


def test_a_map_without_a_coordinate_reference_system(tmp_path):
    found = read(geotiff(tmp_path / "a.tif", crs=None))
    assert np.array_equal(found.transform, UTM) and found.crs is None
    assert found.pixel_size is None and "unit of the map is not known" in found.remark


@pytest.mark.parametrize("kind", ["with", "without"])
@pytest.mark.parametrize("suffix", [".tif", ".png"])
def test_images_on_no_map(tmp_path, kind, suffix, request):
    request.getfixturevalue("rasterio" if kind == "with" else "without_rasterio")
    path = write(tmp_path / f"a{suffix}", Raster(GREY, NOWHERE))
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), GREY)
    found = read(path)
    assert np.array_equal(found.grey, GREY) and found.grey.dtype == np.uint16
    assert found.transform is None and found.pixel_size is None
    assert found.remark == "no georeference: shifts are in pixels only"
    with pytest.raises(ValueError, match="has no georeference"):
        found.map((0, 0))
    with pytest.raises(ValueError, match="has no georeference"):
        found.pixels((0, 0))


@pytest.mark.parametrize("kind", ["with", "without"])
def test_colours_need_a_band(tmp_path, kind, request):
    request.getfixturevalue("rasterio" if kind == "with" else "without_rasterio")
    red = np.arange(60, dtype=np.uint8).reshape(6, 10)
    Image.fromarray(np.stack([red, red + 1, red + 2], axis=2)).save(tmp_path / "a.png")
    with pytest.raises(ValueError, match=r"3 bands, 1 \(red\), 2 \(green\).*band=1"):
        read(tmp_path / "a.png")
    assert np.array_equal(read(tmp_path / "a.png", 3).grey, red + 2)
    with pytest.raises(ValueError, match="no band 4"):
        read(tmp_path / "a.png", 4)


def test_without_rasterio_a_geotiff_says_what_to_install(tmp_path, monkeypatch):
    path = geotiff(tmp_path / "a.tif")
    bare = geotiff(tmp_path / "b.tif", transform=None, nodata=7)
    monkeypatch.setitem(sys.modules, "rasterio", None)
    for one in (path, bare):
        with pytest.raises(ImportError, match="GeoTIFF.*pip install rasterio"):
            read(one)


def test_without_rasterio_nothing_is_left_away_in_silence(tmp_path, without_rasterio):
    with pytest.raises(ImportError, match="georeference, rasterio is needed"):
        write(tmp_path / "a.tif", on_map())
    with pytest.raises(ImportError, match="without data, rasterio is needed"):
        write(tmp_path / "a.tif", Raster(GREY, GREY == 5))
    assert list(tmp_path.iterdir()) == []


def test_without_rasterio_transparent_pixels_have_no_data(tmp_path, without_rasterio):
    rgba = np.dstack(
        [np.full((6, 10, 3), 9, np.uint8), np.full((6, 10), 255, np.uint8)]
    )
    rgba[2, 3, 3] = 0
    Image.fromarray(rgba).save(tmp_path / "a.png")
    assert np.argwhere(read(tmp_path / "a.png", 1).mask).tolist() == [[2, 3]]


@pytest.mark.parametrize(
    "raster, name, message",
    [
        (on_map(), "a.png", "PNG cannot hold a georeference.*end in .tif"),
        (Raster(GREY, GREY == 5), "a.png", "PNG cannot hold pixels without data"),
        (Raster(GREY / 2, NOWHERE), "a.png", "PNG cannot hold float64"),
        (Raster(GREY, NOWHERE), "a.jpg", "must end in .tif or .png"),
        (Raster(GREY, NOWHERE), "a", "must end in .tif or .png"),
    ],
)
def test_a_file_that_cannot_hold_the_image(tmp_path, raster, name, message):
    with pytest.raises(ValueError, match=message):
        write(tmp_path / name, raster)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".tif", ".png"])
def test_nothing_is_overwritten_unless_asked(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    path.write_text("mine")
    with pytest.raises(FileExistsError, match="already exists"):
        write(path, Raster(GREY, NOWHERE))
    assert path.read_text() == "mine" and len(list(tmp_path.iterdir())) == 1
    write(path, Raster(GREY, NOWHERE), overwrite=True)
    assert np.array_equal(read(path).grey, GREY)
    assert len(list(tmp_path.iterdir())) == 1


def test_a_file_that_breaks_off_leaves_the_old_one(tmp_path, monkeypatch):
    path = write(tmp_path / "a.tif", Raster(GREY, NOWHERE))

    def broken(part, *_, **__):
        part.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(_geotiff, "installed", lambda: True)
    monkeypatch.setattr(_geotiff, "write_bands", broken)
    with pytest.raises(OSError, match=r"a\.tif: it cannot be written \(No space"):
        write(path, Raster(GREY + 1, NOWHERE), overwrite=True)
    monkeypatch.undo()
    assert np.array_equal(read(path).grey, GREY)
    assert len(list(tmp_path.iterdir())) == 1


def test_no_data_gets_a_value_that_no_pixel_has(tmp_path, rasterio):
    """0 first, then the highest, then any that is free; or the one of the file."""

    def stated(grey, mask, nodata=None):
        path = write(
            tmp_path / "a.tif", Raster(grey, mask, nodata=nodata), overwrite=True
        )
        found = read(path)
        assert np.array_equal(found.mask, mask)
        assert np.array_equal(found.grey[~mask], grey[~mask])
        return found.nodata

    all_values = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert stated(GREY, GREY == 9) == 0
    assert stated(GREY, GREY == 9, 60000) == 60000
    assert stated(GREY, GREY == 9, 10) == 0  # 10 is in use
    assert stated(GREY, GREY == 9, -9999) == 0  # no uint16
    assert stated(GREY - 1, GREY == 9) == 65535
    assert stated(all_values, all_values == 7) == 7
    assert np.isnan(stated(GREY / 2, GREY == 9, 5))
    with pytest.raises(ValueError, match="all grey values of uint8 are in use"):
        write(
            tmp_path / "b.tif",
            Raster(np.tile(all_values, 2), np.eye(16, 32, dtype=bool)),
        )
    assert not (tmp_path / "b.tif").exists()


@pytest.mark.parametrize(
    "parts, message",
    [
        ((GREY, NOWHERE[1:]), r"mask must be True or False for each pixel, \(20, 30\)"),
        ((GREY, NOWHERE.astype(int)), "mask must be True or False"),
        ((GREY[0], NOWHERE[0]), "grey must have shape"),
        ((GREY, NOWHERE, np.eye(3)), r"transform must have shape \(2, 3\)"),
    ],
)
def test_parts_that_do_not_fit_together(parts, message):
    with pytest.raises(ValueError, match=message):
        Raster(*parts)


def test_other_pixels_in_the_same_place():
    again = on_map().with_values(np.ma.masked_less(GREY / 2, 3))
    assert np.array_equal(again.transform, UTM) and again.crs == "EPSG:32748"
    assert again.grey.dtype == float and np.array_equal(again.mask, GREY / 2 < 3)
    with pytest.raises(ValueError, match=r"shape \(20, 30\); got \(19, 30\)"):
        on_map().with_values(GREY[1:])


DAMAGED = {
    "missing": (None, FileNotFoundError, "there is no such file"),
    "empty": (b"", ValueError, "the file is empty"),
    "text": (b"column,row\n1,2\n", ValueError, "not an image|damaged"),
    "no TIFF": (b"II*\0" + 40 * b"\xff", ValueError, "not an image|damaged"),
}


@pytest.mark.parametrize("kind", ["with", "without"])
@pytest.mark.parametrize("what", DAMAGED)
def test_files_that_are_no_images(tmp_path, kind, what, request):
    request.getfixturevalue("rasterio" if kind == "with" else "without_rasterio")
    content, error, message = DAMAGED[what]
    path = tmp_path / "image.tif"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(error, match=message) as caught:
        read(path)
    assert type(caught.value) is error and "image.tif" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_more_pixels_than_fit_into_memory(tmp_path, rasterio):
    """A file of a few bytes may claim them: no block of it was ever written."""
    profile = dict(driver="GTiff", count=1, dtype="uint8", sparse_ok=True)
    path = tmp_path / "a.tif"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rasterio.open(path, "w", width=100_000, height=100_000, **profile).close()
    assert path.stat().st_size < 10_000_000
    with pytest.raises(ValueError, match="100000 x 100000 pixels are too many"):
        read(path)


def test_a_folder_is_no_image(tmp_path):
    with pytest.raises(IsADirectoryError, match="this is a folder"):
        read(tmp_path)


@pytest.mark.parametrize("kind", ["with", "without"])
@pytest.mark.parametrize("suffix", [".tif", ".png", ".jpg"])
def test_a_file_that_was_cut_off(tmp_path, kind, suffix, request):
    request.getfixturevalue("rasterio" if kind == "with" else "without_rasterio")
    grey = np.random.default_rng(1).integers(0, 256, (300, 400), dtype=np.uint8)
    path = tmp_path / f"a{suffix}"
    cv2.imwrite(str(path), grey)
    data = path.read_bytes()
    assert read(path).grey.shape == (300, 400)
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match="damaged|not an image"):
        read(path)


FULL = """
import resource, signal, sys
import numpy as np
from pgm_lab.registration import Raster, write
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
grey = np.random.default_rng(1).integers(0, 60000, (500, 500)).astype(np.uint16)
try:
    write(sys.argv[1], Raster(grey, np.zeros(grey.shape, bool)), overwrite=True)
except OSError as error:
    print(error)
"""


@pytest.mark.skipif(os.name == "nt", reason="no such limit on Windows")
@pytest.mark.parametrize("suffix", [".tif", ".png"])
def test_a_full_disk_leaves_the_old_file(tmp_path, suffix, rasterio):
    """A process whose files may not have more than 200,000 bytes."""
    path = write(tmp_path / f"a{suffix}", Raster(GREY, NOWHERE))
    command = [sys.executable, "-c", FULL, path]
    done = subprocess.run(command, capture_output=True, text=True)
    assert "it cannot be written" in done.stdout, done.stderr
    assert np.array_equal(read(path).grey, GREY)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.skipif(os.name == "nt" or not hasattr(os, "geteuid"), reason="rights")
def test_a_folder_that_cannot_be_written(tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root may write everywhere")
    tmp_path.chmod(0o500)
    with pytest.raises(OSError, match="cannot be written"):
        write(tmp_path / "a.tif", Raster(GREY, NOWHERE))


def test_offset_of_two_images_on_one_map(tmp_path):
    """The same point of the map, through both files."""
    moved = UTM + [[0, 0, 63.0], [0, 0, -30]]
    one = read(geotiff(tmp_path / "a.tif"))
    other = read(geotiff(tmp_path / "b.tif", GREY[:15], transform=moved))
    found = offset(one, other)
    assert found == pytest.approx((-10.5, -5))
    there = other.pixels(one.map((12.0, 7.0)))
    assert there == pytest.approx(found + (12, 7), abs=1e-6)


def test_offset_without_georeference_is_none():
    assert np.array_equal(offset(Raster(GREY, NOWHERE), Raster(GREY, NOWHERE)), (0, 0))


@pytest.mark.parametrize(
    "other, message",
    [
        (Raster(GREY, NOWHERE), "one image has no georeference and the reference"),
        (on_map(crs="EPSG:32747"), "different coordinate.*EPSG:32748 and EPSG:32747"),
        (on_map(crs=None), "different coordinate.*EPSG:32748 and none"),
        (
            on_map(transform=UTM * [[1.001, 1, 1], [1, 1, 1]]),
            "6 x 6 and 6.006 x 6 map units.*gdalwarp -t_srs EPSG:32748 -tr 6 6 ",
        ),
        (on_map(transform=UTM + [[0, 0, 180], [0, 0, 0]]), "no part of the map"),
        (on_map(transform=UTM + [[0, 0, 0], [0, 0, 120]]), "no part of the map"),
    ],
)
def test_images_whose_grids_do_not_fit(other, message):
    with pytest.raises(ValueError, match=message):
        offset(on_map(), other)


def test_one_map_under_two_names_is_one(rasterio):
    text = rasterio.CRS.from_epsg(32748).to_wkt()
    assert np.array_equal(offset(on_map(), on_map(crs=text)), (0, 0))


def test_a_size_that_differs_in_its_last_digits_is_the_same():
    assert offset(on_map(), on_map(transform=UTM * (1 + 1e-12))) == pytest.approx(
        0, abs=1e-3
    )


def test_points_in_map_coordinates(tmp_path):
    pixels = np.array([(3.0, 4), (10.25, 7.5)])
    path = tmp_path / "points.csv"
    np.savetxt(path, on_map().map(pixels), delimiter=",")
    assert read_points(path, on_map()) == pytest.approx(pixels, abs=1e-6)
    np.savetxt(path, pixels, delimiter=",")
    assert np.array_equal(read_points(path), pixels)
    with pytest.raises(ValueError, match="no georeference"):
        read_points(path, Raster(GREY, NOWHERE))


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "points.csv: the file holds no numbers"),
        ("1,2,3\n", r"points.csv, line 1: 3 column\(s\), where points have 2"),
        ("column,row\n1.5,2\n", "points.csv, line 1: 'column' is not a number"),
        ("1.5,2\n1.5,x\n", "points.csv, line 2: 'x' is not a number"),
    ],
)
def test_tables_that_are_no_points(tmp_path, text, message):
    path = tmp_path / "points.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_points(path)


def test_everything_is_in_the_room():
    assert set(registration.__all__) >= {"Raster", "offset", "read", "write"}
