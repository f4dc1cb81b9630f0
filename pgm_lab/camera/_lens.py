"""The lens: how it displaces an image point, and the way back."""

import numpy as np

from pgm_lab.camera._stacks import entries, matrix, vector


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
    rho2 = x * x + y * y
    # P1 (rho^2 + 2 x^2) + 2 P2 x y = P1 rho^2 + 2 x (P1 x + P2 y), the same in y
    along = rho2 * (K1 + rho2 * (K2 + rho2 * K3)) + 2 * (P1 * x + P2 * y)
    return vector(x * along + P1 * rho2 + b1 * x + b2 * y, y * along + P2 * rho2)


def distortion_by_image(lens: np.ndarray, image: np.ndarray) -> np.ndarray:
    """Derivatives (..., 2, 2) of the displacement by (x, y).

    A of (M 2.80) is the unit matrix plus these, and nearly the unit matrix.
    """
    K1, K2, K3, P1, P2, b1, b2 = entries(lens)
    x, y = image[..., 0], image[..., 1]
    rho2 = x * x + y * y
    radial = rho2 * (K1 + rho2 * (K2 + rho2 * K3))
    slope = 2 * (K1 + rho2 * (2 * K2 + rho2 * 3 * K3))  # d radial / dx = slope * x
    mixed = x * y * slope + 2 * (P1 * y + P2 * x)
    return matrix(
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
    return matrix(
        [x * rho2, x * r4, x * r6, rho2 + 2 * xx, xy, x, y],
        [y * rho2, y * r4, y * r6, xy, rho2 + 2 * yy, zero, zero],
    )


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
