"""The reader's own program: what passed its check is kept in ``my_pgm.py``.

The file stands beside the reader's copies of the notebooks. Where it is missing, as
beside the notebooks of the project, it is neither read nor made.
"""

import ast
import builtins
import functools
import inspect
import itertools
import symtable
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from pgm_lab.io import files

MODULE = "my_pgm"
FILE = f"{MODULE}.py"


class CheckFailed(AssertionError):
    """An answer is wrong or missing; notebooks show the message without a traceback.

    Attributes
    ----------
    properties : tuple of (str, bool or None)
        Each property that the check names and whether it holds; None: another has to
        hold first. Empty where the check stopped before.
    """

    properties: tuple[tuple[str, bool | None], ...] = ()

    def _render_traceback_(self) -> list[str]:
        return [f"✗ {self}"]


# --- What a lesson calls ---


def keep(function: Callable) -> None:
    """Keep a function that passed its check in the reader's program, ``my_pgm.py``.

    The source is kept as typed, with the imports and the functions of the notebook that
    it uses; an older one of that name is replaced, everything else in the file stays.
    Where there is no ``my_pgm.py`` beside the notebook, nothing is written.

    Raises
    ------
    CheckFailed
        If the function cannot be taken out of the notebook, or the file cannot be
        read; nothing is written then.
    """
    imports, sources = collected(function)
    path = Path(FILE)
    if not path.is_file():
        print(
            f"({function.__name__} is kept in {FILE} when that file is in the"
            " notebook's folder, as it is in work/.)"
        )
        return
    before = path.read_text(encoding="utf-8")
    after = merged(before, imports, sources)
    if after != before:
        files.save({path: after}, overwrite=True)  # atomic
    print(f"✓ {function.__name__} is a part of your program now, {FILE}.")


def own(name: str, book: Callable) -> Callable:
    """Return the reader's function of this name from ``my_pgm.py``, or the book's own.

    It prints which of the two it is. Where the reader's returns a list, or a tuple of
    numbers, it is converted to an array.

    Examples
    --------
    >>> largest = own("largest", max)
    largest: the book's own. Yours takes its place once its check has passed.
    >>> largest([1, 3, 2])
    3
    """
    why = "Yours takes its place once its check has passed."
    if Path(FILE).is_file():
        try:
            found = getattr(loaded(), name, None)
        except Exception as error:  # whatever a reader's file raises
            found, why = None, f"{FILE} does not run: {type(error).__name__}, {error}."
        if callable(found) and found is not book:  # the book's, by an import of keep
            print(f"{name}: yours, from {FILE}.")
            return with_arrays(found)
    print(f"{name}: the book's own. {why}")
    return book


def loaded() -> ModuleType:
    """Run the reader's file anew, as a module that nobody else sees."""
    module = ModuleType(MODULE)
    text = Path(FILE).read_text(encoding="utf-8")
    exec(compile(text, FILE, "exec"), vars(module))
    return module


def with_arrays(function: Callable) -> Callable:
    """Let a function return arrays for lists, and for tuples of numbers."""

    @functools.wraps(function)
    def answer(*arguments: Any, **named: Any) -> Any:
        found = function(*arguments, **named)
        if not isinstance(found, list | tuple):
            return found
        try:
            array = np.array(found)
        except ValueError:  # parts of several shapes
            return found
        return found if isinstance(found, tuple) and array.ndim > 1 else array

    return answer


# --- Out of the notebook: a function's source, its helpers, and their imports ---


def collected(function: Any) -> tuple[dict[str, str], dict[str, str]]:
    """Return the imports by the name they give, and the sources by function."""
    imports, sources, waiting, values = {}, {}, [function], set()
    renamed: dict[str, str] = {}  # what the source calls by another name than its own
    while waiting:
        one = waiting.pop()
        source = sources[one.__name__] = source_of(one)
        for name in sorted(names_read(source) & one.__globals__.keys()):
            value = one.__globals__[name]
            known = getattr(value, "__name__", name)
            if isinstance(value, FunctionType) and value.__globals__ is one.__globals__:
                waiting += [value] if value.__name__ not in sources else []
            elif line := import_of(name, value):
                imports[name] = line
                continue
            elif getattr(value, "__module__", "") != MODULE:  # it is not there already
                values.add(f"`{name}`")
                continue
            if name != known:
                renamed[name] = known
    if values:
        raise CheckFailed(
            f"{function.__name__} is right, but it uses {', '.join(sorted(values))} of"
            f" this notebook, which {FILE} does not have. Pass it as an argument,"
            " or set it inside the function; then run this cell again."
        )
    for name, known in renamed.items():
        raise CheckFailed(
            f"{function.__name__} is right, but it uses `{name}`, which is `{known}`"
            f" in {FILE}. Write `{known}`; then run this cell again."
        )
    return imports, sources


