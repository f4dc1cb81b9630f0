"""From the surface to the terrain: isolate what stands on it, bend a plate below."""

import math
import warnings
from dataclasses import dataclass, field

import cv2
import numpy as np
import scipy
from scipy.sparse.linalg import splu

from pgm_lab import _validate
from pgm_lab._robust import SD_OF_MAD
from pgm_lab.stereo.grid import Surface

# Layers of `Terrain.origin`
ORIGINS = ("ground", "interpolated under an object", "interpolated", "nothing")
GROUND, UNDER, BETWEEN, NOTHING = range(4)
MAX_ITERATIONS = 8  # of plate and residuals
FREE, RIM = 2, 4.0  # after so many, no new object within so many m of the border
# Shares of the measured cells: ground, far from it, and changed by the last plate
FEW, AWAY, MOVING = 0.1, 0.1, 0.003
STIFFNESS = 1.0  # of the plate: it smooths over about one of its cells
STIFF = 30.0  # of the first one, with objects still below it
PASSES = 4  # until the plate is right where little of its cells is known
BLOCK = 0.5  # m: openings see nothing smaller, or furrows stand out for them
HOUSE = 3.0  # m: the least height of one
HILL = 8.0  # m: the least radius of one; gables are smaller


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights of the ground.

    Attributes
    ----------
    z : ndarray (rows, columns)
        Heights in m; NaN where the surface has none.
    origin : ndarray (rows, columns) of uint8
        Index into `ORIGINS`: where each height comes from.
    corner, cell, crs
        As in `Surface`.
    """

    z: np.ndarray = field(repr=False)
    origin: np.ndarray = field(repr=False)
    corner: tuple[float, float]
    cell: float
    crs: str | None = field(default=None, repr=False)


def filter_terrain(
    dsm: Surface,
    *,
    slope: float = 0.3,
    widest: float = 40.0,
    least: float | None = None,
    most: float | None = None,
    margin: float = 1.0,
) -> Terrain:
    """DTM of a DSM: objects are isolated, and the ground is interpolated below them.

    A stiff plate takes the slope of the land away, and a morphological opening in
    growing windows finds what stands out: an object is lost to the opening all at once,
    a hill only little by little. So once more above what is left. Then a thin elastic
    plate is laid on the ground. What lies further than `least` from the plate is an
    object, what was taken for one and lies on the plate is ground again, as the top of
    a hill, and the next plate is laid, until nothing changes.

    Parameters
    ----------
    dsm : Surface
    slope : float
        Steepest ground beside the slope of the land, as the tangent of its
        inclination: an opening may lower the ground by this times the growth of the
        window, or by as much as a hill goes on that smaller windows have lowered.
    widest : float
        Side of the largest window in m, wider than any object.
    least : float, optional
        Height in m above the ground from which something is an object. When missing
        three times the standard deviation of a height, from second differences of
        neighbouring cells, and half a cell: so much does ground of 45 degrees rise from
        the middle of a cell to its edge. Smaller cells count in blocks of up to 0.5 m.
    most : float, optional
        Height in m by which an opening may lower the ground in any window. When missing
        3 m, the height of a low house, or twice `least` if that is more.
    margin : float
        In m: objects are widened by this, since matching smears their edges.

    Returns
    -------
    Terrain
        On the ground the heights of the surface, under objects those of the plate.

    Raises
    ------
    ValueError
        If the surface has too few cells on the ground to lay a plate on.

    Warns
    -----
    UserWarning
        If less than a tenth of the measured cells is ground, more than a tenth lies
        farther from all of it than `widest`, or plates still eat crests: a guess then.

    References
    ----------
    Zhang, K., Chen, S.-C., Whitman, D., Shyu, M.-L., Yan, J., Zhang, C. (2003): A
    progressive morphological filter for removing nonground measurements from airborne
    LIDAR data. IEEE Transactions on Geoscience and Remote Sensing 41(4), 872-882.

    Pingel, T. J., Clarke, K. C., McBride, W. A. (2013): An improved simple
    morphological filter for the terrain classification of airborne LIDAR data. ISPRS
    Journal of Photogrammetry and Remote Sensing 77, 21-30.

    Examples
    --------
    A house, 12 m by 12 m and 6 m high, on a slope of one to five:

    >>> X = np.arange(60.0)
    >>> ground = np.tile(0.2 * X, (60, 1))
    >>> z = ground.copy()
    >>> z[20:32, 20:32] += 6.0
    >>> dsm = Surface(z, (0.0, 59.0), 1.0, np.ones(z.shape, bool))
    >>> dtm = filter_terrain(dsm)
    >>> bool(np.abs(dtm.z - ground).max() < 0.01)
    True
    >>> ORIGINS[dtm.origin[25, 25]]
    'interpolated under an object'
    """
    _validate.instance(dsm, Surface, "dsm")
    slope = _validate.not_negative(slope, "slope", "as a tangent")
    widest = _validate.positive_number(widest, "widest", "in metres")
    margin = _validate.not_negative(margin, "margin", "in metres")
    if not np.isfinite(dsm.z).any():
        raise ValueError("the surface has no heights at all")
    z, known = dsm.z, np.isfinite(dsm.z) & dsm.measured
    block = max(1, int(BLOCK / dsm.cell + 1e-9))  # cells
    if least is None:
        least = 3 * _noise(z, known, block) + block * dsm.cell / 2
    least = _validate.positive_number(least, "least", "in metres")
    most = max(HOUSE, 2 * least) if most is None else most
    most = _validate.positive_number(most, "most", "in metres")

    # What openings lower at once is not ground: above the land, then above its ground
    ground, side = known, max(1, min(round(widest / 2 / dsm.cell), min(z.shape) // 4))
    for stiffness in (STIFF, STIFFNESS):
        land = _plate(z, ground, side, stiffness)
        height = _in_blocks(z - land, known, block)
        tall = _stands_out(height, block * dsm.cell, slope, widest, least, most)
        objects = np.kron(tall, np.ones((block, block), bool))[: len(z), : z.shape[1]]
        ground = known & ~_wider(objects, margin / dsm.cell)

    # Plates on the ground, until it changes no more. At the border of the surface they
    # bend less than hills: a hole there would grow
    rim = _wider(np.pad(np.isnan(z), 1, constant_values=True), RIM / dsm.cell)
    inside = ~rim[1:-1, 1:-1]
    for k in range(MAX_ITERATIONS):
        off = known & (np.abs(z - _plate(z, ground, 2 / dsm.cell)) > least)
        objects = off if k < FREE else off & (objects | inside)
        before, ground = ground, known & ~_wider(objects, margin / dsm.cell)
        moving = before != ground
        if np.mean(moving) < 1e-3:
            break
    _warn_of_a_guess(known, ground, moving, widest / dsm.cell)

    # Heights of the surface on the ground, of the plate elsewhere
    plate = _plate(z, ground, 1 / dsm.cell)
    missing = np.isnan(z)
    origin = np.select([missing, ground, known], [NOTHING, GROUND, UNDER], BETWEEN)
    terrain = np.where(missing, np.nan, np.where(ground, z, plate))
    return Terrain(terrain, origin.astype(np.uint8), dsm.corner, dsm.cell, dsm.crs)


def _warn_of_a_guess(
    known: np.ndarray, ground: np.ndarray, moving: np.ndarray, widest: float
) -> None:
    """Say it where most of the terrain rests on nothing that was measured."""
    # No cell of an object is farther from ground than its width; two cells for edges
    distance = cv2.distanceTransform((~ground).astype(np.uint8), cv2.DIST_L2, 5)
    share, away, changed = (
        np.mean(one[known]) for one in (ground, distance > widest + 2, moving)
    )
    if share < FEW or away > AWAY or changed > MOVING:
        warnings.warn(
            f"{share:.1%} of the measured cells are ground, and {away:.1%} lie farther"
            " than widest from all of it; the last plate still changed"
            f" {changed:.1%}: the terrain departs from what was measured. Is least too"
            " small for sharp crests, or for three times the standard deviation of the"
            " heights, slope for the hills, or widest for an object?",
            stacklevel=3,
        )


# --- Objects: openings in growing windows ---


def _noise(z: np.ndarray, known: np.ndarray, lag: int) -> float:
    """Standard deviation of a height, by the median of second differences."""
    z = np.where(known, z, np.nan)
    bends = np.concatenate(
        [(a[2 * lag :] - 2 * a[lag:-lag] + a[: -2 * lag]).ravel() for a in (z, z.T)]
    )
    bends = bends[np.isfinite(bends)]
    if not bends.size:
        return 0.0
    return float(SD_OF_MAD * np.median(np.abs(bends)) / np.sqrt(6))


def _stands_out(
    height: np.ndarray,
    cell: float,
    slope: float,
    widest: float,
    least: float,
    most: float,
) -> np.ndarray:
    """What openings in growing windows lower by more than a slope can explain."""
    top = np.where(np.isnan(height), np.nanmax(height), height).astype(np.float32)
    last, objects = top, np.isnan(height)
    largest = min(max(1, math.ceil(widest / 2 / cell)), max(last.shape))
    radius, before = 1, 0
    while before < largest:
        opened = _open(last, radius)
        # A hill goes on as steeply as it began, a round one up to twice
        lost = np.where(objects, 0, top - last - least)
        lost = cv2.dilate(lost, np.ones((2 * before + 1,) * 2, np.uint8))
        steep = np.maximum(slope, 2 * lost / max(HILL, before * cell))
        rise = least + steep * (radius - before) * cell
        objects |= last - opened > np.minimum(rise, most)
        # By an eighth, or what a slope may explain hides an object
        wider = min(max(radius + 1, radius * 9 // 8), largest)
        last, before, radius = opened, radius, wider
    return objects & ~np.isnan(height)


def _open(z: np.ndarray, radius: int) -> np.ndarray:
    """Grey opening with a square; the border is mirrored, so that slopes go on."""
    wide = np.pad(z, radius, mode="symmetric")
    square = np.ones((2 * radius + 1,) * 2, np.uint8)
    opened = cv2.morphologyEx(wide, cv2.MORPH_OPEN, square)
    return opened[radius:-radius, radius:-radius]


def _wider(mask: np.ndarray, cells: float) -> np.ndarray:
    """A mask, dilated by a disk."""
    radius = int(np.ceil(min(cells, max(mask.shape))))
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1,) * 2)
    return cv2.dilate(mask.astype(np.uint8), disk).astype(bool)


# --- Ground: a thin elastic plate on known heights spans what is between them ---


def _plate(
    z: np.ndarray, known: np.ndarray, cells: float, stiffness: float = STIFFNESS
) -> np.ndarray:
    """Heights of a plate on the known ones, as stiff as its cells of so many are."""
    # Equations for single cells take ten times as long as for two by two, as stiff
    cells = max(1.0, cells)
    side = max(2, round(cells))
    stiffness *= (cells / side) ** 4
    # It carries the mean of the known heights in each cell, by their number, and has
    # the least bending energy (thin plate spline).
    weight = _in_blocks(known.astype(float), np.ones_like(known), side)
    at = np.stack(np.nonzero(weight))
    if known.sum() < 10 or np.linalg.matrix_rank(at - at[:, :1]) < 2:
        raise ValueError(
            "too little of the surface is ground: all the rest stands out as objects."
            " Give a larger slope, least or most, or a smaller widest"
        )
    normal = scipy.sparse.diags(weight.ravel()) + stiffness * _bending(weight.shape)
    # Positive definite: without exchanges of rows the factors stay sparse
    symmetric = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    factors = splu(normal.tocsc(), permc_spec="MMD_AT_PLUS_A", **symmetric)
    # What is known in a cell may lie beside its middle: add what the plate leaves there
    plate = np.full(weight.shape, z[known].mean())
    wide = np.full(z.shape, plate[0, 0])
    for _ in range(PASSES):
        left = np.nan_to_num(_in_blocks(z - wide, known, side))
        plate = factors.solve((weight * (plate + left)).ravel()).reshape(weight.shape)
        # To cells of the surface, smoothly; the rim goes on as it came
        rim = np.pad(plate, 2, mode="reflect", reflect_type="odd")
        wide = cv2.resize(rim, None, fx=side, fy=side, interpolation=cv2.INTER_LINEAR)
        wide = cv2.blur(wide, (side | 1,) * 2)[2 * side :, 2 * side :]
        wide = wide[: len(z), : z.shape[1]]
    return wide


def _in_blocks(z: np.ndarray, known: np.ndarray, side: int) -> np.ndarray:
    """Mean of the known heights in blocks of side by side cells, else NaN."""
    n = _sum(known.astype(float), side)
    return _sum(np.where(known, z, 0.0), side) / np.where(n > 0, n, np.nan)


def _sum(values: np.ndarray, side: int) -> np.ndarray:
    """Sums over cells of side by side, the last ones filled up with zeros."""
    rows, columns = (-n % side for n in values.shape)
    filled = np.pad(values, ((0, rows), (0, columns)))
    wide = filled.shape[1] // side
    return filled.reshape(-1, side, wide, side).sum((1, 3))


def _bending(shape: tuple[int, int]) -> "scipy.sparse.csr_matrix":
    """Energy of a plate: squares of its second differences, xx + 2 xy + yy."""
    (y, yy), (x, xx) = ([d.T @ d for d in _differences(n)] for n in shape)
    return scipy.sparse.kronsum(xx, yy) + 2 * scipy.sparse.kron(y, x)


def _differences(n: int) -> "list[scipy.sparse.spmatrix]":
    """First and second differences of n values, as matrices."""
    rows = max(n - 1, 0), max(n - 2, 0)
    weights = [-1.0, 1.0], [1.0, -2.0, 1.0]
    return [
        scipy.sparse.diags(w, range(len(w)), shape=(m, n))
        for w, m in zip(weights, rows)
    ]
