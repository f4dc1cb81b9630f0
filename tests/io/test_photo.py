"""Photos of all kinds come in as the camera saw them, or are refused with a reason."""

import io
import struct
import zlib

import cv2
import numpy as np
import pytest
from PIL import Image, ImageOps, TiffImagePlugin

from pgm_lab.io import geotiff
from pgm_lab.io import photo as photos
from pgm_lab.matching import read

RNG = np.random.default_rng(5)
GREY = RNG.integers(0, 256, (12, 17), dtype=np.uint8)
DEEP = RNG.integers(0, 65536, (12, 17), dtype=np.uint16)
RGB = RNG.integers(0, 256, (12, 17, 3), dtype=np.uint8)
DEEP_RGB = RNG.integers(0, 65536, (12, 17, 3), dtype=np.uint16)
WEIGHTS = np.array([0.299, 0.587, 0.114])
# What undoes each orientation of EXIF, from its table in the standard
UPRIGHT = {
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: np.rot90(a, 2),
    4: lambda a: a[::-1],
    5: lambda a: np.swapaxes(a, 0, 1),
    6: lambda a: np.rot90(a, -1),
    7: lambda a: np.rot90(np.swapaxes(a, 0, 1), 2),
    8: lambda a: np.rot90(a, 1),
}


def saved(image, path, **options):
    if not isinstance(image, Image.Image):
        image = Image.fromarray(image)
    image.save(path, **options)
    return path


def same(found, expected):
    assert not isinstance(found, np.ma.MaskedArray)
    assert found.dtype == expected.dtype
    np.testing.assert_array_equal(found, expected)


def grey_of(photo):
    return read(photo, colour="grey")


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(
        ">I", zlib.crc32(kind + body)
    )  # fmt: skip


@pytest.mark.parametrize(
    "values, names",
    [
        (GREY, ["photo.png", "photo.tif", "photo.bmp", "Foto ä日.png"]),
        (np.repeat(GREY[..., None], 3, axis=2), ["photo.png"]),
        (DEEP, ["photo.png", "photo.tif"]),
        (GREY / np.float32(7), ["photo.tif"]),
    ],
)
def test_grey_values_of_a_file_are_those_that_were_saved(tmp_path, values, names):
    """8 and 16 bits and floats; three equal channels are grey already."""
    for name in names:
        path = saved(values, tmp_path / name)
        for photo in (path, str(path), values):
            same(read(photo), values if values.ndim == 2 else GREY)


def test_colours_are_refused_with_what_to_do_or_weighted_when_asked(tmp_path):
    for photo in (RGB, Image.fromarray(RGB), saved(RGB, tmp_path / "c.png")):
        with pytest.raises(ValueError, match='left.* has colours.*colour="grey"'):
            read(photo, "left")
        np.testing.assert_allclose(grey_of(photo), RGB @ WEIGHTS, rtol=1e-6)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["png", "jpg", "tif", "16 bits"])
def test_the_orientation_of_exif_is_followed(tmp_path, orientation, kind):
    exif = Image.Exif()
    exif[0x0112] = orientation
    if kind == "16 bits":
        path = tmp_path / "o.png"
        data = cv2.imencode(".png", DEEP_RGB[..., ::-1])[1].tobytes()
        body = chunk(b"eXIf", exif.tobytes().removeprefix(b"Exif\0\0"))
        path.write_bytes(data[:33] + body + data[33:])  # behind the header
        expected = UPRIGHT[orientation](DEEP_RGB) @ WEIGHTS
        np.testing.assert_allclose(grey_of(path), expected, rtol=1e-6)
    else:
        path = saved(GREY, tmp_path / f"o.{kind}", exif=exif)
        with Image.open(saved(GREY, tmp_path / f"0.{kind}")) as plain:
            expected = UPRIGHT[orientation](np.asarray(plain))
        same(read(path), expected)
        with Image.open(io.BytesIO(path.read_bytes())) as image:
            same(read(image), expected)
            np.testing.assert_array_equal(ImageOps.exif_transpose(image), expected)
    assert photos.shape(path, "photo") == expected.shape