def source_of(function: Any) -> str:
    """Return a function as it was typed."""
    name = getattr(function, "__name__", "the function")
    if not isinstance(function, FunctionType) or not name.isidentifier():
        raise CheckFailed(f"{name} must be written with `def` in this notebook.")
    try:
        return textwrap.dedent(inspect.getsource(function)).rstrip()
    except OSError:
        raise CheckFailed(
            f"the text of {name} is no longer known. Run the cell that defines it,"
            " then this one."
        ) from None


def names_read(source: str) -> set[str]:
    """Names that a function takes from outside it, nested functions included."""
    scopes, read = [symtable.symtable(source, FILE, "exec")], set()
    for scope in scopes:
        scopes += scope.get_children()
        read |= {
            one.get_name()
            for one in scope.get_symbols()
            if one.is_global() and one.is_referenced()
        }
    return read - set(dir(builtins))


def import_of(name: str, value: Any) -> str:
    """Write the import that gives a value its name; nothing if there is none."""
    if isinstance(value, ModuleType):
        line, original = f"import {value.__name__}", value.__name__
        return line if original == name else f"{line} as {name}"
    home = "numpy" if isinstance(value, np.ufunc) else getattr(value, "__module__", "")
    original = getattr(value, "__name__", "")
    # From where a reader would take it: pgm_lab.ncc rather than pgm_lab.ncc._windows
    for package in itertools.accumulate((home or "").split("."), "{}.{}".format):
        offered = getattr(sys.modules.get(package), original or "?", None)
        if offered is value and package != "__main__":
            line = f"from {package} import {original}"
            return line if original == name else f"{line} as {name}"
    return ""


# --- Into the program: functions and imports replace those of the same name ---


def merged(text: str, imports: dict[str, str], sources: dict[str, str]) -> str:
    """Put imports and functions into the text of a program.

    A function takes the place of one of its name, or of an import of that name: the
    book's own, which was used until now.
    """
    lines, imports, sources = text.splitlines(), imports.copy(), sources.copy()
    # From the last statement to the first, so that line numbers hold
    for node in reversed(parsed(text).body):
        names, place = names_bound(node), place_of(node, lines)
        is_function, line = isinstance(node, ast.FunctionDef), ast.unparse(node)
        for name in names:
            if name in sources and is_function:
                lines[place] = sources.pop(name).splitlines()
            elif name in sources and is_import(node) and len(names) == 1:
                lines[place] = []
            elif name in imports and (is_function or line == imports[name]):
                del imports[name]  # it stands there already, or the reader's own does
            elif name in sources or name in imports:
                raise CheckFailed(
                    f"{FILE} uses the name {name} for something else, in line"
                    f" {place.start + 1}. Rename one of the two; then run this cell"
                    " again."
                )
    # New imports end the head of docstring and imports, new functions the program
    end, gap = 0, []
    for node in parsed("\n".join(lines)).body:
        if not (is_import(node) or type(node) is ast.Expr):
            break
        end, gap = node.end_lineno or 0, [] if is_import(node) else [""]
    if imports:
        lines[end:end] = [*gap, *sorted(imports.values())]
    whole = ["\n".join(lines).strip("\n"), *sources.values()]
    return "\n\n\n".join(part for part in whole if part) + "\n"


def parsed(text: str) -> ast.Module:
    """Parse a program, or say where it cannot be read."""
    try:
        return ast.parse(text)
    except SyntaxError as error:
        raise CheckFailed(
            f"{FILE} cannot be read, look at its line {error.lineno}. Nothing was"
            " written into it. Correct it, then run this cell again."
        ) from None


def names_bound(node: ast.stmt) -> list[str]:
    """Names that a statement at the top of a program gives a meaning."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        return [one.asname or one.name.partition(".")[0] for one in node.names]
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    names = (one for one in ast.walk(node) if isinstance(one, ast.Name))
    return [one.id for one in names if isinstance(one.ctx, ast.Store)]


def place_of(node: ast.stmt, lines: list[str]) -> slice:
    """Lines of a statement: a function's decorators and last comments included."""
    start = min(one.lineno for one in [node, *getattr(node, "decorator_list", [])])
    end = node.end_lineno or 0
    if isinstance(node, ast.FunctionDef):
        inside = itertools.takewhile(lambda s: not s or s[0].isspace(), lines[end:])
        end += len("\n".join(inside).rstrip().splitlines())
    return slice(start - 1, end)


def is_import(node: ast.stmt) -> bool:
    """Whether a statement imports."""
    return isinstance(node, ast.Import | ast.ImportFrom)
