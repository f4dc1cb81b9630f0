"""Submissions as they are delivered: folders and zips, read as text and never run.

A class is a folder, or a zip as Moodle gives it; in it a student is a folder, a zip or
a file. ``submitted`` of nbgrader and the clones of GitHub Classroom are such folders.
Only notebooks, ``my_pgm.py`` and ``my_results.json`` are read, up to a size; links are
not followed, and nothing is unpacked onto the disk.
"""

import ast
import functools
import hashlib
import io
import json
import re
import stat
import symtable
import zipfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from pgm_book.common.own_program import FILE, names_read
from pgm_book.task import RESULTS

LARGEST = 20 * 2**20  # bytes of a file
MOST = 100  # files of a student that are read
ROOM = 100 * 2**20  # bytes of all of them
MEMBERS = 20_000  # files of a zip, read or not
CODE, CELLS = 2**19, 1000  # characters and cells of code in a file
CHANGING = frozenset(
    "add append clear extend fill insert pop remove sort update".split()
)
NOTHING_READ = "nothing that can be read: a notebook, my_pgm.py or my_results.json"
_MOODLE = re.compile(r"_(\d+)_(assignsubmission|onlinetext).*$")


@dataclass(frozen=True)
class Notebook:
    """The code of a notebook, in its order, and what its outputs say."""

    file: str
    cells: tuple[str, ...]
    ids: tuple[str, ...]
    said: str


@dataclass(frozen=True)
class Submission:
    """What one student handed in."""

    student: str
    notebooks: tuple[Notebook, ...]
    program: str
    tasks: dict[str, str]  # the source of the last try, by the lesson's number
    remarks: tuple[str, ...]
    number: str = ""  # Moodle's, of the participant

    def digest(self) -> bytes:
        """Return a hash of all code."""
        code = [cell for notebook in self.notebooks for cell in notebook.cells]
        whole = json.dumps([self.student, self.program, self.tasks, code])
        return hashlib.sha256(whole.encode("utf-8", "replace")).digest()


def read(place: Path) -> list[Submission]:
    """Read all submissions of a folder, or of a zip that holds a class.

    Raises
    ------
    ValueError
        If there is none.
    """
    files: dict[tuple[str, str], list[tuple[str, bytes]]] = defaultdict(list)
    remarks: dict[tuple[str, str], list[str]] = defaultdict(list)
    for entry, name, content in _delivered(place):
        who = student_of(entry), number_of(entry)
        files[who] += [(name, content)] if isinstance(content, bytes) else []
        remarks[who] += [f"{name}: {content}"] if isinstance(content, str) else []
    having = Counter(student for student, _ in files)
    found = [
        _submission(
            f"{student} {number}" if having[student] > 1 else student,
            sorted(files[student, number]),
            remarks[student, number][:MOST]
            + ([] if files[student, number] else [NOTHING_READ]),
            number,
        )
        for student, number in sorted(files)
    ]
    if not found:
        raise ValueError(
            f"{place}: no submission was found. Give a folder with a folder, a zip or a"
            " notebook for each student, or Moodle's zip."
        )
    return found


# --- Files: (entry of the class, name, content, or why it was not read) ---


class Room:
    """What is left of the files and bytes that a student may hand in."""

    def __init__(self) -> None:
        self.files, self.size = MOST, ROOM

    def has(self, *sizes: int) -> bool:
        """Whether files of these sizes may be read; if so, their room is taken."""
        fits = len(sizes) <= self.files and sum(sizes) <= self.size
        if fits:
            self.files, self.size = self.files - len(sizes), self.size - sum(sizes)
        return fits


def _delivered(place: Path) -> Iterator[tuple[str, str, bytes | str | None]]:
    """Yield the files of all students; without content: a student has a row."""
    if not place.exists():
        raise ValueError(f"{place}: there is no such folder or zip")
    if place.is_file():
        try:
            with zipfile.ZipFile(place) as whole:
                entries = defaultdict(list)
                for info in whole.infolist():
                    entries[info.filename.partition("/")[0]].append(info)
                for entry, infos in entries.items():
                    if entry != "__MACOSX":
                        yield entry, entry, None
                    for name, content in _members(whole, infos, entry, Room()):
                        yield entry, name.removeprefix(f"{entry}/"), content
        except Exception as error:  # whatever its bytes lead to
            raise ValueError(f"{place}: not a zip that can be read: {error}") from None
        return
    for entry in sorted(place.iterdir()):
        if entry.name.startswith("."):
            continue
        if entry.is_dir() or entry.suffix.lower() == ".zip":
            yield entry.name, "", None
        if entry.is_symlink():
            yield entry.name, entry.name, "a link, which is not followed"
        elif entry.is_dir():
            for name, content in _of_folder(entry):
                yield entry.name, name, content
        elif entry.suffix.lower() == ".zip":
            for name, content in _of_zip(entry, entry.name, Room()):
                yield entry.name, name, content
        elif _wanted(entry.name):
            yield entry.name, entry.name, _content(entry, Room())


