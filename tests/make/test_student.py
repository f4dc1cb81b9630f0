"""Student copies: nothing given away, and an unsolved chapter still runs."""

import ast
import copy
import re
import subprocess
import sys

import matplotlib.pyplot as plt
import nbformat
import pytest
from jupyter_client.manager import KernelManager
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

from pgm_book.common import checks
from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import (
    FIRST_LINES,
    PROGRAM,
    student_copy,
    tags,
    write_copies,
)
from tests import kernels
from tests.make.test_rerun import reads_and_binds

NOTEBOOKS = sorted(FOLDER.glob("[0-9A-Z]*.ipynb"))

EXERCISE = """\
def double(x):
    ### BEGIN SOLUTION
    secret = 2 * x
    return secret
    ### END SOLUTION


print("done")"""


def notebook(*sources: str) -> nbformat.NotebookNode:
    """Return a small solved notebook; `sources` replace its exercise cell."""
    output = new_output("stream", text="done\n")
    exercises = [
        new_code_cell(source, metadata={"tags": ["exercise"]})
        for source in sources or [EXERCISE]
    ]
    exercises[0].outputs = [output]
    exercises[0].execution_count = 1
    return new_notebook(
        metadata={"pgm_lab": {"code_sha256": "0" * 64}},
        cells=[
            new_markdown_cell("# 1 · Double it"),
            *exercises,
            new_code_cell("assert double(2) == 4", metadata={"tags": ["check"]}),
            new_markdown_cell("Because secret.", metadata={"tags": ["solution"]}),
        ],
    )


NOTE = new_markdown_cell("Key: 1 b.", metadata={"slideshow": {"slide_type": "notes"}})
CLAIMS = new_code_cell("assert double(3) == 6", metadata={"tags": ["claims"]})


def test_a_student_gets_nothing_solved_and_nothing_run():
    solved = notebook()
    solved.cells += [NOTE, CLAIMS]
    before = copy.deepcopy(solved)
    student = student_copy(solved)
    assert solved == before, "the input is not changed"
    source = student.cells[1].source
    assert source == ('def double(x):\n    pass  # your code here\n\n\nprint("done")')
    text = nbformat.writes(student)
    for word in ("secret", "SOLUTION", "code_sha256", "Key: 1 b.", "double(3)"):
        assert word not in text
    code = [cell for cell in student.cells if cell.cell_type == "code"]
    assert all(not c.outputs and c.execution_count is None for c in code)
    assert tags(student.cells[2]) == ["check", "raises-exception"]


def test_two_blocks_and_other_spellings():
    cell = "a = 1\n# begin solution\nb = 2\n###END SOLUTION\n" * 2
    source = student_copy(notebook(cell)).cells[1].source
    assert source.splitlines() == ["a = 1", "pass  # your code here"] * 2


@pytest.mark.parametrize(
    "source",
    [
        "### BEGIN SOLUTION\nx = 1",
        "x = 1\n### END SOLUTION",
        "### BEGIN SOLUTION\n### BEGIN SOLUTION\n### END SOLUTION",
    ],
)
def test_a_marker_without_partner_or_in_a_text_names_the_cell(source):
    broken = notebook(source)
    with pytest.raises(ValueError, match=broken.cells[1].id):
        student_copy(broken)
    broken.cells[1] = new_markdown_cell("### BEGIN SOLUTION\n42\n### END SOLUTION")
    with pytest.raises(ValueError, match=f"{broken.cells[1].id}.*code cells only"):
        student_copy(broken)


def test_the_copies_are_written_and_the_original_stays(tmp_path):
    """What a lecturer tried in the program beside the copies is not handed out."""
    path = tmp_path / "01_double.ipynb"
    nbformat.write(notebook(), path)
    before = path.read_bytes()
    written = write_copies([path], tmp_path / "build")
    assert [p.relative_to(tmp_path).as_posix() for p in written] == [
        "build/student/01_double.ipynb",
        "build/instructor/01_double.ipynb",
        "build/student/my_pgm.py",
    ]
    assert path.read_bytes() == before
    solved = nbformat.read(written[1], as_version=4)
    assert solved == nbformat.read(path, as_version=4)
    written[2].write_text("def double(x):\n    return 2 * x\n", encoding="utf-8")
    write_copies([path], tmp_path / "build")
    assert written[2].read_text(encoding="utf-8") == FIRST_LINES


# Figures are put together but not painted: nobody looks at those of a copy, and nbval
# paints the same ones.
UNSEEN = """\
from pgm_lab import plot

def show(fig, alt, **_):
    from matplotlib.pyplot import close

    assert alt.strip()
    fig.draw_without_rendering()
    close(fig)

plot.show = show
"""


