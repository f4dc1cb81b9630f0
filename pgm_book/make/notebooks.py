"""Execute the notebooks, and prove that what is stored in them is whole and current.

`python tasks.py notebooks` runs every notebook from the top, writes the outputs into it
and stores a hash of its code. `problems` reads a notebook and lists all that a reader
should not find: missing or stale outputs, errors, widget state, figures without a
description, and so on.
"""

import hashlib
import json
import re
import sys
import time
from collections.abc import Iterable
from pathlib import Path

import nbformat
from jupyter_client.manager import KernelManager
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError
from nbformat import NotebookNode, v4

from pgm_book.make.errors import PublishError
from pgm_book.make.form import choose
from pgm_lab.io.files import save

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
KERNEL = {
    "display_name": "Python 3 (ipykernel)",
    "language": "python",
    "name": "python3",
}

CELL_LINES = 25
FILE_BYTES = 2_000_000
CELL_SECONDS = 120

# Sliders live in a running notebook only; stored, they are an empty frame.
WIDGET_VIEW = "application/vnd.jupyter.widget-view+json"

# Widgets that take what a cell shows. The page answers them, and nbclient, which acts
# as the page in `nbconvert --execute`, sometimes loses an answer and waits in vain.
TAKES_OUTPUT = re.compile(r"(?<!plot\.)\b(interact\w*|Output)\(")

# A folder of the machine that ran the notebook: /home/ada/..., C:\Users\ada\...
MACHINE_PATH = re.compile(
    r"(?<![\w./])(/(home|Users|root|tmp|var/folders)/[\w.]|[A-Za-z]:\\+Users\\)"
)


class RunFailed(Exception):
    """A notebook did not run to its end."""


def code_sha256(notebook: NotebookNode) -> str:
    """Return the hash of all code, which shows whether the outputs are current."""
    sources = [cell.source for cell in code_cells(notebook)]
    return hashlib.sha256(json.dumps(sources).encode()).hexdigest()


def execute(path: Path) -> None:
    """Run a notebook from the top; store its outputs, or raise RunFailed."""
    notebook = nbformat.read(path, as_version=4)
    try:
        client(notebook, path.parent).execute()
    except (CellExecutionError, CellTimeoutError, DeadKernelError) as error:
        raise RunFailed(f"{path.name} was left as it was.\n{error}") from error
    normalize(notebook)
    save({path: nbformat.writes(notebook) + "\n"}, overwrite=True)


def client(
    notebook: NotebookNode, folder: Path, kernel: KernelManager | None = None
) -> NotebookClient:
    """What runs a notebook in a folder, in a kernel of its own or in a given one."""
    return NotebookClient(
        notebook,
        km=kernel,
        kernel_name=KERNEL["name"],
        timeout=CELL_SECONDS,
        record_timing=False,
        resources={"metadata": {"path": str(folder)}},
    )


def normalize(notebook: NotebookNode) -> None:
    """Drop what differs between machines and runs, and store the hash of the code."""
    metadata = notebook.metadata
    metadata.kernelspec = dict(KERNEL)
    metadata.get("language_info", {}).pop("version", None)
    metadata.pop("widgets", None)
    metadata.pgm_lab = {"code_sha256": code_sha256(notebook)}
    for cell in notebook.cells:
        for volatile in ("execution", "ExecuteTime"):
            cell.metadata.pop(volatile, None)
        if cell.cell_type == "code":
            cell.outputs = joined_streams(
                o for o in cell.outputs if WIDGET_VIEW not in o.get("data", {})
            )


def joined_streams(outputs: Iterable[dict]) -> list[dict]:
    """Join what is printed at once: on a busy machine it may arrive in pieces."""
    whole: list[dict] = []
    for output in outputs:
        last = whole[-1] if whole else {}
        if "name" in output and output["name"] == last.get("name"):
            last["text"] += output["text"]
        else:
            whole.append(output)
    return whole


