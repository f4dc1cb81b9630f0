"""Chips of a reference image found in a sensed one by Pearson's correlation."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, lsm, ncc
from pgm_lab.registration._changed import changed
from pgm_lab.registration.result import Registration

REFINEMENTS = ("parabola", "lsm")
# Predicted standard deviation in px up to which a shift is accepted, by default
LARGEST_SD = {None: 0.5, "parabola": 0.1, "lsm": 0.05}
APART = 1.0  # px that least squares matching may end from the highest whole pixel


def register(
    reference: ArrayLike,
    sensed: ArrayLike,
    points: ArrayLike,
    chip: int = 21,
    radius: int = 3,
    refine: str | None = None,
    *,
    threshold: float = 0.7,
    ratio: float = 0.9,
    largest_sd: float | None = None,
    smooth: float = 1.0,
    offset: ArrayLike | None = None,
    nodata: float | None = None,
    noise: ArrayLike = (1.0, 1.0),
) -> Registration:
    """Find chips of the reference image in the sensed image, all in one call.

    A chip is cut out of the reference image around each point, and compared with every
    place up to `radius` pixels from the same point in the sensed image. Where Pearson's
    correlation coefficient (Br 1) is highest, there the chip is found; the shift is
    sensed minus reference. r alone does not say whether that is right: a chip is
    accepted only if no test speaks against it.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values, 8 or 16 bit or float, one band. Pixels without data may be masked
        (`numpy.ma`), NaN or infinite. Of the same shape, unless `offset` is given.
    points : array_like (n, 2)
        (column, row) in the reference image, in pixels. The chip lies around the
        nearest whole pixel.
    chip : int
        Pixels across a chip, odd, at least 5.
    radius : int
        Whole pixels to each side that are searched, at least 1. A shift of more is
        never found; one of just so many lies on the border, and is not accepted.
    refine : None, "parabola" or "lsm"
        Whole pixels, as in the paper; the top of the paraboloid through the peak and
        its eight neighbours; or least squares matching (`lsm.match`) from there.
    threshold : float
        Smallest r that is accepted.
    ratio : float
        A chip is ambiguous if its second peak is higher than this share of the first.
    largest_sd : float, optional
        Largest predicted standard deviation of a coordinate that is accepted, in
        pixels: 0.5 when missing (rounding to whole pixels alone makes 0.29), 0.1 with
        "parabola", 0.05 with "lsm".
    smooth : float
        Standard deviation in pixels of the Gaussian that "lsm" smooths both images by,
        see there; 0 if nothing in them is finer than their pixels.
    offset : array_like (2,), optional
        (column, row) where the first pixel of the reference image should lie in the
        sensed one, if that begins elsewhere; the shifts come on top of it.
    nodata : float, optional
        Grey value that says "no data" in both images, often 0.
    noise : array_like (2,)
        Standard deviations of a grey value in the reference and in the sensed image.
        Only their ratio is used.

    Returns
    -------
    Registration
        Shifts, r, predicted covariance and status of each chip, and the accuracy of the
        accepted ones.

    Raises
    ------
    ValueError
        If an image or an argument is not what is described here; for a colour image,
        and for images of two shapes without `offset`. What happens to a single chip is
        told by its status.

    Notes
    -----
    The statuses are those of `ncc.match` and `lsm.match`, and two more. "not precise
    enough": the predicted standard deviation is above `largest_sd`. "changed": textured
    in both images, and yet matched by nothing within the radius. 1 - r^2 is the share
    of a chip's variance V that the other image does not explain. With the eight nearest
    accepted chips, a chip can expect an R with

        1 - R^2 = max(median(1 - r^2), min((1 - r^2) V) / V)

    in either image: what sampling loses, and what noise hides. It changed if R would
    have been accepted, but less than half of V is explained, and the signal-to-noise
    ratio r^2 : (1 - r^2) is below a quarter of that of R. A field that was ploughed
    does so, a cloud with texture, and what moved farther than the radius; not what is
    flat in one of the images. At least five chips have to be accepted.

    Averaging over the pixel leaves an alias of what is too fine for it, most of it in
    the high frequencies, and that does not move with the rest. In a Landsat image,
    averaged down 2 to 4 times, 50 picked chips had errors (RMSE_T, both axes) of 0.04
    to 0.05 px by "lsm" without smoothing, with a mean of up to 0.03; smoothed by 1 px
    0.02 and 0.006. Blurred before it was averaged down, so that there was no alias, it
    gave 0.006 to 0.008 px, and without smoothing a sixth less. "parabola": 0.07 to 0.11
    with the alias, 0.03 to 0.04 without.

    The predicted standard deviation of "lsm" is that of the errors within a tenth where
    there is noise, and within a fifth with the alias; that of "parabola" is half as
    large as the errors with the alias.

    Where the texture is very weak and the noise large, chips were seen that are off by
    more than their predicted standard deviation tells; a larger chip helps.

    Not accounted for: what all chips agree on. Shadows that moved, or an error of each
    image of its own, give shifts that are precise, and not those of the ground; and
    whether the reference image is right no comparison tells.

    References
    ----------
    Brahmantara 2015, (Br 1) to (Br 4).

    Examples
    --------
    >>> from pgm_lab import datasets, simulate
    >>> reference, sensed = simulate.shrunk_pair(datasets.landsat().grey, (3, -2), 4)
    >>> points = [(60, 50), (150, 80), (90, 200), (150, 250), (220, 150)]
    >>> found = register(reference, sensed, points, refine="lsm")
    >>> print(found.status[0], found.dx.round(2), found.dy.round(2))
    accepted [0.75 0.74 0.75 0.76 0.76] [-0.49 -0.49 -0.5  -0.48 -0.49]
    """
    points = _validate.point_list(points, "points")
    chip = _validate.window(chip, "chip", 5)
    radius = _validate.whole(radius, "radius", 1)
    if refine is not None:
        _validate.choice(refine, "refine", REFINEMENTS)
    if largest_sd is None:
        largest_sd = LARGEST_SD[refine]
    largest_sd = _validate.positive_number(largest_sd, "largest_sd", "px")
    smooth = _validate.smoothing(smooth)
    reference = _with_data(_validate.grey_image(reference, "reference"), nodata)
    sensed = _with_data(_validate.grey_image(sensed, "sensed"), nodata)
    if offset is None:
        if reference.shape != sensed.shape:
            raise ValueError(
                "reference and sensed must show the same area, pixel on pixel; got"
                f" {reference.shape} and {sensed.shape}. Cut both to the area they have"
                " in common, or say in offset=(column, row) where the first pixel of"
                " the reference lies in the sensed image"
            )
        offset = (0.0, 0.0)
    start = points + _validate.of_shape(offset, (2,), "offset")
    found = ncc.match(
        *(reference, sensed, points, start, chip, chip + 2 * radius, threshold, ratio),
        refine="parabola" if refine == "parabola" else None,
        noise=noise,
    )
    place, covariance, status = found.points, found.covariance, found.status
    if refine == "lsm":
        k = np.flatnonzero(found.accepted)
        fine = lsm.match(
            *(reference, sensed, points[k], found.points[k], chip),
            threshold=max(threshold, 0.0),
            noise=noise,
            smooth=smooth,
        )
        place, covariance, status = _refined(found, k, fine)
    sd = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 2)
    status[sd > largest_sd] = "not precise enough"
    status[changed(reference, sensed, points, found, status, chip, threshold)] = (
        "changed"
    )
    covariance[status != "accepted"] = np.nan
    dx, dy = (place - start).T
    return Registration(points, dx, dy, found.r, found.second, covariance, status)


def _refined(
    found: ncc.Match, k: np.ndarray, fine: lsm.Match
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, covariances and status with what least squares matching made of chips k.

    Where it failed, the highest peak stays.
    """
    place, status = found.points.copy(), found.status.copy()
    covariance = np.full_like(found.covariance, np.nan)
    step = np.abs(fine.points - found.points[k]).max(axis=1)  # NaN unless accepted
    status[k] = np.where(step > APART, "diverged", fine.status)
    good = status[k] == "accepted"
    place[k[good]], covariance[k[good]] = fine.points[good], fine.covariance[good]
    return place, covariance, status


def _with_data(image: np.ndarray, nodata: float | None) -> np.ndarray:
    """The image, with what has the value `nodata` masked."""
    if nodata is None:
        return image
    return np.ma.masked_where(
        np.ma.getdata(image) == _validate.number(nodata, "nodata"), image
    )
