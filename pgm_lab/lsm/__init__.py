"""Least squares matching: conjugate points to a hundredth of a pixel.

`match` measures many points, `adjust` does the same in textbook form.
"""

from pgm_lab.lsm.matching import Match, match
from pgm_lab.lsm.rigorous import adjust

__all__ = ["Match", "adjust", "match"]
