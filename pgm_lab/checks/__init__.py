"""Feedback on exercises: which property of the reader's function fails, in plain words.

A check calls the reader's function on several inputs, tests one property after the
other and names those that fail. It never shows the answer. The checks of a chapter
stand in the module of its number, ``pgm_lab.checks.chapter1`` and so on.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import datasets


class CheckFailed(AssertionError):
    """An answer is wrong or missing; notebooks show the message without a traceback."""

    def _render_traceback_(self) -> list[str]:
        return [f"✗ {self}"]


def answer_of(function: Callable, *arguments: Any) -> Any:
    """Call the reader's function on copies of its arguments; return what it answers.

    Raises
    ------
    CheckFailed
        If the function stops, returns nothing, or changes its input.
    """
    name = getattr(function, "__name__", "your function")
    if not callable(function):
        raise CheckFailed(f"{name} is not a function yet. Your turn!")
    copies = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
    try:
        answer = function(*copies)
    except Exception as error:
        raise CheckFailed(
            f"{name} stopped with {type(error).__name__}: {error}"
        ) from error
    if answer is None or answer is ...:
        raise CheckFailed(f"{name} returns nothing yet. Your turn!")
    if isinstance(answer, tuple | list) and any(part is ... for part in answer):
        raise CheckFailed(f"{name}: a part of the answer is still `...`. Your turn!")
    for before, after in zip(arguments, copies, strict=True):
        if isinstance(before, np.ndarray) and not np.array_equal(before, after):
            raise CheckFailed(f"{name} changes its input; work on a copy")
    return answer


def call(function: Callable, *arguments: Any, shape: tuple[int, ...]) -> np.ndarray:
    """Call the reader's function and return its answer as an array of that shape.

    Raises
    ------
    CheckFailed
        If the function stops, returns nothing, changes its input, or returns something
        of another shape.

    Examples
    --------
    >>> call(lambda x: 2 * x, 1.5, shape=())
    array(3.)
    """
    answer = answer_of(function, *arguments)
    must = f"{getattr(function, '__name__', 'your function')} must return"
    try:
        array = np.asarray(answer, dtype=float)
    except (TypeError, ValueError):
        if isinstance(answer, tuple | list) and any(map(np.ndim, answer)):
            shapes = ", ".join(str(np.shape(part)) for part in answer)
            raise CheckFailed(
                f"{must} shape {shape} here; got parts of shapes {shapes}"
            ) from None
        raise CheckFailed(f"{must} numbers, not {type(answer).__name__}") from None
    if array.shape != shape:
        tip = _turned(shape) if array.shape == shape[::-1] else ""
        raise CheckFailed(f"{must} shape {shape} here; got {array.shape}{tip}")
    return array


def _turned(shape: tuple[int, ...]) -> str:
    """What to do about an array of the shape turned round."""
    if len(shape) == 2 and min(shape) > 3:
        return ": rows and columns are exchanged"
    wide = len(shape) == 2 and 1 < shape[0] < shape[1]
    return f"; use np.{'array' if wide else 'column_stack'}([...])"


def numbers(
    name: str, answer: object, shape: tuple[int, ...] = (), wanted: str = "one number"
) -> np.ndarray:
    """Return an answer that is no function as an array of that shape.

    Parameters
    ----------
    name : str
        The name that the reader gives a value.
    answer : object
        The value.
    shape : tuple of int
        Shape of a right answer.
    wanted : str
        The same in words.

    Raises
    ------
    CheckFailed
        If the answer is missing, or is not such numbers.

    Examples
    --------
    >>> numbers("my_sum", 3)
    array(3.)
    """
    if answer is ... or answer is None:
        raise CheckFailed(f"{name} is still empty. Your turn!")
    try:
        array = np.asarray(answer, dtype=float)
    except (TypeError, ValueError):
        raise CheckFailed(f"{name} must be {wanted}") from None
    if array.shape != shape:
        got = f"; got {array.shape}" if array.shape else ""
        raise CheckFailed(f"{name} must be {wanted}{got}")
    return array


def report(name: str, properties: Iterable[tuple[str, bool, str]]) -> None:
    """Print the properties that hold, or raise with the ones that fail.

    Parameters
    ----------
    name : str
        What is checked.
    properties : iterable of (property, holds, hint)
        Each in plain words; the hint is shown when the property fails.

    Raises
    ------
    CheckFailed
        If a property fails.

    Examples
    --------
    >>> report("my_sum", [("adds", True, "it does not add")])
    ✓ my_sum: adds.
    """
    properties = list(properties)
    hints = [hint for _, holds, hint in properties if not holds]
    if hints:
        whole = f"{name}: " + "; ".join(hints).replace("?; ", "? ")
        raise CheckFailed(whole if whole.endswith(("?", "!")) else whole + ".")
    print(f"✓ {name}: " + "; ".join(text for text, _, _ in properties) + ".")


def near(answer: ArrayLike, expected: ArrayLike, tolerance: float = 1e-9) -> bool:
    """True if all numbers agree to a tolerance relative to the largest of them."""
    scale = max(1.0, float(np.max(np.abs(expected))))
    return bool(np.all(np.abs(np.subtract(answer, expected)) <= tolerance * scale))


def first_slip(
    answer: ArrayLike,
    slips: Iterable[tuple[ArrayLike, str]],
    otherwise: str,
    tolerance: float = 1e-6,
) -> str:
    """Hint to the first slip that explains the whole answer.

    Parameters
    ----------
    answer : array_like
        What the reader found.
    slips : iterable of (wrong answer, hint)
        What comes of slips that are often made, in the shape of the answer.
    otherwise : str
        The hint when no slip explains the answer.
    tolerance : float
        As for `near`.

    Examples
    --------
    >>> first_slip(2.0, [(-4.0, "the sign"), (2.0, "a factor of two")], "no idea")
    'a factor of two'
    """
    for wrong, hint in slips:
        if near(answer, wrong, tolerance):
            return hint
    return otherwise


def compare(
    function: Callable,
    cases: Iterable[tuple],
    right: Callable,
    slips: Mapping[str, Callable],
    otherwise: str,
) -> tuple[bool, str]:
    """Compare the reader's function with the right one, and with wrong ones.

    Parameters
    ----------
    function : callable
        The reader's.
    cases : iterable of tuples
        The arguments on which all functions are called.
    right : callable
        The right function.
    slips : mapping of str to callable
        Functions with one slip each, by the hint to it.
    otherwise : str
        The hint when no slip explains all answers.

    Returns
    -------
    bool, str
        Whether the function is right, and the hint if it is not.

    Examples
    --------
    >>> slips = {"the sign is reversed": lambda x: -2 * x}
    >>> compare(lambda x: -2 * x, [(1,), (3,)], lambda x: 2 * x, slips, "no idea")
    (False, 'the sign is reversed')
    """
    cases = list(cases)
    answers = [call(function, *c, shape=np.shape(right(*c))) for c in cases]

    def explains(other: Callable) -> bool:
        return all(near(a, other(*c), 1e-8) for a, c in zip(answers, cases))

    if explains(right):
        return True, ""
    return False, next((h for h, wrong in slips.items() if explains(wrong)), otherwise)


def question(number: str, choice: str) -> None:
    """Answer a quick question; the feedback says why a choice is right or wrong.

    Parameters
    ----------
    number : str
        Number of the question, for example "1.2".
    choice : str
        Letter of the choice.

    Raises
    ------
    CheckFailed
        If the choice is wrong or missing.
    ValueError
        If there is no such question.
    """
    rows = datasets.rows("questions")
    choices = {row["choice"]: row for row in rows if row["question"] == number}
    if not choices:
        raise ValueError(f"there is no question {number} in data/questions")
    letter = choice.strip().lower() if isinstance(choice, str) else ""
    if letter not in choices:
        raise CheckFailed(f"question {number}: choose one of {', '.join(choices)}.")
    row = choices[letter]
    if row["right"] != "yes":
        raise CheckFailed(f"question {number}: {row['feedback']}")
    print(f"✓ question {number}: {row['feedback']}")


def questions(chapter: str, choices: Iterable[str]) -> None:
    """Answer the quick questions of a chapter; each choice gets its feedback.

    Parameters
    ----------
    chapter : str
        Number of the chapter, for example "1".
    choices : iterable of str
        A letter for each question, in their order.

    Raises
    ------
    CheckFailed
        If a choice is wrong or missing, after all questions were looked at.
    """
    known = {row["question"] for row in datasets.rows("questions")}
    wanted = sum(number.startswith(f"{chapter}.") for number in known)
    choices = list(choices)
    if len(choices) != wanted:
        raise CheckFailed(f"give {wanted} letters, one for each question.")
    failed = []
    for number, choice in enumerate(choices, start=1):
        try:
            question(f"{chapter}.{number}", choice)
        except CheckFailed as wrong:
            failed.append(str(wrong))
    if failed:
        raise CheckFailed("\n✗ ".join(failed))
