"""Photos of a board with an exactly known camera, also of a board that is bent."""

from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np
import scipy

from pgm_lab import camera as cameras
from pgm_lab import frames, rotation
from pgm_lab.calibration.board import Board, draw
from pgm_lab.camera import Camera, imaging

Shape = Callable[[np.ndarray, np.ndarray], np.ndarray] | np.ndarray

STEP = 8  # pixels between the nodes at which rays meet the board
SAMPLES = 4  # rays a pixel, across and down
LARGEST = 5e7  # pixels of the drawn board
BLACK, WHITE = 30.0, 220.0  # grey values of ink and paper
AROUND = 89  # of what lies around the paper, where ink is 0 and paper 255


class BoardPhoto(NamedTuple):
    """A photo of a board, and what is true about it."""

    grey: np.ndarray  # (rows, columns) uint8
    pixels: np.ndarray  # (n, 2) true column and row of all points, also outside
    points: np.ndarray  # (n, 3) the board's points as they are bent, in mm
    inside: np.ndarray  # (n,) whether the photo shows the point


def view(
    board: Board, distance: float, tilt: float, azimuth: float, roll: float = 0.0
) -> np.ndarray:
    """Exterior orientation (6,) of a camera that looks at the middle of a board.

    From a distance in mm, tilted by an angle from the board's normal towards an azimuth
    counted from X to Y, rolled about its axis; angles in degrees.

    Examples
    --------
    >>> view(Board("charuco", 13, 9, 20.0), 500.0, 0.0, 0.0)
    array([110.,  70., 500.,   0.,   0.,   0.])
    """
    t, a, r = np.radians((tilt, azimuth, roll))
    axis = np.array([np.sin(t) * np.cos(a), np.sin(t) * np.sin(a), np.cos(t)])
    up = np.cross(axis, (1.0, 0, 0))  # the image's y axis before it is rolled
    up = up / np.linalg.norm(up)
    right = np.cross(up, axis)
    M = [np.cos(r) * right + np.sin(r) * up, np.cos(r) * up - np.sin(r) * right, axis]
    low, high = board.points.min(0), board.points.max(0)
    centre = (low + high) / 2 + distance * axis
    return np.concatenate([centre, rotation.angles(np.array(M))]) + 0.0  # no -0


def photograph(
    board: Board,
    camera: Camera,
    exterior: np.ndarray,
    image_size: tuple[int, int],
    pixel_size: float,
    *,
    shape: Shape | None = None,
    noise: float = 0.0,
    blur: float = 0.7,
    light: float = 0.0,
    quality: int | None = None,
    rng: np.random.Generator | None = None,
) -> BoardPhoto:
    """Photograph a board: each pixel is the mean of 16 rays that meet its surface.

    Parameters
    ----------
    board : Board
    camera : Camera
    exterior : array_like (6,)
        In the board's frame and mm: see `view`.
    image_size : (int, int)
        Columns and rows.
    pixel_size : float
        In mm.
    shape : function or ndarray (n, 3), optional
        The board is bent: Z = shape(X, Y) in mm; or where its points really lie, with a
        thin plate between them. Flat when missing.
    noise : float
        Standard deviation of the grey values.
    blur : float
        Standard deviation of a Gaussian in pixels, on top of the pixel's own area.
    light : float
        How much brighter the right edge is than the left one, as a part of the mean.
    quality : int, optional
        Saved as JPEG of this quality, and read again.
    rng : numpy.random.Generator, optional
        Needed for noise.

    Returns
    -------
    BoardPhoto

    Examples
    --------
    >>> board = Board("charuco", 13, 9, 20.0)
    >>> seen = photograph(board, Camera(3.6), view(board, 500, 30, 0), (400, 300), 0.01)
    >>> print(seen.grey.shape, seen.inside.all())
    (300, 400) True
    """
    exterior = np.asarray(exterior, float)
    bend = _bending(board, shape)
    points = board.points + bend(board.points[:, :2])
    pixels = frames.photo_to_pixel(
        cameras.project(camera, exterior, points), image_size, pixel_size
    )
    columns, rows = image_size
    inside = np.all((pixels >= 0) & (pixels <= (columns - 1, rows - 1)), axis=1)

    # The board as drawn, four of its pixels in one of the photo where it is nearest
    in_photo = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    nearest = np.max(in_photo / np.linalg.norm(np.diff(points, axis=0), axis=1))
    scale = min(SAMPLES * float(nearest), float(LARGEST / np.prod(board.size)) ** 0.5)
    paper = int(scale * 8)
    drawn = np.pad(draw(board, 25.4 * scale), paper, constant_values=255)
    origin = np.array([board.margin, board.size[1] - board.margin]) * scale
    left, top = origin + paper - 0.5

    on_board = _mapping(board, camera, exterior, image_size, pixel_size, bend)
    grey: Any = np.empty((rows, columns), np.float32)
    for first in range(0, rows, 200):
        count = min(200, rows - first)
        # One pixel more around, between which the rays of a pixel are interpolated
        x, y = on_board(
            np.arange(-1, columns + 1), np.arange(first - 1, first + count + 1)
        )
        size = (SAMPLES * (columns + 2), SAMPLES * (count + 2))
        x, y = (
            cv2.resize(one.astype(np.float32), size)[SAMPLES:-SAMPLES, SAMPLES:-SAMPLES]
            for one in (left + scale * x, top - scale * y)
        )
        seen: Any = cv2.remap(drawn, x, y, cv2.INTER_LINEAR, borderValue=AROUND)
        part = seen.astype(np.float32).reshape(count, SAMPLES, columns, SAMPLES)
        grey[first : first + count] = part.mean(axis=(1, 3))

    grey = BLACK + (WHITE - BLACK) * grey / 255
    if blur:
        grey = cv2.GaussianBlur(grey, (0, 0), blur)
    grey = grey * (1 + light * (np.arange(columns) / columns - 0.5))
    if noise:
        assert rng is not None, "noise needs rng"
        grey = grey + noise * rng.normal(size=grey.shape)
    image: Any = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
    if quality is not None:
        file = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        image = cv2.imdecode(file, cv2.IMREAD_GRAYSCALE)
    return BoardPhoto(image, pixels, points, inside)


