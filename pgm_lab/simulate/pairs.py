"""Pairs of images with a known sub-pixel shift or warp: of a texture, of a real image.

The shift of a real image is exact because nothing is interpolated: whole pixels of a
large image become a part of a pixel when it is averaged down.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike

from pgm_lab.simulate.images import photograph
from pgm_lab.simulate.texture import Texture, texture

FIELD = 24  # px, side of a field: a chip of 21 px sees one to four
STUBBLE = 0.2  # of the contrast is left on a harvested field
BANKS = 2.5  # cycles over the image, of the finest haze
HAZE = 0.99  # haze is as bright as the brightest hundredth of the scene


# --- Two images of a texture ---


def texture_pair(
    texture: Texture,
    shape: tuple[int, int],
    affine: ArrayLike,
    *,
    gain: float = 1.0,
    offset: float = 0.0,
    sigma: float = 0.0,
    dtype: DTypeLike | None = None,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Two images of a texture, the right one warped by a known affine transformation.

    left(x, y) = texture(x, y), and right(x', y') = gain * texture(x, y) + offset at
    x' = a0 + a1 x + a2 y, y' = b0 + b1 x + b2 y: exact at every pixel.

    Parameters
    ----------
    texture : Texture
    shape : (rows, columns)
        Shape of both images.
    affine : array_like (6,)
        (a0, a1, a2, b0, b1, b2), from left to right pixel coordinates.
    gain, offset : float
        Of the right image's grey values.
    sigma : float
        Standard deviation of the white noise in each image, in grey values.
    dtype : data type, optional
        numpy.uint8 or numpy.uint16: grey values are rounded and clipped. Default:
        float, not rounded.
    seed : int
        Seed of the noise.

    Returns
    -------
    left, right : ndarray (rows, columns)

    Notes
    -----
    Where the texture shrinks to more than 0.5 cycles per pixel, the right image has an
    alias, as a camera's would.

    References
    ----------
    Bani 2010, (B 2.8) and (B 2.9), for the names of the parameters. His (B 2.7) has
    left = h0 + h1 right: h1 is 1 / gain, and h0 is -offset / gain.

    Examples
    --------
    >>> from pgm_lab.simulate import texture
    >>> left, right = texture_pair(texture(), (60, 80), (3, 1, 0, 2, 0, 1))
    >>> bool(np.allclose(right[2:, 3:], left[:-2, :-3]))
    True
    """
    bits = _bits(dtype)
    right = gain * _image(_warped(texture, affine), shape) + offset
    left = _image(texture, shape)
    return (
        photograph(left, sigma, [seed, 0], bits).astype(dtype),
        photograph(right, sigma, [seed, 1], bits).astype(dtype),
    )


def _image(texture: Texture, shape: tuple[int, int]) -> np.ndarray:
    """Grey values at all pixels of an image."""
    # cos(u + v) = cos u cos v - sin u sin v separates rows from columns: two small
    # matrices multiplied, instead of a cosine for each pixel and wave
    rows, columns = shape
    fx, fy = 2 * np.pi * texture.frequencies.T
    u = np.arange(rows)[:, None] * fy + texture.phases
    v = np.arange(columns)[:, None] * fx
    down = np.hstack([texture.amplitudes * np.cos(u), -texture.amplitudes * np.sin(u)])
    return texture.mean + down @ np.hstack([np.cos(v), np.sin(v)]).T


def _warped(texture: Texture, affine: ArrayLike) -> Texture:
    """The texture as seen in p' = t + J p: again a sum of waves."""
    # From p = J^-1 (p' - t) follows f . p = f' . p' - f' . t with f' = J^-T f
    a0, a1, a2, b0, b1, b2 = np.asarray(affine, dtype=float)
    t, J = np.array([a0, b0]), np.array([[a1, a2], [b1, b2]])
    frequencies = texture.frequencies @ np.linalg.inv(J)
    phases = texture.phases - 2 * np.pi * frequencies @ t
    return Texture(frequencies, texture.amplitudes, phases, texture.mean)


