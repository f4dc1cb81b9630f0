"""The calibration of a camera by photos of a board.

`board` says what was printed, `detect` finds it in a photo, `corners` measures its
corners, `measure` does both for a file, `solve` adjusts the network of all photos, and
`quality` tells what it is worth and what to photograph next.
"""

from pgm_lab.calibration.board import Board
from pgm_lab.calibration.corners import Corners, refine
from pgm_lab.calibration.measure import ENDINGS, Measured, measure, pixel_size
from pgm_lab.calibration.solve import SQUARE, Calibration, calibrate, start_c

__all__ = [
    "ENDINGS",
    "SQUARE",
    "Board",
    "Calibration",
    "Corners",
    "Measured",
    "calibrate",
    "measure",
    "pixel_size",
    "refine",
    "start_c",
]
