"""Files with their place on the map: written by rasterio and read by us, and back."""

import os
import subprocess
import sys
import time
import warnings

import cv2
import numpy as np
import pytest
from PIL import Image

from pgm_lab.io import geotiff
from pgm_lab.io.geotiff import Raster, read, write
from tests.io.rasters import GREY, NOWHERE, UTM, on_map, saved


@pytest.fixture
def rasterio():
    return pytest.importorskip("rasterio")


@pytest.fixture
def without_rasterio(monkeypatch):
    """As on a computer where rasterio was never installed."""
    monkeypatch.setitem(sys.modules, "rasterio", None)
    assert not geotiff.installed()


@pytest.fixture(params=["rasterio", "without_rasterio"])
def both(request):
    """With rasterio and without it."""
    return request.getfixturevalue(request.param)


def test_what_rasterio_wrote_is_read(tmp_path):
    """AREA_OR_POINT=Point moves nothing: GDAL turns it into corners both ways."""
    found = read(saved(tmp_path / "a.tif", tags={"AREA_OR_POINT": "Point"}))
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


def test_bands_with_their_names_and_tags(tmp_path, rasterio):
    path, bands = tmp_path / "a.tif", np.stack([GREY / 2, GREY]).astype(np.float32)
    more = dict(nodata=np.nan, names=("height", "source"), tags={2: {"meaning": "0"}})
    geotiff.write_bands(path, bands, UTM, "EPSG:32748", compress="deflate", **more)
    with rasterio.open(path) as file:
        assert np.array_equal(file.read(), bands) and np.isnan(file.nodata)
        assert file.descriptions == ("height", "source")
        assert file.tags(2)["meaning"] == "0" and file.compression.name == "deflate"
    with pytest.raises(ValueError, match="crs 'EPSG:1' is not known; give it as"):
        geotiff.write_bands(path, bands, UTM, "EPSG:1")
    with pytest.raises(OSError, match="No such file"):
        geotiff.write_bands(tmp_path / "no" / "a.tif", bands)


def test_places_are_those_of_rasterio(tmp_path, rasterio):
    """A pixel's centre has whole numbers here, and .5 in a GeoTIFF; rows are turned."""
    transform = np.column_stack([[[0.96, -0.28], [0.28, 0.96]] @ UTM[:, :2], UTM[:, 2]])
    path = saved(tmp_path / "a.tif", transform=transform)
    found = read(path)
    row, column = np.mgrid[0:20, 0:30].reshape(2, -1)
    pixels = np.stack([column, row], axis=1)
    with rasterio.open(path) as file:
        theirs = np.transpose(file.xy(row, column))
        corner = file.xy(0, 0, offset="ul")
    assert found.map(pixels) == pytest.approx(theirs, abs=1e-6)
    assert found.map((-0.5, -0.5)) == pytest.approx(corner, abs=1e-6)
    assert found.pixels(theirs) == pytest.approx(pixels, abs=1e-6)


@pytest.mark.parametrize("dtype", "u1 i2 u2 f4 f8 i4 u4 c8".split())
def test_types_of_files(tmp_path, rasterio, dtype):
    grey = (GREY % 200).astype(dtype)
    path = saved(tmp_path / "a.tif", grey)
    if dtype == "c8":
        with pytest.raises(ValueError, match="complex numbers; take their modulus"):
            read(path)
        return
    found = read(path)
    assert np.array_equal(found.grey, grey)
    kept = "f8" if dtype in ("i4", "u4") else dtype  # which OpenCV cannot match
    assert found.grey.dtype == kept
    again = read(write(tmp_path / "b.tif", found))
    assert again.grey.dtype == kept and np.array_equal(again.grey, grey)