def _bits(dtype: DTypeLike | None) -> int | None:
    """Bits of a data type of whole grey values; None for float."""
    kind = np.dtype(dtype)
    return 8 * kind.itemsize if kind.kind == "u" else None


# --- Two images from a real one ---


def shrunk_pair(
    image: ArrayLike, shift: tuple[int, int], factor: int
) -> tuple[np.ndarray, np.ndarray]:
    """Two small images from one large one, shifted by a known part of a pixel.

    Two cuts, one shifted by whole pixels, are averaged down: what is at (x, y) in the
    left image is at (x, y) plus shift / factor in the right one.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values.
    shift : (columns, rows)
        Whole pixels of the large image, of either sign.
    factor : int
        Side of the square of pixels that becomes one, usually 2 or 4.

    Returns
    -------
    left, right : ndarray (m, n)
        Means of factor x factor pixels, not rounded.

    Notes
    -----
    The mean keeps a part of the detail too fine for the small pixels: an alias, which
    does not move by shift / factor.

    Examples
    --------
    >>> row = np.tile(np.arange(8.0), (2, 1))
    >>> left, right = shrunk_pair(row, shift=(1, 0), factor=2)
    >>> left, right
    (array([[1.5, 3.5, 5.5]]), array([[0.5, 2.5, 4.5]]))
    """
    grey = np.asarray(image, dtype=float)
    dx, dy = shift
    rows = (grey.shape[0] - abs(dy)) // factor
    columns = (grey.shape[1] - abs(dx)) // factor

    def part(x: int, y: int) -> np.ndarray:
        cut = grey[y : y + rows * factor, x : x + columns * factor]
        return cut.reshape(rows, factor, columns, factor).mean(axis=(1, 3))

    # Content that moves right in the image comes from further left in the large one
    x, y = max(dx, 0), max(dy, 0)
    return part(x, y), part(x - dx, y - dy)


@dataclass(frozen=True, eq=False)
class OrthoPair:
    """Two ortho images of one place.

    Attributes
    ----------
    reference, sensed : ndarray (rows, columns)
        Grey values.
    shift : ndarray (2,)
        The true (columns, rows) from reference to sensed image, in pixels.
    changed : ndarray (rows, columns) of bool
        Pixels of the reference image that show, in part, a changed field.
    """

    reference: np.ndarray = field(repr=False)
    sensed: np.ndarray = field(repr=False)
    shift: np.ndarray
    changed: np.ndarray = field(repr=False)


