"""A photogrammetric network: cameras, photos, object points and the rays between."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab._validate import several
from pgm_lab.bundle import _arguments, _tables
from pgm_lab.camera import Camera


def _nothing() -> np.ndarray:
    return np.zeros(0, int)


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
        Covariances of x and y of each ray in mm^2, as matching gives them, in place of
        `sigma`, which then holds the roots of their diagonals. The weight matrix P has
        their inverses as blocks of 2 x 2.

    Raises
    ------
    ValueError
        If shapes do not fit, an index does not exist, a number is not finite, a sigma
        is not positive, a covariance is singular, a photo has a point twice, a camera
        has no photo, or a point has two of the roles fixed, control and check.

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
    sigma: np.ndarray = field(default_factory=_nothing)
    camera: np.ndarray = field(default_factory=_nothing)
    fixed: np.ndarray = field(default_factory=_nothing)
    control: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
    check: tuple[np.ndarray, np.ndarray] | None = None
    datum_points: np.ndarray | None = None
    scale_bars: np.ndarray = field(default_factory=_nothing)
    photo_names: tuple = ()
    point_names: tuple = ()
    covariance: np.ndarray | None = None

    if TYPE_CHECKING:  # what it takes, beside what it then holds

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
        ) -> None: ...

    def __post_init__(self) -> None:
        """Check everything, and bring it into the shapes that are kept."""
        given = self.cameras
        one = isinstance(given, Camera)
        cameras = (given,) if one else tuple(several(given, "cameras", Camera))
        if not cameras or len({one.lens for one in cameras}) != 1:
            raise ValueError(
                "cameras must be one Camera or several with the same lens direction;"
                f" got {len(cameras)} with {[one.lens for one in cameras]}"
            )
        exteriors = _arguments.table(self.exteriors, 6, "exteriors")
        points = _arguments.table(self.points, 3, "points")
        xy = _arguments.table(self.xy, 2, "xy")
        m, n, k = len(exteriors), len(points), len(xy)
        self._set(cameras=cameras, exteriors=exteriors, points=points, xy=xy)
        self._set(photo=_arguments.indices(self.photo, m, "photo", k))
        self._set(point=_arguments.indices(self.point, n, "point", k))
        sigma, covariance = _arguments.accuracy(self.sigma, self.covariance, k)
        self._set(sigma=sigma, covariance=covariance)
        self._set(camera=_arguments.camera_of_photos(self.camera, m, len(cameras)))
        self._set(fixed=np.unique(_arguments.indices(self.fixed, n, "fixed")))
        self._set(control=_arguments.control(self.control, n))
        self._set(check=_arguments.check(self.check, n))
        _arguments.refuse_two_roles(self.fixed, self.control, self.check)
        if self.datum_points is not None:
            datum = _arguments.indices(self.datum_points, n, "datum_points")
            self._set(datum_points=np.unique(datum))
        self._set(scale_bars=_arguments.scale_bars(self.scale_bars, points))
        self._set(photo_names=_arguments.names(self.photo_names, m, "photo_names"))
        self._set(point_names=_arguments.names(self.point_names, n, "point_names"))
        names = self.photo_names, self.point_names
        _arguments.refuse_doubles(self.photo, self.point, *names)

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
            If a name is not in its table, which the message tells with the place; if a
            file is wrong, with its name and the number of the line; or as `Network`
            does.
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
        tables = _tables.read(cameras, photos, points, observations, camera)
        roles = _tables.roles(points, fixed, control, check, datum_points, scale_bars)
        return cls(**tables, **roles)

    def without(self, rays: ArrayLike) -> "Network":
        """Return the network without some of its rays, by their indices."""
        kept = np.ones(len(self.xy), bool)
        kept[_arguments.indices(rays, len(self.xy), "rays")] = False
        return replace(self, **_tables.some_rays(self, kept))

    def only(self, photos: ArrayLike) -> "Network":
        """Return the network of some photos, by their indices.

        Points go that these photos leave with too few rays, with what was said of them;
        and cameras that took none of these photos.

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
        chosen[_arguments.indices(photos, m, "photos")] = True
        some = replace(self, **_tables.some_rays(self, chosen[self.photo]))
        return replace(some, **_tables.some_of(some, chosen, ~some.too_few_rays))

    def _set(self, **values: object) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

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
