"""Least squares in a few lines, as lesson A1 writes it: to be read.

`core` does the same for any model, with constraints, and says what went wrong.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


def normal_equations(
    A: ArrayLike, p: ArrayLike, observed: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix N and right-hand side n of observation equations.

    Parameters
    ----------
    A : array_like (n, u)
        Design matrix: what each observation changes by for one unit of each unknown.
    p : array_like (n,)
        Weights, the reciprocal variances up to a common factor.
    observed : array_like (n,)
        The observations, or observed minus computed where the model is linearised.

    Returns
    -------
    N : ndarray (u, u)
        The sum of p a a' over the rows a of A.
    n : ndarray (u,)
        The sum of p a l over the rows.

    Raises
    ------
    ValueError
        If the shapes do not fit, or a number is not finite, or a weight not positive.

    References
    ----------
    Muliawan 2013, (M 2.70) and (M 2.78); (B 6) to (B 8), without weights.

    Examples
    --------
    >>> normal_equations([[1], [1]], [1, 3], [2.0, 6.0])
    (array([[4.]]), array([20.]))
    """
    A, p, observed = _checked(A, p, observed)
    return A.T @ (p[:, None] * A), A.T @ (p * observed)


def adjust(
    A: ArrayLike, p: ArrayLike, observed: ArrayLike
) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """Adjust observations by least squares.

    Parameters
    ----------
    A, p, observed
        As for `normal_equations`.

    Returns
    -------
    x : ndarray (u,)
        The unknowns, or their corrections where the model is linearised.
    v : ndarray (n,)
        Residuals, computed minus observed.
    sigma0 : float
        Standard deviation of an observation of weight 1; NaN without redundancy.
    Q : ndarray (u, u)
        Cofactor matrix of x: sigma0 squared times Q is its covariance.

    Raises
    ------
    ValueError
        As for `normal_equations`, or if the observations do not determine the unknowns.

    Examples
    --------
    >>> x, v, sigma0, Q = adjust([[1], [1]], [1, 3], [2.0, 6.0])
    >>> print(x, v, sigma0.round(2), Q)
    [5.] [ 3. -1.] 3.46 [[0.25]]
    """
    A, p, observed = _checked(A, p, observed)
    redundancy = len(A) - A.shape[1]
    roots = np.sqrt(p)[:, None]
    if redundancy < 0 or np.linalg.matrix_rank(roots * A) < A.shape[1]:
        raise ValueError(
            f"the {len(A)} observations do not determine all {A.shape[1]} unknowns:"
            " measure more, or hold some of them fixed"
        )
    N, n = normal_equations(A, p, observed)
    Q = np.linalg.inv(N)
    x = Q @ n
    v = A @ x - observed
    sigma0 = np.sqrt(p @ v**2 / redundancy) if redundancy else np.nan
    return x, v, sigma0, Q


def _checked(
    A: ArrayLike, p: ArrayLike, observed: ArrayLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the arguments as arrays whose shapes fit."""
    A = _validate.finite(A, "A")
    p = _validate.finite(p, "p")
    observed = _validate.finite(observed, "observed")
    if A.ndim != 2 or p.shape != A.shape[:1] or observed.shape != A.shape[:1]:
        raise ValueError(
            "A must have shape (n, u), p and observed (n,); got"
            f" {A.shape}, {p.shape} and {observed.shape}"
        )
    if not np.all(p > 0):
        raise ValueError("p must be positive: leave out what has no weight")
    return A, p, observed
