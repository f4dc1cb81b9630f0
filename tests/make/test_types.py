"""Every public function of the package says what it takes and what it gives.

mypy proves that the types are true (`make test`); that they are there is proven here.
"""

import ast

from pgm_book.make.environment import ROOT

PACKAGE = ROOT / "pgm_lab"


def untyped(source: str) -> list[str]:
    """The public functions of a module that lack a type, and methods of its classes."""
    return [
        function.name
        for function in public_functions(ast.parse(source))
        if lacks_a_type(function)
    ]


def public_functions(scope: ast.Module | ast.ClassDef) -> list[ast.FunctionDef]:
    found = []
    for node in scope.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            found += public_functions(node)
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            found.append(node)
    return found


def lacks_a_type(function: ast.FunctionDef) -> bool:
    taken = function.args
    named = [*taken.posonlyargs, *taken.args, *taken.kwonlyargs]
    named += [many for many in (taken.vararg, taken.kwarg) if many]
    bare = [one for one in named if one.annotation is None]
    unnamed = [one for one in bare if one.arg not in ("self", "cls")]
    return bool(unnamed) or function.returns is None


def test_every_public_function_is_typed():
    found = [
        f"{path.relative_to(ROOT).as_posix()}: {name}"
        for path in sorted(PACKAGE.rglob("*.py"))
        for name in untyped(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_a_missing_type_is_noticed():
    source = """
def good(x: int, *more: int) -> int: ...
def no_result(x: int): ...
def no_argument(x) -> int: ...
def no_option(*, x=1) -> int: ...
def _private(x): ...
class Public:
    def method(self, x): ...
    def typed(self) -> int: ...
class _Private:
    def method(self, x): ...
"""
    expected = ["no_result", "no_argument", "no_option", "method"]
    assert untyped(source) == expected


def test_the_package_tells_others_that_it_is_typed():
    assert (PACKAGE / "py.typed").read_text() == ""
