"""The ledger itself: every row is complete, and the test it names exists."""

import ast
from pathlib import Path

import pytest

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
    "test",
]
ALLOWED = {
    "source": {"Bani 2010", "Muliawan 2013", "Harintaka 2020", "Brahmantara 2015"},
    "kind": {"number", "equation", "program", "statement"},
    "verdict": {"reproduced", "corrected", "not derivable"},
    "cause": {"", "author", "scan", "unclear"},
}


def proofs_in(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def problems(row: dict[str, str]) -> list[str]:
    """What is wrong with a row of the ledger, in words."""
    found = [
        f"{name} is empty" for name in COLUMNS if not row[name] and name != "cause"
    ]
    for name, values in ALLOWED.items():
        if row[name] not in values:
            found.append(f"{name} is {row[name]!r}")
    if (row["verdict"] == "corrected") != bool(row["cause"]):
        found.append("a cause stands with a correction, and only there")
    file, _, name = row["test"].partition("::")
    path = ROOT / "tests" / "audit" / file
    if not path.is_file() or name not in proofs_in(path):
        found.append(f"the test {row['test']} does not exist")
    return found


def test_ledger_has_the_agreed_columns():
    assert all(list(row) == COLUMNS for row in datasets.rows("audit.csv"))


@pytest.mark.parametrize(
    "row", datasets.rows("audit.csv"), ids=lambda r: f"{r['source']} {r['place']}"
)
def test_row_is_complete_and_its_test_exists(row):
    assert problems(row) == []


def test_no_claim_stands_twice():
    claims = [
        (r["source"], r["place"], r["printed"]) for r in datasets.rows("audit.csv")
    ]
    assert len(set(claims)) == len(claims)


def test_every_proof_is_named_in_the_ledger():
    named = {row["test"] for row in datasets.rows("audit.csv")}
    for path in (ROOT / "tests" / "audit").glob("test_*20*.py"):
        for name in proofs_in(path):
            assert f"{path.name}::{name}" in named, "a proof without a verdict"


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"test": "test_bani2010.py::test_nothing"}, "does not exist"),
        ({"test": "no_file.py::test_nothing"}, "does not exist"),
        ({"test": ""}, "test is empty"),
        ({"verdict": "wrong"}, "verdict is 'wrong'"),
        ({"verdict": "corrected", "cause": ""}, "a cause stands"),
        ({"printed": ""}, "printed is empty"),
    ],
)
def test_a_bad_row_is_noticed(change, complaint):
    row = datasets.rows("audit.csv")[0] | change
    assert any(complaint in problem for problem in problems(row))
