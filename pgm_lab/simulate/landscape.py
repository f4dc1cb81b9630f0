"""A real landscape with houses and trees on it, and every height known."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.simulate import _objects
from pgm_lab.simulate._cubic import cubic
from pgm_lab.simulate._light import lighten
from pgm_lab.simulate._objects import BUILDING, OPEN, TREE, WATER, Site
from pgm_lab.simulate._rays import bilinear
from pgm_lab.simulate._terrain import meadow, terrain
from pgm_lab.simulate.images import generator

__all__ = ["BUILDING", "OPEN", "TREE", "WATER", "ZONES", "Landscape", "landscape"]

ZONES = ("open", "mixed", "wood")
HOUSES = (0.6, 9.0, 0.3)  # a hectare of each zone
TREES = (3.0, 45.0, 330.0)
FIELD = (42.0, 26.0)  # m
HECTARE = 1e4
HOW = (cv2.INTER_LINEAR, cv2.INTER_NEAREST, cv2.INTER_CUBIC)


@dataclass(frozen=True, eq=False)
class Landscape:
    """Ground, and what stands on it, in cells of equal size.

    Attributes
    ----------
    grey : ndarray (rows, columns) of float32
        Grey values as seen from above, in the sun.
    dtm, dsm : ndarray (rows, columns) of float32
        Heights of the ground, and of what the sky sees, in m. Between the middles of
        cells both are bilinear, so the wall of a house is a ramp as wide as a cell.
    kind : ndarray (rows, columns) of uint8
        `OPEN`, `BUILDING`, `TREE` or `WATER`.
    corner : (X, Y)
        Middle of the cell in row 0 and column 0, in m; Y falls with the row.
    cell : float
        Side of a cell in m.
    borders : (X, X)
        Where open fields end and mixed ground begins, and where that ends and the wood
        begins, in m.
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
        """Values of a layer at object points.

        Parameters
        ----------
        layer : array_like (rows, columns)
            One of the layers, or another in the same cells.
        X, Y : array_like (...)
            Object coordinates in m; outside, the layer goes on as at its edge.
        how : int
            `cv2.INTER_LINEAR`, `cv2.INTER_NEAREST` or `cv2.INTER_CUBIC`.

        Returns
        -------
        ndarray (...)
        """
        layer = _validate.numeric(layer, "layer")
        if layer.shape != self.dsm.shape:
            raise ValueError(
                f"layer must have the shape of the landscape, {self.dsm.shape}; got"
                f" {layer.shape}"
            )
        X, Y = _validate.finite(X, "X"), _validate.finite(Y, "Y")
        if X.shape != Y.shape:
            raise ValueError(f"Y must have the shape of X, {X.shape}; got {Y.shape}")
        if _validate.whole(how, "how", 0) not in HOW:
            raise ValueError(f"how must be one of {HOW}, as cv2.INTER_...; got {how}")
        column = (X - self.corner[0]) / self.cell
        row = (self.corner[1] - Y) / self.cell
        if how == cv2.INTER_LINEAR:
            return bilinear(layer, row, column)
        if how == cv2.INTER_NEAREST:
            r = np.clip(np.rint(row), 0, layer.shape[0] - 1).astype(int)
            c = np.clip(np.rint(column), 0, layer.shape[1] - 1).astype(int)
            return layer[r, c]
        return cubic(layer, row, column)

    def zone(self, X: ArrayLike) -> np.ndarray:
        """Index (...) into `ZONES` of object coordinates X (...) in m."""
        return np.searchsorted(self.borders, _validate.finite(X, "X"), side="right")


