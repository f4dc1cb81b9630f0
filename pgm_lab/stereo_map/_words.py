"""A measurement in words and numbers."""

import numpy as np

from pgm_lab._rounding import rounded
from pgm_lab.stereo_map._measure import Measurement
from pgm_lab.stereo_map.session import Session

UM = 1e3  # micrometres in a millimetre
IN_WORDS = {
    "none": "not oriented yet: keep five points or more, then orient",
    "model": "model units (the base in x is 1)",
    "object": "units of the given orientation",
}


def lines(session: Session, point: Measurement) -> list[str]:
    """Return what is known of a point, a sentence or a row of numbers each."""
    name = f"Point {point.name}" if point.name else "New point"
    found = [f"{name}: {point.why}"]
    where = f"Sought {point.reason}" if point.reason else ""
    if np.isfinite(point.r):
        where += f"; r = {point.r:.2f} by correlation"
    if np.isfinite(point.r_fine):
        where += f", {point.r_fine:.2f} by least squares"
    found += [f"{where}."] if where else []
    left = pixels(point.left, np.full(2, 0.1))
    if not np.isfinite(point.right).all():
        return [*found, f"left ({left}) px"]
    sd = np.sqrt(np.diagonal(point.covariance))
    found += [
        f"left ({left}) px, right ({pixels(point.right, sd)}) ± ({pixels(sd, sd)}) px",
        *(
            f"{side} photo: x = {xy[0]:.4f}, y = {xy[1]:.4f} mm"
            f" ± {s[0] * UM:.2f}, {s[1] * UM:.2f} µm"
            for side, xy, s in zip(("left", "right"), point.photo, point.photo_sd)
        ),
    ]
    if not np.isfinite(point.xyz).all():
        return [*found, f"object: {IN_WORDS[session.space]}"]
    values = (
        rounded(np.array([v]), np.array([s])) for v, s in zip(point.xyz, point.sd)
    )
    errors = (rounded(np.array([s]), np.array([s])) for s in point.sd)
    found += [
        "; ".join(
            f"{axis} = {v[0]} ± {s[0]}" for axis, v, s in zip("XYZ", values, errors)
        ),
        f"in {IN_WORDS[session.space]}; y parallax {point.y_parallax:.2f} px",
    ]
    return found


def pixels(values: np.ndarray, sd: np.ndarray) -> str:
    """Write (column, row) with the digits that a standard deviation bears."""
    return ", ".join(rounded(values, sd))
