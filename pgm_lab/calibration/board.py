"""The board: what was printed, where its points lie, and the file that says so.

Lengths are in mm. X points right, Y up, Z towards the viewer; the origin is the board's
lower left point. Points are counted row by row from the top left of the printed board,
as OpenCV does:

- "charuco", "chequerboard": inner corners, (columns - 1) (rows - 1) of them. The top
  left square is black (a ChArUco board of OpenCV before 4.6 with an even number of rows
  is another one).
- "circles": centres; `marker` is their diameter.
- "asymmetric circles": centres, each row half a step beside the one before; rows are
  `square` apart, the circles in a row twice that.
- "apriltags": the four corners of each tag, id = 4 tag + corner, clockwise from its top
  left. `square` is a tag and the gap to the next one, `marker` the tag.
"""

import json
import os
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files
from pgm_lab.io.files import printable

# Columns and rows, the part of a square that marker, tag or circle takes, and what the
# markers are. The numbers tell top from bottom where the kind can: `Board.symmetric`
USUAL: dict[str, tuple[int, int, float | None, str | None]] = {
    "charuco": (13, 9, 0.65, "DICT_5X5_100"),  # corners need room beside the markers
    "chequerboard": (12, 9, None, None),
    "circles": (12, 9, 0.5, None),
    "asymmetric circles": (7, 11, 0.8, None),
    "apriltags": (8, 5, 0.8, "DICT_APRILTAG_36h11"),
}
KINDS = tuple(USUAL)
MEASURED = ("AB", "AD", "AC", "BD")  # lengths that a ruler is laid to
PRINTED = 0.01  # sd of a length that nobody measured: "100 %" may be 99
PAPERS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0)}  # mm, landscape
ASIDE, ABOVE, BELOW = 16.0, 8.0, 22.0  # mm of the page that the board leaves free
SCREEN = 96.0  # pixels an inch, until a ruler says how many there are
MAX_BYTES = 2**20
CONVENTION = (
    "mm; X right, Y up, Z towards the viewer, origin at the lower left point; points"
    " counted row by row from the top left, from 0. bars: lengths between two points,"
    " measured with a ruler, and their sd"
)


