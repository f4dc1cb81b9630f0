"""Control points, and the model carried to them."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.orientation import Absolute


def points(
    names: Collection[int], control: Mapping[int, ArrayLike] | None
) -> dict[int, np.ndarray]:
    """Control points by the numbers of points on the list."""
    if control is None:
        return {}
    found = {}
    for name, place in _validate.mapping(control, "control").items():
        if name not in names:
            raise ValueError(f"control names point {name!r}, which is not on the list")
        found[name] = _validate.one_point(place, 3, f"control[{name}]")
    if len(found) < 3:
        raise ValueError(f"control must be three points or more; got {len(found)}")
    return found


def carried(exteriors: np.ndarray, to_object: Absolute) -> np.ndarray:
    """Exterior orientations (2, 6) of the model, carried into object space."""
    stations = to_object.apply(exteriors[:, :3])
    M = rotation.matrix(*exteriors[:, 3:].T) @ to_object.rotation.T
    return np.concatenate([stations, rotation.angles(M)], axis=1)
