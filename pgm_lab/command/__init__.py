"""The command `pgm_lab`: a subcommand for each thing to do with a user's own data.

A subcommand is a line of `COMMANDS` and a module, such as `_match`, with

- `DESCRIPTION` and `EPILOG`, for its help;
- `NO_MEMORY`, what to do when there is not enough memory;
- `add_options(parser)`, which adds its arguments;
- `check(parser, options)`, which refuses before the work what would go wrong after it;
- `run(options)`, which returns an `Outcome`: what to print, and the files to write.

The module is imported only when it is called: `pgm_lab --help` does not wait for NumPy.
"""

import contextlib
import importlib
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import NoReturn

from pgm_lab import __version__
from pgm_lab.command._options import Outcome, Parser
from pgm_lab.io import files
from pgm_lab.io.files import printable

__all__ = ["main"]

DONE, FAILED = 0, 1  # argparse itself ends with 2 when it is called wrongly
COMMANDS = {
    "adjust": "adjust a bundle of photos, from four text files to a report",
    "board": "draw a board to print, for the calibration of a camera",
    "calibrate": "find camera and lens from photos of a board, and what they are worth",
    "match": "find points of one photo in another, to a small part of a pixel",
    "register": "find how far two images of the same place lie off each other",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand: print a short report, write long ones and tables.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when missing.

    Returns
    -------
    int
        0: done; 1: a file is wrong or nothing was found, as the message on the error
        output says. A wrong call raises SystemExit with 2.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    name = next((word for word in words if word in COMMANDS), "")
    command = None
    try:
        with _interruptible():
            if name:
                command = importlib.import_module(f"pgm_lab.command._{name}")
            options = _parser(name, command).parse_args(words)
            assert command is not None  # argparse has refused any other name
            command.check(options.parser, options)
            _finish(command.run(options), options.force)
    except BrokenPipeError:  # who reads the output, as `head` does, has seen enough
        _close_output()
        return DONE
    except MemoryError:
        message = command.NO_MEMORY if command else "there is not enough memory"
    except (ValueError, OSError, ArithmeticError, ImportError) as error:
        message = _in_options(printable(error))
    except KeyboardInterrupt:
        message = "interrupted"
    else:
        return DONE
    print(f"pgm_lab {name}: {message}", file=sys.stderr)
    return FAILED


def _parser(name: str, command: ModuleType | None) -> Parser:
    """Return the parser, with the options of one of its subcommands."""
    parser = Parser(
        prog="pgm_lab",
        description="Photogrammetry with your own data. `pgm_lab COMMAND --help` lists"
        " the options of a command.",
        epilog="The exit code is 0: done; 1: a file is wrong or nothing was found; 2: a"
        " wrong call. Files that exist are replaced only with --force.",
    )
    version = f"%(prog)s {__version__}"
    parser.add_argument("--version", action="version", version=version)
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for one, words in COMMANDS.items():
        own = subparsers.add_parser(one, help=words)
        if command is not None and one == name:
            own.description, own.epilog = command.DESCRIPTION, command.EPILOG
            own.set_defaults(parser=own)
            command.add_options(own)
    return parser


def _in_options(message: str) -> str:
    """Name options where an error of the library names arguments of Python."""
    message = message.replace("in offset=(column, row)", "by --offset COLUMN ROW")
    return re.sub(r'\b(band|colour|nodata|start)="?(\w*)"?', r"--\1 \2", message)


def _finish(outcome: Outcome, force: bool) -> None:
    """Write all files or none, and print the short report."""
    files.save(outcome.files, overwrite=force)
    if hasattr(sys.stdout, "reconfigure"):  # a console without µ shows a ? for it
        sys.stdout.reconfigure(errors="replace")
    print(outcome.short, flush=True)


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into KeyboardInterrupt so that clean-up runs."""

    def interrupt(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    ends = []
    if threading.current_thread() is threading.main_thread():
        names = [one for one in ("SIGTERM", "SIGHUP") if hasattr(signal, one)]
        ends = [signal.Signals[one] for one in names]
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
