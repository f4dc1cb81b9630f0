"""Orientation: resection, intersection, relative and absolute orientation."""

from pgm_lab.orientation import as_printed, textbook
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
    "as_printed",
    "intersect",
    "relative",
    "resect",
    "scale_factors",
    "textbook",
]
