"""The numbers of a bundle adjustment as tables of words, rounded by their precision."""

from typing import TYPE_CHECKING

import numpy as np

from pgm_lab._rounding import fixed, round_number, rounded, scientific, two_digits
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.lens import profile
from pgm_lab.bundle.reliability import Significance, reliability, significance
from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.camera import PARAMETERS
from pgm_lab.report._page import Table

if TYPE_CHECKING:
    from pgm_lab.report.network import Case

UM = 1e3  # micrometres in a millimetre

UNITS = dict(zip(PARAMETERS, ["mm"] * 3 + ["mm^-2", "mm^-4", "mm^-6"] + ["mm^-1"] * 2))
MAX_SUSPECTS = 25  # rows


def with_sd(values: np.ndarray, sd: np.ndarray) -> list[list[str]]:
    """Return the columns v1, sd1, v2, sd2, ...; "held" where the sd is zero."""
    columns = []
    for value, precision in zip(np.transpose(values), np.transpose(sd)):
        words = rounded(precision, precision)
        held = ["held" if s == 0 else word for s, word in zip(precision, words)]
        columns += [rounded(value, precision), held]
    return columns


def cameras(result: Bundle) -> list[Table]:
    """Return a table of the ten parameters for each camera."""
    sd = dict(zip(result.interior_names, result.sd_interior))
    tested = {one.name: one for one in significance(result)}
    several = len(result.cameras) > 1
    header = (*"parameter value unit sd t p significant".split(), "effect (µm)")
    tables = []
    for number, lens in enumerate(result.cameras, start=1):
        of_camera = f" of camera {number}" if several else ""
        rows = []
        for name, value in zip(PARAMETERS, lens.interior):
            words = f"{value:.6g}", "held"
            if (full := name + of_camera) in sd:
                words = scientific(value, sd[full])
            row = (name, words[0], UNITS.get(name, "-"), words[1])
            rows.append((*row, *_test(tested.get(full))))
        caption = (
            f"Interior orientation{of_camera}; the effect is the largest displacement"
            " of a measured point"
        )
        tables.append(Table(caption, header, rows))
    return tables


def _test(tested: Significance | None) -> tuple[str, ...]:
    if tested is None or not np.isfinite(tested.t):
        return ("-",) * 4
    p = f"{tested.p:.3f}" if tested.p >= 0.0005 else "<0.001"
    significant = "yes" if tested.significant else "no"
    return f"{tested.t:.1f}", p, significant, two_digits(UM * tested.effect)


def lenses(result: Bundle) -> list[Table]:
    """Return a table of the distortion at some radii, for each camera that has any."""
    network = result.network
    tables = []
    for number, one in enumerate(result.cameras):
        own = network.camera[network.photo] == number
        if not np.any(own) or not np.any(one.interior[3:8]):
            continue
        rho_max = np.hypot(*(network.xy[own] - one.interior[1:3]).T).max()
        step = round_number(rho_max / 6)
        rho = np.append(np.arange(step, 0.97 * rho_max, step), rho_max)
        columns = [fixed(rho, 2)]
        for kind in ("radial", "decentring"):
            curve, sd = profile(result, rho, kind, number)
            columns += with_sd(UM * curve[:, None], UM * sd[:, None])
        header = ("rho (mm)", "radial (µm)", "sd (µm)", "decentring (µm)", "sd (µm)")
        of_camera = f" of camera {number + 1}" if len(result.cameras) > 1 else ""
        caption = (
            f"Lens{of_camera}: K1 rho^3 + K2 rho^5 + K3 rho^7 and sqrt(P1^2 + P2^2)"
            " rho^2; the last radius is the largest measured"
        )
        tables.append(Table(caption, header, list(zip(*columns))))
    return tables


def photos(result: Bundle) -> list[Table]:
    """Return stations, angles in radians, in degrees, and the quality of each photo."""
    names = [str(name) for name in result.network.photo_names]
    centres = result.exteriors[:, :3], result.sd_exteriors[:, :3]
    angles = result.exteriors[:, 3:], result.sd_exteriors[:, 3:]
    stations, turns = "X0 Y0 Z0", "omega phi kappa"
    return [
        _of_photos("Projection centres, in object units", stations, names, *centres),
        _of_photos("Angles of the photos, in radians", turns, names, *angles),
        _of_photos(
            "Angles of the photos, in degrees", turns, names, *map(np.degrees, angles)
        ),
        _photo_quality(result, names),
    ]


def _of_photos(
    caption: str, columns: str, names: list[str], values: np.ndarray, sd: np.ndarray
) -> Table:
    header = ["photo"]
    for column in columns.split():
        header += [column, f"sd {column}"]
    return Table(caption, header, list(zip(names, *with_sd(values, sd))))


def _photo_quality(result: Bundle, names: list[str]) -> Table:
    network, m = result.network, len(result.exteriors)
    rms = UM * np.sqrt(_means(result.residuals**2, network.photo, m))
    w, where = _largest(result.standardized, network.photo, m)
    redundancy = _means(result.redundancy_numbers, network.photo, m).mean(axis=1)
    points = [
        str(network.point_names[network.point[k]]) if k >= 0 else "-" for k in where
    ]
    columns, header = [names], ["photo"]
    if len(result.cameras) > 1:
        columns.append([str(k + 1) for k in network.camera])
        header.append("camera")
    columns += [[str(k) for k in network.rays_of_photos], *(fixed(c, 2) for c in rms.T)]
    columns += [fixed(redundancy, 2), fixed(w, 1), points]
    header += ["rays", "RMS x (µm)", "RMS y (µm)", "mean r"]
    header += [f"largest |{result.residual_test}|", "at point"]
    return Table("Fit of the photos", header, list(zip(*columns)))


