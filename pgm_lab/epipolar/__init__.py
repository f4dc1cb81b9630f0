"""Epipolar geometry: plane, line, epipole of two oriented photos."""

from pgm_lab.epipolar.geometry import curve, fundamental, line

__all__ = ["curve", "fundamental", "line"]
