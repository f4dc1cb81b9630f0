"""Reports: words, tables and figures of a bundle, a matching, a registration.

The command `pgm_lab` makes one of a bundle from four text files (`adjust`), of a
matching from two photos (`match`), of a registration from two images (`register`), of a
camera from photos of a board (`calibrate`).
"""

from pgm_lab.report import calibration, matching, registration
from pgm_lab.report.network import html, text

__all__ = ["calibration", "html", "matching", "registration", "text"]
