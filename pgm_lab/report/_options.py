"""What the command line takes, and what is wrong with it before any work is done."""

import argparse
from pathlib import Path

from pgm_lab import _command
from pgm_lab._command import REPORTS, Parser
from pgm_lab.camera import LENSES, PARAMETERS


def check_reports(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    reports = [_command.Output("--report", one, REPORTS) for one in options.report]
    inputs = [options.interior, options.exterior, options.points, options.image]
    _command.check_outputs(parser, reports, inputs, options.force)


def parser() -> Parser:
    """Return the parser of the command line."""
    found = Parser(
        prog="python -m pgm_lab.report",
        description="Self-calibrating bundle adjustment of a free network, from four"
        " text files of numbers. White space, commas or semicolons separate columns, a"
        " point the decimals; %% starts a comment.",
        epilog="Photos and points have whole numbers as ids. x points right and y up"
        " from the middle of the photo, and the camera looks along its -z axis."
        " Control points, check points, scale bars and several cameras have no place in"
        " the files: see pgm_lab.bundle.Network in Python.",
    )
    for name, columns in (
        ("interior", f"start values: {' '.join(PARAMETERS)} (mm and its powers)"),
        (
            "exterior",
            "start values: photo omega phi kappa XL YL ZL (radians, any unit)",
        ),
        ("points", "start values: point X Y Z (the same unit)"),
        ("image", "measured: point photo x y sx sy (mm)"),
    ):
        found.add_argument(name, type=Path, help=columns)
    _command.add_outputs(found)
    found.add_argument(
        "--estimate",
        type=_parameters,
        default=PARAMETERS,
        metavar="c,x0,...",
        help="parameters of the camera to estimate, or none; all ten when missing",
    )
    found.add_argument(
        "--lens",
        choices=LENSES,
        default="backward",
        help="lens model: corrects measured coordinates, or displaces ideal ones",
    )
    found.add_argument(
        "--datum",
        choices=("inner", "photos"),
        default="inner",
        help="inner constraints on the points, or on the projection centres",
    )
    found.add_argument(
        "--snoop", action="store_true", help="take out blunders, one ray at a time"
    )
    found.add_argument(
        "--sigma",
        type=_command.positive,
        metavar="MM",
        help="standard deviation of all image coordinates, in place of sx and sy",
    )
    return found


def _parameters(words: str) -> tuple[str, ...]:
    names = () if words == "none" else tuple(words.split(","))
    for name in names:
        if name not in PARAMETERS:
            raise argparse.ArgumentTypeError(
                f"{name!r} is not one of {','.join(PARAMETERS)}"
            )
    return names
