"""Windows cut out of an image, and which of their pixels hold no data.

Only what the windows reach is looked at: the time is one of points, not of pixels.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view


def inside(centre: np.ndarray, size: int, shape: tuple[int, ...]) -> np.ndarray:
    """Whether a window of that size around each centre lies in an image."""
    half = size // 2
    return np.all((centre >= half) & (centre + half < shape[::-1]), axis=-1)


def windows(
    image: np.ndarray, centre: np.ndarray, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray | None]:
    """Copies (n, rows, columns) of the windows around the centres, and what they lack.

    Beyond the edge of the image its last row or column is repeated. Pixels that are
    masked, NaN or infinite are True in the second array (None if there are none), and
    get the lowest grey value of their window, which does no harm to the sums.
    """
    masked = np.ma.getmask(image) is not np.ma.nomask
    cut = _cut(np.ma.getdata(image), centre, size)
    missing = _cut(np.ma.getmaskarray(image), centre, size) if masked else None
    if cut.dtype.kind == "f":
        if cut.dtype.itemsize > 8:  # what double precision cannot hold gets infinite
            with np.errstate(over="ignore"):
                cut = cut.astype(float)
        bad = ~np.isfinite(cut)
        missing = bad if missing is None else missing | bad
    if missing is None or not missing.any():
        return cut, None
    highest = np.inf if cut.dtype.kind == "f" else cut.max(initial=0)
    lowest = np.where(missing, highest, cut).min(axis=(1, 2), keepdims=True)
    lowest = np.where(missing.all(axis=(1, 2), keepdims=True), 0, lowest)
    return np.where(missing, lowest, cut).astype(cut.dtype), missing


def touching(missing: np.ndarray, size: int) -> np.ndarray:
    """Which windows of that size, at each position, touch a pixel that is missing."""
    n = np.pad(missing.cumsum(axis=1).cumsum(axis=2), ((0, 0), (1, 0), (1, 0)))
    n = n[:, size:] - n[:, :-size]
    return n[:, :, size:] > n[:, :, :-size]


def _cut(grey: np.ndarray, centre: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    half = np.array(size[::-1]) // 2
    first = (centre - half).astype(int)
    last = first + size[::-1]
    if np.all((first >= 0) & (last <= grey.shape[::-1])) and len(centre):
        column, row = first.T
        return sliding_window_view(grey, size)[row, column]
    column = first[:, :1] + np.arange(size[1])
    row = first[:, 1:] + np.arange(size[0])
    row = np.clip(row, 0, grey.shape[0] - 1)
    column = np.clip(column, 0, grey.shape[1] - 1)
    return grey[row[:, :, None], column[:, None, :]]
