"""Any cell of a notebook can be run again: what one cell reads, one other cell binds.

A reader goes back, changes a number and runs a cell again, in any order. That works if
each name that a cell takes from another one means one thing in the whole notebook.
Values that change in place, such as a random generator, are not seen.
"""

import ast
import builtins
import json
import symtable

import pytest

from pgm_book.make import form, notebooks

# Those whose names were sorted out, besides all lessons and cases
HELD = ("00_", "06_", "A1_")


def reread(cells: list[tuple[str, str]]) -> list[str]:
    """Names that a cell reads from others, and that more than one cell binds."""
    used = [(name, *reads_and_binds(ast.parse(code))) for name, code in cells]
    found = []
    for name in sorted(set().union(*(reads for _, reads, _ in used))):
        binders = [cell for cell, _, binds in used if name in binds]
        if len(binders) > 1:
            readers = [cell for cell, reads, _ in used if name in reads]
            found.append(f"{name}: read in {readers}, bound in {binders}")
    return found


def reads_and_binds(tree: ast.Module) -> tuple[set[str], set[str]]:
    """Names that a cell reads before it binds them, or in functions; those it binds."""
    reads: set[str] = set()
    bound: set[str] = set()

    def read(*nodes: ast.AST | None) -> None:
        for node in nodes:
            if node is not None:
                reads.update(_of_module(node, "reads") - bound)

    def walk(statements: list[ast.stmt]) -> None:
        for one in statements:
            match one:
                case ast.For():
                    read(one.iter)
                    bound.update(_of_module(one.target, "binds"))
                    walk(one.body + one.orelse)
                case ast.With():
                    for item in one.items:
                        read(item.context_expr)
                        if item.optional_vars is not None:
                            bound.update(_of_module(item.optional_vars, "binds"))
                    walk(one.body)
                case ast.If() | ast.While():
                    read(one.test)
                    walk(one.body + one.orelse)
                case ast.Try():
                    walk(one.body)
                    for handler in one.handlers:
                        read(handler.type)
                        bound.update({handler.name} - {None})
                        walk(handler.body)
                    walk(one.orelse + one.finalbody)
                case ast.FunctionDef():
                    read(*one.args.defaults, *one.args.kw_defaults, *one.decorator_list)
                    # read when it is called, perhaps from another cell
                    reads.update(_of_module(one, "reads"))
                    bound.add(one.name)
                case ast.AugAssign():
                    names = {n.id for n in ast.walk(one) if isinstance(n, ast.Name)}
                    reads.update(names - bound)
                    bound.update(_of_module(one, "binds"))
                case _:
                    read(one)
                    bound.update(_of_module(one, "binds"))

    walk(tree.body)
    return reads - set(dir(builtins)), bound


def _of_module(node: ast.AST, kind: str) -> set[str]:
    """Names of the module that a piece of code reads, in functions too, or binds."""
    code = ast.unparse(node)
    if isinstance(node, ast.expr) and isinstance(getattr(node, "ctx", None), ast.Store):
        code = f"{code} = None"
    found = set()

    def visit(table: symtable.SymbolTable) -> None:
        for one in table.get_symbols():
            top = table.get_type() == "module"
            if kind == "reads":
                wanted = one.is_referenced() and (top or one.is_global())
            else:
                wanted = top and (one.is_assigned() or one.is_imported())
            if wanted:
                found.add(one.get_name())
        for child in table.get_children():
            visit(child)

    visit(symtable.symtable(code, "cell", "exec"))
    return found


@pytest.mark.parametrize(
    "path",
    [
        path
        for path in sorted(notebooks.FOLDER.glob("*.ipynb"))
        if path.name.startswith(HELD) or path.stem in form.kinds()
    ],
    ids=lambda path: path.stem,
)
def test_each_cell_can_be_run_again_after_all(path):
    whole = json.loads(path.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in whole if cell["cell_type"] == "code"]
    assert reread([(cell["id"], "".join(cell["source"])) for cell in code]) == []


@pytest.mark.parametrize(
    "cells, names",
    [
        (["n = 1", "print(n)", "n = 2"], ["n"]),
        (["n = 1", "print(n)", "n = 2\nprint(n)"], ["n"]),
        (["n = 1", "n = n + 1"], ["n"]),
        (["n = 1", "n += 1"], ["n"]),
        (["n = 1", "for i in n:\n    print(i)", "n = 2"], ["n"]),
        (["n = 1", "a[n] = 2", "with open(n) as n:\n    pass"], ["n"]),
        (["n = 1", "def f():\n    return n", "n = 2"], ["n"]),
        (["n = 1\ndef f():\n    return n", "f()", "n = 2"], ["n"]),
        (["n = 1", "[i for i in range(n)]", "n = 2"], ["n"]),
        (["n = 1", "if n:\n    pass", "import n"], ["n"]),
        (["n = 1", "def f(x=n):\n    pass", "def n():\n    pass"], ["n"]),
        (["n = 1\nprint(n)", "n = 2", "print(n)"], ["n"]),
        (["n = 1\nprint(n)", "n = 2\nprint(n)", "n = 3\nprint(n)"], []),
        (["n = 1", "print(n)", "print([n for n in range(3)])"], []),
        (["n = 1", "print(n)", "print((lambda n: n)(2))", "a.n = 2"], []),
        (["def f():\n    return n", "n = 1", "print(n)"], []),
        (["def f():\n    return n\nn = 1", "f()"], []),
        (["def f(n):\n    n = 2\n    return n", "n = 1", "print(n, f(n))"], []),
        (["for n in range(3):\n    print(n)", "for n in range(3):\n    print(n)"], []),
        (["try:\n    f()\nexcept E as n:\n    n\n", "n = 2\nprint(n)"], []),
    ],
)
def test_the_rule_sees_what_a_second_run_would(cells, names):
    found = reread([(str(k), code) for k, code in enumerate(cells)])
    assert [line.partition(":")[0] for line in found] == names
