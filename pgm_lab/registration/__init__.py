"""Two ortho images registered: their shift, and how certain it is.

`chips` finds small windows of one image in the other, `accuracy` summarizes the shifts,
`model` fits one transformation to them and applies it. `points` says where to look.
`textbook` is the method as the lesson writes it, in loops.
"""

from pgm_lab.io.geotiff import Raster, read, write
from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import Registration, register
from pgm_lab.registration.model import Model, fit, resample
from pgm_lab.registration.points import grid, offset, pick, read_points
from pgm_lab.registration.textbook import (
    best_shift,
    chip_shifts,
    peak_of_parabola,
    rmse,
)

__all__ = [
    "Accuracy",
    "Model",
    "Raster",
    "Registration",
    "accuracy",
    "best_shift",
    "chip_shifts",
    "fit",
    "grid",
    "offset",
    "peak_of_parabola",
    "pick",
    "read",
    "read_points",
    "register",
    "resample",
    "rmse",
    "write",
]