def student_of(name: str) -> str:
    """Return a student's name from that of a folder, a zip or a file.

    Examples
    --------
    >>> student_of("Ada Lovelace_12345_assignsubmission_file_")
    'Ada Lovelace'
    """
    stem = re.sub(r"\.(zip|ipynb|py)$", "", name, flags=re.IGNORECASE)
    whole = stem.encode("utf-8", "replace").decode()  # a disk may give half characters
    return _MOODLE.sub("", whole).strip() or "nameless"


def number_of(name: str) -> str:
    """Return the number by which Moodle tells two students of one name; else nothing.

    Examples
    --------
    >>> number_of("Ada Lovelace_12345_assignsubmission_file_")
    '12345'
    """
    found = _MOODLE.search(name)
    return found[1] if found else ""


def _wanted(name: str) -> bool:
    """Whether a file is one that is read."""
    path = PurePosixPath(name)
    hidden = any(part.startswith((".", "__MACOSX")) for part in path.parts)
    kind = path.suffix.lower()
    return not hidden and (kind == ".ipynb" or path.name in (FILE, RESULTS))


def _of_folder(folder: Path) -> Iterator[tuple[str, bytes | str]]:
    """Yield the files of a student's folder."""
    room = Room()
    for path in sorted(folder.rglob("*")):  # links to folders are not entered
        name = path.relative_to(folder).as_posix()
        if path.is_symlink():
            yield name, "a link, which is not followed"
        elif path.is_file() and _wanted(name):
            yield name, _content(path, room)
        elif path.is_file() and path.suffix.lower() == ".zip":
            for inside, content in _of_zip(path, name, room):
                yield f"{name}/{inside}", content


def _content(path: Path, room: Room) -> bytes | str:
    """Return what a file holds, or why it was not read."""
    size = path.stat().st_size
    if size > LARGEST:
        return f"larger than {LARGEST // 2**20} MB, not read"
    return path.read_bytes() if room.has(size) else "too much in all, not read"


def _of_zip(
    file: Path | io.BytesIO, name: str, room: Room, inside: bool = True
) -> Iterator[tuple[str, bytes | str]]:
    """Yield the files of a zip, and of the zips in it; nothing is written anywhere."""
    try:
        with zipfile.ZipFile(file) as whole:
            yield from _members(whole, whole.infolist(), name, room, inside)
    except Exception as error:  # whatever a stranger's bytes lead to
        yield name, f"not a zip that can be read: {error}"


def _members(
    whole: zipfile.ZipFile,
    infos: list[zipfile.ZipInfo],
    of: str,
    room: Room,
    inside: bool = True,
) -> Iterator[tuple[str, bytes | str]]:
    """Yield members of a zip, if there are not too many; its directory tells."""
    read = []
    for info in infos[:MEMBERS]:
        name = info.filename
        if stat.S_ISLNK(info.external_attr >> 16):
            yield name, "a link, which is not followed"
        elif name.startswith("/") or ".." in PurePosixPath(name).parts:
            yield name, "its path leads out of the zip, not read"
        elif info.is_dir() or "__MACOSX" in name:
            continue
        elif _wanted(name) or (inside and name.lower().endswith(".zip")):
            if info.file_size > LARGEST:
                yield name, "too large, not read"
            else:
                read.append(info)
    if len(infos) > MEMBERS or not room.has(*(info.file_size for info in read)):
        yield of, f"more than {MOST} files, or {ROOM // 2**20} MB, in it: not read"
        return
    for info in read:
        content = whole.read(info)  # no more than the directory says
        if _wanted(info.filename):
            yield info.filename, content
        else:
            within = _of_zip(io.BytesIO(content), info.filename, room, inside=False)
            for part, of_it in within:
                yield f"{info.filename}/{part}", of_it


# --- What the files say ---


def _submission(
    student: str, files: list[tuple[str, bytes]], remarks: list[str], number: str
) -> Submission:
    """Read the files of a student."""
    notebooks, program, tasks = [], "", {}
    for name, content in files:
        try:
            if name.lower().endswith(".ipynb"):
                notebooks.append(_notebook(name, content))
            elif name.endswith(FILE):
                program = _sized(content.decode("utf-8-sig"))
            else:
                tries = json.loads(content)
                tasks = {str(one["task"]): _sized(str(one["source"])) for one in tries}
        except Exception as error:  # whatever a stranger's file leads to
            remarks = [*remarks, f"{name}: cannot be read, {type(error).__name__}"]
    return Submission(student, tuple(notebooks), program, tasks, tuple(remarks), number)


