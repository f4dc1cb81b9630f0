"""Least squares matching: conjugate points to a hundredth of a pixel.

`match` measures many points, `adjust` is the same as the textbook writes it, and
`cramer_rao` says how precisely it can be done at all.
"""

from pgm_lab.lsm.matching import Match, match
from pgm_lab.lsm.precision import cramer_rao
from pgm_lab.lsm.rigorous import adjust

__all__ = ["Match", "adjust", "cramer_rao", "match"]
