"""Figures and tables for the notebooks: one look, readable at the back of a hall.

What every chapter needs is here; the rest stands in modules by its subject, each of
which is loaded when it is first used.
"""

import importlib
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pgm_lab.plot import bundle, matches, registration, space
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
    "error_ellipse",
    "frame",
    "interact",
    "matches",
    "overlay",
    "pixel_on_ground",
    "registration",
    "show",
    "space",
    "table",
]


def __getattr__(name: str) -> ModuleType:
    """Load a module of figures when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    """Name also what is not loaded yet."""
    return __all__