def problems(path: Path) -> list[str]:
    """All that is wrong with a stored notebook, in plain words."""
    found = []
    if path.stat().st_size > FILE_BYTES:
        found.append(f"the file is larger than {FILE_BYTES // 1_000_000} MB")
    # As it is stored: another reader would add the ids that are missing
    notebook = v4.reads(path.read_text(encoding="utf-8"))
    metadata = notebook.metadata
    if metadata.get("kernelspec", {}).get("name") != KERNEL["name"]:
        found.append(f"the kernelspec is not {KERNEL['name']}")
    if "widgets" in metadata:
        found.append("it stores widget state")
    if metadata.get("pgm_lab", {}).get("code_sha256") != code_sha256(notebook):
        found.append("the code changed since its outputs were made: make notebooks")
    if any("id" not in cell for cell in notebook["cells"]):
        found.append("a cell has no id")
    found += execution_problems(notebook)
    for number, cell in enumerate(notebook["cells"], start=1):
        if cell["cell_type"] == "code":
            findings = source_problems(cell) + output_problems(cell)
            found += [f"cell {number} {finding}" for finding in findings]
    return found


def execution_problems(notebook: NotebookNode) -> list[str]:
    """Whether every code cell was run, in one go from the top."""
    counts = [cell.get("execution_count") for cell in code_cells(notebook)]
    if None in counts:
        return ["not every code cell was executed: make notebooks"]
    if counts != list(range(1, len(counts) + 1)):
        return ["the execution counts do not run from 1 to n: make notebooks"]
    return []


def source_problems(cell: NotebookNode) -> list[str]:
    """What is wrong with the code of a cell."""
    lines = cell.source.splitlines()
    found = []
    if not any(line.strip() for line in lines):
        found.append("is empty")
    if len(lines) > CELL_LINES:
        found.append(f"has more than {CELL_LINES} lines of code")
    taking = TAKES_OUTPUT.search("\n".join(lines))
    if taking:
        found.append(f"uses {taking[1]}, which may wait for ever: plot.interact")
    marks = [m for m in map(str.strip, lines) if m.startswith(("### BEGIN", "### END"))]
    pairs = len(marks) // 2
    if marks != ["### BEGIN SOLUTION", "### END SOLUTION"] * pairs:
        found.append("has solution markers that do not come in pairs")
    return found


def output_problems(cell: NotebookNode) -> list[str]:
    """What is wrong with the outputs of a cell."""
    found = []
    for output in cell.get("outputs", []):
        if output["output_type"] == "error":
            found.append(f"stores an error, {output.get('ename')}")
        if output.get("name") == "stderr":
            found.append("stores a warning or an error message")
        if WIDGET_VIEW in output.get("data", {}):
            found.append("stores a widget, which nobody will see")
        alt = output.get("metadata", {}).get("image/png", {}).get("alt", "")
        if "image/png" in output.get("data", {}) and not alt.strip():
            found.append("has a figure without alt text")
        path = MACHINE_PATH.search(visible_text(output))
        if path:
            found.append(f"shows a folder of the machine, {path.group()}...")
    return found


def visible_text(output: dict) -> str:
    """All the text that an output shows."""
    texts = [output.get("text", ""), output.get("evalue", "")]
    data = output.get("data", {})
    texts += [value for kind, value in data.items() if kind.startswith("text/")]
    return "\n".join(texts)


def code_cells(notebook: NotebookNode) -> list[NotebookNode]:
    """The code cells of a notebook."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def main(names: list[str]) -> int:
    """Execute the named notebooks, or all; the exit code is 0 if all is well."""
    failed = False
    try:
        paths = choose(FOLDER, names)
    except PublishError as error:
        sys.exit(str(error))
    for path in paths:
        start = time.perf_counter()
        try:
            execute(path)
            findings = problems(path)
        except RunFailed as failure:
            findings = [str(failure)]
        print(f"{path.name}  {time.perf_counter() - start:.1f} s", flush=True)
        for finding in findings:
            print(f"  {finding}", file=sys.stderr)
        failed = failed or bool(findings)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
