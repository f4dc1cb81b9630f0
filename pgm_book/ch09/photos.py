"""The photos of lesson 9: the reader's own from a folder, or those of the book.

`board` reads two sets of photos of a board, `pair` the two photos of a scene. A folder
of one's own holds ``board/*.jpg``, the ``board.json`` that ``pgm_lab board`` wrote, and
``left.*`` and ``right.*``; all are reduced to at most 1000 columns, so that the
lesson's loops stay short.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from pgm_book.common.own_program import FILE
from pgm_book.program.bundle import without_lens
from pgm_lab import calibration, datasets, frames
from pgm_lab.image import cut
from pgm_lab.io import files
from pgm_lab.rotation import angles, matrix

PIXEL = (0.001, 0.001)  # mm, nominal: nobody knows it, and c is stated in pixels
Turned = tuple[tuple[float, float, float], tuple[float, float, float]]
MOST = 1000  # columns of a photo
LEAST = 8  # photos
PLANE = cv2.SOLVEPNP_IPPE  # where points in a plane were seen from
PAD = 40  # pixels around a reduced photo, so that a search may reach over
SIZE = (640, 430)  # of the built-in pair
# Degrees by which its photos were turned, omega, phi, kappa: the answer of section 2
TURNED = ((0.9, -2.6, 2.4), (-1.1, 0.6, -1.9))
PRINCIPAL = (311.193, 254.877)  # px: of the left photo of "Motorcycle", unturned
ENDS = np.array([(153.5, 336.5), (572.9, 299.4)])  # px, there: a measured distance


# --- A board ---


def _blank() -> np.ndarray:
    """Where there is no photo, only pixels."""
    return np.zeros((1, 1))


@dataclass(frozen=True)
class Board:
    """A set of photos of one board, and where its inner corners lie in them."""

    name: str
    pixels: np.ndarray = field(repr=False)  # (photos, corners, 2), NaN: not seen
    size: tuple[int, int]  # columns and rows of a photo
    grid: np.ndarray = field(repr=False)  # (corners, 3), squares: as it was printed
    photo: np.ndarray = field(default_factory=_blank, repr=False)  # the first one, grey

    @cached_property
    def xy(self) -> np.ndarray:
        """Image points (photos, corners, 2), mm; NaN where none was measured."""
        xy, seen = np.full(self.pixels.shape, np.nan), np.isfinite(self.pixels[..., 0])
        xy[seen] = frames.pixel_to_photo(self.pixels[seen], self.size, PIXEL)
        return xy

    @cached_property
    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Camera (10,) and exteriors (photos, 6) to begin with, of a flat board."""
        seen = np.isfinite(self.pixels[..., 0])
        flat = [self.grid[k] for k in seen]
        pixels = (one[k] for one, k in zip(self.pixels, seen))
        c = calibration.start_c(flat, pixels, self.size) * PIXEL[0]
        K, photos = np.diag([c, c, 1]), []
        for points, xy in zip(flat, (one[k] for one, k in zip(self.xy, seen))):
            pair = points, xy * (1, -1)  # OpenCV: y down
            _, turns, shifts, off = cv2.solvePnPGeneric(*pair, K, None, flags=PLANE)
            if off[0] > 0.05 * self.size[0] * PIXEL[0]:
                raise ValueError(
                    "the grid does not fit the corners: are columns and rows exchanged?"
                )
            R = cv2.Rodrigues(turns[0])[0]
            M = R * np.array([[1], [-1], [-1]])
            photos.append([*(-R.T @ shifts[0]).ravel(), *angles(M)])
        return np.array([c, *np.zeros(9)]), np.array(photos)


def board(folder: str | Path | None = None) -> tuple[Board, Board]:
    """Two sets of photos that share none: of two cameras, or every other of a folder.

    Raises
    ------
    FileNotFoundError, ValueError
        If the folder lacks something, or fewer than eight photos show the board.
    """
    if folder is None:
        return _built_in("left"), _built_in("right")
    folder = Path(folder)
    printed = calibration.Board.read(folder / "board.json")
    paths = sorted((folder / "board").iterdir())
    found = [calibration.measure(path, printed) for path in paths]
    n = len(printed.points)
    sizes = [one.image_size for one in found if len(one.ids) > n / 2]
    usual = max(set(sizes), key=sizes.count, default=None)
    kept = [k for k, one in enumerate(found)
            if len(one.ids) > n / 2 and one.image_size == usual]  # fmt: skip
    for one in (one for k, one in enumerate(found) if k not in kept):
        print(f"{one.name} is left out: {one.words or 'half of the board is missing'}")
    if len(kept) < LEAST:
        raise ValueError(
            f"{len(kept)} of {len(found)} photos show the board, and at least {LEAST}"
            " of one size are needed"
        )
    photos = [_reduced(_seen(found[k], n), found[k].image_size) for k in kept]
    points, size = printed.points / printed.square, read(paths[kept[0]]).shape[::-1]
    odd, even = (
        Board(name, np.array(photos[k::2]), size, points, read(paths[kept[k]]))
        for k, name in enumerate(("odd photos", "even photos"))
    )
    return odd, even


