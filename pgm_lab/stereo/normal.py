"""The epipolar (normalised) pair: equal rows of both images show the same ground.

Both photos are turned, in the mind, about their stations until they look alike, at
right angles to the base, with x along it: the normal case. Every epipolar plane then
cuts both images in the same row. `_resampling` fills them with grey values.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.epipolar import epipole
from pgm_lab.stereo._resampling import resampled, seen_at

# Places along each side of a photo where it is asked whether the other one shows them
EDGE = 400

# Pixels of the photo over pixels of the normal image that change nothing worth having
ALIKE = 1.05

# Smallest side of the normal images, in pixels
LEAST = 32


@dataclass(frozen=True, eq=False)
class NormalPair:
    """Two photos resampled to the normal case.

    Attributes
    ----------
    left, right : ndarray (rows, columns) of float32
        Grey values; NaN where the photo shows nothing.
    rotation : ndarray (3, 3)
        Turns object space into the frame of the normal images: x along the base, z
        against the view.
    stations : ndarray (2, 3)
        Projection centres in object space.
    c, pixel_size : float
        Principal distance and pixel size of both images, in mm.
    origin : ndarray (2, 2)
        (x, y) in mm of the middle of pixel (0, 0), left and right; the same y.
    photos : tuple of two Photo, or None
        What it was made of; None if it was not made of photos.
    """

    left: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)
    rotation: np.ndarray
    stations: np.ndarray
    c: float
    pixel_size: float
    origin: np.ndarray
    photos: tuple[Photo, Photo] | None = field(default=None, repr=False)

    @property
    def base(self) -> float:
        """Length of the base."""
        return float(np.linalg.norm(self.stations[1] - self.stations[0]))

    def parallax(self, disparity: ArrayLike) -> np.ndarray:
        """X' - x'' in mm of disparities (left column - right column) in pixels."""
        d = _validate.real(disparity, "disparity")
        return self.origin[0, 0] - self.origin[1, 0] + self.pixel_size * d

    def object_points(
        self, columns: ArrayLike, rows: ArrayLike, disparity: ArrayLike
    ) -> np.ndarray:
        """Object points (..., 3) of left pixels and their disparities.

        NaN where the disparity is NaN, or the rays do not meet in front of the photos.
        """
        px = self.parallax(disparity)
        x = self.origin[0, 0] + self.pixel_size * _validate.real(columns, "columns")
        y = self.origin[0, 1] - self.pixel_size * _validate.real(rows, "rows")
        _validate.broadcast(columns=x[..., None], rows=y[..., None],
                            disparity=px[..., None])  # fmt: skip
        scale = self.base / np.where(px > 0, px, np.nan)
        model = np.stack(np.broadcast_arrays(scale * x, scale * y, -self.c * scale), -1)
        return self.stations[0] + model @ self.rotation

    def from_photo(self, side: int, pixels: ArrayLike) -> np.ndarray:
        """Where pixels of a photo lie in its normal image.

        Parameters
        ----------
        side : {0, 1}
            0 for the left, 1 for the right photo.
        pixels : array_like (..., 2)
            (column, row) in the photo, with lens.

        Returns
        -------
        ndarray (..., 2)
            (column, row) in the normal image; they may lie outside.

        Raises
        ------
        ValueError
            If an argument is not what is described here, the pair was not made of
            photos, or a ray runs along the base.
        """
        photo, origin = self._side(side)
        xy = normal_places(photo.rays(pixels), self.rotation, self.c)
        _validate.refuse(
            np.isnan(xy[..., 0]),
            "pixels{} look along the base, or away from the ground",
        )
        return (xy - origin) / (self.pixel_size, -self.pixel_size)

    def to_photo(self, side: int, pixels: ArrayLike) -> np.ndarray:
        """Where pixels of a normal image lie in its photo: the inverse of `from_photo`.

        Parameters
        ----------
        side : {0, 1}
            0 for the left, 1 for the right photo.
        pixels : array_like (..., 2)
            (column, row) in the normal image.

        Returns
        -------
        ndarray (..., 2)
            (column, row) in the photo, with lens; they may lie outside.

        Raises
        ------
        ValueError
            If an argument is not what is described here, the pair was not made of
            photos, or a pixel lies so far outside that the lens has no solution.
        """
        photo, origin = self._side(side)
        xy = origin + _validate.points(pixels, 2, "pixels") * (
            self.pixel_size,
            -self.pixel_size,
        )
        return photo.of_rays(_rays(xy, self.rotation, self.c))

    def _side(self, side: int) -> tuple[Photo, np.ndarray]:
        side = _validate.whole(side, "side", 0, 1)
        if self.photos is None:
            raise ValueError(
                "this pair was not made of photos: it has no pixels of them"
            )
        return self.photos[side], self.origin[side]


