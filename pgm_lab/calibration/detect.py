"""Where a photo shows the points of a board, to about a pixel: by OpenCV's detectors.

A board that is partly hidden is found if its parts are coded (charuco, apriltags); all
points of the other kinds must be seen. Which end of a plain board is its top follows
from its pattern where it can: see `Board.symmetric`. Where it can't, the end that lies
higher in the photo is taken, or the left one if the board is turned by 90 degrees.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import numpy as np

from pgm_lab import _validate
from pgm_lab.calibration.board import Board, markers

LEAST = 6  # points: a homography takes four, and nothing would check them
# Pixels along the longer side to which a photo is reduced: first, and if that shows no
# board, or one whose points lie fewer than CLOSE pixels apart
CODED_SIDES, PLAIN_SIDES, CLOSE = (1600, 4000), (1200, 2400), 35
REASON_SIDE = 800  # enough to see what else the photo shows
BEND = 0.35  # of a step: how far a point may lie off the middle of its neighbours
# One for each family of markers that another board may have
OTHERS = (
    "DICT_4X4_250",
    "DICT_5X5_250",
    "DICT_6X6_250",
    "DICT_7X7_250",
    "DICT_APRILTAG_36h11",
)
MANY = 6  # markers that chance does not find


class Detected(NamedTuple):
    """Points of a board in a photo, or the reason why there are none."""

    ids: np.ndarray  # (k,) int, increasing
    pixels: np.ndarray  # (k, 2) column and row, good to about a pixel
    reason: str  # "" if they are found


def detect(grey: np.ndarray, board: Board) -> Detected:
    """Find the points of a board in a grey photo.

    Parameters
    ----------
    grey : ndarray (rows, columns)
        uint8, or uint16 of any range of grey values.
    board : Board

    Returns
    -------
    Detected
        At least `LEAST` points, or none and a sentence that says why.

    Examples
    --------
    >>> from pgm_lab.calibration.board import draw
    >>> board = Board("charuco", 6, 5, 20.0)
    >>> found = detect(np.pad(draw(board, 100), 50, constant_values=255), board)
    >>> print(found.ids[-1], found.pixels[0].round())
    19 [128. 128.]
    >>> detect(np.full((300, 400), 99, np.uint8), board).reason
    'no marker is seen: no board, or too dark, blurred or small'
    """
    image = _eight_bits(_validate.grey_image(grey, "grey", 16))
    coded = board.dictionary is not None
    best = _none("")
    for side in CODED_SIDES if coded else PLAIN_SIDES:
        small = _reduced(image, side)
        found = (_coded if coded else _plain)(small, board)
        if len(found.ids) > len(best.ids) or not best.ids.size:
            scale = np.array(image.shape[::-1]) / np.array(small.shape[::-1])
            pixels = (found.pixels + 0.5) * scale - 0.5
            best = Detected(found.ids, pixels, found.reason)
        whole = len(best.ids) == len(board.points)
        if small is image or whole or best.ids.size and _step(found.pixels) > CLOSE:
            break
    if not best.ids.size:
        why = best.reason or (_no_markers if coded else _no_pattern)(
            _reduced(image, REASON_SIDE), board
        )
        return _none(why)
    if "circles" not in board.kind:
        best = best._replace(pixels=_full_size(image, best.pixels, float(scale.max())))
    return best


def _reduced(image: np.ndarray, side: int) -> np.ndarray:
    """Return the image with at most this many pixels along its longer side."""
    if (by := side / max(image.shape)) >= 1:
        return image
    size = tuple(int(np.rint(by * n)) for n in image.shape[::-1])
    return cv2.resize(image, size, interpolation=cv2.INTER_AREA)


def _step(pixels: np.ndarray) -> float:
    """Usual distance of a point (k, 2) to the nearest one."""
    apart = np.linalg.norm(pixels[:, None] - pixels, axis=-1)
    return float(np.median(np.where(apart > 0, apart, np.inf).min(1)))


def _eight_bits(grey: np.ndarray) -> np.ndarray:
    """Return grey values as uint8; others are stretched between their extremes."""
    if grey.dtype == np.uint8:
        return np.ascontiguousarray(grey)
    low, high = np.nanpercentile(grey[::8, ::8], (0.5, 99.5))
    stretched = (np.asarray(grey, np.float32) - low) * (255 / max(high - low, 1e-6))
    return np.clip(np.nan_to_num(stretched), 0, 255).astype(np.uint8)


def _full_size(image: np.ndarray, pixels: np.ndarray, by: float) -> np.ndarray:
    """Take up corners that were found in a photo reduced by a factor at full size."""
    # No neighbouring marker or square may come into the window
    half = int(np.clip(0.1 * _step(pixels), 2, np.ceil(2 * by) + 1))
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 20, 0.01)
    start = np.asarray(pixels, np.float32)[:, None].copy()
    refined = cv2.cornerSubPix(image, start, (half, half), (-1, -1), stop)[:, 0]
    moved = np.linalg.norm(refined - pixels, axis=1, keepdims=True)
    return np.where(moved <= half, refined, pixels).astype(float)


# --- Coded boards ---


def _coded(image: np.ndarray, board: Board) -> Detected:
    """Find the corners of a ChArUco board, or of tags."""
    own = markers(board.dictionary or "")
    detector = cv2.aruco.ArucoDetector(own)
    corners, seen, rejected = detector.detectMarkers(image)
    number = board.columns * board.rows
    number = number // 2 if board.kind == "charuco" else number
    marks = np.array([]) if seen is None else seen.ravel()
    if len(marks) < 2:
        return _none("")
    if np.sum(marks >= number) >= max(3, 0.1 * len(marks)):
        return _none(
            f"another board: marker {marks.max()} is seen, and this board has 0 to"
            f" {number - 1}"
        )
    own_place = _in_place(marks, corners, board)
    if len(marks) >= MANY and np.mean(own_place) < 0.7:
        return _none(_other_layout(marks, corners, board))
    kept = [int(i) for i in np.flatnonzero(own_place)]
    marks, corners = marks[kept], [corners[i] for i in kept]
    if len(marks) >= MANY:  # those that are small or blurred, from where they must be
        corners, seen, *_ = detector.refineDetectedMarkers(
            image, _opencv(board), corners, marks[:, None].copy(), rejected
        )
        kept = [int(i) for i in np.flatnonzero(_in_place(seen.ravel(), corners, board))]
        marks, corners = seen.ravel()[kept], [corners[i] for i in kept]
    order = [int(i) for i in np.argsort(marks)]
    marks, corners = marks[order], [corners[i] for i in order]
    if board.kind == "apriltags":
        ids = (4 * marks[:, None] + np.arange(4)).ravel()
        pixels = np.array(corners).reshape(-1, 2)
    else:
        ids, pixels = _charuco(image, marks, corners, board)
    if len(ids) < LEAST:
        return _none(
            f"too few points: {len(ids)} of {len(board.points)} are seen, at least"
            f" {LEAST} are needed"
        )
    return Detected(ids, pixels, "")


def _opencv(board: Board) -> Any:
    """Return the board as OpenCV describes it; y points down."""
    size, code = (board.columns, board.rows), markers(board.dictionary or "")
    marker = board.marker or 0.0
    if board.kind == "charuco":
        one = cv2.aruco.CharucoBoard(size, board.square, marker, code)
        one.setLegacyPattern(board.legacy)
        return one
    return cv2.aruco.GridBoard(size, marker, board.square - marker, code)


def _in_place(marks: np.ndarray, corners: Sequence, board: Board) -> np.ndarray:
    """Whether each marker (k,) sees most of its neighbours where the board has them.

    Each marker has a scale and directions of its own: by them it predicts where the
    centres of its neighbours are. The lens and a slant change that by a part of a step,
    a board with other numbers of columns or rows by a step or more.
    """
    theirs = _opencv(board)
    on_board = np.full((board.columns * board.rows, 4, 2), np.nan)
    on_board[theirs.getIds().ravel()] = np.array(theirs.getObjPoints())[..., :2]
    known = marks < len(on_board)
    square = on_board[np.where(known, marks, 0)]
    seen = np.array(corners, float).reshape(-1, 4, 2)
    centre, middle = seen.mean(1), square.mean(1)
    # Per mm along x and y of the board, which run from corner 0 to 1, and to 3
    along_x = (seen[:, 1] + seen[:, 2] - seen[:, 0] - seen[:, 3]) / 2 / board.marker
    along_y = (seen[:, 2] + seen[:, 3] - seen[:, 0] - seen[:, 1]) / 2 / board.marker
    d = middle - middle[:, None]  # [i, j]: from i to j
    apart = np.linalg.norm(d, axis=-1) / board.square
    near = (apart > 0) & (apart < 2.1) & known & known[:, None]
    off = d[..., :1] * along_x[:, None] + d[..., 1:] * along_y[:, None]
    off -= centre - centre[:, None]
    length = np.linalg.norm(centre - centre[:, None], axis=-1)
    good = near & (np.linalg.norm(off, axis=-1) < BEND * length)
    return known & (good.sum(1) >= 0.7 * near.sum(1))


def _charuco(
    image: np.ndarray, marks: np.ndarray, corners: Sequence, board: Board
) -> tuple[np.ndarray, np.ndarray]:
    """Return ids and pixels of the corners between markers that were found."""
    parameters = cv2.aruco.CharucoParameters()
    # Their check takes slanted boards for others (opencv issue 25850); ours was before
    if hasattr(parameters, "checkMarkers"):
        parameters.checkMarkers = False
    detector = cv2.aruco.CharucoDetector(_opencv(board), parameters)
    found, ids, *_ = detector.detectBoard(
        image, markerCorners=corners, markerIds=marks[:, None].copy()
    )
    if ids is None or not len(ids):
        return np.empty(0, int), np.empty((0, 2))
    order = np.argsort(ids.ravel())
    ids, pixels = ids.ravel()[order], found.reshape(-1, 2)[order]
    good = _regular(ids, pixels, board)
    return ids[good], pixels[good]


def _no_markers(image: np.ndarray, board: Board) -> str:
    """Say why no marker of the board was found."""

    def number(name: str, grey: np.ndarray) -> int:
        ids = cv2.aruco.ArucoDetector(markers(name)).detectMarkers(grey)[1]
        return 0 if ids is None else len(ids)

    if number(board.dictionary or "", cv2.flip(image, 1)) >= MANY:
        return "the photo is mirrored: turn that off in the camera, or flip it"
    for name in OTHERS:
        if number(name, image) >= MANY:
            return (
                f"another board: its markers are of {name}, and those of this board of"
                f" {board.dictionary}"
            )
    return "no marker is seen: no board, or too dark, blurred or small"


def _other_layout(marks: np.ndarray, corners: Sequence, board: Board) -> str:
    """Say that markers are the board's own, and do not lie where they should."""
    if board.kind == "charuco" and board.rows % 2 == 0:
        other = Board(**{**vars(board), "legacy": not board.legacy})
        if np.mean(_in_place(marks, corners, other)) > 0.9:
            drawn = "black" if board.legacy else "white, as OpenCV drew it before 4.6"
            return (
                f"another board: its top left square is {drawn}; write"
                f' "legacy": {str(other.legacy).lower()} into board.json'
            )
    return (
        f"another board: {len(marks)} markers are seen, but they do not lie as on one"
        f" of {board.columns} x {board.rows} with markers of {board.marker:g} mm in"
        f" {board.square:g} mm"
    )


