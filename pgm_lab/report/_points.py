"""What the reports of a matching and of a registration share: statuses, settings."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from pgm_lab import _validate
from pgm_lab.matching import Match
from pgm_lab.registration import Registration
from pgm_lab.report import _page
from pgm_lab.report._page import Table

MAX_ROWS = 200  # of a table of points
HALF = 0.5  # of the points
SMALL = 0.2  # of the left photo, or of the reference image
PLACES = np.array(
    [
        ["at the upper left", "at the top", "at the upper right"],
        ["at the left", "in the middle", "at the right"],
        ["at the lower left", "at the bottom", "at the lower right"],
    ]
)


Words = Mapping[str, tuple[str, str, str]]  # of each status: name, meaning, what helps
Found = Match | Registration


class Points(_page.Case):
    """What the sentences of both reports need to know; a subclass adds its own.

    `FEW` is the number of points below which they are few; `WORDS` and `SETTINGS`
    explain the statuses and what was asked.
    """

    FEW: int
    WORDS: Words
    SETTINGS: Mapping[str, str]

    def __init__(self, found: Found, asked: dict[str, Any]) -> None:
        self.found, self.asked = found, asked

    @property
    def values(self) -> dict[str, Any]:
        """What both templates are given."""
        good = self.found.accepted
        return super().values | {
            "found": self.found,
            "n": len(good),
            "accepted": int(np.sum(good)),
            "lost": lost(self.found, self.WORDS),
            "few": np.sum(good) < max(self.FEW, HALF * len(good)),
            "SMALL": SMALL,
            "status_table": status_table(self.found, self.WORDS),
            "settings_table": settings_table(self.asked, self.SETTINGS),
        }


# --- What became of the points ---


class Status(NamedTuple):
    """A status in words, and how many points have it."""

    name: str
    meaning: str
    help: str
    number: int

    @property
    def advice(self) -> str:
        """What the status means, and what helps."""
        return f"{self.meaning}. {self.help[:1].upper()}{self.help[1:]}."


def lost(found: Found, known: Words) -> list[Status]:
    """Return why points were not accepted, the most frequent reason first."""
    words, numbers = np.unique(found.status[~found.accepted], return_counts=True)
    order = np.argsort(-numbers, kind="stable")
    return [Status(*known[str(words[i])], int(numbers[i])) for i in order]


def crowded(at: np.ndarray, size: tuple[int, int]) -> tuple[float, str] | None:
    """Which share of an image (columns, rows) the points span, and where, if small."""
    if len(at) < 2:
        return None
    # The middle nine tenths of columns and of rows: single ones do not count
    low, high = np.quantile(at, [0.05, 0.95], axis=0)
    share = float(np.prod((high - low) / (0.9 * np.array(size))))
    if share >= SMALL:
        return None
    third = np.clip((3 * np.median(at, axis=0) / size).astype(int), 0, 2)
    return share, str(PLACES[third[1], third[0]])


def status_table(found: Found, known: Words) -> Table:
    """Return how many points have which status, what it means and what helps."""
    words, numbers = np.unique(found.status, return_counts=True)
    of_status = dict(zip(words.tolist(), numbers.tolist()))
    rows = [
        (name, str(of_status[status]), meaning, help or "-")
        for status, (name, meaning, help) in known.items()
        if status in of_status
    ]
    header = ("status", "points", "what it means", "what helps")
    return Table("What became of the points", header, rows)


def first_rows(caption: str, n: int) -> str:
    """Say in the caption of a table of points that it shows the first ones only."""
    return caption if n <= MAX_ROWS else f"{caption}: the first {MAX_ROWS} of {n}"


# --- What a function was asked for ---


def asked(
    function: Callable, settings: Mapping[str, object] | None, known: Mapping[str, str]
) -> dict[str, Any]:
    """Return settings of a function in the order of `known`, its defaults among them.

    Raises
    ------
    ValueError
        If a setting is not known.
    """
    given = {} if settings is None else _validate.mapping(settings, "settings")
    for name in given:
        _validate.choice(name, "settings: a name", tuple(known))
    of_function = inspect.signature(function).parameters
    defaults = {n: of_function[n].default for n in known if n in of_function}
    found = defaults | dict(given)
    return {name: found[name] for name in known if name in found}


def settings_table(settings: Mapping[str, object], known: Mapping[str, str]) -> Table:
    """Return settings, and what they mean."""
    rows = [(name, _shown(value), known[name]) for name, value in settings.items()]
    return Table("Settings", ("setting", "value", "what it is"), rows)


def _shown(value: object) -> str:
    if value is None:
        return "-"
    return str(value) if isinstance(value, str | float | int) else "given"
