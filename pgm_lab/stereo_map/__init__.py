"""StereoMap: measure points in two photos by clicking, as the program of 2010 did.

`session` has the logic: open, measure, keep, undo, orient. `saving` writes what the
bundle reads.
"""

from pgm_lab.stereo_map._measurement import Measurement
from pgm_lab.stereo_map.drawing import draw, show
from pgm_lab.stereo_map.photos import exif_camera, read_photo
from pgm_lab.stereo_map.saving import network, observations, save, save_network
from pgm_lab.stereo_map.session import (
    Session,
    add,
    measure,
    open_pair,
    orient,
    undo,
)

__all__ = [
    "Measurement",
    "Session",
    "add",
    "draw",
    "exif_camera",
    "measure",
    "network",
    "observations",
    "open_pair",
    "orient",
    "read_photo",
    "save",
    "save_network",
    "show",
    "undo",
]
