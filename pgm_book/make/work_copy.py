"""Make the reader's own copies of the notebooks in work/, and never touch them again.

Each notebook is copied once, with the exercises open. When an original changes later,
its new copy is put beside the reader's, under another name, and a line says so. If the
copies are of an older edition, whose modules have moved, the new edition is put into a
folder beside it, work-2/, with the reader's program. No file of the reader is ever
written to.
"""

import ast
import hashlib
import json
import re
import sys
from pathlib import Path

import nbformat

from pgm_book.make.environment import ROOT, work_folder
from pgm_book.make.student import FIRST_LINES, PROGRAM, student_copy
from pgm_lab.io.files import save

RECORD = ".originals.json"
DAMAGED = (
    "{path} is damaged. It remembers which copies you were given; without it changed "
    "chapters are not offered. Delete it to be offered the current ones. Your "
    "notebooks stay as they are."
)
OLDER = (
    "{old}/ contains notebooks of an older edition, whose modules have moved. "
    "They stay as they are. The new edition is in {new}/, your program {program} along "
    "with it."
)

# Where a reader's notebook or program finds today what an older edition had elsewhere.
ROOMS = ("adjustment", "bundle", "camera", "lsm", "orientation", "stereo")
MOVED = {
    "pgm_lab.checks": "pgm_book.common.checks",
    "pgm_lab.chapters": "pgm_book.common.chapters",
    "pgm_lab.ledger": "pgm_book.common.ledger",
    **{f"pgm_lab.{room}.textbook": f"pgm_book.program.{room}" for room in ROOMS},
    **{
        f"pgm_lab.registration.{name}": f"pgm_book.program.registration.{name}"
        for name in ("best_shift", "chip_shifts", "peak_of_parabola", "rmse")
    },
}


def update(source_dir: Path, work_dir: Path) -> list[str]:
    """Bring a reader's folder up to date."""
    work_dir.mkdir(parents=True, exist_ok=True)
    record = read_record(work_dir)
    lines, current = [], {}
    for path in sorted(source_dir.glob("*.ipynb")):
        text = copy_of(path)
        current[path.stem] = hashlib.sha256(text.encode()).hexdigest()
        own = work_dir / path.name
        if not own.exists():
            save({own: text})
            lines.append(f"{own.name}: your copy is in {work_dir.name}/")
        # Without the record nobody can tell what changed: then only fill the gaps.
        elif record is not None and record.get(path.stem) != current[path.stem]:
            lines += put_beside(own, text)
    if record is None:
        return [DAMAGED.format(path=work_dir / RECORD), *lines]
    text = json.dumps(current, indent=1, sort_keys=True) + "\n"
    save({work_dir / RECORD: text}, overwrite=True)
    return lines


def put_beside(own: Path, text: str) -> list[str]:
    """Put the copy of a changed notebook beside the reader's, under a free name."""
    taken, beside = [own], own.with_suffix(".new.ipynb")
    while beside.exists():
        taken.append(beside)
        beside = own.with_suffix(f".new-{len(taken)}.ipynb")
    if any(path.read_bytes() == text.encode() for path in taken):
        return []
    save({beside: text})
    return [
        f"{own.name}: the original has changed. Your copy stays as it is; "
        f"the new one is beside it: {beside.name}"
    ]


def copy_of(path: Path) -> str:
    """Return the text of the student copy of a notebook."""
    notebook = nbformat.read(path, as_version=4)
    try:
        return nbformat.writes(student_copy(notebook)) + "\n"
    except ValueError as error:
        raise ValueError(f"{path.name}, {error}") from error


def read_record(work_dir: Path) -> dict[str, str] | None:
    """Return which copies were handed out last; None if the record is damaged."""
    path = work_dir / RECORD
    if not path.exists():
        return {}
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return None
    return record if isinstance(record, dict) else None


# --- An older edition ---


def moved(name: str) -> str:
    """Return where a module, or a function of one, is today; nothing if it stayed."""
    chapter = re.match(r"pgm_lab\.checks\.chapter(A?)(\d)(c?)", name)
    if chapter:
        module = f"pgm_book.ch{chapter[1] or 0}{chapter[2]}"
        return f"{module}.{'case_' if chapter[3] else ''}checks{name[chapter.end() :]}"
    for old, new in MOVED.items():
        if f"{name}.".startswith(f"{old}."):
            return new + name[len(old) :]
    return ""


def mended(text: str) -> str:
    """Return a program whose imports name the modules where they are today."""
    lines = text.splitlines(keepends=True)
    for node in reversed(ast.parse(text).body):
        if not isinstance(node, ast.Import | ast.ImportFrom):
            continue
        base = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
        if any(moved(base + alias.name) for alias in node.names):
            new = []
            for alias in node.names:
                name = moved(base + alias.name) or base + alias.name
                module, _, last = name.rpartition(".")
                bound = alias.asname or (alias.name if base else "")
                renamed = f" as {bound}" if bound and bound != last else ""
                new.append(f"from {module} import {last}{renamed}\n")
            lines[node.lineno - 1 : node.end_lineno] = new
    return "".join(lines)


def is_older(work_dir: Path) -> bool:
    """Whether a notebook of the reader imports what has moved since."""
    for path in work_dir.glob("*.ipynb"):
        try:
            cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
            code = ["".join(c["source"]) for c in cells if c["cell_type"] == "code"]
            imports = re.findall(r"^(?:import|from) .*", "\n".join(code), re.MULTILINE)
            if any(mended(line) != line for line in imports):
                return True
        except (ValueError, KeyError, TypeError, SyntaxError):
            continue  # not a notebook, or not yet Python: it says nothing
    return False


def begin_program(work_dir: Path, before: Path | None = None) -> None:
    """Give the reader an empty program, or that of the previous edition, updated."""
    if (work_dir / PROGRAM).exists():
        return
    text = FIRST_LINES
    if before and (before / PROGRAM).exists():
        text = (before / PROGRAM).read_text(encoding="utf-8")
        try:
            text = mended(text)
        except SyntaxError:
            pass  # as it is: the reader's checks say where it cannot be read
    save({work_dir / PROGRAM: text})


def main() -> int:
    """Update the reader's folder and say what is new in it."""
    work, lines, before = work_folder(ROOT), [], None
    try:
        if is_older(work) and not is_older(ROOT / "notebooks"):
            before, work = work, ROOT / f"work-{int(work.name[5:] or 1) + 1}"
            words = {"old": before.name, "new": work.name, "program": PROGRAM}
            lines.append(OLDER.format(**words))
        lines += update(ROOT / "notebooks", work)
        begin_program(work, before)
    except (OSError, ValueError) as error:
        print(
            f"Your copies in {work.name}/ could not be made: {error}", file=sys.stderr
        )
        return 1
    print("".join(f"{line}\n" for line in lines), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
