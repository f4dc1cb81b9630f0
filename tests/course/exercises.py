"""All exercises, with the book's solutions, as the notebooks define and check them."""

import ast
import contextlib
import functools
import gc
import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any
from unittest import mock

import matplotlib.pyplot as plt
import nbformat

from pgm_book.common import checks
from pgm_book.common.checks import CheckFailed
from pgm_book.course import grade, intake
from pgm_book.make import form
from pgm_book.make.notebooks import FOLDER

Property = tuple[str, bool | None]


@dataclass(frozen=True)
class Exercise:
    """An exercise: the check that its notebook calls, and the solution of the book."""

    lesson: str
    name: str
    module: ModuleType
    check: Callable[..., None]
    solution: Any
    others: tuple  # what the notebook passes to the check besides

    def properties(self, answer: Any) -> tuple[Property, ...]:
        """What the check says of an answer; a property for all of a right one."""
        told: list[tuple[Property, ...]] = []

        def report(name: str, properties: Any, right: str = "") -> None:
            properties = list(properties)
            told.append(tuple((text, holds) for text, holds, _ in properties))
            checks.report(name, properties)

        quiet = contextlib.redirect_stdout(io.StringIO())
        with quiet, mock.patch.object(self.module, "report", report):
            try:
                self.check(answer, *self.others)
            except CheckFailed as failed:
                return failed.properties
        return told[0]


def replaced(exercise: Exercise, answer: Any) -> Exercise:
    """Return an exercise of which all the parts of an answer are the same."""
    return replace(exercise, others=(answer,) * len(exercise.others))


def number(stem: str) -> str:
    """Return the number of a notebook in the rubric: 1, 2c, A1."""
    first, second, *_ = stem.split("_")
    return first.lstrip("0") + "c" * (second == "case")


def stems() -> list[str]:
    """Return the notebooks of lessons and cases."""
    return [stem for stem, kind in form.kinds().items() if kind in ("lesson", "case")]


@functools.cache
def of(stem: str) -> tuple[Exercise, ...]:
    """Return the exercises of a notebook in their order."""
    notebook = nbformat.read(FOLDER / f"{stem}.ipynb", as_version=4)
    asked = {one.check: one.call for one in grade.asked_in(notebook) if one.call}
    before: list[str] = []
    found: list[Exercise] = []
    quiet = contextlib.redirect_stdout(io.StringIO())
    with quiet, plt.rc_context(), mock.patch.object(checks, "keep"):
        for cell in notebook.cells:
            if cell.id in asked:
                names: dict = {"__name__": "__main__"}
                used = intake.names_of(asked[cell.id]).used
                for statement in intake.needed(tuple(before), used):
                    exec(compile(statement, stem, "exec"), names)
                (call,) = ast.parse(asked[cell.id]).body
                found.append(_exercise(number(stem), call.value, names))
                names.pop(
                    "mine", None
                )  # the solutions hold the names, and it its folder
            elif cell.cell_type == "code":
                before += intake.statements(cell.source)
        plt.close("all")
    gc.collect()
    return tuple(found)


def _exercise(lesson: str, call: ast.Call, names: dict) -> Exercise:
    """Return the exercise that a call checks, with what its arguments are by now."""
    first = call.args[0]
    module = names[call.func.value.id]
    answer, *others = (eval(ast.unparse(one), names) for one in call.args)
    check = getattr(module, call.func.attr)
    return Exercise(lesson, first.id, module, check, answer, tuple(others))
