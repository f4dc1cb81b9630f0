"""pgm_lab calibrate: a camera from photos of a board."""

import argparse
import glob
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

from pgm_lab import calibration
from pgm_lab.calibration import Board, Measured
from pgm_lab.camera import files
from pgm_lab.command import _options
from pgm_lab.command._adjust import parameters
from pgm_lab.command._options import Outcome, Parser, add, positive
from pgm_lab.io.files import printable
from pgm_lab.report import calibration as report

DESCRIPTION = (
    "Calibrate a camera by 12 to 20 photos of a board, made by pgm_lab board: from the"
    " left, the right, above and below, some turned by 90 degrees, with the board in"
    " all parts of the image. Zoom and focus must not change."
)
EPILOG = (
    "The board may be bent: the places of its points are found, too. Photos are read as"
    " the sensor saw them, whatever EXIF says of how the camera was held."
)
NO_MEMORY = "there is not enough memory for these photos: give fewer at once"
NOMINAL = 0.001  # mm, size of a pixel where nobody knows it
FORMATS = {  # option: (ending, for whom)
    "camera": (".json", "pgm_lab"),
    "opencv": (".yml", "OpenCV: without b1 and b2"),
    "colmap": (".txt", "COLMAP, as cameras.txt: likewise"),
    "metashape": (".xml", "Metashape: likewise"),
}


def add_options(parser: Parser) -> None:
    """Add what the subcommand takes."""
    words = "photos of the board, or a folder of them; * and ? stand for any characters"
    parser.add_argument("photos", nargs="+", help=words)
    words = "what was printed, the file that pgm_lab board wrote"
    parser.add_argument("--board", type=Path, required=True, metavar="FILE", help=words)
    add(parser, "--square", "side of a square, as measured", positive, "MM")
    words = "size of a pixel on the sensor; from EXIF, or 0.001, when missing"
    add(parser, "--pixel-size", words, positive, "MM")
    parser.add_argument(
        "--estimate",
        type=parameters,
        metavar="c,x0,...",
        help="parameters to estimate; when missing all, b1 and b2 only if significant",
    )
    words = "take the board for flat and exactly printed"
    parser.add_argument("--flat", action="store_true", help=words)
    for name, (_, whom) in FORMATS.items():
        add(parser, f"--{name}", f"write the camera for {whom}")
    _options.add_outputs(parser)


def check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    options.photos = _expanded(parser, options.photos)
    outputs = [
        (f"--{name}", getattr(options, name), (ending,))
        for name, (ending, _) in FORMATS.items()
    ]
    _options.check_outputs(parser, options, [options.board, *options.photos], *outputs)


def _expanded(parser: Parser, words: Sequence[str]) -> list[Path]:
    """Return the files of names, folders, and of * and ?, which Windows leaves."""
    found: list[Path] = []
    for word in words:
        if os.path.isdir(word):
            inside = sorted(Path(word).iterdir())
            some = [one for one in inside if one.suffix.lower() in calibration.ENDINGS]
        elif os.path.lexists(word) or not glob.has_magic(word):
            some = [Path(word)]
        else:
            some = [Path(one) for one in sorted(glob.glob(word))]
        if not some:
            parser.error(f"{printable(word)}: there are no photos of this name")
        found += some
    return list(dict.fromkeys(found))


def run(options: argparse.Namespace) -> Outcome:
    """Measure the photos, calibrate the camera, and report it."""
    board = Board.read(options.board)
    if options.square is not None:
        board = board.scaled(options.square)
    photos = _measured(options.photos, board)
    pixel_size = options.pixel_size or calibration.pixel_size(photos)
    estimate = options.estimate
    if estimate is None and (options.opencv or options.colmap or options.metashape):
        estimate = calibration.SQUARE  # their models
    found = calibration.calibrate(
        photos,
        board,
        pixel_size=pixel_size or NOMINAL,
        estimate=estimate,
        flat=options.flat,
    )
    about = f"{len(photos)} photos of the board in {printable(options.board.name)}."
    words: dict = {"about": about, "nominal": pixel_size is None}
    size = found.image_size, found.pixel_size
    known = found.result.estimate, found.covariance
    camera = files.CameraFile(found.camera, *size, pixel_size is None, *known, about)
    more: dict[Path, str | bytes] = {
        path: camera.text() if name == "camera" else files.exchange(camera, name)
        for name in FORMATS
        if (path := getattr(options, name)) is not None
    }
    text, html = (partial(one, found, **words) for one in (report.text, report.html))
    return _options.outcome(options, text, html, more)


def _measured(paths: Sequence[Path], board: Board) -> list[Measured]:
    """Measure all photos, two at a time, with a bar that tells the time left."""
    from tqdm import tqdm

    watched = sys.stderr.isatty()
    with ThreadPoolExecutor(min(4, os.cpu_count() or 1)) as pool:
        found = pool.map(lambda path: calibration.measure(path, board), paths)
        bar = tqdm(found, "photos", len(paths), leave=False, disable=not watched)
        photos = list(bar)
    # Photos of the same name from two folders
    names = [one.name for one in photos]
    return [
        replace(one, name=printable(path)) if names.count(one.name) > 1 else one
        for one, path in zip(photos, paths)
    ]
