"""The board: what was printed, where its points lie, and the file that says so.

Lengths are in mm. X points right, Y up, Z towards the viewer; the origin is the board's
lower left point. Points are counted row by row from the top left of the printed board,
as OpenCV does:

- "charuco", "chequerboard": inner corners, (columns - 1) (rows - 1) of them. The top
  left square is black; `legacy` is the pattern with an even number of rows that OpenCV
  had before 4.6, and others still sell, where it is white.
- "circles": centres; `marker` is their diameter.
- "asymmetric circles": centres, each row half a step beside the one before; rows are
  `square` apart, the circles in a row twice that.
- "apriltags": the four corners of each tag, id = 4 tag + corner, clockwise from its top
  left. `square` is a tag and the gap to the next one, `marker` the tag.
"""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files
from pgm_lab.io.files import printable

KINDS = ("charuco", "chequerboard", "circles", "asymmetric circles", "apriltags")
CODED = {"charuco": "DICT_5X5_100", "apriltags": "DICT_APRILTAG_36h11"}
LETTERS = "ABCD"
MEASURED = (
    ("A", "B"),
    ("A", "D"),
    ("A", "C"),
    ("B", "D"),
)  # lengths that a ruler is laid to
PRINTED = 0.01  # sd of a length that nobody measured: "100 %" may be 99
# Columns, rows, and the part of a square that the marker, tag or circle takes. The
# numbers tell top from bottom where the kind can: see `Board.symmetric`
USUAL = {
    "charuco": (13, 9, 0.75),
    "chequerboard": (12, 9, None),
    "circles": (12, 9, 0.5),
    "asymmetric circles": (7, 11, 0.8),
    "apriltags": (8, 5, 0.8),
}
PAPERS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0)}  # mm, landscape
ASIDE, ABOVE, BELOW = 16.0, 8.0, 22.0  # mm of the page that the board leaves free
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
    bars : tuple of (int, int, float, float)
        Scale bars: ids of two points, length and its standard deviation in mm.
    legacy : bool
        A ChArUco board as OpenCV drew it before 4.6.

    Raises
    ------
    ValueError
        If these do not describe a board.

    Examples
    --------
    >>> board = Board("charuco", 13, 9, 20.0)
    >>> print(len(board.points), board.points[0], board.marker)
    96 [  0. 140.   0.] 15.0
    """

    kind: str
    columns: int
    rows: int
    square: float
    marker: float | None = None
    dictionary: str | None = None
    bars: tuple[tuple[int, int, float, float], ...] = ()
    legacy: bool = False

    def __post_init__(self) -> None:
        _validate.choice(self.kind, "kind", KINDS)
        of_squares = self.kind in ("charuco", "chequerboard")
        least = 3 if of_squares else 1 if self.kind == "apriltags" else 2
        columns = _validate.whole(self.columns, "columns", least, 100)
        rows = _validate.whole(self.rows, "rows", least, 100)
        if self.kind in ("chequerboard", "circles") and columns == rows:
            raise ValueError(
                f"columns and rows are both {rows}: a quarter turn of such a board"
                " cannot be seen; its numbers must differ"
            )
        square = _validate.positive_number(self.square, "square", "mm")
        share = USUAL[self.kind][2]
        marker, dictionary = self.marker, self.dictionary
        if share is None and marker is not None:
            raise ValueError("marker: a plain chequerboard has none; leave it out")
        if share is not None:
            marker = round(share * square, 2) if marker is None else marker
            marker = _validate.positive_number(marker, "marker", "mm")
            limit = square * (2**0.5 if self.kind == "asymmetric circles" else 1)
            if not marker < limit:
                raise ValueError(
                    f"marker, {marker:g} mm, must be smaller than square, {square:g} mm"
                )
        if self.kind in CODED:
            dictionary = CODED[self.kind] if dictionary is None else dictionary
            _refuse_dictionary(self.kind, columns * rows, dictionary)
        elif dictionary is not None:
            raise ValueError(f"dictionary: {self.kind} have no markers; leave it out")
        legacy = _validate.flag(self.legacy, "legacy")
        if legacy and self.kind != "charuco":
            raise ValueError("legacy is a pattern of charuco boards; leave it out")
        for name, value in (
            ("columns", columns),
            ("rows", rows),
            ("square", square),
            ("marker", marker),
            ("dictionary", dictionary),
            ("legacy", legacy),
        ):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "bars", self._checked(self.bars))

    @property
    def grid(self) -> tuple[int, int]:
        """Columns and rows of points, of tags for apriltags."""
        less = self.kind in ("charuco", "chequerboard")
        return self.columns - less, self.rows - less

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
        return self.kind == "circles" or (
            self.kind == "asymmetric circles" and self.rows % 2 == 0
        )

    @property
    def letters(self) -> dict[str, int]:
        """Ids of the four points beside which A, B, C, D are printed, clockwise."""
        columns, rows = self.grid
        ids = [0, columns - 1, columns * rows - 1, columns * (rows - 1)]
        if self.kind == "apriltags":  # the outer corner of the tag
            ids = [4 * tag + corner for corner, tag in enumerate(ids)]
        return dict(zip(LETTERS, ids))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in mm of what `draw` draws: squares, or a white margin."""
        width, height = self.points[:, :2].max(0) + 2 * self.margin
        return float(width), float(height)

    @property
    def margin(self) -> float:
        """Distance in mm from the edge of what is drawn to the outer points."""
        tags = self.kind == "apriltags"
        return self.square - (self.marker or 0.0) if tags else self.square

    def scaled(self, square: float) -> "Board":
        """Return the board if a square measures this many mm, all in proportion."""
        square = _validate.positive_number(square, "square", "mm")
        by = square / self.square
        bars = tuple((i, j, by * d, by * sd) for i, j, d, sd in self.bars)
        marker = None if self.marker is None else by * self.marker
        return replace(self, square=square, marker=marker, bars=bars)

    def with_bars(self) -> "Board":
        """Return the board with the bars that its letters name, not yet measured."""
        ids, points = self.letters, self.points
        bars = []
        for first, second in MEASURED:
            i, j = ids[first], ids[second]
            length = float(np.linalg.norm(points[i] - points[j]))
            bars.append((i, j, round(length, 2), round(PRINTED * length, 2)))
        return replace(self, bars=tuple(bars))

    # --- The file ---

    def json(self) -> str:
        """Return the text of board.json."""
        names = {number: letter for letter, number in self.letters.items()}
        bars = [
            {
                "letters": f"{names.get(i, '?')} to {names.get(j, '?')}",
                "points": [i, j],
                "length": length,
                "sd": sd,
            }
            for i, j, length, sd in self.bars
        ]
        given = {name: getattr(self, name) for name in FIELDS if name != "bars"}
        given = {name: value for name, value in given.items() if value is not None}
        given = {"convention": CONVENTION} | given
        rows = [f'"{name}": {json.dumps(value)}' for name, value in given.items()]
        listed = ",\n    ".join(map(json.dumps, bars))
        rows.append('"bars": [' + (f"\n    {listed}\n  ]" if bars else "]"))
        return "{\n  " + ",\n  ".join(rows) + "\n}\n"

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
        name = printable(path)
        text = files.content(path, name, MAX_BYTES)
        try:
            given = json.loads(text.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            raise ValueError(
                f"{name}: this is no board.json, which `pgm_lab board` writes"
                f" ({printable(str(error)):.80})"
            ) from None
        try:
            return _of_json(given)
        except ValueError as error:
            raise ValueError(f"{name}: {printable(str(error))}") from None

    def _checked(self, bars: Any) -> tuple[tuple[int, int, float, float], ...]:
        """Return the scale bars, refusing those that the points contradict."""
        points, checked = self.points, []
        for n, bar in enumerate(_validate.several(bars, "bars"), 1):
            name = f"bar {n}"
            if len(parts := _validate.several(bar, name)) != 4:
                raise ValueError(f"{name} must be two ids, a length and its sd")
            i, j, length, sd = parts
            i, j = (_validate.whole(v, f"{name}, point", 0) for v in (i, j))
            if max(i, j) >= len(points) or i == j:
                raise ValueError(
                    f"{name}: points {i} and {j} must be two of the board, which has 0"
                    f" to {len(points) - 1}"
                )
            length = _validate.positive_number(length, f"{name}, length", "mm")
            sd = _validate.positive_number(sd, f"{name}, sd", "mm")
            by_squares = float(np.linalg.norm(points[i] - points[j]))
            if abs(length / by_squares - 1) > 0.1:
                raise ValueError(
                    f"{name}: a length of {length:g} mm between points {i} and {j},"
                    f" which lie {by_squares:.4g} mm apart with squares of"
                    f" {self.square:g} mm. One of the two is wrong, or not in mm"
                )
            checked.append((i, j, length, sd))
        return tuple(checked)


FIELDS = tuple(Board.__dataclass_fields__)
MAX_BYTES = 2**20


def _of_json(given: Any) -> Board:
    """Return the board that a file describes."""
    if not isinstance(given, Mapping):
        raise ValueError("this is no board.json, which `pgm_lab board` writes")
    for name in ("kind", "columns", "rows", "square"):
        if name not in given:
            raise ValueError(f'"{name}" is missing')
    unknown = sorted(set(given) - {*FIELDS, "convention"})
    if unknown:
        raise ValueError(
            f"{_validate.shown(unknown[0])} is unknown; a board has {', '.join(FIELDS)}"
        )
    bars = []
    for n, bar in enumerate(_validate.several(given.get("bars", ()), "bars"), 1):
        if not isinstance(bar, Mapping) or not {"points", "length", "sd"} <= set(bar):
            raise ValueError(f'bar {n} must have "points", "length" and "sd"')
        ends = _validate.several(bar["points"], f"points of bar {n}")
        if len(ends) != 2:
            raise ValueError(f"bar {n} must have two points; got {len(ends)}")
        bars.append((*ends, bar["length"], bar["sd"]))
    rest = {name: given[name] for name in FIELDS if name in given and name != "bars"}
    return Board(**rest, bars=tuple(bars))


def _refuse_dictionary(kind: str, cells: int, name: str) -> None:
    """Refuse an unknown set of markers, or one with too few of them."""
    known = isinstance(name, str) and name.startswith("DICT_")
    if not known or not isinstance(getattr(cv2.aruco, name, None), int):
        raise ValueError(
            f"dictionary {_validate.shown(name)} is unknown to OpenCV; DICT_5X5_100 and"
            " DICT_APRILTAG_36h11 are two of them"
        )
    needed = cells // 2 if kind == "charuco" else cells
    there = len(markers(name).bytesList)
    if needed > there:
        raise ValueError(f"the board needs {needed} markers, {name} has {there}")


def markers(name: str) -> Any:
    """Return OpenCV's set of markers of this name."""
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


# --- Drawing ---


def usual(
    kind: str = "charuco",
    width: float | None = None,
    height: float | None = None,
    *,
    columns: int | None = None,
    rows: int | None = None,
    square: float | None = None,
    marker: float | None = None,
) -> Board:
    """Return a board of this kind, as large as a page allows if `square` is not given.

    Parameters
    ----------
    kind : str
    width, height : float
        Of the part of a page that is free for it, in mm; that of A4 when missing.
    columns, rows, square, marker
        As in `Board`; as usual when missing.

    Raises
    ------
    ValueError
        If it does not fit.

    Examples
    --------
    >>> usual("circles").square
    18.0
    """
    _validate.choice(kind, "kind", KINDS)
    free = (
        width or PAPERS["A4"][0] - 2 * ASIDE,
        height or PAPERS["A4"][1] - ABOVE - BELOW,
    )
    across, down, _ = USUAL[kind]
    numbers = columns or across, rows or down
    one = Board(kind, *numbers, 1.0, marker and square and marker / square)
    fits = min(mm / n for mm, n in zip(free, one.size))
    if square is None:
        square = max(np.floor(2 * fits) / 2, 0.5)
    if square > fits:
        raise ValueError(
            f"{one.columns} x {one.rows} with {square:g} mm do not fit: the page leaves"
            f" {free[0]:g} x {free[1]:g} mm, enough for {np.floor(10 * fits) / 10:g} mm"
        )
    return Board(kind, *numbers, float(square), marker)


def ink(board: Board) -> tuple[np.ndarray, np.ndarray]:
    """Black rectangles (n, 4), x0, y0, x1, y1, and circles (k, 3), x, y, radius.

    In mm, in the frame of the board's points. Rectangles do not overlap.
    """
    if "circles" in board.kind:
        assert board.marker is not None
        radius = np.full((len(board.points), 1), board.marker / 2)
        return np.empty((0, 4)), np.concatenate([board.points[:, :2], radius], 1)
    row, column = np.divmod(np.arange(board.columns * board.rows), board.columns)
    inside = board.kind != "apriltags"  # the origin is an inner corner
    x, y = column - inside, board.rows - 1 - row - inside
    odd = (column + row + (board.legacy and board.rows % 2 == 0)) % 2 == 1
    rectangles = []
    if inside:
        black = np.stack([x, y, x + 1, y + 1], 1)[~odd]
        rectangles.append(board.square * black)
    if board.marker is not None:
        at = np.stack([x, y], 1)[odd] if inside else np.stack([x, y], 1)
        gap = (board.square - board.marker) / 2 if inside else 0.0
        code = markers(board.dictionary or "")
        n = code.markerSize + 2
        for number, corner in enumerate(board.square * at + gap):
            bits = cv2.aruco.generateImageMarker(code, number, n) == 0
            # Black runs along the rows of the marker, counted from its top
            edge = np.diff(np.pad(bits.astype(int), ((0, 0), (1, 1))), axis=1)
            line, begin = np.nonzero(edge == 1)
            end = np.nonzero(edge == -1)[1]
            runs = np.stack([begin, n - 1 - line, end, n - line], 1)
            rectangles.append(runs * board.marker / n + np.tile(corner, 2))
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
    height = board.size[1]
    black: np.ndarray = np.zeros((rows, columns), np.float32)
    rectangles, circles = ink(board)
    x0, y0, x1, y1 = scale * (rectangles + board.margin).T
    y0, y1 = scale * height - y1, scale * height - y0  # down
    for left, top, right, bottom in np.stack([x0, y0, x1, y1], 1):
        column, across = _covered(left, right)
        row, down = _covered(top, bottom)
        part = black[row : row + len(down), column : column + len(across)]
        part += np.outer(down, across)[: part.shape[0], : part.shape[1]]
    for x, y, radius in scale * circles:
        y, x = scale * (height - board.margin) - 0.5 - y, scale * board.margin - 0.5 + x
        top, left = (max(int(v - radius - 1), 0) for v in (y, x))
        part = black[top : int(y + radius) + 3, left : int(x + radius) + 3]
        down, across = np.ogrid[: part.shape[0], : part.shape[1]]
        from_centre = np.hypot(across + left - x, down + top - y)
        part += np.clip(radius + 0.5 - from_centre, 0, 1)  # the rim, within a pixel
    return np.rint(255 * (1 - np.clip(black, 0, 1))).astype(np.uint8)


def _covered(begin: float, end: float) -> tuple[int, np.ndarray]:
    """First pixel of an interval, and how much of each pixel from there it covers."""
    begin, end = round(begin, 9), round(end, 9)
    first = int(np.floor(begin))
    edges = np.clip(np.arange(first, int(np.ceil(end)) + 1), begin, end)
    return first, np.diff(edges)


def screen(board: Board, size: tuple[int, int]) -> tuple[Board, bytes]:
    """Draw the board on a screen of this size, in pixels: a board in its pixels, a PNG.

    All edges fall between two pixels. How large a pixel is only a ruler tells: the
    board that is returned takes 96 a inch, and has no scale bars.

    Raises
    ------
    ValueError
        If the screen is too small for the board.
    """
    width, height = (_validate.whole(n, "size", 100, 20_000) for n in size)
    one = replace(board.scaled(1.0), bars=())
    n = 1 if board.dictionary is None else markers(board.dictionary).markerSize + 2
    side = int(min(0.94 * width / one.size[0], 0.94 * height / one.size[1]))
    marker = None if one.marker is None else int(one.marker * side / n) * n
    if marker is not None and board.kind == "charuco":
        marker -= n * ((side - marker) % 2)  # the same gap on both sides
    if side < 8 or marker is not None and marker < 2 * n:
        raise ValueError(
            f"a screen of {width} x {height} pixels is too small for {board.columns} x"
            f" {board.rows}: take fewer columns and rows"
        )
    pitch = 25.4 / 96
    one = replace(one, square=side * pitch, marker=marker and marker * pitch)
    drawn = draw(one, 96)
    page = np.full((height, width), 255, np.uint8)
    top, left = (height - drawn.shape[0]) // 2, (width - drawn.shape[1]) // 2
    page[top : top + drawn.shape[0], left : left + drawn.shape[1]] = drawn
    return one, cv2.imencode(".png", page)[1].tobytes()