@dataclass(frozen=True, eq=False)
class Board:
    """A board with known points, as it was printed.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    columns, rows : int
        Squares across and down; circles, or tags, of these kinds.
    square : float
        Side of a square, or distance of circles or tags, in mm.
    marker : float or None
        Side of a marker or tag, or diameter of a circle, in mm; None: as usual.
    dictionary : str or None
        OpenCV's name of the markers, "DICT_5X5_100" for example; None: as usual.
    bars : sequence of (int, int, float, float)
        Scale bars: ids of two points, length and its standard deviation in mm.

    Raises
    ------
    ValueError
        If these do not describe a board.

    Examples
    --------
    >>> board = Board("charuco", 13, 9, 20.0)
    >>> print(len(board.points), board.points[0], board.marker)
    96 [  0. 140.   0.] 13.0
    """

    kind: str
    columns: int
    rows: int
    square: float
    marker: float | None = None
    dictionary: str | None = None
    bars: tuple[tuple[int, int, float, float], ...] = ()

    def __post_init__(self) -> None:
        _, _, share, code = USUAL[_validate.choice(self.kind, "kind", KINDS)]
        least = 1 if self.kind == "apriltags" else 2 + self._squares
        columns = _validate.whole(self.columns, "columns", least, 100)
        rows = _validate.whole(self.rows, "rows", least, 100)
        if self.kind in ("chequerboard", "circles") and columns == rows:
            raise ValueError(
                f"columns and rows are both {rows}: a quarter turn of such a board"
                " cannot be seen; its numbers must differ"
            )
        square = _validate.positive_number(self.square, "square", "mm")
        marker = self.marker
        if (marker and not share) or (self.dictionary and not code):
            raise ValueError(f"{self.kind}: without marker or dictionary; leave it out")
        if share:
            marker = round(share * square, 2) if marker is None else marker
            marker = _validate.positive_number(marker, "marker", "mm")
            if not marker < square * (2**0.5 if "asymmetric" in self.kind else 1):
                raise ValueError(
                    f"marker, {marker:g} mm, must be smaller than square, {square:g} mm"
                )
        if code := self.dictionary or code:
            needed = columns * rows // (1 + self._squares)
            if needed > (there := len(markers(code).bytesList)):
                raise ValueError(f"it needs {needed} markers, {code} has {there}")
        given = {"columns": columns, "rows": rows, "square": square, "marker": marker}
        vars(self).update(given, dictionary=code)

        # Scale bars: does a ruler agree with the squares?
        points, bars = self.points, []
        for n, (i, j, length, sd) in enumerate(self.bars, 1):
            i, j = (
                _validate.whole(end, f"bar {n}, point", 0, len(points) - 1)
                for end in (i, j)
            )
            length = _validate.positive_number(length, f"bar {n}, length", "mm")
            sd = _validate.positive_number(sd, f"bar {n}, sd", "mm")
            by_squares = float(np.linalg.norm(points[i] - points[j]))
            if abs(length - by_squares) > 0.1 * by_squares:
                raise ValueError(
                    f"bar {n}: a length of {length:g} mm between points {i} and {j},"
                    f" which lie {by_squares:.4g} mm apart with squares of"
                    f" {square:g} mm. One of the two is wrong, or not in mm"
                )
            bars.append((i, j, length, sd))
        vars(self).update(bars=tuple(bars))

    @property
    def _squares(self) -> bool:
        """Whether the points are corners between squares."""
        return self.kind in ("charuco", "chequerboard")

    @property
    def grid(self) -> tuple[int, int]:
        """Columns and rows of points, of tags for apriltags."""
        return self.columns - self._squares, self.rows - self._squares

    @property
    def points(self) -> np.ndarray:
        """The points (n, 3) in mm, if the board were flat and exactly printed."""
        columns, rows = self.grid
        row, column = np.divmod(np.arange(columns * rows), columns)
        x, y = column.astype(float), (rows - 1 - row).astype(float)
        if self.kind == "asymmetric circles":
            x = 2 * x + row % 2
        xyz = np.stack([x, y, 0 * x], -1) * self.square
        if self.kind == "apriltags":
            corner = np.array([(0, 1, 0), (1, 1, 0), (1, 0, 0), (0, 0, 0)])
            xyz = (xyz[:, None] + corner * self.marker).reshape(-1, 3)
        return xyz

    @property
    def symmetric(self) -> bool:
        """Whether the board looks the same when it is rotated by 180 degrees.

        Its points are then counted from the end that lies higher in the photo.
        """
        if self.kind == "chequerboard":
            return (self.columns + self.rows) % 2 == 0
        return "circles" in self.kind and (self.kind == "circles" or self.rows % 2 == 0)

    @property
    def letters(self) -> dict[str, int]:
        """Ids of the four points beside which A, B, C, D are printed, clockwise."""
        columns, rows = self.grid
        ids = [0, columns - 1, columns * rows - 1, columns * (rows - 1)]
        if self.kind == "apriltags":  # the outer corner of the tag
            ids = [4 * tag + corner for corner, tag in enumerate(ids)]
        return dict(zip("ABCD", ids))

    @property
    def margin(self) -> float:
        """Distance in mm from the edge of what is drawn to the outer points."""
        return self.square - (self.kind == "apriltags" and self.marker or 0.0)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in mm of what `draw` draws: squares, or a white margin."""
        width, height = self.points[:, :2].max(0) + 2 * self.margin
        return float(width), float(height)

    def opencv(self) -> Any:
        """Return a coded board as OpenCV describes it; y points down."""
        size, code = (self.columns, self.rows), markers(self.dictionary or "")
        marker = self.marker or 0.0
        if self.kind == "charuco":
            return cv2.aruco.CharucoBoard(size, self.square, marker, code)
        return cv2.aruco.GridBoard(size, marker, self.square - marker, code)

    def scaled(self, square: float) -> "Board":
        """Return the board if a square measures this many mm, all in proportion."""
        by = _validate.positive_number(square, "square", "mm") / self.square
        bars = tuple((i, j, by * d, by * sd) for i, j, d, sd in self.bars)
        marker = self.marker and by * self.marker
        return replace(self, square=square, marker=marker, bars=bars)

    # --- The file ---

    def json(self) -> str:
        """Return the text of board.json."""
        names = {number: letter for letter, number in self.letters.items()}
        bars = [
            {"letters": f"{names.get(i)} to {names.get(j)}", "points": [i, j]}
            | {"length": length, "sd": sd}
            for i, j, length, sd in self.bars
        ]
        given = {"convention": CONVENTION, **vars(self), "bars": bars}
        lines = [
            f'  "{name}": {json.dumps(value)}'.replace("{", "\n    {")
            for name, value in given.items()
            if value is not None
        ]
        return "{\n" + ",\n".join(lines) + "\n}\n"

    def save(self, path: str | os.PathLike, overwrite: bool = False) -> None:
        """Write board.json; FileExistsError if it is there, unless `overwrite`."""
        files.save({path: self.json()}, overwrite=overwrite)

    @classmethod
    def read(cls, path: str | os.PathLike) -> "Board":
        """Read board.json.

        Raises
        ------
        OSError
            If there is no such file, or it can't be read.
        ValueError
            If it does not describe a board: what is wrong, and where.
        """
        text = files.content(path, name := printable(path), MAX_BYTES)
        try:
            given = dict(json.loads(text.decode("utf-8-sig")))
            bars = [(*b["points"], b["length"], b["sd"]) for b in given.pop("bars", ())]
            given.pop("convention", None)
            return cls(**given, bars=tuple(bars))
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise ValueError(
                f"{name}: this is no board.json as `pgm_lab board` writes it:"
                f" {printable(str(error)):.300}"
            ) from None


def markers(name: str) -> Any:
    """Return OpenCV's set of markers of this name."""
    number = getattr(cv2.aruco, str(name), None)
    if not str(name).startswith("DICT_") or number is None:
        raise ValueError(
            f"dictionary {_validate.shown(name)} is unknown to OpenCV; DICT_5X5_100 and"
            " DICT_APRILTAG_36h11 are two of them"
        )
    return cv2.aruco.getPredefinedDictionary(number)


