"""Text files of a network: what is read, what is refused, and where it says so."""

import codecs
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pgm_lab import bundle
from pgm_lab.camera import Camera
from pgm_lab.camera.files import CameraFile
from tests.networks import real

NAMES = ("interior.txt", "exterior.txt", "points.txt", "image.txt")
INTERIOR = "35 0 0 0 0 0 0 0 0 0\n"
EXTERIOR = "7 0 0.1 -0.2 0 0 1000\n-3 0.1 0 3.1 300 0 1000\n"
POINTS = "12 100 20 0\n5 150 -30 10\n90000 -40 60 5\n"
IMAGE = """\
12 7 3.5 0.7 0.001 0.001
5 7 5.2 -1.0 0.001 0.002
90000 7 -1.4 2.1 0.001 0.001
5 -3 -5.2 -1.1 0.003 0.001
12 -3 -7 0.7 0.001 0.001
"""
GOOD = dict(zip(NAMES, (INTERIOR, EXTERIOR, POINTS, IMAGE)))


def files(folder, **changed):
    """Write the four good files, some of them changed, and return their paths."""
    for name, text in GOOD.items():
        text = changed.get(name.split(".")[0], text)
        data = text if isinstance(text, bytes) else text.encode("utf-8")
        (folder / name).write_bytes(data)
    return [folder / name for name in NAMES]


@pytest.fixture
def muliawan():
    return real()


def same(one, other):
    """Whether two networks hold the same numbers, bit by bit."""
    arrays = ("interior", "exteriors", "points", "photo", "point", "xy", "sigma")
    return all(
        getattr(one, name).tobytes() == getattr(other, name).tobytes()
        for name in arrays
    ) and (one.photo_names, one.point_names) == (other.photo_names, other.point_names)


def test_ids_of_any_value_in_any_order_become_indices_and_names(tmp_path):
    network = bundle.read(*files(tmp_path))
    assert network.photo_names == (7, -3)
    assert network.point_names == (12, 5, 90000)
    assert network.photo.tolist() == [0, 0, 0, 1, 1]
    assert network.point.tolist() == [0, 1, 2, 1, 0]
    assert network.xy[3].tolist() == [-5.2, -1.1]
    assert network.sigma[3].tolist() == [0.003, 0.001]
    # positions, then angles
    assert network.exteriors[1].tolist() == [300, 0, 1000, 0.1, 0, 3.1]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_any_network_comes_back_bit_by_bit(tmp_path_factory, seed):
    rng = np.random.default_rng(seed)
    m, n = rng.integers(1, 5), rng.integers(1, 8)
    names = rng.choice(np.arange(1 - 2**53, 2**53, 2**40), m + n, replace=False)
    rays = np.argwhere(rng.random((m, n)) < 0.7)
    if not len(rays):
        return
    scale = 10.0 ** rng.integers(-300, 29, (n, 3))
    network = bundle.Network(
        Camera(rng.uniform(1, 99), *rng.normal(size=9) * 1e-7),
        np.hstack([rng.normal(size=(m, 3)) * 1e7, rng.uniform(-6.2, 6.2, (m, 3))]),
        rng.normal(size=(n, 3)) * scale,
        *rays.T,
        rng.uniform(-5, 5, (len(rays), 2)),
        rng.uniform(1e-12, 1, (len(rays), 2)),
        photo_names=names[:m].tolist(),
        point_names=names[m:].tolist(),
    )
    folder = tmp_path_factory.mktemp("network")
    assert same(bundle.read(*bundle.write(network, folder)), network)


ACCEPTED = {
    "windows line ends": lambda text: text.replace("\n", "\r\n"),
    "tabs": lambda text: text.replace(" ", "\t"),
    "commas": lambda text: text.replace(" ", ","),
    "semicolons": lambda text: text.replace(" ", ";").replace("\n", ";\n"),
    "comments": lambda text: "% a heading, 1 2\n" + text.replace("\n", " % é 3\n", 1),
    "blank lines": lambda text: "\n \n" + text.replace("\n", "\n\n\t\n"),
    "byte order mark": lambda text: "\ufeff" + text,
    "another code page": lambda text: ("% 20° süd\n" + text).encode("latin-1"),
    "utf-16 of notepad": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "fortran exponents": lambda text: text.replace("0.001", "1.0D-3").replace(
        "1000", "+.1d+4"
    ),
}


