"""Two ortho images registered: how far apart they lie, and how sure that is.

`chips` finds small windows of the one image in the other, `accuracy` sums up the
shifts, `model` fits one transformation to them, `resampling` applies it. `points` says
where to look, `raster` reads and writes images with their place on the map, `grids`
says how far two maps' pixels lie apart. `textbook` is the method as the lesson writes
it, in loops.
"""

from pgm_lab.io.geotiff import Raster, read, write
from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import register
from pgm_lab.registration.grids import offset
from pgm_lab.registration.model import Model, fit
from pgm_lab.registration.points import grid, pick, read_points
from pgm_lab.registration.resampling import resample
from pgm_lab.registration.result import Registration
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