def _notebook(name: str, content: bytes) -> Notebook:
    """Read the code cells of a notebook, of whatever version 4."""
    cells = [c for c in json.loads(content)["cells"] if c["cell_type"] == "code"]
    sources = [_joined(cell["source"]) for cell in cells]
    if len(cells) > CELLS:
        raise ValueError("more cells than anybody writes")
    _sized("".join(sources))
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    return Notebook(
        name,
        tuple(map(python_of, sources)),
        tuple(str(cell.get("id", "")) for cell in cells),
        "\n".join(_joined(output.get("text", "")) for output in outputs),
    )


def _sized(code: str) -> str:
    """Return code, if it is not so long that looking through it takes minutes."""
    if len(code) > CODE:
        raise ValueError("more code than anybody writes")
    return code


def _joined(text: Any) -> str:
    """Return a text that may come as a list of lines."""
    return "".join(map(str, text)) if isinstance(text, list) else str(text)


def python_of(source: str) -> str:
    """Return a cell without the lines that only a notebook understands."""
    try:
        ast.parse(source)
        return source
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        lines = re.sub(r"^([ \t]*)[%!?].*$", r"\1pass", source, flags=re.MULTILINE)
        return re.sub(r"^([ \t]*\w+)\?+[ \t]*$", r"\1", lines, flags=re.MULTILINE)


# --- The cells that a name needs ---


def needed(cells: tuple[str, ...], names: set[str], handing_in: bool = False) -> list:
    """Return the cells that give names their values, and all that these cells use.

    Of cells that give one name its value those count that are the last before the use,
    and the last before the answer, since a function takes what is there when it is
    called; if there are none, later ones. With `handing_in` also those that hand in
    the result of the task. A cell that cannot be parsed gives nothing.
    """
    about = [names_of(cell) for cell in cells]

    def giving(name: str, places: range) -> set[int]:
        """Return the last place that binds a name for certain, and those after it."""
        found = set()
        for k in reversed(places):
            found |= {k} if name in about[k].bound else set()
            if name in about[k].certain:
                break
        return found

    everywhere = range(len(cells))
    more = {k for k in everywhere if handing_in and ".hand_in(" in cells[k]}
    more = more.union(*(giving(name, everywhere) for name in names))
    end, chosen = max(more, default=0) + 1, set()
    while more:
        chosen |= more
        uses = [(k, name) for k in more for name in about[k].used]
        more = set()
        for k, name in uses:
            found = giving(name, range(k)) | giving(name, range(k + 1, end))
            more |= found or giving(name, range(end, len(cells)))
        more -= chosen
    return [cells[k] for k in sorted(chosen)]


class Names(NamedTuple):
    """What a cell does with names."""

    bound: set[str]  # it may give them a value,
    certain: set[str]  # whatever happens,
    used: set[str]  # and takes these from other cells


@functools.lru_cache(10_000)
def names_of(cell: str) -> Names:
    """Return what a cell does with names; nothing if it cannot be parsed."""
    certain: set[str] = set()
    try:
        used = _used(ast.parse(cell).body, certain)
        return Names(_bound(cell) | _changed(cell), certain, used)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return Names(set(), set(), set())


def _bound(source: str) -> set[str]:
    names = symtable.symtable(source, "cell", "exec").get_symbols()
    return {n.get_name() for n in names if n.is_assigned() or n.is_imported()}


def _changed(source: str) -> set[str]:
    """Names whose value changes in part, as by ``a[0] = 1`` and ``a.append(1)``."""
    changed = [
        ast.unparse(node)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Subscript | ast.Attribute)
        and (isinstance(node.ctx, ast.Store) or getattr(node, "attr", "") in CHANGING)
    ]
    return set().union(*map(names_read, changed))


@functools.cache
def statements(cell: str) -> list[str]:
    """Return the statements of a cell of the book, each as a cell."""
    return [ast.get_source_segment(cell, node) or "" for node in ast.parse(cell).body]


def _used(body: list[ast.stmt], bound: set[str]) -> set[str]:
    """Return names that statements take from others; add to `bound` what they bind."""
    used: set[str] = set()

    def takes(source: str) -> None:
        used.update(names_read(source) - bound)
        bound.update(_bound(source))

    for node in body:
        if isinstance(node, ast.For):
            takes(f"{ast.unparse(node.target)} = {ast.unparse(node.iter)}")
            used |= _used([*node.body, *node.orelse], bound)
        elif isinstance(node, ast.With):
            for one in node.items:
                name = ast.unparse(one.optional_vars) if one.optional_vars else "_"
                takes(f"{name} = {ast.unparse(one.context_expr)}")
            used |= _used(node.body, bound)
        elif isinstance(node, ast.If):  # one of two branches, for certain neither
            used |= names_read(ast.unparse(node.test)) - bound
            used |= _used(node.body, bound.copy()) | _used(node.orelse, bound.copy())
        elif isinstance(node, ast.While | ast.Try | ast.Match):
            used |= names_read(ast.unparse(node)) - bound
        else:
            if isinstance(node, ast.AugAssign):
                used |= names_read(ast.unparse(node.target)) - bound
            takes(ast.unparse(node))
    return used
