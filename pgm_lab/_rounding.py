"""Numbers as a reader wants them: round ones, and no digit that says nothing."""

import numpy as np


def round_number(value: float) -> float:
    """Largest of 1, 2 and 5 times a power of ten that is not above the value.

    >>> round_number(0.034)
    0.02
    """
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= value))


def plain(value: float, digits: int = 2) -> str:
    """Write a number with so many digits, and never with an exponent."""
    return np.format_float_positional(
        value, digits, unique=False, fractional=False, trim="-"
    )


def fixed(values: np.ndarray, decimals: float) -> list[str]:
    """Write a column with the same number of decimals; "-" for what is not known."""
    decimals = int(np.clip(decimals, 0, 15))
    values = np.round(values, decimals) + 0.0  # and no "-0.00"
    return [f"{v:.{decimals}f}" if np.isfinite(v) else "-" for v in values]


def rounded(values: np.ndarray, sd: np.ndarray) -> list[str]:
    """Write a column with as many decimals as give a usual sd two digits."""
    known = sd[np.isfinite(sd) & (sd > 0)]
    return fixed(values, 1 - np.floor(np.log10(np.median(known))) if len(known) else 6)


def two_digits(value: float) -> str:
    """Write a positive number with two digits, and never with an exponent."""
    return fixed(np.array([value]), 1 - np.floor(np.log10(value or 1.0)))[0]


def scientific(value: float, sd: float) -> tuple[str, str]:
    """Write a value and its sd with two digits of the sd, however small they are.

    >>> scientific(1.234567e-5, 3.2e-8)
    ('1.2346e-05', '3.2e-08')
    """
    if not (np.isfinite(sd) and sd > 0):
        return f"{value:.6g}", "-"
    if 1e-3 < sd < 1e3:
        column = np.array([sd])
        return rounded(np.array([value]), column)[0], rounded(column, column)[0]
    digits = np.floor(np.log10(max(abs(value), sd))) - np.floor(np.log10(sd)) + 1
    return f"{value:.{int(min(digits, 15))}e}", f"{sd:.1e}"
