"""A real landscape with houses and trees on it, and every height known.

Means are in double precision: those in single precision differ from one version of
numpy to the next, and a photo with them.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, datasets
from pgm_lab.image.resampling import cubic_weights

OPEN, BUILDING, TREE = 0, 1, 2
ZONES = ("open", "mixed", "wood")

# Which objects stand where
HOUSES = (0.6, 9.0, 0.3)  # a hectare of each zone
TREES = (3.0, 45.0, 330.0)
FIELD = (42.0, 26.0)  # m
HECTARE = 1e4

# Relief and meadow
POST = 20.0  # m between two heights of the elevation model, which has 90 m in nature
HILLS = (170.0, 150.0)  # row and column of the model in the middle of the landscape
PATCH = 19.0  # m, side of a patch of meadow
SHADE = 85  # grey value below which the orthophoto shows a shadow or a dark crown
GRAIN = 512  # cells, side of the random field that roofs and crowns take theirs from

# Light
AZIMUTH, ELEVATION = np.radians(235.0), np.radians(48.0)  # of the sun
SKY = 0.5  # share of the light that comes from the whole sky, on level ground
TALLEST = 25.0  # m, no shadow is longer than that of a tree so tall
BAND = 256  # rows at a time


@dataclass(frozen=True, eq=False)
class Landscape:
    """Ground, and what stands on it, in cells of equal size.

    Attributes
    ----------
    grey : ndarray (rows, columns) of float32
        Grey values as seen from above, in the sun.
    dtm, dsm : ndarray (rows, columns) of float32
        Heights of the ground, and of the surface seen from above, in m; bilinear
        between cell centres, so the wall of a house is a ramp as wide as a cell.
    kind : ndarray (rows, columns) of uint8
        `OPEN`, `BUILDING` or `TREE`.
    corner : (X, Y)
        Centre of the cell in row 0 and column 0, in m; Y decreases with the row.
    cell : float
        Side of a cell in m.
    borders : (X, X)
        Where mixed ground and where the wood begin, in m.
    """

    grey: np.ndarray = field(repr=False)
    dtm: np.ndarray = field(repr=False)
    dsm: np.ndarray = field(repr=False)
    kind: np.ndarray = field(repr=False)
    corner: tuple[float, float]
    cell: float
    borders: tuple[float, float] = (-np.inf, np.inf)

    def at(
        self, layer: ArrayLike, X: ArrayLike, Y: ArrayLike, how: int = cv2.INTER_LINEAR
    ) -> np.ndarray:
        """Values (...) of a layer at object points; outside, as at its edge.

        Parameters
        ----------
        layer : array_like (rows, columns)
            One of the layers, or another in the same cells.
        X, Y : array_like (...)
            Object coordinates in m.
        how : int
            `cv2.INTER_LINEAR`, `cv2.INTER_NEAREST` or `cv2.INTER_CUBIC`.
        """
        layer = np.asarray(layer)
        column = (np.asarray(X, dtype=float) - self.corner[0]) / self.cell
        row = (self.corner[1] - np.asarray(Y, dtype=float)) / self.cell
        if how == cv2.INTER_NEAREST:
            r = np.clip(np.rint(row), 0, layer.shape[0] - 1).astype(int)
            c = np.clip(np.rint(column), 0, layer.shape[1] - 1).astype(int)
            return layer[r, c]
        return (cubic if how == cv2.INTER_CUBIC else bilinear)(layer, row, column)

    def zone(self, X: ArrayLike) -> np.ndarray:
        """Index (...) into `ZONES` of object coordinates X (...) in m."""
        return np.searchsorted(self.borders, X, side="right")


def landscape(
    extent: tuple[float, float, float, float],
    *,
    cell: float = 0.15,
    relief: float = 40.0,
    buildings: int | None = None,
    trees: int | None = None,
    seed: int = 8,
    borders: tuple[float, float] | None = None,
) -> Landscape:
    """Landscape with open fields, mixed ground and a wood, from west to east.

    Hills from a real elevation model, meadows with the texture of a real orthophoto,
    houses and trees in the sun, with their shadows.

    Parameters
    ----------
    extent : (X least, Y least, X most, Y most)
        In m.
    cell : float
        Side of a cell in m, 0.05 to 1.
    relief : float
        Height of the highest ground above the lowest, in m.
    buildings, trees : int, optional
        Number tried; some find no space. Default: as many as suit the area.
    seed : int
        Seed of the random numbers: the same seed gives the same landscape.
    borders : (X, X), optional
        Where mixed ground and where the wood begin, in m; default: thirds of the
        extent.

    Notes
    -----
    Elevation model: the Jacksboro fault (``data/README.md``), its posts put 20 m apart.
    Ground: `datasets.yellowstone`, without trees.

    Examples
    --------
    >>> land = landscape((-30, -20, 30, 20), cell=0.5)
    >>> land.dsm.shape, f"{land.dtm.max():.0f} m", bool((land.dsm >= land.dtm).all())
    ((80, 120), '40 m', True)
    """
    west, south, east, north = np.asarray(extent, dtype=float)
    shape = int(np.ceil((north - south) / cell)), int(np.ceil((east - west) / cell))
    _validate.size("extent", *shape)
    third = (east - west) / 3
    first, second = borders or (west + third, east - third)
    ends = float(first), float(second)
    rng = np.random.default_rng(seed)
    X = west + cell * (np.arange(shape[1]) + 0.5)
    Y = north - cell * (np.arange(shape[0]) + 0.5)

    # The ground: relief, meadow, fields and roads
    dtm = _terrain(X, Y, relief)
    grey, none = _meadow(shape, cell, rng), np.zeros(shape, np.uint8)
    site = _Site(grey, dtm, dtm.copy(), none, cell, paved=none.astype(bool))
    _draw_fields(site, X, ends, rng)
    angles = _draw_roads(site, X, ends)

    # The objects on it
    for row, column in _places(buildings, HOUSES, X, Y, ends, rng):
        along = angles[int(column)] + rng.choice([0, np.pi / 2])
        _build_house(site, row, column, along + rng.normal(0, 0.08), rng)
    for row, column in _places(trees, TREES, X, Y, ends, rng):
        _plant_tree(site, row, column, rng)

    grey = _lighten(site.grey, site.dsm, cell)
    corner = (float(X[0]), float(Y[0]))
    return Landscape(grey, dtm, site.dsm, site.kind, corner, float(cell), ends)


def _places(
    n: int | None,
    densities: tuple[float, ...],
    X: np.ndarray,
    Y: np.ndarray,
    ends: tuple[float, float],
    rng: np.random.Generator,
) -> np.ndarray:
    """Random positions (n, 2), row and column: uniform in a zone, with its density."""
    edges = np.clip([X[0], *ends, X[-1]], X[0], X[-1])
    expected = np.array(densities) * np.diff(edges) * (Y[0] - Y[-1]) / HECTARE
    if n is None:
        n = round(expected.sum())
    if n == 0 or expected.sum() == 0:
        return np.empty((0, 2))
    zone = rng.choice(3, n, p=expected / expected.sum())
    x = edges[zone] + rng.random(n) * np.diff(edges)[zone]
    cell = X[1] - X[0]
    return np.stack([rng.random(n) * (len(Y) - 1), (x - X[0]) / cell], -1)


# --- Relief and meadow ---


def _terrain(X: np.ndarray, Y: np.ndarray, relief: float) -> np.ndarray:
    """Heights (rows, columns) in m, from 0 to `relief`, at columns X and rows Y."""
    # A cubic spline: neither slope nor curvature jumps at the posts of the elevation
    # model, which is mirrored beyond its edge
    if relief == 0:
        return np.zeros((len(Y), len(X)), np.float32)
    with np.load(datasets.path("jacksboro_fault_dem.npz")) as data:
        posts = cv2.GaussianBlur(data["elevation"].astype(np.float32), (0, 0), 1.0)
    row = HILLS[0] - (Y - Y.mean()) / POST
    column = HILLS[1] + (X - X.mean()) / POST
    rows, columns = (
        np.arange(np.floor(i.min()) - 3, np.ceil(i.max()) + 4) for i in (row, column)
    )
    near = posts[np.ix_(_mirrored(rows, len(posts)), _mirrored(columns, len(posts.T)))]
    spline = scipy.interpolate.RectBivariateSpline(rows, columns, near)
    z = spline(row, column).astype(np.float32)
    z -= z.min()
    z *= np.float32(relief) / z.max()
    return z


def _mirrored(index: np.ndarray, n: int) -> np.ndarray:
    return n - 1 - np.abs(index.astype(int) % (2 * n - 2) - (n - 1))


def _meadow(
    shape: tuple[int, int], cell: float, rng: np.random.Generator
) -> np.ndarray:
    """Grey values (rows, columns) of open ground: quilted patches of the orthophoto."""
    # The patches, rotated and mirrored, overlap by a third. Where they meet, the
    # weighted sum is divided by the root of the sum of squared weights: divided by the
    # sum of weights it would lose contrast.
    # The orthophoto in cells of the landscape, each the mean of the pixels it covers
    ortho = datasets.yellowstone()
    n = round(len(ortho.grey) * ortho.gsd / cell)
    how = cv2.INTER_AREA if cell >= ortho.gsd else cv2.INTER_CUBIC
    tile = cv2.resize(ortho.grey.astype(np.float32), (n, n), interpolation=how)
    side = min(round(PATCH / cell), n // 2)
    places = _open_places(tile, side)

    # Quilt the patches
    step = side * 2 // 3
    ramp = np.minimum(1, (np.arange(side) + 0.5) / (side - step))
    w = np.outer(*[np.minimum(ramp, ramp[::-1])] * 2).astype(np.float32)
    total = np.zeros((shape[0] + 2 * side, shape[1] + 2 * side), np.float32)
    weight = np.zeros_like(total)
    for r in range(0, shape[0] + side, step):
        for c in range(0, shape[1] + side, step):
            i, j = places[rng.integers(len(places))]
            patch = np.rot90(tile[i : i + side, j : j + side], int(rng.integers(4)))
            if rng.integers(2):
                patch = patch[:, ::-1]
            total[r : r + side, c : c + side] += w * (patch - patch.mean(dtype=float))
            weight[r : r + side, c : c + side] += w**2
    here = np.s_[side // 2 : side // 2 + shape[0], side // 2 : side // 2 + shape[1]]
    grey = total[here] / np.sqrt(weight[here])
    grey += 138 + 9 * _clouds(shape, 35 / cell, rng) + 5 * _clouds(shape, 8 / cell, rng)
    return grey


def _open_places(tile: np.ndarray, side: int) -> np.ndarray:
    """Rows and columns where a square without trees and shadows begins."""
    smooth = cv2.GaussianBlur(tile, (0, 0), max(0.5, 1.5 * len(tile) / 1024))
    total = cv2.integral((smooth < SHADE).astype(np.float32))
    dark = total[side:, side:] - total[:-side, side:]
    dark += total[:-side, :-side] - total[side:, :-side]
    return np.argwhere(dark <= 0.004 * side**2)


def _clouds(
    shape: tuple[int, int], size: float, rng: np.random.Generator
) -> np.ndarray:
    """Smooth random field (rows, columns), sd about 1, with waves of `size` cells."""
    rows, columns = (int(n / size) + 4 for n in shape)
    coarse = rng.standard_normal((rows, columns)).astype(np.float32)
    down, across = (
        _cubic_matrix(1 + np.arange(n) / size, m) for n, m in zip(shape, coarse.shape)
    )
    return 1.4 * (down @ coarse @ across.T).astype(np.float32)


# --- What stands on the ground or is drawn on it, each in its own small window ---


def grain(sigma: float) -> np.ndarray:
    """Periodic random field (rows, columns), sd 1, smooth over `sigma` cells."""
    white = np.random.default_rng(0).standard_normal((GRAIN, GRAIN), np.float32)
    around = np.pad(white, 16, mode="wrap")
    smooth = cv2.GaussianBlur(around, (0, 0), sigma)[16:-16, 16:-16]
    return smooth / np.float32(smooth.std(dtype=float))


@dataclass(frozen=True, eq=False)
class _Site:
    """Layers of a landscape while it is built; see `Landscape`."""

    grey: np.ndarray
    dtm: np.ndarray
    dsm: np.ndarray
    kind: np.ndarray
    cell: float
    paved: np.ndarray
    fine: np.ndarray = field(default_factory=lambda: grain(0.8))
    coarse: np.ndarray = field(default_factory=lambda: grain(2.5))

    def window(self, row: float, column: float, reach: float) -> tuple[slice, slice]:
        """Window of `reach` cells around a position, as far as it is inside."""
        rows, columns = self.dtm.shape
        a, b = max(0, int(row - reach)), min(rows, int(row + reach) + 2)
        c, d = max(0, int(column - reach)), min(columns, int(column + reach) + 2)
        return slice(a, max(a, b)), slice(c, max(c, d))

    def axes(
        self, window: tuple[slice, slice], row: float, column: float, angle: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (u along, v across) in m of the cells of a window."""
        r = np.arange(window[0].start, window[0].stop, dtype=np.float32) - row
        c = np.arange(window[1].start, window[1].stop, dtype=np.float32) - column
        r, c = r * self.cell, c * self.cell
        sin, cos = np.sin(angle), np.cos(angle)
        return c * cos + r[:, None] * sin, r[:, None] * cos - c * sin

    def rough(
        self, window: tuple[slice, slice], rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Random fields for a window, of fine and of coarse grain, sd 1."""
        n, m = (s.stop - s.start for s in window)
        r, c = rng.integers(GRAIN - n + 1), rng.integers(GRAIN - m + 1)
        return self.fine[r : r + n, c : c + m], self.coarse[r : r + n, c : c + m]


def _draw_fields(
    site: _Site, X: np.ndarray, ends: tuple[float, float], rng: np.random.Generator
) -> None:
    """Fields where it is open; the floor of the wood is dark."""
    wood = np.clip((X - ends[1]) / 12 + 0.5, 0, 1).astype(np.float32)
    site.grey[:] -= 30 * wood
    rows, columns = site.dtm.shape
    angle, cell = 0.25, site.cell
    long, wide = FIELD
    reach = int(np.hypot(rows, columns) * cell / min(FIELD) / 2) + 2
    for i in range(-reach, reach + 1):
        shift = rng.uniform(0, long)
        for j in range(-reach, reach + 1):
            u, v = j * long + shift, i * wide
            column = columns / 2 + (u * np.cos(angle) - v * np.sin(angle)) / cell
            row = rows / 2 + (u * np.sin(angle) + v * np.cos(angle)) / cell
            if X[0] + column * cell < ends[0] and rng.random() < 0.9:
                _draw_field(site, row, column, angle, (long - 1.2, wide - 1.2), rng)


def _draw_field(
    site: _Site,
    row: float,
    column: float,
    angle: float,
    size: tuple[float, float],
    rng: np.random.Generator,
) -> None:
    """A field: another tone, more or less of the meadow's texture, perhaps furrows."""
    window = site.window(row, column, np.hypot(*size) / 2 / site.cell)
    u, v = site.axes(window, row, column, angle)
    within = (np.abs(u) < size[0] / 2) & (np.abs(v) < size[1] / 2)
    if not within.any():
        return
    grey = site.grey[window]
    texture = grey[within] - grey[within].mean(dtype=float)
    tone, keep = rng.uniform(95, 172), rng.uniform(0.5, 1.1)
    furrows = rng.choice([0.0, 4.0, 8.0]) * np.sin(
        2 * np.pi / rng.uniform(1.2, 3.0) * v[within] + rng.uniform(0, 6)
    )
    grey[within] = tone + keep * texture + furrows


def _draw_roads(site: _Site, X: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """A road from west to east, a track along the border; angles (columns,) of it."""
    rows, columns = site.dtm.shape
    bend = min(18.0, 0.08 * rows * site.cell)
    x, r = X - X[0], np.arange(rows)
    winding = np.sin(x / 38 + 1) + 0.7 * np.sin(x / 91)
    slope = np.cos(x / 38 + 1) / 38 + 0.7 / 91 * np.cos(x / 91)
    row = 0.42 * rows + bend / site.cell * winding
    _draw_road(site, row, np.arange(columns), 5.0)
    track = ends[0] + 4 - X[0] + bend / 2 * np.sin(r * site.cell / 38)
    _draw_road(site, r, track / site.cell, 2.6)
    return np.arctan(bend * slope)


def _draw_road(site: _Site, row: np.ndarray, column: np.ndarray, width: float) -> None:
    """A road along points, brighter than the ground, with little texture."""
    line = np.round(np.stack([column, row], -1) * 16).astype(np.int32)
    mask = np.zeros(site.dtm.shape, np.uint8)
    thick = max(1, round(width / site.cell))
    cv2.polylines(mask, [line], False, 255, thick, cv2.LINE_AA, 4)
    on = mask > 0
    site.paved[on] = True
    share = mask[on] / np.float32(255)
    site.grey[on] = (1 - share) * site.grey[on] + share * (
        182 + 0.3 * (site.grey[on] - 138)
    )


def _build_house(
    site: _Site, row: float, column: float, angle: float, rng: np.random.Generator
) -> None:
    """A house with a gable roof or a flat one, unless something is there."""
    flat = rng.random() < 0.3
    length, width = (
        (rng.uniform(14, 28), rng.uniform(10, 16))
        if flat
        else (rng.uniform(9, 17), rng.uniform(7, 10.5))
    )
    window = site.window(row, column, (np.hypot(length, width) / 2 + 2) / site.cell)
    u, v = site.axes(window, row, column, angle)
    around = (np.abs(u) < length / 2 + 1.5) & (np.abs(v) < width / 2 + 1.5)
    on = (np.abs(u) < length / 2) & (np.abs(v) < width / 2)
    taken = site.paved[window] | (site.kind[window] != OPEN)
    if not on.any() or taken[around].any():
        return
    ground = site.dtm[window][on]
    eaves = max(ground.mean(dtype=float) + rng.uniform(3.5, 7.5), ground.max() + 2.5)
    slope = 0.0 if flat else rng.uniform(0.4, 0.8)
    site.dsm[window][on] = eaves + slope * (width / 2 - np.abs(v[on]))
    site.kind[window][on] = BUILDING
    tone = rng.uniform(120, 205) if flat else rng.uniform(80, 165)
    tiles = 0.0 if flat else 4 * np.sin(2 * np.pi * v[on] / 0.9)
    fine, coarse = site.rough(window, rng)
    site.grey[window][on] = tone + 6 * fine[on] + 6 * coarse[on] + tiles


def _plant_tree(
    site: _Site, row: float, column: float, rng: np.random.Generator
) -> None:
    """A tree with a round crown, unless a house or a road is there."""
    here = int(row), int(column)
    if site.paved[here] or site.kind[here] == BUILDING:
        return
    height = rng.uniform(5, 16)
    radius = (0.6 + 0.17 * height) * rng.uniform(0.8, 1.2)
    round_, tone = rng.uniform(0.4, 0.9), rng.uniform(80, 135)
    window = site.window(row, column, radius / site.cell)
    u, v = site.axes(window, row, column, 0.0)
    fine, coarse = site.rough(window, rng)
    q = (u**2 + v**2) / radius**2 * (1 + 0.15 * coarse)
    crown = site.dtm[here] + height * (0.45 + 0.55 * np.maximum(0, 1 - q) ** round_)
    crown += 0.25 * coarse + 0.08 * fine
    free = site.kind[window] != BUILDING
    on = (q < 1) & free & (crown > np.maximum(site.dsm[window], site.dtm[window] + 0.5))
    site.dsm[window][on] = crown[on]
    site.kind[window][on] = TREE
    site.grey[window][on] = tone + 11 * fine[on] + 6 * coarse[on]


# --- Light: slopes that face the sun are bright, and objects cast shadows ---


def _lighten(albedo: np.ndarray, dsm: np.ndarray, cell: float) -> np.ndarray:
    """Grey values (rows, columns) under the sun; level ground in it is unchanged."""
    shadow = _shadow(dsm, cell)
    east, north, up = (
        np.cos(ELEVATION) * np.sin(AZIMUTH),
        np.cos(ELEVATION) * np.cos(AZIMUTH),
        np.sin(ELEVATION),
    )
    grey = np.empty_like(albedo)
    for a in range(0, len(dsm), BAND):
        b = min(a + BAND, len(dsm))
        first = max(0, a - 1)
        z = dsm[first : b + 1]
        down, right = np.gradient(z, cell)
        inner = np.s_[a - first : a - first + b - a]
        p, q = np.clip(right[inner], -1.5, 1.5), np.clip(-down[inner], -1.5, 1.5)
        towards = (up - p * east - q * north) / (up * np.sqrt(1 + p**2 + q**2))
        lit = 1 - np.clip((shadow[a:b] - dsm[a:b]) / 0.6, 0, 1)
        light = SKY + (1 - SKY) * lit * np.clip(towards, 0, 1.3)
        grey[a:b] = np.clip(albedo[a:b] * light, 12, 238)
    return grey


def _shadow(dsm: np.ndarray, cell: float) -> np.ndarray:
    """Height below which the sun does not reach, at each cell."""
    # The highest shadow over distances up to 2^n cells is that up to 2^(n-1), and the
    # same from 2^(n-1) cells further on
    height = dsm.copy()
    drop = np.tan(ELEVATION) * cell
    rows, columns = dsm.shape
    length = 1
    while length * drop < TALLEST:
        dc = round(-length * np.sin(AZIMUTH))  # away from the sun
        dr = round(length * np.cos(AZIMUTH))
        if abs(dr) >= rows or abs(dc) >= columns:
            break
        to_r, from_r = _moved(dr, rows)
        to_c, from_c = _moved(dc, columns)
        lower = height[from_r, from_c] - np.float32(length * drop)
        np.maximum(height[to_r, to_c], lower, out=height[to_r, to_c])
        length *= 2
    return height


def _moved(by: int, n: int) -> tuple[slice, slice]:
    """Slices to and from: where n values land that move `by` cells, and which do."""
    return slice(max(0, by), n + min(0, by)), slice(max(0, -by), n - max(0, by))


# --- Between the cells ---


def bilinear(layer: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values at (row, column) of cells, without rounding them; the edge is repeated."""
    rows, columns = layer.shape
    row = np.clip(row, 0, rows - 1)
    column = np.clip(column, 0, columns - 1)
    r = np.minimum(row.astype(np.intp), max(rows - 2, 0))
    c = np.minimum(column.astype(np.intp), max(columns - 2, 0))
    down, right = row - r, column - c
    first = r * columns + c
    flat = layer.ravel()
    below = first + columns * (rows > 1)
    beside = int(columns > 1)
    upper = flat[first] * (1 - right) + flat[first + beside] * right
    lower = flat[below] * (1 - right) + flat[below + beside] * right
    return upper * (1 - down) + lower * down


def cubic(layer: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values at (row, column) of cells by cubic convolution; the edge is repeated.

    As OpenCV 5 does it (a = -0.75); older ones round to a 32nd of a pixel.
    """
    rows, columns = layer.shape
    flat = np.pad(layer, 2, mode="edge").ravel()
    i, down = cubic_weights(np.clip(row, -0.999, rows - 0.001), a=-0.75)
    j, across = cubic_weights(np.clip(column, -0.999, columns - 0.001), a=-0.75)
    first = (i + 2) * (columns + 4) + j + 2
    out = np.zeros(row.shape, np.float32)
    for k, weight in enumerate(down):
        at = first + k * (columns + 4)
        out += weight * sum(w * flat[at + m] for m, w in enumerate(across))
    return out


def _cubic_matrix(x: np.ndarray, n: int) -> np.ndarray:
    """Weights (positions, n) of n values at positions inside, from 1 to n - 2."""
    first, weights = cubic_weights(x, a=-0.75)
    out = np.zeros((len(x), n))
    for k, w in enumerate(weights):
        out[np.arange(len(x)), first + k] = w
    return out
