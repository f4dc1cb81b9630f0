"""The epipolar (normalised) pair: equal rows of both images show the same ground.

Both photos are rotated (virtually) about their projection centres until they look in
the same direction, perpendicular to the base, with x along it: the normal case. Every
epipolar plane then cuts both images in the same row.
"""

from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.epipolar import epipole
from pgm_lab.stereo import slips

MIN_SIDE = 32  # px, of the normal images
SAME_SCALE = 1.05  # ratio of pixel sizes up to which the left photo's is used
EDGE_POINTS = 400  # along each side of a photo, to see what the other one shows
STEP = 4  # px: positions in the photo are exact for every 4th pixel, linear between
BAND = 256  # rows that are resampled at once
SMOOTHED_FROM = 1.2  # photo pixels in a normal pixel from which the photo is smoothed


@dataclass(frozen=True, eq=False)
class NormalPair:
    """Two photos resampled to the normal case.

    Attributes
    ----------
    left, right : ndarray (rows, columns) of float32
        Grey values; NaN where the photo shows nothing.
    rotation : ndarray (3, 3)
        Object space to the frame of the normal images: x along the base, z against the
        view.
    stations : ndarray (2, 3)
        Projection centres in object space.
    c, pixel_size : float
        Principal distance and pixel size of both images, in mm.
    origin : ndarray (2, 2)
        (x, y) in mm of the centre of pixel (0, 0), left and right; the same y.
    photos : tuple of two Photo, or None
        The source photos; None if it was not made from photos.
    within : tuple of str and ndarray (2,), or None
        "heights" or "depths", and the (least, greatest) of them that were given.
    reach : float
        Largest disparity between these limits, to both sides, in pixels; 0 if unknown.
    """

    left: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)
    rotation: np.ndarray
    stations: np.ndarray
    c: float
    pixel_size: float
    origin: np.ndarray
    photos: tuple[Photo, Photo] | None = field(default=None, repr=False)
    within: tuple[str, np.ndarray] | None = None
    reach: float = 0.0

    @property
    def base(self) -> float:
        """Length of the base."""
        return float(np.linalg.norm(self.stations[1] - self.stations[0]))

    @property
    def crs(self) -> str | None:
        """Coordinate reference system, if both photos name the same."""
        named = {photo.crs for photo in self.photos or ()}
        return named.pop() if len(named) == 1 else None

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
        x = self.origin[0, 0] + self.pixel_size * _validate.finite(columns, "columns")
        y = self.origin[0, 1] - self.pixel_size * _validate.finite(rows, "rows")
        _validate.broadcast(columns=x[..., None], rows=y[..., None],
                            disparity=px[..., None])  # fmt: skip
        scale = self.base / np.where(px > 0, px, np.nan)
        model = np.stack(np.broadcast_arrays(scale * x, scale * y, -self.c * scale), -1)
        return self.stations[0] + model @ self.rotation

    def from_photo(self, side: int, pixels: ArrayLike) -> np.ndarray:
        """Pixels (..., 2) in a normal image of pixels (..., 2) in its distorted photo.

        They may lie outside. Side 0 is the left photo, 1 the right one.

        Raises
        ------
        ValueError
            If an argument is not as described here, the pair was not made from photos,
            or a ray runs along the base.
        """
        photo, origin = self._side(side)
        xy = to_normal(photo.rays(pixels), self.rotation, self.c)
        _validate.refuse(
            np.isnan(xy[..., 0]),
            "pixels{} look along the base, or away from the ground",
        )
        return (xy - origin) / (self.pixel_size, -self.pixel_size)

    def to_photo(self, side: int, pixels: ArrayLike) -> np.ndarray:
        """Pixels (..., 2) in a photo from its normal image: undoes `from_photo`.

        Raises
        ------
        ValueError
            If an argument is not as described here, the pair was not made from photos,
            or a pixel lies so far outside that the lens has no solution.
        """
        photo, origin = self._side(side)
        pixels = _validate.points(pixels, 2, "pixels")
        xy = origin + pixels * (self.pixel_size, -self.pixel_size)
        return photo.of_rays(to_rays(xy, self.rotation, self.c))

    def _side(self, side: int) -> tuple[Photo, np.ndarray]:
        side = _validate.whole(side, "side", 0, 1)
        if self.photos is None:
            raise ValueError(
                "this pair was not made from photos: it has no pixels of them"
            )
        return self.photos[side], self.origin[side]


