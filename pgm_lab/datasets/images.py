"""Real images: an aerial orthophoto, satellite scenes, a stereo pair with its truth."""

from dataclasses import dataclass, field

import cv2
import numpy as np
import skimage.data
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.datasets.files import verified
from pgm_lab.io.photo import GREY_OF_RGB


@dataclass(frozen=True)
class Orthophoto:
    """A grey orthophoto.

    Attributes
    ----------
    grey : ndarray (rows, columns)
        Grey values as stored.
    gsd : float
        Ground sampling distance; m.
    """

    grey: np.ndarray = field(repr=False)
    gsd: float


@dataclass(frozen=True)
class StereoPair:
    """Two rectified images, with the truth that was measured by other means.

    A point at (column x, row y) of the left image lies at (x - d, y) of the right one,
    d being the disparity at (x, y). Its distance in front of the cameras is
    focal_length * baseline / (d + doffs).

    Attributes
    ----------
    left, right : ndarray (rows, columns)
        Grey values, float64.
    disparity : ndarray (rows, columns)
        Disparity d of every pixel of the left image; px. NaN where it is unknown:
        ``np.isfinite(disparity)`` is the mask of the known ones. Known does not mean
        seen: the right image may hide the point, or end before it.
    focal_length : float
        In px.
    baseline : float
        Distance of the two perspective centres; mm.
    doffs : float
        Principal point of the right image less that of the left one, in x; px.
    """

    left: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)
    disparity: np.ndarray = field(repr=False)
    focal_length: float
    baseline: float
    doffs: float

    def known(
        self, columns: ArrayLike, rows: ArrayLike
    ) -> tuple[np.ndarray, np.ndarray]:
        """Points of a grid in the left image whose disparity is known.

        Parameters
        ----------
        columns, rows : array_like of int
            Where the lines of the grid lie, such as ``range(80, 720, 20)``.

        Returns
        -------
        points : ndarray (n, 2) of int
            (column, row), row by row.
        disparity : ndarray (n,)
            In px: a point lies so much farther left in the right image.

        Raises
        ------
        ValueError
            If a column or row is no index of the image.

        Examples
        --------
        >>> points, disparity = motorcycle().known(range(80, 720, 20), [318])
        >>> print(points[10], disparity[10].round(1))
        [300 318] 46.2
        """
        size = self.disparity.shape
        at = _validate.indices(columns, size[1], "columns")
        x, y = np.meshgrid(at, _validate.indices(rows, size[0], "rows"))
        kept = np.isfinite(self.disparity[y, x])
        return np.column_stack([x[kept], y[kept]]), self.disparity[y, x][kept]


def yellowstone() -> Orthophoto:
    """Load a real aerial orthophoto, 1536 x 1536, 8 bit, 0.1 m (NEON, Yellowstone).

    Examples
    --------
    >>> yellowstone().grey.shape
    (1536, 1536)
    """
    return Orthophoto(_grey("neon_yellowstone_ortho_10cm_gray.png"), gsd=0.1)


def landsat() -> Orthophoto:
    """Load a satellite image of Itaipu, 1200 x 1200, 16 bit, 30 m (Landsat 8, red).

    City, fields, forest and water at Ciudad del Este, 18 May 2020.

    Examples
    --------
    >>> landsat().grey.shape, landsat().grey.dtype
    ((1200, 1200), dtype('uint16'))
    """
    return Orthophoto(_grey("landsat8_itaipu_red_30m.png"), gsd=30.0)


def landsat_pair() -> tuple[Orthophoto, Orthophoto]:
    """Load the same ground, 600 x 1000, from two scenes of one pass of Landsat 8.

    The ground was seen once; then the scenes of rows 077 and 078 were processed and
    resampled each by itself. A correct registration finds no shift, which makes the
    pair a test for false ones.

    Examples
    --------
    >>> one, other = landsat_pair()
    >>> one.grey.shape == other.grey.shape == (600, 1000)
    True
    """
    name = "landsat8_itaipu_red_30m_row{}.png".format
    return Orthophoto(_grey(name("077")), 30.0), Orthophoto(_grey(name("078")), 30.0)


def motorcycle() -> StereoPair:
    """Load the stereo pair 'Motorcycle', 500 x 741, with its true disparities.

    Part of the Middlebury stereo benchmark of 2014, reduced to a quarter; it comes with
    scikit-image, so that no network is needed. Grey is 0.299 R + 0.587 G + 0.114 B
    (Rec. 601), from 0 to 255, not rounded. The disparities were measured with
    structured light. At the edges of objects the reduction has mixed near and far.

    Returns
    -------
    StereoPair

    Raises
    ------
    FileNotFoundError
        If the files are missing from scikit-image, or damaged.

    Notes
    -----
    How far can the truth be trusted? Least squares matching along the rows, in windows
    of 11 x 11 with a clear texture and disparities within 1 px, differs from it by
    -0.08 px in the median, with a standard deviation of 0.08 px: it can judge a matcher
    to a tenth of a pixel, not to a hundredth.

    References
    ----------
    D. Scharstein, H. Hirschmüller, Y. Kitajima, G. Krathwohl, N. Nešić, X. Wang and
    P. Westling (2014), High-resolution stereo datasets with subpixel-accurate ground
    truth, German Conference on Pattern Recognition. The calibration is the one in the
    documentation of ``skimage.data.stereo_motorcycle``.

    Examples
    --------
    >>> pair = motorcycle()
    >>> pair.left.shape == pair.right.shape == pair.disparity.shape == (500, 741)
    True
    >>> near = np.nanmax(pair.disparity)
    >>> print(f"{1e-3 * pair.focal_length * pair.baseline / (near + pair.doffs):.2f} m")
    2.11 m
    """
    try:
        left, right, disparity = skimage.data.stereo_motorcycle()
    except (OSError, ImportError) as error:
        raise FileNotFoundError(
            "the stereo pair 'motorcycle' that comes with scikit-image is missing or"
            " damaged. Restore it with pip install --force-reinstall --no-deps"
            " scikit-image"
        ) from error
    disparity = disparity.astype(float)
    disparity[~np.isfinite(disparity)] = np.nan
    return StereoPair(
        left @ np.array(GREY_OF_RGB),
        right @ np.array(GREY_OF_RGB),
        disparity,
        focal_length=994.978,
        baseline=193.001,
        doffs=31.086,
    )


def _grey(name: str) -> np.ndarray:
    """Grey values of an image in ``data/``, in its own number of bits."""
    # imdecode, since imread cannot open paths with accents on Windows
    coded = np.frombuffer(verified(name).read_bytes(), dtype=np.uint8)
    return np.asarray(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED))
