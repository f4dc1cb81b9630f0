"""Figures and tables for the notebooks: one look, readable at the back of a hall.

The parts that every lesson needs are here. `bundle`, `matches` and `registration` draw
results of the library, and are loaded when they are first used.
"""

import importlib
from types import ModuleType
from typing import TYPE_CHECKING

from pgm_lab.plot import space
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
    interact,
    overlay,
    show,
    table,
)
from pgm_lab.plot.space import pixel_on_ground

if TYPE_CHECKING:
    from pgm_lab.plot import bundle, matches, registration

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
