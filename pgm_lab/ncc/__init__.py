"""Normalized cross correlation: how similar two windows are, and where they fit best.

`correlation` and `regression` compare two windows, `correlation_map` slides a template
over a search window, `match` finds many points of the left image in the right one.
Coordinates are (column, row) in pixels, integers at pixel centres.
"""

from pgm_lab.ncc._map import correlation_map
from pgm_lab.ncc._match import Match, match
from pgm_lab.ncc._windows import Regression, correlation, regression

__all__ = [
    "Match",
    "Regression",
    "correlation",
    "correlation_map",
    "match",
    "regression",
]
