"""No public function accepts a bad argument, hangs, warns or fails from deep inside.

The bad arguments are made from the signatures, `bad_arguments` says how. Whatever a
function does not take ends in an error of ours that names the argument.
"""

import _thread
import dataclasses
import importlib
import inspect
import linecache
import pkgutil
import re
import threading
import warnings
from contextlib import contextmanager
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import pgm_lab.checks
import pgm_lab.observations
from tests import bad_arguments, good_arguments
from tests.bad_arguments import MAY, REFUSE, RIGHT
from tests.good_arguments import FUNCTIONS

HOME = str(Path(pgm_lab.__file__).parent)
MEMORY = 8 * 2**30  # bytes of addresses
LONGEST = 20.0  # seconds of one call; the longest takes a tenth of one


def modules():
    """Modules that are open: rooms, what they export, and what stands alone."""
    names = ["pgm_lab." + one.name for one in pkgutil.iter_modules(pgm_lab.__path__)]
    rooms = [name for name in names if not name.startswith("pgm_lab._")]
    for name in rooms:
        room = importlib.import_module(name)
        yield room
        inside = getattr(room, "__all__", None)
        if inside is None and hasattr(room, "__path__"):
            inside = [one.name for one in pkgutil.iter_modules(room.__path__)]
            inside = [one for one in inside if not one.startswith("_")]
            for one in inside:
                importlib.import_module(f"{name}.{one}")
        for one in inside or ():
            if inspect.ismodule(getattr(room, one)):
                yield getattr(room, one)


def public():
    """Public functions, and classes by their constructors and methods, by name."""
    found = {}
    for module in modules():
        own = [n for n, one in vars(module).items() if not n.startswith("_")
               and is_of(one, module.__name__)]  # fmt: skip
        for name in getattr(module, "__all__", own):
            one = getattr(module, name)
            full = f"{module.__name__}.{name}".removeprefix("pgm_lab.")
            if inspect.isclass(one):
                found[full] = one
                found |= methods(full, one)
            elif callable(one):
                found[full] = one
    return found


def takes_any(name):
    return bool(bad_arguments.parameters(PUBLIC[name]))


def is_of(one, name):
    """Whether a module of this name defines it, or a hidden part of its folder."""
    home = getattr(one, "__module__", None) or ""
    return home == name or home.startswith(f"{name}._")


def methods(full, one):
    return {
        f"{full}.{name}": getattr(one, name)
        for name, method in vars(one).items()
        if not name.startswith("_")
        and isinstance(method, classmethod | type(public))
        and bad_arguments.parameters(getattr(one, name))
    }


