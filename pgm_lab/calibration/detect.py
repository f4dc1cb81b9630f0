"""Where a photo shows the points of a board, to about a pixel: by OpenCV's detectors.

A board that is partly hidden is found if its parts are coded (charuco, apriltags); all
points of the other kinds must be seen. Which end of a plain board is its top follows
from its pattern where it can: see `Board.symmetric`. Where it can't, the end that lies
higher in the photo is taken, or the left one if the board is turned by 90 degrees. The
mirror image of a plain board is such a board again: nobody can tell that a photo was
mirrored.
"""

from typing import Any, NamedTuple

import cv2
import numpy as np

from pgm_lab import _validate
from pgm_lab.calibration.board import Board

LEAST = 6  # points: a homography takes four, and nothing would check them
# Pixels to which a photo is reduced; to the second if the first does not show all
CODED_SIDES, PLAIN_SIDES = (1600, 4000), (1200, 2400)
BEND = 0.35  # of two steps: how far a point may lie off the middle of its neighbours
OWN = 0.7  # least share of the points that lie so if the board is this one


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
    >>> detect(np.full((300, 400), 99, np.uint8), board).reason[:29]
    'no marker is seen: no board, '
    """
    image = _validate.grey_image(grey, "grey", 16)
    if image.dtype != np.uint8:
        low, high = np.percentile(image[::8, ::8], (0.5, 99.5))
        image = (image.astype(np.float32) - low) * (255 / max(high - low, 1e-6))
        image = np.clip(image, 0, 255).astype(np.uint8)
    best, by = _none(""), 1.0
    for side in CODED_SIDES if board.dictionary else PLAIN_SIDES:
        by = max(max(image.shape) / side, 1.0)
        size = [round(n / by) for n in image.shape[::-1]]
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        found = (_coded if board.dictionary else _plain)(small, board)
        if len(found.ids) >= len(best.ids):
            pixels = (found.pixels + 0.5) * np.divide(image.shape[::-1], size) - 0.5
            best = found._replace(pixels=pixels)
        if by == 1 or len(best.ids) == len(board.points):
            break
    if len(best.ids) and "circles" not in board.kind:
        # Corners at full size, within what the reduced photo leaves open
        start, half = best.pixels[:, None].astype(np.float32), int(by) + 2
        stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 20, 0.01)
        at = cv2.cornerSubPix(image, start, (half, half), (-1, -1), stop)[:, 0]
        best = best._replace(pixels=at.astype(float))
    return best


def _none(reason: str) -> Detected:
    return Detected(np.empty(0, int), np.empty((0, 2)), reason)


def _coded(image: np.ndarray, board: Board) -> Detected:
    """Find the corners of a ChArUco board, or of tags."""
    theirs = board.opencv()
    if board.kind == "charuco":
        how = cv2.aruco.CharucoParameters()
        how.tryRefineMarkers = True
        # Their check takes slanted boards for others (opencv issue 25850)
        if hasattr(how, "checkMarkers"):  # not in 4.11
            how.checkMarkers = False
        found: Any = cv2.aruco.CharucoDetector(theirs, how).detectBoard(image)
        pixels, ids, _, seen = found
    else:
        detector: Any = cv2.aruco.ArucoDetector(theirs.getDictionary())
        pixels, ids, rest = detector.detectMarkers(image)
        if (seen := ids) is not None:
            found = detector.refineDetectedMarkers(image, theirs, pixels, ids, rest)
            pixels, ids, *_ = found
    if seen is None or not len(seen):
        return _none(
            "no marker is seen: no board, another one, mirrored, or too dark, blurred"
            " or small"
        )
    each = 4 if board.kind == "apriltags" else 1  # points of an id
    ids = np.array([] if ids is None else ids, int).ravel()
    pixels = np.array([] if not len(ids) else pixels, float).reshape(-1, each, 2)
    strange = np.sum(seen > theirs.getIds().max())
    inside = np.flatnonzero(ids < np.prod(board.grid))
    inside = inside[np.argsort(ids[inside])]
    ids, pixels = ids[inside], pixels[inside]
    good = _regular(ids, pixels.mean(1), board)
    if strange > max(1, 0.1 * len(seen)) or np.sum(good) < OWN * len(ids):
        return _none(
            f"another board: the {len(seen)} markers that are seen do not lie as on one"
            f" of {board.columns} x {board.rows}"
        )
    ids = (each * ids[good, None] + np.arange(each)).ravel()
    if len(ids) < LEAST:
        return _none(
            f"too few points: {len(ids)} of {len(board.points)} are seen, at least"
            f" {LEAST} are needed"
        )
    return Detected(ids, pixels[good].reshape(-1, 2), "")


def _plain(image: np.ndarray, board: Board) -> Detected:
    """Find all corners of a chequerboard, or all circles."""
    columns, rows = board.grid
    what = "inner corners" if board.kind == "chequerboard" else "circles"
    but = ": no board, another one, not all of it, or too dark, blurred or slanted"
    if board.kind == "chequerboard":
        flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_LARGER
        found, pixels, meta = cv2.findChessboardCornersSBWithMeta(
            image, board.grid, flags
        )
        if found and sorted(meta.shape) != sorted(board.grid):
            found, but = False, f", but {meta.shape[1]} x {meta.shape[0]}: another"
            but += " board, or its file does not count squares: there is one more"
    else:
        module: Any = cv2  # its types lack the blob detector
        blobs = module.SimpleBlobDetector_Params()
        blobs.minArea, blobs.maxArea = 20, image.size / 50
        blobs.minDistBetweenBlobs = 5
        blobs = module.SimpleBlobDetector_create(blobs)
        flags = cv2.CALIB_CB_SYMMETRIC_GRID
        if board.kind == "asymmetric circles":
            flags = cv2.CALIB_CB_ASYMMETRIC_GRID
        for more in (0, cv2.CALIB_CB_CLUSTERING):  # clustering is for slanted boards
            found, pixels = cv2.findCirclesGrid(
                image, board.grid, flags=flags | more, blobDetector=blobs
            )
            if found:
                break
    if not found:
        return _none(f"the {columns} x {rows} {what} are not seen{but}")
    grid = np.asarray(pixels, float).reshape(rows, columns, 2)

    # The right way round: columns to the right of the rows, which go down
    across, down = (grid[:, -1] - grid[:, 0]).mean(0), (grid[-1] - grid[0]).mean(0)
    if across[0] * down[1] < across[1] * down[0]:
        # Each way leaves the pattern of its kind as it is
        grid = grid[::-1] if board.kind == "asymmetric circles" else grid[:, ::-1]
    if board.symmetric:
        upside_down = (grid[-1] - grid[0]).mean(0) @ (1, 2) < 0
    else:
        upside_down = board.kind == "chequerboard" and _white_first(image, grid)
    grid = grid[::-1, ::-1] if upside_down else grid
    return Detected(np.arange(rows * columns), grid.reshape(-1, 2), "")


def _white_first(image: np.ndarray, grid: np.ndarray) -> bool:
    """Whether the square inside the first corner is white, as its diagonal ones are."""
    middle = (grid[:-1, :-1] + grid[1:, 1:] + grid[1:, :-1] + grid[:-1, 1:]) / 4
    column, row = np.rint(middle).astype(int).transpose(2, 0, 1)
    grey = cv2.blur(image, (3, 3))[row, column].astype(float)
    even = np.add.outer(*(np.arange(n) for n in grey.shape)) % 2 == 0
    return bool(grey[even].mean() > grey[~even].mean())


def _regular(ids: np.ndarray, pixels: np.ndarray, board: Board) -> np.ndarray:
    """Whether points (k,) lie midway between their neighbours, where these are seen.

    Perspective and lens change the steps of the grid slowly, another's id abruptly.
    """
    columns, rows = board.grid
    grid = np.full((rows * columns, 2), np.nan)
    grid[ids] = pixels
    good = np.ones((rows, columns), bool)
    for axis in (0, 1):
        one = np.moveaxis(grid.reshape(rows, columns, 2), axis, 0)
        off = np.linalg.norm(one[:-2] + one[2:] - 2 * one[1:-1], axis=-1)
        bad = off > BEND * np.linalg.norm(one[2:] - one[:-2], axis=-1)
        judged = np.moveaxis(good, axis, 0)  # a view: a triple judges all its points
        for n in range(3):
            judged[n : n + len(bad)] &= ~bad
    return good.ravel()[ids]
