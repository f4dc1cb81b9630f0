"""The report of a bundle adjustment: words, tables, figures, and a command line.

`python -m pgm_lab.report` makes a report from four text files.
"""

from pgm_lab.report._page import html
from pgm_lab.report._text import text

__all__ = ["html", "text"]
