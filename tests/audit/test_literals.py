"""No test compares literals with literals: it would prove what its author typed."""

import ast
import builtins
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# What adds nothing to a literal; and the methods that put something into a container
PLAIN = {*dir(builtins), "approx", "pytest"} - {"open"}
FILLS = {"append", "extend", "update", "add", "insert", "setdefault"}
EMPTY = {"[]", "{}", "set()", "dict()"}  # to be filled by somebody
CLOSE = {"close", "assert_allclose", "assert_array_equal"}


def names(node, context=(ast.Load, ast.Store)):
    every = (n for n in ast.walk(node) if isinstance(n, ast.Name))
    return {n.id for n in every if isinstance(n.ctx, context)}


def needed(node):
    """Names that have to be bound to literals if this expression is one."""
    inner = (n.target for n in ast.walk(node) if isinstance(n, ast.comprehension))
    return names(node).difference(PLAIN, *map(names, inner))


def bindings(function):
    """Names of a function with what they are bound to; None if that may be anything."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                plain = isinstance(target, ast.Name | ast.Tuple)
                yield from ((n, node.value if plain else None) for n in names(target))
        elif isinstance(node, ast.AnnAssign | ast.AugAssign | ast.NamedExpr):
            yield from ((n, node.value) for n in names(node.target))
        elif isinstance(node, ast.For):
            yield from ((n, node.iter) for n in names(node.target))
        elif isinstance(node, ast.withitem) and node.optional_vars:
            yield from ((n, None) for n in names(node.optional_vars))
        elif isinstance(node, ast.Attribute) and node.attr in FILLS:
            yield from ((n, None) for n in names(node.value))
        elif isinstance(node, ast.arg):
            yield node.arg, None


def literals_in(function):
    """Names of a function that are bound to literals alone."""
    anything = {"anything"}  # never bound to a literal
    bound, known, more = [], set(), True
    for name, value in bindings(function):
        empty = value is None or ast.unparse(value) in EMPTY
        bound.append((name, anything if empty else needed(value)))
    while more:
        other = {name for name, needs in bound if not needs <= known}
        more = {name for name, _ in bound} - other - known
        known |= more
    return known


def findings(source):
    """Lines on which a test asserts something of literals alone."""
    functions = [
        f for f in ast.walk(ast.parse(source)) if isinstance(f, ast.FunctionDef)
    ]
    for function in functions:
        known = literals_in(function)
        for node in ast.walk(function):
            if isinstance(node, ast.Assert):
                both = isinstance(node.test, ast.BoolOp) and isinstance(
                    node.test.op, ast.And
                )
                parts = node.test.values if both else [node.test]
            elif isinstance(node, ast.Call) and names(node.func) & CLOSE:
                parts = [ast.Tuple(node.args[:2], ast.Load())]
            else:
                continue
            if any(needed(part) <= known for part in parts):
                yield node.lineno


def test_no_test_compares_literals_with_literals():
    found = [
        f"{path.relative_to(ROOT).as_posix()}:{line}"
        for path in sorted((ROOT / "tests").rglob("*.py"))
        for line in sorted(set(findings(path.read_text(encoding="utf-8"))))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("a = {'x': 1}\n b = {'x': 1}\n assert a == b", True),
        ("assert [w[0] for w in 'Land Survey'.split()] == list('LS')", True),
        ("assert 25 > 14.35 > 10", True),
        ("said = {1: 'none', 2: 'few'}\n assert len(set(said.values())) == 2", True),
        ("bits = 24\n assert DATA.bits == 24 and 2 ** (bits // 3) == 256", True),
        ("assert 5000 / 2000 == approx(2.5)", True),
        ("close(5000 / 2000, 2.5)", True),
        ("assert DATA.bits == 24 == 3 * 8", False),
        ("found = [0]\n found.append(DATA)\n assert found == [1]", False),
        ("found = {}\n fill(found)\n assert found == {1: 2}", False),
        ("for n in (1, 2):\n  assert n == 1 or DATA[n] == 2", False),
        ("n = 0\n n += len(DATA)\n assert n == 2", False),
    ],
)
def test_literals_are_told_from_what_was_computed(body, found):
    assert bool(list(findings(f"def test():\n {body}"))) == found
