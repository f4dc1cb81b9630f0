"""A photogrammetric network: cameras, photos, object points and the rays between."""

import os
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import Camera
from pgm_lab.io.text import Source, read_table

SIGMA = 0.001  # mm, of image coordinates of which nothing is said
RAY = ("point", "photo", "x", "y", "sx", "sy")  # columns of a file


@dataclass(frozen=True, eq=False, init=False)
class Network:
    """Image observations with start values of all they depend on.

    A ray is one point in one photo. Indices count from 0; the names are for reports.

    Parameters
    ----------
    cameras : Camera or sequence of Camera
        Start values of the interior orientations, all with the same lens direction.
    exteriors : array_like (m, 6)
        (X0, Y0, Z0, omega, phi, kappa) of the photos, in object units and radians.
    points : array_like (n, 3)
        Object points.
    photo, point : array_like (k,) of int
        The photo and the point of each ray.
    xy : array_like (k, 2)
        Image coordinates as measured, in mm.
    sigma : array_like (k, 2), (2,) or float, optional
        Their standard deviations, in mm; 0.001 when neither these nor covariances are
        given.
    camera : array_like (m,) of int, optional
        The camera of each photo; the first one when missing.
    fixed : array_like of int
        Points held at their coordinates: control points without error.
    control : tuple, optional
        (points (q,), coordinates (q, 3), sigma (q, 3) or float): control points with
        standard deviations in object units; 0 holds a coordinate, inf leaves it free.
    check : tuple, optional
        (points (c,), coordinates (c, 3)): known points, not used but compared.
    datum_points : array_like of int, optional
        Points that take part in the inner constraints; all when missing.
    scale_bars : array_like (s, 4)
        (point, point, distance, sigma) in object units, sigma above 0.
    photo_names, point_names : sequence, optional
        Names for reports; 1, 2, ... when missing.
    covariance : array_like (k, 2, 2), optional
        Of x and y of each ray in mm^2, as matching gives them, in place of `sigma`,
        which then holds the roots of their diagonals.

    Raises
    ------
    ValueError
        If shapes or indices do not fit, a sigma is not positive, a covariance singular,
        a photo has a point twice, a camera no photo, or a point two of the roles fixed,
        control and check.

    See Also
    --------
    Network.of : the same from tables with names.

    Examples
    --------
    >>> exteriors = [(0, 0, 1000, 0, 0, 0), (300, 0, 1000, 0, 0, 0)]
    >>> network = Network(
    ...     Camera(50.0), exteriors, [(100, 20, 0)], [0, 1], [0, 0], [(5, 1), (-10, 1)]
    ... )
    >>> network.xy.shape, network.rays_of_points
    ((2, 2), array([2]))
    """

    cameras: tuple[Camera, ...]
    exteriors: np.ndarray
    points: np.ndarray
    photo: np.ndarray
    point: np.ndarray
    xy: np.ndarray
    sigma: np.ndarray
    camera: np.ndarray
    fixed: np.ndarray
    control: tuple[np.ndarray, np.ndarray, np.ndarray] | None
    check: tuple[np.ndarray, np.ndarray] | None
    datum_points: np.ndarray | None
    scale_bars: np.ndarray
    photo_names: tuple
    point_names: tuple
    covariance: np.ndarray | None

    def __init__(
        self,
        cameras: Camera | Sequence[Camera],
        exteriors: ArrayLike,
        points: ArrayLike,
        photo: ArrayLike,
        point: ArrayLike,
        xy: ArrayLike,
        sigma: ArrayLike | None = None,
        camera: ArrayLike | None = None,
        fixed: ArrayLike = (),
        control: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
        check: tuple[ArrayLike, ArrayLike] | None = None,
        datum_points: ArrayLike | None = None,
        scale_bars: ArrayLike = (),
        photo_names: Sequence | None = None,
        point_names: Sequence | None = None,
        covariance: ArrayLike | None = None,
    ) -> None:
        values: dict[str, Any] = {"cameras": _cameras(cameras)}
        values["exteriors"] = _table(exteriors, 6, "exteriors")
        values["points"] = points = _table(points, 3, "points")
        values["xy"] = _table(xy, 2, "xy")
        m, n, k = len(values["exteriors"]), len(points), len(values["xy"])
        values["photo"] = photo = _indices(photo, m, "photo", k)
        values["point"] = point = _indices(point, n, "point", k)
        values["sigma"], values["covariance"] = _accuracy(sigma, covariance, k)
        values["camera"] = _camera_of_photos(camera, m, len(values["cameras"]))
        values["fixed"] = np.unique(_indices(fixed, n, "fixed"))
        values["control"] = _control(control, n)
        values["check"] = _check(check, n)
        _refuse_two_roles(values["fixed"], values["control"], values["check"])
        if datum_points is not None:
            datum_points = np.unique(_indices(datum_points, n, "datum_points"))
        values["datum_points"] = datum_points
        values["scale_bars"] = _scale_bars(scale_bars, points)
        photo_names = _names(photo_names, m, "photo_names")
        point_names = _names(point_names, n, "point_names")
        values |= {"photo_names": photo_names, "point_names": point_names}
        _refuse_doubles(photo, point, photo_names, point_names)
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(
        cls,
        cameras: Camera | Mapping,
        photos: Mapping,
        points: Mapping,
        observations: Iterable | str | os.PathLike,
        *,
        camera: Mapping | None = None,
        fixed: Iterable = (),
        control: Mapping | None = None,
        check: Mapping | None = None,
        datum_points: Iterable | None = None,
        scale_bars: Iterable = (),
    ) -> "Network":
        """Make a network of tables with names, as they come out of a file or a match.

        Parameters
        ----------
        cameras : Camera or mapping {name: Camera}
        photos : mapping {name: (X0, Y0, Z0, omega, phi, kappa)}
            Exterior orientations, in object units and radians.
        points : mapping {name: (X, Y, Z)}
        observations : iterable of rows, or str or path
            (photo, point, x, y); or with standard deviations (photo, point, x, y, sx,
            sy); or with a covariance (2, 2) in the fifth place, as the `rows` of
            `pgm_lab.observations`. In mm and mm^2; all rows alike. Or the file that
            `Observations.save` and `stereo_map.save` write, in which the point stands
            first and names are whole numbers.
        camera : mapping {photo: camera}, optional
            The camera of each photo; needed where there are several.
        fixed, datum_points : iterable of point names, optional
        control : mapping {point: (X, Y, Z, sX, sY, sZ)}, optional
            Control points; a standard deviation of 0 holds a coordinate, inf leaves it
            free.
        check : mapping {point: (X, Y, Z)}, optional
        scale_bars : iterable of rows (point, point, distance, sigma), optional

        Returns
        -------
        Network
            Photos and points in the order of their tables, and with these names.

        Raises
        ------
        ValueError
            If a name is not in its table, a file is wrong (name and line), or as
            `Network`.
        FileNotFoundError
            If there is no such file.

        Examples
        --------
        >>> photos = {"A": (0, 0, 1000, 0, 0, 0), "B": (300, 0, 1000, 0, 0, 0)}
        >>> rows = [("A", "tower", 5, 1), ("B", "tower", -10, 1)]
        >>> network = Network.of(Camera(50.0), photos, {"tower": (100, 20, 0)}, rows)
        >>> network.photo, network.point_names
        (array([0, 1]), ('tower',))
        """
        for name, table in (("photos", photos), ("points", points)):
            if not isinstance(table, Mapping) or not table:
                raise ValueError(f"{name} must be a mapping of names, with one or more")
        found = _read_observations(observations, photos, points)
        found["exteriors"] = _values(photos, 6, "photos")
        found["points"] = _values(points, 3, "points")
        found["cameras"] = cameras
        if isinstance(cameras, Mapping):
            found["cameras"] = tuple(cameras.values())
            found["camera"] = _camera_by_name(cameras, photos, camera)

        # What is known of the points
        found["fixed"] = _places(fixed, points, "points", "fixed")
        if control is not None:
            _validate.mapping(control, "control")
            place = _places(list(control), points, "points", "control")
            values = _values(control, 6, "control", finite=False)
            found["control"] = place, values[:, :3], values[:, 3:]
        if check is not None:
            _validate.mapping(check, "check")
            place = _places(list(check), points, "points", "check")
            found["check"] = place, _values(check, 3, "check")
        if datum_points is not None:
            place = _places(datum_points, points, "points", "datum_points")
            found["datum_points"] = place
        bars = _rows(scale_bars, "scale_bars")
        if any(len(bar) != 4 for bar in bars):
            raise ValueError("scale_bars must be rows (point, point, distance, sigma)")
        ends = [
            _places([bar[i] for bar in bars], points, "points", "scale_bars, row {}")
            for i in (0, 1)
        ]
        found["scale_bars"] = [(*e, *bar[2:]) for *e, bar in zip(*ends, bars)]
        return cls(**found, photo_names=tuple(photos), point_names=tuple(points))

    def without(self, rays: ArrayLike) -> "Network":
        """Return the network without some of its rays, by their indices."""
        kept = np.ones(len(self.xy), bool)
        kept[_indices(rays, len(self.xy), "rays")] = False
        return replace(self, **self._some_rays(kept))

    def only(self, photos: ArrayLike) -> "Network":
        """Return the network of some photos, by their indices.

        Points with too few rays go, and cameras that took none of these photos.

        Examples
        --------
        >>> from pgm_lab import simulate
        >>> net = simulate.network(Camera(35.0), 4, 30, np.random.default_rng(1))
        >>> whole = Network(
        ...     net.camera, net.exteriors, net.points, net.photo, net.point, net.xy
        ... )
        >>> whole.only([0, 3]).photo_names
        (1, 4)
        """
        m = len(self.exteriors)
        chosen = np.zeros(m, bool)
        chosen[_indices(photos, m, "photos")] = True
        rest = replace(self, **self._some_rays(chosen[self.photo]))
        return rest._some_photos(chosen, ~rest.too_few_rays)

    def _some_rays(self, kept: np.ndarray) -> dict[str, Any]:
        """What changes if some rays (k,) are kept."""
        names = ["photo", "point", "xy", "sigma"]
        if self.covariance is not None:
            names.append("covariance")
        return {name: getattr(self, name)[kept] for name in names}

    def _some_photos(self, photos: np.ndarray, points: np.ndarray) -> "Network":
        """The network of some photos (m,) and points (n,), by their rays."""
        photo_place, point_place = np.cumsum(photos) - 1, np.cumsum(points) - 1
        found = self._some_rays(photos[self.photo] & points[self.point])
        found["photo"] = photo_place[found["photo"]]
        found["point"] = point_place[found["point"]]
        found["exteriors"], found["points"] = (
            self.exteriors[photos],
            self.points[points],
        )
        for name, kept in (("photo_names", photos), ("point_names", points)):
            found[name] = tuple(one for one, k in zip(getattr(self, name), kept) if k)
        used, found["camera"] = np.unique(self.camera[photos], return_inverse=True)
        found["cameras"] = tuple(self.cameras[i] for i in used)

        found["fixed"] = point_place[self.fixed[points[self.fixed]]]
        if self.datum_points is not None:
            datum = self.datum_points[points[self.datum_points]]
            found["datum_points"] = point_place[datum]
        for name in ("control", "check"):
            if (known := getattr(self, name)) is not None:
                index, *values = (part[points[known[0]]] for part in known)
                found[name] = (point_place[index], *values) if len(index) else None
        ends = self.scale_bars[:, :2].astype(int)
        bars = np.column_stack([point_place[ends], self.scale_bars[:, 2:]])
        found["scale_bars"] = bars[points[ends].all(axis=1)]
        return replace(self, **found)

    @property
    def interior(self) -> np.ndarray:
        """Interior parameters (cameras, 10) in the order of `camera.PARAMETERS`."""
        return np.array([camera.interior for camera in self.cameras])

    @property
    def correlation(self) -> np.ndarray:
        """Correlation (k,) of x and y of each ray; 0 without covariances."""
        if self.covariance is None:
            return np.zeros(len(self.xy))
        return self.covariance[:, 0, 1] / self.sigma.prod(axis=1)

    @property
    def sigma_alone(self) -> np.ndarray:
        """Standard deviations (k, 2) of each coordinate if the other one were known."""
        return self.sigma * np.sqrt(1 - self.correlation[:, None] ** 2)

    @property
    def rays_of_points(self) -> np.ndarray:
        """Number of rays (n,) of each point."""
        return np.bincount(self.point, minlength=len(self.points))

    @property
    def rays_of_photos(self) -> np.ndarray:
        """Number of rays (m,) of each photo."""
        return np.bincount(self.photo, minlength=len(self.exteriors))

    @property
    def held(self) -> np.ndarray:
        """Coordinates (n, 3) of points that are no unknowns, as bool."""
        held = np.zeros(self.points.shape, bool)
        held[self.fixed] = True
        if self.control is not None:
            index, _, sigma = self.control
            held[index] |= sigma == 0
        return held

    @property
    def known(self) -> np.ndarray:
        """Coordinates (n, 3) that are held, or observed at control points, as bool."""
        known = self.held
        if self.control is not None:
            index, _, sigma = self.control
            known[index] |= np.isfinite(sigma)
        return known

    @property
    def too_few_rays(self) -> np.ndarray:
        """Points (n,) with fewer image coordinates than unknown ones, as bool."""
        return 2 * self.rays_of_points < 3 - self.known.sum(axis=1)


