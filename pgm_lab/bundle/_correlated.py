"""What changes when x and y of a ray are correlated: P has blocks of 2 x 2.

Divided by sigma, a ray's coordinates have the covariance R of ones and the correlation
rho, and R = L Lᵀ with L = ((1, 0), (rho, s)), s^2 = 1 - rho^2. Observation equations
times L^-1 have P = 1 like all others, and nothing else of the adjustment notices. What
is said of a single coordinate afterwards needs the way back.

Foerstner and Wrobel 2016, section 4.6; the same as in `adjustment.result`.
"""

import numpy as np


def whiten(values: np.ndarray, rho: np.ndarray) -> None:
    """Multiply equations (..., 2, k) by L^-1, in place."""
    values[..., 1, :] -= rho * values[..., 0, :]
    values[..., 1, :] /= np.sqrt(1 - rho**2)


def coloured(values: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Whitened values (2, k) times L: what they were."""
    first, second = values
    return np.array([first, rho * first + np.sqrt(1 - rho**2) * second])


def shares(
    H: np.ndarray, across: np.ndarray, rho: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Redundancy numbers and testable shares (2, k) of the coordinates.

    Parameters
    ----------
    H : ndarray (2, k)
        Diagonal of A Q Aᵀ of the whitened equations.
    across : ndarray (k,)
        Its element between the two rows of a ray.
    rho : ndarray (k,)

    Returns
    -------
    redundancy_numbers : ndarray (2, k)
        Diagonal of Qvv P = 1 - L A Q Aᵀ L^-1.
    testable : ndarray (2, k)
        (P Qvv P)_ii / P_ii, with P Qvv P = L^-T (1 - A Q Aᵀ) L^-1.
    """
    s = np.sqrt(1 - rho**2)
    redundancy_numbers = 1 - H + np.array([across, -across]) * rho / s
    (g_x, g_y), g_xy = 1 - H, -across
    first = g_x * s**2 - 2 * g_xy * rho * s + g_y * rho**2
    return redundancy_numbers, np.array([first, g_y])


def alone(v: np.ndarray, sigma: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Residuals (k, 2) less what the other coordinate predicts: (P v)_i / P_ii."""
    return v - rho[:, None] * sigma / sigma[:, ::-1] * v[:, ::-1]
