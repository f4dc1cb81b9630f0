"""Damaged files: read, or refused by name; never a crash, another error or a hang.

What is told apart one by one stands in `test_hostile.py`. Here good files are damaged
at random: by a fixed seed, or by new ones for the seconds that FUZZ_SECONDS says, as at
night. What is found there gets a test of its own.
"""

import io
import os
import time
import warnings

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st
from PIL import Image

from pgm_lab import bundle, matching, observations, registration, stereo, stereo_map
from pgm_lab.camera import PARAMETERS, Camera
from pgm_lab.camera.files import CameraFile
from tests.bundle.test_files import GOOD
from tests.io.rasters import GREY, saved
from tests.io.test_hostile import frames, pages, photo_file

SECONDS = float(os.environ.get("FUZZ_SECONDS", 0))  # for each kind of file
EXAMPLES = 500  # a round
PATIENCE = 5.0  # seconds for one file, which take milliseconds
BYTES = (GREY % 200).astype(np.uint8)
WORDS = b"nan inf -1e999 1e300 1,5 1d3 1_0 +-1 0x1 % , ; \t \r \0 \xff \xef\xbb\xbf"

damage = st.lists(
    st.tuples(
        st.floats(0, 1),  # where
        st.integers(0, 12),  # how many bytes go
        st.one_of(st.binary(max_size=8), st.sampled_from(WORDS.split(b" "))),
    ),
    min_size=1,
    max_size=6,
)
number = st.one_of(
    st.floats(),
    st.sampled_from([0.0, 1e-9, 0.1, 3.7e6, 2.1e5, 1e12, 1e200]),
)


def damaged(data, changes):
    for where, gone, put in changes:
        at = int(where * len(data))
        data = data[:at] + put + data[at + gone :]
    return data


def array():
    file = io.BytesIO()
    np.save(file, BYTES)
    return file.getvalue()


def corpus(folder):
    """Small good files of all kinds, by name."""
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(BYTES).save(folder / "exif.jpg", exif=exif)
    for suffix in ("png", "jpg", "tif") + ("jp2",) * cv2.haveImageWriter("a.jp2"):
        cv2.imwrite(str(folder / f"a.{suffix}"), BYTES)
    (folder / "a.npy").write_bytes(array())
    pages(folder / "pages.tif", 0, 1, 4)
    frames(folder / "a.gif")
    saved(folder / "map.tif")
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def readers(name):
    """What reads a file of this name."""
    photo = [
        lambda path: photo_file(path).read(),
        lambda path: photo_file(path).blank(),
    ]
    if name.endswith("npy"):
        return photo
    exif = [lambda path: stereo_map.exif_camera(path, (30, 20))]
    return [registration.read, matching.read, *photo, *exif]


def survives(read, path):
    """Read a file, or have it refused by name, soon."""
    begin = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of Pillow and GDAL, about the damage
            read(path)
    except (ValueError, OSError) as error:
        assert path.name in str(error) and "\n" not in str(error)
    assert time.perf_counter() - begin < PATIENCE


def rounds(check, **strategies):
    """Check the same examples always, or new ones as long as there is time."""
    end, number = time.monotonic() + SECONDS, 0
    if SECONDS:
        number = time.time_ns() % 2**32
    while True:
        test = settings(
            max_examples=EXAMPLES, database=None, deadline=None, print_blob=False,
            suppress_health_check=list(HealthCheck),
        )(given(**strategies)(check))  # fmt: skip
        seed(number)(test)()
        number += 1
        if time.monotonic() >= end:
            return


@pytest.mark.slow
def test_damaged_images_are_read_or_refused_by_name(tmp_path):
    (tmp_path / "good").mkdir()
    good = corpus(tmp_path / "good")

    def check(name, changes):
        path = tmp_path / name
        path.write_bytes(damaged(good[name], changes))
        for read in readers(name):
            survives(read, path)

    rounds(check, name=st.sampled_from(sorted(good)), changes=damage)


@pytest.mark.slow
def test_damaged_tables_are_read_or_refused_by_name(tmp_path):
    paths = [tmp_path / name for name in GOOD]

    def check(name, changes):
        for path in paths:
            path.write_text(GOOD[path.name])
        path = tmp_path / name
        path.write_bytes(damaged(GOOD[name].encode(), changes))
        survives(registration.read_points, path)
        survives(observations.read, path)
        survives(lambda _: bundle.read(*paths), path)

    rounds(check, name=st.sampled_from(sorted(GOOD)), changes=damage)


@pytest.mark.slow
def test_damaged_cameras_are_read_or_refused_by_name(tmp_path):
    path = tmp_path / "camera.json"
    known = {"estimate": PARAMETERS, "covariance": np.diag(np.arange(1, 11) * 1e-12)}
    CameraFile(Camera(35.0, 0.1, K1=1e-5), (4000, 3000), 0.006, **known).save(path)
    good = path.read_bytes()

    def check(changes):
        path.write_bytes(damaged(good, changes))
        survives(Camera.read, path)

    rounds(check, changes=damage)


@pytest.mark.slow
def test_points_of_any_size_are_written_as_they_are_or_refused(tmp_path):
    laspy = pytest.importorskip("laspy")
    path = tmp_path / "a.las"

    def check(xyz, sd):
        n = len(xyz)
        points = stereo.Points(
            np.array(xyz), np.full((n, 3), sd), np.ones(n), np.ones((n, 2), int)
        )

        if (np.abs(points.xyz) <= 1e30).all():
            las = laspy.read(stereo.save_points(points, path, overwrite=True))
            off = np.abs(np.stack([las.x, las.y, las.z], -1) - points.xyz)
            assert (off <= las.header.scales).all()
        else:
            with pytest.raises(ValueError, match=r"points\.xyz\[.* are NaN, inf"):
                stereo.save_points(points, path, overwrite=True)

    xyz = st.lists(st.tuples(number, number, number), min_size=1, max_size=4)
    rounds(check, xyz=xyz, sd=st.floats(0, 1e30))
