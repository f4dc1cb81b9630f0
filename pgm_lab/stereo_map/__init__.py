"""StereoMap: measure points in two photos by clicking, as the program of 2010 did.

`session` opens two photos and keeps points, `measuring` measures and orients, `saving`
writes what the bundle reads; `drawing` shows a point, `program` is all of it in a
notebook.
"""

from pgm_lab.stereo_map.drawing import draw, show
from pgm_lab.stereo_map.measuring import measure, orient
from pgm_lab.stereo_map.photos import exif_camera, read_photo
from pgm_lab.stereo_map.saving import network, observations, save, save_network
from pgm_lab.stereo_map.session import Measurement, Session, add, open_pair, undo

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
