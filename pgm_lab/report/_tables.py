"""The numbers of a bundle adjustment as tables of words, rounded by their precision."""

from collections.abc import Iterable, Sequence

import numpy as np

from pgm_lab._rounding import fixed, round_number, rounded, scientific, two_digits
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.lens import profile
from pgm_lab.bundle.reliability import Significance, reliability, significance
from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.snooping import Snooping
from pgm_lab.camera import PARAMETERS
from pgm_lab.camera import UNITS as OF_FILE
from pgm_lab.report._page import Table

UM = 1e3  # micrometres in a millimetre

UNITS = OF_FILE | {"b1": "-", "b2": "-"}
MAX_SUSPECTS = 25  # rows
AXES = "dX", "dY", "dZ"


Column = tuple[str, Sequence[str]]  # its header, and its cells


def _table(caption: str, *columns: Column) -> Table:
    header, cells = zip(*columns)
    return Table(caption, header, list(zip(*cells)))


def _fixed(headers: Sequence[str], values: np.ndarray, decimals: int) -> list[Column]:
    """Return a column for each of the last axis of some values."""
    return [(head, fixed(v, decimals)) for head, v in zip(headers, values.T)]


def _named(header: str, names: Iterable[object]) -> Column:
    return header, [str(name) for name in names]


def _with_sd(headers: str, values: np.ndarray, sd: np.ndarray) -> list[Column]:
    """Return a value and its sd in turn; "held" where the sd is zero."""
    columns: list[Column] = []
    for name, value, precision in zip(headers.split(), values.T, sd.T):
        words = rounded(precision, precision)
        held = ["held" if s == 0 else word for s, word in zip(precision, words)]
        columns += [(name, rounded(value, precision)), (f"sd {name}", held)]
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
            row = (name, words[0], UNITS[name], words[1])
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
        columns: list[Column] = [("rho (mm)", fixed(rho, 2))]
        for kind in ("radial", "decentring"):
            curve, sd = profile(result, rho, kind, number)
            (_, values), (_, sds) = _with_sd(
                kind, UM * curve[:, None], UM * sd[:, None]
            )
            columns += [(f"{kind} (µm)", values), ("sd (µm)", sds)]
        of_camera = f" of camera {number + 1}" if len(result.cameras) > 1 else ""
        caption = (
            f"Lens{of_camera}: K1 rho^3 + K2 rho^5 + K3 rho^7 and sqrt(P1^2 + P2^2)"
            " rho^2; the last radius is the largest measured"
        )
        tables.append(_table(caption, *columns))
    return tables


def photos(result: Bundle) -> list[Table]:
    """Return stations, angles in radians, in degrees, and the quality of each photo."""
    photo = _named("photo", result.network.photo_names)
    X0, angles = np.hsplit(result.exteriors, 2)
    sd_X0, sd_angles = np.hsplit(result.sd_exteriors, 2)
    turns = "omega phi kappa"
    return [
        _table(f"{caption}, in {unit}", photo, *_with_sd(columns, values, sd))
        for caption, unit, columns, values, sd in (
            ("Projection centres", "object units", "X0 Y0 Z0", X0, sd_X0),
            ("Angles of the photos", "radians", turns, angles, sd_angles),
            (
                "Angles of the photos",
                "degrees",
                turns,
                *np.degrees([angles, sd_angles]),
            ),
        )
    ] + [_photo_quality(result, photo)]


def _photo_quality(result: Bundle, photo: Column) -> Table:
    network, m = result.network, len(result.exteriors)
    rms = UM * np.sqrt(_means(result.residuals**2, network.photo, m))
    w, where = _largest(result.standardized, network.photo, m)
    redundancy = _means(result.redundancy_numbers, network.photo, m).mean(axis=1)
    points = [network.point_names[network.point[k]] if k >= 0 else "-" for k in where]
    columns = [photo]
    if len(result.cameras) > 1:
        columns.append(_named("camera", network.camera + 1))
    columns += [
        _named("rays", network.rays_of_photos),
        *_fixed(("RMS x (µm)", "RMS y (µm)"), rms, 2),
        ("mean r", fixed(redundancy, 2)),
        (f"largest |{result.residual_test}|", fixed(w, 1)),
        _named("at point", points),
    ]
    return _table("Fit of the photos", *columns)


