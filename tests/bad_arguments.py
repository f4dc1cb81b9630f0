"""Bad arguments for every public function, made from its signature.

What a function takes is told by the type of the argument and by a good value of it.
Some bad values must be refused, some may be taken, and some unusual ones must give the
same as the usual ones.
"""

import collections.abc
import inspect
import types
import typing
from fractions import Fraction

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

ARRAY_LIKE_PARTS = set(typing.get_args(ArrayLike))
REFUSE, MAY, RIGHT = "must be refused", "may be refused", "must be right"
BEYOND = 10**400  # no float holds it
HUGE = 10**12


def of(good, annotation, default):
    """Yield (label, value, verdict) for one argument."""
    optional = default is None or type(None) in typing.get_args(annotation)
    if not optional:
        yield "None", None, REFUSE
    for kind in kinds(good, annotation):
        yield from kind(good)


def kinds(good, annotation):
    """Which lists of bad values suit an argument."""
    if isinstance(annotation, str):
        annotation = None
    parts = typing.get_args(annotation) if _is_union(annotation) else (annotation,)
    plain = [p for p in parts if p is not type(None)]
    if good is None or isinstance(good, np.random.Generator):
        return [things]
    if callable(good) or isinstance(good, Figure):
        return [things]
    if not (np.isscalar(good) or _is_numeric(good)):
        pass
    elif np.ndarray in plain or ARRAY_LIKE_PARTS <= set(plain):
        return [arrays]
    if isinstance(good, bool):
        return [flags]
    if isinstance(good, str):
        return [words]
    if isinstance(good, int) and (int in plain or float not in plain):
        return [wholes]
    if isinstance(good, int | float):
        return [numbers]
    if isinstance(good, collections.abc.Mapping):
        return [things, members_of_mapping]
    if _is_numeric(good):
        return [arrays]
    if isinstance(good, tuple | list):
        return [things, members]
    return [things]


def _is_union(annotation):
    return isinstance(annotation, types.UnionType) or (
        typing.get_origin(annotation) is typing.Union
    )


def _is_numeric(value):
    if isinstance(value, np.ndarray):
        return True
    if not isinstance(value, tuple | list) or not len(value):
        return False
    try:
        return np.asarray(value).dtype.kind in "iuf"
    except ValueError:
        return False


def strange():
    yield "text", "text", REFUSE
    yield "text of a number", "1.0", REFUSE
    yield "text of NumPy", np.str_("1"), REFUSE
    yield "bytes", b"1", REFUSE
    yield "list of texts", ["a", "b"], REFUSE
    yield "dictionary", {"a": 1}, REFUSE
    yield "object", object(), REFUSE
    yield "beyond floats", BEYOND, REFUSE
    yield "complex", 1j, REFUSE
    yield "function", len, REFUSE
    yield "type", int, REFUSE
    yield "date", np.datetime64("2020-01-01"), REFUSE
    yield "time", np.timedelta64(1, "s"), REFUSE
    yield "masked", np.ma.masked, REFUSE