def epipolar_pair(
    left: Photo,
    right: Photo,
    heights: tuple[float, float] | None = None,
    *,
    depths: tuple[float, float] | None = None,
) -> NormalPair:
    """Resample two oriented photos to the normal case, corrected for distortion.

    Parameters
    ----------
    left, right : Photo
        Of any cameras, sizes and kappa; they may be parts. Photos in the opposite
        order give the images rotated by 180 degrees.
    heights : (least, greatest), optional
        Z between which the ground lies, which determines the overlap. Take them from a
        map or from control points, rather too wide than too narrow. Either these or
        depths.
    depths : (least, greatest), optional
        Distances of the object from the stations along the axes of the cameras, for
        photos that do not look down, or with relative orientation only.

    Returns
    -------
    NormalPair
        Of the ground that both show, with the pixel size of the left photo or, where
        the scales differ by more than a twentieth, such that the coarser of the two
        keeps its pixels. The disparity is about zero in the middle of the ground.

    Raises
    ------
    ValueError
        If an argument is not as described here, both photos have the same station, an
        epipole lies inside a photo, the photos look in opposite directions, or show no
        ground in common.

    Notes
    -----
    Positions in the photo are computed exactly for every fourth pixel and linearly
    between (off by less than 0.001 px with usual lenses), grey values by a cubic
    spline, so that nothing is shifted.

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
    along, limits = _limits(heights, depths)
    photos = left, right
    try:
        _refuse_geometry(left, right)
        # What both show
        ground = _common_ground(photos, along, limits)
    except ValueError as error:
        slip = slips.likely(photos, along, limits)
        raise ValueError(f"{error}. {slip}".rstrip(". ")) from None
    stations = np.array([photo.exterior[:3] for photo in photos])
    R, c = normal_frame(left, right), left.camera.c

    # Where the ground that both show lies in the normal images, in mm
    a, b = (to_normal(ground - X0, R, c) for X0 in stations)
    ahead = np.isfinite(a[:, 0] + b[:, 0])
    if not ahead.any():
        raise ValueError(
            "the common part of the photos lies almost along the base: there is no"
            " normal case of them"
        )
    a, b = a[ahead], b[ahead]

    # One frame for both: rows are equal, and the mean parallax is not a disparity
    parallax = a[:, 0] - b[:, 0]
    shift = (parallax.min() + parallax.max()) / 2
    box = np.concatenate([a, b + (shift, 0)])
    (x_min, y_min), (x_max, y_max) = box.min(0), box.max(0)
    pixel, ratios = _scale(photos, ground[ahead], (a, b), R, c)
    size = int((x_max - x_min) / pixel) + 1, int((y_max - y_min) / pixel) + 1
    if min(size) < MIN_SIDE:
        raise ValueError(
            f"the ground that both photos show makes {size[0]} x {size[1]} pixels of a"
            f" normal image (columns x rows); at least {MIN_SIDE} are needed: check the"
            " exterior orientations"
        )
    _validate.size("the normal pair", *size)
    origin = np.array([(x_min, y_max), (x_min - shift, y_max)])

    # Two more than needed at the end, between which the last pixels lie
    steps = [STEP * np.arange((n - 1) // STEP + 2.0) for n in size]

    def image(k: int) -> np.ndarray:
        xy = origin[k] + np.stack(np.meshgrid(*steps), -1) * (pixel, -pixel)
        positions = photos[k].seen_at(to_rays(xy, R, c))
        return _resampled(photos[k].grey, positions, size, ratios[k])

    given = photos, (along, limits), float(np.ptp(parallax) / 2 / pixel)
    return NormalPair(image(0), image(1), R, stations, c, pixel, origin, *given)


# --- The frame of the normal case ---


def normal_frame(left: Photo, right: Photo) -> np.ndarray:
    """Object to normal frame (3, 3): x along the base, z against the mean view."""
    x = right.exterior[:3] - left.exterior[:3]
    x = x / np.linalg.norm(x)
    z = attitude(left.exterior)[2] + attitude(right.exterior)[2]
    z = z - x * (z @ x)
    if np.linalg.norm(z) < 1e-3:
        raise ValueError(
            "the photos look along the base: there is no normal case of them"
        )
    z = z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


def to_rays(xy: np.ndarray, R: np.ndarray, c: float) -> np.ndarray:
    """Directions (..., 3) in object space of positions (..., 2) in the normal frame."""
    return np.concatenate([xy, np.full((*xy.shape[:-1], 1), -c)], -1) @ R


def to_normal(directions: np.ndarray, R: np.ndarray, c: float) -> np.ndarray:
    """Positions (..., 2) in mm in the normal frame; NaN behind it."""
    u = directions @ R.T
    z = np.where(u[..., 2:] < 0, u[..., 2:], np.nan)
    return -c * u[..., :2] / z


# --- What both photos show ---


def _limits(
    heights: tuple[float, float] | None, depths: tuple[float, float] | None
) -> tuple[str, np.ndarray]:
    """Whether heights or depths limit the object, and their (least, greatest)."""
    if (heights is None) == (depths is None):
        raise ValueError(
            "give either heights or depths (least, greatest), between which the ground"
            " lies"
        )
    name = "heights" if depths is None else "depths"
    given: Any = heights if depths is None else depths
    limits = _validate.of_shape(given, (2,), name)
    if limits[0] > limits[1] or (name == "depths" and limits[0] <= 0):
        raise ValueError(
            f"{name} must be (least, greatest)"
            f"{', positive' if name == 'depths' else ''}; got {limits.tolist()}"
        )
    return name, limits


def _refuse_geometry(left: Photo, right: Photo) -> None:
    """Refuse photos of which there is no normal case."""
    for name, one in zip(("left", "right"), epipole(left, right)):
        if one.status == "inside the photo":
            raise ValueError(
                f"the epipole lies inside the {name} photo: it shows the other station,"
                " and all epipolar lines pass through that point. Such a pair has no"
                " normal images; check the exterior orientations, or use parts of the"
                " photos without it"
            )
    if attitude(left.exterior)[2] @ attitude(right.exterior)[2] <= 0:
        raise ValueError(
            "the photos look in directions more than 90 degrees apart, and cannot show"
            " the same side of anything: check the exterior orientations (angles in"
            " radians)"
        )


def _common_ground(
    photos: tuple[Photo, Photo], along: str, limits: np.ndarray
) -> np.ndarray:
    """Object points (n, 3): the part of each photo's edge that the other shows."""
    found = []
    for one, other in (photos, photos[::-1]):
        u = one.rays(one.outline(EDGE_POINTS))
        X0 = one.exterior[:3]
        reach = np.linspace(limits[0], limits[1], 3)[:, None]
        down = u[:, 2] if along == "heights" else np.full(len(u), one.camera.c)
        if along == "heights":
            reach = reach - X0[2]
        t = reach / np.where(down == 0, np.nan, down)
        points = (X0 + t[..., None] * u)[t > 0]
        pixels = other.seen_at(points - other.exterior[:3])
        size = np.array(other.grey.shape[::-1])
        found.append(points[((pixels >= -0.5) & (pixels <= size - 0.5)).all(-1)])
    ground = np.concatenate(found)
    if not len(ground):
        raise ValueError(
            "the photos have no ground in common: check the exterior orientations, the"
            f" {along} {limits.tolist()} and, if the photos are parts, their corners"
        )
    return ground


