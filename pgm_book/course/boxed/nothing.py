"""What stands in the box for all that draws, shows and checks: it does nothing.

It stands alone, since the worker in the box uses it.
"""

import importlib.abc
import importlib.machinery
import types
from collections.abc import Sequence
from typing import Any

PACKAGES = (
    *("matplotlib", "IPython", "ipywidgets"),
    *(f"pgm_lab.{name}" for name in ("plot", "report", "stereo_map", "command")),
    *(f"pgm_book.common.{name}" for name in ("chapters", "ledger", "results")),
)


class BooksOwn(Exception):
    """An answer called the book's own function in place of doing the work."""


class Nothing:
    """It may be called, indexed, entered and derived from."""

    def __getattr__(self, name: str) -> "Nothing":
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *arguments: Any, **named: Any) -> "Nothing":
        """Do nothing."""
        return self

    def __getitem__(self, place: Any) -> "Nothing":
        return self

    def __iter__(self) -> Any:
        return iter(())

    def __enter__(self) -> "Nothing":
        return self

    def __exit__(self, *error: object) -> None:
        return None

    def __or__(self, other: Any) -> "Nothing":
        return self

    __ror__ = __or__

    def __mro_entries__(self, bases: tuple) -> tuple:
        return ()


def __getattr__(name: str) -> Nothing:  # of a module that takes this over
    if name.startswith("__"):
        raise AttributeError(name)
    return Nothing()


class Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Find nothing for every module of the packages that draw and show."""

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: Any = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return this loader for a module of these packages."""
        if any(name == one or name.startswith(f"{one}.") for one in PACKAGES):
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def exec_module(self, module: types.ModuleType) -> None:
        """Let a module have whatever is asked for; images can be read."""
        vars(module).update(__getattr__=__getattr__, imread=imread)


def imread(path: Any, *_: Any) -> Any:
    """Read an image as `matplotlib.pyplot` does: a PNG from 0 to 1."""
    import numpy as np
    from PIL import Image

    with Image.open(path) as image:
        values = np.asarray(image)
        return values / np.float32(255) if image.format == "PNG" else values
