"""Your task: new data, one question, an empty cell, at the end of every lesson.

The data are made from a name, so that everybody has their own, and the same again on
every machine. What a lesson asks stands in its ``task.py``, with six functions:

``make(chance)``
    The files, and the truth that belongs to them. A file is text, or grey values
    (uint8), which are written as PNG. `chance` is a frozen stream; numbers are rounded,
    so that the last digit of a library changes nothing.
``read(result)``
    The values of an answer, most often by name; a CheckFailed where it is none to the
    question.
``judge(truth, found)``
    The parts of an answer, each with how far it is off.
``slips(truth)``
    By the hint that helps, what the likeliest wrong programs give with these data.
    Where the truth has the right values by name, in ``answer``, only those that the
    program spoils.
``hint(truth, found, wrong)``
    What helps where these parts are wrong: the hint of a slip, or another sentence.
``picture(truth, found)``
    The values beside the truth: a figure and what it shows.

`grey` and `table` make what a file holds, `named` reads an answer of several parts,
`likeliest` finds the slip that explains a wrong one.
"""

import copy
import hashlib
import importlib
import json
import shutil
import sys
import tempfile
import weakref
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import numpy as np

from pgm_book.common.checks import CheckFailed, numbers
from pgm_book.common.own_program import FILE
from pgm_lab import plot
from pgm_lab.io import files

RESULTS = "my_results.json"
Answer = dict[str, Any]  # the values of an answer by name


@dataclass(frozen=True)
class Part:
    """One part of an answer: how far it is off, and how far it may be."""

    name: str
    off: float  # NaN counts as wrong
    allowed: float = 3.0
    unit: str = "standard deviations"

    @property
    def holds(self) -> bool:
        """Whether it is near enough."""
        return self.off <= self.allowed

    def __str__(self) -> str:
        """How far it is off, in words; where nothing is allowed, right or not."""
        if self.allowed == 0:
            return f"{self.name}: {'correct' if self.holds else 'not correct'}"
        size = 0 if abs(self.off) < 5e-4 else self.off
        off = f"{size:.3g} {self.unit}".rstrip()
        return f"{self.name}: {off} ({self.allowed:g} allowed)"


@dataclass(frozen=True)
class Task:
    """A reader's task: the files in its folder, and where the result is handed in."""

    number: str
    name: str
    folder: Path
    files: tuple[str, ...]
    digest: str  # of all values, so that two machines can compare
    _lesson: ModuleType
    _truth: Any
    _tries: list = field(default_factory=list)  # results of this session
    _last: list = field(default_factory=list)  # what was handed in, of whatever form

    def __repr__(self) -> str:
        """What is given, and nothing of the answer."""
        return f"Task {self.number} for {self.name}: {', '.join(self.files)}"

    def judged(self, result: Any) -> list[Part]:
        """Return how far the parts of a result are off; nothing is kept."""
        return self._lesson.judge(self._truth, self._lesson.read(result))

    def hand_in(self, result: Any) -> None:
        """Say whether a result is right, within what the noise of the data allows.

        Each try is counted, and kept in ``my_results.json`` beside ``my_pgm.py``.

        Raises
        ------
        CheckFailed
            If the result is wrong, or is no answer to the question.
        """
        self._last[:] = [result]
        parts = self.judged(result)
        passed = all(part.holds for part in parts)
        self._tries.append(result)
        number = self._kept(parts, passed)
        told = parts if passed else [part for part in parts if not part.holds]
        said = "; ".join(map(str, told))
        if not passed:
            raise CheckFailed(f"try {number}: {said}. mine.hint() names a likely slip.")
        print(f"✓ Task {self.number}, try {number}. {said}.")
        figure, alt = self._lesson.picture(self._truth, self._lesson.read(result))
        plot.show(figure, alt)

    def hint(self) -> None:
        """Name the slip that the last result looks like, or what its form must be."""
        if not self._last:
            raise CheckFailed("hand a result in first: mine.hand_in(result)")
        found = self._lesson.read(*self._last)
        print(self.explained(found) or "Your last result is right.")

    def explained(self, found: Any) -> str:
        """Return the hint to values of which some are wrong, "" where all are right."""
        parts = self._lesson.judge(self._truth, found)
        wrong = [part.name for part in parts if not part.holds]
        return self._lesson.hint(self._truth, found, wrong) if wrong else ""

    def _kept(self, parts: list[Part], passed: bool) -> int:
        """Keep a try beside the reader's program; return its number."""
        if not Path(FILE).is_file():
            return len(self._tries)
        before = _results()
        same = [
            one
            for one in before
            if (one["task"], one["values"]) == (self.number, self.digest[:16])
        ]
        one = {
            "task": self.number,
            "name": self.name,
            "values": self.digest[:16],
            "try": len(same) + 1,
            "passed": passed,
            "parts": {part.name: _rounded(part.off) for part in parts},
            "time": datetime.now(UTC).isoformat(timespec="seconds"),
            "source": _typed(),
        }
        text = json.dumps([*before, one], indent=1, ensure_ascii=False) + "\n"
        files.save({Path(RESULTS): text}, overwrite=True)  # atomic
        return len(same) + 1


