"""The reader's own program: what passed its check is kept in ``my_pgm.py``.

The file stands beside the reader's copies of the notebooks. Where it is missing, as
beside the notebooks of the project, it is neither read nor made.
"""

import ast
import builtins
import functools
import inspect
import itertools
import os
import symtable
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from pgm_lab import _validate


class CheckFailed(AssertionError):
    """An answer is wrong or missing; notebooks show the message without a traceback."""

    def _render_traceback_(self) -> list[str]:
        return [f"✗ {self}"]


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
    imports, sources = parts(function)
    if not Path(FILE).is_file():
        print(
            f"({function.__name__} goes into your program, {FILE}, where there is one"
            " beside the notebook, as in work/. An empty file begins it.)"
        )
        return
    before = Path(FILE).read_text(encoding="utf-8")
    after = joined(before, imports, sources)
    if after != before:
        part = Path(f".{FILE}.part")
        part.write_text(after, encoding="utf-8", newline="\n")
        os.replace(part, FILE)  # in one step: no half a program
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
    module = ModuleType(MODULE)
    text = Path(FILE).read_text(encoding="utf-8")
    exec(compile(text, FILE, "exec"), vars(module))
    return module


# --- The text of the reader's program: a function's source goes in, the rest stays ---

MODULE = "my_pgm"
FILE = f"{MODULE}.py"


def parts(function: Any) -> tuple[list[str], dict[str, str]]:
    """Return the imports a function needs, and its source and its helpers' by name."""
    imports: set[str] = set()
    sources: dict[str, str] = {}
    values: set[str] = set()
    waiting = [function]
    while waiting:
        one = waiting.pop()
        sources[one.__name__] = source_of(one)
        for name in sorted(names_read(sources[one.__name__]) - sources.keys()):
            value = one.__globals__.get(name)
            if isinstance(value, FunctionType) and value.__globals__ is one.__globals__:
                waiting.append(value)
            elif line := import_of(name, value):
                imports.add(line)
            elif name in one.__globals__ and not is_kept(name, value):
                values.add(name)
    if values:
        raise CheckFailed(
            f"{function.__name__} is right, but it uses"
            f" {', '.join(f'`{name}`' for name in sorted(values))} of this notebook,"
            f" which {FILE} does not have. Hand it over as an argument, or set it"
            " inside the function; then run this cell again."
        )
    return sorted(imports), sources


def source_of(function: Any) -> str:
    """Return a function as it was typed."""
    name = getattr(function, "__name__", "the function")
    if not isinstance(function, FunctionType) or not name.isidentifier():
        raise CheckFailed(f"{name} must be written with `def` in this notebook.")
    try:
        return textwrap.dedent(inspect.getsource(function)).rstrip()
    except OSError:
        raise CheckFailed(
            f"the text of {name} is not known any more. Run the cell that defines it,"
            " then this one."
        ) from None


def names_read(source: str) -> set[str]:
    """Names that a function takes from outside it."""
    module = symtable.symtable(source, FILE, "exec")
    read = {
        symbol.get_name()
        for scope in scopes(module)
        for symbol in scope.get_symbols()
        if symbol.is_referenced() and (scope is module or symbol.is_global())
    }
    return read - set(dir(builtins))


def scopes(scope: symtable.SymbolTable) -> Iterator[symtable.SymbolTable]:
    """Yield the names of a piece of code, then those of each function in it."""
    yield scope
    for child in scope.get_children():
        yield from scopes(child)


def import_of(name: str, value: Any) -> str:
    """Write the import that gives a value its name; nothing if there is none."""
    if isinstance(value, ModuleType):
        path = value.__name__
        return f"import {path}" + (f" as {name}" if path != name else "")
    home = "numpy" if isinstance(value, np.ufunc) else getattr(value, "__module__", "")
    original = getattr(value, "__name__", "")
    if home in ("", None, "__main__") or not original:
        return ""
    # From where a reader would take it: pgm_lab.ncc rather than pgm_lab.ncc._windows
    rooms = [*itertools.accumulate(home.split("."), "{}.{}".format)]
    known = [r for r in rooms if getattr(sys.modules.get(r), original, None) is value]
    if not known:
        return ""
    line = f"from {known[0]} import {original}"
    return line if original == name else f"{line} as {name}"


def is_kept(name: str, value: Any) -> bool:
    """Whether a value came from the reader's program, by this name."""
    origin = getattr(value, "__module__", ""), getattr(value, "__name__", "")
    return origin == (MODULE, name)


def joined(text: str, imports: list[str], sources: dict[str, str]) -> str:
    """Put imports and functions into the text of a program; the rest stays.

    A function takes the place of one of its name, or of an import of that name: the
    book's own, which was used until now.
    """
    bound = {name: node for node in parsed(text).body for name in names_bound(node)}
    wanted = {names_bound(parsed(line).body[0])[0]: line for line in imports}
    lines = text.splitlines()
    for name, node in sorted(bound.items(), key=lambda pair: -pair[1].lineno):
        first = min([node.lineno, *(d.lineno for d in decorators(node))])
        place = slice(first - 1, last_line(node, lines))
        if name in sources and isinstance(node, ast.FunctionDef):
            lines[place] = sources.pop(name).splitlines()
        elif name in sources and is_import(node) and len(names_bound(node)) == 1:
            lines[place] = []
        elif name in wanted and wanted[name] == ast.unparse(node):
            del wanted[name]
        elif name in wanted and isinstance(node, ast.FunctionDef):
            del wanted[name]  # the reader's own stands there already
        elif name in sources or name in wanted:
            raise CheckFailed(
                f"{FILE} uses the name {name} for something else, in line {first}."
                " Rename one of the two; then run this cell again."
            )
    top = list(itertools.takewhile(is_top, parsed("\n".join(lines)).body))
    end = (top[-1].end_lineno or 0) if top else 0
    if wanted:
        gap = [""] if top and not is_import(top[-1]) else []
        lines[end:end] = [*gap, *wanted.values()]
    whole = ["\n".join(lines).strip("\n"), *sources.values()]
    return "\n\n\n".join(part for part in whole if part) + "\n"


def last_line(node: ast.stmt, lines: list[str]) -> int:
    """Return the number of a function's last line, its comments at the end included."""
    end = node.end_lineno or 0
    for number, line in enumerate(lines[end:], start=end + 1):
        if isinstance(node, ast.FunctionDef) and line.lstrip().startswith("#"):
            if line[0] == "#":
                break
            end = number
        elif line.strip():
            break
    return end


def parsed(text: str) -> ast.Module:
    """Parse a program, or say where it cannot be read."""
    try:
        return ast.parse(text)
    except SyntaxError as error:
        raise CheckFailed(
            f"{FILE} cannot be read, look at its line {error.lineno}. Nothing was"
            " written into it. Mend it, then run this cell again."
        ) from None


def names_bound(node: ast.stmt) -> list[str]:
    """Names that a statement at the top of a program gives a meaning."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        return [one.asname or one.name.partition(".")[0] for one in node.names]
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    names = (one for one in ast.walk(node) if isinstance(one, ast.Name))
    return [one.id for one in names if isinstance(one.ctx, ast.Store)]


def decorators(node: ast.stmt) -> list[ast.expr]:
    """Return what stands above a function."""
    return getattr(node, "decorator_list", [])


def is_import(node: ast.stmt) -> bool:
    """Whether a statement imports."""
    return isinstance(node, ast.Import | ast.ImportFrom)


def is_top(node: ast.stmt) -> bool:
    """Whether a statement belongs to the head of a program: docstring and imports."""
    return is_import(node) or isinstance(node, ast.Expr)
