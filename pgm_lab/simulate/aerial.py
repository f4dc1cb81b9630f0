"""Aerial photos of a landscape, ray-cast through the collinearity equations."""

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from pgm_lab.camera import Camera, Photo, imaging
from pgm_lab.simulate.landscape import TREE, Landscape, bilinear, grain, landscape

# Harintaka (2020): f 24 mm, 1000 m above ground; a Nikon D2X has 4288 x 2848 pixels
CAMERA = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
SENSOR, PIXEL = (4288, 2848), 5.49e-3
HEIGHT = 1000.0
GSD = HEIGHT / CAMERA.c * PIXEL

# Photos
OPTICS = 0.4, 0.35  # px, sd of the blur of the ground, and of the photo
BAND = 48  # rows of a photo at a time
IN_FRONT = 0.5  # m, what is higher than a point by this hides it
LEVEL = 0.15  # m, neighbours no higher than that do not
SAME = 0.05  # m, a ray that meets the surface so near to a point shows it

# Rays
BLOCKS = (32, 8, 2)  # cells: rays go down by blocks as long as they are above all
STEEP = 0.6  # m, the step down for each cell of rays that hardly move sideways
CLOSE = 1e-4  # m between a ray and the surface where they meet
MAX_ITERATIONS = 60  # a halving every third one brings a metre far below CLOSE


@dataclass(frozen=True, eq=False)
class AerialPair:
    """Two photos of a landscape, with the truth.

    Attributes
    ----------
    left, right : Photo
    landscape : Landscape
    ground : tuple of two ndarray (rows, columns, 3)
        Object point that each pixel of left and right shows, in m: where its ray first
        meets the bilinear DSM.
    hidden : tuple of two ndarray (rows, columns) of bool
        Pixels whose point the other photo does not show: occluded, or outside.
    """

    left: Photo
    right: Photo
    landscape: Landscape = field(repr=False)
    ground: tuple[np.ndarray, np.ndarray] = field(repr=False)
    hidden: tuple[np.ndarray, np.ndarray] = field(repr=False)


def aerial_pair(
    part: tuple[int, int] = (900, 650),
    *,
    overlap: float = 0.6,
    sigma: float = 2.0,
    seed: int = 8,
    relief: float = 40.0,
    cell: float = 0.15,
    buildings: int | None = None,
    trees: int | None = None,
    camera: Camera = CAMERA,
) -> AerialPair:
    """Two photos flown as in Harintaka (2020), or the same part of both.

    The camera (f 24 mm, 4288 x 2848 pixels of 5.49 um, the lens of a non-metric
    camera) flies 1000 m above the ground, so that a pixel is 0.229 m there, with small
    tilts.

    Parameters
    ----------
    part : (columns, rows)
        Part of the sensor, in pixels, around the middle of the overlap; (4288, 2848) is
        the whole sensor. The base is that of whole photos.
    overlap : float
        Overlap of two whole photos, 0.5 or more and below 1.
    sigma : float
        Standard deviation of the noise, in grey values.
    seed : int
        Seed of landscape and noise.
    relief, cell, buildings, trees
        As in `landscape`. Open fields, mixed ground and wood are the thirds, from west
        to east, of the ground that both photos show.
    camera : Camera
        Another lens, or none.

    Examples
    --------
    >>> pair = aerial_pair((120, 80))
    >>> pair.left.grey.shape, pair.ground[0].shape
    ((80, 120), (80, 120, 3))
    """
    # Both photos, around the ground in the middle
    base = (1 - overlap) * SENSOR[0] * GSD
    stations = [(-base / 2, 0, HEIGHT + 20), (base / 2, 3, HEIGHT + 24)]
    tilts = np.radians([(0.8, -1.1, 2.0), (-0.6, 0.9, -1.5)])
    frames = []
    for station, tilt in zip(stations, tilts):
        whole = _frame(camera, np.array([*station, *tilt]), (0, 0))
        middle = whole.project(np.array([0.0, 0.0, relief / 2]))
        corner = np.round(middle - np.array(part) / 2).astype(int)
        column, row = np.clip(corner, 0, np.array(SENSOR) - part)
        frames.append(dataclasses.replace(whole, corner=(column, row)))

    # The landscape, its thirds those of the ground in both photos
    seen = np.array([_footprint(frame, part, relief / 2) for frame in frames])
    west, east = seen[:, 0].max(), seen[:, 2].min()
    third = (east - west) / 3
    land = landscape(
        _extent(frames, part),
        cell=cell,
        relief=relief,
        buildings=buildings,
        trees=trees,
        seed=seed,
        borders=(west + third, east - third),
    )
    surface = Surface(land.dsm)
    (left, a), (right, b) = render(land, surface, frames, part, sigma, seed)
    not_seen = hidden(a, right, b, land, surface), hidden(b, left, a, land, surface)
    return AerialPair(left, right, land, (a, b), not_seen)


