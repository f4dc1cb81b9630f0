"""pgm_lab match: points of one photo in another."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pgm_lab import matching, observations
from pgm_lab.command import _options
from pgm_lab.command._options import (
    TABLES,
    Outcome,
    Parser,
    add,
    odd,
    positive,
    share,
    whole,
)
from pgm_lab.io.files import printable
from pgm_lab.io.photo import COLOURS
from pgm_lab.io.text import read_table
from pgm_lab.matching.pair import STARTS
from pgm_lab.report import matching as report

DESCRIPTION = (
    "Find points of the left photo in the right one, to a small part of a pixel. JPEG,"
    " PNG, TIFF and what else Pillow opens, 8 or 16 bit; transparent pixels and NaN"
    " count as missing."
)
EPILOG = (
    "Columns count to the right and rows down, from 0 at the middle of the first pixel"
    " of the upright photo."
)
NO_MEMORY = (
    "there is not enough memory for these photos: cut out the part that both show"
)
OPTIONS: dict[str, dict[str, Any]] = {
    "template": {"type": odd, "metavar": "PX"},
    "start": {"choices": tuple(STARTS)},
    "search": {"type": odd, "metavar": "PX"},
    "colour": {"choices": COLOURS},
    "threshold": {"type": share, "metavar": "R"},
    "ratio": {"type": share, "metavar": "SHARE"},
    "back": {"type": positive, "metavar": "PX"},
    "least_quality": {"type": share, "metavar": "Q"},
}


def add_options(parser: Parser) -> None:
    """Add what the subcommand takes."""
    parser.add_argument("left", type=Path, help="photo in which the points are chosen")
    parser.add_argument("right", type=Path, help="photo in which they are sought")
    where = parser.add_mutually_exclusive_group()
    words = "points to match: column row, one a line; picked when missing"
    add(where, "--points", words)
    add(where, "--number", report.SETTINGS["number"], whole, "N")
    for name, kind in OPTIONS.items():
        option = "--" + name.removeprefix("least_")
        parser.add_argument(option, dest=name, help=report.SETTINGS[name], **kind)
    _options.add_outputs(parser)
    _options.add_csv(parser)
    words = "write the image file of pgm_lab adjust: photos 1 and 2, in mm"
    add(parser, "--image-csv", words)
    words = "size of a pixel, for --image-csv"
    add(parser, "--pixel-size", words, positive, "MM")


def check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    tables = ("--csv", options.csv, TABLES), ("--image-csv", options.image_csv, TABLES)
    inputs = options.left, options.right, options.points
    _options.check_outputs(parser, options, inputs, *tables)
    if options.image_csv is not None and options.pixel_size is None:
        parser.error("--image-csv needs --pixel-size, the size of a pixel in mm")


def run(options: argparse.Namespace) -> Outcome:
    """Match two photos, and report what was found."""
    if _options.same_file(options.left, options.right):
        raise ValueError(
            f"{options.left} and {options.right} are the same file: two photos of the"
            " same object, from two places, are needed"
        )
    asked = {name: getattr(options, name) for name in ("number", *OPTIONS)}
    settings = {name: value for name, value in asked.items() if value is not None}
    with _options.progress("reading", "matching", "reporting") as begin:
        begin()
        if options.points is not None:
            columns = ("column", "row")
            table = read_table(options.points, "points", columns, 0)
            settings["points"] = table.values
        colour = options.colour or COLOURS[0]
        left = matching.read(options.left, "left", colour=colour)
        right = matching.read(options.right, "right", colour=colour)
        begin()
        found = matching.match(left, right, **settings)
        if not np.any(found.accepted):
            raise ValueError(report.reason(found))
        begin()
        about = f"From {printable(options.left.name)}, {printable(options.right.name)}."
        words: dict[str, Any] = {"settings": settings, "about": about}
        files: dict[Path, str | bytes] = {}
        if options.csv is not None:
            files[options.csv] = found.csv()
        if options.image_csv is not None:
            files[options.image_csv] = _image_file(found, options.pixel_size)
        text = partial(report.text, found, **words)
        html = partial(report.html, found, left, right, **words)
        return _options.outcome(options, text, html, files)


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