def epipolar_pair(
    left: Photo,
    right: Photo,
    heights: tuple[float, float] | None = None,
    *,
    depths: tuple[float, float] | None = None,
) -> NormalPair:
    """Resample two oriented photos to the normal case, freed from lens distortion.

    Parameters
    ----------
    left, right : Photo
        Of whatever cameras, sizes and kappa; they may be parts. Photos in the opposite
        order give the images turned by 180 degrees.
    heights : (least, greatest), optional
        Z between which the ground lies; it says what both photos show. Give it from a
        map or from control points, a little too wide rather than too narrow. Either
        these or depths.
    depths : (least, greatest), optional
        Distances of the object from the stations along the axes of the cameras, for
        photos that do not look down, or with relative orientation only.

    Returns
    -------
    NormalPair
        Of the ground that both show, with the pixel size of the left photo or, where
        the scales differ by more than a twentieth, such that the coarser of both keeps
        its pixels. The disparity is about zero in the middle of the ground.

    Raises
    ------
    ValueError
        If an argument is not what is described here, both photos stand at the same
        place, an epipole lies inside a photo, the photos look in opposite directions,
        or show no ground in common.

    Notes
    -----
    Places in the photo are computed exactly for every fourth pixel and linearly between
    (off by less than 0.001 px with the lens of `simulate`), grey values by a
    cubic spline, so that nothing is moved. In bands of rows: a pair of 24 megapixels
    takes some 0.6 GB.

    References
    ----------
    Bani 2010, II.1.2.1 (normalisation); Kraus 2007, "Photogrammetry", 2nd ed., 6.8.5.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> scene = simulate.aerial_pair(part=(120, 90), sigma=0)
    >>> pair = epipolar_pair(scene.left, scene.right, (0, 40))
    >>> point = scene.ground[0][45, 60]
    >>> one, other = (
    ...     pair.from_photo(side, photo.project(point))
    ...     for side, photo in enumerate((scene.left, scene.right))
    ... )
    >>> bool(abs(one[1] - other[1]) < 1e-6)  # no y parallax
    True
    """
    for name, photo in (("left", left), ("right", right)):
        _validate.instance(photo, Photo, name)
    along, between = _range(heights, depths)
    photos = left, right
    _refuse_epipoles(left, right)
    stations = np.array([photo.exterior[:3] for photo in photos])
    R = rotation(left, right)
    c = left.camera.c
    ground = _ground(photos, along, between)
    # Where the ground that both show lies in the normal images, in mm
    a, b = (normal_places(ground - X0, R, c) for X0 in stations)
    ahead = np.isfinite(a[:, 0] + b[:, 0])
    if not ahead.any():
        raise ValueError(
            "the photos see what they have in common almost along the base: there is no"
            " normal case of it"
        )
    a, b = a[ahead], b[ahead]
    parallax = a[:, 0] - b[:, 0]
    shift = (parallax.min() + parallax.max()) / 2
    box = np.concatenate([a, b + (shift, 0)])
    (least, low), (most, high) = box.min(0), box.max(0)
    pixel, ratios = _pixel_size(photos, ground[ahead], (a, b), R, c)
    size = int((most - least) / pixel) + 1, int((high - low) / pixel) + 1
    if min(size) < LEAST:
        raise ValueError(
            f"the ground that both photos show makes {size[0]} x {size[1]} pixels of a"
            f" normal image (columns x rows); at least {LEAST} are needed: check the"
            " exterior orientations"
        )
    _validate.size("the normal pair", *size)
    origin = np.array([(least, high), (least - shift, high)])

    def image(k: int) -> np.ndarray:
        def xy_of(columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
            x, y = origin[k, 0] + pixel * columns, origin[k, 1] - pixel * rows
            return _rays(np.stack(np.meshgrid(x, y), -1), R, c)

        return resampled(photos[k], xy_of, size, ratios[k])

    return NormalPair(image(0), image(1), R, stations, c, pixel, origin, photos)


def _range(
    heights: tuple[float, float] | None, depths: tuple[float, float] | None
) -> tuple[str, np.ndarray]:
    """What says where the object lies, and between what."""
    if heights is not None and depths is None:
        name, between = "heights", _validate.of_shape(heights, (2,), "heights")
    elif depths is not None and heights is None:
        name, between = "depths", _validate.of_shape(depths, (2,), "depths")
    else:
        raise ValueError(
            "either heights or depths (least, greatest) say what both photos show; give"
            " one"
        )
    if between[0] > between[1] or (name == "depths" and between[0] <= 0):
        raise ValueError(
            f"{name} must be (least, greatest)"
            f"{', positive' if name == 'depths' else ''}; got {between.tolist()}"
        )
    return name, between


def _refuse_epipoles(left: Photo, right: Photo) -> None:
    for name, one in zip(("left", "right"), epipole(left, right)):
        if one.status == "inside the photo":
            raise ValueError(
                f"the epipole lies inside the {name} photo: it shows the other station,"
                " and all epipolar lines pass through that point. Such a pair has no"
                " normal images; check the exterior orientations, or use parts of the"
                " photos without it"
            )
    axes = [attitude(photo.exterior)[2] for photo in (left, right)]
    if axes[0] @ axes[1] <= 0:
        raise ValueError(
            "the photos look in directions more than 90 degrees apart, and cannot show"
            " the same side of anything: check the exterior orientations (angles in"
            " radians)"
        )


def rotation(left: Photo, right: Photo) -> np.ndarray:
    """Object to normal frame (3, 3): x along the base, z against the mean view."""
    x = right.exterior[:3] - left.exterior[:3]
    x = x / np.linalg.norm(x)
    z = attitude(left.exterior)[2] + attitude(right.exterior)[2]
    z = z - x * (z @ x)
    if np.linalg.norm(z) < 1e-3:
        raise ValueError(
            "the photos look along the base: there is no normal case of it"
        )
    z = z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


def _rays(xy: np.ndarray, R: np.ndarray, c: float) -> np.ndarray:
    """Directions (..., 3) in object space of places (..., 2) in the normal frame."""
    return np.concatenate([xy, np.full((*xy.shape[:-1], 1), -c)], -1) @ R


def normal_places(directions: np.ndarray, R: np.ndarray, c: float) -> np.ndarray:
    """Places (..., 2) in mm in the normal frame; NaN where it does not see them."""
    u = directions @ R.T
    z = np.where(u[..., 2:] < 0, u[..., 2:], np.nan)
    return -c * u[..., :2] / z


def _ground(photos: tuple[Photo, Photo], along: str, between: np.ndarray) -> np.ndarray:
    """Object points (n, 3) around the ground that both photos show; there must be."""
    ground = _common(photos, along, between)
    if len(ground):
        return ground
    left, right = photos
    exchanged = (
        replace(left, exterior=right.exterior),
        replace(right, exterior=left.exterior),
    )
    hint = "; with their exterior orientations exchanged they would have some"
    raise ValueError(
        "the photos have no ground in common: check the exterior orientations, the"
        f" {along} {between.tolist()} and, if the photos are parts, their corners"
        + hint
        * bool(len(_common(exchanged, along, between)))
    )


def _common(photos: tuple[Photo, Photo], along: str, between: np.ndarray) -> np.ndarray:
    """Object points (n, 3) around the ground that both photos show.

    Its edge is part of the edges of both photos: of each the part that the other shows.
    """
    found = []
    for one, other in (photos, photos[::-1]):
        u = one.rays(one.outline(EDGE))
        X0 = one.exterior[:3]
        reach = np.linspace(between[0], between[1], 3)[:, None]
        down = u[:, 2] if along == "heights" else np.full(len(u), one.camera.c)
        if along == "heights":
            reach = reach - X0[2]
        t = reach / np.where(down == 0, np.nan, down)
        meets = t > 0
        points = (X0 + t[..., None] * u)[meets]
        pixels = seen_at(other, points - other.exterior[:3])
        size = np.array(other.grey.shape[::-1])
        found.append(points[((pixels >= -0.5) & (pixels <= size - 0.5)).all(-1)])
    return np.concatenate(found)


def _pixel_size(
    photos: tuple[Photo, Photo],
    ground: np.ndarray,
    places: tuple[np.ndarray, np.ndarray],
    R: np.ndarray,
    c: float,
) -> tuple[float, list[float]]:
    """Pixel size in mm, and pixels of each photo in one of them, in mid-ground."""
    middle = np.argmin(np.sum((ground - ground.mean(0)) ** 2, axis=1))
    fine = []
    for photo, xy in zip(photos, places):
        step = photo.pixel_size * np.array([(0.0, 0), (1, 0), (0, 1)])
        at = seen_at(photo, _rays(xy[middle] + step, R, c))
        area = np.linalg.det(at[1:] - at[0])
        fine.append(np.sqrt(abs(area)) / photo.pixel_size)  # px per mm
    pixel = 1 / min(fine)
    if max(pixel / photos[0].pixel_size, photos[0].pixel_size / pixel) < ALIKE:
        pixel = photos[0].pixel_size
    return float(pixel), [float(pixel * one) for one in fine]
