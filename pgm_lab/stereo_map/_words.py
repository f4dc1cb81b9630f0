"""A measurement in words and numbers."""

import numpy as np

from pgm_lab._rounding import rounded
from pgm_lab.stereo_map._measurement import Measurement
from pgm_lab.stereo_map.session import Session

UM = 1e3  # micrometres in a millimetre
NOT_SOUGHT = "template leaves the image"
MINUS = str.maketrans("-", "−")


def lines(session: Session, point: Measurement) -> list[str]:
    """Return what is known of a point, a line for each kind of coordinates."""
    name = f"Point {point.name}" if point.name else "New point"
    sought = point.reason and point.status != NOT_SOUGHT
    where = f" Sought {point.reason}" if sought else ""
    if np.isfinite(point.r):
        where += f"; r = {point.r:.2f} by correlation"
    if np.isfinite(point.r_fine):
        where += f", {point.r_fine:.2f} by least squares"
    found = [f"{name}: {point.why}{where}{'.' * bool(where)}"]
    left = _columns(point.left, np.full(2, 0.1))
    if not np.isfinite(point.right).all():
        return [*found, f"Pixels: left ({left})"]
    sd = np.sqrt(np.diagonal(point.covariance))
    right, error = _columns(point.right, sd), _columns(sd, sd)
    found.append(f"Pixels: left ({left}), right ({right}) ± ({error})")
    sides = (
        f"{side} ({xy[0]:.4f}, {xy[1]:.4f}) ± ({s[0]:.2f}, {s[1]:.2f}) µm"
        for side, xy, s in zip(("left", "right"), point.photo, UM * point.photo_sd)
    )
    found.append(f"Photo, mm: {', '.join(sides)}".translate(MINUS))
    if session.space == "none" or not np.isfinite(point.xyz).all():
        return [*found, "Object: not oriented yet; keep points, then orient."]
    place = "; ".join(
        f"{axis} = {rounded(v, s)[0]} ± {rounded(s, s)[0]}"
        for axis, v, s in zip("XYZ", point.xyz[:, None], point.sd[:, None])
    )
    off = f"y parallax {point.y_parallax:.2f} px"
    base = f"Model (base in x: {session.right.exterior[0]:.0f})"
    kind = base if session.space == "model" else "Object"
    found.append(f"{kind}: {place}; {off}".translate(MINUS))
    return found


def pixels(values: np.ndarray) -> str:
    """Write (column, row) with two decimals."""
    return ", ".join(f"{value:.2f}" for value in values)


def _columns(values: np.ndarray, sd: np.ndarray) -> str:
    return ", ".join(rounded(values, sd)).translate(MINUS)
