"""Two ortho images registered: how far apart they lie, and how sure that is.

`chips` finds small windows of the one image in the other, `accuracy` sums up the
shifts, `model` fits one transformation to them, `resampling` applies it. `points` says
where to look, `raster` reads and writes images with their place on the map, `grids`
says how far two maps' pixels lie apart.
"""

from pgm_lab.registration.accuracy import Accuracy, accuracy
from pgm_lab.registration.chips import register
from pgm_lab.registration.grids import offset
from pgm_lab.registration.model import Model, fit
from pgm_lab.registration.points import grid, pick, read_points
from pgm_lab.registration.raster import Raster, read, write
from pgm_lab.registration.resampling import resample
from pgm_lab.registration.result import Registration

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