def arrays(good):
    """Bad values of an array, or of what can become one."""
    g = np.asarray(good)
    if g.dtype == bool:
        yield from masks(good)
        return
    yield from strange()
    yield "ragged", [[1.0, 2.0], [3.0]], REFUSE
    if not g.size:
        return
    yield "texts of numbers", g.astype(str), REFUSE
    yield "bytes of numbers", g.astype("S"), REFUSE
    yield "dates", np.full(g.shape, "2020-01-01", "M8[D]"), REFUSE
    yield "times", np.ones(g.shape, "m8[s]"), REFUSE
    yield "records", np.zeros(g.shape, [("a", float)]), REFUSE
    yield "complex numbers", g + 0j, REFUSE
    first = np.arange(g.size).reshape(g.shape) == 0
    yield "one masked", np.ma.masked_array(g, first), REFUSE
    floats = g.astype(float)
    for label, bad in (("NaN", np.nan), ("inf", np.inf), ("-inf", -np.inf)):
        yield f"one {label}", _with_first(floats, bad), REFUSE
        yield f"all {label}", np.full(g.shape, bad), REFUSE
    objects = g.astype(object)
    yield "one None", _with_first(objects, None), REFUSE
    yield "one text", _with_first(objects, "1"), REFUSE
    yield "one beyond floats", _with_first(objects, BEYOND), REFUSE
    yield "one complex", _with_first(objects, 1j), REFUSE
    yield "objects", objects, RIGHT
    yield "nothing masked", np.ma.masked_array(g), RIGHT
    yield "list", g.tolist(), RIGHT
    yield "read only", _read_only(g), RIGHT
    if np.all(g == np.round(floats)) and np.abs(g).max() <= 127:
        yield "int8", g.astype(np.int8), RIGHT
        if g.min() >= 0:
            yield "uint8", g.astype(np.uint8), RIGHT
    yield "big endian", g.astype(g.dtype.newbyteorder(">")), RIGHT
    yield "none at all", np.zeros(0), MAY
    yield "no rows", g[:0] if g.ndim else g, MAY
    yield "no columns", g[..., :0] if g.ndim else g, MAY
    yield "one row less", g[:-1] if g.ndim else g, MAY
    yield "one column less", g[..., :-1] if g.ndim else g, MAY
    yield "one axis more", g[None], MAY
    yield "two axes more", g[None, None], MAY
    yield "one number", 1.0, MAY
    yield "first row", g[0] if g.ndim else g, MAY
    yield "zeros", np.zeros_like(g), MAY
    yield "ones", np.ones_like(g), MAY
    yield "negative", -floats, MAY
    yield "huge index", _with_first(floats, float(HUGE)), MAY
    yield "fractions", floats + 0.25, MAY
    yield "truth", g.astype(bool), MAY


def masks(good):
    g = np.asarray(good)
    yield from strange()
    yield "numbers", g.astype(float), REFUSE
    yield "texts", g.astype(str), REFUSE
    yield "masked", np.ma.masked_array(g, g), REFUSE
    yield "wrong shape", g[:1], MAY
    yield "none true", np.zeros_like(g), MAY


def _with_first(array, value):
    changed = array.copy()
    changed[(0,) * changed.ndim] = value
    return changed


def _read_only(array):
    copy = array.copy()
    copy.setflags(write=False)
    return copy


def numbers(good):
    """Bad values of one number."""
    yield from strange()
    for label, bad in (("NaN", np.nan), ("inf", np.inf), ("-inf", -np.inf)):
        yield label, bad, REFUSE
    yield "NaN of NumPy", np.float32("nan"), REFUSE
    yield "True", True, REFUSE
    yield "two numbers", [good, good], REFUSE
    yield "empty", [], REFUSE
    yield "array of text", np.array("1"), REFUSE
    yield "masked array", np.ma.masked_array(good, True), REFUSE
    yield "Fraction", Fraction(good), RIGHT
    yield "array without axes", np.array(good), RIGHT
    if float(good) == round(good) and abs(good) <= 127:
        yield "int8", np.int8(good), RIGHT
        yield "int", int(good), RIGHT
    if float(np.float16(good)) == good:
        yield "float16", np.float16(good), RIGHT
    yield "zero", 0.0, MAY
    yield "negative", -1.0, MAY
    yield "huge", 1e12, MAY
    yield "tiny", 1e-30, MAY


def wholes(good):
    """Bad values of one whole number."""
    yield from (row for row in numbers(good) if row[0] not in ("int", "tiny"))
    yield "fraction", good + 0.5, REFUSE
    yield "beyond integers", 1e300, MAY
    if 0 <= good <= 255:
        yield "uint8", np.uint8(good), RIGHT
    yield "int64", np.int64(good), RIGHT
    yield "huge whole", HUGE, MAY
    yield "huge of NumPy", np.int64(HUGE), MAY
    yield "negative whole", -1, MAY
    yield "no more than zero", 0, MAY


def flags(good):
    """Bad values of True or False."""
    yield from strange()
    yield "two", 2, REFUSE
    yield "NaN", np.nan, REFUSE
    yield "array", np.array([True, False]), REFUSE
    yield "empty", [], REFUSE
    yield "truth of NumPy", np.bool_(good), RIGHT


def words(good):
    """Bad values of a word."""
    yield from (row for row in strange() if not isinstance(row[1], str))
    yield "number", 3, REFUSE
    yield "NaN", np.nan, REFUSE
    yield "array", np.zeros(2), REFUSE
    yield "no such word", "nonsense", REFUSE
    yield "empty", "", REFUSE