def read(path: Path) -> np.ndarray:
    """Grey values of a photo as the sensor saw it, reduced to at most 1000 columns."""
    how = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION
    grey = cv2.imread(str(path), how)
    if grey is None:
        raise ValueError(f"{path.name} cannot be read as a photo: save it as JPEG")
    share = min(1.0, MOST / grey.shape[1])
    return cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)


def _reduced(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Where pixels of a photo of that size lie when `read` has reduced it."""
    return (pixels + 0.5) * min(1.0, MOST / size[0]) - 0.5


def _seen(found: calibration.Measured, n: int) -> np.ndarray:
    """Pixels (n, 2) of all corners of a board, NaN where one was not measured."""
    pixels = np.full((n, 2), np.nan)
    pixels[found.ids] = found.pixels
    return pixels


def corners(path: Path, columns: int, rows: int) -> np.ndarray:
    """Inner corners (n, 2) of a chequerboard in a photo, px; NaN where there is none.

    So were the corners in ``data/chequerboard_corners.csv`` measured.
    """
    printed = calibration.Board("chequerboard", columns + 1, rows + 1, 1.0)
    return _seen(calibration.measure(path, printed), columns * rows)


def grid(columns: int, rows: int) -> np.ndarray:
    """Corners as they are counted, row by row from the top; y points up."""
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    return np.stack([column, -row, 0 * row], axis=-1).reshape(-1, 3).astype(float)


def _built_in(side: str) -> Board:
    data = datasets.chequerboard(side)
    name, printed = f"{side} camera", grid(*data.corners)
    return Board(name, data.pixels, data.image_size, printed, read(data.photos[0]))


def given(folder: Path) -> tuple[Board, np.ndarray, np.ndarray]:
    """Photos of the task's board; points (16, 2) of its cupboard, left and right."""
    corners, cupboard = (
        np.loadtxt(folder / f"{name}.csv", delimiter=",", skiprows=1)
        for name in ("board", "cupboard")
    )
    pixels = corners[:, 2:].reshape(12, 48, 2)
    phone = Board("phone", pixels, (1200, 900), grid(8, 6))
    return phone, cupboard[:, 1:3], cupboard[:, 3:]


# --- Two photos ---


@dataclass(frozen=True)
class Pair:
    """Two photos without distortion, the principal point in the middle.

    Attributes
    ----------
    left, right : ndarray (rows, columns)
        Grey values.
    c : float
        Principal distance, mm, for pixels of 0.001 mm.
    ends : ndarray (2, 2)
        Pixels (column, row) of the left photo between which a distance was measured.
    distance : float
        That distance, m.
    depths : (float, float)
        Between which the scene lies, about; m.
    turned : two triples, optional
        By how much the built-in photos were turned; what follows from it is the truth.
    """

    left: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)
    c: float
    ends: np.ndarray
    distance: float
    depths: tuple[float, float]
    turned: Turned | None = field(default=None, repr=False)

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of a photo."""
        return self.left.shape[1], self.left.shape[0]

    @property
    def exterior(self) -> np.ndarray:
        """True orientation (6,) of the right photo where X0 is 1; NaN if unknown."""
        return exterior(self.turned) if self.turned else np.full(6, np.nan)

    def truth(self, pixels: np.ndarray) -> np.ndarray:
        """True points (n, 3) behind pixels of the left photo, in m; NaN if unknown."""
        if self.turned is None:
            return np.full((len(pixels), 3), np.nan)
        return truth(pixels, self.turned)


def pair(turned: Turned = TURNED) -> Pair:
    """Photos of a motorcycle, each turned about its perspective centre.

    `turned` has omega, phi and kappa of both photos, in degrees.
    """
    scene, M = _scene(), matrix(*np.radians(turned).T)
    left, right = (
        _resampled(grey, _from_photo(_pixels(SIZE), SIZE, R, k), SIZE)
        for k, (grey, R) in enumerate(zip((scene.left, scene.right), M))
    )
    ends = np.round(_to_photo(ENDS, SIZE, M[0])).astype(int)
    distance = float(np.linalg.norm(np.subtract(*truth(ends, turned))))
    c = scene.focal_length * PIXEL[0]
    return Pair(left, right, c, ends, round(distance, 3), (2.0, 5.2), turned)


def truth(pixels: np.ndarray, turned: Turned = TURNED) -> np.ndarray:
    """Points (n, 3) behind pixels of the left built-in photo, in its own frame, m.

    NaN where the benchmark does not know the disparity.
    """
    scene, M = _scene(), matrix(*np.radians(turned[0]))
    column, row = np.round(_from_photo(pixels, SIZE, M, 0)).astype(int).T
    rows, columns = scene.disparity.shape
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    disparity = np.full(len(pixels), np.nan)
    disparity[inside] = scene.disparity[row[inside], column[inside]]
    depth = scene.focal_length * scene.baseline / 1000 / (disparity + scene.doffs)
    rays = _rays(pixels, SIZE)
    return rays * (depth / -(rays @ M)[:, 2])[:, None]  # depth: before it was turned


def exterior(turned: Turned = TURNED) -> np.ndarray:
    """Relative orientation (6,) of the right built-in photo, where X0 is 1."""
    left, right = matrix(*np.radians(turned).T)
    base = left @ (1, 0, 0)
    return np.concatenate([base / base[0], angles(right @ left.T)])


def own_pair(
    folder: str | Path,
    camera: np.ndarray,
    ends: np.ndarray,
    distance: float,
    depths: tuple[float, float],
) -> Pair:
    """Two photos of one's own, ``left.*`` and ``right.*``, freed of their distortion.

    Parameters
    ----------
    folder : str or Path
    camera : array_like (10,)
        As `bundle` found it from photos of the same size.
    ends, distance, depths
        As of `Pair`; `ends` in whole pixels of the photos that `own_pair` returns.

    Raises
    ------
    FileNotFoundError
        If there is no left or no right photo.
    ValueError
        If an end lies outside the left photo.
    """
    both = []
    for name in ("left", "right"):
        there = sorted(Path(folder).glob(f"{name}.*"))
        if not there:
            raise FileNotFoundError(f"there is no {name}.jpg or the like in {folder}")
        grey = read(there[0])
        size = grey.shape[::-1]
        ideal = frames.pixel_to_photo(_pixels(size), size, PIXEL)
        pixels = frames.photo_to_pixel(measured(ideal, camera), size, PIXEL)
        both.append(_resampled(grey, pixels, size))
    left, right = both
    ends, size = np.round(ends).astype(int), left.shape[::-1]
    if np.any((ends < 0) | (ends >= size)):
        raise ValueError(
            f"ends: {ends.tolist()} do not lie in the left photo, which has {size[0]}"
            f" by {size[1]} pixels as it is read"
        )
    return Pair(left, right, float(camera[0]), ends, distance, depths)


def measured(ideal: np.ndarray, camera: np.ndarray) -> np.ndarray:
    """Photo coordinates (n, 2) that a lens gives ideal ones, mm: by iteration."""
    xy = ideal + camera[1:3]
    for _ in range(20):
        xy = xy + ideal - without_lens(xy, camera)
    return xy


def levels(scene: Pair) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Both photos with each 8 x 8 and each 2 x 2 pixels averaged, mirrored beyond."""

    def padded(image: np.ndarray, k: int) -> np.ndarray:
        return np.pad(smaller(image, k), PAD, "reflect")

    return {k: (padded(scene.left, k), padded(scene.right, k)) for k in (8, 2)}


