"""pgm_lab board: a board to print, for the calibration of a camera."""

import argparse
import re
from pathlib import Path

from pgm_lab.calibration.board import KINDS, PAPERS, screen, usual
from pgm_lab.command import _options
from pgm_lab.command._options import Outcome, Parser, add, positive, whole
from pgm_lab.io.files import printable
from pgm_lab.plot.page import page

DESCRIPTION = (
    "Draw a board with known points for the calibration of a camera: a PDF to print, or"
    " a PNG for a screen, and beside it board.json, which says what was printed."
)
EPILOG = (
    "A charuco board may be partly hidden; of a chequerboard or circles each photo must"
    " show all."
)
NO_MEMORY = "there is not enough memory for this page: make it smaller"


def add_options(parser: Parser) -> None:
    """Add what the subcommand takes."""
    parser.add_argument("page", type=Path, help="PDF to write; with --screen a PNG")
    where = parser.add_mutually_exclusive_group()
    words = "paper to print on, in landscape; A4 when missing"
    where.add_argument("--paper", choices=tuple(PAPERS), help=words)
    words = "columns and rows of a screen, 1920x1080 for example"
    add(where, "--screen", words, _size, "WxH")
    kinds = tuple(kind.replace(" ", "-") for kind in KINDS)
    words = f"what is drawn; {kinds[0]} when missing"
    parser.add_argument("--kind", choices=kinds, default=kinds[0], help=words)
    add(parser, "--columns", "squares across; circles, or tags, of these", whole, "N")
    add(parser, "--rows", "the same down", whole, "N")
    words = "side of a square, or distance of circles or tags; as large as it fits"
    add(parser, "--square", words, positive, "MM")
    words = "side of a marker or tag, diameter of a circle"
    add(parser, "--marker", words, positive, "MM")
    words = "where to say what was printed; beside the page, as .json, when missing"
    add(parser, "--json", words)
    words = "replace files that exist already"
    parser.add_argument("--force", action="store_true", help=words)
    parser.set_defaults(report=[])


def check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    if options.json is None:
        options.json = options.page.with_suffix(".json")
    if options.screen is not None and options.square is not None:
        parser.error("--square: of a screen it is measured; leave it out here")
    ending = ".pdf" if options.screen is None else ".png"
    files = ("the page", options.page, (ending,)), ("--json", options.json, (".json",))
    _options.check_outputs(parser, options, (), *files)


def run(options: argparse.Namespace) -> Outcome:
    """Draw the page, and say what to do with it."""
    names = ("columns", "rows", "square", "marker")
    asked = {name: getattr(options, name) for name in names}
    paper = options.paper or "A4"
    board = usual(options.kind.replace("-", " "), paper, **asked)
    name, json = printable(options.page.name), printable(options.json)
    if options.screen is None:
        drawn = page(board, paper)
        first = (
            f"Print {name} at 100 % and glue it on glass or a plate. Measure A to B,\n"
            "   A to D, A to C and B to D with a ruler, and write lengths and sd (mm)"
            f" into {json}."
        )
    else:
        board, drawn = screen(board, options.screen)
        first = (
            f"Show {name} on the screen, one of its pixels on one of the screen.\n  "
            " Measure ten squares with a ruler: --square is a tenth of it, in mm."
        )
    more = "" if options.screen is None else " --square MM"
    name = f"{board.kind}, {board.columns} x {board.rows}, {len(board.points)} points"
    title = f"Board: {name}"
    return Outcome(
        f"{title}\n{'=' * len(title)}\n"
        f"1. {first}\n"
        "2. Photograph it 15 times, zoom and focus fixed: filling the photo, slanted by"
        " 30 to 45 degrees\n   to all four sides, from two distances, and a quarter of"
        " the photos turned by 90 degrees.\n"
        "3. pgm_lab calibrate photos/*.jpg --board"
        f" {json}{more} --report report.html",
        {options.page: drawn, options.json: board.json()},
    )


def _size(word: str) -> tuple[int, int]:
    """Read the columns and rows of a screen."""
    found = re.fullmatch(r"(\d{3,5})[xX×](\d{3,5})", word, re.ASCII)
    if not found:
        raise argparse.ArgumentTypeError(f"{word!r} is not a size such as 1920x1080")
    return int(found[1]), int(found[2])
