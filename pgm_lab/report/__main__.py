"""The command line: python -m pgm_lab.report, from four text files to a report."""

import argparse
import contextlib
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from typing import NoReturn

from pgm_lab import _files, bundle, report
from pgm_lab._files import printable
from pgm_lab.report._input import doubt
from pgm_lab.report._options import check_reports, parser

DONE, FAILED = 0, 1  # argparse itself ends with 2 when it is called wrongly
WRITERS = {
    ".html": report.html,
    ".htm": report.html,
    ".txt": report.text,
}

# The normal equations of m photos are 6 m + 10 square; while they are solved there are
# about so many copies of them
COPIES = 8


def main(arguments: Sequence[str] | None = None) -> int:
    """Adjust the network of four text files, print a short report, write long ones.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when missing.

    Returns
    -------
    int
        0: done; 1: a file is wrong or the adjustment not possible, as the message
        on the error output says. A wrong call raises SystemExit with 2.
    """
    call = parser()
    options = call.parse_args(arguments)
    check_reports(call, options)
    try:
        with _interruptible():
            _run(options)
    except MemoryError:
        message = "there is not enough memory for this network: adjust parts of it"
    except BrokenPipeError:  # who reads the output, as `head` does, has seen enough
        _close_output()
        return DONE
    except (ValueError, OSError, ArithmeticError) as error:
        message = printable(error)
    except KeyboardInterrupt:
        message = "interrupted"
    else:
        return DONE
    print(f"{call.prog}: {message}", file=sys.stderr)
    return FAILED


def _run(options: argparse.Namespace) -> None:
    files = (options.interior, options.exterior, options.points, options.image)
    network = bundle.read(*files, lens=options.lens, sigma=options.sigma)
    _refuse_too_large(network)
    found = _adjusted(network, options)
    about = f"From {', '.join(printable(path.name) for path in files)}."
    # All of them before the first is written: nothing half done
    pages = {
        path: WRITERS[path.suffix.lower()](found, about=about)
        for path in options.report
    }
    for left in _files.clear([path.parent for path in pages]):
        print(f"removed {printable(left)}, left by a run that broke", file=sys.stderr)
    _files.save(pages, overwrite=options.force)
    if hasattr(sys.stdout, "reconfigure"):  # a console without µ shows a ? for it
        sys.stdout.reconfigure(errors="replace")
    print(report.text(found, about=about, short=True), flush=True)


def _adjusted(
    network: bundle.Network, options: argparse.Namespace
) -> bundle.Bundle | bundle.Snooping:
    """Adjust a network; if it fails, say first what is wrong with the input."""
    settings = {"estimate": options.estimate, "datum": options.datum}
    settings["progress"] = sys.stderr.isatty()
    wrong = doubt(network)
    found: bundle.Bundle | bundle.Snooping
    try:
        if options.snoop:
            found = bundle.snoop(network, **settings)
            result = found.result
        else:
            found = result = bundle.adjust(network, **settings)
    except (ValueError, ArithmeticError) as error:
        if wrong is None:
            raise
        raise ValueError(f"{wrong.words} The adjustment failed: {error}") from None
    if result.status != "converged":
        cause = (
            wrong.words
            if wrong
            else "Check start values and ids, and that x points right and y up in the"
            " image; or estimate fewer parameters"
        )
        raise ArithmeticError(
            f"the adjustment did not converge ({result.status} after"
            f" {result.iterations} iterations), so there is nothing to report. {cause}"
        )
    return found


def _refuse_too_large(network: bundle.Network) -> None:
    """Refuse more photos than the memory holds before it is full."""
    photos = len(network.exteriors)
    needed = COPIES * 8 * (6 * photos + 10) ** 2
    try:
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):  # not on Windows
        return
    if needed > memory:
        raise ValueError(
            f"{photos} photos need about {needed / 1e9:.0f} GB for their normal"
            f" equations, and this machine has {memory / 1e9:.0f} GB: adjust parts of"
            " the network"
        )


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


if __name__ == "__main__":
    sys.exit(main())
