"""One point, from the search area to object space; orientation by all of them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, frames, lsm, ncc, rotation
from pgm_lab.camera import collinearity
from pgm_lab.camera.photo import Photo
from pgm_lab.orientation import absolute, intersect, relative
from pgm_lab.stereo_map.session import ACCEPTED, THRESHOLD, Measurement, Session

MIN_POINTS = 5  # that orient two photos
ORIENTED = ("converged", "no redundancy", "several solutions", "weak geometry",
            "gimbal lock")  # fmt: skip

# Where to look
TOLERANCE = 2.0  # px from the epipolar curve, beside what the orientation misses
DEPTH_MARGIN = 1.3  # factor on the depths of the points so far
MIN_DEPTH, MAX_DEPTH = 1.0, 100.0  # in bases, where nothing else is known
SAMPLES = 97  # along an epipolar curve
MIN_AFFINE = 6  # points; fewer give a shift
MAX_ERROR = {"shift": 0.15, "affine": 0.08}  # of the prediction, by the photo's width

# From coarse to fine
FIRST_REACH = 100  # px to each side at the level where a wide search begins
REACH = 4  # px to each side at the levels below it
LAST_REACH = 20  # px to each side in the photo itself
MAX_SEARCH = 400_000  # pixels of a search window
MIN_TEMPLATE = 11  # pixels across a template at a coarse level
MIN_R = 0.5  # that leads on to the next level, or to least squares on the line

# Correlation in the photo itself
RATIO = 0.9  # of the second peak to the first
BACK = 2.0  # px by which the way back may miss the left point


def measure(
    session: Session,
    pixel: ArrayLike,
    near: ArrayLike | None = None,
    *,
    reach: float = 25.0,
) -> Measurement:
    """Find a point of the left photo in the right one, and in object space.

    The search is along the epipolar curve once the photos are oriented; before that
    around the place that the points so far predict, or in the whole photo without any.

    Parameters
    ----------
    session : Session
    pixel : array_like (2,)
        (column, row) in the left photo.
    near : array_like (2,), optional
        About where it is in the right photo, as a click there says.
    reach : float
        How far from `near` it may be, in pixels.

    Returns
    -------
    Measurement
        Its `status` says whether it was found, or why not.

    Raises
    ------
    ValueError
        If a pixel is not one point of two numbers.
    """
    _validate.instance(session, Session, "session")
    pixel = _validate.one_point(pixel, 2, "pixel")
    if near is not None:
        near = _validate.one_point(near, 2, "near")
    reach = _validate.positive_number(reach, "reach", "px")

    size = np.array(session.left.grey.shape[::-1])
    if np.any(pixel < -0.5) or np.any(pixel > size - 0.5):
        return Measurement(pixel)
    area = _search_area(session, pixel, near, reach)
    point = Measurement(pixel, start=area.centre, reason=area.reason)
    if area.curve is not None:
        point = replace(point, curve=area.curve)
        if len(area.curve) < 2:
            return replace(point, status="window leaves the image")
    if area.curve is not None or near is None:
        start = _narrowed(*session.levels, pixel, area, session.template)
        point = replace(point, start=start)
    return _matched(session, point, area)


def orient(session: Session, control: Mapping[int, ArrayLike] | None = None) -> Session:
    """Orient the photos by the points on the list.

    Parameters
    ----------
    session : Session
        With five points or more; six control each other, and a dozen spread over the
        photos are good.
    control : mapping {number of a point: (X, Y, Z)}, optional
        Three or more points that are known in object space. Without them coordinates
        are those of a model: its origin is the left station, its axes are those of the
        left photo, its unit is the base in x.

    Returns
    -------
    Session
        Oriented; each point has object coordinates and its `y_parallax`.

    Raises
    ------
    ValueError
        If there are too few points, or they do not determine the orientation.
    """
    _validate.instance(session, Session, "session")
    if len(session.points) < MIN_POINTS:
        raise ValueError(
            f"{MIN_POINTS} points or more orient two photos, better ten; there are"
            f" {len(session.points)}"
        )
    names = tuple(point.name for point in session.points)
    known = _control(names, control)

    # Relative orientation
    xy = np.array([point.photo for point in session.points])
    variances = np.array([point.photo_covariance for point in session.points])
    sigma = float(np.sqrt(np.mean(variances[..., [0, 1], [0, 1]])))
    cameras = session.left.camera, session.right.camera
    found = relative(*cameras, xy[:, 0], xy[:, 1], sigma=sigma)
    if found.status not in ORIENTED:
        raise ValueError(
            f"the points give no orientation: {found.status}. Were the photos taken"
            " from two places, and are all points right?"
        )
    exteriors = np.array([np.zeros(6), found.exterior])

    # Absolute orientation, which carries the photos into object space
    if known:
        rows = [names.index(name) for name in known]
        fit = absolute(found.points[rows], np.array(list(known.values())))
        stations = fit.apply(exteriors[:, :3])
        M = rotation.matrix(*exteriors[:, 3:].T) @ fit.rotation.T
        exteriors = np.concatenate([stations, rotation.angles(M)], axis=1)

    left, right = (
        replace(photo, exterior=exterior)
        for photo, exterior in zip(session.photos, exteriors)
    )
    oriented = replace(
        session,
        left=left,
        right=right,
        space="object" if known else "model",
        relative=found,
        oriented_by=names,
        before=session,
    )
    points = tuple(_positioned(oriented, point) for point in session.points)
    return replace(oriented, points=points)


def _control(
    names: tuple[int, ...], control: Mapping[int, ArrayLike] | None
) -> dict[int, np.ndarray]:
    """Control points by the numbers of points on the list, in its order."""
    if control is None:
        return {}
    control = _validate.mapping(control, "control")
    for name in control:
        if name not in names:
            raise ValueError(f"control names point {name!r}, which is not on the list")
    if len(control) < 3:
        raise ValueError(f"control must be three points or more; got {len(control)}")
    return {
        name: _validate.one_point(control[name], 3, f"control[{name}]")
        for name in names
        if name in control
    }


# --- Where to look in the right photo ---


@dataclass(frozen=True, eq=False)
class _Area:
    """Part of the right photo where a point is sought."""

    centre: np.ndarray
    half: np.ndarray  # pixels to each side, (columns, rows)
    curve: np.ndarray | None  # epipolar curve (k, 2), near which alone is searched
    distance: float  # largest one from it, in pixels
    reason: str  # where the prediction comes from, in words


def _search_area(
    session: Session, pixel: np.ndarray, near: np.ndarray | None, reach: float
) -> _Area:
    distance, curve = TOLERANCE, None
    if session.space != "none":
        curve = _curve(*session.photos, pixel, _depths(session, pixel))
        off = [abs(p.y_parallax) for p in session.points]
        distance += 2 * max(off, default=0.0)
    if near is not None:
        reason, half = "where you clicked in the right photo", np.full(2, reach)
        return _Area(near, half, curve, distance, reason)
    if curve is not None:
        centre, half = pixel, np.ones(2)
        if len(curve) > 1:
            low, high = curve.min(axis=0), curve.max(axis=0)
            centre, half = (low + high) / 2, (high - low) / 2 + distance + 1
        return _Area(centre, half, curve, distance, "along the epipolar line")
    n = len(session.points)
    by = "one point predicts" if n == 1 else f"{n} points predict"
    reason = f"near the place that {by}" if n else "in the whole photo"
    return _Area(*_predicted(session, pixel), None, distance, reason)


def _predicted(session: Session, pixel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place and reach by the affine transformation, or shift, of the points so far."""
    n, size = len(session.points), np.array(session.right.grey.shape[::-1])
    if n == 0:
        return (size - 1) / 2, size / 2
    chosen = np.array([p.left for p in session.points])
    found = np.array([p.right for p in session.points])
    middle = chosen.mean(axis=0)
    kind = "affine" if n >= MIN_AFFINE else "shift"
    A = np.column_stack([np.ones(n), chosen - middle])
    a = np.concatenate([[1.0], pixel - middle])
    if kind == "shift":
        A, a = A[:, :1], a[:1]
    x, *_ = np.linalg.lstsq(A, found - chosen, rcond=1e-6)
    residuals = np.hypot(*(found - chosen - A @ x).T)
    reach = max(MAX_ERROR[kind] * max(size), 3 * residuals.max())
    return pixel + a @ x, np.full(2, reach)