def test_no_data_from_the_tag_the_mask_the_argument_and_nan(tmp_path):
    none = GREY == 77
    assert np.array_equal(read(saved(tmp_path / "t.tif", nodata=77)).mask, none)
    masked = read(saved(tmp_path / "m.tif", mask=none))
    assert np.array_equal(masked.mask, none)
    assert np.array_equal(np.ma.getmaskarray(masked.values), none)
    forced = read(saved(tmp_path / "a.tif", nodata=5), nodata=77)
    assert np.array_equal(forced.mask, none) and forced.nodata == 77
    grey = np.where(none, np.nan, GREY).astype(np.float32)
    assert np.array_equal(read(saved(tmp_path / "n.tif", grey)).mask, none)
    alpha = np.where(none, 0, 65535).astype(np.uint16)
    found = read(saved(tmp_path / "b.tif", np.stack([GREY, alpha]), alpha="yes"))
    assert np.array_equal(found.grey, GREY) and np.array_equal(found.mask, none)
    for name in ("m.tif", "b.tif"):  # what marks pixels beside a value is kept
        both = read(tmp_path / name, 1, nodata=78).mask
        assert np.array_equal(both, none | (GREY == 78))
    with pytest.raises(ValueError, match=r"t\.tif: there is no data in it"):
        read(saved(tmp_path / "t.tif", np.zeros_like(GREY), nodata=0))


def test_several_bands_are_named_and_chosen(tmp_path):
    bands = np.stack([GREY, GREY + 1, GREY + 2])
    path = saved(tmp_path / "a.tif", bands, names=("red", "green", "nir"))
    with pytest.raises(ValueError, match=r"3 bands, 1 \(red\), .*3 \(nir\).* band=1"):
        read(path)
    assert np.array_equal(read(path, 2).grey, GREY + 1)
    assert np.array_equal(read(path, band=3).grey, GREY + 2)
    with pytest.raises(ValueError, match="no band 4"):
        read(path, band=4)


def test_sixty_thousand_bands_take_no_hour(tmp_path, rasterio):
    path = saved(tmp_path / "a.tif")
    one, many = (b"\x15\1\3\0\1\0\0\0" + count for count in (b"\1\0", b"\1\xff"))
    assert path.read_bytes().count(one) == 1  # the tag of samples per pixel
    path.write_bytes(path.read_bytes().replace(one, many))
    begin = time.perf_counter()
    with pytest.raises(ValueError, match="it has 65281 bands, 1 .*say which one"):
        read(path)
    assert time.perf_counter() - begin < 60


def test_feet_become_metres_and_degrees_have_no_size(tmp_path):
    found = read(saved(tmp_path / "a.tif", crs="EPSG:2225"))  # US survey feet
    assert found.pixel_size == pytest.approx(6 * 1200 / 3937)
    degrees = np.array([[5e-5, 0, 106.8], [0, -5e-5, -6.2]])
    found = read(saved(tmp_path / "a.tif", transform=degrees, crs="EPSG:4326"))
    assert found.pixel_size is None and "gdalwarp -t_srs" in found.remark
    assert found.map((0, 0)) == pytest.approx((106.800025, -6.200025))
    found = read(saved(tmp_path / "a.tif", crs=None))
    assert np.array_equal(found.transform, UTM) and found.crs is None
    assert found.pixel_size is None and "unit of the map is not known" in found.remark


@pytest.mark.parametrize("suffix", [".tif", ".png"])
def test_images_on_no_map(tmp_path, both, suffix):
    path = write(tmp_path / f"a{suffix}", Raster(GREY, NOWHERE))
    assert np.array_equal(cv2.imread(str(path), cv2.IMREAD_UNCHANGED), GREY)
    found = read(path)
    assert np.array_equal(found.grey, GREY) and found.grey.dtype == np.uint16
    assert found.transform is None and found.pixel_size is None
    assert found.remark == "no georeference: shifts are in pixels only"
    for there in (found.map, found.pixels):
        with pytest.raises(ValueError, match="has no georeference"):
            there((0, 0))


def test_colours_need_a_band(tmp_path, both):
    red = np.arange(60, dtype=np.uint8).reshape(6, 10)
    Image.fromarray(np.stack([red, red + 1, red + 2], axis=2)).save(tmp_path / "a.png")
    with pytest.raises(ValueError, match=r"3 bands, 1 \(red\), 2 \(green\).*band=1"):
        read(tmp_path / "a.png")
    assert np.array_equal(read(tmp_path / "a.png", 3).grey, red + 2)
    with pytest.raises(ValueError, match="no band 4"):
        read(tmp_path / "a.png", 4)


