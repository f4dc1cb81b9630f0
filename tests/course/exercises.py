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
from pgm_book.make import form
from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import tags

LEFT_OUT = {"claims"}

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

        def report(name: str, properties: Any) -> None:
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
    found: list[Exercise] = []
    names: dict = {"__name__": "__main__"}
    quiet = contextlib.redirect_stdout(io.StringIO())
    with quiet, plt.rc_context(), mock.patch.object(checks, "keep"):
        for statement in _needed(notebook):
            if _is_check(statement):
                found.append(_exercise(number(stem), statement.value, names))
            else:
                exec(compile(ast.Module([statement], []), stem, "exec"), names)
        plt.close("all")
    names.pop("mine", None)  # the solutions hold the names, and it its folder
    gc.collect()
    return tuple(found)


def _needed(notebook: nbformat.NotebookNode) -> list[ast.stmt]:
    """Return the checks of a notebook, and the statements that they depend on."""
    statements = [
        statement
        for cell in notebook.cells
        if cell.cell_type == "code" and not LEFT_OUT & set(tags(cell))
        for statement in ast.parse(cell.source).body
        # A check in a solution is that of a part of a task, and no exercise
        if not (_is_check(statement) and "solution" in tags(cell))
    ]
    kept: list[ast.stmt] = []
    wanted: set[str] = set()
    for statement in reversed(statements):
        if _is_check(statement) or wanted & _changed(statement):
            kept.append(statement)
            wanted |= {n.id for n in ast.walk(statement) if isinstance(n, ast.Name)}
            # `globals().get("relative", ...)`
            wanted |= {
                n.value
                for n in ast.walk(statement)
                if isinstance(n, ast.Constant) and isinstance(n.value, str)
            }
    return kept[::-1]


def _changed(statement: ast.stmt) -> set[str]:
    """Names that a statement binds, or whose values it changes, maybe by a method."""
    names: set[str] = set()
    for node in ast.walk(statement):
        if isinstance(node, ast.FunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.alias):
            names.add((node.asname or node.name).partition(".")[0])
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            names |= {n.id for n in ast.walk(node.value) if isinstance(n, ast.Name)}
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            if isinstance(node.value.func, ast.Attribute):  # such as rows.append(row)
                names.add(ast.unparse(node.value.func.value))
    return names


def _is_check(statement: ast.stmt) -> bool:
    """Whether a statement is a call such as `chapter2.correlation(correlation)`."""
    return isinstance(statement, ast.Expr) and ast.unparse(statement).startswith(
        "chapter"
    )


def _exercise(lesson: str, call: ast.Call, names: dict) -> Exercise:
    """Return the exercise that a call checks, with what its arguments are by now."""
    first = call.args[0]
    module = names[call.func.value.id]
    answer, *others = (eval(ast.unparse(one), names) for one in call.args)
    name = first.id if isinstance(first, ast.Name) else first.args[0].value
    check = getattr(module, call.func.attr)
    return Exercise(lesson, name, module, check, answer, tuple(others))