def _curve(
    left: Photo, right: Photo, pixel: np.ndarray, depths: tuple[float, float]
) -> np.ndarray:
    """Epipolar curve (k, 2) in the right photo, between two depths; perhaps nothing."""
    # Depths are along the axis of the left camera, in steps of equal parallax
    near, far = depths
    t = 1 / np.linspace(1 / near, 1 / far, SAMPLES) / left.camera.c
    points = left.exterior[:3] + t[:, None] * left.rays(pixel)
    pixels = right.seen_at(points - right.exterior[:3])
    size = np.array(right.grey.shape[::-1]) - 0.5
    return pixels[np.all((pixels > -0.5) & (pixels < size), axis=1)]


def _line(curve: np.ndarray, pixel: np.ndarray) -> np.ndarray:
    """The line a column + b row + d = 0, a^2 + b^2 = 1, along a curve at a pixel."""
    middle = (curve[:-1] + curve[1:]) / 2
    k = np.argmin(np.hypot(*(middle - pixel).T))
    (x0, y0), (dx, dy) = curve[k], curve[k + 1] - curve[k]
    a, b = np.array([-dy, dx]) / np.hypot(dx, dy)
    return np.array([a, b, -a * x0 - b * y0])


def _depths(session: Session, pixel: np.ndarray) -> tuple[float, float]:
    """Nearest and farthest depth of the object along the axis of the left camera."""
    left, right = session.photos
    station, ray = left.exterior[:3], left.rays(pixel)
    base = float(np.linalg.norm(right.exterior[:3] - station))
    if session.heights is not None and session.space == "object":
        t = (np.array(session.heights) - station[2]) / ray[2]
        if np.all(t > 0):
            near, far = np.sort(t * left.camera.c)
            return float(near), float(far)
    xyz = np.array([p.xyz for p in session.points if p.accepted]).reshape(-1, 3)
    if len(xyz) < 3:
        return MIN_DEPTH * base, MAX_DEPTH * base
    depth = _depth(left, xyz)
    middle = np.median(depth)
    # At least a tenth of the depth to each side, wherever the points so far lie
    return (
        float(min(depth.min() / DEPTH_MARGIN, middle / 1.1)),
        float(max(depth.max() * DEPTH_MARGIN, middle * 1.1)),
    )