def at(k: int, point: np.ndarray) -> np.ndarray:
    """Where a pixel (column, row) of the photo lies in those of `levels`."""
    return np.round((np.asarray(point) + 0.5) / k - 0.5).astype(int) + PAD


def places(image: np.ndarray, first: int, step: int = 10) -> np.ndarray:
    """Pixels (n, 2) of a grid from a column on, where a window has contrast."""
    rows, columns = image.shape
    every = _pixels((columns - 8, rows - 12)).reshape(rows - 12, columns - 8, 2)
    chosen = every[12::step, first::step].reshape(-1, 2)
    return chosen[[cut(image, pixel, 9).std() > 1 for pixel in chosen]]


def smaller(image: np.ndarray, k: int) -> np.ndarray:
    """The mean of each k x k pixels."""
    rows, columns = (n // k for n in image.shape)
    return image[: rows * k, : columns * k].reshape(rows, k, columns, k).mean((1, 3))


def matches(
    scene: Pair, points: list, correlation_map: Callable, match: Callable
) -> np.ndarray:
    """Left and right pixels (n, 4) of points, matched from coarse to fine.

    `correlation_map` searches photos of 8 x 8 and 2 x 2 pixels averaged, and `match`
    goes on with least squares. Points without texture, at an edge, or matched with a
    standard deviation of 0.1 px or more are left out.
    """
    small, half = levels(scene), 30

    def by_ncc(
        k: int, point: np.ndarray, shift: np.ndarray, side: int, reach: int
    ) -> np.ndarray:
        """Shift (column, row) with the highest r, to k pixels."""
        left, right = small[k]
        p, q = at(k, point), at(k, point + shift)
        template = cut(left, p, 2 * side + 1)
        r = correlation_map(template, cut(right, q, 2 * (side + reach) + 1))
        row, column = np.unravel_index(r.argmax(), r.shape)
        return k * (q - p + (column - reach, row - reach))

    found = []
    whole = by_ncc(8, np.divide(scene.size, 2), np.zeros(2), 14, 16)
    for point in np.asarray(points):
        try:
            shift = by_ncc(2, point, by_ncc(8, point, whole, 4, 6), 7, 5)
            right = cut(scene.right, point + shift, 2 * half + 1)
            trail, sigma0, Q = match(
                scene.left, right, point, [half, 1, 0, half, 0, 1, 0, 1], 21
            )
        except (ValueError, np.linalg.LinAlgError):
            continue  # at the edge, without texture, or no convergence
        if sigma0 * np.sqrt(max(Q[0, 0], Q[3, 3])) < 0.1:
            there = point + shift - half + trail[-1][[0, 3]]
            found.append([*point, *there])
    return np.array(found)


def scatter(places: np.ndarray, disparity: np.ndarray) -> float:
    """Standard deviation (px) of matches against the mean of their neighbours in a row.

    The places are 10 px apart, so that no two windows share a pixel.
    """
    d = dict(zip(map(tuple, places), disparity))
    sides = [[d.get((x + dx, y), np.nan) for dx in (-10, 10)] for x, y in d]
    gap = disparity - np.mean(sides, axis=1)
    return float(1.4826 * np.nanmedian(np.abs(gap)) / np.sqrt(1.5))


def ply(points: np.ndarray, grey: np.ndarray) -> str:
    """Text of a file of points that MeshLab, CloudCompare and Blender read."""
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"property uchar {name}" for name in ("red", "green", "blue")]
    rows = [
        "{:.4f} {:.4f} {:.4f}".format(*point) + f" {value:.0f}" * 3
        for point, value in zip(points, grey)
    ]
    return "\n".join([*head, "end_header", *rows]) + "\n"


