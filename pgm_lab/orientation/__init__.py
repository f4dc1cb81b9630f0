"""Orientation: resection, intersection, relative and absolute orientation."""

from pgm_lab.orientation.intersection import Intersection, intersect
from pgm_lab.orientation.resection import Resection, resect

__all__ = ["Intersection", "Resection", "intersect", "resect"]
