"""Figures and tables for the notebooks: one look, readable at the back of a hall.

What every chapter needs is here; the rest stands by its subject: `space` (cameras in
3-D), `village` (what they see), `matching`, `matches` (of two photos), `fringe`,
`chips`, `shifts`, `fifty`, `registration` (of two ortho images), `parallax`, `mark`,
`stereo` (of a stereo pair), `locations`, `bundle`, `network`, `matrices`, `studies`.
"""

from pgm_lab.plot import (
    bundle,
    chips,
    fifty,
    fringe,
    locations,
    mark,
    matches,
    matching,
    matrices,
    network,
    parallax,
    registration,
    shifts,
    space,
    stereo,
    studies,
    village,
)
from pgm_lab.plot._overlay import overlay
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
    "chips",
    "error_ellipse",
    "fifty",
    "frame",
    "fringe",
    "interact",
    "locations",
    "mark",
    "matches",
    "matching",
    "matrices",
    "network",
    "overlay",
    "parallax",
    "pixel_on_ground",
    "registration",
    "shifts",
    "show",
    "space",
    "stereo",
    "studies",
    "table",
    "village",
]
