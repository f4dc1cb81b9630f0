"""The steps from an object point to its image, each with its derivatives.

Object point, ray in the camera's frame, ideal image point, displacement by the lens:
`camera.collinearity` puts them together. Nothing is checked here; complex numbers and
NaN pass through; leading axes broadcast.

Matrices of derivatives stand in the last two axes, (..., rows, columns), but are stored
with these outermost: all values of one entry, `a[..., 0, 1]`, lie side by side in the
memory. That makes hundreds of thousands of points fast without a loop over them.
"""

from collections.abc import Collection

import numpy as np

from pgm_lab.camera._stacks import (
    entries,
    matrix,
    of_photo,
    product,
    side_by_side,
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


def ray_by_angles(ray: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Derivatives (..., 3, 3) of the ray by (omega, phi, kappa).

    To change an angle is to turn the camera about an axis a, and the ray then moves by
    (U, V, W) x a. `axes` are those of `axes_of_angles`.
    """
    a1, a2, a3 = axes[..., 0, 0], axes[..., 1, 0], axes[..., 2, 0]
    sin, cos = axes[..., 0, 1], axes[..., 1, 1]
    U, V, W = entries(ray)
    return matrix(
        [V * a3 - W * a2, -W * cos, V],
        [W * a1 - U * a3, W * sin, -U],
        [U * a2 - V * a1, U * cos - V * sin, 0.0],
    )


def axes_of_angles(M: np.ndarray, kappa: np.ndarray) -> np.ndarray:
    """Axes (..., 3, 3), one a column, about which omega, phi and kappa turn a camera.

    In the camera's frame: omega turns about the X axis of the object, M (1, 0, 0), phi
    about M_kappa (0, 1, 0), kappa about the z axis.
    """
    M1, sin, cos = M[..., 0], np.sin(kappa), np.cos(kappa)
    return matrix(
        [M1[..., 0], sin, 0.0], [M1[..., 1], cos, 0.0], [M1[..., 2], 0.0, 1.0]
    )


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
    by_ray = matrix([scale, 0.0, scale * x], [0.0, scale, scale * y])
    return vector(c * x, c * y), matrix([x], [y]), by_ray


def distortion(lens: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Displacement (dx, dy) of an image point by the lens, as `camera` defines it.

    Parameters
    ----------
    lens : ndarray (..., 7)
        (K1, K2, K3, P1, P2, b1, b2).
    image : ndarray (..., 2)
        (x, y) reduced to the principal point, in mm.

    Returns
    -------
    ndarray (..., 2)
        (dx, dy) in mm.

    References
    ----------
    Muliawan 2013, (M 2.46) to (M 2.48) radial, (M 2.52) decentring, (M 2.54) affinity;
    Brown 1971, "Close-range camera calibration", Photogrammetric Engineering 37(8);
    Fraser 1997, "Digital camera self-calibration", ISPRS Journal 52(4).
    """
    K1, K2, K3, P1, P2, b1, b2 = entries(lens)
    x, y = image[..., 0], image[..., 1]
    r2 = x * x + y * y
    # P1 (r^2 + 2 x^2) + 2 P2 x y = P1 r^2 + 2 x (P1 x + P2 y), the same in y
    along = r2 * (K1 + r2 * (K2 + r2 * K3)) + 2 * (P1 * x + P2 * y)
    return vector(x * along + P1 * r2 + b1 * x + b2 * y, y * along + P2 * r2)


def distortion_by_image(lens: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Derivatives (..., 2, 2) of the displacement by (x, y).

    A of (M 2.80) is the unit matrix plus these, and nearly the unit matrix.
    """
    K1, K2, K3, P1, P2, b1, b2 = entries(lens)
    x, y = image[..., 0], image[..., 1]
    r2 = x * x + y * y
    radial = r2 * (K1 + r2 * (K2 + r2 * K3))
    slope = 2 * (K1 + r2 * (2 * K2 + r2 * 3 * K3))  # d radial / dx = slope * x
    mixed = x * y * slope + 2 * (P1 * y + P2 * x)
    return matrix(
        [radial + x * x * slope + 6 * P1 * x + 2 * P2 * y + b1, mixed + b2],
        [mixed, radial + y * y * slope + 6 * P2 * y + 2 * P1 * x],
    )


def distortion_by_lens(image: np.ndarray) -> np.ndarray:
    """Derivatives (..., 2, 7) of the displacement by (K1, K2, K3, P1, P2, b1, b2).

    The columns of A3, (M 2.89), which has r where r^2 belongs.
    """
    x, y = image[..., 0], image[..., 1]
    xx, xy, yy = x * x, 2 * x * y, y * y
    r2 = xx + yy
    r4 = r2 * r2
    r6 = r4 * r2
    return matrix(
        [x * r2, x * r4, x * r6, r2 + 2 * xx, xy, x, y],
        [y * r2, y * r4, y * r6, xy, r2 + 2 * yy, 0.0, 0.0],
    )


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
        Of v, by "interior", "exterior" and "point", as far as asked for.
    """
    if interior.ndim > 1:
        interior = of_photo(interior, photo)
    c, centre, lens_parameters = interior[..., 0], interior[..., 1:3], interior[..., 3:]
    rays, M = ray(exterior, points, photo)
    image, by_c, by_ray = perspective(c, rays)
    distorted = measured - centre if lens == "backward" else image
    if "interior" in wrt:  # the displacement is linear in the parameters of the lens
        by_lens = distortion_by_lens(distorted)
        moved = product(by_lens, lens_parameters[..., None])[..., 0]
    else:
        moved = distortion(lens_parameters, distorted)
    if wrt and (lens == "forward" or "interior" in wrt):
        through_lens = np.eye(2) + distortion_by_image(lens_parameters, distorted)
    blocks = {}
    if lens == "backward":
        v = image - distorted - moved
        if "interior" in wrt:
            blocks["interior"] = side_by_side(by_c, through_lens, -by_lens)
    else:
        v = image + moved + centre - measured
        if wrt:
            by_c, by_ray = product(through_lens, by_c), product(through_lens, by_ray)
        if "interior" in wrt:
            blocks["interior"] = side_by_side(by_c, np.eye(2), by_lens)
    if "exterior" in wrt or "point" in wrt:
        by_point = product(by_ray, M)
    if "exterior" in wrt:
        axes = axes_of_angles(M, of_photo(exterior[..., 5], photo))
        by_angles = product(by_ray, ray_by_angles(rays, axes))
        blocks["exterior"] = np.concatenate([-by_point, by_angles], axis=-1)
    if "point" in wrt:
        blocks["point"] = by_point
    for name, block in blocks.items():
        if block.shape[:-1] != v.shape:
            blocks[name] = np.broadcast_to(block, (*v.shape, block.shape[-1]))
    return v, np.broadcast_to(-rays[..., 2], v.shape[:-1]), blocks


def undistort(lens: np.ndarray, image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Solve x + d(x) = image for x by Newton's method.

    Parameters
    ----------
    lens : ndarray (..., 7)
        (K1, K2, K3, P1, P2, b1, b2).
    image : ndarray (..., 2)
        Points that the lens displaced, reduced to the principal point, in mm.

    Returns
    -------
    x : ndarray (..., 2)
    solved : ndarray (...) of bool
        False where the iteration does not converge, or only to a ghost: a point
        beyond the radius where the curve of the lens turns back.
    """
    x = image
    with np.errstate(all="ignore"):  # what overflows is not solved
        for _ in range(30):
            a, b, c, d = _entries(distortion_by_image(lens, x))
            u, v = np.moveaxis(image - x - distortion(lens, x), -1, 0)
            step = vector(d * u - b * v, a * v - c * u) / (a * d - b * c)[..., None]
            x = x + step
            # Newton squares the error: after such a step only rounding is left
            solved = np.hypot(*_xy(step)) <= 1e-9 * np.hypot(*_xy(image))
            if np.all(solved):
                break
        for part in np.linspace(0.1, 1, 10):  # no turn on the way out to x
            a, b, c, d = _entries(distortion_by_image(lens, part * x))
            solved = solved & (a * d > b * c) & (a + d > 0)
    return x, solved


def _xy(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return image[..., 0], image[..., 1]


def _entries(by_x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Entries a, b, c, d of the derivative of x + d(x)."""
    return 1 + by_x[..., 0, 0], by_x[..., 0, 1], by_x[..., 1, 0], 1 + by_x[..., 1, 1]