def things(good):
    """Bad values of what is no number: cameras, functions, mappings, axes."""
    for label, value, verdict in strange():
        if not (callable(good) and callable(value)):
            yield label, value, verdict
    yield "number", 3.5, REFUSE
    yield "NaN", np.nan, REFUSE
    yield "array", np.zeros(3), REFUSE
    yield "True", True, REFUSE


def members(good):
    """A sequence with one bad member; one too few, one too many, none."""
    some = list(enumerate(good))[:3]
    yield from _inside(good, some, lambda i, bad: _replaced(good, i, bad))
    yield "empty", type(good)(), MAY
    yield "one less", good[:-1], MAY
    yield "one more", (*good, *good[-1:]), MAY


def members_of_mapping(good):
    """A mapping with one bad value; an empty one."""
    first = list(good.items())[:1]
    yield from _inside(good, first, lambda key, bad: {**good, key: bad})
    yield "empty mapping", {}, MAY


def _inside(good, members, replaced):
    for key, member in members:
        if callable(member):
            continue
        yield f"{key}: None", replaced(key, None), REFUSE
        if isinstance(member, list) and not _is_numeric(member):
            continue  # a list in a list: its members are of another kind
        for kind in kinds(member, type(member)):
            for label, value, verdict in kind(member):
                yield f"{key}: {label}", replaced(key, value), verdict


def _replaced(good, place, bad):
    changed = list(good)
    changed[place] = bad
    return type(good)(changed) if type(good) in (list, tuple) else changed


def parameters(function):
    """Arguments of a function that can be bad, by name."""
    return {
        name: one
        for name, one in inspect.signature(function).parameters.items()
        if name not in ("self", "cls")
        and one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)
    }


class Wrong(Exception):
    """What a reader's function may raise."""


def answers():
    """Bad answers of a reader."""
    yield from strange()
    yield "None", None, REFUSE
    yield "nothing yet", ..., REFUSE
    yield "NaN", np.nan, REFUSE
    yield "NaNs", np.full(3, np.nan), REFUSE
    yield "square of NaNs", np.full((3, 3), np.nan), REFUSE
    yield "inf", np.inf, REFUSE
    yield "a number", -12345.6, REFUSE
    yield "True", True, MAY
    yield "empty", [], REFUSE
    yield "ragged", [[1.0, 2.0], [3.0]], REFUSE
    yield "complex numbers", np.full(2, 1j), REFUSE
    yield "masked numbers", np.ma.masked_all(2), REFUSE
    yield "dates", np.full(2, "2020-01-01", "M8[D]"), REFUSE
    yield "objects", np.array([None, "1"]), REFUSE


def readers(shapes=((), (2,), (3,), (2, 2), (3, 3), (5,), (6,))):
    """Bad functions of a reader, as named functions."""
    for label, answer, verdict in answers():
        yield f"returns {label}", _returning(answer), verdict
    for shape in shapes:
        for text, number in (("NaN", np.nan), ("inf", np.inf), ("zeros", 0.0)):
            if text != "zeros":
                array = np.full(shape, number)
                yield f"returns {text} {shape}", _returning(array), REFUSE
    yield "raises", _raising(Wrong("wrong")), REFUSE
    yield "raises without text", _raising(ValueError()), REFUSE
    yield "raises a key", _raising(KeyError("x")), REFUSE
    yield "takes nothing", _named(lambda: 1.0), REFUSE
    yield "returns what it got", _named(lambda *a: a[0]), MAY
    yield "returns NaN in the shape of the first", _like(0), REFUSE
    yield "returns NaN in the shape of the last", _like(-1), REFUSE
    yield "warns", _named(lambda *a: np.array([np.log(-1.0)] * 3)), REFUSE
    for label, value, verdict in strange():
        if not callable(value):
            yield f"is {label}", value, verdict


def _named(function):
    function.__name__ = "mine"
    return function


def _returning(answer):
    return _named(lambda *_: answer)


def _raising(error):
    def mine(*_):
        raise error

    return mine


def _like(place):
    return _named(lambda *a: np.full(np.shape(a[place]), np.nan))