def aerial_block(
    strips: int,
    photos: int,
    part: tuple[int, int] = (900, 650),
    *,
    overlap: float = 0.6,
    sidelap: float = 0.3,
    sigma: float = 2.0,
    seed: int = 8,
    relief: float = 40.0,
    cell: float = 0.15,
    buildings: int | None = None,
    trees: int | None = None,
    camera: Camera = CAMERA,
) -> tuple[list[Photo], Landscape]:
    """Strips of photos that overlap, of one landscape, flown as `aerial_pair`.

    Parameters
    ----------
    strips, photos : int
        How many strips, from north to south, and photos in each, from west to east.
    part : (columns, rows)
        Part of the sensor, in pixels, around its centre; a smaller one has a shorter
        base.
    overlap, sidelap : float
        Between the photos of a strip, 0.5 or more, and between strips, 0 or more.
    sigma, seed, relief, cell, buildings, trees, camera
        As in `aerial_pair`; stations and angles vary a little, too.

    Returns
    -------
    photos : list of Photo
        Strip by strip, each from west to east.
    landscape : Landscape

    Examples
    --------
    >>> photos, land = aerial_block(1, 2, (120, 80), cell=0.3)
    >>> len(photos), photos[1].grey.shape
    (2, (80, 120))
    """
    along, across = (1 - overlap) * part[0] * GSD, (1 - sidelap) * part[1] * GSD
    rng = np.random.default_rng([seed, 1])
    column, row = (np.array(SENSOR) - part) // 2
    frames = []
    for i in range(strips):
        for j in range(photos):
            X = (j - (photos - 1) / 2) * along
            Y = ((strips - 1) / 2 - i) * across
            shake = rng.normal(0, 0.004, 2) * (along, across)
            Z = HEIGHT + relief / 2 + rng.normal(0, 1)
            tilt = np.radians(rng.normal(0, 0.02, 3))
            exterior = np.array([X + shake[0], Y + shake[1], Z, *tilt])
            frames.append(_frame(camera, exterior, (column, row)))
    land = landscape(
        _extent(frames, part),
        cell=cell,
        relief=relief,
        buildings=buildings,
        trees=trees,
        seed=seed,
    )
    taken = render(land, Surface(land.dsm), frames, part, sigma, seed)
    return [photo for photo, _ in taken], land


def _frame(camera: Camera, exterior: np.ndarray, corner: tuple[int, int]) -> Photo:
    """Photo without grey values so far."""
    return Photo(np.zeros((1, 1)), camera, exterior, PIXEL, SENSOR, corner)


def _footprint(frame: Photo, part: tuple[int, int], Z: float = 0.0) -> np.ndarray:
    """Smallest and largest X and Y (4,) of level ground that a photo shows."""
    edge = [np.linspace(0, n - 1, 9) for n in part]
    u = frame.rays(np.stack(np.meshgrid(*edge), -1)).reshape(-1, 3)
    down = (Z - frame.exterior[2]) / u[:, 2]
    XY = frame.exterior[:2] + down[:, None] * u[:, :2]
    return np.concatenate([XY.min(0), XY.max(0)])


def _extent(
    frames: list[Photo], part: tuple[int, int]
) -> tuple[float, float, float, float]:
    """Ground that the photos show, with a margin."""
    boxes = np.array([_footprint(frame, part) for frame in frames])
    west, south = boxes[:, :2].min(0) - 4
    east, north = boxes[:, 2:].max(0) + 4
    return float(west), float(south), float(east), float(north)


# --- What a camera sees of a landscape: rays, light, optics, noise ---