# --- Argument validation: into the shapes that a network keeps ---


def _cameras(given: Camera | Sequence[Camera]) -> tuple[Camera, ...]:
    one = isinstance(given, Camera)
    cameras = (given,) if one else tuple(_validate.several(given, "cameras", Camera))
    if len({one.lens for one in cameras}) != 1:
        raise ValueError(
            "cameras must be one Camera or several with the same lens direction;"
            f" got {len(cameras)} with {[one.lens for one in cameras]}"
        )
    return cameras


def _table(
    values: ArrayLike, columns: int, name: str, rows: int | None = None
) -> np.ndarray:
    """Return a copy of `values` as an array (rows, columns)."""
    array = _validate.points(values, columns, name)
    if array.ndim != 2 or rows not in (None, len(array)):
        raise ValueError(
            f"{name} must have shape ({'rows' if rows is None else rows}, {columns});"
            f" got {array.shape}"
        )
    return array.copy()


def _given(values: Any) -> bool:
    """Whether there is any value."""
    if isinstance(values, list | tuple):
        return len(values) > 0
    return values is not None and np.size(values) > 0


def _indices(
    values: ArrayLike, size: int, name: str, length: int | None = None
) -> np.ndarray:
    """Return a copy of `values` as indices from 0 to size - 1; none if empty."""
    none = values is not None and not _given(values)
    return _validate.indices(np.zeros(0, int) if none else values, size, name, length)


