"""Photos of all kinds come in as the camera saw them, or are refused with a reason."""

import io
import os
import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image, ImageOps

from pgm_lab.io.photo import read

RNG = np.random.default_rng(5)
GREY = RNG.integers(0, 256, (12, 17), dtype=np.uint8)
DEEP = RNG.integers(0, 65536, (12, 17), dtype=np.uint16)
RGB = RNG.integers(0, 256, (12, 17, 3), dtype=np.uint8)
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


@pytest.mark.parametrize(
    "name", ["photo.png", "photo.tif", "photo.bmp", "Foto ä日.png"]
)
def test_grey_values_of_a_file_are_those_that_were_saved(tmp_path, name):
    path = saved(GREY, tmp_path / name)
    same(read(path), GREY)
    same(read(str(path)), GREY)


@pytest.mark.parametrize("name", ["photo.png", "photo.tif"])
def test_16_bits_stay_16_bits(tmp_path, name):
    same(read(saved(DEEP, tmp_path / name)), DEEP)


def test_floats_of_a_tiff_stay_floats(tmp_path):
    same(read(saved(GREY / np.float32(7), tmp_path / "f.tif")), GREY / np.float32(7))


@pytest.mark.parametrize("name", ["photo.png", "photo.tif"])
def test_colours_of_16_bits_keep_them_all(tmp_path, name):
    rgb = RNG.integers(0, 65536, (12, 17, 3), dtype=np.uint16)
    path = tmp_path / name
    path.write_bytes(cv2.imencode(path.suffix, rgb[..., ::-1])[1].tobytes())
    grey = read(path, colour="grey")
    np.testing.assert_allclose(grey, rgb @ WEIGHTS, rtol=1e-6)
    assert grey.dtype == np.float32 and np.any(grey > 255)


def test_colours_are_refused_with_what_to_do_or_weighted_when_asked(tmp_path):
    for photo in (RGB, Image.fromarray(RGB), saved(RGB, tmp_path / "c.png")):
        with pytest.raises(ValueError, match='left.* has colours.*colour="grey"'):
            read(photo, "left")
        np.testing.assert_allclose(read(photo, colour="grey"), RGB @ WEIGHTS, rtol=1e-6)


def test_three_equal_channels_are_grey_already(tmp_path):
    path = saved(np.repeat(GREY[..., None], 3, axis=2), tmp_path / "g.png")
    same(read(path), GREY)


def test_a_palette_is_looked_up(tmp_path):
    image = Image.fromarray(RGB).convert("P")
    expected = np.asarray(image.convert("RGB")) @ WEIGHTS
    for photo in (
        image,
        saved(image, tmp_path / "p.png"),
        saved(image, tmp_path / "p.gif"),
    ):
        np.testing.assert_allclose(read(photo, colour="grey"), expected, rtol=1e-6)
    image = Image.fromarray(GREY)
    same(read(image.quantize(256)), np.asarray(image.quantize(256).convert("L")))


def test_other_colour_spaces_become_red_green_and_blue(tmp_path):
    image = Image.fromarray(RGB).convert("CMYK")
    expected = np.asarray(image.convert("RGB")) @ WEIGHTS
    np.testing.assert_allclose(read(image, colour="grey"), expected, rtol=1e-6)
    assert read(saved(image, tmp_path / "c.jpg"), colour="grey").shape == (12, 17)


def test_black_and_white_becomes_0_and_255():
    image = Image.fromarray(GREY).convert("1")
    assert set(np.unique(read(image))) == {0, 255}


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["png", "jpg", "tif"])
def test_the_orientation_of_exif_is_followed(tmp_path, orientation, kind):
    path = tmp_path / f"o.{kind}"
    exif = Image.Exif()
    exif[0x0112] = orientation
    saved(GREY, path, exif=exif)
    expected = UPRIGHT[orientation](
        np.asarray(Image.open(saved(GREY, tmp_path / f"0.{kind}")))
    )
    with Image.open(io.BytesIO(path.read_bytes())) as image:
        same(read(image), expected)
        np.testing.assert_array_equal(ImageOps.exif_transpose(image), expected)
    same(read(path), expected)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_the_orientation_is_followed_in_colours_of_16_bits_too(tmp_path, orientation):
    rgb = RNG.integers(0, 65536, (12, 17, 3), dtype=np.uint16)
    exif = Image.Exif()
    exif[0x0112] = orientation
    data = cv2.imencode(".png", rgb[..., ::-1])[1].tobytes()
    body = exif.tobytes().removeprefix(b"Exif\0\0")
    chunk = b"eXIf" + body
    chunk = struct.pack(">I", len(body)) + chunk + struct.pack(">I", zlib.crc32(chunk))
    path = tmp_path / "o.png"
    path.write_bytes(data[:33] + chunk + data[33:])  # behind the header
    turned = UPRIGHT[orientation](rgb)
    np.testing.assert_allclose(read(path, colour="grey"), turned @ WEIGHTS, rtol=1e-6)