# --- Plain boards ---


def _plain(image: np.ndarray, board: Board) -> Detected:
    """Find all corners of a chequerboard, or all circles."""
    columns, rows = board.grid
    if board.kind == "chequerboard":
        found, pixels = _chequerboard(image, (columns, rows))
    else:
        found, pixels = _circles(image, board)
    if not found:
        return _none("")
    grid = np.asarray(pixels, float).reshape(rows, columns, 2)

    # The right way round: columns to the right of the rows, which go down
    if _cross(_across(grid), _down(grid)) < 0:
        if board.kind == "asymmetric circles" and board.symmetric:
            return _none("the photo is mirrored: turn that off in the camera")
        # Each way leaves the pattern of its kind as it is
        grid = grid[::-1] if board.kind == "asymmetric circles" else grid[:, ::-1]
    if board.symmetric:
        if _down(grid) @ (1, 2) < 0:
            grid = grid[::-1, ::-1]
    elif board.kind == "chequerboard" and _white_first(image, grid):
        grid = grid[::-1, ::-1]
    ids, pixels = np.arange(rows * columns), grid.reshape(-1, 2)
    if not _regular(ids, pixels, board).all():
        return _none("")
    return Detected(ids, pixels, "")


def _chequerboard(image: np.ndarray, size: tuple[int, int]) -> tuple[bool, np.ndarray]:
    """Find inner corners, sector based; by the older detector if that finds none."""
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE
    found, pixels = cv2.findChessboardCornersSB(image, size, flags=flags)
    small = _reduced(image, REASON_SIDE)
    if not found:  # the older one takes seconds to find nothing in a large image
        flags |= cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_FAST_CHECK
        found, pixels = cv2.findChessboardCorners(small, size, flags=flags)
        if found:
            pixels = (pixels + 0.5) * (max(image.shape) / max(small.shape)) - 0.5
    if found and min(_seen(small)) > min(size) and max(_seen(small)) > max(size):
        return False, pixels  # a part of a larger board
    return found, pixels