def _accuracy(
    sigma: ArrayLike | None, covariance: ArrayLike | None, k: int
) -> tuple[np.ndarray, np.ndarray | None]:
    """Standard deviations (k, 2), and covariances (k, 2, 2) if they were given."""
    stated = _given(sigma)
    sd = _validate.finite(sigma if stated else SIGMA, "sigma")
    if covariance is None:
        _validate.refuse(
            np.atleast_1d(sd <= 0),
            "sigma{} must be positive standard deviations; to leave an observation out,"
            " leave out its ray",
        )
        return _broadcast(sd, (k, 2), "sigma"), None
    C = _validate.covariances(covariance, "covariance", singular=False)
    C = _broadcast(C, (k, 2, 2), "covariance")
    of_C = np.sqrt(np.diagonal(C, axis1=1, axis2=2))
    if stated and not np.allclose(_broadcast(sd, (k, 2), "sigma"), of_C, 1e-9, 0):
        raise ValueError(
            "sigma and covariance say different things: give one of them, and None for"
            " the other"
        )
    return of_C, C


def _broadcast(values: np.ndarray, shape: tuple[int, ...], name: str) -> np.ndarray:
    """Return a copy of `values` in this shape."""
    try:
        return np.broadcast_to(values, shape).copy()
    except ValueError:
        what = "one matrix (2, 2)" if name == "covariance" else "one number"
        raise ValueError(
            f"{name} must be {what} or have shape {shape}; got {values.shape}"
        ) from None


