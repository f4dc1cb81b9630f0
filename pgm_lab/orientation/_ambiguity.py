"""When another solution fits the observations as well as the best one."""

import scipy

# Probability with which errors of known size stay below the limit.
KNOWN = 0.999


def largest_objective(
    least: float, redundancy: int, sigma: float | None, level: float
) -> float:
    """Sum of squares vᵀv up to which a solution fits as well as the one with the least.

    Parameters
    ----------
    least : float
        vᵀv of the best solution.
    redundancy : int
        Redundancy of both, at least 1.
    sigma : float or None
        Standard deviation of an observation, if known beforehand.
    level : float
        Quantile of the ratio of two such sums, which counts if sigma is not known.

    Returns
    -------
    float
        In the squared unit of the observations.
    """
    if sigma is not None:
        return max(least, sigma**2 * scipy.stats.chi2.ppf(KNOWN, redundancy))
    return least * scipy.stats.f.ppf(level, redundancy, redundancy)
