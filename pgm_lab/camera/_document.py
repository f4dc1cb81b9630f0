"""The text of camera.json: what it states, and what is refused when it is read."""

import json
import math
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files
from pgm_lab.io.files import printable

FORMAT = "pgm_lab camera 1"
LARGEST = 2**20  # bytes of a file; some 6,000 are usual
UNITS = {
    **{"c": "mm", "x0": "mm", "y0": "mm", "K1": "mm^-2", "K2": "mm^-4"},
    **{"K3": "mm^-6", "P1": "mm^-1", "P2": "mm^-1", "b1": "1", "b2": "1"},
}
CONVENTION = {
    "units": "mm and its powers; pixels are square",
    "photo": "x to the right, y up, from the centre of the whole image",
    "pixel": "column = x / pixel_size + (columns - 1) / 2,"
    " row = (rows - 1) / 2 - y / pixel_size: whole numbers at pixel centres, the"
    " first is 0, and the centre of the image lies half a pixel before columns / 2",
    "perspective": "the camera looks along its -z: ideal x = -c U / W, y = -c V / W"
    " of a point (U, V, W) in its frame; (x0, y0) is added to measured ones",
    "lens": "Brown 1971 with affinity: dx = x (K1 r^2 + K2 r^4 + K3 r^6)"
    " + P1 (r^2 + 2 x^2) + 2 P2 x y + b1 x + b2 y, dy = y (K1 r^2 + K2 r^4 + K3 r^6)"
    " + P2 (r^2 + 2 y^2) + 2 P1 x y, with x, y reduced to (x0, y0), r^2 = x^2 + y^2",
}
LENS = {
    "backward": "backward: ideal = measured + (dx, dy) of measured",
    "forward": "forward: measured = ideal + (dx, dy) of ideal, as in OpenCV",
}
# The corner of a photo, in principal distances from the middle: 84 degrees off the axis
FARTHEST = 10.0
NEAREST = 1e-4


class Content(NamedTuple):
    """What the file states, checked."""

    interior: dict[str, float]
    lens: str
    image_size: tuple[int, int]
    pixel_size: float
    nominal: bool
    names: tuple[str, ...]
    covariance: np.ndarray | None
    about: str


def text(content: Content) -> str:
    """Write out a content, which is checked as that of a file is."""
    C, names = content.covariance, list(content.names)
    sd = dict(zip(names, np.sqrt(np.diag(C).clip(0)).tolist())) if C is not None else {}
    whole: dict[str, Any] = {
        "format": FORMAT,
        "convention": CONVENTION,
        "about": content.about,
        "image_size": list(content.image_size),
        "pixel_size": content.pixel_size,
        "pixel_size_is_nominal": content.nominal,
        "lens": LENS[content.lens],
        "parameters": {
            name: {"value": content.interior[name], "sd": sd.get(name), "unit": unit}
            for name, unit in UNITS.items()
        },
        "covariance": None,
    }
    if C is not None:
        units = [UNITS.get(name) for name in names]
        whole["covariance"] = {"names": names, "units": units, "matrix": C.tolist()}
    _checked(whole)
    return _written(whole) + "\n"


def _written(value: Any, indent: str = "\n") -> str:
    """JSON with a line for each number that has a name, and each row of a matrix."""
    members: list[str] = []
    deeper = indent + "  "
    if isinstance(value, dict) and indent != "\n    ":
        for key, one in value.items():
            members.append(f"{json.dumps(key)}: {_written(one, deeper)}")
        return "{" + deeper + f",{deeper}".join(members) + indent + "}"
    if isinstance(value, list) and value and isinstance(value[0], list):
        rows = f",{deeper}".join(map(json.dumps, value))
        return "[" + deeper + rows + indent + "]"
    return json.dumps(value)