def _camera_of_photos(values: ArrayLike | None, m: int, cameras: int) -> np.ndarray:
    """Camera (m,) of each photo; by default the first one."""
    of_photos = np.zeros(m, int) if values is None or not _given(values) else values
    camera = _indices(of_photos, cameras, "camera", m)
    _validate.refuse(
        ~np.isin(np.arange(cameras), camera),
        "cameras{} have no photo: leave them out, or correct `camera`, the camera of"
        " each photo",
    )
    return camera


def _control(
    values: tuple | None, n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Points (q,), coordinates (q, 3) and sigma (q, 3) of control points."""
    if values is None:
        return None
    index, coordinates, sigma = _parts(values, 3, "control")
    index = _indices(index, n, "control")
    if len(np.unique(index)) != len(index):
        raise ValueError("control has a point twice")
    coordinates = _table(coordinates, 3, "control", len(index))
    sigma = _validate.real(sigma, "control sigma")
    if not np.all(sigma >= 0):
        raise ValueError(
            "control must have sigmas above 0, 0 to hold a coordinate, or inf to leave"
            " it free"
        )
    return index, coordinates, _broadcast(sigma, coordinates.shape, "control sigma")


def _check(values: tuple | None, n: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Points (c,) and coordinates (c, 3) of check points."""
    if values is None:
        return None
    index, coordinates = _parts(values, 2, "check")
    index = _indices(index, n, "check")
    return index, _table(coordinates, 3, "check", len(index))


def _parts(values: tuple, number: int, name: str) -> tuple:
    if not isinstance(values, tuple | list) or len(values) != number:
        words = ("points", "coordinates", "sigma")[:number]
        raise ValueError(f"{name} must be a tuple ({', '.join(words)})")
    return tuple(values)


def _refuse_two_roles(
    fixed: np.ndarray, control: tuple | None, check: tuple | None
) -> None:
    """Refuse a point with two of the roles fixed, control and check."""
    roles = {"fixed": fixed}
    roles |= {"control": control[0]} if control is not None else {}
    roles |= {"check": check[0]} if check is not None else {}
    for one, other in combinations(roles, 2):
        if len(both := np.intersect1d(roles[one], roles[other])):
            raise ValueError(
                f"point {both[0]} is in `{one}` and in `{other}`: a point has one"
                " of these roles only"
            )


def _scale_bars(values: ArrayLike, points: np.ndarray) -> np.ndarray:
    """Scale bars (s, 4)."""
    rows = values if _given(values) else np.zeros((0, 4))
    bars = _validate.of_shape(rows, (None, 4), "scale_bars").copy()
    ends, n = bars[:, :2], len(points)
    if np.any((ends < 0) | (ends >= n)):
        raise ValueError(f"the points of scale_bars must be indices from 0 to {n - 1}")
    if np.any(ends != np.round(ends)) or np.any(ends[:, 0] == ends[:, 1]):
        raise ValueError("scale_bars must join two different points, by their indices")
    if np.any(bars[:, 2:] <= 0):
        raise ValueError("scale_bars must have a positive distance and sigma")
    one, other = ends.T.astype(int)
    _validate.refuse(
        np.all(points[one] == points[other], axis=1),
        "scale_bars{} join points with the same start values: a distance of 0 has no"
        " direction",
    )
    return bars


def _names(values: Sequence | None, size: int, what: str) -> tuple:
    """Names, 1, 2, ... where there are none."""
    named = [] if values is None else _validate.several(values, what)
    named = named or list(range(1, size + 1))
    if not all(isinstance(name, Hashable) for name in named):
        raise ValueError(f"{what} must be names such as texts or numbers")
    if len(named) != size or len(set(named)) != size:
        raise ValueError(f"{what} must be {size} different names; got {len(named)}")
    return tuple(named)


def _refuse_doubles(
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


# --- Tables with names ---


def _places(names: Iterable, table: Iterable, what: str, where: str) -> np.ndarray:
    """Indices of names in a table; `where` is for messages."""
    place = {key: i for i, key in enumerate(table)}
    found = []
    for i, name in enumerate(_validate.several(names, where)):
        if not isinstance(name, Hashable) or name not in place:
            some = ", ".join(map(repr, list(place)[:5]))
            more = ", ..." if len(place) > 5 else ""
            raise ValueError(
                f"{where.format(i)}: {_validate.shown(name)} is not in {what}, which"
                f" has {some}{more}"
            )
        found.append(place[name])
    return np.array(found, int)


def _rows(values: Iterable, name: str) -> list[tuple]:
    several = _validate.several
    return [tuple(several(row, f"{name}, a row")) for row in several(values, name)]


def _values(table: Mapping, columns: int, name: str, finite: bool = True) -> np.ndarray:
    """Values of a table as rows of `columns` numbers."""
    rows = {k: _validate.real(row, f"{name}, {k!r}") for k, row in table.items()}
    for key, row in rows.items():
        if row.shape != (columns,) or (finite and not np.all(np.isfinite(row))):
            kind = "finite numbers" if finite else "numbers"
            raise ValueError(f"{name}, {key!r}: {columns} {kind} are needed; got {row}")
    return np.array(list(rows.values()))


def _read_observations(
    observations: Iterable | Source, photos: Mapping, points: Mapping
) -> dict[str, Any]:
    """Indices, coordinates and accuracies of rows of observations, or of a file."""
    if isinstance(observations, str | os.PathLike):
        observations = _observations_of_file(observations, photos, points)
    rows = _rows(observations, "observations")
    must = (
        "observations must be rows (photo, point, x, y), (photo, point, x, y, sx, sy)"
        " or (photo, point, x, y, covariance), all alike"
    )
    kinds = {len(row) for row in rows}
    if len(kinds) != 1 or not kinds <= {4, 5, 6}:
        raise ValueError(f"{must}; got rows of {sorted(kinds) or 'no'} columns")
    found: dict[str, Any] = {
        "photo": _places(
            [r[0] for r in rows], photos, "photos", "observations, row {}"
        ),
        "point": _places(
            [r[1] for r in rows], points, "points", "observations, row {}"
        ),
    }
    found["xy"] = _validate.finite([row[2:4] for row in rows], "observations (x, y)")
    if kinds == {6}:
        sigma = [row[4:] for row in rows]
        found["sigma"] = _validate.finite(sigma, "observations (sx, sy)")
    if kinds == {5}:
        C = [_validate.finite(row[4], "observations (covariance)") for row in rows]
        if {one.shape for one in C} != {(2, 2)}:
            raise ValueError(f"{must}; a covariance has shape (2, 2)")
        found["covariance"] = np.array(C)
    return found


def _observations_of_file(
    path: Source, photos: Mapping, points: Mapping
) -> list[tuple]:
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


def _camera_by_name(
    cameras: Mapping, photos: Mapping, camera: Mapping | None
) -> np.ndarray:
    """Camera (m,) of each photo."""
    if camera is None:
        if len(cameras) > 1:
            raise ValueError("camera must name the camera of each photo: {photo: name}")
        return np.zeros(len(photos), int)
    _validate.mapping(camera, "camera")
    if missing := [name for name in photos if name not in camera]:
        raise ValueError(f"camera says nothing of photo {missing[0]!r}")
    names = [camera[name] for name in photos]
    return _places(names, cameras, "cameras", "camera")
