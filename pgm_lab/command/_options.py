"""Options that subcommands share, the kinds of their values, and what is refused."""

import argparse
import contextlib
import math
import os
import stat
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from pgm_lab.io.files import printable

REPORTS = (".html", ".htm", ".txt")
TABLES = (".csv", ".txt")


class Parser(argparse.ArgumentParser):
    """A parser whose messages hold nothing that a terminal would obey."""

    def error(self, message: str) -> NoReturn:
        """Print the usage and the message, and end with 2."""
        super().error(printable(message))


class Outcome(NamedTuple):
    """What a subcommand made: the report to print, and the files to write."""

    short: str
    files: Mapping[Path, str | bytes]


def outcome(
    options: argparse.Namespace,
    text: Callable[..., str],
    html: Callable[[], str],
    more: Mapping[Path, str | bytes] | None = None,
) -> Outcome:
    """Make the short report, the long ones that were asked for, and more files."""
    reports = {
        path: text() if path.suffix.lower() == ".txt" else html()
        for path in options.report
    }
    return Outcome(text(short=True), reports | dict(more or {}))


@contextlib.contextmanager
def progress(*steps: str) -> Iterator[Callable[[], None]]:
    """Show a bar where somebody watches; call what it yields to begin each step."""
    from tqdm import tqdm

    names = iter(steps)
    watched = sys.stderr.isatty()
    with tqdm(total=len(steps), disable=not watched, leave=False, unit="step") as bar:

        def begin() -> None:
            name = next(names)
            bar.update(steps.index(name) - bar.n)
            bar.set_description(name)

        yield begin


# --- Options ---


def add(
    parser: Any, option: str, words: str, kind: Any = Path, name: str = "FILE"
) -> None:
    """Add an option that takes a value, a file unless its kind is said."""
    parser.add_argument(option, type=kind, metavar=name, help=words)


def add_outputs(parser: Parser) -> None:
    """Add the options --report and --force."""
    words = "write the whole report, as .html or .txt; may be given several times"
    several: dict = {"action": "append", "default": [], "metavar": "FILE"}
    parser.add_argument("--report", type=Path, help=words, **several)
    words = "replace files that exist already"
    parser.add_argument("--force", action="store_true", help=words)


def add_csv(parser: Parser) -> None:
    """Add the option --csv."""
    add(parser, "--csv", "write all points, whatever became of them")


# --- Kinds of values ---


def _number(what: str, good: Callable[[float], bool]) -> Callable[[str], float]:
    """Return what reads a finite number of some kind."""

    def read(word: str) -> float:
        with contextlib.suppress(ValueError):
            value = float(word)
            if math.isfinite(value) and good(value):
                return value
        hint = "; a decimal needs a point" if "," in word else ""
        raise argparse.ArgumentTypeError(f"{word!r} is not {what}{hint}")

    return read


number = _number("a number", lambda value: True)
positive = _number("a number above zero", lambda value: value > 0)
share = _number("a number from 0 to 1", lambda value: 0 <= value <= 1)


def whole(word: str) -> int:
    """Read a whole number above zero."""
    if not word.isdecimal() or not 0 < int(word) < 10**6:
        raise argparse.ArgumentTypeError(
            f"{word!r} is not a whole number from 1 to 999999"
        )
    return int(word)


def odd(word: str) -> int:
    """Read how many pixels a window is across."""
    if (value := whole(word)) % 2 == 0:
        raise argparse.ArgumentTypeError(
            f"{word!r} is even: a window with a middle needs an odd number of pixels"
        )
    return value


# --- What is refused before the work ---


def check_outputs(
    parser: Parser,
    options: argparse.Namespace,
    inputs: Sequence[Path | None],
    *more: tuple[str, Path | None, Sequence[str]],
) -> None:
    """Refuse files that cannot be written, or are an input or another output.

    `more` are an option, its file or None, and the endings that its name may have.
    """
    reports = [("--report", path, REPORTS) for path in options.report]
    outputs = [
        *reports,
        *((option, path, endings) for option, path, endings in more if path),
    ]
    for option, path, endings in outputs:
        if wrong := _wrong(path, endings, options.force):
            parser.error(f"{option} {printable(path)}: {wrong}")
        for read in inputs:
            if read and same_file(read, path):
                parser.error(f"{option} {printable(path)}: this is the input {read}")
    for (_, first, _), (option, second, _) in combinations(outputs, 2):
        if same_file(first, second):
            parser.error(
                f"{option} {second}: another output, {first}, is the same file"
            )


def _wrong(path: Path, endings: Sequence[str], force: bool) -> str:
    """Say why a file cannot be written there."""
    if path.suffix.lower() not in endings:
        return f"the name must end in {', '.join(endings)}"
    try:
        if not stat.S_ISDIR(os.stat(path.parent).st_mode):
            return f"{path.parent} is not a folder"
        there = os.lstat(path)
    except FileNotFoundError:
        there = None
        if not os.path.lexists(path.parent):
            return f"there is no folder {path.parent}"
    except OSError as error:  # too long a name, a circle of links
        return f"no file can have this name ({error.strerror})"
    if not os.access(path.parent, os.W_OK):
        return f"nothing may be written into the folder {path.parent}"
    if there and not (stat.S_ISREG(there.st_mode) or stat.S_ISLNK(there.st_mode)):
        return "it is there already and is not a file: choose another name"
    if there and not force:
        return "it exists already; --force replaces it"
    return ""


def same_file(one: Path, other: Path) -> bool:
    """Whether two names are of one file, or would be where case does not count."""
    try:
        return os.path.samefile(one, other)
    except OSError:  # one of them is not there
        pass
    try:
        folder = os.path.samefile(one.parent, other.parent)
    except OSError:
        return False
    return folder and one.name.casefold() == other.name.casefold()
