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
def test_a_transpose_is_a_superscript_t_and_tables_say_where_columns_begin(notebook):
    for text in sources(notebook, "markdown", "code"):
        assert not PRIME.search(text), PRIME.search(text)
    # JupyterLab sets a column that says nothing to the right
    for text in sources(notebook, "markdown"):
        for line in re.findall(r"^(?:> )?\|(?: *:?-+:? *\|)+ *$", text, re.MULTILINE):
            assert "|-" not in line.replace(" ", "") or "-:" in line, line


def test_the_ledger_writes_transposes_as_the_chapters_do():
    for table in (ROOT / "data" / "audit").glob("*.csv"):
        found = PRIME.search(table.read_text(encoding="utf-8"))
        assert not found, (table.name, found)


def test_a_prime_of_a_matrix_is_noticed_and_no_other():
    matrices = [
        "the least v'Pv",
        "A'PA",
        "A2'PA3",
        "$MM' = I$",
        "|MM′ − I|",
        "$R = M'$",
    ]
    assert all(map(PRIME.search, matrices))
    others = ["X' = a0", "photo's A", "x'", "'A'", "M 2.8's"]
    assert not any(map(PRIME.search, others))
