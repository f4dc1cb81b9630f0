"""Figures and tables for the notebooks: one look, readable at the back of a hall.

What every chapter needs is here; the rest stands in modules by its subject, each of
which is loaded when it is first used.
"""

import importlib
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pgm_lab.plot import (
        bundle,
        calibrate,
        cameras,
        chips,
        estimates,
        fifty,
        forty,
        fringe,
        heights,
        levelling,
        locations,
        lsm,
        mark,
        matches,
        matching,
        matrices,
        network,
        parallax,
        precision,
        printed,
        program,
        rays,
        registration,
        search,
        sensor,
        shifts,
        space,
        start,
        stereo,
        studies,
        subpixel,
        target,
        trials,
        troubles,
        turns,
        twentyfive,
        validation,
        village,
        windows,
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
    "calibrate",
    "cameras",
    "chips",
    "error_ellipse",
    "estimates",
    "fifty",
    "forty",
    "frame",
    "fringe",
    "heights",
    "interact",
    "levelling",
    "locations",
    "lsm",
    "mark",
    "matches",
    "matching",
    "matrices",
    "network",
    "overlay",
    "parallax",
    "pixel_on_ground",
    "program",
    "printed",
    "precision",
    "rays",
    "registration",
    "search",
    "sensor",
    "shifts",
    "show",
    "space",
    "start",
    "stereo",
    "studies",
    "subpixel",
    "table",
    "target",
    "trials",
    "turns",
    "validation",
    "troubles",
    "twentyfive",
    "village",
    "windows",
]


def __getattr__(name: str) -> ModuleType:
    """Load a module of figures when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    """Name also what is not loaded yet."""
    return __all__
