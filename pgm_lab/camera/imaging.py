"""The steps from an object point to its image, and their derivatives.

Object point, ray in the camera's frame, ideal image point, displacement by the lens:
`equations` writes them out, with all derivatives, and `camera.collinearity` validates
the arguments. Nothing is checked here; complex numbers and NaN pass through; leading
axes (...) broadcast.

Vectors and matrices stand in the last axes, (..., rows, columns), but are stored with
these outermost: all values of one entry, `a[..., 0, 1]`, lie side by side in memory.
That makes hundreds of thousands of points fast without a loop over them.
"""

from collections.abc import Collection, Sequence

import numpy as np

# --- Rotation and perspective ---


def ray(
    exterior: np.ndarray, points: np.ndarray, photo: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Rays (U, V, W) = M (X - X0) of object points in the camera's frame, and M.

    M (..., 3, 3) is the derivative by (X, Y, Z), and -M the one by (X0, Y0, Z0):
    (M 2.25) to (M 2.27) and (B 4), where r, s, q stand for U, V, W.

    With `photo` (k,), that of each point, `exterior` (photos, 6) has a row a photo.
    """
    M = _of_photo(attitude(exterior), photo)
    from_centre = points - _of_photo(exterior[..., :3], photo)
    lead = np.broadcast_shapes(M.shape[:-2], from_centre.shape[:-1])
    rays = _last(np.empty((3, *lead), np.result_type(M, from_centre)))
    return np.einsum("...ij,...j->...i", M, from_centre, out=rays), M


def attitude(exterior: np.ndarray) -> np.ndarray:
    """Rotation matrices M (..., 3, 3) of exterior orientations (..., 6).

    `rotation.matrix`, (M 2.8), without validation: also for complex numbers and NaN.
    """
    (so, sp, sk), (co, cp, ck) = (
        f(_entries(exterior[..., 3:])) for f in (np.sin, np.cos)
    )
    return _matrix(
        [cp * ck, co * sk + so * sp * ck, so * sk - co * sp * ck],
        [-cp * sk, co * ck - so * sp * sk, so * ck + co * sp * sk],
        [sp, -so * cp, co * cp],
    )


def axes_of_angles(M: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Axes (..., 3, 3) of omega, phi, kappa in the camera's frame, one a column."""
    # Omega rotates about the X axis of the object, M (1, 0, 0), phi about
    # M_kappa (0, 1, 0), kappa about the z axis
    a1, a2, a3 = _entries(M[..., 0])
    sin, cos, zero = np.sin(kappa), np.cos(kappa), np.zeros_like(kappa)
    return _matrix([a1, sin, zero], [a2, cos, zero], [a3, zero, zero + 1])


def perspective(
    c: np.ndarray | float, ray: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ideal image x = -c U / W, y = -c V / W (..., 2) of rays (U, V, W).

    And its derivatives by c (..., 2, 1) and by the ray (..., 2, 3): (B 2.2a), (B 2.2b),
    (B 1a), (B 1b); (M 2.20), (M 2.21).
    """
    per_depth = -1.0 / ray[..., 2]
    x, y = ray[..., 0] * per_depth, ray[..., 1] * per_depth
    scale = c * per_depth
    zero = np.zeros_like(scale)
    by_ray = _matrix([scale, zero, scale * x], [zero, scale, scale * y])
    return _vector(c * x, c * y), _matrix([x], [y]), by_ray


# --- The lens ---


def distortion(lens: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Displacement (dx, dy) of an image point by the lens, as `camera` defines it.

    Of lens parameters (K1, K2, K3, P1, P2, b1, b2) and image points (x, y) reduced to
    the principal point, in mm: (M 2.46) to (M 2.48) radial, (M 2.52) decentring,
    (M 2.54) affinity; Brown 1971, "Close-range camera calibration", Photogrammetric
    Engineering 37(8); Fraser 1997, "Digital camera self-calibration", ISPRS Journal
    52(4).
    """
    K1, K2, K3, P1, P2, b1, b2 = _entries(lens)
    x, y = image[..., 0], image[..., 1]
    rho2 = x * x + y * y
    # P1 (rho^2 + 2 x^2) + 2 P2 x y = P1 rho^2 + 2 x (P1 x + P2 y), the same in y
    along = rho2 * (K1 + rho2 * (K2 + rho2 * K3)) + 2 * (P1 * x + P2 * y)
    return _vector(x * along + P1 * rho2 + b1 * x + b2 * y, y * along + P2 * rho2)


def distortion_by_image(lens: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Derivatives (..., 2, 2) of the displacement by (x, y).

    A of (M 2.80) is the unit matrix plus these, and nearly the unit matrix.
    """
    K1, K2, K3, P1, P2, b1, b2 = _entries(lens)
    x, y = image[..., 0], image[..., 1]
    rho2 = x * x + y * y
    radial = rho2 * (K1 + rho2 * (K2 + rho2 * K3))
    slope = 2 * (K1 + rho2 * (2 * K2 + rho2 * 3 * K3))  # d radial / dx = slope * x
    mixed = x * y * slope + 2 * (P1 * y + P2 * x)
    return _matrix(
        [radial + x * x * slope + 6 * P1 * x + 2 * P2 * y + b1, mixed + b2],
        [mixed, radial + y * y * slope + 6 * P2 * y + 2 * P1 * x],
    )


def distortion_by_lens(image: np.ndarray) -> np.ndarray:
    """Derivatives (..., 2, 7) of the displacement by (K1, K2, K3, P1, P2, b1, b2).

    The columns of A3, (M 2.89), which has rho where rho^2 belongs.
    """
    x, y = image[..., 0], image[..., 1]
    xx, xy, yy = x * x, 2 * x * y, y * y
    rho2 = xx + yy
    r4 = rho2 * rho2
    r6, zero = r4 * rho2, np.zeros_like(x)
    return _matrix(
        [x * rho2, x * r4, x * r6, rho2 + 2 * xx, xy, x, y],
        [y * rho2, y * r4, y * r6, xy, rho2 + 2 * yy, zero, zero],
    )


def undistort(lens: np.ndarray, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solve x + d(x) = image for x (..., 2) by Newton's method.

    Also returns where it is solved (...): not where the iteration does not converge, or
    only to a ghost, a point beyond the radius where the curve of the lens turns back.
    """
    x = image
    with np.errstate(all="ignore"):  # what overflows is not solved
        for _ in range(30):
            a, b, c, d = _jacobian(lens, x)
            u, v = _entries(image - x - distortion(lens, x))
            step = _vector(d * u - b * v, a * v - c * u) / (a * d - b * c)[..., None]
            x = x + step
            # Newton squares the error: after such a step only rounding is left
            solved = np.hypot(*_entries(step)) <= 1e-9 * np.hypot(*_entries(image))
            if np.all(solved):
                break
        return x, solved & ~beyond_fold(lens, x)


def beyond_fold(lens: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Whether the lens turns back on the way out to image points x (..., 2): (...)."""
    folded = np.zeros(x.shape[:-1], bool)
    # A distortion too small to turn back, wherever x lies: nothing to look for
    K1, K2, K3, P1, P2, b1, b2 = np.abs(_entries(lens))
    with np.errstate(all="ignore"):
        rho = np.max(np.hypot(*_entries(x)), initial=0)
        radial = rho**2 * (3 * K1 + rho**2 * (5 * K2 + rho**2 * 7 * K3))
    if np.all(radial + 8 * rho * (P1 + P2) + b1 + b2 < 0.9):
        return folded
    with np.errstate(all="ignore"):
        for part in np.linspace(0.1, 1, 10):
            a, b, c, d = _jacobian(lens, part * x)
            folded = folded | ~((a * d > b * c) & (a + d > 0))
    return folded


def _jacobian(lens: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Entries a, b, c, d of the derivatives of x + d(x) by x."""
    by_x = distortion_by_image(lens, x)
    return 1 + by_x[..., 0, 0], by_x[..., 0, 1], by_x[..., 1, 0], 1 + by_x[..., 1, 1]


# --- The collinearity equations ---


def misclosure(
    interior: np.ndarray,
    exterior: np.ndarray,
    points: np.ndarray,
    measured: np.ndarray,
    lens: str,
    wrt: Collection[str],
    photo: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Misclosure v (..., 2), depth (...), derivatives (..., 2, n): see `equations`."""
    v, depth, by = equations(interior, exterior, points, measured, lens, wrt, photo)
    for name, rows in by.items():
        if rows.shape[1:] != v.shape:
            rows = np.broadcast_to(rows, (len(rows), *v.shape))
        by[name] = _last(rows, 2).swapaxes(-1, -2)
    return _last(v), np.broadcast_to(depth, v.shape[1:]), by


def equations(
    interior: np.ndarray,
    exterior: np.ndarray,
    points: np.ndarray,
    measured: np.ndarray,
    lens: str,
    wrt: Collection[str],
    photo: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Misclosure v (2, ...) of the collinearity equations, depth (...), derivatives.

    As `camera.collinearity`, unchecked: (M 2.20) to (M 2.29), (M 2.80), (M 2.89), as
    mended. The derivatives (n, 2, ...) stand by "interior", "exterior", "point", as far
    as `wrt` asks for them. With `photo` (k,), exterior and interior (photos, 10) have a
    row for each photo.
    """
    M, exterior = _of_photo(attitude(exterior), photo), _of_photo(exterior, photo)
    interior = _of_photo(interior, photo) if interior.ndim > 1 else interior
    axes = max(a.ndim for a in (interior, exterior, points, measured)) - 1
    interior, exterior = _first(interior, axes), _first(exterior, axes)
    c, centre, parameters = interior[0], interior[1:3], interior[3:]
    M, reduced = _first(M, axes, 2), _first(measured, axes) - centre

    # The ray and its ideal image, (M 2.20) to (M 2.27); the lens moves it, (M 2.46)
    dX, dY, dZ = _first(points, axes) - exterior[:3]
    U, V, W = M[:, 0] * dX + M[:, 1] * dY + M[:, 2] * dZ
    by_c = np.array([U, V]) / -W
    x, y = ideal = c * by_c
    forward = lens == "forward"
    at = _last(ideal if forward else reduced)
    moved = _first(distortion(_last(parameters), at), axes)
    v = ideal + moved - reduced if forward else ideal - moved - reduced
    if wrt and (forward or "interior" in wrt):  # (M 2.80)
        A = _first(distortion_by_image(_last(parameters), at), axes, 2)
        A[0, 0] += 1
        A[1, 1] += 1

    # Derivatives by the ideal x and y, and by c, which a forward lens moves too
    by_x, by_y = np.eye(2).reshape(2, 2, *[1] * axes)
    if wrt and forward:
        by_x, by_y = A[:, 0], A[:, 1]
        by_c = by_x * by_c[0] + by_y * by_c[1]
    by = {}
    if "interior" in wrt:  # (M 2.55), (M 2.89)
        by_lens = _first(distortion_by_lens(at), axes, 2).swapaxes(0, 1)
        rows = by["interior"] = np.empty((10, *v.shape), v.dtype)
        rows[0] = by_c
        if forward:
            rows[1:3], rows[3:] = np.eye(2).reshape(2, 2, *[1] * axes), by_lens
        else:
            rows[1:3] = A.swapaxes(0, 1)
            np.negative(by_lens, out=rows[3:])
    if "exterior" in wrt or "point" in wrt:
        m1, m2, m3 = M[:, :, None]  # (M 2.24), b14 to b26
        by["point"] = c / -W * (m1 * by_x + m2 * by_y + m3 * by_c)
    if "exterior" in wrt:
        # (M 2.24), b11 to b23: first by rotations about the axes of the camera, then by
        # the angles, whose axes are the columns of `axes_of_angles`
        by_1, by_2, by_3 = (
            -c * by_y - y * by_c,
            c * by_x + x * by_c,
            y * by_x - x * by_y,
        )
        a1, a2, a3 = M[:, 0]
        by_omega = a1 * by_1 + a2 * by_2 + a3 * by_3
        by_phi = np.sin(exterior[5]) * by_1 + np.cos(exterior[5]) * by_2
        by["exterior"] = np.concatenate([-by["point"], [by_omega, by_phi, by_3]])
    return v, -W, {name: by[name] for name in wrt}


# --- Small vectors and matrices, stored entry by entry ---


def _of_photo(values: np.ndarray, photo: np.ndarray | None) -> np.ndarray:
    """Values (k, ...) of each point's photo from those (photos, ...) of the photos."""
    if photo is None:
        return values
    return values.T.take(photo, axis=-1).T


def _entries(values: np.ndarray) -> np.ndarray:
    """View (n, ...) of values (..., n), to be unpacked into their entries."""
    return values.transpose(-1, *range(values.ndim - 1))


def _vector(*parts: np.ndarray) -> np.ndarray:
    """Array (..., n) of n entries of the same shape."""
    return _last(np.array(parts))


def _matrix(*rows: Sequence[np.ndarray]) -> np.ndarray:
    """Array (..., n, k) of n rows of k entries of the same shape."""
    return _last(np.array(rows), 2)


def _first(values: np.ndarray, leading: int, axes: int = 1) -> np.ndarray:
    """View of values (..., n) or (..., n, k) with the last axes first."""
    # The others become as many as `leading`, so that they broadcast as they did
    missing = leading + axes - values.ndim
    values = values[(None,) * missing] if missing else values
    return values.transpose(*range(leading, values.ndim), *range(leading))


def _last(values: np.ndarray, axes: int = 1) -> np.ndarray:
    """View of values (n, ...) or (n, k, ...) with the first axes last."""
    return values.transpose(*range(axes, values.ndim), *range(axes))
