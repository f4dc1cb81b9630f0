"""The command line: python -m pgm_lab.matching, from two photos to a report."""

import argparse
import re
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from pgm_lab import _command, matching, observations
from pgm_lab._command import REPORTS, TABLES, Output, Parser
from pgm_lab.io import text as _numbers
from pgm_lab.io.files import printable
from pgm_lab.io.photo import COLOURS
from pgm_lab.matching.pair import STARTS
from pgm_lab.report import matching as report
from pgm_lab.report._match_tables import SETTINGS
from pgm_lab.report._statuses import advice

STEPS = "reading", "matching", "reporting"
NO_MEMORY = (
    "there is not enough memory for these photos: cut out the part that both show"
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Match two photos, print a short report, write long ones and tables.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when missing.

    Returns
    -------
    int
        0: done; 1: a file is wrong or no point was found, as the message on the error
        output says. A wrong call raises SystemExit with 2.
    """
    call = parser()
    options = call.parse_args(arguments)
    _check(call, options)
    return _command.run(call.prog, lambda: _in_words_of_a_call(options), NO_MEMORY)


def _in_words_of_a_call(options: argparse.Namespace) -> None:
    """Run, and where an error names an argument of Python, name the option."""
    try:
        _run(options)
    except ValueError as error:
        words = re.sub(r'\b(colour|start)="(\w+)"', r"--\1 \2", str(error))
        raise ValueError(words) from None


def _run(options: argparse.Namespace) -> None:
    if _command.same(options.left, options.right):
        raise ValueError(
            f"{options.left} and {options.right} are the same file: two photos of the"
            " same object, from two places, are needed"
        )
    settings = {
        name: value
        for name in SETTINGS
        if (value := getattr(options, name)) is not None
    }
    watched = sys.stderr.isatty()
    with tqdm(total=len(STEPS), disable=not watched, leave=False, unit="step") as bar:
        bar.set_description(STEPS[0])
        if options.points is not None:
            columns = ("column", "row")
            table = _numbers.read_table(options.points, "points", columns, 0)
            settings["points"] = table.values
        colour = options.colour or COLOURS[0]
        left = matching.read(options.left, "left", colour=colour)
        right = matching.read(options.right, "right", colour=colour)
        bar.update()
        bar.set_description(STEPS[1])
        found = matching.match(left, right, **settings)
        _refuse_none(found)
        bar.update()
        bar.set_description(STEPS[2])
        about = f"From {printable(options.left.name)}, {printable(options.right.name)}."
        words: dict[str, Any] = {"settings": settings, "about": about}
        # All of them before the first is written: nothing half done
        pages = {}
        for path in options.report:
            if path.suffix.lower() == ".txt":
                pages[path] = report.text(found, **words)
            else:
                pages[path] = report.html(found, left, right, **words)
        if options.csv is not None:
            pages[options.csv] = found.csv()
        if options.image_csv is not None:
            pages[options.image_csv] = _image_file(found, options.pixel_size)
        bar.update()
    short = report.text(found, **words, short=True)
    _command.finish(pages, options.force, short)


def _image_file(found: matching.Match, pixel_size: float) -> str:
    """Return the accepted points as photos 1 and 2 of a bundle."""
    if found.left_size != found.right_size:
        raise ValueError(
            f"the photos have {found.left_size} and {found.right_size} pixels, and an"
            " image file is of one camera: leave out --image-csv"
        )
    seen = observations.from_matches(
        found.chosen, {2: found}, found.left_size, pixel_size, left=1
    )
    return seen.csv()


def _refuse_none(found: matching.Match) -> None:
    if np.any(found.accepted):
        return
    status, number = Counter(found.status.tolist()).most_common(1)[0]
    raise ValueError(
        f"none of {len(found.chosen)} points was found; most often ({number}) the"
        f' reason is "{status}": {advice(status)} Do both photos show the same?'
    )


def _check(call: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    inputs = [options.left, options.right]
    inputs += [] if options.points is None else [options.points]
    outputs = [Output("--report", path, REPORTS) for path in options.report]
    for option, path in (("--csv", options.csv), ("--image-csv", options.image_csv)):
        outputs += [] if path is None else [Output(option, path, TABLES)]
    _command.check_outputs(call, outputs, inputs, options.force)
    if options.image_csv is not None and options.pixel_size is None:
        call.error("--image-csv needs --pixel-size, the size of a pixel in mm")
    if options.points is not None and options.number is not None:
        call.error("--points and --number exclude each other: give one of them")


def parser() -> Parser:
    """Return the parser of the command line."""
    found = Parser(
        prog="python -m pgm_lab.matching",
        description="Find points of the left photo in the right one, to a small part of"
        " a pixel. JPEG, PNG, TIFF and what else Pillow opens, 8 or 16 bit; transparent"
        " pixels and NaN count as missing.",
        epilog="Columns count to the right and rows down, from 0 at the middle of the"
        " first pixel of the upright photo.",
    )
    found.add_argument("left", type=Path, help="photo in which the points are chosen")
    found.add_argument("right", type=Path, help="photo in which they are sought")
    found.add_argument(
        "--points",
        type=Path,
        metavar="FILE",
        help="points to match: column row, one a line; picked when missing",
    )
    kinds: dict[str, dict] = {
        "number": {"type": _command.whole, "metavar": "N"},
        "template": {"type": _command.odd, "metavar": "PX"},
        "start": {"choices": tuple(STARTS)},
        "search": {"type": _command.odd, "metavar": "PX"},
        "colour": {"choices": COLOURS},
        "threshold": {"type": _command.share, "metavar": "R"},
        "ratio": {"type": _command.share, "metavar": "SHARE"},
        "back": {"type": _command.positive, "metavar": "PX"},
        "least_quality": {"type": _command.share, "metavar": "Q"},
    }
    for name, kind in kinds.items():
        option = "--" + name.removeprefix("least_")
        found.add_argument(option, dest=name, help=SETTINGS[name], **kind)
    _command.add_outputs(found)
    _command.add_csv(found)
    found.add_argument(
        "--image-csv",
        type=Path,
        metavar="FILE",
        help="write the image file of python -m pgm_lab.report: photos 1 and 2, in mm",
    )
    found.add_argument(
        "--pixel-size",
        type=_command.positive,
        metavar="MM",
        help="size of a pixel, for --image-csv",
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
