"""Orientation of photos and models."""

from pgm_lab.orientation.absolute import Absolute, absolute
from pgm_lab.orientation.relative import Relative, relative
from pgm_lab.orientation.scale_factors import scale_factors

__all__ = ["Absolute", "Relative", "absolute", "relative", "scale_factors"]
