"""Normal equations: scaled, solved, and diagnosed when they are singular.

Everything here takes one problem or a stack of them over leading axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pgm_lab import _validate

# A parameter whose variance the others inflate more than this is not determined: normal
# equations in double precision hold about 16 digits, and these are 12 of them.
INFLATION_LIMIT = 1e12
# A parameter whose variance constraints deflate more than this is fixed by them: it is
# rounding, which grows with the square of what nearly dependent constraints magnify.
DEFLATION_LIMIT = 1e-14

# Columns of a design matrix whose cosine is nearer to 1 or -1 are called multiples.
PARALLEL = 1 - 1e-6

# Of every Gauss-Newton iteration: its smallest step, the share of the expected decrease
# that a step must bring, and the relative error that rounding leaves in v.
SMALLEST_STEP = 2.0**-20
SUFFICIENT_DECREASE = 1e-4
ROUNDING = 100 * np.finfo(float).eps


@dataclass(frozen=True)
class NullSpace:
    """Directions in which the parameters may move without a change of any residual.

    Attributes
    ----------
    vectors : ndarray (u, defect)
        One direction a column, of unit length after column scaling.
    names : tuple of str
        Parameters that take part in these directions.
    parallel : tuple of str
        Those of them whose columns are nearly multiples of one another's.
    """

    vectors: np.ndarray
    names: tuple[str, ...]
    parallel: tuple[str, ...] = ()

    @property
    def defect(self) -> int:
        """Number of missing constraints: unknowns minus rank."""
        return self.vectors.shape[1]


class RankDefect(ValueError):
    """The observations do not determine all parameters; `null_space` says which."""

    def __init__(self, null_space: NullSpace):
        self.null_space = null_space
        u = len(null_space.vectors)
        if null_space.defect:
            message = (
                f"the normal matrix has rank {u - null_space.defect} of {u}: the"
                f" observations do not determine {', '.join(null_space.names)}. Add"
                " observations or constraints, give these parameters weights, or leave"
                " them out"
            )
            if null_space.parallel:
                message += (
                    f". The columns of {', '.join(null_space.parallel)} are nearly"
                    " multiples of one another: if these are coordinates far from their"
                    " origin, such as UTM, subtract their mean (reduce to the centre)"
                )
        else:
            message = (
                "the constraints follow from one another or contradict each other:"
                " leave out the superfluous ones"
            )
        super().__init__(message)


def column_scale(normal: np.ndarray) -> np.ndarray:
    """Factors (..., u) that make the diagonal of a normal matrix (..., u, u) one.

    Parameters come in mm, radians and mm^-7: without scaling, their units decide which
    of them look undetermined.

    Examples
    --------
    >>> column_scale(np.diag([4.0, 1e-6, 0.0]))
    array([5.e-01, 1.e+03, 1.e+00])
    """
    diagonal = np.diagonal(normal, axis1=-2, axis2=-1)
    return 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))


def solve(
    normal: np.ndarray,
    right: np.ndarray,
    constraint: np.ndarray | None = None,
    misclosure: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Solve ``N dx + Cᵀk = n``, ``C dx = -c``, (M 2.76), by scaling and inversion.

    N (..., u, u), n (..., u), C (..., k, u), c (..., k). Returns the corrections dx,
    the cofactors Q (..., u, u), the multipliers k of the constraints, and where (...)
    the problem is singular, or constraints depend on each other: NaN there.

    Examples
    --------
    >>> solve(np.diag([4.0, 1.0]), np.array([8.0, 3.0]))[0]
    array([2., 3.])
    """
    u = normal.shape[-1]
    if constraint is None:
        constraint = normal[..., :0, :]
    if misclosure is None:
        misclosure = np.zeros(constraint.shape[:-1])

    # Scale to ones on the diagonal, border with the constraints, invert
    scale = column_scale(normal)
    system = normal * scale[..., :, None] * scale[..., None, :]
    system, rows = _bordered(system, constraint * scale[..., None, :])
    border = system[..., u:, :u]
    inverse = _inverse(system)
    cofactor = inverse[..., :u, :u]

    # What is determined, and what the constraints fix
    determined = _regular(cofactor)
    if border.shape[-2]:
        determined &= _regular(_inverse(border @ np.swapaxes(border, -1, -2)))
    magnified = np.sum(inverse[..., :u, u:] ** 2, axis=-1)
    rounding = DEFLATION_LIMIT * np.maximum(1, magnified)
    fixed = np.diagonal(cofactor, axis1=-2, axis2=-1) < rounding
    cofactor[fixed[..., :, None] | fixed[..., None, :]] = 0
    inverse[~determined] = np.nan

    # Solve, and undo the scaling
    right = np.concatenate([right * scale, -misclosure * rows], axis=-1)
    solution = np.einsum("...ij,...j->...i", inverse, right)
    dx, correlates = solution[..., :u] * scale, solution[..., u:] * rows
    with np.errstate(over="ignore"):  # of what is next to undetermined
        cofactor = cofactor * scale[..., :, None] * scale[..., None, :]
    return dx, cofactor, correlates, ~determined


