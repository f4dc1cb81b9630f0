"""Every public function of the package says what it takes and what it gives.

mypy proves that the types are true (`make test`); that they are there is proven here.
"""

import ast

from pgm_book.make.environment import ROOT

PACKAGE = ROOT / "pgm_lab"


def untyped(source: str) -> list[str]:
    """The public functions of a module that lack a type, and methods of its classes."""
    found, scopes = [], [ast.parse(source)]
    while scopes:
        for node in scopes.pop().body:
            if getattr(node, "name", "_").startswith("_"):
                continue
            if isinstance(node, ast.ClassDef):
                scopes.append(node)
            elif isinstance(node, ast.FunctionDef):
                taken = [one for one in ast.walk(node.args) if isinstance(one, ast.arg)]
                bare = {one.arg for one in taken if one.annotation is None}
                if bare - {"self", "cls"} or node.returns is None:
                    found.append(node.name)
    return found


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
