"""Questions with a number for an answer, in as many variants as a class needs.

A question is a function that draws numbers and returns what is asked. All numbers are
shown as they are used, so that the answer follows from the paper alone. A variant whose
usual slips come too near to the answer is drawn again.
"""

import hashlib
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

VARIANTS = 50
MODULES = ("numbers_images", "numbers_rays")  # where the questions stand
APART = 2.0  # tolerances, from the answer to a slip


class Chance:
    """Numbers from a frozen stream, the same on every machine (NEP 19)."""

    def __init__(self, *seed: object) -> None:
        digest = hashlib.sha256("\n".join(map(str, seed)).encode()).digest()
        self._stream = np.random.RandomState(np.frombuffer(digest, dtype="<u4"))

    def below(self, n: int) -> int:
        """Return a whole number from 0 to n - 1."""
        return int(self._stream.randint(n, dtype=np.int64))

    def __call__(self, low: float, high: float, step: float = 1) -> Any:
        """Return one of low, low + step, ..., high, with no more digits than these."""
        value = low + step * self.below(round((high - low) / step) + 1)
        return value if isinstance(value, int) else round(value, 8)

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
class Asked:
    """What a question asks with one set of numbers; texts in Markdown, with %(name)s.

    `slips` has for a usual slip, in words, what it leads to.
    """

    given: dict[str, Any]
    text: str
    answer: float
    solution: str
    slips: dict[str, float]


@dataclass(frozen=True)
class NumberQuestion:
    """A question of which only the numbers are missing; no digits: a whole number."""

    lesson: str
    title: str
    unit: str
    digits: int
    ask: Callable[[Chance], Asked]

    @property
    def name(self) -> str:
        """Its name, stable as long as the function keeps its own."""
        return f"{self.lesson}.{self.ask.__name__}"


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
        """The answer with its digits and its unit."""
        return f"{self.answer:.{self.digits}f} {self.unit}".rstrip()


QUESTIONS: dict[str, NumberQuestion] = {}


def question(lesson: str, title: str, unit: str, digits: int) -> Callable:
    """Register a function as a question of a lesson, answered in this unit."""

    def register(ask: Callable[[Chance], Asked]) -> Callable[[Chance], Asked]:
        made = NumberQuestion(lesson, title, unit, digits, ask)
        QUESTIONS[made.name] = made
        return ask

    return register


@cache
def number_questions() -> tuple[NumberQuestion, ...]:
    """Return all questions, those of a lesson in the order in which they stand."""
    for name in MODULES:
        import_module(f"pgm_book.course.{name}")
    return tuple(QUESTIONS.values())


def variants(asked: NumberQuestion, count: int = VARIANTS) -> list[Variant]:
    """Make the first variants of a question, no two alike."""
    found: dict[str, Variant] = {}
    attempt = 0
    while len(found) < count:
        variant = _variant(asked, asked.ask(Chance(asked.name, attempt)), len(found))
        attempt += 1
        if _fair(variant):
            found.setdefault(variant.text, variant)
        if attempt > 40 * count:
            raise ValueError(f"{asked.name}: too few of its variants are fair")
    return list(found.values())


def _variant(of: NumberQuestion, made: Asked, k: int) -> Variant:
    """Put the numbers into the texts; the tolerance is a unit of the last digit."""
    answer = round(float(made.answer), of.digits) + 0.0  # no -0
    values = {**made.given, "answer": f"{answer:.{of.digits}f}"}
    unit = f" in **{of.unit}**," if of.unit else ""
    wanted = f"to {of.digits} decimal{'s' * (of.digits > 1)}"
    wanted = f"Answer{unit} {wanted}." if of.digits else "Answer with a whole number."
    return Variant(
        number=f"{of.name}.{k + 1:02d}",
        title=of.title,
        text=f"{made.text % values} {wanted}",
        answer=answer,
        tolerance=10.0**-of.digits if of.digits else 0.0,
        unit=of.unit,
        digits=of.digits,
        solution=made.solution % values,
        slips={words: float(value) for words, value in made.slips.items()},
        given=made.given,
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
    rows = r" \\ ".join(" & ".join(form % one for one in row) for row in values)
    return rf"\begin{{pmatrix}} {rows} \end{{pmatrix}}"


def listed(values: Iterable, form: str = "%g") -> str:
    """Write numbers with commas between them, in TeX.

    Examples
    --------
    >>> listed([1, -0.5])
    '1,\\\\ -0.5'
    """
    return r",\ ".join(form % one for one in values)


def total(terms: Iterable[float], form: str = "%g") -> str:
    """Write a sum, without a plus before a minus.

    Examples
    --------
    >>> total([1, -2, 3])
    '1 - 2 + 3'
    """
    return re.sub(r"\+ -", "- ", " + ".join(form % one for one in terms))