def points(result: Bundle) -> Table:
    """Return coordinates, precision and fit of each point."""
    network, n = result.network, len(result.points)
    names = [str(name) for name in network.point_names]
    squares = _means(result.residuals**2, network.point, n)
    rms = UM * np.sqrt(squares.mean(axis=1))
    w, where = _largest(result.standardized, network.point, n)
    photos = [
        str(network.photo_names[network.photo[k]]) if k >= 0 else "-" for k in where
    ]
    columns = (
        names,
        *with_sd(result.points, result.sd_points),
        [str(k) for k in network.rays_of_points],
        fixed(rms, 2),
        fixed(w, 1),
        photos,
    )
    header: tuple[str, ...] = ("point", "X", "sd X", "Y", "sd Y", "Z", "sd Z")
    header += ("rays", "RMS (µm)", f"largest |{result.residual_test}|", "in photo")
    return Table("Object points, in object units", header, list(zip(*columns)))


def _means(values: np.ndarray, group: np.ndarray, size: int) -> np.ndarray:
    """Return the mean of the rows of each group, NaN for an empty one."""
    sums = np.array([np.bincount(group, v, minlength=size) for v in values.T]).T
    counts = np.bincount(group, minlength=size).astype(float)
    return sums / np.where(counts > 0, counts, np.nan)[:, None]


def _largest(
    w: np.ndarray, group: np.ndarray, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest |w| of each group and its ray; NaN and -1 of an empty one."""
    w = np.max(np.abs(np.nan_to_num(w)), axis=1)
    order = np.argsort(w, kind="stable")  # the largest comes last and stays
    where = np.full(size, -1)
    where[group[order]] = order
    where[np.bincount(group, w, minlength=size) == 0] = -1  # nothing is controlled
    return np.where(where >= 0, w[where], np.nan), where


def suspects(case: "Case") -> Table:
    """Return the suspected blunders, the largest first."""
    result, network, rays = case.result, case.network, case.suspects
    caption = "Suspected blunders, and the smallest ones that the network would find"
    if len(rays) > MAX_SUSPECTS:
        caption += f": the {MAX_SUSPECTS} largest of {len(rays)}"
        rays = rays[:MAX_SUSPECTS]
    smallest = reliability(result).internal[rays]
    columns = [
        [str(network.point_names[j]) for j in network.point[rays]],
        [str(network.photo_names[i]) for i in network.photo[rays]],
        *(fixed(column, 2) for column in UM * result.residuals[rays].T),
        *(fixed(column, 1) for column in result.standardized[rays].T),
        *(fixed(column, 1) for column in UM * smallest.T),
    ]
    w = result.residual_test
    header = ["point", "photo", "v x (µm)", "v y (µm)", f"{w} x", f"{w} y"]
    header += ["smallest found x (µm)", "smallest found y (µm)"]
    return Table(caption, header, list(zip(*columns)))


def rejected(found: Snooping) -> Table:
    """Return the rays that data snooping rejected, in that order."""
    w = found.result.residual_test
    rows = [
        (
            str(number),
            str(one.point),
            str(one.photo),
            *(f"{value:.1f}" for value in one.standardized),
            *(f"{UM * value:.2f}" for value in one.error),
            f"{one.sigma0:.3f}",
        )
        for number, one in enumerate(found.removed, start=1)
    ]
    header = ["step", "point", "photo", f"{w} x", f"{w} y"]
    header += ["error x (µm)", "error y (µm)", "sigma0 before"]
    caption = "Rays rejected by data snooping, with the estimated error of each"
    return Table(caption, header, rows)


def known(result: Bundle) -> list[Table]:
    """Return how far control points, check points and scale bars are off."""
    network, tables = result.network, []
    if network.control is not None and len(network.control[0]):
        tables.append(_control(result, network.control[0], network.control[2]))
    if network.check is not None and len(network.check[0]):
        names = [str(network.point_names[j]) for j in network.check[0]]
        columns = _differences(result.check_differences)
        caption = "Check points: adjusted - given, in object units"
        header = ("point", "dX", "dY", "dZ")
        tables.append(Table(caption, header, list(zip(names, *columns))))
    if len(network.scale_bars):
        tables.append(_scale_bars(result))
    return tables


def _control(result: Bundle, index: np.ndarray, sigma: np.ndarray) -> Table:
    """Control points; r and w, or tau, only where a coordinate is an observation."""
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
        columns += [fixed(axis, 2) for axis in r.T]
        columns += [fixed(axis, 1) for axis in w.T]
        test = result.residual_test
        header += [f"{name} {axis}" for name in ("r", test) for axis in "XYZ"]
        caption += f"; r and {test} of coordinates with a standard deviation"
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
    header = ("bar", "length", "adjusted - given", "r", result.residual_test)
    return Table("Scale bars, in object units", header, list(zip(*columns)))


def _differences(values: np.ndarray) -> list[list[str]]:
    """Write three columns with as many decimals as give a usual one two digits."""
    there = np.abs(values[np.isfinite(values)])
    usual = np.full(len(values), there.mean() / 10 if len(there) else np.nan)
    return [rounded(column, usual) for column in values.T]


def _tested(
    r: np.ndarray, w: np.ndarray, observed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return r of observations and w of the controlled ones among them, else NaN."""
    r = np.where(observed, np.maximum(r, 0), np.nan)
    return r, np.where(r > UNCONTROLLED, w, np.nan)
