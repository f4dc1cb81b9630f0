"""A lesson's own cells, run without what they show: the program that its task uses."""

import contextlib
import io
from collections.abc import Callable, Iterator
from unittest import mock

import matplotlib.pyplot as plt
import nbformat

from pgm_book import task as book
from pgm_book.common import checks
from pgm_book.make import form
from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import tags
from pgm_book.task import Task

LEFT_OUT = {"draw", "check", "claims"}


def lessons() -> dict[str, str]:
    """Return the notebooks of the lessons by their numbers, 1 to 9 and A1."""
    stems = [stem for stem, kind in form.kinds().items() if kind == "lesson"]
    return {stem.partition("_")[0].lstrip("0"): stem for stem in stems}


@contextlib.contextmanager
def of(number: str) -> Iterator[Callable[[Task], None]]:
    """Give a function that runs the solution of a lesson's task, and what it reads."""
    path = FOLDER / f"{lessons()[number]}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    cells = [cell for cell in cells if not LEFT_OUT & set(tags(cell))]
    (start,) = [k for k, cell in enumerate(cells) if "task.start(" in cell.source]
    (end,) = [k for k, cell in enumerate(cells) if "task" in tags(cell)]
    names: dict = {"__name__": "__main__"}
    quiet = contextlib.redirect_stdout(io.StringIO())
    kept = mock.patch.object(checks, "keep")  # it reads a notebook's own text
    with quiet, plt.rc_context(), kept:
        for cell in cells[:start]:
            exec(compile(cell.source, path.name, "exec"), names)
            plt.close("all")

        def solve(mine: Task) -> None:
            space = names.copy()
            with mock.patch.object(book, "start", lambda *_: mine):
                for cell in cells[start : end + 1]:
                    exec(compile(cell.source, path.name, "exec"), space)
            space.clear()  # its functions would keep it, and the task's folder

        yield solve