def test_without_rasterio_nothing_is_left_away_in_silence(tmp_path, monkeypatch):
    paths = [saved(tmp_path / "a.tif"),
             saved(tmp_path / "b.tif", transform=None, nodata=7)]  # fmt: skip
    rgba = np.full((6, 10, 4), 255, np.uint8)
    rgba[2, 3, 3] = 0
    Image.fromarray(rgba).save(tmp_path / "c.png")
    monkeypatch.setitem(sys.modules, "rasterio", None)
    for path in paths:
        with pytest.raises(ImportError, match="GeoTIFF.*pip install rasterio"):
            read(path)
    assert np.argwhere(read(tmp_path / "c.png", 1).mask).tolist() == [[2, 3]]
    with pytest.raises(ImportError, match="georeference, rasterio is needed"):
        write(tmp_path / "d.tif", on_map())
    with pytest.raises(ImportError, match="without data, rasterio is needed"):
        write(tmp_path / "d.tif", Raster(GREY, GREY == 5))
    assert len(list(tmp_path.iterdir())) == 3


# --- Files that are something else ---


@pytest.mark.parametrize(
    "content, error, message",
    [
        (None, FileNotFoundError, "there is no such file"),
        (b"", ValueError, "the file is empty"),
        (b"column,row\n1,2\n", ValueError, "not an image|damaged"),
        (b"II*\0" + 40 * b"\xff", ValueError, "not an image|damaged"),
    ],
)
def test_files_that_are_no_images(tmp_path, both, content, error, message):
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
    profile |= {"tiled": True, "blockxsize": 8192, "blockysize": 8192}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rasterio.open(path, "w", width=25_000, height=25_000, **profile).close()
    with pytest.raises(ValueError, match="25000 x 25000 pixels, but is far too short"):
        read(path)


@pytest.mark.parametrize("suffix", [".tif", ".png", ".jpg"])
def test_a_file_that_was_cut_off(tmp_path, both, suffix):
    grey = np.random.default_rng(1).integers(0, 256, (300, 400), dtype=np.uint8)
    path = tmp_path / f"a{suffix}"
    cv2.imwrite(str(path), grey)
    data = path.read_bytes()
    assert read(path).grey.shape == (300, 400)
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match="damaged|not an image"):
        read(path)


# --- Writing ---


@pytest.mark.parametrize(
    "raster, name, message",
    [
        (on_map(), "a.png", "PNG cannot hold a georeference.*end in .tif"),
        (on_map(crs=None), "a.png", "PNG cannot hold a georeference.*end in .tif"),
        (on_map(transform=None), "a.png", "PNG cannot hold a georeference"),
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
    assert path.read_text() == "mine"
    write(path, Raster(GREY, NOWHERE), overwrite=True)
    assert np.array_equal(read(path).grey, GREY)
    assert len(list(tmp_path.iterdir())) == 1


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


ALL = np.arange(256, dtype=np.uint8).reshape(16, 16)


@pytest.mark.parametrize(
    "grey, none, nodata, expected",
    [
        (GREY, 9, None, 0),
        (GREY, 9, 60000, 60000),  # as the file states it
        (GREY, 9, 10, 0),  # 10 is in use
        (GREY, 9, -9999, 0),  # no uint16
        (GREY - 1, 9, None, 65535),
        (ALL, 7, None, 7),
        (GREY / 2, 9, 5, np.nan),
    ],
)
def test_no_data_gets_a_value_that_no_pixel_has(
    tmp_path, rasterio, grey, none, nodata, expected
):
    """0 first, then the highest, then any that is free; or the one of the file."""
    mask = grey == none
    found = read(write(tmp_path / "a.tif", Raster(grey, mask, nodata=nodata)))
    assert np.array_equal(found.mask, mask)
    assert np.array_equal(found.grey[~mask], grey[~mask])
    assert np.array_equal(found.nodata, expected, equal_nan=True)


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
