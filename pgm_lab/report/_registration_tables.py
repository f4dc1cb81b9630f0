"""The numbers of a registration as tables of words, rounded by their precision."""

import numpy as np

from pgm_lab._rounding import fixed, rounded, scientific
from pgm_lab.registration import Accuracy, Model, Raster, Registration
from pgm_lab.report._layout import Table
from pgm_lab.report._registration_case import Case, say
from pgm_lab.report._statuses import MOST, first_rows

FINEST = 1e-3  # px; a smaller standard deviation adds no more digits

# What the settings mean, for the command line and the report
SETTINGS = {
    "points": "where the chips are taken from in the reference image",
    "number": "how many points to pick, where the texture is good and spread",
    "grid": "pixels from one point to the next, on a grid",
    "chip": "pixels across a chip of the reference image; odd",
    "radius": "whole pixels that are searched to each side",
    "refine": "how the shift is found between the pixels: not, by a parabola, by least"
    " squares matching",
    "threshold": "least correlation r of the chip and what is found",
    "ratio": "a second place with a higher share of r makes a point ambiguous",
    "largest_sd": "largest predicted standard deviation of a shift, in pixels",
    "smooth": "standard deviation in pixels of the Gaussian that takes the alias away",
    "offset": "column and row of the reference image's first pixel in the sensed one",
}


def accuracy(case: Case) -> Table:
    """Return means, root mean squares and quantiles, in pixels and metres."""
    a = case.found.accuracy
    metres = None if case.pixel_size is None else a.times(case.pixel_size)
    right, down = ("east", "south") if case.north_up else ("to the right", "down")
    rows = [
        _row("mean dx", "mean_x", a, metres, f"common shift, {right} if positive"),
        _row("mean dy", "mean_y", a, metres, f"common shift, {down} if positive"),
        _row("RMSE_x", "rmse_x", a, metres, "root mean square of dx, with its mean"),
        _row("RMSE_y", "rmse_y", a, metres, "the same of dy"),
        _row("RMSE_T", "rmse_t", a, metres, "of both: root of RMSE_x^2 + RMSE_y^2"),
        _row("CE90", "ce90", a, metres, "nine tenths of the shifts are not longer"),
        _row("CE90 if normal", "ce90_normal", a, metres, "1.517 times RMSE_T"),
        _row("median dx", "median_x", a, metres, "a few blunders hardly move it"),
        _row("median dy", "median_y", a, metres, "the same of dy"),
        _row("spread dx", "spread_x", a, metres, "robust standard deviation of dx"),
        _row("spread dy", "spread_y", a, metres, "the same of dy"),
    ]
    header = ["measure", "px", "m", "what it says"]
    if metres is None:
        del header[2]
    return Table(f"Accuracy from {a.n} accepted points", header, rows)


def _row(
    name: str, field: str, px: Accuracy, metres: Accuracy | None, words: str
) -> tuple[str, ...]:
    values = [getattr(one, field) for one in (px, metres) if one is not None]
    return (name, *fixed(np.array(values), 3), words)


def model(found: Model) -> Table:
    """Return the parameters with their standard deviations."""
    units = ["px" if name.endswith("0") else "px a pixel" for name in found.names]
    rows = [
        (name, *scientific(value, sd), unit)
        for name, value, sd, unit in zip(found.names, found.parameters, found.sd, units)
    ]
    return Table(f"Model: {found.kind}", ("parameter", "value", "sd", "unit"), rows)


def points(case: Case) -> Table:
    """Return the first points with their shifts."""
    found = case.found
    n = min(MOST, len(found.points))
    sd = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))
    d = np.column_stack([found.dx, found.dy])
    digits = np.maximum(found.sd, FINEST)
    second = np.where(found.second > -1, found.second, np.nan)
    columns = [
        [str(i) for i in range(n)],
        *(fixed(one, 2) for one in found.points[:n].T),
        *(rounded(one, digits)[:n] for one in d.T),
        *(rounded(one, digits)[:n] for one in sd.T),
        fixed(found.r[:n], 3),
        fixed(second[:n], 3),
        [say(str(one)) for one in found.status[:n]],
    ]
    header = ("point", "column", "row", "dx", "dy", "sd dx", "sd dy", "r", "second r")
    caption = (
        "Points in the reference image and their shifts in pixels, columns to the right"
        " and rows down, from 0"
    )
    caption = first_rows(caption, len(found.points))
    return Table(caption, (*header, "status"), list(zip(*columns)))


def csv(found: Registration, reference: Raster) -> str:
    """Return all points with every digit, with their map coordinates if known."""
    if reference.transform is None:
        return found.csv()
    head, *rows = found.csv().splitlines()
    on_map = [f"{x!r},{y!r}" for x, y in reference.map(found.points).tolist()]
    lines = []
    for row, place in zip((head, *rows), ("x on the map,y on the map", *on_map)):
        *at, rest = row.split(",", 3)  # behind number, column and row
        lines.append(",".join([*at, place, rest]))
    return "\n".join([*lines, ""])
