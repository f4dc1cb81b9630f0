"""Two ortho images registered: how far apart they lie, and how sure that is.

`chips` finds small windows of one image in the other, `accuracy` sums up the shifts.
"""

from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import register
from pgm_lab.registration.result import Registration

__all__ = ["Accuracy", "Registration", "accuracy", "register"]
