"""Files written whole or not at all, and their names as one may show them."""

import contextlib
import itertools
import os
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

_LEFT = re.compile(r"\.pgm_lab-(\d+)-\d+\.part")
_HOUR = 3600.0  # seconds; nothing is written for so long
_counter = itertools.count()


def save(files: Mapping[Path, str | bytes], *, overwrite: bool = False) -> None:
    """Write texts, or bytes as they are: all, or none and the old files stay.

    Each is written beside its place first. Then the old ones are put aside, which needs
    no room on the disk, and the new ones renamed; whatever fails or interrupts is
    undone.

    Raises
    ------
    FileExistsError
        If a file is there already, and may not be replaced.
    OSError
        If one cannot be written.
    """
    if not overwrite:
        refuse_existing(*files)
    parts = {path: _beside(path, "part") for path in files}
    try:
        for path, part in parts.items():
            content = files[path]
            if isinstance(content, bytes):
                with part.open("xb") as file:
                    file.write(content)
            else:
                with part.open("x", encoding="utf-8", newline="\n") as text:
                    text.write(content)
        if not overwrite:
            refuse_existing(*files)  # somebody may have been faster
        if len(parts) == 1:
            part.replace(path)
        else:
            _replace_all(parts)
    finally:
        for part in parts.values():
            part.unlink(missing_ok=True)


@contextlib.contextmanager
def written_whole(path: Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Give the name of a file to write, which takes its place when all went well.

    Raises
    ------
    FileExistsError
        If the file is there already, and may not be replaced.
    """
    if not overwrite:
        refuse_existing(path)
    part = _beside(path, "part")
    try:
        yield part
        if not overwrite:
            refuse_existing(path)  # somebody may have been faster
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def place(path: str | os.PathLike) -> Path:
    """Return the path of a file to be written, in a folder that is made if missing."""
    if not isinstance(path, str | os.PathLike) or not str(path).strip():
        raise ValueError(f"path must be the name of a file; got {path!r:.60}")
    file = Path(path)
    if file.is_dir():
        raise IsADirectoryError(f"{printable(file)}: this is a folder; name a file")
    file.parent.mkdir(parents=True, exist_ok=True)
    return file


def _replace_all(parts: Mapping[Path, Path]) -> None:
    """Rename each part to its path, or leave all paths as they are."""
    aside = {path: _beside(path, "old") for path in parts if os.path.lexists(path)}
    try:
        for path, part in parts.items():
            if path in aside:
                path.replace(aside[path])
            part.replace(path)
    except BaseException:
        for path, part in parts.items():
            if path in aside and os.path.lexists(aside[path]):
                aside[path].replace(path)
            elif path not in aside and not part.exists():
                path.unlink()
        raise
    for old in aside.values():
        old.unlink()


def _beside(path: Path, kind: str) -> Path:
    """Return a new name in the folder of a file, short however long its own is."""
    return path.with_name(f".pgm_lab-{os.getpid()}-{next(_counter)}.{kind}")


def refuse_existing(*paths: Path) -> None:
    """Raise FileExistsError if one of the files is there."""
    for path in paths:
        if os.path.lexists(path):
            raise FileExistsError(
                f"{printable(path)} is there already, and is not overwritten"
            )


def clear(folders: Sequence[Path]) -> list[Path]:
    """Remove what killed runs left half written in some folders, and return it."""
    left = []
    for folder in dict.fromkeys(folders):
        with contextlib.suppress(OSError):  # not ours to remove
            for path in sorted(folder.iterdir()):
                found = _LEFT.fullmatch(path.name)
                if found and not _running(int(found[1]), path):
                    path.unlink()
                    left.append(path)
    return left


def _running(process: int, path: Path) -> bool:
    """Whether the process that writes a file may still do so."""
    if process == os.getpid():
        return True
    if time.time() - path.stat().st_mtime > _HOUR:
        return False
    if os.name == "nt":  # there signal 0 would interrupt it
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # of another user
        return True
    return True


def printable(name: object) -> str:
    """Return a name without what a terminal would take for a command."""
    return "".join(
        one if one.isprintable() else one.encode("unicode_escape").decode("ascii")
        for one in str(name)
    )
