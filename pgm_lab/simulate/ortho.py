"""Two ortho images of one place, with the shift between them known exactly."""

from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike

from pgm_lab import _validate
from pgm_lab.simulate.images import generator, photograph
from pgm_lab.simulate.pairs import bits_of, shrunk_pair, texture_pair
from pgm_lab.simulate.texture import texture

FIELD = 24  # px, side of a field: a chip of 21 px sees one to four
STUBBLE = 0.2  # of the contrast, what a harvested field keeps
BANKS = 2.5  # cycles over the image, of the finest haze
HAZE = 0.99  # haze is as bright as the brightest hundredth of the scene


@dataclass(frozen=True, eq=False)
class OrthoPair:
    """Two ortho images of one place.

    Attributes
    ----------
    reference, sensed : ndarray (rows, columns)
        Grey values.
    shift : ndarray (2,)
        (columns, rows) from a point of the reference image to the same point of the
        sensed one, in pixels: the truth.
    changed : ndarray (rows, columns) of bool
        Pixels of the reference image of which at least a part is a field that the
        sensed image shows changed.
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
    """Two ortho images out of one scene, shifted by a known part of a pixel.

    The scene is blurred, cut twice, the second time shifted by whole pixels, and both
    cuts are averaged down (`shrunk_pair`). The sensed image may show some of its fields
    changed, through haze, with another gain and offset; each image has its own noise.

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
        Where it is thickest, the share of the ground's light that is lost, from 0 to
        below 1; as bright as the scene's brightest hundredth, haze takes its place.
        Elsewhere less, down to none.
    changed : float
        Probability of a field to change, from 0 to 1.
    dtype : data type, optional
        numpy.uint8 or numpy.uint16: grey values are rounded and clipped. Float and not
        rounded without.
    seed : int
        Seed of fields, haze and noise.

    Returns
    -------
    OrthoPair

    Raises
    ------
    ValueError
        If the scene is not 2-D or too small for shift and factor, a number is not as
        said, or the scene has grey values that `dtype` cannot hold.

    Notes
    -----
    The shift is exact: it is whole pixels of the scene over `factor`, and nothing is
    interpolated. Haze and changed fields alter what is seen, not where it is.

    What the averages keep is a matter of the transfer function. A mean over a pixel
    keeps sin(pi f) / (pi f) of a wave of f cycles per pixel: 0.64 at 0.5, the finest
    that the pixels can hold, and still 0.30 at 0.75. What is above 0.5 appears as a
    wave of 1 - f, an alias, and this one moves backwards. The blur b multiplies it by
    exp(-2 pi^2 b^2 f^2): with b = 0.7, 0.09 at 0.5 and 0.004 at 0.75. Of the contrast
    of `datasets.landsat` at factor 4, shifted by (0.5, 0.25), 0.29 do not move along
    without blur, 0.05 with b = 0.5, 0.011 with 0.7, and 0.0007 with 1.

    Fields are squares of 24 pixels, turned by a random angle. Every second that changes
    is harvested: it keeps a fifth of its contrast, about another brightness. In place
    of the others stands ground from elsewhere in the scene.

    Examples
    --------
    >>> from pgm_lab import datasets
    >>> pair = ortho_pair(
    ...     datasets.landsat().grey, (1, -5), 4, gain=0.9, sigma=15, dtype=np.uint16
    ... )
    >>> pair.reference.shape, pair.sensed.dtype, pair.shift
    ((298, 299), dtype('uint16'), array([ 0.25, -1.25]))
    """
    scene = _validate.image(scene, "scene")
    factor = _validate.whole(factor, "factor", least=2)
    blur = _validate.not_negative(blur, "blur", "px")
    gain, offset = _validate.number(gain, "gain"), _validate.number(offset, "offset")
    sigma = _validate.not_negative(sigma, "sigma", "grey values")
    haze = _share(haze, "haze", below_one=True)
    changed = _share(changed, "changed")
    seed = _validate.whole(seed, "seed", 0, 2**63)
    bits = bits_of(dtype)
    _fits(scene, bits)

    fields, later = _changed_fields(scene, changed, factor * FIELD, seed)
    # A pixel that holds any part of a changed field has a mean above zero
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
    if blur > min(scene.shape) / 4:
        raise ValueError(
            f"blur must be at most a quarter of the scene; {blur:g} of its pixels are"
            f" too much for a shape of {scene.shape}"
        )
    return (
        scipy.ndimage.gaussian_filter(scene, blur, truncate=6.0) if blur > 0 else scene
    )


def _changed_fields(
    scene: np.ndarray, share: float, side: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Where fields have changed, and the scene with what stands there then."""
    if share == 0:
        return np.zeros(scene.shape), scene
    random = generator([seed, 2])
    c, s = np.cos(angle := random.uniform(0, np.pi / 2)), np.sin(angle)
    y, x = np.indices(scene.shape)
    u, v = ((np.array([c * x + s * y, c * y - s * x])) // side).astype(int)
    u, v = u - u.min(), v - v.min()
    fate = random.uniform(size=(u.max() + 1, v.max() + 1)) < share
    brightness = random.normal(scene.mean(), scene.std(), fate.shape)
    rows, columns = scene.shape
    elsewhere = np.roll(scene, (rows // 2, columns // 2), axis=(0, 1))
    harvested = brightness[u, v] + STUBBLE * (scene - scene.mean())
    instead = np.where((u + v) % 2 == 0, harvested, elsewhere)
    fields = fate[u, v]
    lowest, highest = scene.min(), scene.max()
    later = np.where(fields, np.clip(instead, lowest, highest), scene)
    return fields.astype(float), later


def _banks(shape: tuple[int, int], seed: int) -> np.ndarray:
    """How thick the haze is: a smooth image of values from 0 to 1."""
    wave = texture(min(BANKS / max(shape), 0.5), waves=12, seed=seed)
    thick, _ = texture_pair(wave, shape, (0, 1, 0, 0, 0, 1))
    height = np.ptp(thick)
    return (thick - thick.min()) / height if height > 0 else np.zeros(shape)


def _share(value: float, name: str, below_one: bool = False) -> float:
    share = _validate.number(value, name)
    if not 0 <= share <= 1 or (below_one and share == 1):
        end = "below 1" if below_one else "1"
        raise ValueError(f"{name} must be a share from 0 to {end}; got {share:g}")
    return share


def _fits(scene: np.ndarray, bits: int | None) -> None:
    if bits is not None and (scene.min() < 0 or scene.max() > 2**bits - 1):
        raise ValueError(
            f"the scene has grey values from {scene.min():g} to {scene.max():g}, and"
            f" {bits} bits hold 0 to {2**bits - 1}; stretch it first, or take uint16 or"
            " no dtype"
        )
