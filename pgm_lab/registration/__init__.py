"""Two ortho images registered: their shift, and how certain it is.

`chips` finds small windows of one image in the other, `accuracy` summarizes the shifts,
`model` fits one transformation to them and applies it. `points` selects the points.
"""

from pgm_lab.io.geotiff import Raster, read, write
from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import Registration, register
from pgm_lab.registration.model import Model, fit, resample
from pgm_lab.registration.points import grid, offset, pick, read_points

__all__ = [
    "Accuracy",
    "Model",
    "Raster",
    "Registration",
    "accuracy",
    "fit",
    "grid",
    "offset",
    "pick",
    "read",
    "read_points",
    "register",
    "resample",
    "write",
]