def test_what_is_transparent_is_masked(tmp_path):
    alpha = np.full(GREY.shape, 255, np.uint8)
    alpha[:3], alpha[3, 0], alpha[3, 1] = 0, 127, 128
    expected = alpha < 128
    rgba = np.dstack([RGB, alpha])
    la = np.dstack([GREY, alpha])
    deep = np.dstack(
        [RNG.integers(0, 65536, (12, 17, 3)), alpha * np.uint16(257)]
    ).astype(np.uint16)
    path = tmp_path / "deep.png"
    path.write_bytes(cv2.imencode(".png", deep)[1].tobytes())
    for photo in (rgba, Image.fromarray(rgba), saved(rgba, tmp_path / "a.png"), path,
                  np.dstack([RGB / 255, alpha / 255])):  # fmt: skip
        found = read(photo, colour="grey")
        np.testing.assert_array_equal(np.ma.getmaskarray(found), expected)
    found = read(saved(Image.fromarray(la, "LA"), tmp_path / "la.png"))
    np.testing.assert_array_equal(found.mask, expected)
    np.testing.assert_array_equal(found.data[~expected], GREY[~expected])


def test_a_transparent_colour_of_a_palette_is_masked(tmp_path):
    image = Image.fromarray(GREY).quantize(8)
    path = saved(image, tmp_path / "p.png", transparency=2)
    found = read(path)
    np.testing.assert_array_equal(found.mask, np.asarray(image) == 2)


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
    assert np.argwhere(read(colours, colour="grey").mask).tolist() == [[1, 2]]
    same(read(np.ma.array(GREY)), GREY)


def test_types_that_opencv_does_not_take_are_changed():
    assert read(GREY.astype(">u2")).dtype == np.uint16
    assert read(GREY.astype(np.float16)).dtype == np.float32
    assert read(GREY.astype(np.int64)).dtype == float
    assert read(GREY > 9).dtype == np.uint8
    same(read(GREY.tolist()), GREY.astype(float))


@given(arrays.arrays(np.uint8, st.tuples(*[st.integers(1, 9)] * 2)))
def test_any_grey_photo_comes_back_from_memory_and_from_png(grey):
    same(read(grey), grey)
    same(read(Image.fromarray(grey)), grey)
    file = io.BytesIO()
    Image.fromarray(grey).save(file, "png")
    with Image.open(file) as image:
        same(read(image), grey)


@given(st.binary(max_size=400), st.sampled_from(["png", "tiff", "jpeg", "none"]))
def test_no_file_whatever_it_holds_fails_from_deep_inside(tmp_path_factory, data, kind):
    path = tmp_path_factory.mktemp("bytes") / "photo"
    begin = io.BytesIO()
    if kind != "none":
        Image.fromarray(GREY).save(begin, kind)
    path.write_bytes(begin.getvalue()[: len(data) // 2] + data)
    try:
        read(path)
    except ValueError as error:
        assert "\n" not in str(error) and str(path) in str(error)


def test_files_that_cannot_be_read_say_so_in_a_line(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"right, .*x\.png: there is no such"):
        read(tmp_path / "x.png", "right")
    with pytest.raises(IsADirectoryError, match="this is a folder, not a file"):
        read(tmp_path)
    with pytest.raises(OSError, match="cannot be read"):
        read("null\0byte")
    (tmp_path / "empty.png").touch()
    with pytest.raises(ValueError, match="empty.png: the file is empty"):
        read(tmp_path / "empty.png")
    (tmp_path / "text.png").write_text("no photo")
    with pytest.raises(ValueError, match="not an image that can be read; save it as"):
        read(tmp_path / "text.png")


@pytest.mark.parametrize("kind", ["png", "jpg", "tif"])
def test_a_file_that_was_cut_off_is_damaged(tmp_path, kind):
    path = saved(np.tile(GREY, (20, 20)), tmp_path / f"whole.{kind}")
    cut = tmp_path / f"cut.{kind}"
    cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ValueError, match=f"cut.{kind}: the image is damaged"):
        read(cut)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes there")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="a pipe or a device"):
        read(tmp_path / "pipe")


def test_a_bomb_is_not_unpacked(tmp_path):
    """A file of a few bytes that says it has 30000 x 30000 pixels."""
    data = io.BytesIO()
    Image.fromarray(GREY).save(data, "png")
    data = bytearray(data.getvalue())
    data[16:24] = struct.pack(">II", 30_000, 30_000)
    data[29:33] = struct.pack(">I", zlib.crc32(data[12:29]))
    (tmp_path / "bomb.png").write_bytes(data)
    with pytest.raises(ValueError, match="too many pixels"):
        read(tmp_path / "bomb.png")


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
