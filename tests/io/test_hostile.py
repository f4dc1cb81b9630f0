"""Files made to harm: nothing is run, fetched, waited for or unpacked without end."""

import http.server
import os
import pickle
import re
import struct
import threading
import time
import warnings
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from pgm_lab import matching, observations, registration, stereo_map
from pgm_lab.camera import Camera
from pgm_lab.io import text
from pgm_lab.stereo import PhotoFile
from tests.io.rasters import GREY, UTM, saved
from tests.io.test_photo import chunk

BYTES = (GREY % 200).astype(np.uint8)
OTHER = Image.fromarray(BYTES[::-1].copy())
SVG = '<svg xmlns="http://www.w3.org/2000/svg"><image href="file:///etc/passwd"/></svg>'
VRT = """<VRTDataset rasterXSize="30" rasterYSize="20">
<Metadata><MDI key="INTERNAL_MASK_FLAGS_1">2</MDI></Metadata><VRTRasterBand
dataType="Byte" band="1"><SimpleSource><SourceFilename>{}</SourceFilename>
</SimpleSource></VRTRasterBand></VRTDataset>"""
WORLD = "6\n0\n0\n-6\n700003\n9319997\n"  # the centre of the first pixel
AUX = """<PAMDataset><SRS>{}</SRS>
<GeoTransform>8e5,6,0,9.32e6,0,-6</GeoTransform></PAMDataset>"""


def photo_file(path):
    return PhotoFile(path, Camera(50.0), (0,) * 6, 0.005)


READERS = {
    "registration": registration.read,
    "matching": matching.read,
    "PhotoFile": lambda path: photo_file(path).read(),
    "its head": lambda path: photo_file(path).blank(),
    "EXIF": lambda path: stereo_map.exif_camera(path, (30, 20)),
}


def png(**header):
    """A PNG of a few bytes that says how large it is."""
    data = cv2.imencode(".png", BYTES)[1].tobytes()
    size = b"".join(header[one].to_bytes(4, "big") for one in ("width", "height"))
    return data[:8] + chunk(b"IHDR", size + data[24:29]) + data[33:]


def put(folder, name, content):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def eps(folder):
    """Code for Ghostscript, which Pillow would start."""
    OTHER.save(folder / "a.jpg", "EPS")
    return folder / "a.jpg"


def fifo(folder):
    os.mkfifo(folder / "a.tif")
    return folder / "a.tif"


def zipped(folder):
    with zipfile.ZipFile(folder / "a.zip", "w") as archive:
        archive.write(saved(folder / "b.tif"), "b.tif")
    return f"/vsizip/{folder}/a.zip/b.tif"


def unreadable(folder):
    path = saved(folder / "a.tif")
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    return path


