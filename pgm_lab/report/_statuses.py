"""What became of points, and where they lie: the same for photos and for images."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from pgm_lab._statuses import STATUSES
from pgm_lab.report._layout import Finding, Table, count

MOST = 200  # rows of points
HALF = 0.5  # of the points
SMALL = 0.2  # of the left photo
PLACES = np.array(
    [
        ["at the upper left", "at the top", "at the upper right"],
        ["at the left", "in the middle", "at the right"],
        ["at the lower left", "at the bottom", "at the lower right"],
    ]
)


class Found(Protocol):
    """What has a status for each point."""

    @property
    def status(self) -> np.ndarray:
        """The words of `matching.STATUSES` (n,)."""

    @property
    def accepted(self) -> np.ndarray:
        """Whether the status is "accepted" (n,)."""


def lost(found: Found) -> list[tuple[str, int]]:
    """Reasons for which points were not accepted, the most frequent first."""
    words, numbers = np.unique(found.status[~found.accepted], return_counts=True)
    order = np.argsort(-numbers, kind="stable")
    return [(str(words[i]), int(numbers[i])) for i in order]


def reasons(found: Found, say: Callable[[str], str] = str) -> list[Finding]:
    """List what became of the points, in words; `say` puts a sentence into others."""
    said = [Finding("accepted", f"{np.sum(found.accepted)} points")]
    for status, number in lost(found):
        words = f"{count(number, 'point')}: {advice(status, say)}"
        said.append(Finding(say(status), words))
    return said


def advice(status: str, say: Callable[[str], str] = str) -> str:
    """Say what a status means, and what helps."""
    meaning, help = map(say, STATUSES[status])
    return f"{meaning}. {help[:1].upper()}{help[1:]}."


def few(found: Found, least: int, say: Callable[[str], str] = str) -> str:
    """Say how few points were accepted, and why; nothing if there are enough."""
    n, m = len(found.status), int(np.sum(found.accepted))
    if m >= least and m >= HALF * n:
        return ""
    words = f"{count(m, 'point').capitalize()} of {n} found."
    if reasons := lost(found):
        status, number = reasons[0]
        words += f' Most often the reason is "{say(status)}" ({number}):'
        words += f" {advice(status, say)}"
    return words


def crowded(at: np.ndarray, size: tuple[int, int]) -> tuple[float, str] | None:
    """Which share of an image (columns, rows) the points span, and where, if small."""
    if len(at) < 2:
        return None
    # the middle nine tenths of columns and of rows: single ones do not count
    low, high = np.quantile(at, [0.05, 0.95], axis=0)
    share = float(np.prod((high - low) / (0.9 * np.array(size))))
    if share >= SMALL:
        return None
    third = np.clip((3 * np.median(at, axis=0) / size).astype(int), 0, 2)
    return share, str(PLACES[third[1], third[0]])


def statuses(found: Found, say: Callable[[str], str] = str) -> Table:
    """Return how many points have which status, what it means and what helps."""
    words, numbers = np.unique(found.status, return_counts=True)
    of_status = dict(zip(words.tolist(), numbers.tolist()))
    rows = [
        (say(status), str(of_status[status]), say(meaning), say(help) or "-")
        for status, (meaning, help) in STATUSES.items()
        if status in of_status
    ]
    header = ("status", "points", "what it means", "what helps")
    return Table("What became of the points", header, rows)


def first_rows(caption: str, n: int) -> str:
    """Say in the caption of a table of points that it shows the first ones only."""
    return caption if n <= MOST else f"{caption}: the first {MOST} of {n}"