@pytest.fixture(scope="module")
def kernel():
    """One kernel for all copies: it imports the large libraries once.

    That every notebook runs in a kernel of its own is proven with its solutions.
    """
    with kernels.started(FOLDER) as manager:
        first = new_notebook(cells=[new_code_cell(UNSEEN)])
        kernels.run(first, FOLDER, manager)
        yield manager


def run(unsolved: nbformat.NotebookNode, kernel: KernelManager) -> None:
    """Run every cell; a cell may fail only if it is tagged `raises-exception`."""
    forget = (
        f"%reset -f\n%cd -q {FOLDER}\n"
        "import matplotlib\nmatplotlib.rcdefaults()\ndel matplotlib"
    )
    first = new_notebook(cells=[new_code_cell(forget)])
    kernels.run(first, FOLDER, kernel)
    kernels.run(unsolved, FOLDER, kernel)


@pytest.mark.slow
def test_an_unsolved_copy_runs_past_its_checks(kernel):
    unsolved = student_copy(notebook())
    run(unsolved, kernel)
    assert unsolved.cells[2].outputs[0].output_type == "error"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_each_check_of_an_unsolved_chapter_says_what_is_missing(path, monkeypatch):
    """With the cells alone that bind what exercises and checks need."""
    monkeypatch.chdir(FOLDER)
    space = {"__name__": "__main__"}
    with plt.rc_context():
        for cell in needed(student_copy(nbformat.read(path, as_version=4))):
            code = compile(cell.source, f"<{path.stem}, cell {cell.id}>", "exec")
            if "check" not in tags(cell):
                exec(code, space)
                continue
            with pytest.raises(checks.CheckFailed) as failed:
                exec(code, space)
            assert "TypeError" not in str(failed.value), "it must say so in words"
    plt.close("all")


def needed(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    """Exercises, checks, and the cells that bind what they and each other read."""
    chosen, names = [], set()
    for cell in reversed([c for c in notebook.cells if c.cell_type == "code"]):
        reads, binds = reads_and_binds(ast.parse(cell.source))
        if {"exercise", "check"} & {*tags(cell)} or binds & names:
            chosen.append(cell)
            names = names - binds | reads
    return chosen[::-1]


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_an_unsolved_chapter_runs_to_its_end(path, kernel):
    unsolved = student_copy(nbformat.read(path, as_version=4))
    assert "SOLUTION" not in nbformat.writes(unsolved)
    # A task's temporary folder goes with the task; this kernel will be killed
    unsolved.cells.append(new_code_cell("%reset -f\nimport gc\n\ngc.collect();"))
    run(unsolved, kernel)
    for cell in unsolved.cells:
        for output in cell.get("outputs", []):
            if output.output_type == "error":
                assert "check" in tags(cell)
                assert output.ename == "CheckFailed", "a check must say what is missing"
                assert "TypeError" not in output.evalue, "it must say so in words"


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [p for p in NOTEBOOKS if "checks.keep(" in p.read_text(encoding="utf-8")],
    ids=lambda path: path.stem,
)
def test_a_solved_lesson_makes_a_program_that_runs_by_itself(path, kernel, tmp_path):
    """In a reader's folder; what comes after uses the program, and the claims hold."""
    (tmp_path / PROGRAM).write_text(FIRST_LINES, encoding="utf-8")
    solved = nbformat.read(path, as_version=4)
    code = "\n".join(c.source for c in solved.cells if c.cell_type == "code")
    solved.cells.insert(0, new_code_cell(f"%cd -q {tmp_path}"))
    run(solved, kernel)
    outputs = [o for cell in solved.cells for o in cell.get("outputs", [])]
    printed = "".join(o.text for o in outputs if o.output_type == "stream")
    kept = re.findall(r"checks\.keep\((\w+)\)", code)
    for name in kept:
        assert f"✓ {name} is a part of your program now" in printed
    used = set(re.findall(r"checks\.own\(\"(\w+)\"", code)) & set(kept)
    assert used, "no later cell takes a function of the reader's"
    for name in used:
        assert f"{name}: yours, from {PROGRAM}." in printed
    program = (tmp_path / PROGRAM).read_text(encoding="utf-8")
    for name in kept:
        assert program.count(f"def {name}(") == 1
    alone = f"from my_pgm import {', '.join(kept)}"
    subprocess.run([sys.executable, "-c", alone], cwd=tmp_path, check=True)
