"""Questions with a number for an answer, in as many variants as a class needs.

A question is a function that draws numbers, and words in `numbers.toml`. All numbers
are shown as they are used, so that the answer follows from the paper alone. A variant
in which a usual slip comes too near to the answer is drawn again.
"""

import re
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from pgm_book.task import stream

VARIANTS = 50
MODULES = ("numbers_images", "numbers_rays")  # where the questions draw
WORDS = Path(__file__).with_name("numbers.toml")
APART = 2.0  # tolerances, from the answer to a slip

# What a question draws: its numbers by name, the answer, what the usual slips lead to.
Numbers = tuple[dict[str, Any], Any, list[Any]]


class Chance:
    """Numbers from a frozen stream, the same on every machine (NEP 19)."""

    def __init__(self, *seed: object) -> None:
        self._stream = stream(*seed)

    def below(self, n: int) -> int:
        """Return a whole number from 0 to n - 1."""
        return int(self._stream.randint(n, dtype=np.int64))

    def __call__(self, low: float, high: float, step: float = 1) -> Any:
        """Return one of low, low + step, ..., high, with no more digits than these."""
        value = low + step * self.below(round((high - low) / step) + 1)
        return value if isinstance(value, int) else round(value, 8) + 0.0  # no -0

    def of(self, values: Sequence) -> Any:
        """Return one of some values."""
        return values[self.below(len(values))]

    def several(self, n: int, low: float, high: float, step: float = 1) -> np.ndarray:
        """Return n numbers as `__call__` does."""
        return np.array([self(low, high, step) for _ in range(n)])

    def order(self, values: Sequence) -> list:
        """Return the values in another order."""
        left = list(values)
        return [left.pop(self.below(len(left))) for _ in values]


@dataclass(frozen=True)
class NumberQuestion:
    """A question of which only the numbers are missing; no digits: a whole number."""

    name: str  # that of its function
    lesson: str
    title: str
    unit: str
    digits: int
    text: str  # Markdown, with %(name)s for what is drawn
    solution: str
    slips: list[str]
    draw: Callable[[Chance], Numbers]


@dataclass(frozen=True)
class Variant:
    """A question with its numbers, its answer rounded to the digits asked for."""

    number: str  # "1.gsd.07": stable
    title: str
    text: str
    answer: float
    tolerance: float
    unit: str
    digits: int
    solution: str
    slips: dict[str, float]
    given: dict[str, Any]

    @property
    def shown(self) -> str:
        """The answer with its digits and its unit, in print."""
        shown = f"{self.answer:.{self.digits}f} {self.unit}".rstrip()
        return shown.replace("-", "−").replace(" °", "°")


@cache
def number_questions() -> tuple[NumberQuestion, ...]:
    """Return all questions, those of a lesson in the order in which they stand."""
    words = tomllib.loads(WORDS.read_text(encoding="utf-8"))
    modules = [import_module(f"pgm_book.course.{name}") for name in MODULES]
    found = []
    for name, said in words.items():
        (draw,) = (vars(one)[name] for one in modules if name in vars(one))
        title = draw.__doc__.rstrip(".")
        found.append(NumberQuestion(name=name, title=title, draw=draw, **said))
    return tuple(found)


def variants(asked: NumberQuestion, count: int = VARIANTS) -> list[Variant]:
    """Make the first variants of a question, no two alike."""
    found: dict[str, Variant] = {}
    attempt = 0
    while len(found) < count:
        drawn = asked.draw(Chance(asked.lesson, asked.name, attempt))
        variant = _variant(asked, drawn, len(found) + 1)
        attempt += 1
        if _fair(variant):
            found.setdefault(variant.text, variant)
        if attempt > 40 * count:
            raise ValueError(f"{asked.name}: too few of its variants are fair")
    return list(found.values())


def _variant(of: NumberQuestion, drawn: Numbers, k: int) -> Variant:
    """Put the numbers into the words; the tolerance is a unit of the last digit."""
    given, exact, slips = drawn
    answer = round(float(exact), of.digits) + 0.0  # no -0
    values = {**given, "answer": f"{answer:.{of.digits}f}"}
    unit = f" in **{of.unit}**," if of.unit else ""
    wanted = f"to {of.digits} decimal{'s' * (of.digits > 1)}"
    if not of.digits:
        wanted = "with a whole number"
    return Variant(
        number=f"{of.lesson}.{of.name}.{k:02d}",
        title=of.title,
        text=f"{of.text % values} Answer{unit} {wanted}.",
        answer=answer,
        tolerance=10.0**-of.digits if of.digits else 0.0,
        unit=of.unit,
        digits=of.digits,
        solution=of.solution % values,
        slips={words: float(one) for words, one in zip(of.slips, slips, strict=True)},
        given=given,
    )


def _fair(variant: Variant) -> bool:
    """Whether every slip leads to a number that is clearly wrong."""
    least = APART * variant.tolerance or 0.5
    return all(abs(slip - variant.answer) > least for slip in variant.slips.values())


# --- What several questions show ---


def matrix(values: Iterable, form: str = "%g") -> str:
    r"""Write rows of numbers as a matrix in TeX.

    Examples
    --------
    >>> matrix([[1, 0.5], [-2, 3]])
    '\\begin{pmatrix} 1 & 0.5 \\\\ -2 & 3 \\end{pmatrix}'
    """
    rows = r" \\ ".join(" & ".join(form % (one + 0.0) for one in row) for row in values)
    return rf"\begin{{pmatrix}} {rows} \end{{pmatrix}}"


def listed(values: Iterable, form: str = "%g") -> str:
    r"""Write numbers with commas between them, in TeX.

    Examples
    --------
    >>> listed([1, -0.5])
    '1,\\ -0.5'
    """
    return r",\ ".join(form % (one + 0.0) for one in values)  # no -0


def total(terms: Iterable[float], form: str = "%g") -> str:
    """Write a sum, without a plus before a minus.

    Examples
    --------
    >>> total([1, -2, 3])
    '1 - 2 + 3'
    """
    return re.sub(r"\+ -", "- ", " + ".join(form % one for one in terms))