PUBLIC = public()
# A function makes these; nobody else need construct one
RESULTS = {
    name
    for name, one in PUBLIC.items()
    if inspect.isclass(one)
    and name
    not in ("bundle.Network", "camera.Camera", "camera.Photo", "simulate.Texture")
}
CHECKS = {n for n in PUBLIC if n.startswith("checks.chapter") and n not in FUNCTIONS}
# Not tried here, and why
EXCEPT = {
    "command.main": "tests/command",
    "report.html": "tests/report/test_network.py",
    "report.text": "tests/report/test_network.py",
    "report.matching.html": "tests/report/test_matching.py",
    "report.matching.text": "tests/report/test_matching.py",
    "report.registration.html": "tests/report/test_registration.py",
    "report.registration.text": "tests/report/test_registration.py",
    "bundle.read": "tests/bundle/test_files.py",
    "bundle.write": "tests/bundle/test_files.py",
    "matching.read": "tests/matching/test_photo.py",
    "matching.Match.save": "tests/matching/test_result.py",
    "registration.read": "tests/registration/test_raster.py",
    "registration.read_points": "tests/registration/test_raster.py",
    "registration.write": "tests/registration/test_raster.py",
    "registration.Registration.save": "tests/registration/test_result.py",
    "observations.Observations.save": "tests/matching/test_result.py",
    "observations.read": "tests/stereo_map/test_saving.py",
    "bundle.defects.adjust": "tests/bundle/test_defects.py",
    "bundle.defects.network": "tests/bundle/test_defects.py",
    "simulate.aerial_block": "tests/simulate/test_aerial.py, as simulate.aerial_pair",
    "stereo.plot_block": "tests/stereo/test_block.py",
    "stereo_map.exif_camera": "tests/stereo_map/test_photos.py",
    "stereo_map.read_photo": "tests/stereo_map/test_photos.py",
    "stereo_map.save": "tests/stereo_map/test_saving.py",
    "stereo_map.save_network": "tests/stereo_map/test_saving.py",
    "plot.interact": "tests/plot/test_sliders.py",
    "checks.keep": "tests/checks/test_own.py",
}
# For the authors of checks alone: what a reader hands over is tried by the checks
AUTHORS = {"answer_of", "call", "compare", "first_slip", "numbers", "report"}
EXCEPT |= {f"checks.{name}": "the checks" for name in AUTHORS}
# What its `args` are, the function alone knows that takes them
IGNORED = {("adjustment.adjust", "args")}
# Steps of a printed program, which hand arrays to each other
STEPS = ("design", "inverse", "misclosure", "normal_matrix", "tolerance")
EXCEPT |= {f"bundle.defects.{name}": "steps of `adjust`" for name in STEPS}
EXCEPT["plot.troubles.gallery"] = "draws what `six` made"
CALLED = [name for name in PUBLIC if name in FUNCTIONS and name not in EXCEPT]
# What would be bad elsewhere, but is meant here: (function, argument) -> labels
NO_NAMES = {"None", *(f"{i}: None" for i in range(3))}
LACKING = {"one masked", "one NaN", "one inf", "one -inf"}  # a photo may lack pixels
MEANT = {
    ("camera.Photo", "grey"): LACKING | {"all NaN", "all inf", "all -inf"},
    # NaN says that nothing was matched
    ("stereo.NormalPair.parallax", "disparity"): LACKING
    | {"all NaN", "all inf", "all -inf"},
    ("stereo.NormalPair.object_points", "disparity"): LACKING
    | {"all NaN", "all inf", "all -inf"},
    ("stereo_map.open_pair", "left"): LACKING,
    ("stereo_map.open_pair", "right"): LACKING,
    ("ncc.match", "left"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("ncc.match", "right"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("ncc.match", "search"): {"two numbers"},  # rows and columns
    ("image.cut", "image"): LACKING,  # outside the window
    ("plot.program.scatter", "ratio"): {"dictionary"},  # the names are free
    ("lsm.match", "left"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("lsm.match", "right"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("matching.quality", "left"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("matching.quality", "right"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("matching.match", "left"): LACKING,
    ("matching.match", "right"): LACKING,
    ("matching.pick", "image"): LACKING,
    ("registration.pick", "image"): LACKING,
    ("registration.pick", "sensed"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("registration.Raster.with_values", "values"): LACKING
    | {"all NaN", "all inf", "all -inf"},
    ("registration.resample", "sensed"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("registration.register", "reference"): LACKING
    | {"all NaN", "all inf", "all -inf"},
    ("registration.register", "sensed"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("plot.shifts.trial", "tests"): {  # NaN: the test does not trust the chip
        f"r: {many} {what}"
        for many in ("one", "all")
        for what in ("NaN", "inf", "-inf")
    },
    ("plot.program.precisions", "sds"): {"A: one NaN", "A: all NaN"},  # refused there
    ("plot.search.by_hand", "disparity"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("plot.troubles.right_and_wrong", "right"): {"numbers"},  # 0 and 1
    ("plot.twentyfive.reach", "windows"): {"dictionary"},
    ("plot.subpixel.depths", "measured"): LACKING,
    ("plot.subpixel.depths", "true"): LACKING,
    ("plot.overlay", "reference"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("plot.overlay", "sensed"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("plot.fringe.before_and_after", "again"): LACKING
    | {"all NaN", "all inf", "all -inf"},
    ("stereo.match_rows", "left"): LACKING,
    ("stereo.match_rows", "right"): LACKING,
    # NaN: no height, no truth
    ("stereo.quality", "heights"): {"one NaN", "all NaN"},
    ("stereo.quality", "truth"): {"one NaN", "all NaN"},
    ("stereo.surface", "points"): {"one NaN"},  # left out
    ("stereo.textbook.along_row", "left"): LACKING,  # outside the windows
    ("stereo.textbook.along_row", "right"): LACKING,
    ("stereo.textbook.best_disparity", "left"): LACKING,
    ("stereo.textbook.best_disparity", "right"): LACKING,
    ("plot.matches.side_by_side", "left"): LACKING,
    ("plot.matches.side_by_side", "right"): LACKING,
    ("plot.matches.parallaxes", "left"): LACKING,
    ("plot.registration.fringes", "reference"): LACKING,
    ("plot.registration.fringes", "images"): {f"other: {one}" for one in LACKING},
    ("plot.registration.shifts", "reference"): LACKING,
    ("plot.registration.shifts", "title"): {"no such word"},  # any words
    ("simulate.Landscape.at", "layer"): LACKING | {"all NaN", "all inf", "all -inf"},
    ("bundle.Network", "sigma"): {"None"},
    ("bundle.Network", "camera"): {"None"},
    ("bundle.Network", "scale_bars"): {"None"},
    ("bundle.Network", "control"): {"2: one inf", "2: all inf"},  # leaves it free
    ("bundle.Network", "photo_names"): NO_NAMES,
    ("bundle.Network", "point_names"): NO_NAMES,
    ("plot.bundle.residual_vectors", "photo"): {"two numbers"},
    ("plot.matrices.spectrum", "tolerances"): {"dictionary"},
    ("plot.validation.ladder", "sigma0"): {"dictionary"},
    ("plot.space.space", "where"): {"None"},
    ("image.resample", "outside"): ("NaN", "NaN of NumPy"),  # marks what is outside
    # an answer that is no number is near nothing
    ("checks.near", "answer"): {
        f"{many} {what}" for many in ("one", "all") for what in ("NaN", "inf", "-inf")
    },
    ("checks.near", "expected"): {
        f"{many} {what}" for many in ("one", "all") for what in ("NaN", "inf", "-inf")
    },
    ("image.equalize", "image"): ("objects", "list"),  # the type says the grey values
    ("image.histogram", "image"): ("objects", "list"),
    ("simulate.photograph", "seed"): ("two numbers", "empty"),  # seeds may be several
}


# A name may be anything that can stand in a table, a text may be any text
NAMES = {
    "left", "points", "photo_names", "point_names", "names", "rows",
    "labels", "notes", "caption", "alt", "unit", "name", "header", "folder",
    "otherwise", "wanted",
    "row",
}  # fmt: skip
A_NAME = {
    "text", "text of a number", "text of NumPy", "bytes", "object", "list of texts",
    "object that raises", "beyond floats", "complex", "function", "type", "date",
    "time", "number", "NaN", "no such word", "empty",
}  # fmt: skip
# These take long: few of the values that may be taken, and each once
SLOW = ("plot.", "orientation.relative", "ledger.figure", "simulate.")
SLOW += ("bundle.textbook", "stereo.y_parallax", "stereo_map.orient", "stereo_map.show")
FEW = {"none at all", "no rows", "zeros", "zero", "negative", "huge whole", "objects"}


def is_meant(full, name, label):
    """Whether what is bad elsewhere is meant here."""
    last = label.rpartition(": ")[2]
    of_names = name in NAMES and last in A_NAME
    return of_names or label in MEANT.get((full, name), ())


class Hangs(Exception):
    pass


@contextmanager
def no_longer_than(seconds):
    """Interrupt what takes longer."""
    timer = threading.Timer(seconds, _thread.interrupt_main)
    timer.start()
    try:
        yield
    except KeyboardInterrupt:
        raise Hangs from None
    finally:
        timer.cancel()


def call(function, arguments):
    """Call a function; return (what came, its error, a complaint)."""
    before = {name: _frozen(one) for name, one in arguments.items()}
    result = error = complaint = None
    positional = [arguments.pop("self")] if "self" in arguments else []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The oldest matplotlib uses names that the newest pyparsing has given up
        module = "matplotlib|pyparsing"
        warnings.filterwarnings("ignore", category=DeprecationWarning, module=module)
        try:
            result = function(*positional, **arguments)
        except Hangs:
            complaint = "hangs"
        except Warning as warning:
            complaint = f"warns: {type(warning).__name__}: {warning}"
        except BaseException as raised:
            if isinstance(raised, KeyboardInterrupt):
                raise
            error = raised
    changed = [n for n, one in arguments.items() if _frozen(one) != before[n]]
    if changed:
        complaint = f"changes {', '.join(changed)}"
    return result, error, complaint


def _frozen(value):
    """What an argument holds, if it can be changed."""
    if isinstance(value, np.ma.MaskedArray):
        return value.data.tobytes(), np.ma.getmaskarray(value).tobytes()
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value.tobytes()
    return None


def ours(error):
    """Whether an error was raised on purpose, by a line of the package."""
    trace = error.__traceback__
    while trace.tb_next:
        trace = trace.tb_next
    place = trace.tb_frame.f_code.co_filename
    line = linecache.getline(place, trace.tb_lineno).strip()
    named = isinstance(error, ValueError | TypeError | OSError | AssertionError)
    return named and place.startswith(HOME) and line.startswith("raise")


def text_of(error):
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:
        return type(error).__name__


def complaint_of(function, arguments, name, verdict, expected=None):
    """What is wrong with a call that has one bad argument, or None."""
    result, error, complaint = call(function, arguments)
    if complaint:
        return complaint
    if error is None:
        if verdict == REFUSE:
            return "accepted"
        if verdict == RIGHT and not same(result, expected):
            return "wrong result"
        return None
    text = text_of(error)
    if not ours(error):
        return f"deep {text[:150]}"
    if verdict == RIGHT:
        return f"refused: {text[:150]}"
    of_reader = isinstance(error, pgm_lab.checks.CheckFailed)
    if (
        verdict == REFUSE
        and not of_reader
        and not re.search(rf"(?<![A-Za-z]){name}(?![a-z])", text)
    ):
        return f"does not name it: {text[:150]}"
    return None


def same(a, b):
    """Whether two results are the same but for rounding."""
    if dataclasses.is_dataclass(a) and type(a) is type(b):
        return all(
            same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a)
        )
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, float | int | np.number | np.ndarray) and not isinstance(a, bool):
        a, b = np.asarray(a), np.asarray(b)
        if a.dtype.kind in "fiuc":
            return a.shape == b.shape and np.allclose(a, b, 1e-6, 1e-9, equal_nan=True)
        return a.shape == b.shape and bool(np.all(a == b))
    return True  # figures and the like are looked at elsewhere


def test_every_public_function_has_good_arguments():
    known = set(FUNCTIONS) | RESULTS | set(EXCEPT) | CHECKS
    missing = [name for name in PUBLIC if name not in known and takes_any(name)]
    assert missing == [], "add good arguments to tests/good_arguments.py"
    gone = [name for name in {*FUNCTIONS, *EXCEPT} if name not in PUBLIC]
    assert gone == [], "there is no such function any more"


def test_a_new_public_function_is_found(monkeypatch):
    def new(image):
        return image

    new.__module__ = "pgm_lab.observations"
    monkeypatch.setattr(pgm_lab.observations, "new", new, raising=False)
    assert set(public()) - set(PUBLIC) == {"observations.new"}


@pytest.fixture(autouse=True)
def memory():
    """Let a size that nobody refused end this test, and not the machine."""
    try:
        import resource
    except ImportError:  # Windows
        yield
        return
    now = resource.getrlimit(resource.RLIMIT_AS)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, now[1]))
    except (OSError, ValueError):  # macOS refuses
        yield
        return
    yield
    resource.setrlimit(resource.RLIMIT_AS, now)


@pytest.fixture(autouse=True)
def closed(monkeypatch, tmp_path):
    monkeypatch.setattr(good_arguments, "FOLDER", tmp_path)
    yield
    plt.close("all")
    good_arguments.axes.cache_clear()
    good_arguments.axes_in_space.cache_clear()


def failures(full):
    """Calls, and those that fail: (argument, label, complaint)."""
    function = PUBLIC[full]
    good = good_arguments.of(full, function)
    found, calls, tried = [], 0, set()
    expected, error, complaint = call(function, good_arguments.fresh(good))
    if error or complaint:
        return 1, [("all good", "", complaint or text_of(error))]
    for name, one in bad_arguments.parameters(function).items():
        if (full, name) in IGNORED:
            continue
        if name not in good:
            found.append((name, "", "has no good value"))
            continue
        for label, bad, verdict in bad_arguments.of(
            good[name], one.annotation, one.default
        ):
            if is_meant(full, name, label):
                verdict = MAY
            if verdict != REFUSE and full.startswith(SLOW):
                if label in tried or label not in FEW:
                    continue
                tried.add(label)
            calls += 1
            arguments = good_arguments.fresh(good) | {name: bad}
            try:
                with no_longer_than(LONGEST):
                    wrong = complaint_of(function, arguments, name, verdict, expected)
            except Hangs:
                wrong = "hangs"
            plt.close("all")
            if wrong:
                found.append((name, label, wrong))
    return calls, found


def is_door(full):
    """Whether the data of a user come through a function.

    They do not through figures, simulations and what chapters take apart.
    """
    room, *inside = full.split(".")
    chapters = {"textbook", "dense", "defects", "published", "as_printed"}
    return room not in ("plot", "simulate", "ledger") and not chapters & set(inside)


@pytest.mark.parametrize(
    "full",
    [
        pytest.param(full, marks=() if is_door(full) else pytest.mark.slow)
        for full in CALLED
    ],
)
def test_bad_arguments_end_in_an_error_that_names_them(full):
    calls, found = failures(full)
    assert found == [], "\n".join(map(str, found))


def failures_of_check(full):
    function = PUBLIC[full]
    found, calls = [], 0
    names = bad_arguments.parameters(function)
    for name in (one for one in names if one not in GIVEN.get(full, ())):
        takes_function = name == "function"
        bads = bad_arguments.readers() if takes_function else bad_arguments.answers()
        for label, bad, verdict in bads:
            calls += 1
            arguments = good_check(full) | {name: bad}
            with no_longer_than(LONGEST):
                result, error, complaint = call(function, arguments)
            plt.close("all")
            if complaint is None and error is None and verdict == REFUSE:
                complaint = "accepted"
            if error is not None and not (
                isinstance(error, pgm_lab.checks.CheckFailed) and ours(error)
            ):
                complaint = f"leaks {text_of(error)[:150]}"
            if complaint:
                found.append((name, label, complaint))
    return calls, found


def good_check(full):
    if full == "checks.chapter0.tenth":
        return dict(point=10, computed=(2.24795, 3.53131))
    if full == "checks.chapter6c.largest_difference":
        return dict(photo=1, unknown="kappa", unit="rad", moved_um=1.0)
    if full == "checks.chapter7.border":
        dx, dy = np.array([(3.0, 0), (1, -3), (0, 2)]).T
        return dict(answer=[True, True, False], dx=dx, dy=dy, radius=3)
    if full == "checks.chapter7c.forged":
        dy = [3, -3] * 13 + [1, -1] + [0] * 22
        return dict(shifts=np.column_stack([np.ones(50), dy]), mean=(1, 0))
    if full == "checks.chapter8.mark":
        pair = good_arguments.normal_pair()
        land = good_arguments.level_land()
        return dict(answer=0.0, pair=pair, place=(30, 30), land=land)
    if full == "checks.chapter8c.marks":
        known = good_check("checks.chapter8.mark")
        pair, land, places = known["pair"], known["land"], np.full((1, 2), 30)
        return dict(answer=[0.0], pair=pair, places=places, land=land)
    return {}


# What a check is given by the notebook, not by the reader
GIVEN = {
    "checks.chapter7.border": ("dx", "dy", "radius"),
    "checks.chapter8.mark": ("pair", "place", "land"),
    "checks.chapter8c.marks": ("pair", "places", "land"),
}


@pytest.mark.parametrize("full", sorted(CHECKS))
def test_a_check_names_what_fails_and_never_leaks(full):
    calls, found = failures_of_check(full)
    assert found == [], "\n".join(map(str, found))