def _seen(image: np.ndarray) -> tuple[int, int]:
    """Columns and rows of inner corners of the largest chequerboard, or zeros."""
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_LARGER
    found, _, meta = cv2.findChessboardCornersSBWithMeta(image, (3, 3), flags)
    return (meta.shape[1], meta.shape[0]) if found else (0, 0)


def _circles(image: np.ndarray, board: Board) -> tuple[bool, np.ndarray]:
    """Find the centres of circles of any size."""
    module: Any = cv2  # its types lack the blob detector
    parameters = module.SimpleBlobDetector_Params()
    parameters.minArea, parameters.maxArea = 20, image.size / 50
    parameters.minDistBetweenBlobs = 5
    symmetric = board.kind == "circles"
    flags = cv2.CALIB_CB_SYMMETRIC_GRID if symmetric else cv2.CALIB_CB_ASYMMETRIC_GRID
    detector = module.SimpleBlobDetector_create(parameters)
    for more in (0, cv2.CALIB_CB_CLUSTERING):  # clustering is for slanted boards
        found, pixels = cv2.findCirclesGrid(
            image, board.grid, flags=flags | more, blobDetector=detector
        )
        if found:
            break
    return found, pixels


def _no_pattern(image: np.ndarray, board: Board) -> str:
    """Say why a plain board was not found."""
    columns, rows = board.grid
    what = "circles" if "circles" in board.kind else "inner corners"
    if board.kind == "chequerboard":
        seen = _seen(image)
        if max(seen) and sorted(seen) != sorted(board.grid):
            return (
                f"{seen[0]} x {seen[1]} inner corners are seen, and the board has"
                f" {columns} x {rows}: another board, or not all of it"
            )
    return (
        f"the {columns} x {rows} {what} are not seen: no board, not all of it, or too"
        " dark, blurred or slanted"
    )