def landscape(
    extent: tuple[float, float, float, float],
    *,
    cell: float = 0.15,
    relief: float = 40.0,
    buildings: int | None = None,
    trees: int | None = None,
    seed: int = 8,
    borders: tuple[float, float] | None = None,
    water: bool = False,
) -> Landscape:
    """Landscape with open fields, mixed ground and a wood, from west to east.

    Its hills have the shape of a real elevation model, its meadows the texture of a
    real orthophoto. Houses and trees stand on it, in the sun and with their shadows.

    Parameters
    ----------
    extent : (X least, Y least, X most, Y most)
        In m.
    cell : float
        Side of a cell in m, 0.05 to 1.
    relief : float
        Height of the highest ground above the lowest, in m.
    buildings, trees : int, optional
        How many are tried; some find no room. As many as suit the area when missing.
    seed : int
        Of all that is random: the same seed gives the same landscape.
    borders : (X, X), optional
        Where mixed ground and where the wood begin, in m; thirds of the extent when
        missing.
    water : bool
        A pond without texture in the open fields, 12 m to 30 m long.

    Returns
    -------
    Landscape

    Raises
    ------
    ValueError
        If a number is not as said, or the cells are more than 10^8.

    Notes
    -----
    Elevation model: the Jacksboro fault of matplotlib's sample data, whose posts are
    put 20 m apart and joined by a cubic spline. Ground: patches of
    `datasets.yellowstone` without trees, quilted.

    Examples
    --------
    >>> land = landscape((-30, -20, 30, 20), cell=0.5)
    >>> land.dsm.shape, f"{land.dtm.max():.0f} m", bool((land.dsm >= land.dtm).all())
    ((80, 120), '40 m', True)
    """
    west, south, east, north = _extent(extent)
    cell = _validate.positive_number(cell, "cell", "m")
    if not 0.05 <= cell <= 1:
        raise ValueError(f"cell must be from 0.05 m to 1 m; got {cell:g}")
    relief = _validate.not_negative(relief, "relief", "m")
    shape = int(np.ceil((north - south) / cell)), int(np.ceil((east - west) / cell))
    _validate.size("extent", *shape)
    ends = _borders(borders, west, east)
    houses, woods = _count(buildings, "buildings"), _count(trees, "trees")
    water = _validate.flag(water, "water")
    rng = generator(_validate.whole(seed, "seed", 0))
    X = west + cell * (np.arange(shape[1]) + 0.5)
    Y = north - cell * (np.arange(shape[0]) + 0.5)
    dtm = terrain(X, Y, relief)
    grey, none = meadow(shape, cell, rng), np.zeros(shape, np.uint8)
    site = Site(grey, dtm, dtm.copy(), none, cell, paved=none.astype(bool))
    _draw_fields(site, X, ends, rng)
    if water:
        radius = min(15.0, (north - south) / 8, max(6.0, (ends[0] - west) / 5))
        place = (0.62 * shape[0], ((west + ends[0]) / 2 - west) / cell)
        _objects.pond(site, *place, radius)
    angles = _draw_road(site, X, ends)
    for n, densities, kind in ((houses, HOUSES, BUILDING), (woods, TREES, TREE)):
        for row, column in _places(n, densities, X, Y, ends, rng):
            if kind == TREE:
                _objects.tree(site, row, column, rng)
            else:
                along = angles[int(column)] + rng.choice([0, np.pi / 2])
                _objects.house(site, row, column, along + rng.normal(0, 0.08), rng)
    grey = lighten(site.grey, site.dsm, cell)
    corner = (float(X[0]), float(Y[0]))
    return Landscape(grey, dtm, site.dsm, site.kind, corner, cell, ends)


def _extent(extent: tuple[float, float, float, float]) -> np.ndarray:
    box = _validate.of_shape(extent, (4,), "extent")
    if box[2] - box[0] < 2 or box[3] - box[1] < 2:
        raise ValueError(
            "extent must be (X least, Y least, X most, Y most), 2 m wide or more; got"
            f" {box.tolist()}"
        )
    return box


def _borders(
    borders: tuple[float, float] | None, west: float, east: float
) -> tuple[float, float]:
    if borders is None:
        return float(west + (east - west) / 3), float(east - (east - west) / 3)
    one, two = _validate.of_shape(borders, (2,), "borders")
    if one > two:
        raise ValueError(f"borders must rise from west to east; got {borders}")
    return float(one), float(two)


def _draw_fields(
    site: Site, X: np.ndarray, ends: tuple[float, float], rng: np.random.Generator
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
                size = (long - 1.2, wide - 1.2)
                _objects.field(site, row, column, angle, size, rng)


def _draw_road(site: Site, X: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """A road from west to east, a track along the border; angles (columns,) of it."""
    rows, columns = site.dtm.shape
    bend = min(18.0, 0.08 * rows * site.cell)
    x, r = X - X[0], np.arange(rows)
    winding = np.sin(x / 38 + 1) + 0.7 * np.sin(x / 91)
    slope = np.cos(x / 38 + 1) / 38 + 0.7 / 91 * np.cos(x / 91)
    row = 0.42 * rows + bend / site.cell * winding
    _objects.road(site, row, np.arange(columns), 5.0)
    track = ends[0] + 4 - X[0] + bend / 2 * np.sin(r * site.cell / 38)
    _objects.road(site, r, track / site.cell, 2.6)
    return np.arctan(bend * slope)


def _count(n: int | None, name: str) -> int | None:
    return None if n is None else _validate.whole(n, name, 0, 10**6)


def _places(
    n: int | None,
    densities: tuple[float, ...],
    X: np.ndarray,
    Y: np.ndarray,
    ends: tuple[float, float],
    rng: np.random.Generator,
) -> np.ndarray:
    """Rows and columns (n, 2): uniform in each zone, as dense as said."""
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
