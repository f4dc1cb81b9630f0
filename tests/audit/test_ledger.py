"""The ledger itself: every row is complete; the test and code it names exist."""

import ast
import inspect
import pkgutil
import random
import re
from pathlib import Path

import pytest

from pgm_book.common import ledger
from pgm_lab import datasets

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = [
    "chapter",
    "source",
    "place",
    "kind",
    "printed",
    "obtained",
    "verdict",
    "cause",
    "code",
    "test",
]
MAY_BE_EMPTY = {"cause", "code"}
ALLOWED = {
    "source": set(ledger.CITED_AS),
    "kind": {"number", "equation", "program", "statement"},
    "verdict": {"reproduced", "corrected", "not derivable"},
    "cause": {"", "author", "scan", "unclear"},
}
# What stands for the code when there is none
NO_CODE = {"-: misprint only", "-: not used"}
# What stands for the test where nothing printed lets a program decide; an equation has
# a test
NO_TEST = "-: read, not proved"
ROWS = datasets.rows("audit")
EQUATIONS = [row for row in ROWS if row["kind"] == "equation"]


def proofs_in(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


PROOFS = {
    path.name: proofs_in(path) for path in (ROOT / "tests" / "audit").glob("test_*.py")
}


def function(name: str):
    """The function or class of a full name such as pgm_lab.bundle.dense.G."""
    module, _, last = name.rpartition(".")
    return pkgutil.resolve_name(f"{module}:{last}")


def size(number: str) -> tuple:
    """(2, 14, "a") for "2.14a", to compare numbers of equations."""
    whole = re.findall(r"\d+", number)
    return *map(int, whole), number.removeprefix(".".join(whole))


def cites(docstring: str, equation: str) -> bool:
    """Whether a docstring cites (M 2.95), alone or in (M 2.75) to (M 2.95)."""
    source, _, number = equation.partition(" ")
    if f"({equation})" in docstring:
        return True
    ranges = rf"\({source} (\d[\w.]*)\)\s+to\s+\({source} (\d[\w.]*)\)"
    return number[0].isdigit() and any(
        size(first) <= size(number) <= size(last + "z")
        for first, last in re.findall(ranges, docstring)
    )


def problems_of_code(row: dict[str, str]) -> list[str]:
    """What is wrong with the code that a row of the ledger names, in words."""
    if row["kind"] != "equation":
        return ["code is for equations only"] if row["code"] else []
    if row["code"].startswith("-"):
        return [] if row["code"] in NO_CODE else [f"code is {row['code']!r}"]
    found, missing = [], set(ledger.equations(row))
    for name in row["code"].split("; "):
        try:
            docstring = inspect.getdoc(function(name)) or ""
        except (AttributeError, ImportError, ValueError):
            found.append(f"there is no {name or 'code'}")
            continue
        cited = {equation for equation in missing if cites(docstring, equation)}
        if not any(cites(docstring, equation) for equation in ledger.equations(row)):
            found.append(f"{name} cites none of {', '.join(ledger.equations(row))}")
        missing -= cited
    if missing and not found:
        found.append(f"{row['code']} does not cite {', '.join(sorted(missing))}")
    return found


def problems(row: dict[str, str]) -> list[str]:
    """What is wrong with a row of the ledger, in words."""
    found = [
        f"{name} is empty"
        for name in COLUMNS
        if not row[name] and name not in MAY_BE_EMPTY
    ]
    for name, values in ALLOWED.items():
        if row[name] not in values:
            found.append(f"{name} is {row[name]!r}")
    if (row["verdict"] == "corrected") != bool(row["cause"]):
        found.append("a cause stands with a correction, and only there")
    file, _, name = row["test"].partition("::")
    read = row["test"] == NO_TEST and row["kind"] != "equation"
    if name not in PROOFS.get(file, ()) and not read:
        found.append(f"the test {row['test']} does not exist")
    return found + problems_of_code(row)


def test_rows_are_complete_and_their_tests_and_code_exist():
    wrong = [
        f"{row['source']} {row['place']}: {problem}"
        for row in ROWS
        for problem in problems(row)
    ]
    assert not wrong, "\n".join(wrong)


def test_every_chapter_has_its_own_file():
    for path in (datasets.folder() / "audit").iterdir():
        chapters = {row["chapter"] for row in datasets.rows(f"audit/{path.name}")}
        assert chapters == {path.stem.lstrip("0")}, path.name


def test_no_claim_stands_twice():
    claims = [(r["source"], r["place"], r["printed"]) for r in ROWS]
    assert len(set(claims)) == len(claims)


def test_every_proof_is_named_in_the_ledger():
    named = {row["test"] for row in ROWS}
    proofs = {
        f"{file}::{name}"
        for file, names in PROOFS.items()
        for name in names
        if re.match("test_.*20", file)
    }
    assert not proofs - named, "proofs without a verdict"


def test_a_stranger_finds_the_code_behind_twelve_equations():
    """Drawn by a seed; one look at the index leads to a function that cites them.

    Rows that are misprints only lead to no code, and say so.
    """
    used = [row for row in EQUATIONS if not row["code"].startswith("-")]
    for row in random.Random(2013).sample(used, 12):
        for equation in ledger.equations(row):
            found = [function(name) for name in ledger.code(equation)]
            assert all(inspect.isroutine(one) for one in found)
            assert any(cites(inspect.getdoc(one), equation) for one in found)
            for one in found:
                package = Path(inspect.getsourcefile(one)).relative_to(ROOT).parts[0]
                assert package in ("pgm_lab", "pgm_book")


@pytest.mark.parametrize(
    ("docstring", "cited"),
    [
        ("(M 2.95)", True),
        ("Muliawan 2013, (M 2.75)\n    to (M 2.95).", True),
        ("(M 2.95), (M 2.96)", True),
        ("(2.95)", False),
        ("(B 2.95)", False),
        ("(M 2.75) to (M 2.94)", False),
        ("(B 2.75) to (B 2.99)", False),
        ("", False),
    ],
)
def test_citation_has_one_style(docstring, cited):
    assert cites(docstring, "M 2.95") == cited
