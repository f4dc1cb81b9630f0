"""What the command line takes, and what is wrong with it before any work is done."""

import argparse
import os
import stat
from itertools import combinations
from pathlib import Path
from typing import NoReturn

from pgm_lab._files import printable
from pgm_lab.camera import LENSES, PARAMETERS

FORMATS = (".html", ".htm", ".txt")


class Parser(argparse.ArgumentParser):
    """A parser whose messages hold nothing that a terminal would obey."""

    def error(self, message: str) -> NoReturn:
        """Print the usage and the message, and end with 2."""
        super().error(printable(message))


def check_reports(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    for path in options.report:
        if wrong := _wrong(path, options.force):
            parser.error(f"--report {path}: {wrong}")
    inputs = [options.interior, options.exterior, options.points, options.image]
    for path in options.report:
        if same := [one for one in inputs if _same(one, path)]:
            parser.error(f"--report {path}: this is the input {same[0]}")
    for one, other in combinations(options.report, 2):
        if _same(one, other):
            parser.error(f"--report {other}: another report, {one}, is the same file")


def _wrong(path: Path, force: bool) -> str:
    """Say why a report cannot be written there."""
    if path.suffix.lower() not in FORMATS:
        return f"the name must end in {', '.join(FORMATS)}"
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


def _same(one: Path, other: Path) -> bool:
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
    found.add_argument(
        "--report",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="write the whole report, as .html or .txt; may be given several times",
    )
    found.add_argument(
        "--force", action="store_true", help="replace reports that exist already"
    )
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
        type=_positive,
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


def _positive(word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        hint = ""
        if "," in word:
            hint = "; a decimal needs a point"
        raise argparse.ArgumentTypeError(f"{word!r} is not a number above zero{hint}")
    return value