def _scale(
    photos: tuple[Photo, Photo],
    ground: np.ndarray,
    positions: tuple[np.ndarray, np.ndarray],
    R: np.ndarray,
    c: float,
) -> tuple[float, list[float]]:
    """Pixel size in mm, and pixels of each photo in one of them, at mean height."""
    middle = np.argmin(np.sum((ground - ground.mean(0)) ** 2, axis=1))
    fine = []
    for photo, xy in zip(photos, positions):
        step = photo.pixel_size * np.array([(0.0, 0), (1, 0), (0, 1)])
        at = photo.seen_at(to_rays(xy[middle] + step, R, c))
        area = np.linalg.det(at[1:] - at[0])
        fine.append(np.sqrt(abs(area)) / photo.pixel_size)  # px per mm
    pixel = 1 / min(fine)
    if max(pixel / photos[0].pixel_size, photos[0].pixel_size / pixel) < SAME_SCALE:
        pixel = photos[0].pixel_size
    return float(pixel), [float(pixel * one) for one in fine]


# --- Resampling ---


def _resampled(
    grey: np.ndarray, positions: np.ndarray, size: tuple[int, int], ratio: float
) -> np.ndarray:
    """Image (rows, columns) of float32; NaN where the photo shows nothing."""
    # `positions` are those of every STEP-th pixel in the photo, of which `ratio` pixels
    # go into one of the image. (`image.resample`, in float64 and with exact positions
    # of all pixels, would take seven times the memory.)
    columns, rows = size
    spline, missing = _spline(grey, ratio)
    last = np.array(spline.shape[::-1]) - 1
    image = np.empty((rows, columns), np.float32)
    for first in range(0, rows, BAND):
        band = slice(first, min(first + BAND, rows))
        at = _linear(positions, np.arange(band.start, band.stop), 0)
        at = _linear(at, np.arange(columns), 1)
        # Rounding must not push the outermost pixel out
        out = ~((at >= -1e-6) & (at <= last + 1e-6)).all(-1)
        at[out] = 0
        values = scipy.ndimage.map_coordinates(
            spline, [at[..., 1], at[..., 0]], output=np.float32, order=3,
            mode="mirror", prefilter=False,
        )  # fmt: skip
        if missing is not None:
            x, y = np.moveaxis(at.astype(np.float32), -1, 0)
            out |= cv2.remap(missing, x, y, cv2.INTER_LINEAR) > 0
        values[out] = np.nan
        image[band] = values
    return image


