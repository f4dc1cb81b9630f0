"""Files of users: checked before reading, written atomically, named safely in messages.

A file is written beside its target under a temporary name, and renamed when it is
complete: whatever fails or interrupts, the target holds its old content or the new one.
"""

import contextlib
import os
import re
import secrets
import shutil
import stat
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

Name = TypeVar("Name", bound=str | os.PathLike)

LONGEST = 200  # characters of a name in a message

_URL = re.compile(r"[a-z][a-z0-9+.-]+:/", re.IGNORECASE)  # not C:/, the drive


def printable(name: object) -> str:
    """Return a name with everything escaped that a terminal would obey.

    Of a very long path only the beginning and the end are left.
    """
    text = str(name)
    if isinstance(name, os.PathLike) and len(text) > LONGEST:
        text = f"{text[: LONGEST // 2]}...{text[-LONGEST // 2 :]}"
    return "".join(
        one if one.isprintable() else one.encode("unicode_escape").decode("ascii")
        for one in text
    )


# --- Reading ---


def existing(path: str | os.PathLike, name: str, *, empty: bool = False) -> Path:
    """Return the path of a regular file that exists, called `name` in messages."""
    file = local(path, name)
    try:
        state = os.stat(file)
    except FileNotFoundError:
        raise FileNotFoundError(f"{name}: there is no such file") from None
    except (OSError, ValueError) as error:  # no permission, a name with a null in it
        raise _unreadable(error, name) from None
    if stat.S_ISDIR(state.st_mode):
        raise IsADirectoryError(f"{name}: this is a folder, not a file")
    if not stat.S_ISREG(state.st_mode):
        raise OSError(
            f"{name}: this is a pipe or a device; save its content as a file first"
        )
    if not state.st_size and not empty:
        raise ValueError(f"{name}: the file is empty; copy it again")
    return file


def content(
    path: str | os.PathLike, name: str, size: int = -1, *, empty: bool = False
) -> bytes:
    """Return the first `size` bytes of a regular file, or all."""
    there = existing(path, name, empty=empty)
    try:
        with there.open("rb") as file:
            return file.read(size)
    except OSError as error:
        raise _unreadable(error, name) from None


def _unreadable(error: OSError | ValueError, name: str) -> OSError:
    reason = getattr(error, "strerror", None) or error
    return OSError(f"{name}: it cannot be read ({reason})")


# --- Writing ---


def save(contents: Mapping[Name, str | bytes], *, overwrite: bool = False) -> None:
    """Write a set of files: texts, or bytes as they are; all of them, or none.

    A FileExistsError if one exists already and `overwrite` is False, an OSError if one
    cannot be written, or is not a regular file.
    """
    with _temporaries(list(contents), overwrite) as parts:
        for part, (path, text) in zip(parts, contents.items()):
            with _named(path):
                if isinstance(text, bytes):
                    with part.open("xb") as binary:
                        binary.write(text)
                else:
                    with part.open("x", encoding="utf-8", newline="\n") as file:
                        file.write(text)


@contextlib.contextmanager
def atomic(path: str | os.PathLike, *, overwrite: bool = False) -> Iterator[Path]:
    """Give a temporary name to write to; the file replaces `path` when all went well.

    Raises as `save` does.
    """
    with _temporaries([path], overwrite) as (part,), _named(path):
        yield part


def place(path: str | os.PathLike) -> Path:
    """Return where a file is to be written: a link is followed, its folder is made."""
    file = local(path, "path")
    name = printable(file)
    if "\0" in str(file):
        raise ValueError(f"{name:.60} holds a null character: path must be a file name")
    with _named(file):
        if file.is_symlink():
            file = Path(os.path.realpath(file))
        if file.is_dir():
            raise IsADirectoryError(f"{name}: this is a folder; name a file")
        if file.exists() and not file.is_file():
            raise OSError(f"{name}: this is a pipe or a device; name a file")
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise NotADirectoryError(
                f"{name}: {printable(file.parent)} is not a folder"
            ) from None
    return file


@contextlib.contextmanager
def _named(path: str | os.PathLike) -> Iterator[None]:
    """Name the file in what the system says: a disk that is full, too long a name."""
    try:
        yield
    except (OSError, UnicodeError) as error:
        reason: Any = getattr(error, "strerror", error)
        if reason is None:  # the message is ours, or that of a library
            raise
        name = printable(Path(path))
        said = OSError if isinstance(error, UnicodeError) else type(error)
        named = said(f"{name}: it cannot be written ({reason})")
        named.strerror = reason
        raise named from None


@contextlib.contextmanager
def _temporaries(
    paths: Sequence[str | os.PathLike], overwrite: bool
) -> Iterator[list[Path]]:
    """Give a temporary name beside each target, and replace the targets at the end."""
    from pgm_lab import _validate  # `pgm_lab --help` does not wait for NumPy

    overwrite = _validate.flag(overwrite, "overwrite")
    targets = [place(path) for path in paths]
    _check(targets, overwrite)
    parts = [_beside(target, "part") for target in targets]
    try:
        yield parts
        _check(targets, overwrite)  # another program may have been faster
        for target, part in zip(targets, parts):
            if target.exists():
                shutil.copymode(target, part)
        _replace(dict(zip(targets, parts)))
    finally:
        for part in parts:
            part.unlink(missing_ok=True)


def _check(targets: Sequence[Path], overwrite: bool) -> None:
    """Refuse targets that exist already, or are write-protected."""
    for target in filter(os.path.lexists, targets):
        name = printable(target)
        if not overwrite:
            raise FileExistsError(
                f"{name} already exists, and is not overwritten; overwrite=True would"
                " replace it"
            )
        if not os.stat(target).st_mode & stat.S_IWUSR:
            raise PermissionError(f"{name} is write-protected: choose another name")


def _replace(parts: Mapping[Path, Path]) -> None:
    """Rename each temporary file to its target; after a failure the old ones return."""
    backups = {target: _beside(target, "old") for target in parts if target.exists()}
    try:
        if len(parts) > 1:  # a single rename succeeds or fails as a whole
            for target, backup in backups.items():
                shutil.copy2(target, backup)
        for target, part in parts.items():
            with _named(target):
                part.replace(target)
    except BaseException:
        for target, part in parts.items():
            if len(parts) > 1 and not part.exists():  # it was renamed already
                if target in backups:
                    os.replace(backups[target], target)
                else:
                    target.unlink()
        raise
    finally:
        for backup in backups.values():
            backup.unlink(missing_ok=True)


def _beside(target: Path, kind: str) -> Path:
    """Return a new name in the folder of a file, short however long its own is."""
    return target.with_name(f".pgm_lab-{secrets.token_hex(6)}.{kind}")


def local(path: str | os.PathLike, name: str, kind: str = "file") -> Path:
    """Return the path of a file, or a folder, on this computer, with ~ expanded."""
    if not isinstance(path, str | os.PathLike) or not str(path).strip():
        raise ValueError(f"{name} must be the name of a {kind}; got {path!r:.60}")
    if _URL.match(str(path)):
        raise ValueError(
            f"{name} must be the name of a {kind} on this computer; got the address"
            f" {printable(path):.60}"
        )
    return Path(os.path.expanduser(path))
