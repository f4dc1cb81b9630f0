"""Is it a rotation? Orthogonality, determinant, and the nearest rotation."""

import warnings

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


def defect(M: ArrayLike) -> np.ndarray | float:
    """Largest element of |M Mᵀ - I|: how far a matrix is from being orthogonal.

    A reflection has no defect either; its determinant is -1.

    References
    ----------
    (M 2.11), (M 2.12).

    Examples
    --------
    >>> print(f"{defect([[1, 0, 0], [0, 1, 0.1], [0, 0, 1]]):.2f}")
    0.10
    """
    M = _square(M)
    return np.abs(M @ np.swapaxes(M, -1, -2) - np.eye(3)).max(axis=(-2, -1))


def nearest(M: ArrayLike) -> np.ndarray:
    """Rotation nearest to a matrix: the sum of squared differences is smallest.

    Raises
    ------
    ValueError
        If a determinant is not positive: the matrix mirrors or flattens space.

    Examples
    --------
    >>> nearest([[0.7, 0.9, 0.0], [-0.9, 0.7, 0.0], [0.0, 0.0, 1.0]]).round(3) + 0.0
    array([[ 0.614,  0.789,  0.   ],
           [-0.789,  0.614,  0.   ],
           [ 0.   ,  0.   ,  1.   ]])
    """
    M = _square(M)
    bad = np.linalg.det(M) <= 0
    if np.any(bad):
        raise ValueError(
            f"the determinant of {which(bad)} is not positive: the matrix mirrors or"
            " flattens space, and no rotation is near. Check the sign of each row and"
            " column"
        )
    return best_fit(M)[0]


def best_fit(product: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Rotation R for which R s comes nearest to t, summed over pairs of vectors.

    Parameters
    ----------
    product : array_like (..., 3, 3)
        Sum of t s' over the pairs, with their weights if they have any.

    Returns
    -------
    R : ndarray (..., 3, 3)
        Least sum of |t - R s|^2 among the rotations.
    singular : ndarray (..., 3)
        Singular values of the product, the largest first; their sum is that of all
        tᵀ R s. The last is negative if a reflection would come nearer.

    Raises
    ------
    ValueError
        If the shape is wrong or a number is not finite.

    References
    ----------
    Umeyama 1991, "Least-squares estimation of transformation parameters between two
    point patterns", IEEE PAMI 13(4).

    Examples
    --------
    >>> source = np.eye(3)
    >>> target = source @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]  # kappa = 90 degrees
    >>> best_fit(target.T @ source)[0] @ [1.0, 0.0, 0.0]
    array([0., 1., 0.])
    """
    U, singular, Vt = np.linalg.svd(_square(product, "product"))
    sign = np.sign(np.linalg.det(U @ Vt))
    U[..., -1] *= sign[..., None]
    singular[..., -1] *= sign
    return U @ Vt, singular


def rotation(M: ArrayLike, tolerance: float, name: str = "M") -> np.ndarray:
    """M as a float array, if all its matrices are rotations."""
    M = _square(M, name)
    tolerance = _validate.not_negative(tolerance, "tolerance", "of elements of M")
    size = defect(M)
    if np.any(size > tolerance):
        raise ValueError(
            f"{which(size > tolerance, name)} is not a rotation: |{name} {name}' - I|"
            f" reaches {np.max(size):.2g}, more than {tolerance:g}. For a matrix copied"
            " from print, set the tolerance to a few units of its last digit, or use"
            " nearest(M)"
        )
    mirror = np.linalg.det(M) < 0
    if np.any(mirror):
        raise ValueError(
            f"{which(mirror, name)} is not a rotation but a reflection: its determinant"
            " is -1. Reverse the sign of one axis; y or z may point the other way"
        )
    return M


def which(bad: np.ndarray | bool, name: str = "M") -> str:
    """Name of the first bad matrix, and how many there are."""
    if np.ndim(bad) == 0:
        return name
    first = ", ".join(str(i) for i in np.argwhere(bad)[0])
    return f"{name}[{first}] (one of {np.sum(bad)})"


def ambiguous(where: np.ndarray, case: str, pair: str, choice: str) -> None:
    """Warn that two angles of some matrices are not told apart, and what is chosen."""
    if np.any(where):
        warnings.warn(
            f"{case}: {pair} of {which(where)} are not told apart; {choice}",
            RuntimeWarning,
            stacklevel=3,
        )


def _square(M: ArrayLike, name: str = "M") -> np.ndarray:
    M = _validate.finite(M, name)
    if M.shape[-2:] != (3, 3):
        raise ValueError(f"{name} must have shape (..., 3, 3); got shape {M.shape}")
    return M