def _depth(photo: Photo, xyz: np.ndarray) -> np.ndarray:
    """Depths (...) of object points (..., 3) along the axis of a camera."""
    axis = photo.rays(photo.to_pixel([photo.camera.x0, photo.camera.y0]))
    return (xyz - photo.exterior[:3]) @ axis / np.linalg.norm(axis)


# --- From coarse to fine ---


def _narrowed(
    left: list[np.ndarray],
    right: list[np.ndarray],
    pixel: np.ndarray,
    area: _Area,
    template: int,
) -> np.ndarray:
    """Place (2,) in the right photo, to a few pixels, by correlation level by level."""
    wide = float(np.max(area.half))
    if wide <= LAST_REACH:
        return area.centre
    first = max(int(np.ceil(np.log2(wide / FIRST_REACH))), 1)
    first = min(first, len(left) - 1, len(right) - 1)
    place, half = area.centre, area.half
    for k in range(first, 0, -1):
        step = 2.0**k
        # The largest template up to the wanted size that lies in the level
        nearest = np.floor(pixel / step + 0.5)
        room = np.min([nearest, np.array(left[k].shape[::-1]) - 1 - nearest])
        size = min(template, 2 * int(room) + 1)
        if size < MIN_TEMPLATE:
            continue
        columns, rows = (2 * np.ceil(half / step).astype(int) + size).tolist()
        along: dict[str, Any] = {}
        if area.curve is not None:
            a, b, d = _line(area.curve, place)
            away = np.abs(area.curve @ (a, b) + d).max()  # the curve is not straight
            wide = min(away, area.half.max()) + area.distance
            along = {"lines": np.array([[a, b, d / step]])}
            along["distance"] = 1.0 + wide / step
        found = ncc.match(
            left[k], right[k], pixel[None] / step, place[None] / step, size,
            (rows, columns), MIN_R, 1.0, **along,
        )  # fmt: skip
        if found.r[0] >= MIN_R:
            place, half = found.points[0] * step, np.full(2, REACH * step / 2)
        elif 4 * columns * rows > MAX_SEARCH:  # else a finer level may tell
            break
    return place


# --- Correlation and least squares ---


