"""The command line: python -m pgm_lab.report, from four text files to a report."""

import argparse
import os
import sys
from collections.abc import Sequence

from pgm_lab import _command, bundle, report
from pgm_lab.io.files import printable
from pgm_lab.report._input import doubt
from pgm_lab.report._options import check_reports, parser

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
    no_memory = "there is not enough memory for this network: adjust parts of it"
    return _command.run(call.prog, lambda: _run(options), no_memory)


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
    _command.finish(pages, options.force, report.text(found, about=about, short=True))


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


if __name__ == "__main__":
    sys.exit(main())
