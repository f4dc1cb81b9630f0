"""Stereo plotting: from two oriented photos to points, a surface and a terrain.

In the order of the work: `normal` makes the epipolar (normalised) pair, `parallax`
checks it, `dense` matches it, `heights` intersects and compares with truth, `grid`
makes the DSM, `terrain` the DTM, `save` writes files; `photo_file` and `block` do it
for many photos.
"""

from pgm_lab.orientation import scale_factors
from pgm_lab.stereo.block import Block, PlottedPair, plot_block
from pgm_lab.stereo.dense import STATUSES, DenseMatch, match_dense, match_rows
from pgm_lab.stereo.grid import Surface, surface
from pgm_lab.stereo.heights import Points, Quality, intersect, quality
from pgm_lab.stereo.normal import NormalPair, epipolar_pair
from pgm_lab.stereo.parallax import YParallax, y_parallax
from pgm_lab.stereo.photo_file import PhotoFile, neighbours
from pgm_lab.stereo.save import save_points, save_surface
from pgm_lab.stereo.terrain import Terrain, filter_terrain

__all__ = [
    "STATUSES",
    "Block",
    "DenseMatch",
    "NormalPair",
    "PhotoFile",
    "PlottedPair",
    "Points",
    "Quality",
    "Surface",
    "Terrain",
    "YParallax",
    "epipolar_pair",
    "filter_terrain",
    "intersect",
    "match_dense",
    "match_rows",
    "neighbours",
    "plot_block",
    "quality",
    "save_points",
    "save_surface",
    "scale_factors",
    "surface",
    "y_parallax",
]
