"""Arguments of a network from tables with names, and those of a part of a network."""

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pgm_lab import _validate
from pgm_lab.camera import Camera
from pgm_lab.io.text import Source, read_table

if TYPE_CHECKING:
    from pgm_lab.bundle.network import Network

RAY = ("point", "photo", "x", "y", "sx", "sy")  # of a file, as `bundle.read` has it
ROWS = (
    "observations must be rows (photo, point, x, y), (photo, point, x, y, sx, sy) or"
    " (photo, point, x, y, covariance), all alike"
)


def read(
    cameras: Camera | Mapping,
    photos: Mapping,
    points: Mapping,
    observations: Iterable | Source,
    camera: Mapping | None,
) -> dict[str, Any]:
    """Cameras, photos, points and rays of a network, from tables with names."""
    for name, table in (("photos", photos), ("points", points)):
        if not isinstance(table, Mapping) or not table:
            raise ValueError(f"{name} must be a mapping of names, with one or more")
    if isinstance(observations, str | os.PathLike):
        observations = _of_file(observations, photos, points)
    found = _read_rows(
        _rows(observations, "observations"),
        _Places(photos, "photos"),
        _Places(points, "points"),
    )
    found |= {
        "cameras": cameras,
        "exteriors": _numbers(photos, 6, "photos"),
        "points": _numbers(points, 3, "points"),
        "photo_names": tuple(photos),
        "point_names": tuple(points),
    }
    if isinstance(cameras, Mapping):
        found["cameras"] = tuple(cameras.values())
        found["camera"] = _camera_of_photos(cameras, photos, camera)
    return found


def roles(
    points: Mapping,
    fixed: Iterable,
    control: Mapping | None,
    check: Mapping | None,
    datum_points: Iterable | None,
    scale_bars: Iterable,
) -> dict[str, Any]:
    """What is known of the points, by their names."""
    places = _Places(points, "points")
    bars = _rows(scale_bars, "scale_bars")
    if any(len(bar) != 4 for bar in bars):
        raise ValueError("scale_bars must be rows (point, point, distance, sigma)")
    found: dict[str, Any] = {
        "fixed": places.of(fixed, "fixed"),
        "scale_bars": [
            (
                *places.of(bar[:2], f"scale_bars, row {i}"),
                *_validate.of_shape(bar[2:], (2,), f"scale_bars, row {i}"),
            )
            for i, bar in enumerate(bars)
        ],
    }
    if control is not None and _validate.mapping(control, "control"):
        values = _numbers(control, 6, "control", finite=False)
        found["control"] = (
            places.of(list(control), "control"),
            values[:, :3],
            values[:, 3:],
        )
    if check is not None and _validate.mapping(check, "check"):
        found["check"] = places.of(list(check), "check"), _numbers(check, 3, "check")
    if datum_points is not None:
        found["datum_points"] = places.of(datum_points, "datum_points")
    return found


class _Places:
    """Where each name stands in its table."""

    def __init__(self, table: Iterable, name: str) -> None:
        self.place = {key: i for i, key in enumerate(table)}
        self.name = name

    def of(self, names: Iterable, where: str) -> np.ndarray:
        """Return the places of names; `where` they stand is for the message."""
        listed = _validate.several(names, where)
        strange = complex, np.timedelta64  # which compare equal to whole numbers
        listed = [None if isinstance(one, strange) else one for one in listed]
        return np.array([self.one(name, where) for name in listed], int)

    def one(self, name: Any, where: str) -> int:
        """Return the place of one name."""
        try:
            return self.place[name]
        except Exception:  # no such name, or none that can be one
            some = ", ".join(map(repr, list(self.place)[:5]))
            more = ", ..." if len(self.place) > 5 else ""
            raise ValueError(
                f"{where}: {_validate.shown(name)} is not in {self.name}, which has"
                f" {some}{more}"
            ) from None


def _read_rows(rows: list[tuple], photos: _Places, points: _Places) -> dict[str, Any]:
    """Indices, coordinates and accuracies of the rows of observations."""
    kinds = {len(row) for row in rows}
    if len(kinds) != 1 or not kinds <= {4, 5, 6}:
        raise ValueError(f"{ROWS}; got rows of {sorted(kinds) or 'no'} columns")
    found: dict[str, Any] = {
        "photo": np.array(
            [photos.one(row[0], f"observations, row {i}") for i, row in enumerate(rows)]
        ),
        "point": np.array(
            [points.one(row[1], f"observations, row {i}") for i, row in enumerate(rows)]
        ),
        "xy": _validate.finite([row[2:4] for row in rows], "observations (x, y)"),
    }
    if kinds == {6}:
        sigma = [row[4:] for row in rows]
        found["sigma"] = _validate.finite(sigma, "observations (sx, sy)")
    if kinds == {5}:
        C = [_validate.finite(row[4], "observations (covariance)") for row in rows]
        if {one.shape for one in C} != {(2, 2)}:
            raise ValueError(f"{ROWS}; a covariance has shape (2, 2)")
        found["covariance"] = np.array(C)
    return found


