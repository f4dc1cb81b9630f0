"""A camera looks at a landscape: rays, light, optics, noise, and what hides what."""

import dataclasses
from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from pgm_lab.camera import Camera, imaging
from pgm_lab.camera.photo import Photo
from pgm_lab.simulate._objects import TREE, grain
from pgm_lab.simulate._rays import Surface, bilinear
from pgm_lab.simulate.images import generator
from pgm_lab.simulate.landscape import Landscape

OPTICS = 0.4, 0.35  # px, sd of the blur of the ground, and of the photo
BAND = 48  # rows of a photo at a time
IN_FRONT = 0.5  # m, what is so much higher on the ray hides a point
LEVEL = 0.15  # m, neighbours no higher than that do not
SAME = 0.05  # m, a ray that meets the surface so near to a point shows it


def photograph(
    land: Landscape,
    camera: Camera,
    exterior: np.ndarray,
    pixel_size: float,
    image_size: tuple[int, int],
    corner: tuple[int, int],
    part: tuple[int, int],
    sigma: float = 2.0,
    seed: int = 0,
) -> tuple[Photo, np.ndarray]:
    """Photo of a landscape, and the object point (rows, columns, 3) of each pixel."""
    frame = Photo(np.zeros((1, 1)), camera, exterior, pixel_size, image_size, corner)
    return next(photographs(land, Surface(land.dsm), [frame], part, sigma, seed))


def photographs(
    land: Landscape,
    surface: Surface,
    frames: Sequence[Photo],
    part: tuple[int, int],
    sigma: float,
    seed: int,
) -> Iterator[tuple[Photo, np.ndarray]]:
    """Photos from frames without grey values, with the object points they show.

    Parameters
    ----------
    land : Landscape
    surface : Surface
        Of its heights.
    frames : sequence of Photo
    part : (columns, rows)
        Of the photos.
    sigma : float
        Standard deviation of the noise, in grey values.
    seed : int
        Of the noise.

    Yields
    ------
    photo : Photo
        With grey values of 8 bit.
    points : ndarray (rows, columns, 3)
        Object point that each pixel shows, in m.

    Notes
    -----
    A pixel is 1.5 cells of the landscape wide. Before they are sampled, the grey values
    of the ground are blurred by a normal curve of 0.4 px, about the area of a pixel and
    the optics: of a wave of half a cycle a pixel, the finest that a photo holds, 0.45
    remains, of one of a whole cycle 0.04, so that little comes back as an alias. The
    edges of houses and crowns, which are sharp on the ground, are blurred by 0.35 px in
    the photo.
    """
    first = frames[0]
    pixel = first.pixel_size * first.exterior[2] / first.camera.c  # m, at height 0
    ground = cv2.GaussianBlur(land.grey, (0, 0), OPTICS[0] * pixel / land.cell)
    leaves = grain(1.2)
    columns, rows = part
    for k, frame in enumerate(frames):
        rng = generator([seed, 2, k])
        grey: np.ndarray = np.empty((rows, columns), np.float32)
        points = np.empty((rows, columns, 3))
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
        grey = cv2.GaussianBlur(grey, (0, 0), OPTICS[1])
        for a in range(0, rows, BAND):
            band = grey[a : a + BAND]
            noise = sigma * rng.standard_normal(band.shape, np.float32)
            grey[a : a + BAND] = band + noise
        seen = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
        yield dataclasses.replace(frame, grey=seen), points


def _meet(
    land: Landscape, surface: Surface, station: np.ndarray, rays: np.ndarray
) -> np.ndarray:
    """Object points (n, 3) where rays (n, 3) from a station first meet the surface."""
    dx, dy = rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]
    X0, Y0, Z0 = station
    right, down = dx / land.cell, -dy / land.cell
    column = (X0 - land.corner[0]) / land.cell - Z0 * right
    row = (land.corner[1] - Y0) / land.cell - Z0 * down
    Z = surface.meet(row, down, column, right)
    return np.stack([X0 + (Z - Z0) * dx, Y0 + (Z - Z0) * dy, Z], -1)


def _foliage(land: Landscape, leaves: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Share of the light that foliage sends back: a texture in space, not from above.

    The side of a crown, a few cells wide from above, would be drawn out otherwise.
    """
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
    surface: Surface,
) -> np.ndarray:
    """Whether another photo does not show object points.

    Parameters
    ----------
    points : ndarray (rows, columns, 3)
        In m.
    other : Photo
    ground : ndarray (rows, columns, 3)
        Object points that the other photo shows.
    land, surface
        What both photos show.

    Returns
    -------
    ndarray (rows, columns) of bool
        True outside the other photo, and where the ray from its station to the point
        first meets something else.

    Notes
    -----
    The four pixels around the image of a point decide, where all of them show something
    clearly above the point, or none. The rays of the others are cast.
    """
    rows, columns = other.grey.shape
    Z = ground[..., 2]
    result = np.ones(points.shape[:2], bool)
    for a in range(0, len(points), BAND):
        band = points[a : a + BAND]
        pixels = _about(other, band)
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


def _about(photo: Photo, points: np.ndarray) -> np.ndarray:
    """Pixels of points, to hundredths: `Photo.project` proves more, and takes longer.

    What the lens displaces is put in again five times; each is ten times closer.
    """
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
