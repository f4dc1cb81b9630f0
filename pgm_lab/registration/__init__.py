"""Two ortho images registered: their shift, and how certain it is.

`points` selects the points, `start` finds out roughly how the images are shifted,
`chips` finds small windows of one in the other, `accuracy` summarizes their shifts, and
`model` fits one transformation or a smooth `field` to them and applies it.
"""

from pgm_lab.io.geotiff import Raster, read, write
from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import Registration, register
from pgm_lab.registration.model import Model, fit, resample
from pgm_lab.registration.points import common_grid, grid, offset, pick, read_points
from pgm_lab.registration.start import approximate

__all__ = [
    "Accuracy",
    "Model",
    "Raster",
    "Registration",
    "accuracy",
    "approximate",
    "common_grid",
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
