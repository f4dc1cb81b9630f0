"""Grey values of an image: statistics, gradients, resampling, centre of a target.

Images are arrays indexed [row, column], 8 or 16 bit or float; everything is computed
in float64. Points are (column, row) in pixels, integers at pixel centres.
"""

from pgm_lab.image.centroid import Centroid, centroid
from pgm_lab.image.grey import (
    Statistics,
    equalize,
    gradient,
    histogram,
    pyramid,
    statistics,
)
from pgm_lab.image.resampling import cut, resample

__all__ = [
    "Centroid",
    "Statistics",
    "centroid",
    "cut",
    "equalize",
    "gradient",
    "histogram",
    "pyramid",
    "resample",
    "statistics",
]
