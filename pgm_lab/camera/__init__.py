"""The camera: interior orientation, lens, and the way from object point to image."""

from pgm_lab.camera.model import (
    BLOCKS,
    LENSES,
    PARAMETERS,
    Camera,
    Collinearity,
    collinearity,
    ideal,
    measured,
    project,
)
from pgm_lab.camera.photo import Photo

__all__ = [
    "BLOCKS",
    "LENSES",
    "PARAMETERS",
    "Camera",
    "Collinearity",
    "Photo",
    "collinearity",
    "ideal",
    "measured",
    "project",
]
