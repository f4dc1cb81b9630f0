"""From a board and two photos to a surface, as lesson 9 writes it: to be read.

`pgm_lab.bundle`, `pgm_lab.orientation` and `pgm_lab.stereo` do the same for any
network, and say what went wrong.
"""

import numpy as np
from scipy.ndimage import map_coordinates

from pgm_book.program.adjustment import adjust
from pgm_book.program.bundle import without_lens
from pgm_book.program.camera import derivatives, project
from pgm_book.program.orientation import intersection, resection
from pgm_book.program.stereo import best_disparity, model_point, sigma_height
from pgm_lab import frames, rotation

STEPS = 4  # Gauss-Newton steps, enough from `photos.Board.start`
LEAST = 0.8  # of r
WINDOW = 9  # px


def flat_board(
    xy: np.ndarray, camera: np.ndarray, exteriors: np.ndarray, grid: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Camera from photos of a board whose points are taken for known.

    Parameters
    ----------
    xy : array_like (m, n, 2)
        Measured image points of each photo, mm; NaN where one was not seen.
    camera, exteriors : array_like (10,), (m, 6)
        Start values.
    grid : array_like (n, 3)
        The points of the board as it was printed.

    Returns
    -------
    camera : ndarray (10,)
        Adjusted.
    C : ndarray (10, 10)
        Its covariance.
    sigma0 : float
        Standard deviation of an image coordinate, mm.
    """
    xy = np.asarray(xy, float)

    def misclosures(unknowns: np.ndarray) -> np.ndarray:
        camera, photos = unknowns[:10], unknowns[10:].reshape(-1, 6)
        computed = [project(photo, grid, camera[0]) for photo in photos]
        observed = without_lens(xy.reshape(-1, 2), camera)
        return np.nan_to_num(np.ravel(computed) - observed.ravel())

    unknowns = np.concatenate([camera, np.ravel(exteriors)])
    for _ in range(STEPS):
        A = derivatives(misclosures, unknowns)
        x, _, sigma0, Q = adjust(A, np.ones(len(A)), -misclosures(unknowns))
        unknowns = unknowns + x
    return unknowns[:10], sigma0**2 * Q[:10, :10], float(sigma0)


def new_photo(
    xy: np.ndarray, camera: np.ndarray, board: np.ndarray, start: np.ndarray
) -> float:
    """How well a camera and a board predict a photo that took no part in either.

    Parameters
    ----------
    xy : array_like (n, 2)
        Image points of the new photo, mm.
    camera : array_like (10,)
    board : array_like (n, 3)
        Points of the board.
    start : array_like (6,)
        Approximate exterior orientation of the new photo.

    Returns
    -------
    float
        Root mean square of what its resection leaves in x and y, mm.
    """
    ideal = without_lens(xy, camera)
    exterior, _ = resection(start, ideal, board, camera[0])
    left = project(exterior, board, camera[0]) - ideal
    return float(np.sqrt(np.mean(left**2)))


def frame(exterior: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotations into the right photo and into the normal case.

    Parameters
    ----------
    exterior : array_like (6,)
        Of the right photo, by relative orientation: the left one stands at the origin
        and is not rotated.

    Returns
    -------
    M, N : ndarray (3, 3)

    Examples
    --------
    >>> M, N = frame([1, 0, 0, 0, 0, 0])
    >>> print(N + 0.0)
    [[1. 0. 0.]
     [0. 1. 0.]
     [0. 0. 1.]]
    """
    base, M = np.asarray(exterior[:3], float), rotation.matrix(*exterior[3:])
    across = np.cross(M[2] + (0, 0, 1), base)
    axes = (base, across, np.cross(base, across))
    return M, np.array([axis / np.linalg.norm(axis) for axis in axes])


def y_parallaxes(
    exterior: np.ndarray, left: np.ndarray, right: np.ndarray, c: float
) -> np.ndarray:
    """What is left in y when both photos are rotated into the normal case.

    Parameters
    ----------
    exterior : array_like (6,)
        As for `frame`.
    left, right : array_like (n, 2)
        Photo coordinates of the same points, mm.
    c : float
        Principal distance, mm.

    Returns
    -------
    ndarray (n,)
        y' - y'' in mm.
    """
    M, N = frame(exterior)
    first, second = (np.insert(np.asarray(p, float), 2, -c, 1) for p in (left, right))
    first, second = first @ N.T, second @ M @ N.T
    return -c * (first[:, 1] / first[:, 2] - second[:, 1] / second[:, 2])


def base_length(
    exterior: np.ndarray, left: np.ndarray, right: np.ndarray, c: float, distance: float
) -> float:
    """Distance of the two perspective centres, from one distance in the scene.

    Parameters
    ----------
    exterior, c
        As for `y_parallaxes`.
    left, right : array_like (2, 2)
        Photo coordinates of both ends of the distance, mm.
    distance : float
        In m.

    Returns
    -------
    float
        In m.
    """
    M, base = rotation.matrix(*exterior[3:]), np.asarray(exterior[:3], float)
    ends = [
        intersection(
            np.array([np.zeros(3), base]),
            np.array([np.append(p, -c), np.append(q, -c) @ M]),
        )
        for p, q in zip(left, right)
    ]
    unit = distance / np.linalg.norm(ends[1] - ends[0])
    return float(unit * np.linalg.norm(base))


def normal_case(
    image: np.ndarray, M: np.ndarray, N: np.ndarray, c: float, pixel_size: float
) -> np.ndarray:
    """Photo as a camera rotated by N would have taken it from the same place.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values of a photo that was rotated by M.
    M, N : array_like (3, 3)
        From object space into the photo and into the normal case.
    c, pixel_size : float
        Principal distance and size of a pixel, mm; the same in both.

    Returns
    -------
    ndarray (rows, columns)
        Grey values, 0 where the photo has none.
    """
    image = np.asarray(image)
    rows, columns = image.shape
    pixels = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1)
    xy = frames.pixel_to_photo(pixels.reshape(-1, 2), (columns, rows), pixel_size)
    U, V, W = np.insert(xy, 2, -c, 1).T.copy()
    U, V, W = np.asarray(M) @ np.asarray(N).T @ (U, V, W)
    there = np.column_stack([-c * U / W, -c * V / W])
    column, row = frames.photo_to_pixel(there, (columns, rows), pixel_size).T
    return map_coordinates(image, [row, column], order=1).reshape(image.shape)