def render(
    land: Landscape,
    surface: "Surface",
    frames: Sequence[Photo],
    part: tuple[int, int],
    sigma: float,
    seed: int,
) -> Iterator[tuple[Photo, np.ndarray]]:
    """Photos of 8 bit from frames without grey values, with the points they show.

    A pixel is 1.5 cells wide. The grey values of the ground are blurred by a normal
    curve of 0.4 px before sampling (a wave of half a cycle a pixel keeps 0.45, one of a
    whole cycle 0.04, so that there is little alias), the sharp edges of houses and
    crowns by 0.35 px in the photo.
    """
    first = frames[0]
    pixel = first.pixel_size * first.exterior[2] / first.camera.c  # m, at height 0
    ground = cv2.GaussianBlur(land.grey, (0, 0), OPTICS[0] * pixel / land.cell)
    leaves = grain(1.2)
    columns, rows = part
    for k, frame in enumerate(frames):
        rng = np.random.default_rng([seed, 2, k])
        grey: np.ndarray = np.empty((rows, columns), np.float32)
        points = np.empty((rows, columns, 3))
        # Cast the rays, look up the ground
        for a in range(0, rows, BAND):
            b = min(a + BAND, rows)
            pixels = np.stack(np.meshgrid(np.arange(columns), np.arange(a, b)), -1)
            rays = frame.rays(pixels).reshape(-1, 3)
            met = _meet(land, surface, frame.exterior[:3], rays)
            points[a:b] = met.reshape(b - a, columns, 3)
            X, Y = points[a:b, :, 0], points[a:b, :, 1]
            light = _vignetting(frame, pixels)
            light = light * _foliage(land, leaves, points[a:b])
            grey[a:b] = light * land.at(ground, X, Y, cv2.INTER_CUBIC)
        # Blur, add noise, round
        grey = cv2.GaussianBlur(grey, (0, 0), OPTICS[1])
        for a in range(0, rows, BAND):
            band = grey[a : a + BAND]
            noise = sigma * rng.standard_normal(band.shape, np.float32)
            grey[a : a + BAND] = band + noise
        seen = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
        yield dataclasses.replace(frame, grey=seen), points


def _meet(
    land: Landscape, surface: "Surface", station: np.ndarray, rays: np.ndarray
) -> np.ndarray:
    """Object points (n, 3) where rays (n, 3) from a station first meet the surface."""
    dx, dy = rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]
    X0, Y0, Z0 = station
    right, down = dx / land.cell, -dy / land.cell
    column = (X0 - land.corner[0]) / land.cell - Z0 * right
    row = (land.corner[1] - Y0) / land.cell - Z0 * down
    Z = surface.meet(np.array([row, down, column, right]))
    return np.stack([X0 + (Z - Z0) * dx, Y0 + (Z - Z0) * dy, Z], -1)