def ortho_pair(
    scene: ArrayLike,
    shift: tuple[int, int],
    factor: int,
    *,
    blur: float = 0.0,
    gain: float = 1.0,
    offset: float = 0.0,
    sigma: float = 0.0,
    haze: float = 0.0,
    changed: float = 0.0,
    dtype: DTypeLike | None = None,
    seed: int = 0,
) -> OrthoPair:
    """Two ortho images from one scene, shifted by a known part of a pixel.

    The scene is blurred, then cut and averaged down as by `shrunk_pair`. The sensed
    image may show changed fields, haze, another gain and offset; each has its own
    noise.

    Parameters
    ----------
    scene : array_like (rows, columns)
        Grey values of a sharp image, such as `datasets.landsat`.
    shift : (columns, rows)
        Sensed minus reference, whole pixels of the scene, of either sign.
    factor : int
        Side of the square of the scene's pixels that becomes one.
    blur : float
        Standard deviation, in pixels of the two images, of a normal blur before the
        sampling: 0 leaves the alias, 0.7 next to none (see the notes).
    gain, offset : float
        Of the sensed image's grey values.
    sigma : float
        Standard deviation of the white noise in each image, in grey values.
    haze : float
        Share of the ground's light that is lost where haze is thickest, from 0 to below
        1. Haze is as bright as the scene's brightest hundredth.
    changed : float
        Probability that a field changes, from 0 to 1.
    dtype : data type, optional
        numpy.uint8 or numpy.uint16: grey values are rounded and clipped. Default:
        float, not rounded.
    seed : int
        Seed of fields, haze and noise.

    Notes
    -----
    The shift is exact: nothing is interpolated, and haze and fields shift nothing.

    The mean over a pixel keeps sin(pi f) / (pi f) of a wave of f cycles per pixel, 0.30
    at 0.75; above 0.5 it appears as an alias of 1 - f, which moves backwards. The blur
    b multiplies this by exp(-2 pi^2 b^2 f^2), with b = 0.7 by 0.004 at 0.75. In
    `datasets.landsat` at factor 4, shifted by (0.5, 0.25), a share of the contrast does
    not move with the rest: 0.29 without blur, 0.05 with b = 0.5, 0.011 with 0.7, and
    0.0007 with 1.

    Fields are squares of 24 pixels at a random angle. Every second one of those that
    change is harvested (a fifth of its contrast, another brightness), the others show
    ground from elsewhere in the scene.

    Examples
    --------
    >>> from pgm_lab import datasets
    >>> pair = ortho_pair(
    ...     datasets.landsat().grey, (1, -5), 4, gain=0.9, sigma=15, dtype=np.uint16
    ... )
    >>> pair.reference.shape, pair.sensed.dtype, pair.shift
    ((298, 299), dtype('uint16'), array([ 0.25, -1.25]))
    """
    scene, bits = np.asarray(scene, dtype=float), _bits(dtype)
    fields, later = _changed_fields(scene, changed, factor * FIELD, seed)
    # A pixel that contains any part of a changed field has a mean above zero
    touched, _ = shrunk_pair(fields, shift, factor)
    reference, _ = shrunk_pair(_blurred(scene, factor * blur), shift, factor)
    _, sensed = shrunk_pair(_blurred(later, factor * blur), shift, factor)
    light = 1 - haze * _banks(sensed.shape, seed)
    sensed = light * sensed + (1 - light) * np.quantile(scene, HAZE)
    return OrthoPair(
        photograph(reference, sigma, [seed, 0], bits).astype(dtype),
        photograph(gain * sensed + offset, sigma, [seed, 1], bits).astype(dtype),
        np.array(shift) / factor,
        touched > 0,
    )


def _blurred(scene: np.ndarray, blur: float) -> np.ndarray:
    """The scene under a normal blur, mirrored at its edges."""
    if blur == 0:
        return scene
    return scipy.ndimage.gaussian_filter(scene, blur, truncate=6.0)


def _changed_fields(
    scene: np.ndarray, share: float, side: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Where fields have changed, and the scene with the changed fields."""
    if share == 0:
        return np.zeros(scene.shape), scene
    rng = np.random.default_rng([seed, 2])
    c, s = np.cos(angle := rng.uniform(0, np.pi / 2)), np.sin(angle)
    y, x = np.indices(scene.shape)
    u, v = ((np.array([c * x + s * y, c * y - s * x])) // side).astype(int)
    u, v = u - u.min(), v - v.min()
    fate = rng.uniform(size=(u.max() + 1, v.max() + 1)) < share
    brightness = rng.normal(scene.mean(), scene.std(), fate.shape)
    rows, columns = scene.shape
    elsewhere = np.roll(scene, (rows // 2, columns // 2), axis=(0, 1))
    harvested = brightness[u, v] + STUBBLE * (scene - scene.mean())
    instead = np.where((u + v) % 2 == 0, harvested, elsewhere)
    fields = fate[u, v]
    later = np.where(fields, np.clip(instead, scene.min(), scene.max()), scene)
    return fields.astype(float), later


def _banks(shape: tuple[int, int], seed: int) -> np.ndarray:
    """How thick the haze is: a smooth image of values from 0 to 1."""
    wave = texture(min(BANKS / max(shape), 0.5), waves=12, seed=seed)
    thick, _ = texture_pair(wave, shape, (0, 1, 0, 0, 0, 1))
    height = np.ptp(thick)
    return (thick - thick.min()) / height if height > 0 else np.zeros(shape)
