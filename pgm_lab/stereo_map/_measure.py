"""One point: template, search, correlation, least squares, photo and object."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from pgm_lab import frames, lsm, ncc
from pgm_lab.camera.photo import Photo
from pgm_lab.ncc import correlation_map
from pgm_lab.stereo_map import _rays, _seek
from pgm_lab.stereo_map._measurement import ACCEPTED, THRESHOLD, Measurement
from pgm_lab.stereo_map._seek import LAST, Area

if TYPE_CHECKING:
    from pgm_lab.stereo_map.session import Session

ON_LINE = 0.5  # the same before least squares, where the epipolar line controls it
RATIO = 0.9  # of the second peak to the first
BACK = 2.0  # px by which the way back may miss the left point
DISTANCE = 2.0  # px from the epipolar curve, beside what the orientation misses
WIDER = 1.3  # the depths of the points so far, and a little more
NEAREST, FARTHEST = 1.0, 100.0  # depths in bases, where nothing else is known


def measured(
    session: "Session", pixel: np.ndarray, near: np.ndarray | None, reach: float
) -> Measurement:
    """Measure one point."""
    photos, template = session.photos, session.template
    if not _inside(photos[0], pixel):
        return Measurement(pixel)
    area = predicted(session, pixel, near, reach)
    point = Measurement(pixel, start=area.centre, reason=area.reason)
    if area.curve is not None:
        point = replace(point, curve=area.curve)
        if len(area.curve) < 2:
            return replace(point, status="window leaves the image")
    if area.curve is not None or near is None:
        start = _seek.narrow(*session.levels, pixel, area, template)
    else:
        start = area.centre
    half = np.minimum(np.ceil(area.half), LAST).astype(int)
    point = replace(point, start=start)
    return _matched(session, point, area, start, half)


def predicted(
    session: "Session", pixel: np.ndarray, near: np.ndarray | None, reach: float
) -> Area:
    """Where to look in the right photo."""
    distance, curve = DISTANCE, None
    if session.space != "none":
        curve = _rays.curve(*session.photos, pixel, _depths(session, pixel))
        off = [abs(p.y_parallax) for p in session.points]
        distance += 2 * max(off, default=0.0)
    if near is not None:
        reason, half = "where you clicked in the right photo", np.full(2, reach)
        return Area(near, half, curve, distance, reason)
    if curve is not None and len(curve) > 1:
        low, high = curve.min(axis=0), curve.max(axis=0)
        half = (high - low) / 2 + distance + 1
        return Area((low + high) / 2, half, curve, distance, "along the epipolar line")
    if curve is not None:
        return Area(pixel, np.ones(2), curve, distance, "along the epipolar line")
    chosen = np.array([p.left for p in session.points]).reshape(-1, 2)
    found = np.array([p.right for p in session.points]).reshape(-1, 2)
    size = session.right.grey.shape[::-1]
    centre, half = _seek.around(chosen, found, pixel, size)
    n = len(chosen)
    by = "one point predicts" if n == 1 else f"{n} points predict"
    reason = f"near the place that {by}" if n else "in the whole photo"
    return Area(centre, half, None, distance, reason)


def _depths(session: "Session", pixel: np.ndarray) -> tuple[float, float]:
    """Nearest and farthest depth of the object along the axis of the left camera."""
    left, right = session.photos
    station = np.asarray(left.exterior[:3], float)
    ray = left.rays(pixel)
    base = float(np.linalg.norm(right.exterior[:3] - station))
    if session.heights is not None and session.space == "object":
        t = (np.array(session.heights) - station[2]) / ray[2]
        if np.all(t > 0):
            near, far = np.sort(t * left.camera.c)
            return float(near), float(far)
    xyz = np.array([p.xyz for p in session.points if p.accepted]).reshape(-1, 3)
    if len(xyz) < 3:
        return NEAREST * base, FARTHEST * base
    axis = left.rays(left.to_pixel([left.camera.x0, left.camera.y0]))
    depth = (xyz - station) @ axis / np.linalg.norm(axis)
    middle = np.median(depth)
    # At least a tenth of the depth to each side, wherever the points so far lie
    return (
        float(min(depth.min() / WIDER, middle / 1.1)),
        float(max(depth.max() * WIDER, middle * 1.1)),
    )


def _matched(
    session: "Session",
    point: Measurement,
    area: Area,
    start: np.ndarray,
    half: np.ndarray,
) -> Measurement:
    """Correlate around a start, then least squares."""
    left, right = (photo.grey for photo in session.photos)
    n, pixel = session.template, point.left
    along: dict[str, Any] = {}
    if area.curve is not None:
        along = {"lines": _rays.line(area.curve, start)[None]}
        along["distance"] = area.distance
    columns, rows = (2 * half + n).tolist()
    found = ncc.match(
        left, right, pixel[None], start[None], n, (rows, columns),
        ON_LINE if along else THRESHOLD, RATIO, "parabola", back=BACK, **along,
    )  # fmt: skip
    point = replace(
        point,
        correlated=found.points[0],
        r=float(found.r[0]),
        status=str(found.status[0]),
        **_seen(left, right, pixel, start, half, n),
    )
    if not point.accepted:
        return point
    place, C, shape, r, status = _least_squares(left, right, pixel, found.points, n)
    point = replace(point, r_fine=r)
    if status != ACCEPTED:
        return replace(point, status=f"least squares: {status}")
    J = np.linalg.inv(shape)
    both = np.array([J @ C @ J.T / 2, C / 2])
    xy, covariance = zip(
        *(
            in_mm(photo, p, c)
            for photo, p, c in zip(session.photos, (pixel, place), both)
        )
    )
    point = replace(
        point,
        right=place,
        shape=shape,
        covariance=C,
        photo=np.array(xy),
        photo_covariance=np.array(covariance),
    )
    return positioned(session, point, area.distance)


def _least_squares(
    left: np.ndarray, right: np.ndarray, pixel: np.ndarray, start: np.ndarray, n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, str]:
    """Place (2,), covariance, shape (2, 2), r and status of least squares matching.

    A window of half the width follows the surface better where that is curved; what
    the whole window says differently is counted as an error.
    """
    wide = lsm.match(left, right, pixel[None], start, n, threshold=0.0)
    status = str(wide.status[0])
    shape = wide.parameters[0][[[1, 2], [4, 5]]]
    if status == ACCEPTED:
        fine = lsm.match(
            left, right, pixel[None], wide.points, n // 2 | 1,
            shape=shape, threshold=THRESHOLD,
        )  # fmt: skip
        status = str(fine.status[0])
        shape = fine.parameters[0][[[1, 2], [4, 5]]]
    if status != ACCEPTED:
        return np.full(2, np.nan), np.full((2, 2), np.nan), shape, np.nan, status
    curved = wide.points[0] - fine.points[0]
    C = fine.covariance[0] + np.outer(curved, curved)
    return fine.points[0], C, shape, float(fine.r[0]), status


def in_mm(
    photo: Photo, pixel: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Photo coordinates (2,) in mm and their covariance (2, 2), of a pixel."""
    moved = pixel + np.array(photo.corner)
    size = photo.sensor, photo.pixel_size
    return frames.pixel_to_photo(moved, *size, covariance=covariance)


