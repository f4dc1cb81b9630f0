"""The camera: interior orientation, lens, and the projection of object points."""

from pgm_lab.camera import files
from pgm_lab.camera._document import UNITS
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
    "UNITS",
    "Camera",
    "Collinearity",
    "Photo",
    "collinearity",
    "files",
    "ideal",
    "measured",
    "project",
]