def points(result: Bundle) -> Table:
    """Return coordinates, precision and fit of each point."""
    network, n = result.network, len(result.points)
    squares = _means(result.residuals**2, network.point, n)
    w, where = _largest(result.standardized, network.point, n)
    photos = [network.photo_names[network.photo[k]] if k >= 0 else "-" for k in where]
    return _table(
        "Object points, in object units",
        _named("point", network.point_names),
        *_with_sd("X Y Z", result.points, result.sd_points),
        _named("rays", network.rays_of_points),
        ("RMS (µm)", fixed(UM * np.sqrt(squares.mean(axis=1)), 2)),
        (f"largest |{result.residual_test}|", fixed(w, 1)),
        _named("in photo", photos),
    )


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


def suspects(result: Bundle, rays: np.ndarray) -> Table:
    """Return the suspected blunders, which are rays, the largest first."""
    network = result.network
    caption = "Suspected blunders, and the smallest ones that the network would find"
    if len(rays) > MAX_SUSPECTS:
        caption += f": the {MAX_SUSPECTS} largest of {len(rays)}"
        rays = rays[:MAX_SUSPECTS]
    smallest = reliability(result).internal[rays]
    w = result.residual_test
    return _table(
        caption,
        _named("point", [network.point_names[j] for j in network.point[rays]]),
        _named("photo", [network.photo_names[i] for i in network.photo[rays]]),
        *_fixed(("v x (µm)", "v y (µm)"), UM * result.residuals[rays], 2),
        *_fixed((f"{w} x", f"{w} y"), result.standardized[rays], 1),
        *_fixed(("smallest found x (µm)", "smallest found y (µm)"), UM * smallest, 1),
    )


def rejected(found: Snooping) -> Table:
    """Return the rays that data snooping rejected, in that order."""
    w, removed = found.result.residual_test, found.removed
    return _table(
        "Rays rejected by data snooping, with the estimated error of each",
        _named("step", range(1, len(removed) + 1)),
        _named("point", [one.point for one in removed]),
        _named("photo", [one.photo for one in removed]),
        *_fixed((f"{w} x", f"{w} y"), np.array([x.standardized for x in removed]), 1),
        *_fixed(
            ("error x (µm)", "error y (µm)"),
            UM * np.array([x.error for x in removed]),
            2,
        ),
        ("sigma0 before", fixed(np.array([one.sigma0 for one in removed]), 3)),
    )


def known(result: Bundle) -> list[Table]:
    """Return how far control points, check points and scale bars are off."""
    network, tables = result.network, []
    if network.control is not None and len(network.control[0]):
        tables.append(_control(result, network.control[0], network.control[2]))
    if network.check is not None and len(network.check[0]):
        names = [network.point_names[j] for j in network.check[0]]
        differences = zip(AXES, _differences(result.check_differences))
        caption = "Check points: adjusted - given, in object units"
        tables.append(_table(caption, _named("point", names), *differences))
    if len(network.scale_bars):
        tables.append(_scale_bars(result))
    return tables


def _control(result: Bundle, index: np.ndarray, sigma: np.ndarray) -> Table:
    """Control points; r and w, or tau, only where a coordinate is an observation."""
    v = np.where(sigma == 0, np.nan, result.control_residuals)
    columns = [_named("point", [result.network.point_names[j] for j in index])]
    for axis, of_axis, words in zip(AXES, sigma.T, _differences(v)):
        held = ["held" if s == 0 else word for s, word in zip(of_axis, words)]
        columns.append((axis, held))
    weighted = (sigma > 0) & np.isfinite(sigma)
    caption = "Control points: adjusted - given, in object units"
    if np.any(weighted):
        r, w = _tested(
            result.control_redundancy_numbers, result.control_standardized, weighted
        )
        test = result.residual_test
        columns += _fixed(("r X", "r Y", "r Z"), r, 2)
        columns += _fixed([f"{test} {axis}" for axis in "XYZ"], w, 1)
        caption += f"; r and {test} of coordinates with a standard deviation"
    return _table(caption, *columns)


def _scale_bars(result: Bundle) -> Table:
    a, b, length, sigma = result.network.scale_bars.T
    names = result.network.point_names
    r, w = _tested(
        result.scale_bar_redundancy_numbers, result.scale_bar_standardized, sigma > 0
    )
    return _table(
        "Scale bars, in object units",
        ("bar", [f"{names[int(i)]} to {names[int(j)]}" for i, j in zip(a, b)]),
        ("length", rounded(length, sigma)),
        ("adjusted - given", rounded(result.scale_bar_residuals, sigma)),
        ("r", fixed(r, 2)),
        (result.residual_test, fixed(w, 1)),
    )


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
