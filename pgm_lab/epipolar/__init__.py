"""Epipolar geometry: plane, line, epipole of two oriented photos."""

from pgm_lab.epipolar.epipoles import Epipole, epipole
from pgm_lab.epipolar.geometry import curve, distance, line, plane
from pgm_lab.epipolar.matrices import essential, fundamental

__all__ = [
    "Epipole",
    "curve",
    "distance",
    "epipole",
    "essential",
    "fundamental",
    "line",
    "plane",
]
