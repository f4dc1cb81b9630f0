"""pgm_lab adjust: a bundle adjustment from four text files."""

import argparse
import os
import sys
from functools import partial
from pathlib import Path

from pgm_lab import bundle, report
from pgm_lab.camera import LENSES, PARAMETERS
from pgm_lab.command import _options
from pgm_lab.command._options import Outcome, Parser
from pgm_lab.io.files import printable
from pgm_lab.report.network import doubt

DESCRIPTION = (
    "Self-calibrating bundle adjustment of a free network, from four text files of"
    " numbers. White space, commas or semicolons separate columns, a point the"
    " decimals; % starts a comment."
)
EPILOG = (
    "Photos and points have whole numbers as ids. x points right and y up from the"
    " middle of the photo, and the camera looks along its -z axis. Control points,"
    " check points, scale bars and several cameras have no place in the files: see"
    " pgm_lab.bundle.Network in Python."
)
NO_MEMORY = "there is not enough memory for this network: adjust parts of it"
FILES = {
    "interior": f"start values: {' '.join(PARAMETERS)} (mm and its powers), or a"
    " camera.json",
    "exterior": "start values: photo omega phi kappa XL YL ZL (radians, any unit)",
    "points": "start values: point X Y Z (the same unit)",
    "image": "measured: point photo x y sx sy (mm)",
}

# The normal equations of m photos are 6 m + 10 square; while they are solved there are
# about so many copies of them
COPIES = 8


def add_options(parser: Parser) -> None:
    """Add what the subcommand takes."""
    for name, columns in FILES.items():
        parser.add_argument(name, type=Path, help=columns)
    _options.add_outputs(parser)
    parser.add_argument(
        "--estimate",
        type=parameters,
        default=PARAMETERS,
        metavar="c,x0,...",
        help="parameters of the camera to estimate, or none; all ten when missing",
    )
    parser.add_argument(
        "--lens",
        choices=LENSES,
        help="lens model: corrects measured coordinates (when missing), or displaces"
        " ideal ones; a camera.json says it",
    )
    parser.add_argument(
        "--datum",
        choices=("inner", "photos"),
        default="inner",
        help="inner constraints on the points, or on the projection centres",
    )
    parser.add_argument(
        "--snoop", action="store_true", help="reject blunders, one ray at a time"
    )
    words = "standard deviation of all image coordinates, in place of sx and sy"
    _options.add(parser, "--sigma", words, _options.positive, "MM")


def parameters(words: str) -> tuple[str, ...]:
    """Read names of interior parameters, or none."""
    names = () if words == "none" else tuple(words.split(","))
    for name in names:
        if name not in PARAMETERS:
            raise argparse.ArgumentTypeError(
                f"{name!r} is not one of {','.join(PARAMETERS)}"
            )
        if names.count(name) > 1:
            raise argparse.ArgumentTypeError(f"{name} stands there twice")
    return names


def check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    _options.check_outputs(parser, options, [getattr(options, name) for name in FILES])


def run(options: argparse.Namespace) -> Outcome:
    """Adjust the network of the files, and report it."""
    files = [getattr(options, name) for name in FILES]
    interior, exterior, points, image = files
    settings = {"lens": options.lens, "sigma": options.sigma}
    network = bundle.read(interior, exterior, points, image, **settings)
    _refuse_too_large(network)
    found = _adjusted(network, options)
    about = f"From {', '.join(printable(path.name) for path in files)}."
    text = partial(report.text, found, about=about)
    return _options.outcome(options, text, partial(report.html, found, about=about))


def _adjusted(
    network: bundle.Network, options: argparse.Namespace
) -> bundle.Bundle | bundle.Snooping:
    """Adjust a network; if it fails, say first what is wrong with the input."""
    settings = {"estimate": options.estimate, "datum": options.datum}
    settings["progress"] = sys.stderr.isatty()
    wrong = doubt(network)
    try:
        work = bundle.snoop if options.snoop else bundle.adjust
        found: bundle.Bundle | bundle.Snooping = work(network, **settings)
    except (ValueError, ArithmeticError) as error:
        if wrong is None:
            raise
        raise ValueError(f"{wrong.words} The adjustment failed: {error}") from None
    result = found.result if isinstance(found, bundle.Snooping) else found
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
