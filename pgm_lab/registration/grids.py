"""Two images on one map: how far their grids of pixels lie apart."""

import numpy as np

from pgm_lab import _validate
from pgm_lab.io.geotiff import Raster, same_crs

SAME_GRID = 0.01  # px that two grids may drift apart over an image


def offset(reference: Raster, sensed: Raster) -> np.ndarray:
    """How many columns and rows a pixel's number is larger in the sensed image.

    Two images of one place may begin at different corners. The same point of the map
    has (column, row) + offset in the sensed image if it has (column, row) in the
    reference: what `register` and `fit` take.

    Parameters
    ----------
    reference, sensed : Raster
        Either both with a georeference, of the same coordinate reference system and
        pixel size, or both without.

    Returns
    -------
    ndarray (2,)
        In pixels, not rounded; zeros without georeference.

    Raises
    ------
    ValueError
        If the grids do not fit together: the message says how to make them; or the
        images have no part of the map in common.

    Examples
    --------
    >>> zeros = np.zeros((100, 100), np.uint8), np.zeros((100, 100), bool)
    >>> one = Raster(*zeros, np.array([[6.0, 0, 700_000], [0, -6, 9_320_000]]))
    >>> other = Raster(*zeros, np.array([[6.0, 0, 700_060], [0, -6, 9_320_015]]))
    >>> offset(one, other)
    array([-10. ,   2.5])
    """
    _validate.instance(reference, Raster, "reference")
    _validate.instance(sensed, Raster, "sensed")
    if reference.transform is None and sensed.transform is None:
        return np.zeros(2)
    for one, name in ((reference, "sensed"), (sensed, "reference")):
        if one.transform is None:
            raise ValueError(
                f"{one.path or 'one image'} has no georeference and the {name} image"
                " has one: cut both to the same area and leave it away, or give the"
                " offset in pixels"
            )
    if not same_crs(reference.crs, sensed.crs):
        raise ValueError(
            f"the images have different coordinate reference systems,"
            f" {_short(reference.crs)} and {_short(sensed.crs)}. {_warp(reference)}"
        )
    A, corner = reference.affine()
    other, other_corner = sensed.affine()
    size = max(*reference.grey.shape, *sensed.grey.shape)
    if np.abs(np.linalg.solve(A, other) - np.eye(2)).max() * size > SAME_GRID:
        sizes = (" x ".join(f"{s:.9g}" for s in np.hypot(*m)) for m in (A, other))
        raise ValueError(
            "the images have pixels of different size or direction,"
            f" {' and '.join(sizes)} map units. {_warp(reference)}"
        )
    found = np.linalg.solve(A, corner - other_corner)
    first = np.maximum(-found, 0)
    last = np.minimum(sensed.grey.shape[::-1] - found, reference.grey.shape[::-1])
    if np.any(last <= first):
        raise ValueError(
            "the images have no part of the map in common: the sensed one begins"
            f" {-found[0]:.0f} columns and {-found[1]:.0f} rows from the reference's"
            " first pixel"
        )
    return found


def _short(crs: str | None) -> str:
    return (crs or "none")[:60]


def _warp(reference: Raster) -> str:
    """What to do with a sensed image on another grid."""
    across, down = np.hypot(*reference.affine()[0])
    return (
        "Bring the sensed image onto the reference's grid first, for example with"
        f" gdalwarp -t_srs {_short(reference.crs)} -tr {across:.9g} {down:.9g} -r cubic"
        " sensed.tif aligned.tif"
    )
