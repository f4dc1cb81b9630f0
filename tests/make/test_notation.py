"""One notation in all chapters, and tables that read the same in every viewer."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").rglob("*.ipynb"))
# A prime after a matrix or a vector that is multiplied: A'PA, v'Pv, MM'
PRIME = re.compile(r"(?<![A-Za-z])(A\d?|V|M|N|v|MM|RR)['′](?=[APVMNvw]|\$| [=−-])")


def sources(notebook, *kinds):
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return ["".join(c["source"]) for c in cells if c["cell_type"] in kinds]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_transpose_is_a_superscript_t(notebook):
    for text in sources(notebook, "markdown", "code"):
        assert not PRIME.search(text), PRIME.search(text)


@pytest.mark.parametrize(
    "table", sorted((ROOT / "data" / "audit").glob("*.csv")), ids=lambda path: path.stem
)
def test_the_ledger_writes_transposes_as_the_chapters_do(table):
    text = table.read_text(encoding="utf-8")
    assert not PRIME.search(text), PRIME.search(text)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_columns_of_text_say_that_they_begin_at_the_left(notebook):
    # JupyterLab sets a column that says nothing to the right
    for text in sources(notebook, "markdown"):
        for line in re.findall(r"^(?:> )?\|(?: *:?-+:? *\|)+ *$", text, re.MULTILINE):
            assert "|-" not in line.replace(" ", "") or "-:" in line, line


@pytest.mark.parametrize(
    "text", ["the least v'Pv", "A'PA", "A2'PA3", "$MM' = I$", "|MM′ − I|", "$R = M'$"]
)
def test_a_prime_is_noticed(text):
    assert PRIME.search(text)


@pytest.mark.parametrize("text", ["X' = a0", "photo's A", "x'", "'A'", "M 2.8's"])
def test_other_primes_are_not(text):
    assert not PRIME.search(text)