@pytest.mark.parametrize("change", ACCEPTED.values(), ids=ACCEPTED.keys())
def test_the_same_numbers_in_another_dress(tmp_path, change):
    (tmp_path / "plain").mkdir()
    plain = bundle.read(*files(tmp_path / "plain"))
    changed = {name.split(".")[0]: change(text) for name, text in GOOD.items()}
    assert same(bundle.read(*files(tmp_path, **changed)), plain)


def test_the_interior_orientation_may_stand_in_a_column(tmp_path):
    numbers = [35, 0.1, -0.2, 1e-5, 2e-8, 3e-11, 4e-6, 5e-6, 6e-5, 7e-5]
    column = "% c first\n" + "\n".join(map(str, numbers))
    camera = bundle.read(*files(tmp_path, interior=column), lens="forward").cameras[0]
    assert camera == Camera(*numbers, lens="forward")


def test_a_camera_json_stands_for_the_interior_orientation(tmp_path):
    lens = Camera(35.0, 0.1, K1=1e-5, lens="forward")
    path = tmp_path / "camera.json"
    CameraFile(lens, (3000, 2000), 0.005).save(path)
    _, *others = files(tmp_path)
    assert bundle.read(path, *others).cameras == (lens,)
    assert bundle.read(path, *others, lens="forward").cameras == (lens,)
    with pytest.raises(ValueError, match=r"lens forward: leave out lens backward"):
        bundle.read(path, *others, lens="backward")
    CameraFile(lens, (3000, 400), 0.005).save(path, overwrite=True)
    with pytest.raises(ValueError, match=r"line 3.*y = 2\.1 lies outside the image of"):
        bundle.read(path, *others)


def test_one_sigma_for_all_takes_the_place_of_two_columns(tmp_path):
    bare = "\n".join(" ".join(line.split()[:4]) for line in IMAGE.splitlines())
    for image in (bare, IMAGE, IMAGE.replace("0.003", "0")):
        network = bundle.read(*files(tmp_path, image=image), sigma=0.002)
        assert np.all(network.sigma == 0.002)


def changed(name, line, text):
    """Return the good file with another text in one of its lines."""
    lines = GOOD[name + ".txt"].split("\n")
    lines[line - 1] = text
    return {name: "\n".join(lines)}


REFUSED = {
    "not a number": ("image", 2, "5 7 5.2 l.0 0.001 0.002", "'l.0' is not a number"),
    "a heading": ("points", 1, "id X Y Z", "'id' is not a number; a heading needs a %"),
    "a typographic minus": ("image", 1, "12 7 −3 1 1 1", "'−3' is not a number"),
    "nan": ("points", 2, "5 nan 0 0", "'nan' is not a number"),
    "too few columns": (
        "points",
        3,
        "9 1 2",
        "3 column(s), where object points have 4",
    ),
    "decimal comma": ("points", 2, "5 1,5 2 3", "'1,5' has a decimal comma"),
    "no sigma": ("image", 4, "5 -3 -5.2 -1.1", "4 column(s), where image coordinates"),
    "nine interior": ("interior", 1, "35 0 0 0 0 0 0 0 0", "9 number(s) in 1 line(s)"),
    "no distance": ("interior", 1, "0 0 0 0 0 0 0 0 0 0", "distance c = 0 must be"),
    "unknown photo": ("image", 2, "5 8 1 1 1 1", "photo 8 is not in exterior.txt"),
    "unknown point": ("image", 2, "6 7 1 1 1 1", "point 6 is not in points.txt"),
    "photo before point": ("image", 1, "7 12 1 1 1 1", "point, photo, x, y, sx, sy"),
    "photo twice": ("exterior", 2, "7 0 0 0 0 0 0", "photo 7 stands in line 1 already"),
    "point twice": ("points", 3, "12 1 2 3", "point 12 stands in line 1 already"),
    "ray twice": (
        "image",
        4,
        "5 7 5 -1 1 1",
        "point 5 was measured in photo 7 in line 2",
    ),
    "broken id": ("points", 2, "5.5 1 2 3", "point 5.5: an id must be a whole number"),
    "id too long": ("points", 2, "1e17 1 2 3", "an id must be below 2^53"),
    "sigma 0": ("image", 5, "12 -3 -7 0.7 0 0.001", "sx = 0: a standard deviation"),
    "degrees": (
        "exterior",
        2,
        "-3 0.1 0 90 300 0 1000",
        "kappa = 90 is more than a turn",
    ),
    "pixels": ("image", 3, "90000 7 1936 12 1 1", "c = 35 mm: millimetres"),
}


