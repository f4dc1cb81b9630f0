"""Figures and tables for the notebooks: one look, readable at the back of a hall.

What every chapter needs is here; the rest stands by its subject: `space` (cameras in
3-D), `village` (what they see), `matching`, `matches` (of two photos), `bundle`,
`network`, `matrices`, `registration`, `studies`, `fifty` (the case of chapter 7).
"""

from pgm_lab.plot import (
    bundle,
    fifty,
    matches,
    matching,
    matrices,
    network,
    registration,
    space,
    studies,
    village,
)
from pgm_lab.plot._pixel import pixel_on_ground
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    STYLE,
    YELLOW,
    error_ellipse,
    frame,
    show,
    table,
)

__all__ = [
    "BLACK",
    "BLUE",
    "GREEN",
    "GREY",
    "ORANGE",
    "PURPLE",
    "RED",
    "SKY",
    "STYLE",
    "YELLOW",
    "bundle",
    "error_ellipse",
    "fifty",
    "frame",
    "interact",
    "matches",
    "matching",
    "matrices",
    "network",
    "pixel_on_ground",
    "registration",
    "show",
    "space",
    "studies",
    "table",
    "village",
]
