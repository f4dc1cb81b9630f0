"""Orientation: resection, intersection, relative and absolute orientation."""

from pgm_lab.orientation.absolute import Absolute, absolute
from pgm_lab.orientation.intersection import Intersection, intersect
from pgm_lab.orientation.rays import scale_factors
from pgm_lab.orientation.relative import Relative, relative
from pgm_lab.orientation.resection import Resection, resect

__all__ = [
    "Absolute",
    "Intersection",
    "Relative",
    "Resection",
    "absolute",
    "intersect",
    "relative",
    "resect",
    "scale_factors",
]
