"""Make the reader's own copies of the notebooks in work/, and never touch them again.

Each notebook is copied once, with the exercises open. When an original changes later,
its new copy is put beside the reader's, under another name, and a line says so. A file
that exists is never written to, unless it is a copy that broke off: the beginning of
ours, and nothing of the reader's.
"""

import hashlib
import json
import os
import sys
from pathlib import Path

import nbformat

from pgm_book.make.student import FIRST_LINES, PROGRAM, student_copy

ROOT = Path(__file__).resolve().parents[2]
RECORD = ".originals.json"
DAMAGED = (
    "{path} is damaged. It remembers which copies you were given; without it changed "
    "chapters are not offered. Delete it to be offered the current ones. Your "
    "notebooks stay as they are."
)


def update(source_dir: Path, work_dir: Path) -> list[str]:
    """Bring a reader's folder up to date.

    Parameters
    ----------
    source_dir : Path
        Folder with the notebooks.
    work_dir : Path
        The reader's folder; it is made if it is missing.

    Returns
    -------
    list of str
        What was done, one line for each new file.
    """
    work_dir.mkdir(parents=True, exist_ok=True)
    record = read_record(work_dir)
    lines, current = [], {}
    for path in sorted(source_dir.glob("*.ipynb")):
        text = copy_of(path)
        current[path.stem] = digest(text)
        own = own_copy(work_dir, path.stem)
        if not own.exists() or broke_off(own, text):
            lines.append(give(path.stem, text, work_dir))
        # Without the record nobody can tell what changed: then only fill the gaps.
        elif record is not None and record.get(path.stem) != current[path.stem]:
            lines += put_beside(path.stem, text, work_dir)
    if record is None:
        return [DAMAGED.format(path=work_dir / RECORD), *lines]
    write_record(work_dir, current)
    return lines


def begin_program(work_dir: Path) -> None:
    """Give the reader an empty program, unless there is one."""
    if not (work_dir / PROGRAM).exists():
        write(work_dir / PROGRAM, FIRST_LINES)


def give(name: str, text: str, work_dir: Path) -> str:
    """Give the reader the first copy of a notebook."""
    own = own_copy(work_dir, name)
    write(own, text)
    return f"{own.name}: your copy is in {work_dir.name}/"


def put_beside(name: str, text: str, work_dir: Path) -> list[str]:
    """Put the copy of a changed notebook beside the reader's, under a free name."""
    own = own_copy(work_dir, name)
    taken = [own]
    beside = work_dir / f"{name}.new.ipynb"
    while beside.exists() and not broke_off(beside, text):
        taken.append(beside)
        beside = work_dir / f"{name}.new-{len(taken)}.ipynb"
    if any(holds(path, text) for path in taken):
        return []
    write(beside, text)
    return [
        f"{own.name}: the original has changed. Your copy stays as it is; "
        f"the new one is beside it: {beside.name}"
    ]


def own_copy(work_dir: Path, name: str) -> Path:
    """Where the reader's own copy of a notebook is."""
    return work_dir / f"{name}.ipynb"


def copy_of(path: Path) -> str:
    """The text of the student copy of a notebook."""
    notebook = nbformat.read(path, as_version=4)
    try:
        return nbformat.writes(student_copy(notebook)) + "\n"
    except ValueError as error:
        raise ValueError(f"{path.name}, {error}") from error


def write(path: Path, text: str) -> None:
    """Put a file in its place in one step: on a full disk there is none, not a half."""
    part = path.with_name(f".{path.name}.part")
    try:
        with open(part, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def broke_off(path: Path, text: str) -> bool:
    """Whether a file is the beginning of this text, as a full disk left it."""
    if not path.is_file():
        return False
    stored, whole = path.read_bytes(), text.encode()
    return len(stored) < len(whole) and whole.startswith(stored)


def holds(path: Path, text: str) -> bool:
    """Whether a file has exactly this text."""
    return path.is_file() and path.read_bytes() == text.encode()


def digest(text: str) -> str:
    """The hash under which the record remembers a copy."""
    return hashlib.sha256(text.encode()).hexdigest()


def read_record(work_dir: Path) -> dict[str, str] | None:
    """Which copies were handed out last; None if the record is damaged."""
    path = work_dir / RECORD
    if not path.exists():
        return {}
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return None
    return record if isinstance(record, dict) else None


def write_record(work_dir: Path, record: dict[str, str]) -> None:
    """Remember which copies were handed out last."""
    text = json.dumps(record, indent=1, sort_keys=True)
    write(work_dir / RECORD, text + "\n")


def main() -> int:
    """Update work/ and say what is new in it."""
    try:
        lines = update(ROOT / "notebooks", ROOT / "work")
        begin_program(ROOT / "work")
    except (OSError, ValueError) as error:
        print(f"Your copies in work/ could not be made: {error}", file=sys.stderr)
        return 1
    for line in lines:
        print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
