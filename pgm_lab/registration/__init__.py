"""Two ortho images registered: how far apart they lie, and how sure that is.

`chips` finds small windows of the one image in the other, `accuracy` sums up the shifts.
"""

from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import Registration, register

__all__ = ["Accuracy", "Registration", "accuracy", "register"]