def start(number: int | str, name: str, secret: str = "") -> Task:
    """Make the data of a lesson's task from a name, and write them where they belong.

    They go into a folder such as ``task_06`` beside ``my_pgm.py``, or where there is no
    program into a temporary one. Files that stand there already stay as they are: where
    they differ, the data go into ``task_06-2`` and so on.

    Parameters
    ----------
    number : int or str
        Of the lesson, 1 to 9, or "A1".
    name : str
        Whose task; capitals and blanks do not count.
    secret : str
        A lecturer's word, so that nobody makes the data of the others beforehand.

    Raises
    ------
    ValueError
        If the lesson has no task, or the name is empty.
    """
    number = str(number).upper()
    chance, lesson = _chance(number, name, secret), _lesson(number)
    made, truth = lesson.make(chance)
    contents = {one: _content(value) for one, value in made.items()}
    keeps = Path(FILE).is_file()
    folder = _place(number, contents) if keeps else Path(tempfile.mkdtemp("_task"))
    files.save({p: c for p, c in _under(folder, contents) if not p.exists()})
    mine = Task(number, name, folder, tuple(made), _digest(made), lesson, truth)
    if not keeps:  # the folder goes when the task goes, or Python
        weakref.finalize(mine, shutil.rmtree, folder, ignore_errors=True)
    where = f"{folder}/" if keeps else "a temporary folder"
    print(f"Your data are in {where}: {', '.join(made)}.")
    return mine


# --- What the tasks of several lessons use ---