@pytest.mark.parametrize(
    "name, line, text, reason", REFUSED.values(), ids=REFUSED.keys()
)
def test_an_error_names_the_file_the_line_and_the_reason(
    tmp_path, name, line, text, reason
):
    paths = files(tmp_path, **changed(name, line, text))
    with pytest.raises(ValueError) as error:
        bundle.read(*paths)
    path = paths[NAMES.index(name + ".txt")]
    assert str(error.value).startswith(f"{path}, line {line}: ")
    assert reason.replace(",", "") in str(error.value).replace(",", "")


def test_the_line_is_counted_with_comments_and_blank_lines(tmp_path):
    points = "% id X Y Z\r\n\r\n" + POINTS.replace("\n", "\r\n") + "\r\n8 1 2 x\r\n"
    with pytest.raises(ValueError, match=r"points\.txt, line 7: 'x' is not a number"):
        bundle.read(*files(tmp_path, points=points))


@pytest.mark.parametrize("name", NAMES)
def test_an_empty_file_and_a_missing_one_are_named(tmp_path, name):
    for text in ("", "\n\r\n \t", "% nothing but a comment"):
        paths = files(tmp_path, **{name.split(".")[0]: text})
        with pytest.raises(ValueError, match=name + ": the file holds no numbers"):
            bundle.read(*paths)
    (tmp_path / name).unlink()
    with pytest.raises(FileNotFoundError, match=name + ": there is no such file"):
        bundle.read(*paths)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("rubbish")


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(NAMES), st.binary(max_size=60) | st.text(max_size=60))
def test_rubbish_is_refused_with_its_file_and_never_otherwise(folder, name, rubbish):
    paths = files(folder, **{name.split(".")[0]: rubbish})
    with pytest.raises(ValueError, match=name):
        bundle.read(*paths)


def test_exchanged_files_are_refused(tmp_path):
    interior, exterior, points, image = files(tmp_path)
    with pytest.raises(ValueError, match="exterior orientations have 7"):
        bundle.read(interior, points, exterior, image)


def test_what_the_files_have_no_place_for_is_not_written(tmp_path, muliawan):
    cannot = {
        "fixed points": {"fixed": [0, 1]},
        "control": {"control": ([0], muliawan.points[:1], 1.0)},
        "check points": {"check": ([0], muliawan.points[:1])},
        "chosen datum points": {"datum_points": [0, 1, 2]},
        "scale bars": {"scale_bars": [(0, 1, 30.0, 0.1)]},
        "several cameras": {
            "cameras": 2 * muliawan.cameras,
            "camera": [0, 1] + 7 * [0],
        },
        "covariances": {"sigma": None, "covariance": 1e-6 * np.eye(2)},
        "whole numbers": {"photo_names": list("abcdefghi")},
    }
    for name, change in cannot.items():
        with pytest.raises(ValueError, match=name):
            bundle.write(replace(muliawan, **change), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "names, words",
    [
        (("007", "7"), "'007' and '7' are the same number, 7"),
        ((1, "b"), "must be whole numbers"),
        ((2**53, 1), "must be below 2\\^53"),
        ((1, -(2**53)), "must be below 2\\^53"),
        ((2**53 - 1, 1 - 2**53), None),
        (("007", "8"), None),
    ],
)
def test_names_that_read_would_refuse_are_not_written(tmp_path, names, words):
    network = replace(bundle.read(*files(tmp_path)), photo_names=names)
    out = tmp_path / "out"
    if words:
        with pytest.raises(ValueError, match=f"photo_names .*{words}"):
            bundle.write(network, out)
        assert not out.exists()
    else:
        ids = bundle.read(*bundle.write(network, out)).photo_names
        assert ids == tuple(map(int, names))