def _foliage(land: Landscape, leaves: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Share of the light that foliage reflects: a texture in space."""
    # The side of a crown, a few cells wide from above, would be stretched otherwise
    X, Y, Z = (points[..., i] for i in range(3))
    tree = land.at(land.kind, X, Y, cv2.INTER_NEAREST) == TREE
    row = (0.35 * Z - Y) / land.cell % len(leaves)
    column = (X + 0.2 * Z) / land.cell % len(leaves)
    spots = bilinear(np.pad(leaves, (0, 1), mode="wrap"), row, column)
    return np.where(tree, np.clip(1 + 0.16 * spots, 0.6, 1.5), 1)


def _vignetting(frame: Photo, pixels: np.ndarray) -> np.ndarray:
    """Share of the light that reaches a pixel: less towards the corners."""
    r2 = (frame.to_photo(pixels) ** 2).sum(-1) / frame.camera.c**2
    return (1 - 0.6 * r2 + 0.2 * r2**2).clip(0.5, 1)


def hidden(
    points: np.ndarray,
    other: Photo,
    ground: np.ndarray,
    land: Landscape,
    surface: "Surface",
) -> np.ndarray:
    """Whether another photo, which shows `ground`, does not show points.

    A point is hidden outside of that photo, or where something blocks its ray. The four
    pixels around its image decide where they agree; other rays are cast.
    """
    rows, columns = other.grey.shape
    Z = ground[..., 2]
    result = np.ones(points.shape[:2], bool)
    for a in range(0, len(points), BAND):
        band = points[a : a + BAND]
        pixels = _roughly_projected(other, band)
        c, r = pixels[..., 0], pixels[..., 1]
        inside = (c >= 0) & (r >= 0) & (c <= columns - 1) & (r <= rows - 1)
        i = np.clip(r, 0, rows - 2).astype(int)
        j = np.clip(c, 0, columns - 2).astype(int)
        around = np.stack([Z[i, j], Z[i + 1, j], Z[i, j + 1], Z[i + 1, j + 1]])
        around -= band[..., 2]
        covered = around.min(0) > IN_FRONT
        ask = inside & ~covered & (around.max(0) > LEVEL)
        towards = band[ask] - other.exterior[:3]
        first = _meet(land, surface, other.exterior[:3], towards)
        covered[ask] = first[:, 2] > band[ask][:, 2] + SAME
        result[a : a + BAND] = ~inside | covered
    return result


def _roughly_projected(photo: Photo, points: np.ndarray) -> np.ndarray:
    """Pixels of points, to hundredths; quicker than `Photo.project`."""
    # Each of five iterations reduces the error of the distortion tenfold
    camera = photo.camera
    ray = (points - photo.exterior[:3]) @ imaging.attitude(photo.exterior).T
    xy = image = -camera.c * ray[..., :2] / ray[..., 2:]
    lens = camera.interior[3:]
    if camera.lens == "forward":
        image = xy + imaging.distortion(lens, xy)
    else:
        for _ in range(5):
            image = xy - imaging.distortion(lens, image)
    return photo.to_pixel(image + camera.interior[1:3])


# --- Where rays from above first meet a surface of heights ---


class Surface:
    """Heights z (rows, columns) in m, with the tops of blocks of cells.

    `tops` contains for each block size the greatest height of a block and of the blocks
    around it.
    """

    def __init__(self, z: np.ndarray) -> None:
        self.z = z
        self.tops = [(block, _tops(z, block)) for block in BLOCKS]

    def meet(self, rays: np.ndarray) -> np.ndarray:
        """Heights (n,) where rays that come from above first meet the surface.

        Rays (4, n) are (row, down, column, right): where they are at height 0, in
        cells, and the cells by which they move down and right for a metre of height.
        Steps pass whole blocks, then smaller ones, finally half a cell: at most the
        corner of a cell is missed.
        """
        row, down, column, right = rays
        z = np.full(row.shape, float(self.z.max()) + 0.1)
        level = 1 / np.maximum(np.maximum(np.abs(down), np.abs(right)), 1 / STEEP)
        for block, top in self.tops:
            step = block * level
            go = np.arange(z.size)
            while go.size:
                low = z[go] - step[go]
                middle = low + step[go] / 2
                r = (row[go] + middle * down[go]).astype(np.int32) // block
                c = (column[go] + middle * right[go]).astype(np.int32) // block
                r = np.clip(r, 0, top.shape[0] - 1)
                c = np.clip(c, 0, top.shape[1] - 1)
                free = top[r, c] < low
                go = go[free]
                z[go] = low[free]
        return self._close(rays, z, level / 2)

    def _close(
        self, rays: np.ndarray, high: np.ndarray, step: np.ndarray
    ) -> np.ndarray:
        """Close in on the surface from above: by steps, then by false position."""
        # `high` are heights above the surface, by `over`; `low` below it, by `under`
        # Step down to the first height below the surface
        z = np.empty_like(high)
        low, over, under = z.copy(), self._above(high, rays), z.copy()
        go = np.arange(high.size)
        while go.size:
            low[go] = high[go] - step[go]
            under[go] = self._above(low[go], rays[:, go])
            go = go[under[go] > 0]
            high[go], over[go] = low[go], under[go]

        # Close in between the last two heights; every third time by halving
        go = np.arange(high.size)
        for k in range(MAX_ITERATIONS):
            share = 0.5 if k % 3 == 2 else over / (over - under)
            middle = high + share * (low - high)
            d = self._above(middle, rays)
            z[go] = middle
            far = np.abs(d) > CLOSE
            if not far.any():
                break
            up = d > 0
            high, over = np.where(up, middle, high)[far], np.where(up, d, over)[far]
            low, under = np.where(up, low, middle)[far], np.where(up, under, d)[far]
            go, rays = go[far], rays[:, far]
        return z

    def _above(self, z: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """How far rays are above the surface where they have the height z."""
        row, down, column, right = rays
        return z - bilinear(self.z, row + z * down, column + z * right)


def _tops(z: np.ndarray, block: int) -> np.ndarray:
    """Greatest height in each block and in its neighbours."""
    rows, columns = (-(-n // block) for n in z.shape)
    full = np.full((rows * block, columns * block), -np.inf, np.float32)
    full[: z.shape[0], : z.shape[1]] = z
    top = full.reshape(rows, block, columns, block).max((1, 3))
    around = np.pad(top, 1, constant_values=-np.inf)
    wide = np.maximum(np.maximum(around[:-2], around[1:-1]), around[2:])
    return np.maximum(np.maximum(wide[:, :-2], wide[:, 1:-1]), wide[:, 2:])
