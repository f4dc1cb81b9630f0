"""The reader's program as the book solves it, in the order of the lessons.

`adjustment` (A1), `lsm` (3), `camera` and `orientation` (5), `bundle` (6),
`registration` (7), `stereo` (8), `surface` (9): loops and formulas in the order of the
text, each module loaded when it is first used. The library beside it does the same for
many points.
"""

import importlib
from types import ModuleType

__all__ = [
    "adjustment",
    "bundle",
    "camera",
    "lsm",
    "orientation",
    "registration",
    "stereo",
    "surface",
]


def __getattr__(name: str) -> ModuleType:
    """Load a module when it is first used."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(f"{__name__}.{name}")