def _bending(board: Board, shape: Shape | None) -> Callable[[np.ndarray], np.ndarray]:
    """Return the displacement (..., 3) of points (..., 2) of the flat board."""
    if shape is None:
        return lambda xy: np.zeros((*xy.shape[:-1], 3))
    if callable(shape):
        return lambda xy: np.concatenate(
            [0 * xy, shape(xy[..., 0], xy[..., 1])[..., None]], -1
        )
    flat = board.points
    plate = scipy.interpolate.RBFInterpolator(
        flat[:, :2], np.asarray(shape) - flat, degree=1
    )
    return lambda xy: plate(xy.reshape(-1, 2)).reshape(*xy.shape[:-1], 3)


def _mapping(
    board: Board,
    camera: Camera,
    exterior: np.ndarray,
    image_size: tuple[int, int],
    pixel_size: float,
    bend: Callable[[np.ndarray], np.ndarray],
) -> Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, ...]]:
    """Return what maps columns and rows of the photo to x and y (rows, columns).

    In mm on the flat board: the point that, bent, lies on the ray of the pixel.
    """
    # All changes slowly: computed at nodes, and splines between these
    x, y = (np.arange(-2 * STEP, n + 2 * STEP + 1, STEP) for n in image_size)
    nodes = np.stack(np.meshgrid(x, y), -1).astype(float)
    photo = frames.pixel_to_photo(nodes, image_size, pixel_size, check_size=False)
    xy = cameras.ideal(camera, photo)
    ray = np.dstack([xy, np.full(xy.shape[:2], -camera.c)]) @ imaging.attitude(exterior)
    down = ray[..., :2] / np.minimum(ray[..., 2:], -1e-9)  # level: far away
    low, high = board.points[:, :2].min(0), board.points[:, :2].max(0)
    on_board, low, high = 0 * xy, low - 2 * board.margin, high + 2 * board.margin
    for _ in range(20):  # the slope of the bending times that of the ray is small
        moved = bend(on_board)
        met = exterior[:2] + down * (moved[..., 2:] - exterior[2]) - moved[..., :2]
        on_board, before = np.clip(met, low, high), on_board
        if np.abs(on_board - before).max() < 1e-7:
            break
    met = np.clip(met, 2 * low - high, 2 * high - low)  # nothing to see farther away
    splines = [scipy.interpolate.RectBivariateSpline(y, x, met[..., i]) for i in (0, 1)]
    return lambda columns, rows: tuple(spline(rows, columns) for spline in splines)