# --- Drawing ---


def usual(
    kind: str = "charuco",
    paper: str = "A4",
    *,
    columns: int | None = None,
    rows: int | None = None,
    square: float | None = None,
    marker: float | None = None,
) -> Board:
    """Return a board of this kind, as large as the paper allows if not told otherwise.

    Its scale bars are the lengths between its letters, not yet measured.

    Examples
    --------
    >>> usual("circles").square
    18.0
    """
    across, down, *_ = USUAL[_validate.choice(kind, "kind", KINDS)]
    width, height = PAPERS[_validate.choice(paper, "paper", tuple(PAPERS))]
    free = width - 2 * ASIDE, height - ABOVE - BELOW
    columns, rows = columns or across, rows or down
    one = Board(kind, columns, rows, 1.0, marker and square and marker / square)
    fits = min(free[0] / one.size[0], free[1] / one.size[1])
    if square is None:
        square = max(np.floor(2 * fits) / 2, 0.5)
    if square > fits:
        raise ValueError(
            f"{columns} x {rows} with {square:g} mm do not fit: {paper} leaves"
            f" {free[0]:g} x {free[1]:g} mm, enough for {np.floor(10 * fits) / 10:g} mm"
        )
    board = Board(kind, columns, rows, float(square), marker)
    bars = []
    for i, j in ((board.letters[end] for end in ends) for ends in MEASURED):
        length = float(np.linalg.norm(board.points[i] - board.points[j]))
        bars.append((i, j, round(length, 2), round(PRINTED * length, 2)))
    return replace(board, bars=tuple(bars))


