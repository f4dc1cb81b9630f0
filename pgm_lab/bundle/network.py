"""A photogrammetric network: cameras, photos, object points and the rays between."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import Camera


@dataclass(frozen=True, eq=False)
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
    sigma : array_like (k, 2), (2,) or float
        Their standard deviations, in mm.
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

    Raises
    ------
    ValueError
        If shapes do not fit, an index does not exist, a number is not finite, a sigma
        is not positive, a photo has a point twice, a camera has no photo, or a point
        has two of the roles fixed, control and check.

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
    sigma: np.ndarray = 0.001
    camera: np.ndarray | None = None
    fixed: np.ndarray = ()
    control: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
    check: tuple[np.ndarray, np.ndarray] | None = None
    datum_points: np.ndarray | None = None
    scale_bars: np.ndarray = ()
    photo_names: Sequence | None = None
    point_names: Sequence | None = None

    def __post_init__(self):
        if isinstance(self.cameras, Camera):
            self._set(cameras=(self.cameras,))
        self._set(cameras=tuple(self.cameras))
        if not self.cameras or len({one.lens for one in self.cameras}) != 1:
            raise ValueError(
                "cameras must be one Camera or several with the same lens direction;"
                f" got {len(self.cameras)} with {[one.lens for one in self.cameras]}"
            )
        exteriors = _table(self.exteriors, 6, "exteriors")
        points = _table(self.points, 3, "points")
        m, n = len(exteriors), len(points)
        xy = _table(self.xy, 2, "xy")
        self._set(exteriors=exteriors, points=points, xy=xy)
        self._set(photo=_indices(self.photo, m, "photo", len(xy)))
        self._set(point=_indices(self.point, n, "point", len(xy)))
        self._set(sigma=_broadcast(_sigma(self.sigma, "sigma"), xy.shape, "sigma"))
        camera = np.zeros(m, int) if self.camera is None else self.camera
        self._set(camera=_indices(camera, len(self.cameras), "camera", m))
        unused = np.setdiff1d(np.arange(len(self.cameras)), self.camera)
        _validate.refuse(
            np.isin(np.arange(len(self.cameras)), unused),
            "cameras{} take no photo: leave them out, or correct `camera`, the camera"
            " of each photo",
        )
        self._set(fixed=np.unique(_indices(self.fixed, n, "fixed")))
        if self.control is not None:
            self._set(control=_control(self.control, n))
        if self.check is not None:
            index, coordinates = _parts(self.check, 2, "check")
            index = _indices(index, n, "check")
            self._set(check=(index, _table(coordinates, 3, "check", len(index))))
        self._refuse_two_roles()
        if self.datum_points is not None:
            datum = np.unique(_indices(self.datum_points, n, "datum_points"))
            self._set(datum_points=datum)
        self._set(scale_bars=_scale_bars(self.scale_bars, points))
        self._set(photo_names=_names(self.photo_names, m, "photo_names"))
        self._set(point_names=_names(self.point_names, n, "point_names"))
        self._refuse_doubles()

    def without(self, rays: ArrayLike) -> "Network":
        """Return the network without some of its rays, by their indices."""
        kept = np.ones(len(self.xy), bool)
        kept[_indices(rays, len(self.xy), "rays")] = False
        return replace(
            self,
            photo=self.photo[kept],
            point=self.point[kept],
            xy=self.xy[kept],
            sigma=self.sigma[kept],
        )

    def _set(self, **values) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _refuse_two_roles(self) -> None:
        roles = {"fixed": self.fixed}
        roles |= {"control": self.control[0]} if self.control is not None else {}
        roles |= {"check": self.check[0]} if self.check is not None else {}
        for one, other in combinations(roles, 2):
            both = np.intersect1d(roles[one], roles[other])
            if len(both):
                raise ValueError(
                    f"point {both[0]} is in `{one}` and in `{other}`: a point has one"
                    " of these roles only"
                )

    def _refuse_doubles(self) -> None:
        ray = self.photo * len(self.points) + self.point
        found, count = np.unique(ray, return_counts=True)
        if np.any(count > 1):
            photo, point = divmod(int(found[count > 1][0]), len(self.points))
            times = int(count[count > 1][0])
            raise ValueError(
                f"photo {self.photo_names[photo]} has point"
                f" {self.point_names[point]} {times} times: leave one, or take the mean"
                " with a smaller sigma"
            )

    @property
    def interior(self) -> np.ndarray:
        """Interior parameters (cameras, 10) in the order of `camera.PARAMETERS`."""
        return np.array([camera.interior for camera in self.cameras])

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


def _table(values: ArrayLike, columns: int, name: str, rows: int | None = None):
    array = _validate.points(values, columns, name)
    if array.ndim != 2 or (rows is not None and len(array) != rows):
        raise ValueError(
            f"{name} must have shape ({'rows' if rows is None else rows}, {columns});"
            f" got {array.shape}"
        )
    return array.copy()


def _indices(values: ArrayLike, size: int, name: str, length: int | None = None):
    array = np.asarray(values if np.size(values) else np.zeros(0, int))
    whole = np.issubdtype(array.dtype, np.integer)
    if array.ndim != 1 or not whole or length not in (None, len(array)):
        raise ValueError(
            f"{name} must be whole numbers in one row"
            + (f" of {length}" if length is not None else "")
            + f"; got shape {array.shape} of {array.dtype}"
        )
    if array.size and (array.min() < 0 or array.max() >= size):
        raise ValueError(
            f"{name} must be indices from 0 to {size - 1}; got {array.min()} to"
            f" {array.max()}. Numbers in a file often count from 1"
        )
    return array.astype(int)


def _sigma(values: ArrayLike, name: str) -> np.ndarray:
    sigma = _validate.finite(values, name)
    _validate.refuse(
        np.atleast_1d(sigma <= 0),
        name + "{} must be positive standard deviations; to leave an observation out,"
        " leave out its ray",
    )
    return sigma


def _broadcast(values: np.ndarray, shape: tuple[int, ...], name: str) -> np.ndarray:
    try:
        return np.broadcast_to(values, shape)
    except ValueError:
        raise ValueError(
            f"{name} must be one number or have shape {shape}; got {values.shape}"
        ) from None


def _parts(values, number: int, name: str):
    if not isinstance(values, tuple | list) or len(values) != number:
        words = ("points", "coordinates", "sigma")[:number]
        raise ValueError(f"{name} must be a tuple ({', '.join(words)})")
    return values


def _control(values, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    index, coordinates, sigma = _parts(values, 3, "control")
    index = _indices(index, n, "control")
    if len(np.unique(index)) != len(index):
        raise ValueError("control has a point twice")
    coordinates = _table(coordinates, 3, "control", len(index))
    sigma = np.asarray(sigma, dtype=float)
    if np.any(np.isnan(sigma)) or np.any(sigma < 0):
        raise ValueError(
            "control must have sigmas above 0, 0 to hold a coordinate, or inf to leave"
            " it free"
        )
    return index, coordinates, _broadcast(sigma, coordinates.shape, "control sigma")


def _scale_bars(values: ArrayLike, points: np.ndarray) -> np.ndarray:
    bars = np.reshape(values, (-1, 4)) if np.size(values) else np.zeros((0, 4))
    bars = _validate.finite(bars, "scale_bars")
    ends = bars[:, :2]
    whole = ends.astype(int)
    _indices(whole.ravel(), len(points), "the points of scale_bars")
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


def _names(names, size: int, what: str) -> tuple:
    names = range(1, size + 1) if names is None else names
    if len(names) != size or len(set(names)) != size:
        raise ValueError(f"{what} must be {size} different names; got {len(names)}")
    return tuple(names)
