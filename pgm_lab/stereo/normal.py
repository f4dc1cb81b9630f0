"""The epipolar (normalised) pair: equal rows of both images show the same ground.

Both photos are turned, in the mind, about their stations until they look alike, at
right angles to the base, with x along it: the normal case. Every epipolar plane then
cuts both images in the same row. `_resampling` fills them with grey values.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera.photo import Photo
from pgm_lab.stereo import _common
from pgm_lab.stereo._frame import normal_places, rays, rotation
from pgm_lab.stereo._resampling import resampled

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
        x = self.origin[0, 0] + self.pixel_size * _validate.finite(columns, "columns")
        y = self.origin[0, 1] - self.pixel_size * _validate.finite(rows, "rows")
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
        return photo.of_rays(rays(xy, self.rotation, self.c))

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
    along, between = _common.between(heights, depths)
    photos = left, right
    _common.refuse_epipoles(left, right)
    stations = np.array([photo.exterior[:3] for photo in photos])
    R = rotation(left, right)
    c = left.camera.c
    ground = _common.ground_of(photos, along, between)
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
    pixel, ratios = _common.scale(photos, ground[ahead], (a, b), R, c)
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
            return rays(np.stack(np.meshgrid(x, y), -1), R, c)

        return resampled(photos[k], xy_of, size, ratios[k])

    return NormalPair(image(0), image(1), R, stations, c, pixel, origin, photos)
