"""Two images of one place laid on each other in two colours."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import _doors

DARK, BRIGHT = 0.02, 0.98  # share of the grey values below black, and below white


def overlay(
    reference: ArrayLike,
    sensed: ArrayLike,
    *,
    paper: bool = False,
    ax: Axes | None = None,
) -> Figure:
    """Lay two images on each other: reference green, sensed magenta, alike grey.

    Magenta and green are told apart in all common kinds of colour vision. Red and
    green, as in Brahmantara 2015, are not: what lies well is yellow there.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values, each stretched for itself; white where masked or NaN.
    paper : bool
        Sensed red and reference green, as in the paper.
    ax : matplotlib.axes.Axes, optional
        Where to draw; a new figure if there is none.

    Returns
    -------
    matplotlib.figure.Figure
        Axes in pixels of the reference image.

    References
    ----------
    Brahmantara 2015, figure 1.1.

    Examples
    --------
    >>> import numpy as np
    >>> fig = overlay(np.eye(5), np.eye(5)[:, ::-1])
    >>> plt.close(fig)
    """
    paper = _validate.flag(paper, "paper")
    colours = composite(reference, sensed, paper=paper)
    if ax is None:
        fig, ax = plt.subplots(figsize=(10, 6.4))
    else:
        _doors.axes(ax)
    ax.imshow(colours, interpolation="nearest")
    ax.grid(False)
    ax.set(xlabel="column (px)", ylabel="row (px)")
    one, other, both = ("green", "red", "yellow") if paper else (
        "green", "magenta", "grey"
    )  # fmt: skip
    ax.set_title(f"{one}: reference, {other}: sensed, {both}: alike")
    return ax.get_figure(root=True)  # type: ignore[return-value]


def composite(
    reference: ArrayLike, sensed: ArrayLike, *, paper: bool = False
) -> np.ndarray:
    """Red, green and blue (rows, columns, 3) of `overlay`, from 0 to 1."""
    one, other = grey_levels(reference, "reference"), grey_levels(sensed, "sensed")
    if one.shape != other.shape:
        raise ValueError(
            f"reference has shape {one.shape} and sensed {other.shape}; cut or resample"
            " one of them, so that both have the same pixels"
        )
    colours = np.stack([other, one, np.zeros_like(one) if paper else other], axis=-1)
    colours[np.isnan(one) | np.isnan(other)] = 1.0
    return colours


def grey_levels(image: ArrayLike, name: str) -> np.ndarray:
    """Grey values from 0 to 1, a few at both ends beyond; NaN where there are none."""
    grey = _validate.grey_image(image, name)
    mask = np.ma.getmaskarray(grey)
    grey = np.where(mask, np.nan, np.ma.getdata(grey).astype(float))
    known = grey[np.isfinite(grey)]
    if not known.size:
        return np.full(grey.shape, np.nan)
    dark, bright = np.quantile(known, (DARK, BRIGHT))
    span = bright - dark if bright > dark else 1.0
    return np.asarray(np.clip((grey - dark) / span, 0.0, 1.0))