def ink(board: Board) -> tuple[np.ndarray, np.ndarray]:
    """Black rectangles (n, 4), x0, y0, x1, y1, and circles (k, 3), x, y, radius.

    In mm, in the frame of the board's points. Rectangles do not overlap.
    """
    marker = board.marker or 0.0
    if "circles" in board.kind:
        radius = np.full((len(board.points), 1), marker / 2)
        return np.empty((0, 4)), np.concatenate([board.points[:, :2], radius], 1)
    row, column = np.divmod(np.arange(board.columns * board.rows), board.columns)
    squares = board.kind != "apriltags"  # the origin is an inner corner
    corner = board.square * np.stack([column, board.rows - 1 - row], 1)
    black = squares * (column + row + 1) % 2 == 1
    corner -= board.square * squares
    rectangles = [np.concatenate([corner, corner + board.square], 1)[black]]
    if board.dictionary:
        code = markers(board.dictionary)
        cell = marker / (n := code.markerSize + 2)
        gap = (board.square - marker) / 2 * squares
        for number, (x, y) in enumerate(corner[~black] + gap):
            bits = cv2.aruco.generateImageMarker(code, number, n)[::-1]
            up, right = np.nonzero(bits == 0)
            low = np.stack([x + cell * right, y + cell * up], 1)
            rectangles.append(np.concatenate([low, low + cell], 1))
    return np.concatenate(rectangles), np.empty((0, 3))


def draw(board: Board, dpi: float) -> np.ndarray:
    """Draw the board alone: a grey image uint8, 255 white, pixels partly black exact.

    Its lower left corner lies `board.margin` left of and below the lowest left point.

    Examples
    --------
    >>> draw(Board("chequerboard", 4, 3, 10.0), 25.4).shape
    (30, 40)
    """
    scale = _validate.positive_number(dpi, "dpi", "1/inch") / 25.4
    columns, rows = (int(np.ceil(round(scale * mm, 6))) for mm in board.size)
    _validate.size("dpi", rows, columns)
    black: np.ndarray = np.zeros((rows, columns), np.float32)
    rectangles, circles = ink(board)
    left, top = board.margin, board.size[1] - board.margin
    sides = (rectangles * (1, -1, 1, -1) + (left, top, left, top)) * scale
    for x0, y1, x1, y0 in sides.round(6):
        column, row = (
            np.arange(int(low), int(np.ceil(high)))
            for low, high in ((x0, x1), (y0, y1))
        )
        across = np.minimum(column + 1, x1) - np.maximum(column, x0)
        down = np.minimum(row + 1, y1) - np.maximum(row, y0)
        black[row[0] : row[-1] + 1, column[0] : column[-1] + 1] += np.outer(
            down, across
        )
    for x, y, r in (circles * (1, -1, 1) + (left, top, 0)) * scale - (0.5, 0.5, 0):
        row, column = (np.arange(int(v - r - 1), int(v + r + 3)) for v in (y, x))
        from_centre = np.hypot(column - x, row[:, None] - y)
        rim = np.clip(r + 0.5 - from_centre, 0, 1)  # within a pixel
        black[row[0] : row[-1] + 1, column[0] : column[-1] + 1] += rim
    return np.rint(255 * (1 - np.clip(black, 0, 1))).astype(np.uint8)


def screen(board: Board, size: tuple[int, int]) -> tuple[Board, bytes]:
    """Draw the board on a screen of this size, in pixels: a board in its pixels, a PNG.

    All edges of squares fall between two pixels. How large a pixel is only a ruler
    tells: the board that is returned takes 96 an inch, and has no scale bars.
    """
    one = replace(board, bars=()).scaled(25.4 / SCREEN)  # a square is a pixel
    across, down = (0.94 * n * one.square / mm for n, mm in zip(size, one.size))
    if (side := int(min(across, down))) < 16:
        raise ValueError(
            f"a screen of {size[0]} x {size[1]} pixels is too small for"
            f" {board.columns} x {board.rows}: take fewer columns and rows"
        )
    one = one.scaled(side * one.square)
    drawn = draw(one, SCREEN)
    page = np.full(size[::-1], 255, np.uint8)
    top, left = (np.array(page.shape) - drawn.shape) // 2
    page[top : top + drawn.shape[0], left : left + drawn.shape[1]] = drawn
    return one, cv2.imencode(".png", page)[1].tobytes()