def _linear(values: np.ndarray, n: np.ndarray, axis: int) -> np.ndarray:
    """Values at pixels n along an axis, linear between those of every STEP-th."""
    k, t = n // STEP, n % STEP / STEP
    t = t[:, None, None] if axis == 0 else t[:, None]
    a, b = values.take(k, axis), values.take(k + 1, axis)
    return a + t * (b - a)


def _spline(grey: np.ndarray, ratio: float) -> tuple[np.ndarray, np.ndarray | None]:
    """Coefficients of a cubic spline, and 1 where there are no grey values."""
    values: np.ndarray = np.ma.getdata(grey).astype(np.float32)
    none = ~np.isfinite(values) | np.ma.getmaskarray(grey)
    missing = None
    if none.any():
        if none.all():
            raise ValueError("a photo has no grey values at all")
        missing = none.astype(np.float32)
        # The nearest grey value, so that no spline oscillates at the holes
        nearest = scipy.ndimage.distance_transform_edt(
            none, return_distances=False, return_indices=True
        )
        values = values[tuple(nearest)]
    if ratio > SMOOTHED_FROM:
        values = cv2.GaussianBlur(values, (0, 0), 0.5 * np.sqrt(ratio**2 - 1))
    spline = scipy.ndimage.spline_filter(values, 3, output=np.float32, mode="mirror")
    return spline, missing
