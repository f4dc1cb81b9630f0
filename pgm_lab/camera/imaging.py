"""The steps from an object point to its image, and their derivatives.

Object point, ray in the camera's frame, ideal image point, displacement by the lens:
`equations` writes them out, with all derivatives, and `camera.collinearity` checks what
comes in. Nothing is checked here; complex numbers and NaN pass through; leading axes
broadcast.

Matrices of derivatives stand in the last two axes, (..., rows, columns), but are stored
with these outermost: all values of one entry, `a[..., 0, 1]`, lie side by side in the
memory. That makes hundreds of thousands of points fast without a loop over them.
"""

from collections.abc import Collection

import numpy as np

from pgm_lab.camera._lens import distortion, distortion_by_image, distortion_by_lens
from pgm_lab.camera._stacks import (
    entries,
    first,
    last,
    matrix,
    of_photo,
    product,
    vector,
)


def ray(
    exterior: np.ndarray, points: np.ndarray, photo: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Turn object points into rays (U, V, W) = M (X - X0) of the camera's frame.

    Parameters
    ----------
    exterior : ndarray (..., 6)
        (X0, Y0, Z0, omega, phi, kappa), in the unit of the points and radians.
    points : ndarray (..., 3)
        Object points.
    photo : ndarray (k,) of int, optional
        The photo of each of k points; `exterior` (photos, 6) then has a row a photo,
        and each rotation is computed once.

    Returns
    -------
    ray : ndarray (..., 3)
        In the unit of the points.
    by_point : ndarray (..., 3, 3)
        Derivatives by (X, Y, Z): this is M, as from `rotation.matrix`. Those by
        (X0, Y0, Z0) are -M.

    References
    ----------
    (M 2.25) to (M 2.27) and (B 4), where r, s, q stand for U, V, W.
    """
    M = of_photo(attitude(exterior), photo)
    from_centre = points - of_photo(exterior[..., :3], photo)
    return product(M, from_centre[..., None])[..., 0], M


def axes_of_angles(M: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Axes (..., 3, 3), one a column, about which omega, phi and kappa turn a camera.

    In the camera's frame: omega turns about the X axis of the object, M (1, 0, 0), phi
    about M_kappa (0, 1, 0), kappa about the z axis.
    """
    a1, a2, a3 = entries(M[..., 0])
    sin, cos, zero = np.sin(kappa), np.cos(kappa), np.zeros_like(kappa)
    return matrix([a1, sin, zero], [a2, cos, zero], [a3, zero, zero + 1])


def attitude(exterior: np.ndarray) -> np.ndarray:
    """Rotation matrices M (..., 3, 3) of exterior orientations (..., 6).

    The same as `rotation.matrix`, (M 2.8), which refuses the complex and the not
    finite.
    """
    angles = entries(exterior[..., 3:])
    (so, sp, sk), (co, cp, ck) = np.sin(angles), np.cos(angles)
    return matrix(
        [cp * ck, co * sk + so * sp * ck, so * sk - co * sp * ck],
        [-cp * sk, co * ck - so * sp * sk, so * ck + co * sp * sk],
        [sp, -so * cp, co * cp],
    )


def perspective(
    c: np.ndarray | float, ray: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Project rays onto the image plane: x = -c U / W, y = -c V / W.

    Parameters
    ----------
    c : float or ndarray (...)
        Principal distance.
    ray : ndarray (..., 3)
        (U, V, W), as from `ray`.

    Returns
    -------
    image : ndarray (..., 2)
        Ideal image coordinates, reduced to the principal point; unit of c.
    by_c : ndarray (..., 2, 1)
        Derivatives by c.
    by_ray : ndarray (..., 2, 3)
        Derivatives by (U, V, W).

    References
    ----------
    (B 2.2a), (B 2.2b), (B 1a), (B 1b); (M 2.20), (M 2.21).
    """
    per_depth = -1.0 / ray[..., 2]
    x, y = ray[..., 0] * per_depth, ray[..., 1] * per_depth
    scale = c * per_depth
    zero = np.zeros_like(scale)
    by_ray = matrix([scale, zero, scale * x], [zero, scale, scale * y])
    return vector(c * x, c * y), matrix([x], [y]), by_ray


def misclosure(
    interior: np.ndarray,
    exterior: np.ndarray,
    points: np.ndarray,
    measured: np.ndarray,
    lens: str,
    wrt: Collection[str],
    photo: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Put the steps together: see `camera.collinearity`, which checks what comes in.

    With `photo` (k,), exterior and interior (photos, 10) have a row for each photo.

    Returns
    -------
    v : ndarray (..., 2)
    depth : ndarray (...)
    derivatives : dict
        Of v (..., 2, n), by "interior", "exterior", "point", as far as asked for.
    """
    v, depth, by = equations(interior, exterior, points, measured, lens, wrt, photo)
    for name, rows in by.items():
        if rows.shape[1:] != v.shape:
            rows = np.broadcast_to(rows, (len(rows), *v.shape))
        by[name] = last(rows, 2).swapaxes(-1, -2)
    return last(v), np.broadcast_to(depth, v.shape[1:]), by


def equations(
    interior: np.ndarray,
    exterior: np.ndarray,
    points: np.ndarray,
    measured: np.ndarray,
    lens: str,
    wrt: Collection[str],
    photo: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Write the collinearity equations out: as `misclosure`, a line for each unknown.

    Returns
    -------
    v : ndarray (2, ...)
    depth : ndarray (...)
    derivatives : dict
        Of v: (n, 2, ...).

    References
    ----------
    (M 2.20) to (M 2.29), (M 2.80), (M 2.89), as mended.
    """
    M, exterior = of_photo(attitude(exterior), photo), of_photo(exterior, photo)
    interior = of_photo(interior, photo) if interior.ndim > 1 else interior
    axes = max(a.ndim for a in (interior, exterior, points, measured)) - 1
    interior, exterior = first(interior, axes), first(exterior, axes)
    c, centre, parameters = interior[0], interior[1:3], interior[3:]
    M, reduced = first(M, axes, 2), first(measured, axes) - centre

    # The ray and its ideal image, (M 2.20) to (M 2.27); the lens moves it, (M 2.46)
    dX, dY, dZ = first(points, axes) - exterior[:3]
    U, V, W = M[:, 0] * dX + M[:, 1] * dY + M[:, 2] * dZ
    by_c = np.array([U, V]) / -W
    x, y = ideal = c * by_c
    forward = lens == "forward"
    at = last(ideal if forward else reduced)
    moved = first(distortion(last(parameters), at), axes)
    v = ideal + moved - reduced if forward else ideal - moved - reduced
    if wrt and (forward or "interior" in wrt):  # (M 2.80)
        A = first(distortion_by_image(last(parameters), at), axes, 2)
        A[0, 0] += 1
        A[1, 1] += 1

    # Derivatives by the ideal x and y, and by c, which a forward lens moves too
    by_x, by_y = np.eye(2).reshape(2, 2, *[1] * axes)
    if wrt and forward:
        by_x, by_y = A[:, 0], A[:, 1]
        by_c = by_x * by_c[0] + by_y * by_c[1]
    by = {}
    if "interior" in wrt:  # (M 2.55), (M 2.89)
        by_lens = first(distortion_by_lens(at), axes, 2).swapaxes(0, 1)
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
        # (M 2.24), b11 to b23: first by turns about the axes of the camera
        by_turn = -c * by_y - y * by_c, c * by_x + x * by_c, y * by_x - x * by_y
        by["exterior"] = np.concatenate(
            [-by["point"], _by_angles(by_turn, M[:, 0], exterior[5])]
        )
    return v, -W, {name: by[name] for name in wrt}


def _by_angles(
    by_turn: tuple[np.ndarray, ...], X_axis: np.ndarray, kappa: np.ndarray
) -> list[np.ndarray]:
    """Derivatives by omega, phi and kappa from those by turns about x, y and z.

    The columns of `axes_of_angles`: omega turns about the X axis of the object.
    """
    by_1, by_2, by_3 = by_turn
    a1, a2, a3 = X_axis
    by_omega = a1 * by_1 + a2 * by_2 + a3 * by_3
    return [by_omega, np.sin(kappa) * by_1 + np.cos(kappa) * by_2, by_3]