def keep(name: str, text: str) -> None:
    """Write a file beside the reader's program; without one, say so."""
    if not Path(FILE).is_file():
        print(f"({name} is written where {FILE} is in the notebook's folder.)")
        return
    files.save({Path(name): text}, overwrite=True)
    print(f"Written: {name}.")


@cache
def _scene() -> datasets.StereoPair:
    return datasets.motorcycle()


def _pixels(size: tuple[int, int]) -> np.ndarray:
    return np.stack(np.meshgrid(*map(np.arange, size)), -1).reshape(-1, 2)


def _rays(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    xy = frames.pixel_to_photo(pixels, size, PIXEL)
    return np.insert(xy, 2, -_scene().focal_length * PIXEL[0], axis=1)


def _principal(k: int) -> np.ndarray:
    """Principal point of the left (0) or right (1) photo before it was turned, px."""
    return np.add(PRINCIPAL, (k * _scene().doffs, 0))


def _from_photo(
    pixels: np.ndarray, size: tuple[int, int], M: np.ndarray, k: int
) -> np.ndarray:
    """Where pixels of the turned photo lie in the one that was not."""
    U, V, W = (_rays(pixels, size) @ M).T
    f = _scene().focal_length
    return np.column_stack([-f * U / W, f * V / W]) + _principal(k)


def _to_photo(pixels: np.ndarray, size: tuple[int, int], M: np.ndarray) -> np.ndarray:
    """The reverse, for the left photo."""
    f = _scene().focal_length
    x, y = (np.subtract(pixels, _principal(0)) * (1, -1)).T
    U, V, W = M @ (x, y, np.full(len(x), -f))
    xy = np.column_stack([-f * U / W, -f * V / W]) * PIXEL
    return frames.photo_to_pixel(xy, size, PIXEL)


def _resampled(
    grey: np.ndarray, pixels: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    column, row = pixels.T
    values = map_coordinates(grey.astype(float), [row, column], order=3, mode="nearest")
    return np.clip(np.round(values), 0, 255).reshape(size[::-1])
