"""Tables of what was known before: control points, scale bars and check points."""

import numpy as np

from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.result import Bundle
from pgm_lab.report._tables import Table, fixed, rounded


def known(result: Bundle) -> list[Table]:
    """Return how far control points, check points and scale bars are off."""
    network, tables = result.network, []
    if network.control is not None and len(network.control[0]):
        tables.append(_control(result))
    if network.check is not None and len(network.check[0]):
        names = [str(network.point_names[j]) for j in network.check[0]]
        columns = _differences(result.check_differences)
        caption = "Check points: adjusted - given, in object units"
        header = ("point", "dX", "dY", "dZ")
        tables.append(Table(caption, header, list(zip(names, *columns))))
    if len(network.scale_bars):
        tables.append(_scale_bars(result))
    return tables


def _control(result: Bundle) -> Table:
    """Control points; r and w only where a coordinate is weighted, an observation."""
    index, _, sigma = result.network.control
    names = [str(result.network.point_names[j]) for j in index]
    v = np.where(sigma == 0, np.nan, result.control_residuals)
    differences = [
        ["held" if s == 0 else word for s, word in zip(of_axis, words)]
        for of_axis, words in zip(sigma.T, _differences(v))
    ]
    weighted = (sigma > 0) & np.isfinite(sigma)
    caption = "Control points: adjusted - given, in object units"
    header, columns = ["point", "dX", "dY", "dZ"], [names, *differences]
    if np.any(weighted):
        r, w = _tested(
            result.control_redundancy_numbers, result.control_standardized, weighted
        )
        columns += [
            *(fixed(axis, 2) for axis in r.T),
            *(fixed(axis, 1) for axis in w.T),
        ]
        header += ["r X", "r Y", "r Z", "w X", "w Y", "w Z"]
        caption += "; r and w of coordinates with a standard deviation"
    return Table(caption, header, list(zip(*columns)))


def _scale_bars(result: Bundle) -> Table:
    a, b, length, sigma = result.network.scale_bars.T
    names = result.network.point_names
    bars = [f"{names[int(i)]} to {names[int(j)]}" for i, j in zip(a, b)]
    r, w = _tested(
        result.scale_bar_redundancy_numbers, result.scale_bar_standardized, sigma > 0
    )
    lengths = [rounded(one, sigma) for one in (length, result.scale_bar_residuals)]
    columns = bars, *lengths, fixed(r, 2), fixed(w, 1)
    header = ("bar", "length", "adjusted - given", "r", "w")
    return Table("Scale bars, in object units", header, list(zip(*columns)))


def _differences(values: np.ndarray) -> list[list[str]]:
    """Write three columns with as many decimals as give a usual one two digits."""
    there = np.abs(values[np.isfinite(values)])
    usual = np.full(len(values), there.mean() / 10 if len(there) else np.nan)
    return [rounded(column, usual) for column in values.T]


def _tested(r: np.ndarray, w: np.ndarray, observed: np.ndarray):
    """Return r of observations and w of the controlled ones among them, else NaN."""
    r = np.where(observed, np.maximum(r, 0), np.nan)
    return r, np.where(r > UNCONTROLLED, w, np.nan)
