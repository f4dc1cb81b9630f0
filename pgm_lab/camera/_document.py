"""The text of camera.json: what it states, and what is refused when it is read."""

import json
import math
import os
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files
from pgm_lab.io.files import printable

if TYPE_CHECKING:
    from pgm_lab.camera.model import Camera

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


@dataclass(frozen=True, eq=False)
class CameraFile:
    """A camera, how well it is known, and the image it belongs to.

    Attributes
    ----------
    camera : Camera
    image_size : (columns, rows)
        Of the whole photo, as it lies on the sensor.
    pixel_size : float
        Side of a pixel in mm.
    nominal : bool
        Whether the pixel size was only assumed, as 0.001 mm: c, x0, y0, ... are then in
        such units, and rays are right all the same.
    estimate : tuple of str
        The parameters that were estimated, in the order of the covariance.
    covariance : ndarray (u, u) or None
        Of these, in mm and its powers, as `bundle` estimates it; None if not known.
    about : str
        Where the camera comes from.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from pgm_lab.camera import Camera
    >>> camera = Camera(4.2, 0.01, K1=1.3e-3, lens="forward")
    >>> with TemporaryDirectory() as folder:
    ...     CameraFile(camera, (4000, 3000), 0.0014).save(f"{folder}/camera.json")
    ...     Camera.read(f"{folder}/camera.json") == camera
    True
    """

    camera: "Camera"
    image_size: tuple[int, int]
    pixel_size: float
    nominal: bool = False
    estimate: tuple[str, ...] = ()
    covariance: np.ndarray | None = field(default=None, repr=False)
    about: str = ""

    def __post_init__(self) -> None:
        if not hasattr(self.camera, "interior"):
            raise ValueError("camera must be a Camera")
        columns, rows = (int(n) for n in _validate.image_size(self.image_size))
        object.__setattr__(self, "image_size", (columns, rows))
        pixel = _validate.positive_number(self.pixel_size, "pixel_size", "mm")
        object.__setattr__(self, "pixel_size", pixel)
        _validate.flag(self.nominal, "nominal")
        _validate.instance(self.about, str, "about")
        off = math.hypot(columns, rows) / 2 * pixel / self.camera.c
        if not 1e-4 < off < 10:  # 84 degrees
            raise ValueError(
                f"the corner of {columns} x {rows} pixels of {pixel:g} mm is {off:.3g}"
                f" times c = {self.camera.c:g} from the middle: are all in mm?"
            )
        names = tuple(_validate.texts(self.estimate, "estimate"))
        object.__setattr__(self, "estimate", names)
        if self.covariance is not None:
            C = _covariance(names, self.covariance)
            object.__setattr__(self, "covariance", C)

    def text(self) -> str:
        """What stands in camera.json, which gives back each bit."""
        written = json.dumps(_stated(self), indent=2)
        # A row of a matrix and a parameter take one line each
        inner = r'\[[^][{}]*\]|\{\s*"value[^}]*\}'
        return re.sub(inner, lambda one: re.sub(r"\n *", " ", one[0]), written) + "\n"

    def save(self, path: str | os.PathLike, overwrite: bool = False) -> None:
        """Write a camera.json; FileExistsError if it is there, unless `overwrite`."""
        files.save({path: self.text()}, overwrite=overwrite)


def _covariance(names: tuple[str, ...], matrix: Any) -> np.ndarray:
    """Return the matrix if it can be the covariance of these parameters."""
    for name in names:
        _validate.choice(name, "a name of the covariance", tuple(UNITS))
    C = _validate.of_shape(matrix, (len(names), len(names)), "covariance")
    variance = np.diag(C)
    if len(set(names)) == len(names) > 0 and np.all(variance > 0):
        R = C / np.sqrt(variance) / np.sqrt(variance)[:, None]
        if np.abs(R - R.T).max() < 1e-9 and np.linalg.eigvalsh(R).min() > -1e-9:
            return C
    raise ValueError(
        "the covariance must be of some parameters, each once, with variances above"
        " zero, symmetric and positive semi-definite"
    )


def _stated(file: CameraFile) -> dict[str, Any]:
    """What stands in the file."""
    names, C = file.estimate, file.covariance
    sd, known = {}, None
    if C is not None:
        sd = dict(zip(names, np.sqrt(np.diag(C)).tolist()))
        units = [UNITS[name] for name in names]
        known = {"names": list(names), "units": units, "matrix": C.tolist()}
    return {
        "format": FORMAT,
        "convention": CONVENTION,
        "about": file.about,
        "image_size": list(file.image_size),
        "pixel_size": file.pixel_size,
        "pixel_size_is_nominal": bool(file.nominal),
        "lens": LENS[file.camera.lens],
        "parameters": {
            name: {"value": value, "sd": sd.get(name), "unit": UNITS[name]}
            for name, value in zip(UNITS, file.camera.interior.tolist())
        },
        "covariance": known,
    }


def read(path: str | os.PathLike, kind: "type[Camera]") -> CameraFile:
    """Read a file; what is wrong with it is said in a sentence that names it."""
    name = f"camera, {printable(path)}"
    content = files.content(path, name, LARGEST)
    try:
        whole = json.loads(content.decode("utf-8-sig"))
        given, known = whole["parameters"], whole["covariance"]
        values = {parameter: given[parameter]["value"] for parameter in UNITS}
        lens = _validate.choice(whole["lens"], "lens", tuple(LENS.values()))
        found = CameraFile(
            kind(**values, lens=lens.partition(":")[0]),
            whole["image_size"],
            whole["pixel_size"],
            whole["pixel_size_is_nominal"],
            known["names"] if known else (),
            known["matrix"] if known else None,
            whole["about"],
        )
        _compare(whole, _stated(found), "the file")
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        reason = " ".join(str(error).split())[:400]
        missing = " is missing" if isinstance(error, KeyError) else ""
        raise ValueError(f"{name}: this is no camera.json: {reason}{missing}") from None
    return found


def _compare(given: Any, expected: Any, name: str) -> None:
    """Refuse a file that lacks, adds or contradicts what follows from its numbers."""
    if isinstance(expected, dict):
        if not isinstance(given, dict):
            raise ValueError(f"{name} must have {', '.join(expected)}")
        for key in sorted(given.keys() ^ expected.keys()):
            raise ValueError(f'"{printable(key):.40}" in {name} is missing or unknown')
        for key, one in expected.items():
            _compare(given[key], one, f"{key} in {name}")
    elif given != expected:
        raise ValueError(f"{name} must be {expected!r}; got {_validate.shown(given)}")
