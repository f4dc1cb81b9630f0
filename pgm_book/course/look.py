"""What a lecturer may want to look at: no verdicts, and no points.

Code that does what no exercise asks for, outputs that say what is not so, and students
whose answers have the same unusual structure, whatever the names in it.
"""

import ast
import itertools
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping

from pgm_book.course import intake
from pgm_book.course.intake import Submission

SYSTEM = frozenset(
    "builtins ctypes gc importlib inspect multiprocessing os pickle requests shutil"
    " signal socket subprocess sys threading urllib".split()
)
CALLS = frozenset("__import__ compile eval exec open setattr delattr".split())
MOST = 20  # remarks on a piece of code
GRAM = 6  # nodes of a syntax tree that follow each other
RARE = 0.25  # share of the class that has it too
COMMON, TOGETHER = 0.6, 12  # share and number of rare pieces of which a pair is named


def at_cells(submission: Submission, known: frozenset[str]) -> list[str]:
    """Name what the cells and the program of a student do that no exercise asks for.

    `known` are the cells of the book, which may do so.
    """
    parts = {
        f"{notebook.file}, cell {k}": cell
        for notebook in submission.notebooks
        for k, cell in enumerate(notebook.cells, 1)
        if cell.strip() not in known
    }
    parts |= {"my_pgm.py": submission.program}
    return [f"{place}: {what}" for place, code in parts.items() for what in doing(code)]


def doing(code: str) -> list[str]:
    r"""Name what a piece of code does beyond computing.

    Examples
    --------
    >>> doing("import os\nnp.dot = print")
    ['imports os', 'gives np.dot another value']
    """
    try:
        tree = ast.parse(code)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ["cannot be read as Python"]
    found = []
    modules = {
        one.asname or one.name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for one in node.names
    } | {"np", "checks"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = {one.name.partition(".")[0] for one in node.names}
            found += [f"imports {name}" for name in sorted(names & SYSTEM)]
        elif isinstance(node, ast.ImportFrom):
            name = (node.module or "").partition(".")[0]
            found += [f"imports {name}"] if name in SYSTEM else []
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            found += [f"calls {node.func.id}"] if node.func.id in CALLS else []
        elif isinstance(node, ast.Attribute):
            name, of = _written(node), node.value
            of = of.value if isinstance(of, ast.Attribute) else of
            if node.attr.startswith("__"):
                found.append(f"reads {name}")
            elif isinstance(node.ctx, ast.Store | ast.Del) and (
                isinstance(of, ast.Name)
                and (of.id in modules or of.id.startswith("chapter"))
            ):
                found.append(f"gives {name} another value")
    return list(dict.fromkeys(found))[:MOST]


def _written(node: ast.Attribute) -> str:
    """Write an attribute as in the code, its beginning if that is long."""
    try:
        return ast.unparse(node)[:60]
    except (RecursionError, ValueError):  # too deep, or a number of 5000 digits
        return f"... .{node.attr}"[:60]


def calls_of(cells: Iterable[str], names: set[str], table: Iterable[str]) -> list[str]:
    r"""Name what an answer takes from a table of functions and modules.

    `cells` may hold more than the answer: what `names` need of them counts.

    Examples
    --------
    >>> code = "from pgm_lab import ncc\ndef f(a, b): return ncc.correlation(a, b)"
    >>> calls_of([code], {"f"}, ["pgm_lab.ncc"])
    ['pgm_lab.ncc.correlation']
    """
    tree = ast.parse("\n".join(cells))
    statements = tuple(map(ast.unparse, tree.body))
    answer = ast.parse("\n".join(intake.needed(statements, names)))
    homes: dict[str | None, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            homes |= {o.asname or o.name: o.name for o in node.names}
        elif isinstance(node, ast.ImportFrom):
            homes |= {o.asname or o.name: f"{node.module}.{o.name}" for o in node.names}
    found = {}
    for node in ast.walk(answer):
        if isinstance(node, ast.Name | ast.Attribute):
            name = ast.unparse(node)
            first, _, rest = name.partition(".")
            whole = f"{homes.get(first, first)}.{rest}".rstrip(".")
            if any(f"{whole}.".startswith(f"{one}.") for one in table):
                found[whole] = 0
    return [one for one in found if not any(o.startswith(f"{one}.") for o in found)]


# --- Near-equal answers ---


def functions(submission: Submission, names: Iterable[str]) -> dict[str, ast.AST]:
    """Return a student's functions of these names; of several the last."""
    wanted = set(names)
    found: dict[str, ast.AST] = {}
    cells = [cell for notebook in submission.notebooks for cell in notebook.cells]
    for code in (submission.program, *cells):
        try:
            tree = ast.parse(code)
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and node.name in wanted:
                found[node.name] = node
    return found


def pieces(function: ast.AST) -> set[tuple[str, ...]]:
    """Return the pieces of a function's structure; names and texts do not count."""
    kinds = [
        type(node).__name__ + _number(node)
        for node in ast.walk(function)
        if not isinstance(node, ast.Load | ast.Store | ast.arg | ast.arguments)
    ]
    return {tuple(kinds[k : k + GRAM]) for k in range(len(kinds) - GRAM + 1)}


def _number(node: ast.AST) -> str:
    """Return what tells one number from another; nothing for what is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return str(hash(node.value))  # a number of 5000 digits has no text
    return ""


def near_equal(
    answers: Mapping[str, Mapping[str, ast.AST]],
    template: Mapping[str, ast.AST],
) -> list[tuple[str, str, float, tuple[str, ...]]]:
    """Return pairs of students who share what few others have, the nearest first.

    `answers` are the functions of each student, `template` what they were given. A pair
    comes with its share of common
    among its rare pieces, and the functions in which it has any in common.
    """
    structure = {
        who: {
            name: pieces(tree) - (pieces(template[name]) if name in template else set())
            for name, tree in of.items()
        }
        for who, of in answers.items()
    }
    having: dict[str, Counter] = defaultdict(Counter)
    for of in structure.values():
        for name, some in of.items():
            having[name].update(some)
    most = max(2, RARE * len(answers))
    rare = {
        who: {
            (name, one) for name, some in of.items() for one in some
            if having[name][one] <= most
        }
        for who, of in structure.items()
    }  # fmt: skip
    found = []
    for a, b in itertools.combinations(sorted(rare), 2):
        both = rare[a] & rare[b]
        share = len(both) / max(1, min(len(rare[a]), len(rare[b])))
        if len(both) >= TOGETHER and share >= COMMON:
            found.append((a, b, share, tuple(sorted({name for name, _ in both}))))
    return sorted(found, key=lambda one: -one[2])
