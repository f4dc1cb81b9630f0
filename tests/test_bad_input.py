"""No public function takes a bad argument, or fails from deep inside.

The bad values are made from a good one and from the signature. Each call must end in a
ValueError or TypeError that names the argument. Readers and writers of files have tests
of their own, beside those of their rooms.
"""

import copy
import importlib
import inspect
import re
import typing
import warnings

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pgm_lab import bundle, lsm, ncc, simulate
from pgm_lab.camera import Camera
from tests.good_arguments import FUNCTIONS, GREY, in_network

MODULES = (
    *("adjustment", "bundle", "camera", "epipolar", "frames", "image", "lsm"),
    *("matching", "ncc", "observations", "orientation", "registration", "rotation"),
    "stereo",
)
# Classes that a caller makes; functions make the others
CLASSES = "bundle.Network", "camera.Camera", "camera.Photo"
FILES = ("read", "read_points", "write", "save", "save_points", "save_surface")
ELSEWHERE = {"stereo.plot_block"}  # tests/stereo
IGNORED = {("adjustment.adjust", "args")}  # only the function knows what they are


def public():
    """Public functions, classes that are made by callers, and methods, by name."""
    found = {}
    for module in MODULES:
        room = importlib.import_module(f"pgm_lab.{module}")
        own = [n for n, one in vars(room).items() if n[0] != "_"
               and getattr(one, "__module__", "") == room.__name__]  # fmt: skip
        for name in getattr(room, "__all__", own):
            one, full = getattr(room, name), f"{module}.{name}"
            if inspect.isclass(one):
                found |= {full: one} if full in CLASSES else {}
                found |= {
                    f"{full}.{name}": getattr(one, name)
                    for name, method in vars(one).items()
                    if name[0] != "_" and callable(getattr(method, "__func__", method))
                    and not isinstance(method, type) and parameters(getattr(one, name))
                }  # fmt: skip
            elif inspect.isfunction(one):
                found[full] = one
    return {
        name: one
        for name, one in found.items()
        if name.split(".")[-1] not in FILES and name not in ELSEWHERE
    }


def parameters(function):
    """Arguments that can be bad, by name."""
    return {
        name: one
        for name, one in inspect.signature(function).parameters.items()
        if name not in ("self", "cls")
        and one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)
    }


# --- Bad values, by the kind of a good one ---


class Endless:
    """An iterator without an end, as that of `itertools.count`: it is not begun."""

    def __iter__(self):
        return self

    def __next__(self):
        raise AssertionError("the numbers of an endless iterator are collected")


def with_first(good, value):
    changed = np.array(good, dtype=float)
    changed[(0,) * changed.ndim] = value
    return changed


def bad_numbers(good):
    yield from {"NaN": np.nan, "inf": np.inf, "True": True, "none": []}.items()
    yield "two numbers", [good, good]


def bad_arrays(good):
    g = np.asarray(good)
    yield "ragged", [[1.0, 2.0], [3.0]]
    if g.ndim:
        yield "shape", np.ones((2, 3, 5, 7))
    yield "masked", np.ma.masked_array(g, np.ones(g.shape, bool))
    yield "texts of numbers", g.astype(str)
    yield "complex numbers", g + 0j
    yield "dates", np.full(g.shape, "2020-01-01", "M8[D]")
    yield "NaN", with_first(g, np.nan)
    yield "inf", with_first(g, np.inf)


def is_numeric(good):
    try:
        return np.size(good) > 0 and np.asarray(good).dtype.kind in "fiu"
    except ValueError:
        return False


def bad_values(good, one):
    """Labels and values that must be refused for an argument."""
    parts = typing.get_args(one.annotation) or (one.annotation,)
    if one.default is not None and type(None) not in parts:
        yield "None", None
    yield "object", object()
    yield "dictionary", {"a": 1}
    yield "endless", Endless()
    if not callable(good):
        yield "function", len
    if isinstance(good, str):
        yield from {"number": 3, "no such word": "nonsense", "empty": ""}.items()
        return
    yield "text", "text"
    yield "complex", 1j
    array = set(typing.get_args(ArrayLike)) <= set(parts) or np.ndarray in parts
    if isinstance(good, bool):
        yield from {"two": 2, "NaN": np.nan, "none": []}.items()
    elif isinstance(good, int | float) and not array:
        yield from bad_numbers(good)
        if isinstance(good, int) and float not in parts:
            yield "fraction", good + 0.5
    elif is_numeric(good):
        yield from bad_arrays(good)
    elif good is not None:
        yield from {"number": 3.5, "array": np.zeros(3), "True": True}.items()


