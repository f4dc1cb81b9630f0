"""Student and instructor copies of a notebook.

The notebook in ``notebooks/`` contains the worked solutions, between two marker lines

    ### BEGIN SOLUTION
    ### END SOLUTION

inside a code cell, or in a whole cell tagged ``solution``. A student copy has neither.
"""

import copy
import re
from collections.abc import Iterable
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from pgm_lab.io.files import save

PLACEHOLDER = "pass  # your code here"
PROGRAM = "my_pgm.py"  # where there is one, `checks.keep` puts functions into it
FIRST_LINES = '''"""My photogrammetric program: the functions that passed their checks.

A check that passes puts its function here as it was typed; when it passes again, the
new one takes the place of the old. Nothing else changes this file.
"""
'''

# Lenient on purpose: a marker in another spelling must not give a solution away.
_MARKER = re.compile(r"^(\s*)#+\s*(BEGIN|END)\s+SOLUTION\b", re.IGNORECASE)
_OWN = re.compile(r"^\w+: the book's own\..*\n?", re.MULTILINE)  # of checks.own


def tags(cell: NotebookNode) -> list[str]:
    """Return the tags of a cell; none is an empty list."""
    return list(cell.metadata.get("tags", []))


def slide_type(cell: NotebookNode) -> str:
    """Return slide, subslide, fragment, skip, notes or "-" (continues)."""
    return cell.metadata.get("slideshow", {}).get("slide_type", "-")


def student_copy(notebook: NotebookNode) -> NotebookNode:
    """Return the notebook as a student gets it: nothing solved, nothing run.

    Solution blocks become a placeholder, in a cell tagged ``task`` nothing; cells
    tagged ``solution`` or ``claims`` and the lecturer's notes go, and cells tagged
    ``check`` may fail without stopping *Run All*. The input is not changed.

    Raises
    ------
    ValueError
        If a solution marker stands alone or outside a code cell.
    """
    result = blank_solutions(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if slide_type(cell) != "notes" and "claims" not in tags(cell)
    ]
    result.metadata.pop("pgm_lab", None)
    for cell in result.cells:
        if cell.cell_type != "code":
            continue
        cell.outputs = []
        cell.execution_count = None
        cell.metadata.pop("execution", None)
        if "check" in tags(cell) and "raises-exception" not in tags(cell):
            cell.metadata["tags"] = [*tags(cell), "raises-exception"]
    return result


def blank_solutions(notebook: NotebookNode) -> NotebookNode:
    """Return a copy without solutions; outputs and metadata stay as they are."""
    result = copy.deepcopy(notebook)
    result.cells = [cell for cell in result.cells if "solution" not in tags(cell)]
    for cell in result.cells:
        cell.source = _blank(cell)
    return result


def unsolved(notebook: NotebookNode) -> NotebookNode:
    """Return a copy to be read: solutions blank, and no output that gives them away.

    Where nothing runs, no line says whose function runs.
    """
    result = blank_solutions(notebook)
    result.cells = [
        cell
        for cell in result.cells
        if cell.source.strip() and "claims" not in tags(cell)
    ]
    for cell in result.cells:
        if PLACEHOLDER in cell.source or {"check", "task"} & set(tags(cell)):
            cell.outputs = []
        for output in list(cell.get("outputs", [])):
            if output.output_type == "stream":
                output.text = _OWN.sub("", output.text)
                if not output.text:
                    cell.outputs.remove(output)
    return result


def _blank(cell: NotebookNode) -> str:
    """Return the source of one cell with each solution block as a placeholder."""
    kept = []
    inside = False
    for line in cell.source.split("\n"):
        marker = _MARKER.match(line)
        if marker and cell.cell_type != "code":
            raise ValueError(
                f"{name(cell)}: solution markers work in code cells only; "
                "tag this cell `solution` instead."
            )
        if marker:
            begins = marker[2].upper() == "BEGIN"
            if begins == inside:
                raise ValueError(
                    f"{name(cell)}: {line.strip()!r} has no partner; every "
                    "'### BEGIN SOLUTION' needs one '### END SOLUTION' after it."
                )
            if begins and "task" not in tags(cell):  # a task is an empty cell
                kept.append(marker[1] + PLACEHOLDER)
            inside = begins
        elif not inside:
            kept.append(line)
    if inside:
        raise ValueError(
            f"{name(cell)}: a '### BEGIN SOLUTION' is never closed; "
            "add '### END SOLUTION' after the solution."
        )
    return "\n".join(kept)


def name(cell: NotebookNode) -> str:
    """Name a cell by its id and its first line, so that an author finds it."""
    first = cell.source.strip().split("\n", 1)[0]
    return f"cell {cell.get('id', 'without id')} ({first[:50]!r})"


def write_copies(notebooks: Iterable[Path], build: Path) -> list[Path]:
    """Write ``build/student`` and ``build/instructor`` copies; return their paths.

    With the students' copies goes an empty program, into which `checks.keep` puts what
    they write. It is written anew: one that grew there would give solutions away.
    """
    written = []
    for path in notebooks:
        notebook = nbformat.read(path, as_version=4)
        try:
            copies = {"student": student_copy(notebook), "instructor": notebook}
        except ValueError as error:
            raise ValueError(f"{path.name}, {error}") from error
        for folder, made in copies.items():
            target = build / folder / path.name
            save({target: nbformat.writes(made) + "\n"}, overwrite=True)
            written.append(target)
    program = build / "student" / PROGRAM
    save({program: FIRST_LINES}, overwrite=True)
    return [*written, program]
