"""pgm_lab: the tested functions behind the photogrammetry workbook.

One module a topic; the notebooks in ``notebooks/`` show how to use them. Axes, units
and signs follow the conventions page of ``notebooks/00_start_here.ipynb``: pixel
coordinates are (column, row) with integers at pixel centres, photo coordinates are in
millimetres with x right and y up, angles are in radians.
"""

__version__ = "1.0.0"