def _of_file(path: Source, photos: Mapping, points: Mapping) -> list[tuple]:
    """Rows of a file of image coordinates; a name may be the text of its number."""
    try:
        table = read_table(path, "image coordinates", RAY, 2)
    except FileNotFoundError as error:
        raise FileNotFoundError(f"observations: {error}") from None
    named: list[list] = []
    for column, (name, known) in enumerate((("point", points), ("photo", photos))):
        ids = table.ids(column, name)
        keys = {str(key): key for key in known}
        missing = np.array([str(one) not in keys for one in ids.tolist()], bool)
        table.refuse(missing, f"{name} {{}} is not in {name}s", ids)
        named.append([keys[str(one)] for one in ids.tolist()])
    return list(zip(named[1], named[0], *table.values[:, 2:].T.tolist()))


def _rows(values: Iterable, name: str) -> list[tuple]:
    """Rows of a table; as tuples, whatever they were."""
    several = _validate.several
    return [tuple(several(row, f"{name}, a row")) for row in several(values, name)]


def _numbers(
    table: Mapping, columns: int, name: str, finite: bool = True
) -> np.ndarray:
    """Return the values of a table as rows of so many numbers."""
    rows = {k: _validate.real(row, f"{name}, {k!r}") for k, row in table.items()}
    for key, row in rows.items():
        if row.shape != (columns,) or (finite and not np.all(np.isfinite(row))):
            kind = "finite numbers" if finite else "numbers"
            raise ValueError(f"{name}, {key!r}: {columns} {kind} are needed; got {row}")
    return np.array(list(rows.values()))


def _camera_of_photos(
    cameras: Mapping, photos: Mapping, camera: Mapping | None
) -> np.ndarray:
    if camera is None:
        if len(cameras) > 1:
            raise ValueError("camera must name the camera of each photo: {photo: name}")
        return np.zeros(len(photos), int)
    _validate.mapping(camera, "camera")
    if missing := [name for name in photos if name not in camera]:
        raise ValueError(f"camera says nothing of photo {missing[0]!r}")
    return _Places(cameras, "cameras").of((camera[name] for name in photos), "camera")


def some_rays(network: "Network", kept: np.ndarray) -> dict[str, Any]:
    """What changes in a network of which some rays (k,) are kept."""
    C = network.covariance
    return {
        "photo": network.photo[kept],
        "point": network.point[kept],
        "xy": network.xy[kept],
        "sigma": network.sigma[kept],
        "covariance": None if C is None else C[kept],
    }


def some_of(network: "Network", photos: np.ndarray, points: np.ndarray) -> dict:
    """What changes in a network of some photos (m,) and points (n,), by their rays."""
    photo_place, point_place = np.cumsum(photos) - 1, np.cumsum(points) - 1
    found = some_rays(network, photos[network.photo] & points[network.point])
    found |= {
        "exteriors": network.exteriors[photos],
        "points": network.points[points],
        "photo": photo_place[found["photo"]],
        "point": point_place[found["point"]],
        "photo_names": _some(network.photo_names, photos),
        "point_names": _some(network.point_names, points),
        "fixed": point_place[network.fixed[points[network.fixed]]],
    }
    used, camera = np.unique(network.camera[photos], return_inverse=True)
    found |= {"cameras": tuple(network.cameras[i] for i in used), "camera": camera}
    for name in ("control", "check"):
        if (known := getattr(network, name)) is not None:
            index, *values = (part[points[known[0]]] for part in known)
            found[name] = (point_place[index], *values) if len(index) else None
    if network.datum_points is not None:
        datum = network.datum_points[points[network.datum_points]]
        found["datum_points"] = point_place[datum]
    ends = network.scale_bars[:, :2].astype(int)
    there = points[ends].all(axis=1)
    bars = np.column_stack([point_place[ends], network.scale_bars[:, 2:]])
    return found | {"scale_bars": bars[there]}


def _some(names: tuple, kept: np.ndarray) -> tuple:
    return tuple(name for name, keep in zip(names, kept) if keep)
