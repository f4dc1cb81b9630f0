"""Orientation: resection, intersection, relative and absolute orientation."""

from pgm_lab.orientation.intersection import Intersection, intersect

__all__ = ["Intersection", "intersect"]