def null_space(
    normal: np.ndarray,
    names: Sequence[str] | None = None,
    constraint: np.ndarray | None = None,
) -> NullSpace:
    """Find and name the parameters that a normal matrix (u, u) leaves undetermined.

    Constraints C (k, u) may go with it. The defect is 0 if everything is determined.

    Examples
    --------
    Height differences alone do not say how high the points lie:

    >>> design = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
    >>> found = null_space(design.T @ design, ["A", "B", "C"])
    >>> found.defect, found.names
    (1, ('A', 'B', 'C'))
    """
    u = len(normal)
    names = parameter_names(names, u)
    scale = column_scale(normal)
    scaled = normal * scale[:, None] * scale
    cosine = np.abs(scaled)
    np.fill_diagonal(cosine, 0)
    if constraint is not None:
        system, _ = _bordered(scaled, constraint * scale)
        rows = system[u:, :u]
        scaled = scaled + rows.T @ rows
    eigenvalues, eigenvectors = np.linalg.eigh(scaled)
    free = eigenvalues < u / INFLATION_LIMIT
    part = np.linalg.norm(eigenvectors[:, free], axis=1)
    involved = part > 0.1 * part.max(initial=0) if free.any() else np.zeros(u, bool)
    parallel = involved & (cosine[:, involved] > PARALLEL).any(axis=1)
    return NullSpace(
        vectors=scale[:, None] * eigenvectors[:, free],
        names=tuple(name for name, yes in zip(names, involved, strict=True) if yes),
        parallel=tuple(name for name, yes in zip(names, parallel, strict=True) if yes),
    )


def parameter_names(names: Sequence[str] | None, u: int) -> Sequence[str]:
    """Return the names of u parameters, or make some up."""
    if names is None:
        return [f"x{i + 1}" for i in range(u)]
    names = _validate.texts(names, "names")
    if len(names) != u:
        raise ValueError(f"names has {len(names)} entries for {u} parameters")
    return names


def _bordered(
    normal: np.ndarray, constraint: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Border a normal matrix with constraints, each row scaled to unit length."""
    length = np.linalg.norm(constraint, axis=-1)
    rows = 1 / np.where(length > 0, length, 1.0)
    constraint = constraint * rows[..., None]
    *lead, k, u = np.broadcast_shapes(normal.shape[:-2] + (1, 1), constraint.shape)
    system = np.zeros((*lead, u + k, u + k))
    system[..., :u, :u] = normal
    system[..., u:, :u] = constraint
    system[..., :u, u:] = np.swapaxes(constraint, -1, -2)
    return system, rows


def _regular(inverse: np.ndarray) -> np.ndarray:
    """Whether the inverse of a matrix with diagonal one is to be trusted."""
    diagonal = np.diagonal(inverse, axis1=-2, axis2=-1)
    with np.errstate(invalid="ignore"):
        return np.all(np.abs(diagonal) < INFLATION_LIMIT, axis=-1)


def _inverse(matrices: np.ndarray) -> np.ndarray:
    """Inverse of each matrix; NaN where it is exactly singular."""
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        with np.errstate(invalid="ignore"):
            regular = np.linalg.slogdet(matrices).sign != 0
        inverse = np.full_like(matrices, np.nan)
        inverse[regular] = np.linalg.inv(matrices[regular])
        return inverse
