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

__all__ = [
    "BLOCKS",
    "LENSES",
    "PARAMETERS",
    "Camera",
    "Collinearity",
    "collinearity",
    "ideal",
    "measured",
    "project",
]
