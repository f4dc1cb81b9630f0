"""Least squares in a few lines, as lesson A1 writes it: to be read.

`pgm_lab.adjustment` does the same for any model, with constraints, and says what went
wrong. `redundancy_numbers` and `suspect` look for blunders; `ellipse` shows how precise
a point is.
"""

import numpy as np

from pgm_lab.adjustment.outliers import critical_w


def normal_equations(
    A: np.ndarray, p: np.ndarray, observed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Normal matrix N and right-hand side n of observation equations.

    Parameters
    ----------
    A : array_like (n, u)
        Design matrix: the change of each observation per unit of each unknown.
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

    References
    ----------
    Muliawan 2013, (M 2.70) and (M 2.78); (B 6) to (B 8), without weights.

    Examples
    --------
    >>> normal_equations([[1], [1]], [1, 3], [2.0, 6.0])
    (array([[4.]]), array([20.]))
    """
    A, p, observed = np.asarray(A, float), np.asarray(p, float), np.asarray(observed)
    if p.shape != (len(A),):
        raise ValueError(
            f"p must hold one weight for each row of A, shape ({len(A)},); it has the"
            f" shape {p.shape}. For equal weights: np.ones({len(A)})"
        )
    if not np.all(p > 0):
        raise ValueError("p must be positive: leave out observations without weight")
    return A.T @ (p[:, None] * A), A.T @ (p * observed)


def adjust(
    A: np.ndarray, p: np.ndarray, observed: np.ndarray
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
        If the observations do not determine the unknowns, or only so weakly that
        rounding spoils them, or a weight is not positive.

    Examples
    --------
    >>> x, v, sigma0, Q = adjust([[1], [1]], [1, 3], [2.0, 6.0])
    >>> print(x, v, sigma0.round(2), Q)
    [5.] [ 3. -1.] 3.46 [[0.25]]
    """
    A, p = np.asarray(A, float), np.asarray(p, float)
    N, n = normal_equations(A, p, observed)
    redundancy = len(A) - A.shape[1]
    rank = np.linalg.matrix_rank(np.sqrt(p)[:, None] * A)
    if redundancy < 0 or rank < A.shape[1]:
        raise ValueError(
            f"the {len(A)} observations do not determine all {A.shape[1]} unknowns:"
            " measure more, or hold some of them fixed"
        )
    scale = np.sqrt(np.diag(N))
    if np.linalg.cond(N / np.outer(scale, scale)) > 1e8:
        raise ValueError(
            "the columns of A depend on one another so nearly that N loses more than"
            " half of its digits. Are there large coordinates, such as UTM? Subtract"
            " their mean first: reduce them to their centre"
        )
    Q = np.linalg.inv(N)
    x = Q @ n
    v = A @ x - observed
    sigma0 = np.sqrt(p @ v**2 / redundancy) if redundancy else np.nan
    return x, v, sigma0, Q


def redundancy_numbers(A: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Share of each observation in the redundancy, 0 to 1; their sum is the redundancy.

    It is the part of an observation's own error that its residual shows: 1 - p a' Q a.

    References
    ----------
    Baarda 1968, "A testing procedure for use in geodetic networks".

    Examples
    --------
    >>> redundancy_numbers([[1], [1]], [1, 3])
    array([0.75, 0.25])
    """
    A, p = np.asarray(A, float), np.asarray(p, float)
    _, _, _, Q = adjust(A, p, np.zeros(len(p)))
    return 1 - p * np.einsum("ni,ij,nj->n", A, Q, A)


def suspect(v: np.ndarray, sigma: np.ndarray, r: np.ndarray) -> int:
    """Row of the observation that Baarda's test suspects most, or -1 for none.

    Parameters
    ----------
    v : array_like (n,)
        Residuals.
    sigma : array_like (n,)
        Standard deviations of the observations, as stated beforehand; in the unit of
        `v`.
    r : array_like (n,)
        Redundancy numbers; where one is 0 the observation is uncontrolled.

    Returns
    -------
    int
        Where Baarda's |w|, the residual divided by its own standard deviation, is
        largest, if it is above 3.29.

    References
    ----------
    Baarda 1968, "A testing procedure for use in geodetic networks".

    Examples
    --------
    >>> suspect([4.0, -9.0, -3.0], [2.0, 5.0, 1.2], [0.6, 0.7, 0.12])
    2
    """
    v, sigma, r = np.asarray(v, float), np.asarray(sigma, float), np.asarray(r, float)
    if not v.shape == sigma.shape == r.shape:
        raise ValueError(
            "v, sigma and r must be numbers of the same observations; got shapes"
            f" {v.shape}, {sigma.shape} and {r.shape}"
        )
    controlled = r > 1e-9
    w = np.zeros(len(v))
    w[controlled] = np.abs(v / sigma)[controlled] / np.sqrt(r[controlled])
    return int(np.argmax(w)) if w.max() > critical_w() else -1


def ellipse(covariance: np.ndarray) -> np.ndarray:
    """Semi-axes of the standard error ellipse of a point, and its direction.

    Parameters
    ----------
    covariance : array_like (2, 2)
        Covariance of the two coordinates.

    Returns
    -------
    ndarray (3,)
        The longer and the shorter semi-axis in the unit of the coordinates, and the
        direction of the longer one in degrees, 0 to 180, from the x axis towards y.
        Multiplied by 2.45, the semi-axes are those of the 95 per cent ellipse.

    Examples
    --------
    >>> ellipse([[2.5, 1.5], [1.5, 2.5]]).round(6)
    array([ 2.,  1., 45.])
    """
    variance, axes = np.linalg.eigh(covariance)  # in ascending order
    if variance[0] < -1e-9 * variance[1]:
        raise ValueError("covariance is not positive semi-definite")
    direction = np.degrees(np.arctan2(axes[1, 1], axes[0, 1])) % 180
    long, short = np.sqrt(np.maximum(variance[::-1], 0))
    return np.array([long, short, direction])
