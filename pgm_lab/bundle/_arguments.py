"""Arguments of a network: checked, and brought into the shapes that it keeps."""

from collections.abc import Hashable, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate

SIGMA = 0.001  # mm, of image coordinates of which nothing is said


def table(
    values: ArrayLike, columns: int, name: str, rows: int | None = None
) -> np.ndarray:
    """Return a copy of `values` as an array (rows, columns)."""
    array = _validate.points(values, columns, name)
    if array.ndim != 2 or (rows is not None and len(array) != rows):
        raise ValueError(
            f"{name} must have shape ({'rows' if rows is None else rows}, {columns});"
            f" got {array.shape}"
        )
    return array.copy()


def given(values: ArrayLike | None) -> bool:
    """Whether there is any value; what cannot be counted is refused later."""
    try:
        return values is not None and np.size(values) > 0
    except Exception:  # whatever the conversion of a stranger's object raises
        return True


def indices(
    values: ArrayLike | None, size: int, name: str, length: int | None = None
) -> np.ndarray:
    """Return `values` as indices from 0 to size - 1; none if they are empty."""
    none = isinstance(values, np.ndarray | list | tuple) and not given(values)
    some = np.zeros(0, int) if none else values
    return _validate.indices(some, size, name, length)


def accuracy(
    sigma: ArrayLike | None, covariance: ArrayLike | None, k: int
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return standard deviations (k, 2), and covariances (k, 2, 2) if they were given.

    An empty sigma was not given.
    """
    stated = given(sigma)
    if covariance is None:
        values = _validate.finite(SIGMA if not stated else sigma, "sigma")
        _validate.refuse(
            np.atleast_1d(values <= 0),
            "sigma{} must be positive standard deviations; to leave an observation out,"
            " leave out its ray",
        )
        return broadcast(values, (k, 2), "sigma"), None
    C = _validate.covariances(covariance, "covariance", singular=False)
    C = broadcast(C, (k, 2, 2), "covariance")
    sd = np.sqrt(np.diagonal(C, axis1=1, axis2=2))
    if not stated:
        return sd, C
    values = _validate.finite(sigma, "sigma")
    if not np.allclose(broadcast(values, (k, 2), "sigma"), sd, 1e-9, 0):
        raise ValueError(
            "sigma and covariance say different things: give one of them, and None for"
            " the other"
        )
    return sd, C


def broadcast(values: np.ndarray, shape: tuple[int, ...], name: str) -> np.ndarray:
    """Return a copy of `values` in this shape: the caller may change his own."""
    try:
        return np.broadcast_to(values, shape).copy()
    except ValueError:
        what = "one matrix (2, 2)" if name == "covariance" else "one number"
        raise ValueError(
            f"{name} must be {what} or have shape {shape}; got {values.shape}"
        ) from None


def control(
    values: tuple | None, n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return points (q,), coordinates (q, 3) and sigma (q, 3) of control points."""
    if values is None:
        return None
    index, coordinates, sigma = _parts(values, 3, "control")
    index = indices(index, n, "control")
    if len(np.unique(index)) != len(index):
        raise ValueError("control has a point twice")
    coordinates = table(coordinates, 3, "control", len(index))
    sigma = _validate.real(sigma, "control sigma")
    if np.any(np.isnan(sigma)) or np.any(sigma < 0):
        raise ValueError(
            "control must have sigmas above 0, 0 to hold a coordinate, or inf to leave"
            " it free"
        )
    return index, coordinates, broadcast(sigma, coordinates.shape, "control sigma")


def check(values: tuple | None, n: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Return points (c,) and coordinates (c, 3) of check points."""
    if values is None:
        return None
    index, coordinates = _parts(values, 2, "check")
    index = indices(index, n, "check")
    return index, table(coordinates, 3, "check", len(index))


def _parts(values: tuple, number: int, name: str) -> tuple:
    if not isinstance(values, tuple | list) or len(values) != number:
        words = ("points", "coordinates", "sigma")[:number]
        raise ValueError(f"{name} must be a tuple ({', '.join(words)})")
    return tuple(values)


def scale_bars(values: ArrayLike, points: np.ndarray) -> np.ndarray:
    """Return scale bars (s, 4)."""
    rows = _validate.finite(values, "scale_bars") if given(values) else np.zeros((0, 4))
    bars = _validate.of_shape(rows, (None, 4), "scale_bars").copy()
    ends = bars[:, :2]
    if np.any(np.abs(ends) > len(points)):
        raise ValueError(
            f"the points of scale_bars must be indices from 0 to {len(points) - 1}"
        )
    whole = ends.astype(int)
    indices(whole.ravel(), len(points), "the points of scale_bars")
    if np.any(ends != np.round(ends)) or np.any(ends[:, 0] == ends[:, 1]):
        raise ValueError("scale_bars must join two different points, by their indices")
    if np.any(bars[:, 2:] <= 0):
        raise ValueError("scale_bars must have a positive distance and sigma")
    _validate.refuse(
        np.all(points[whole[:, 0]] == points[whole[:, 1]], axis=1),
        "scale_bars{} join points with the same start values: a distance of 0 has no"
        " direction",
    )
    return bars


def names(values: Sequence | None, size: int, what: str) -> tuple:
    """Return names, 1, 2, ... where there are none."""
    named = [] if values is None else _validate.several(values, what)
    named = named or list(range(1, size + 1))
    if not all(isinstance(name, Hashable) for name in named):
        raise ValueError(f"{what} must be names such as texts or numbers")
    if len(named) != size or len(set(named)) != size:
        raise ValueError(f"{what} must be {size} different names; got {len(named)}")
    return tuple(named)


def camera_of_photos(values: ArrayLike | None, m: int, cameras: int) -> np.ndarray:
    """Return the camera (m,) of each photo; the first one where nothing is said."""
    of_photo = values if given(values) else np.zeros(m, int)
    camera = indices(of_photo, cameras, "camera", m)
    _validate.refuse(
        ~np.isin(np.arange(cameras), camera),
        "cameras{} take no photo: leave them out, or correct `camera`, the camera of"
        " each photo",
    )
    return camera


def refuse_two_roles(
    fixed: np.ndarray, control: tuple | None, check: tuple | None
) -> None:
    """Refuse a point that is fixed, a control point and a check point, or two of it."""
    roles = {"fixed": fixed}
    roles |= {"control": control[0]} if control is not None else {}
    roles |= {"check": check[0]} if check is not None else {}
    for one, other in combinations(roles, 2):
        both = np.intersect1d(roles[one], roles[other])
        if len(both):
            raise ValueError(
                f"point {both[0]} is in `{one}` and in `{other}`: a point has one"
                " of these roles only"
            )


def refuse_doubles(
    photo: np.ndarray, point: np.ndarray, photo_names: tuple, point_names: tuple
) -> None:
    """Refuse a point that was measured twice in one photo."""
    ray = photo * len(point_names) + point
    found, count = np.unique(ray, return_counts=True)
    if np.any(count > 1):
        i, j = divmod(int(found[count > 1][0]), len(point_names))
        raise ValueError(
            f"photo {photo_names[i]} has point {point_names[j]}"
            f" {count[count > 1][0]} times: leave one, or take the mean"
            " with a smaller sigma"
        )
