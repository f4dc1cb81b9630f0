"""Least squares adjustment in the Gauss-Markov model: one core for the whole workbook.

`core` sets up and iterates, `normal` solves normal equations, `result` is what comes
out, `outliers` has the tests of its residuals.
"""

from pgm_lab.adjustment.core import adjust
from pgm_lab.adjustment.normal import RankDefect
from pgm_lab.adjustment.outliers import critical_tau, critical_w
from pgm_lab.adjustment.result import UNCONTROLLED, Adjustment, GlobalTest, History

__all__ = [
    "UNCONTROLLED",
    "Adjustment",
    "GlobalTest",
    "History",
    "RankDefect",
    "adjust",
    "critical_tau",
    "critical_w",
]