POSIX = pytest.mark.skipif(os.name == "nt", reason="pipes and modes of POSIX")
NONE, MANY = "not an image that can be read", "too many pixels"


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(
    "make, message",
    [
        (lambda folder: put(folder, "a.tif", VRT.format("b.tif")), NONE),
        (lambda folder: put(folder, "a.png", VRT.format("b.tif")), NONE),
        (lambda folder: put(folder, "a.jpg", VRT.format("/etc/passwd")), NONE),
        (lambda folder: put(folder, "a.jp2", VRT.format("b.tif")), NONE),
        (lambda folder: put(folder, "a.png", SVG), NONE),
        (lambda folder: put(folder, "a.jpg", "1 2\n"), NONE),
        (eps, NONE),
        (lambda folder: put(folder, "a.png", png(width=60_000, height=60_000)), MANY),
        (lambda folder: put(folder, "a.png", png(width=3000, height=30)), "damaged"),
        (zipped, "there is no such file"),
        (lambda folder: "zip://a.zip!b.tif", "on this computer; got the address"),
        (lambda folder: "http://127.0.0.1/a.tif", "on this computer; got the address"),
        (lambda folder: "/vsicurl/http://127.0.0.1/a.tif", "there is no such file"),
        (lambda folder: "", "must be the name of a file; got ''"),
        (lambda folder: folder, "this is a folder"),
        pytest.param(fifo, "this is a pipe", marks=POSIX),
        pytest.param(unreadable, "cannot be read", marks=POSIX),
    ],
)
def test_what_is_no_image_is_named_and_refused(tmp_path, reader, make, message):
    path = make(tmp_path)
    with pytest.raises((ValueError, OSError), match=message) as caught:
        READERS[reader](path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_registration_names_a_command_that_converts(tmp_path):
    with pytest.raises(ValueError, match="gdal_translate -of GTiff"):
        registration.read(put(tmp_path, "a.tif", VRT.format("b.tif")))


@POSIX
def test_a_link_is_followed(tmp_path):
    (tmp_path / "a.tif").symlink_to(saved(tmp_path / "b.tif"))
    assert np.array_equal(registration.read(tmp_path / "a.tif").grey, GREY)
    assert np.array_equal(matching.read(tmp_path / "a.tif"), GREY)


# --- Files beside an image ---


@pytest.fixture
def server():
    """An address on this computer, and what was asked from it."""
    asked = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            self.send_error(404)

        do_HEAD = do_GET

        def log_message(self, *_):
            pass

    with http.server.HTTPServer(("127.0.0.1", 0), Handler) as here:
        thread = threading.Thread(target=here.serve_forever, args=(0.01,))
        thread.start()
        yield f"http://127.0.0.1:{here.server_port}", asked
        here.shutdown()
        thread.join()


@pytest.mark.parametrize("suffix", ["tif", "png"])
def test_a_mask_that_leads_elsewhere_is_refused(tmp_path, server, suffix):
    """GDAL opens it by any of its drivers: other files, and the network."""
    rasterio = pytest.importorskip("rasterio")
    address, asked = server
    path, other = tmp_path / f"a.{suffix}", saved(tmp_path / "other.tif", BYTES)
    cv2.imwrite(str(path), BYTES)
    for place in (f"/vsicurl/{address}/b", str(other)):
        put(tmp_path, f"{path.name}.msk", VRT.format(place))
        message = rf"beside .*a\.{suffix}\.msk: .* is no TIFF"
        with pytest.raises(ValueError, match=message):
            registration.read(path)
    assert asked == []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with rasterio.open(path) as file:
            assert np.array_equal(file.read_masks(1), BYTES)


def test_a_system_of_the_map_is_not_fetched(tmp_path, server):
    address, asked = server
    path = saved(tmp_path / "a.tif")
    put(tmp_path, "a.tif.aux.xml", AUX.format(f"{address}/srs"))
    with pytest.raises(ValueError, match=r"a\.tif: .*network|NETWORK"):
        registration.read(path)
    assert asked == []


@pytest.mark.parametrize(
    "suffix, placed, name, content, beside, east",
    [
        ("tif", True, "a.tif.aux.xml", AUX.format(""), "a.tif.aux.xml", 800_000),
        ("tif", True, "a.tfw", WORLD.replace("70", "90"), "", 700_000),  # not obeyed
        ("tif", False, "a.tfw", WORLD, "a.tfw", 700_000),
        ("png", False, "a.pgw", WORLD, "a.pgw", 700_000),
        ("jpg", False, "a.jgw", WORLD, "a.jgw", 700_000),
        ("tif", True, "a.txt", WORLD, "", 700_000),
    ],
)
def test_a_file_that_moves_the_image_is_named(
    tmp_path, suffix, placed, name, content, beside, east
):
    pytest.importorskip("rasterio")
    path = tmp_path / f"a.{suffix}"
    if placed:
        saved(path)
    else:
        cv2.imwrite(str(path), BYTES)
    put(tmp_path, name, content)
    found = registration.read(path)
    assert found.beside == beside and found.transform[0, 2] == east


@POSIX
@pytest.mark.parametrize("name", ["a.tfw", "a.wld", "a.tab", "a.aux", "a_RPC.TXT"])
def test_a_pipe_beside_an_image_is_not_waited_for(tmp_path, name):
    path = saved(tmp_path / "a.tif")
    os.mkfifo(tmp_path / name)
    with pytest.raises(OSError, match=f"{name}: this is a pipe"):
        registration.read(path)


def test_a_mask_beside_an_image_moves_nothing(tmp_path):
    rasterio = pytest.importorskip("rasterio")
    with rasterio.Env(GDAL_TIFF_INTERNAL_MASK=False):
        path = saved(tmp_path / "a.tif", mask=GREY == 77)
    assert (tmp_path / "a.tif.msk").exists()
    found = registration.read(path)
    assert np.array_equal(found.mask, GREY == 77) and found.beside == ""


# --- Several pictures, palettes, and how the camera was held ---


def frames(path, kind=None):
    first = Image.fromarray(BYTES)
    first.save(path, kind, save_all=True, append_images=[OTHER])
    return path


def pages(path, *kinds, big=False):
    """A TIFF with pages of some kinds: 0 a picture, 1 a smaller one, 4 a mask."""
    number, field, word = ("<Q", "<HHQQ", "<Q") if big else ("<H", "<HHII", "<I")
    data = b"II+\0\x08\0\0\0" if big else b"II*\0"
    data += struct.pack(word, struct.calcsize(word) + len(data))
    for k, kind in enumerate(kinds, 1):
        tags = {254: kind, 256: 30, 257: 20, 258: 8, 259: 1, 262: 1, 273: 0, 277: 1,
                278: 20, 279: 600}  # fmt: skip
        size = struct.calcsize(number) + len(tags) * struct.calcsize(field)
        tags[273] = len(data) + size + struct.calcsize(word)  # where the pixels begin
        data += struct.pack(number, len(tags))
        for tag, value in tags.items():
            data += struct.pack(field, tag, 4, 1, value)
        data += struct.pack(word, tags[273] + 600 if k < len(kinds) else 0)
        data += BYTES.tobytes()
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("reader", ["registration", "matching", "PhotoFile"])
@pytest.mark.parametrize(
    "make, several",
    [
        (lambda folder: pages(folder / "a.tif", 0), False),
        (lambda folder: pages(folder / "a.tif", 0, 1, 1, 4), False),
        (lambda folder: pages(folder / "a.tif", 0, 1, 0), True),
        (lambda folder: pages(folder / "a.tif", *[0] * 100), True),
        (lambda folder: pages(folder / "a.tif", 0, 1, big=True), False),
        (lambda folder: pages(folder / "a.tif", 0, 0, big=True), True),
        (lambda folder: frames(folder / "a.png"), True),
        (lambda folder: frames(folder / "a.gif"), True),
        (lambda folder: frames(folder / "a.jpg", "MPO"), False),  # of a phone
    ],
)
def test_of_several_pictures_none_is_taken_in_silence(tmp_path, reader, make, several):
    path = make(tmp_path)
    if several:
        with pytest.raises(ValueError, match=r"a\.\w+: .*several pictures, pages or"):
            READERS[reader](path)
    else:
        found = READERS[reader](path)
        off = np.abs(getattr(found, "grey", found) - BYTES.astype(float))
        assert off.mean() < (5 if path.suffix == ".jpg" else 1e-9)


def test_numbers_of_a_palette_are_no_grey_values(tmp_path):
    pytest.importorskip("rasterio")
    colours = Image.fromarray(np.dstack([BYTES, BYTES[::-1], BYTES])).quantize(16)
    for suffix in ("png", "tif"):
        colours.save(tmp_path / f"a.{suffix}")
        with pytest.raises(ValueError, match=rf"a\.{suffix}: .*palette.*-expand rgb"):
            registration.read(tmp_path / f"a.{suffix}")
    Image.fromarray(BYTES).convert("P").save(tmp_path / "grey.png")
    assert np.array_equal(registration.read(tmp_path / "grey.png").grey, BYTES)


@pytest.mark.parametrize("orientation", [*range(1, 10), "a text"])
@pytest.mark.parametrize("suffix", ["png", "jpg", "tif"])
def test_both_readers_turn_an_image_upright(tmp_path, suffix, orientation):
    """Without a place on the map; with one it stays as it is stored."""
    exif = Image.Exif()
    exif[0x0112] = 6 if orientation == "a text" else orientation
    path = tmp_path / f"a.{suffix}"
    Image.fromarray(BYTES).save(path, exif=exif, quality=100)
    if orientation == "a text" and suffix != "png":  # whose checksum would be wrong
        tag = b"\x12\1\3\0" if suffix == "tif" else b"\1\x12\0\3"
        data = path.read_bytes()
        assert data.count(tag) == 1
        path.write_bytes(data.replace(tag, tag.replace(b"\3", b"\2")))
    assert np.array_equal(registration.read(path).grey, matching.read(path))
    pytest.importorskip("rasterio")
    put(tmp_path, f"a.{suffix[0]}{suffix[-1]}w", WORLD)
    found = registration.read(path)
    assert np.allclose(found.grey, BYTES, atol=3)
    assert np.array_equal(found.transform, UTM)


# --- What the library does without ---

FORBIDDEN = r"^\s*(?:import|from) (urllib|http|requests|pickle|marshal|shelve)\b"
RUNS = r"(?<![\w.])(?:eval|exec)\(|allow_pickle=True"


def test_the_library_fetches_nothing_and_runs_no_data():
    files = list(Path(registration.__file__).parents[1].rglob("*.py"))
    assert len(files) > 90
    for file in files:
        source = file.read_text(encoding="utf-8")
        assert not re.findall(f"{FORBIDDEN}|{RUNS}", source, re.MULTILINE), file


# --- Arrays ---


class Harm:
    """What a pickle of it does when it is loaded."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def pickled(path):
    np.save(path, np.array([Harm(path.with_name("harm"))], object), allow_pickle=True)


def lying(path, shape=b"(9999,9)"):
    np.save(path, BYTES)
    path.write_bytes(path.read_bytes().replace(b"(20, 30)", shape))


def cut(path):
    lying(path, b"(20,(30,")


def renamed(path):
    np.savez(path.with_suffix(".npz"), BYTES)
    path.with_suffix(".npz").rename(path)


@pytest.mark.parametrize("head", [False, True])
@pytest.mark.parametrize(
    "make",
    [pickled, lying, cut, renamed, lambda path: path.write_bytes(pickle.dumps(1))],
)
def test_an_array_with_objects_or_a_wrong_head_is_refused(tmp_path, make, head):
    make(tmp_path / "a.npy")
    photo = photo_file(tmp_path / "a.npy")
    with pytest.raises(ValueError, match=r"a\.npy: this is no array of numbers"):
        photo.blank() if head else photo.read()
    assert not (tmp_path / "harm").exists()
    np.save(tmp_path / "a.npy", BYTES[:0])
    with pytest.raises(ValueError, match=r"a\.npy: its shape is \(0, 30\), not"):
        photo.blank() if head else photo.read()


# --- Texts ---

GOOD = "1,1,5.5,1.1,.002,.003\n"


@pytest.mark.parametrize(
    "content, message",
    [
        (GOOD + '2,1,"5.0",1,.002,.003\n', 'line 2: .*"5.0".*without quotation marks'),
        ('"1",1,5.5,1,.002,.003\n', "line 1: .*without quotation marks"),
        ("point,photo,x,y,sx,sy\n" + GOOD, "line 1: .*a heading needs a %"),
        (GOOD * 2 + "2,1,5.5,1.1,.0", "line 3: 5 column.*is it cut off"),
        (GOOD + "2,1,5.0,1.0\n" + GOOD, "line 2: 4 column.*is it cut off"),
        (GOOD + "2,1,1e300,1.1,.002,.003", "line 2: a number is too large"),
        (GOOD + "\0", "line 2: this is not text"),
        ("1," * 100_000, "line 1: 100000 column"),
        ("1" * 20_000 + "x", "line 1: .* is not a number"),
        ("1" * 20_000 + " , ;", "line 1: 1 column"),
    ],
)
def test_texts_are_refused_by_line_and_in_no_time(tmp_path, content, message):
    """Each takes milliseconds; patterns that go back and forth took up to 14 s."""
    begin = time.perf_counter()
    with pytest.raises(ValueError, match=re.escape("a.txt, ") + message) as caught:
        observations.read(put(tmp_path, "a.txt", content))
    assert time.perf_counter() - begin < 2 and len(str(caught.value)) < 500


def test_a_text_as_large_as_a_disk_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(text, "MAX_BYTES", 1 << 20)
    with pytest.raises(ValueError, match=r"a\.txt: the file has more than 1 MB"):
        observations.read(put(tmp_path, "a.txt", b"1 " * (1 << 20)))