def surface_point(
    pair: tuple[np.ndarray, np.ndarray],
    column: int,
    row: int,
    span: tuple[int, int],
    base: float,
    c: float,
    pixel_size: float,
    sigma_px: float,
) -> np.ndarray:
    """Point of the surface behind a pixel of the left normal image.

    Parameters
    ----------
    pair : two arrays (rows, columns)
        Left and right image in the normal case.
    column, row : int
        Of the left pixel.
    span : (int, int)
        Smallest and largest disparity that is tried, px.
    base, c, pixel_size : float
        m, mm, mm.
    sigma_px : float
        Standard deviation of a disparity, px.

    Returns
    -------
    ndarray (4,)
        X, Y, Z and the standard deviation of Z in m, as the left camera sees them; NaN
        where r is below 0.8, or the best disparity lies at the end of the search.
    """
    d, r = best_disparity(*pair, column, row, WINDOW, *span)
    if not (r >= LEAST and np.isfinite(d)):
        return np.full(4, np.nan)
    size = np.shape(pair[0])[::-1]
    ((x, y),) = frames.pixel_to_photo([(column, row)], size, pixel_size)
    point = model_point(x, y, pixel_size * d, base, c)
    gsd = -point[2] / c * pixel_size
    return np.append(point, sigma_height(-point[2], base, gsd, sigma_px))
