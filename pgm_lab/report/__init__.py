"""Reports: words, tables and figures of a bundle, a matching, a registration.

`python -m pgm_lab.report` makes one of a bundle from four text files, `python -m
pgm_lab.matching` one of a matching from two photos, and `python -m
pgm_lab.registration` one of a registration from two images.
"""

from pgm_lab.report import matching, registration
from pgm_lab.report._page import html
from pgm_lab.report._text import text

__all__ = ["html", "matching", "registration", "text"]
