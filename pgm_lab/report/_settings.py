"""What a function was asked for: checked, and shown with its meaning."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from pgm_lab import _validate
from pgm_lab.report._layout import Table


def given(
    settings: Mapping[str, object] | None, about: str, known: Mapping[str, str]
) -> Mapping[str, object]:
    """Refuse settings whose names are not known, and what is no text."""
    if not isinstance(about, str):
        raise ValueError(f"about must be a text; got {_validate.shown(about)}")
    asked = {} if settings is None else _validate.mapping(settings, "settings")
    for name in asked:
        _validate.choice(name, "settings: a name", tuple(known))
    return asked


def values(
    function: Callable, asked: Mapping[str, object], known: Mapping[str, str]
) -> dict[str, Any]:
    """Return what was asked of a function in the order of `known`, its defaults too."""
    of_function = inspect.signature(function).parameters
    defaults = {
        name: of_function[name].default for name in known if name in of_function
    }
    found = defaults | dict(asked)
    return {name: found[name] for name in known if name in found}


def table(of: Mapping[str, object], known: Mapping[str, str]) -> Table:
    """Return settings, and what they mean."""
    rows = [(name, _shown(value), known[name]) for name, value in of.items()]
    return Table("Settings", ("setting", "value", "what it is"), rows)


def _shown(value: object) -> str:
    if value is None:
        return "-"
    return str(value) if isinstance(value, str | float | int) else "given"