# What would be bad elsewhere, but is meant here
LACKING = {"NaN", "inf", "masked"}  # a photo may lack pixels
ANY_NAME = {"object", "function", "text", "complex", "number", "no such word", "empty"}
ANY_NAME |= {"endless"}
MEANT = {
    ("adjustment.adjust", "start"): {"shape"},  # the names no longer fit
    ("bundle.Network", "control"): {"inf"},
    ("bundle.Network", "scale_bars"): {"None"},
    ("bundle.Network.of", "fixed"): {"complex numbers"},  # 3 + 0j is the name 3
    ("bundle.Network.of", "datum_points"): {"complex numbers"},
    ("bundle.Network", "photo_names"): {"None"},
    ("bundle.Network", "point_names"): {"None"},
    ("camera.Photo", "grey"): LACKING,
    ("camera.Photo", "crs"): {"no such word"},  # known to rasterio alone
    ("image.centroid", "window"): {"shape"},
    ("image.cut", "image"): LACKING,  # outside the window
    ("image.resample", "outside"): {"NaN"},  # marks what is outside
    ("lsm.match", "left"): LACKING,
    ("lsm.match", "right"): LACKING,
    ("matching.match", "left"): LACKING,
    ("matching.match", "right"): LACKING,
    ("matching.pick", "image"): LACKING,
    ("matching.quality", "left"): LACKING,
    ("matching.quality", "right"): LACKING,
    ("ncc.match", "left"): LACKING,
    ("ncc.match", "right"): LACKING,
    ("ncc.match", "search"): {"two numbers"},  # rows and columns
    ("ncc.correlation_map", "search"): {"shape"},  # a stack
    ("observations.from_matches", "left"): ANY_NAME,
    ("registration.approximate", "reference"): LACKING,
    ("registration.approximate", "sensed"): LACKING,
    ("registration.pick", "image"): LACKING,
    ("registration.pick", "sensed"): LACKING,
    ("registration.Raster.with_values", "values"): LACKING,
    ("registration.register", "reference"): LACKING,
    ("registration.register", "sensed"): LACKING,
    ("registration.resample", "sensed"): LACKING,
    # NaN: nothing was matched, no height, no truth
    ("stereo.NormalPair.parallax", "disparity"): LACKING | {"shape"},
    ("stereo.NormalPair.object_points", "disparity"): LACKING | {"shape"},
    ("stereo.match_rows", "left"): LACKING,
    ("stereo.match_rows", "right"): LACKING,
    ("stereo.quality", "heights"): {"NaN"},
    ("stereo.quality", "truth"): {"NaN"},
    ("stereo.surface", "points"): {"NaN"},  # left out
    ("stereo.surface", "largest_gap"): {"inf"},  # any
}
PUBLIC = public()


def good_arguments(full):
    kinds = bool | int | float | str | tuple | list
    defaults = {
        name: one.default
        for name, one in parameters(PUBLIC[full]).items()
        if one.default is not one.empty and isinstance(one.default, kinds)
    }
    return defaults | FUNCTIONS[full]()


def call(function, arguments):
    arguments = dict(arguments)
    first = [arguments.pop("self")] if "self" in arguments else []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return function(*first, **arguments)


def complaint(function, arguments, name):
    """What is wrong with a call that has one bad argument, or None."""
    try:
        call(function, arguments)
    except (ValueError, TypeError, OSError) as error:
        named = re.search(rf"(?<![A-Za-z]){name}(?![a-z])", str(error))
        return None if named else f"does not name it: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "accepted"


def test_every_public_function_has_good_arguments():
    missing = [name for name in PUBLIC if name not in FUNCTIONS]
    assert [one for one in missing if parameters(PUBLIC[one])] == []
    assert [name for name in FUNCTIONS if name not in PUBLIC] == []


@pytest.mark.parametrize("full", [name for name in FUNCTIONS if name in PUBLIC])
def test_bad_arguments_end_in_an_error_that_names_them(full):
    function, good, found = PUBLIC[full], good_arguments(full), []
    arrays = {n: one.copy() for n, one in good.items() if isinstance(one, np.ndarray)}
    call(function, good)
    for name, array in arrays.items():  # nothing handed over is changed
        np.testing.assert_array_equal(good[name], array)
    for name, one in parameters(function).items():
        if (full, name) in IGNORED:
            continue
        meant = MEANT.get((full, name), ())
        for label, bad in bad_values(good[name], one):
            if label not in meant:
                wrong = complaint(function, good | {name: bad}, name)
                found += [f"{name}, {label}: {wrong[:150]}"] if wrong else []
    assert found == [], "\n".join(found)


# --- Single cases that are not made from signatures ---


def test_a_lens_that_shows_too_little_ends_the_search_for_a_pair(monkeypatch):
    monkeypatch.setattr("pgm_lab.simulate.photos.TRIES", 50)
    for make in (simulate.pair, simulate.control_photo):
        with pytest.raises(ValueError, match="in 50 tries.* 40 points.*c = 180 mm"):
            make(Camera(180.0), 40, np.random.default_rng(1))


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int64])
def test_a_small_integer_type_does_not_overflow(kind):
    points = [(20.0, 20.0)]
    small = lsm.match(GREY, GREY, points, points, kind(21))
    assert small.redundancy == 21**2 - 8
    found = ncc.match(GREY, GREY, points, template=kind(11), search=kind(21))
    np.testing.assert_allclose(found.points, points, atol=1e-9)


def test_a_network_keeps_no_array_of_the_caller():
    k = len(in_network()["xy"])
    covariance = np.tile(np.eye(2) * 1e-6, (k, 1, 1))
    for given in (
        in_network() | {"sigma": np.full((k, 2), 0.002)},
        in_network() | {"sigma": None, "covariance": covariance},
    ):
        given = copy.deepcopy(given)
        network = bundle.Network(**given)
        before = copy.deepcopy(vars(network))
        for one in given.values():
            for array in one if isinstance(one, tuple) else (one,):
                if isinstance(array, np.ndarray):
                    array += 1
        for name, values in before.items():
            if name not in ("cameras", "photo_names", "point_names"):
                np.testing.assert_equal(getattr(network, name), values)


def test_masked_numbers_are_refused_only_where_something_is_masked():
    image = np.ma.masked_array(GREY)
    found = ncc.match(image, image, [(20.0, 20.0)], template=11, search=21)
    assert found.status.tolist() == ["accepted"]
    image[3, 3] = np.ma.masked
    with pytest.raises(ValueError, match="search has masked values"):
        ncc.correlation_map(GREY[:5, :5], image)