def grey(values: np.ndarray) -> np.ndarray:
    """Return grey values as a camera stores them: whole ones from 0 to 255."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def table(head: str, row: str, rows: Iterable[Iterable]) -> str:
    """Write a table: its head, and each row in a format such as "{},{:.2f}"."""
    return "\n".join([head, *(row.format(*one) for one in rows)]) + "\n"


def named(result: Any, wanted: dict[str, tuple[str, Any]]) -> Answer:
    """Return the parts of an answer by their names, or say what is wanted.

    `wanted` has for each name what it must be, in words, and the shape of its numbers;
    what has no numbers, and None for a shape, is returned as it is. An answer is a
    dict, or has all parts in this order.

    Examples
    --------
    >>> named(("CD", 7), {"line": ("two letters", None), "size": ("one number", ())})
    {'line': 'CD', 'size': np.float64(7.0)}
    """
    if isinstance(result, tuple | list) and len(result) == len(wanted):
        result = dict(zip(wanted, result))
    if not isinstance(result, Mapping) or not wanted.keys() <= set(result):
        each = "; ".join(f'"{name}", {words}' for name, (words, _) in wanted.items())
        raise CheckFailed(f"the result must be a dict, or all in this order: {each}")
    found = {name: result[name] for name in wanted}
    for name, (words, shape) in wanted.items():
        if shape is not None:
            found[name] = numbers(name, result[name], shape, words)[()]
    return found


def likeliest(
    judge: Callable[[Any, Answer], list[Part]],
    truth: Any,
    found: Answer,
    wrong: Iterable[str],
    slips: Mapping[str, Answer],
) -> str:
    """Return the hint of the slip that explains most of an answer.

    A slip explains what would hold if what the slip gives were the right answer: at
    least one of the wrong parts, and most of all. Of several, that of the first wrong
    part is taken, and the nearest; where none explains anything, "" is returned. So
    `judge` compares with ``truth.answer``, a field or a cached property, on which what
    is allowed must not depend.
    """
    order, ranked = list(wrong), {}
    for words, change in slips.items():
        as_if = copy.copy(truth)  # with all that is cached
        vars(as_if)["answer"] = truth.answer | change
        held = {part.name: part.off for part in judge(as_if, found) if part.holds}
        if cured := [(order.index(name), held[name]) for name in order if name in held]:
            ranked[words] = (-len(held), *cured[0])
    return min(ranked, key=ranked.__getitem__, default="")


# --- From a name to the values ---


def _chance(number: str, name: str, secret: str) -> np.random.RandomState:
    """Return the stream of a name."""
    if not isinstance(name, str) or not name.strip():
        raise ValueError("name must be a text, such as 'Ada Lovelace'")
    return stream(number, " ".join(name.casefold().split()), secret)


def stream(*words: object) -> np.random.RandomState:
    """Return the stream of words; unlike `default_rng`, it never changes (NEP 19)."""
    seed = hashlib.sha256("\n".join(map(str, words)).encode()).digest()
    return np.random.RandomState(np.frombuffer(seed, dtype="<u4"))


def _lesson(number: str) -> ModuleType:
    """Return the module of a lesson's task."""
    module = f"pgm_book.ch{number.zfill(2)}.task"
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name not in (module, module.rpartition(".")[0]):
            raise
        raise ValueError(
            f"number: lesson {number} has no task; give 1 to 9, or 'A1'"
        ) from None


def _content(value: str | np.ndarray) -> bytes:
    """Return what is written: text, or grey values as PNG."""
    if isinstance(value, str):
        return value.encode()
    return cv2.imencode(".png", value)[1].tobytes()


def _digest(made: dict[str, str | np.ndarray]) -> str:
    """Return a hash of all values, whatever version wrote the PNG."""
    whole = hashlib.sha256()
    for name, value in made.items():
        shape = () if isinstance(value, str) else value.shape
        whole.update(f"{name} {shape}\n".encode())
        whole.update(value.encode() if isinstance(value, str) else value.tobytes())
    return whole.hexdigest()


def _place(number: str, contents: dict[str, bytes]) -> Path:
    """Return the first folder, task_06, task_06-2, ..., where nothing else stands."""
    first = folder = Path(f"task_{number.zfill(2)}")
    k = 1
    while any(_differs(path, content) for path, content in _under(folder, contents)):
        k += 1
        folder = Path(f"{first}-{k}")
    folder.mkdir(exist_ok=True)
    return folder


def _under(folder: Path, contents: dict[str, bytes]) -> list[tuple[Path, bytes]]:
    return [(folder / name, content) for name, content in contents.items()]


def _differs(path: Path, content: bytes) -> bool:
    """Whether something else stands at a path."""
    return path.exists() and (not path.is_file() or path.read_bytes() != content)


# --- From a result to the portfolio ---


def _results() -> list[dict]:
    """Return the tries so far; a file that cannot be read is never written over."""
    path = Path(RESULTS)
    if not path.exists():
        return []
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        [(one["task"], one["values"]) for one in found]
    except (ValueError, KeyError, TypeError):
        raise CheckFailed(
            f"{RESULTS} cannot be read. Nothing was written into it. Give it another"
            " name, and hand in again."
        ) from None
    return found


def _rounded(off: float) -> float | None:
    """Return a number that JSON can hold: four digits, None for what is not finite."""
    return float(f"{off:.4g}") if np.isfinite(off) else None


def _typed() -> str:
    """Return the cell that hands in, as it was typed; nothing outside a notebook."""
    ipython = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return ipython.user_ns.get("In", [""])[-1] if ipython else ""