def test_what_is_transparent_is_masked(tmp_path):
    alpha = np.full(GREY.shape, 255, np.uint8)
    alpha[:3], alpha[3, 0], alpha[3, 1] = 0, 127, 128
    expected = alpha < 128
    rgba = np.dstack([RGB, alpha])
    deep = np.dstack([DEEP_RGB, alpha * np.uint16(257)]).astype(np.uint16)
    path = tmp_path / "deep.png"
    path.write_bytes(cv2.imencode(".png", deep)[1].tobytes())
    for photo in (rgba, Image.fromarray(rgba), saved(rgba, tmp_path / "a.png"), path,
                  np.dstack([RGB / 255, alpha / 255])):  # fmt: skip
        np.testing.assert_array_equal(np.ma.getmaskarray(grey_of(photo)), expected)
    la = Image.fromarray(np.dstack([GREY, alpha]), "LA")
    found = read(saved(la, tmp_path / "la.png"))
    np.testing.assert_array_equal(found.mask, expected)
    np.testing.assert_array_equal(found.data[~expected], GREY[~expected])
    palette = Image.fromarray(GREY).quantize(8)
    found = read(saved(palette, tmp_path / "p.png", transparency=2))
    np.testing.assert_array_equal(found.mask, np.asarray(palette) == 2)


def test_infrared_is_no_transparency():
    """Even if the file calls it so, as GDAL does with any four bands of 8 bits."""
    infrared = RNG.integers(0, 256, GREY.shape, dtype=np.uint8)
    colours = np.dstack([RGB, infrared])
    for photo in (colours, Image.fromarray(colours), colours / 255.0):
        assert not np.ma.is_masked(grey_of(photo))


def test_a_tiff_of_unmarked_bands_is_told_what_to_do(tmp_path):
    pytest.importorskip("rasterio")
    bands, path = np.moveaxis(DEEP_RGB, 2, 0), tmp_path / "a.tif"
    geotiff.write_bands(path, bands)
    with pytest.raises(ValueError, match="-co PHOTOMETRIC=RGB -co INTERLEAVE=PIXEL"):
        read(path, colour="grey")
    geotiff.write_bands(path, bands, photometric="rgb", interleave="pixel")
    assert read(path, colour="grey").max() > 255  # the cure keeps 16 bits


def test_what_a_geotiff_states_for_no_data_is_masked(tmp_path):
    """A colour counts if all its channels have the value."""
    grey = np.arange(400, dtype=np.float32).reshape(20, 20) + 1
    rgb = np.repeat(grey[..., None], 3, axis=2).clip(0, 255).astype(np.uint8)
    grey[:5], rgb[:5], rgb[5, :, 0] = -9999, 0, 0
    for values, text in ((grey, "-9999"), (rgb, "0 ")):
        tags = TiffImagePlugin.ImageFileDirectory_v2()
        tags[photos.NODATA] = text
        Image.fromarray(values).save(tmp_path / "a.tif", tiffinfo=tags)
        found = read(tmp_path / "a.tif", colour="grey")
        assert found.mask[:5].all() and not found.mask[5:].any()


def test_masks_and_values_that_are_none_are_kept_as_masks():
    mask = GREY > 200
    found = read(np.ma.array(GREY, mask=mask))
    np.testing.assert_array_equal(found.mask, mask)
    same(found.data, GREY)
    grey = GREY / 3
    grey[2, 3], grey[4, 5], grey[0, 0] = np.nan, np.inf, -np.inf
    found = read(np.ma.array(grey, mask=mask))
    np.testing.assert_array_equal(found.mask, mask | ~np.isfinite(grey))
    colours = np.ma.array(RGB, mask=np.zeros(RGB.shape, bool))
    colours.mask[1, 2, 2] = True
    assert np.argwhere(grey_of(colours).mask).tolist() == [[1, 2]]
    same(read(np.ma.array(GREY)), GREY)


@pytest.mark.parametrize(
    ("photo", "message"),
    [
        (np.zeros(5), r"got shape \(5,\)"),
        (np.zeros((5, 5, 2)), r"got shape \(5, 5, 2\)"),
        (np.zeros((0, 5)), "has no pixels"),
        (np.full((5, 5), np.nan), "left has no data"),
        (np.ma.masked_all((5, 5)), "left has no data"),
        (None, "left must be numbers"),
        (b"photo.png", "left must be numbers"),
    ],
)
def test_arrays_that_are_no_photo_are_refused(photo, message):
    with pytest.raises(ValueError, match=message):
        read(photo, "left")
