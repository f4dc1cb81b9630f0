"""The reader's own program: what passed its check is kept in ``my_pgm.py``.

The file stands beside the reader's copies of the notebooks. Where it is missing, as
beside the notebooks of the project, it is neither read nor made.
"""

import functools
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from pgm_lab import _validate
from pgm_lab.checks import _program
from pgm_lab.io import files

FILE = _program.FILE  # in the folder of the notebook


def keep(function: Callable) -> None:
    """Keep a function that passed its check in the reader's program, ``my_pgm.py``.

    The source is kept as it was typed, with the imports and the functions of the
    notebook that it uses. An older one of the same name is replaced; all else in the
    file stays. Where there is no ``my_pgm.py`` beside the notebook, nothing is written.

    Parameters
    ----------
    function : callable
        A function that the notebook defines, right after its check.

    Raises
    ------
    CheckFailed
        If the function cannot be taken out of the notebook, or the file cannot be
        read; nothing is written then.
    """
    imports, sources = _program.parts(function)
    if not Path(FILE).is_file():
        print(
            f"({function.__name__} goes into your program, {FILE}, where there is one"
            " beside the notebook, as in work/. An empty file begins it.)"
        )
        return
    before = Path(FILE).read_text(encoding="utf-8")
    after = _program.joined(before, imports, sources)
    if after != before:
        files.save({FILE: after}, overwrite=True)  # in one step: no half a program
    print(f"✓ {function.__name__} is a part of your program now, {FILE}.")


def own(name: str, book: Callable) -> Callable:
    """Return the reader's function of this name, or the book's own, and say which.

    Parameters
    ----------
    name : str
        The name under which an exercise kept it.
    book : callable
        What to use until then.

    Returns
    -------
    callable
        The function from ``my_pgm.py`` beside the notebook, else `book`. Where the
        reader's answers with a list, or with numbers in a tuple, it is an array here.

    Examples
    --------
    >>> largest = own("largest", max)
    largest: the book's own. Yours takes its place once its check has passed.
    >>> largest([1, 3, 2])
    3
    """
    _validate.text(name, "name")
    _validate.function(book, "book")
    why = "Yours takes its place once its check has passed."
    if Path(FILE).is_file():
        try:
            found = getattr(loaded(), name, None)
        except Exception as error:  # whatever a reader's file raises
            found, why = None, f"{FILE} does not run: {type(error).__name__}, {error}."
        if callable(found):
            print(f"{name}: yours, from {FILE}.")
            return with_arrays(found)
    print(f"{name}: the book's own. {why}")
    return book


def with_arrays(function: Callable) -> Callable:
    """Return the function, but with arrays for lists, and for tuples of numbers.

    A check takes either for an answer, and the rest of a notebook computes with it.
    """

    @functools.wraps(function)
    def answer(*arguments: Any, **named: Any) -> Any:
        found = function(*arguments, **named)
        try:
            array = np.array(found) if isinstance(found, list | tuple) else None
        except ValueError:  # parts of several shapes
            return found
        several = array is None or (isinstance(found, tuple) and array.ndim > 1)
        return found if several else array

    return answer


def loaded() -> ModuleType:
    """Run the reader's file anew, as a module that nobody else sees."""
    module = ModuleType(_program.MODULE)
    text = Path(FILE).read_text(encoding="utf-8")
    exec(compile(text, FILE, "exec"), vars(module))
    return module
