"""In the box the files of a task are there already, and its result is not judged."""

from pathlib import Path
from typing import Any

HANDED: list = []


class Task:
    """What a notebook calls ``mine``."""

    def __init__(self, number: int | str, name: str) -> None:
        self.number, self.name = str(number).upper(), name
        self.folder = Path(f"task_{self.number.zfill(2)}")
        self.files = tuple(sorted(path.name for path in self.folder.iterdir()))

    def hand_in(self, result: Any) -> None:
        """Keep a result for the judge."""
        HANDED.append(result)

    def hint(self) -> None:
        """Say nothing."""


def start(number: int | str, name: str = "", secret: str = "") -> Task:
    """Return the task, whoever asks."""
    return Task(number, name)
