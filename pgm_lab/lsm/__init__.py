"""Least squares matching: conjugate points to a hundredth of a pixel.

`match` measures many points, `adjust` does the same in textbook form, and `cramer_rao`
returns the best precision that is possible at all.
"""

from pgm_lab.lsm.matching import Match, match
from pgm_lab.lsm.precision import cramer_rao
from pgm_lab.lsm.rigorous import adjust

__all__ = ["Match", "adjust", "cramer_rao", "match"]
