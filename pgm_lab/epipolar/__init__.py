"""Epipolar geometry: plane, line, epipole of two oriented photos."""

from pgm_lab.epipolar.geometry import (
    Epipole,
    curve,
    distance,
    epipole,
    essential,
    fundamental,
    line,
    plane,
)

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
