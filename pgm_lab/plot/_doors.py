"""Checks of what the figures take: axes, colours, views, results of a bundle."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import is_color_like
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.bundle.result import Bundle


def axes(ax: Any) -> None:
    """Refuse what is no axes of matplotlib."""
    _validate.instance(ax, Axes, "ax")


def axes_in_space(ax: Any) -> None:
    """Refuse what is no axes in space, see `plot.space.space`."""
    _validate.instance(ax, Axes3D, "ax")


def colour(value: Any, name: str) -> None:
    """Refuse what matplotlib cannot read as a colour."""
    if not isinstance(value, str) or not is_color_like(value):
        raise ValueError(f"{name} must be a colour; got {_validate.shown(value)}")


def view(value: ArrayLike | None) -> tuple[float, float] | None:
    """Return (elevation, azimuth) in degrees, or None where nothing is said."""
    if value is None:
        return None
    elevation, azimuth = _validate.one_point(value, 2, "view").tolist()
    return elevation, azimuth


def form(value: ArrayLike) -> np.ndarray:
    """Return (width, height) of a photo over its principal distance."""
    return _validate.positive(_validate.one_point(value, 2, "form"), "form", "of c")


def faces(values: Any) -> list[tuple[np.ndarray, str]]:
    """Return polygons (k, 3), each with its colour."""
    found = []
    for face in _validate.several(values, "faces"):
        pair = _validate.several(face, "faces: a face")
        if len(pair) != 2:
            raise ValueError("faces must be pairs of a polygon and its colour")
        colour(pair[1], "faces: a colour")
        found.append((_validate.of_shape(pair[0], (None, 3), "faces"), pair[1]))
    return found


def square_map(values: ArrayLike) -> np.ndarray:
    """Return a square correlation map."""
    r = _validate.image(values, "r")
    if r.shape[0] != r.shape[1]:
        raise ValueError(f"r must be square; got shape {r.shape}")
    return r


def bundle(result: Any, camera: int = 0) -> int:
    """Refuse what is no result of `bundle.adjust`; return the index of its camera."""
    _validate.instance(result, Bundle, "result")
    return _validate.whole(camera, "camera", 0, len(result.cameras) - 1)


def lists(values: Any, name: str) -> dict[str, np.ndarray]:
    """Return a mapping of lists of numbers, all of one length and none empty."""
    given = _validate.mapping(values, name)
    found = {key: _validate.finite(one, f"{name}, {key}") for key, one in given.items()}
    shapes = {one.shape for one in found.values()}
    if len(shapes) != 1 or len(shape := shapes.pop()) != 1 or not shape[0]:
        raise ValueError(f"{name} must hold lists of numbers, all of one length")
    return found