def read(path: str | os.PathLike, name: str = "camera") -> Content:
    """Read a file; what is wrong with it is said in a sentence that names it."""
    name = f"{name}, {printable(path)}"
    read = files.content(path, name, LARGEST)
    try:
        whole = json.loads(
            read.decode("utf-8-sig"), parse_constant=_refuse, object_pairs_hook=_once
        )
    except (ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise ValueError(f"{name}: this is not a whole JSON file ({reason})") from None
    if not isinstance(whole, dict) or whole.get("format") != FORMAT:
        raise ValueError(
            f'{name}: this is not a camera.json: its "format" is not "{FORMAT}".'
            " camera.files.from_opencv takes the camera of OpenCV"
        )
    try:
        return _checked(whole)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def _refuse(word: str) -> None:
    raise ValueError(f"{word} is not a number")


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Members of an object, each of which stands there once."""
    names = [name for name, _ in pairs]
    if twice := [one for one in names if names.count(one) > 1]:
        raise ValueError(f'"{printable(twice[0]):.40}" stands there twice')
    return dict(pairs)


def _checked(whole: dict[str, Any]) -> Content:
    """Return what a file states, if it is whole, possible and does not contradict."""
    keys = "format convention about image_size pixel_size pixel_size_is_nominal lens"
    _members(whole, (*keys.split(), "parameters", "covariance"), "the file")
    stated = _members(whole["convention"], CONVENTION, "convention")
    for key, words in CONVENTION.items():
        if stated[key] != words:
            raise ValueError(f'another convention for "{key}"; expected: {words}')
    lens = next((one for one, words in LENS.items() if words == whole["lens"]), None)
    if lens is None:
        raise ValueError(f"lens must be one of {', '.join(map(repr, LENS.values()))}")
    if not isinstance(whole["about"], str):
        raise ValueError("about must be a text")
    size = whole["image_size"]
    if (
        not isinstance(size, list)
        or [type(n) for n in size] != [int, int]
        or not 0 < min(size) <= max(size) < 10**6
    ):
        raise ValueError(
            "image_size must be [columns, rows], two whole numbers of pixels; got"
            f" {_validate.shown(size)}"
        )
    pixel = _validate.positive_number(whole["pixel_size"], "pixel_size", "mm")
    nominal = _validate.flag(whole["pixel_size_is_nominal"], "pixel_size_is_nominal")

    # The parameters, and whether c fits the image
    given = _members(whole["parameters"], UNITS, "parameters")
    interior, sd = {}, {}
    for name, unit in UNITS.items():
        one = _members(given[name], ("value", "sd", "unit"), f"parameters.{name}")
        interior[name] = _validate.number(one["value"], name)
        sd[name] = one["sd"]
        if one["unit"] != unit:
            raise ValueError(f"the unit of {name} must be {unit!r}")
    _validate.positive(interior["c"], "c", "mm")
    off = math.hypot(*size) / 2 * pixel / interior["c"]
    if not NEAREST < off < FARTHEST:
        raise ValueError(
            f"the corner of a photo of {size[0]} x {size[1]} pixels of {pixel:g} mm is"
            f" {off:.3g} times c = {interior['c']:g} from its middle, as in no camera:"
            " are all in mm?"
        )

    # How well they are known
    names: tuple[str, ...] = ()
    C = None
    if (known := whole["covariance"]) is not None:
        known = _members(known, ("names", "units", "matrix"), "covariance")
        names, C = _covariance(known["names"], known["matrix"])
        if known["units"] != [UNITS[name] for name in names]:
            raise ValueError("the units of the covariance are not those of its names")
    roots = {} if C is None else dict(zip(names, np.sqrt(np.diag(C)).tolist()))
    for name, one in sd.items():
        root = roots.get(name)
        same = one is root  # None of what was not estimated
        if one is not None and root is not None:
            same = math.isclose(_validate.number(one, "sd"), root, rel_tol=1e-9)
        if not same:
            raise ValueError(
                f"the sd of {name} is {one}, and by the covariance it is {root}"
            )
    return Content(
        *(interior, lens, (size[0], size[1]), pixel, nominal, names, C, whole["about"])
    )


def _members(value: Any, names: Sequence[str] | dict, what: str) -> dict[str, Any]:
    """Return an object that has these members and no others."""
    if not isinstance(value, dict):
        raise ValueError(f"{what} must be an object with {', '.join(names)}")
    for name in names:
        if name not in value:
            raise ValueError(f'{what} lacks "{name}"')
    for name in value:
        if name not in names:
            raise ValueError(f'"{printable(name):.40}" in {what} is unknown')
    return value


def _covariance(names: Any, matrix: Any) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and their covariance, symmetric and positive."""
    if (
        not isinstance(names, list)
        or not names
        or len(set(map(str, names))) < len(names)
    ):
        raise ValueError(
            "the names of the covariance must be a list, each of them once"
        )
    for name in names:
        _validate.choice(name, "a name of the covariance", tuple(UNITS))
    C = _validate.of_shape(matrix, (len(names), len(names)), "covariance")
    variances = np.diag(C)
    if np.any(variances <= 0):
        bad = names[int(np.argmin(variances))]
        raise ValueError(f"the covariance gives {bad} a variance that is not positive")
    correlation = C / np.sqrt(np.outer(variances, variances))
    if np.any(np.abs(correlation - correlation.T) > 1e-9):
        raise ValueError("the covariance is not symmetric")
    if np.linalg.eigvalsh(correlation).min() < -1e-9:
        raise ValueError("the covariance is not positive semi-definite")
    return tuple(names), C
