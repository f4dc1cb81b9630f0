"""Reports: words, tables and figures of a bundle adjustment, and of a matching.

`python -m pgm_lab.report` makes one of a bundle from four text files, and `python -m
pgm_lab.matching` one of a matching from two photos.
"""

from pgm_lab.report import matching
from pgm_lab.report._page import html
from pgm_lab.report._text import text

__all__ = ["html", "matching", "text"]
