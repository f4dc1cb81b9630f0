"""The proofs: each file under ``tests/audit`` as a page, each test with its anchor.

The pages are searchable by the name of a test, because it is a heading, and the table
of verdicts links to it.
"""

import ast
import textwrap
from dataclasses import dataclass
from pathlib import Path

from docutils import nodes

ROOT = Path(__file__).resolve().parents[3]
AUDIT = ROOT / "tests" / "audit"
FOLDER = "proofs"

INDEX = """\
# The proofs

Each verdict has a test that proves it: it computes what a source prints from what the
source gives, and compares. These are the tests, a page for each file, in the order of
the sources. `python tasks.py test` runs all of them.

```{{toctree}}
:maxdepth: 1

{pages}
```
"""


@dataclass(frozen=True)
class Block:
    """Some lines of a file: a test if it has a name."""

    name: str
    lines: list[str]


def place(test: str) -> tuple[str, str]:
    """Page and anchor of a test.

    Examples
    --------
    >>> place("test_bani2010.py::test_2_5a_undoes_2_3a")
    ('proofs/test_bani2010', 'test-2-5a-undoes-2-3a')
    """
    file, _, name = test.partition("::")
    return f"{FOLDER}/{file.removesuffix('.py')}", nodes.make_id(name)


def write(folder: Path) -> list[str]:
    """Write a page for each file of proofs, and a page that lists them."""
    target = folder / FOLDER
    target.mkdir(parents=True, exist_ok=True)
    files = sorted(AUDIT.glob("*.py"))
    names = []
    for file in files:
        text = file.read_text(encoding="utf-8")
        if text.strip():
            (target / f"{file.stem}.rst").write_text(page(file.name, text), "utf-8")
            names.append(file.stem)
    (target / "index.md").write_text(INDEX.format(pages="\n".join(names)), "utf-8")
    return [f"{FOLDER}/index"]


def page(file: str, text: str) -> str:
    """A page of reStructuredText: the code of a file, a heading above each test."""
    parts = [heading(file, "="), f"From ``tests/audit/{file}``."]
    for block in blocks(text):
        if block.name:
            parts.append(".. rst-class:: proof")
            parts.append(heading(block.name, "-"))  # which makes the anchor
        code = textwrap.indent("\n".join(block.lines).strip("\n"), "   ")
        if code:
            parts.append(f".. code-block:: python\n\n{code}")
    return "\n\n".join(parts) + "\n"


def blocks(text: str) -> list[Block]:
    """Cut a file into its tests and the lines between them; nothing is lost."""
    lines = text.splitlines()
    found, end = [], 0
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            first = min([node.lineno, *(d.lineno for d in node.decorator_list)]) - 1
            while first > end and lines[first - 1].startswith("#"):
                first -= 1  # a comment right above belongs to the test
            found.append(Block("", lines[end:first]))
            found.append(Block(node.name, lines[first : node.end_lineno]))
            end = node.end_lineno or end
    return [*found, Block("", lines[end:])]


def heading(text: str, line: str) -> str:
    """Write a heading of reStructuredText."""
    return f"{text}\n{line * len(text)}"