def positioned(
    session: "Session", point: Measurement, distance: float = np.inf
) -> Measurement:
    """The point with its place in object space, if the photos are oriented."""
    if session.space == "none":
        return point
    xyz, C, status = _rays.meet(session.photos, point.photo, point.photo_covariance)
    if status != "intersected":
        return replace(point, status=f"intersection: {status}")
    t = session.left
    depth = _depth(t, xyz)
    curve = _rays.curve(*session.photos, point.left, (depth / 1.02, depth * 1.02))
    off = np.nan
    if len(curve) > 1:
        a, b, d = _rays.line(curve, point.right)
        off = float(point.right @ (a, b) + d)
    point = replace(point, xyz=xyz, xyz_covariance=C, y_parallax=off)
    if abs(off) > distance:
        return replace(point, status="off the epipolar line")
    return point


def _depth(photo: Photo, xyz: np.ndarray) -> float:
    """Depth of an object point along the axis of a camera."""
    axis = photo.rays(photo.to_pixel([photo.camera.x0, photo.camera.y0]))
    away = xyz - np.asarray(photo.exterior[:3])
    return float(away @ axis / np.linalg.norm(axis))


def _inside(photo: Photo, pixel: np.ndarray) -> bool:
    size = np.array(photo.grey.shape[::-1]) - 0.5
    return bool(np.all((pixel >= -0.5) & (pixel <= size)))


def _seen(
    left: np.ndarray,
    right: np.ndarray,
    pixel: np.ndarray,
    start: np.ndarray,
    half: np.ndarray,
    n: int,
) -> dict[str, Any]:
    """Template, window and map for the eye, as far as the photos reach."""
    template, at = cut(left, pixel, np.array([n // 2, n // 2]))
    window, corner = cut(right, start, half + n // 2)
    seen = {"template": template, "window": window, "corner": corner}
    whole = template.shape == (n, n) and min(window.shape, default=0) >= n
    finite = np.all(np.isfinite(template)) and np.all(np.isfinite(window))
    if whole and finite and np.ptp(template) > 0:
        seen["map"] = correlation_map(template, window)
    return seen


def cut(
    grey: np.ndarray, centre: np.ndarray, half: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Grey values around a pixel as far as the photo reaches, and their corner."""
    size = np.array(grey.shape[::-1])
    middle = np.floor(np.clip(centre, -1e6, 1e6) + 0.5).astype(int)
    low = np.clip(middle - half, 0, size)
    high = np.clip(middle + half + 1, 0, size)
    part = np.ma.filled(grey[low[1] : high[1], low[0] : high[0]].astype(float), np.nan)
    return part, low
