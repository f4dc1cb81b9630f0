"""In the box nothing is checked; `own` gives the student's function, or the book's."""

from collections.abc import Callable

from nothing import __getattr__  # type: ignore[import-not-found]  # noqa: F401


class CheckFailed(AssertionError):
    """An answer is wrong or missing."""


def own(name: str, book: Callable) -> Callable:
    """Return the student's function of a name, else the book's own."""
    try:
        names: dict = {}
        with open("my_pgm.py", encoding="utf-8") as file:
            exec(compile(file.read(), "my_pgm.py", "exec"), names)
        return names[name]
    except Exception:  # whatever a student's file raises
        return book