def _white_first(image: np.ndarray, grid: np.ndarray) -> bool:
    """Whether the square inside the first corner is white, as its diagonal ones are."""
    middle = (grid[:-1, :-1] + grid[1:, 1:] + grid[1:, :-1] + grid[:-1, 1:]) / 4
    column, row = np.rint(middle).astype(int).transpose(2, 0, 1)
    grey = cv2.blur(image, (3, 3))[row, column].astype(float)
    even = np.add.outer(*(np.arange(n) for n in grey.shape)) % 2 == 0
    return bool(grey[even].mean() > grey[~even].mean())


# --- The grid ---


def _across(grid: np.ndarray) -> np.ndarray:
    return (grid[:, -1] - grid[:, 0]).mean(0)


def _down(grid: np.ndarray) -> np.ndarray:
    return (grid[-1] - grid[0]).mean(0)


def _cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _regular(ids: np.ndarray, pixels: np.ndarray, board: Board) -> np.ndarray:
    """Whether points (k,) lie between their neighbours, as far as these are seen.

    Perspective and lens change the steps of the grid slowly; a point with another's id
    does not lie near the middle of its neighbours, and spoils that of theirs.
    """
    columns, rows = board.grid
    flat = np.full((rows * columns, 2), np.nan)
    flat[ids] = pixels
    grid = flat.reshape(rows, columns, 2)
    bad, judged = np.zeros((2, rows, columns))
    axes = (1,) if board.kind == "asymmetric circles" else (0, 1)  # their rows zigzag
    for axis in axes:
        steps = np.diff(grid, axis=axis)
        turn = np.linalg.norm(np.diff(steps, axis=axis), axis=-1)
        length = np.linalg.norm(steps, axis=-1)
        first, second = (
            np.take(length, np.arange(n, length.shape[axis] + n - 1), axis)
            for n in (0, 1)
        )
        off = np.where(np.isnan(turn), np.nan, turn > BEND * (first + second))
        for n in range(3):  # a triple judges all its three points
            part = [slice(None), slice(None)]
            part[axis] = slice(n, n + off.shape[axis])
            bad[tuple(part)] += np.nan_to_num(off)
            judged[tuple(part)] += ~np.isnan(off)
    return (bad <= judged / 2).ravel()[ids]


def _none(reason: str) -> Detected:
    return Detected(np.empty(0, int), np.empty((0, 2)), reason)
