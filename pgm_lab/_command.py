"""What the command lines share: how they end, what they refuse, what they write."""

import argparse
import contextlib
import os
import signal
import stat
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple, NoReturn

from pgm_lab.io import files as _files
from pgm_lab.io.files import printable

DONE, FAILED = 0, 1  # argparse itself ends with 2 when it is called wrongly
REPORTS = (".html", ".htm", ".txt")
TABLES = (".csv", ".txt")


class Parser(argparse.ArgumentParser):
    """A parser whose messages hold nothing that a terminal would obey."""

    def error(self, message: str) -> NoReturn:
        """Print the usage and the message, and end with 2."""
        super().error(printable(message))


class Output(NamedTuple):
    """A file to write, the option that names it, and how its name may end."""

    option: str
    path: Path
    endings: Sequence[str]


def add_outputs(parser: Parser) -> None:
    """Add the options --report and --force."""
    parser.add_argument(
        "--report",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="write the whole report, as .html or .txt; may be given several times",
    )
    parser.add_argument(
        "--force", action="store_true", help="replace files that exist already"
    )


def add_csv(parser: Parser) -> None:
    """Add the option --csv."""
    parser.add_argument(
        "--csv",
        type=Path,
        metavar="FILE",
        help="write all points, whatever became of them",
    )


def number(word: str) -> float:
    """Read a finite number."""
    return _number(word, "a number", -float("inf"))


def positive(word: str) -> float:
    """Read a number above zero."""
    return _number(word, "a number above zero", 0.0)


def _number(word: str, what: str, above: float) -> float:
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not above < value < float("inf"):
        hint = "; a decimal needs a point" if "," in word else ""
        raise argparse.ArgumentTypeError(f"{word!r} is not {what}{hint}")
    return value


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


def share(word: str) -> float:
    """Read a number from 0 to 1."""
    try:
        value = float(word)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"{word!r} is not a number from 0 to 1")
    return value


def check_outputs(
    parser: Parser, outputs: Sequence[Output], inputs: Sequence[Path], force: bool
) -> None:
    """Refuse before the work what would go wrong after it."""
    for one in outputs:
        if wrong := _wrong(one, force):
            parser.error(f"{one.option} {one.path}: {wrong}")
    for one in outputs:
        if read := [path for path in inputs if same(path, one.path)]:
            parser.error(f"{one.option} {one.path}: this is the input {read[0]}")
    for first, second in combinations(outputs, 2):
        if same(first.path, second.path):
            parser.error(
                f"{second.option} {second.path}: another output, {first.path}, is the"
                " same file"
            )


def _wrong(output: Output, force: bool) -> str:
    """Say why a file cannot be written there."""
    path = output.path
    if path.suffix.lower() not in output.endings:
        return f"the name must end in {', '.join(output.endings)}"
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


def same(one: Path, other: Path) -> bool:
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


def run(program: str, work: Callable[[], None], no_memory: str) -> int:
    """Do the work of a command, and say in one line why it failed.

    Returns
    -------
    int
        0: done; 1: failed, and the reason stands on the error output.
    """
    try:
        with _interruptible():
            work()
    except MemoryError:
        message = no_memory
    except BrokenPipeError:  # who reads the output, as `head` does, has seen enough
        _close_output()
        return DONE
    except (ValueError, OSError, ArithmeticError) as error:
        message = printable(error)
    except KeyboardInterrupt:
        message = "interrupted"
    else:
        return DONE
    print(f"{program}: {message}", file=sys.stderr)
    return FAILED


def finish(pages: Mapping[Path, str | bytes], force: bool, short: str) -> None:
    """Write all files or none, and print the short report."""
    _files.save(pages, overwrite=force)
    if hasattr(sys.stdout, "reconfigure"):  # a console without µ shows a ? for it
        sys.stdout.reconfigure(errors="replace")
    print(short, flush=True)


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Let what ends a program, as `kill` does, undo what is half done."""

    def interrupt(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    ends = []
    if threading.current_thread() is threading.main_thread():
        there = [n for n in ("SIGTERM", "SIGHUP") if hasattr(signal, n)]
        ends = [signal.Signals[name] for name in there]
    # nohup has SIGHUP ignored: that stays
    ends = [end for end in ends if signal.getsignal(end) == signal.SIG_DFL]
    for end in ends:
        signal.signal(end, interrupt)
    try:
        yield
    finally:
        for end in ends:
            signal.signal(end, signal.SIG_DFL)


def _close_output() -> None:
    """Leave nothing for Python to complain about when it flushes at the end."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
