"""Functions of the library that alone answer an exercise, or nearly."""

import csv
import importlib
import pkgutil
import re
from importlib import resources

import numpy as np
import pytest

from pgm_book import program
from pgm_book.common.own_program import with_arrays
from pgm_book.make.notebooks import FOLDER
from tests.course import exercises
from tests.course.test_rubric import POINTS, SOME

FILE = resources.files("pgm_book.course") / "counterparts.csv"
with FILE.open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))
NAMED = {(row["lesson"], row["exercise"]): row["functions"].split() for row in ROWS}


def function_of(name):
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(module), last)


def of_the_program():
    """Public functions of the book's program, each where it is defined."""
    for module in pkgutil.iter_modules(program.__path__, "pgm_book.program."):
        for name, one in vars(importlib.import_module(module.name)).items():
            if getattr(one, "__module__", "") == module.name and name[0] != "_":
                yield f"{module.name}.{name}", one


def test_each_function_exists_and_its_exercise_too():
    assert set(NAMED) <= set(POINTS)
    assert all(
        callable(function_of(name)) for names in NAMED.values() for name in names
    )
    near = {name for row in ROWS for name in row["near"].split()}
    assert all(pkgutil.resolve_name(n) for n in near if n.startswith("pgm_lab"))


def test_the_book_s_own_functions_of_the_notebooks_are_named():
    named = {function_of(name) for names in NAMED.values() for name in names}
    missing = set()
    for path in FOLDER.glob("0[1-9]*.ipynb"):
        text = path.read_text(encoding="utf-8")
        for own in re.findall(r'checks\.own\(\\"\w+\\", program\.([\w.]+)\)', text):
            if function_of(f"pgm_book.program.{own}") not in named:
                missing.add(own)
    assert missing == {"surface.normal_case"}  # a part of a task, no exercise


@pytest.mark.slow
@pytest.mark.parametrize("stem", SOME)
def test_whatever_of_the_program_passes_a_check_is_named(stem):
    missing = []
    for one in exercises.of(stem):
        if not callable(one.solution):
            continue
        named = [function_of(name) for name in NAMED.get((one.lesson, one.name), [])]
        for name, function in of_the_program():
            try:
                with np.errstate(all="ignore"):
                    told = one.properties(with_arrays(function))
            except Exception:  # not its arguments
                continue
            if told and all(holds for _, holds in told) and function not in named:
                missing.append((one.name, name))
    assert missing == []