def _matched(session: Session, point: Measurement, area: _Area) -> Measurement:
    """Correlate around the start of a point, then least squares."""
    left, right = (photo.grey for photo in session.photos)
    n, pixel, start = session.template, point.left, point.start
    half = np.minimum(np.ceil(area.half), LAST_REACH).astype(int)
    threshold = THRESHOLD
    along: dict[str, Any] = {}
    if area.curve is not None:  # which controls the match, too
        threshold = MIN_R
        along = {"lines": _line(area.curve, start)[None], "distance": area.distance}
    columns, rows = (2 * half + n).tolist()
    found = ncc.match(
        left, right, pixel[None], start[None], n, (rows, columns),
        threshold, RATIO, "parabola", back=BACK, **along,
    )  # fmt: skip
    point = replace(
        point,
        correlated=found.points[0],
        r=float(found.r[0]),
        status=str(found.status[0]),
        **_shown(left, right, pixel, start, half, n),
    )
    if not point.accepted:
        return point
    place, C, shape, r, status = _least_squares(left, right, pixel, found.points, n)
    point = replace(point, r_fine=r)
    if status != ACCEPTED:
        return replace(point, status=f"least squares: {status}")

    # Half of the noise is in each photo
    J = np.linalg.inv(shape)
    noise = J @ C @ J.T / 2, C / 2
    xy, covariance = zip(
        *(
            _in_mm(photo, at, part)
            for photo, at, part in zip(session.photos, (pixel, place), noise)
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
    return _positioned(session, point, area.distance)


def _least_squares(
    left: np.ndarray, right: np.ndarray, pixel: np.ndarray, start: np.ndarray, n: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, str]:
    """Place (2,), covariance, shape (2, 2), r and status of least squares matching."""
    # A window of half the width follows the surface better where that is curved; what
    # the whole window says differently is counted as an error.
    wide = lsm.match(left, right, pixel[None], start, n, threshold=0.0)
    last = wide
    if str(wide.status[0]) == ACCEPTED:
        shape = wide.parameters[0][[[1, 2], [4, 5]]]
        last = lsm.match(
            left, right, pixel[None], wide.points, n // 2 | 1,
            shape=shape, threshold=THRESHOLD,
        )  # fmt: skip
    status = str(last.status[0])
    shape = last.parameters[0][[[1, 2], [4, 5]]]
    if status != ACCEPTED:
        return np.full(2, np.nan), np.full((2, 2), np.nan), shape, np.nan, status
    curved = wide.points[0] - last.points[0]
    C = last.covariance[0] + np.outer(curved, curved)
    return last.points[0], C, shape, float(last.r[0]), status


def _in_mm(
    photo: Photo, pixel: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Photo coordinates (2,) in mm and their covariance (2, 2), of a pixel."""
    moved = pixel + np.array(photo.corner)
    size = photo.sensor, photo.pixel_size
    return frames.pixel_to_photo(moved, *size, covariance=covariance)


def _shown(
    left: np.ndarray,
    right: np.ndarray,
    pixel: np.ndarray,
    start: np.ndarray,
    half: np.ndarray,
    n: int,
) -> dict[str, Any]:
    """Template, window and map of r for the eye, as far as the photos reach."""
    template, _ = _cut(left, pixel, np.full(2, n // 2))
    window, corner = _cut(right, start, half + n // 2)
    shown = {"template": template, "window": window, "corner": corner}
    whole = template.shape == (n, n) and min(window.shape, default=0) >= n
    finite = np.all(np.isfinite(template)) and np.all(np.isfinite(window))
    if whole and finite and np.ptp(template) > 0:
        shown["map"] = ncc.correlation_map(template, window)
    return shown


def _cut(
    grey: np.ndarray, centre: np.ndarray, half: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Grey values around a pixel as far as the photo reaches, and their corner."""
    size = np.array(grey.shape[::-1])
    middle = np.floor(np.clip(centre, -1e6, 1e6) + 0.5).astype(int)
    low = np.clip(middle - half, 0, size)
    high = np.clip(middle + half + 1, 0, size)
    part = np.ma.filled(grey[low[1] : high[1], low[0] : high[0]].astype(float), np.nan)
    return part, low


# --- Object space ---


def _positioned(
    session: Session, point: Measurement, distance: float = np.inf
) -> Measurement:
    """The point with its place in object space, if the photos are oriented."""
    if session.space == "none":
        return point
    xyz, C, status = _intersected(session.photos, point.photo, point.photo_covariance)
    if status != "intersected":
        return replace(point, status=f"intersection: {status}")
    depth = float(_depth(session.left, xyz))
    curve = _curve(*session.photos, point.left, (depth / 1.02, depth * 1.02))
    off = np.nan
    if len(curve) > 1:
        a, b, d = _line(curve, point.right)
        off = float(point.right @ (a, b) + d)
    point = replace(point, xyz=xyz, xyz_covariance=C, y_parallax=off)
    if abs(off) > distance:
        return replace(point, status="off the epipolar line")
    return point


def _intersected(
    photos: tuple[Photo, Photo], xy: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, str]:
    """Object point of xy (2, 2) in mm, its covariance, how the intersection ended."""
    exteriors = np.array([photo.exterior for photo in photos])
    cameras = [photo.camera for photo in photos]
    first = intersect(cameras, exteriors, xy)
    if first.status != "intersected":
        return np.full(3, np.nan), np.full((3, 3), np.nan), str(first.status)
    # One step with the weights: equal weights have brought it near enough
    parts = [
        collinearity(camera, exterior, first.points, observed, "point")
        for camera, exterior, observed in zip(cameras, exteriors, xy)
    ]
    B = np.concatenate([part.point for part in parts])
    v = np.concatenate([part.v for part in parts])
    P = np.zeros((4, 4))
    P[:2, :2], P[2:, 2:] = np.linalg.inv(covariance)
    C = np.linalg.inv(B.T @ P @ B)
    return first.points - C @ B.T @ P @ v, C, str(first.status)
