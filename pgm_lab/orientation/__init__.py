"""Orientation of photos and models."""

from pgm_lab.orientation.absolute import Absolute, absolute

__all__ = ["Absolute", "absolute"]
