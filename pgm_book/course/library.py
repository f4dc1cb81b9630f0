"""What lies in the box beside a student's code: the library that students get.

It has `pgm_lab` and the book's own program, on which who is stuck can fall back, and
nothing that knows an answer: no checks, no tasks, no predictions. What draws is left
out, too, since nobody looks.
"""

import ast
import compileall
import dataclasses
import importlib
import inspect
import os
import shutil
from collections.abc import Iterable
from pathlib import Path

import numpy as np

import pgm_book
import pgm_lab
from pgm_lab import datasets

DRAWING = "plot", "report", "stereo_map", "command"  # rooms of pgm_lab
LEFT_OUT = "checks", "figures", "task"  # modules of a lesson, and of its case
GIVEN = ("ch02", "FIVE"), ("ch07", "images")  # data that a notebook takes from checks

BOXED = Path(__file__).parent / "boxed"
NOTHING = "from nothing import __getattr__\n"
LOADED = """
from pathlib import Path

import numpy as np

_{name} = np.load(Path(__file__).parent / "{name}.npy")
{name} = {call}_{name}
"""

# scikit-image takes longer to import than most exercises take.
MOTORCYCLE = """

def motorcycle() -> StereoPair:
    with np.load(folder() / "motorcycle.npz") as values:
        return StereoPair(**{k: v if v.ndim else float(v) for k, v in values.items()})
"""


def write_library(folder: Path) -> None:
    """Write the students' library into an empty folder, compiled."""
    lab, book = Path(pgm_lab.__file__).parent, Path(pgm_book.__file__).parent
    skipped = shutil.ignore_patterns("__pycache__", "data", "*.j2", *DRAWING)
    shutil.copytree(lab, folder / "pgm_lab", ignore=skipped)
    for room in ("", "program", *(path.name for path in book.glob("ch??"))):
        (folder / "pgm_book" / room).mkdir()
        for path in (book / room).glob("*.py"):
            left_out = path.stem.removeprefix("case_") in LEFT_OUT
            text = NOTHING if left_out else path.read_text(encoding="utf-8")
            (folder / "pgm_book" / room / path.name).write_text(text, encoding="utf-8")
    for room, name in GIVEN:
        given = getattr(importlib.import_module(f"pgm_book.{room}.checks"), name)
        with (folder / "pgm_book" / room / "checks.py").open("a") as file:
            values = given() if callable(given) else given
            np.save(folder / "pgm_book" / room / name, values)
            file.write(LOADED.format(name=name, call="lambda: " * callable(given)))
    common = folder / "pgm_book" / "common"
    common.mkdir()
    for name in ("__init__.py", "figures.py"):
        shutil.copy(book / "common" / name, common)
    shutil.copy(BOXED / "checks.py", common)
    (common / "own_program.py").write_text(f"{NOTHING}FILE = 'my_pgm.py'\n")
    shutil.copy(BOXED / "task.py", folder / "pgm_book")
    module, data = folder / "pgm_lab" / "datasets.py", folder / "pgm_lab" / "data"
    text = module.read_text(encoding="utf-8").replace("import skimage.data\n", "")
    module.write_text(text + MOTORCYCLE, encoding="utf-8")
    compileall.compile_dir(folder, quiet=2)
    shutil.copytree(datasets.folder(), data)
    np.savez(data / "motorcycle.npz", **dataclasses.asdict(datasets.motorcycle()))


def without(library: Path, folder: Path, functions: Iterable[str]) -> None:
    """Copy a library in which some functions only say that they are the book's own.

    `functions` are dotted names, such as ``pgm_lab.ncc.correlation``.
    """

    def linked(source: str, target: str) -> None:
        os.link(source, target)  # its thousand files take no room, and stay compiled

    shutil.copytree(library, folder, copy_function=linked)
    for name in functions:
        module, _, attribute = name.rpartition(".")
        found = inspect.unwrap(getattr(importlib.import_module(module), attribute))
        home = folder / f"{found.__module__.replace('.', '/')}.py"
        if not home.is_file():
            home = home.with_suffix("") / "__init__.py"
        text = emptied(home.read_text(encoding="utf-8"), found.__name__)
        home.unlink()  # the link, not the library's file
        home.write_text(text, encoding="utf-8")
        for compiled in (home.parent / "__pycache__").glob(f"{home.stem}.*.pyc"):
            compiled.unlink()  # it still has the function


def emptied(text: str, function: str) -> str:
    """Give a function of a module another body: it says that it is the book's own."""
    lines = text.split("\n")
    *_, node = [  # the last: before it may stand overloads of its type
        one
        for one in ast.parse(text).body
        if isinstance(one, ast.FunctionDef) and one.name == function
    ]
    body = slice(node.body[0].lineno - 1, node.end_lineno)
    lines[body] = [
        "    from nothing import BooksOwn",
        f'    raise BooksOwn("{function} is the book\'s own")',
    ]
    return "\n".join(lines)
