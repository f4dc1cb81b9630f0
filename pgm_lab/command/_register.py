"""pgm_lab register: how far two images of one place lie off each other."""

import argparse
import importlib.util
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pgm_lab import registration
from pgm_lab.command import _options
from pgm_lab.command._options import (
    TABLES,
    Outcome,
    Parser,
    add,
    number,
    odd,
    positive,
    share,
    whole,
)
from pgm_lab.io.files import printable
from pgm_lab.registration import Model, Raster, Registration
from pgm_lab.registration.chips import HALF
from pgm_lab.registration.model import NAMES
from pgm_lab.registration.start import Start, cause, chance
from pgm_lab.report import registration as report

DESCRIPTION = (
    "How far a sensed image lies off a reference image of the same place, and how sure"
    " that is. GeoTIFF where rasterio is installed; PNG, TIFF and JPEG without a place"
    " on the map; 8 or 16 bit."
)
EPILOG = "Shifts are sensed minus reference, columns to the right and rows down."
NO_MEMORY = (
    "there is not enough memory for these images: cut out the part that both show, or"
    " take fewer points"
)
NUMBER = {"shift": 100, "affine": 100, "local": 500}  # points that are picked
NEAR = 0.5  # of the radius: the search needs no other start
MANY = 0.5  # of the points: where fewer are accepted, chance decides on r
RASTERS = (".tif", ".tiff")
THRESHOLD = 0.7  # of r, if not asked for
REFINE = {"none": None, "parabola": "parabola", "lsm": "lsm"}
OPTIONS: dict[str, dict[str, Any]] = {
    "chip": {"type": odd, "metavar": "PX"},
    "radius": {"type": whole, "metavar": "PX"},
    "refine": {"choices": tuple(REFINE), "default": "lsm"},
    "threshold": {"type": share, "metavar": "R"},
    "largest_sd": {"type": positive, "metavar": "PX"},
    "smooth": {"type": number, "metavar": "PX"},
    "offset": {"type": number, "nargs": 2, "metavar": ("COLUMN", "ROW")},
}


def add_options(parser: Parser) -> None:
    """Add what the subcommand takes."""
    parser.add_argument("reference", type=Path, help="image that is taken as right")
    parser.add_argument("sensed", type=Path, help="image that is compared with it")
    where = parser.add_mutually_exclusive_group()
    words = "points of the reference image: column row, one a line"
    add(where, "--points", words)
    add(where, "--map-points", "the same as x y on its map")
    add(where, "--grid", report.SETTINGS["grid"], whole, "STEP")
    words = f"{report.SETTINGS['number']}; {NUMBER['shift']} when missing,"
    words += f" {NUMBER['local']} for a local model"
    add(where, "--number", words, whole, "N")
    for name, kind in OPTIONS.items():
        option = "--" + name.replace("_", "-")
        parser.add_argument(option, dest=name, help=report.SETTINGS[name], **kind)
    parser.add_argument(
        "--model",
        choices=tuple(NAMES),
        default="shift",
        help="what is fitted to the shifts of the points: one shift for all, scales,"
        " rotation and shear too, or a smooth field as where relief shifts them",
    )
    add(parser, "--band", "band to read, from 1", whole, "N")
    words = "band of the sensed image, where it is another one"
    add(parser, "--sensed-band", words, whole, "N")
    add(parser, "--nodata", "grey value that marks missing data", number, "VALUE")
    words = "of the reference image, where the file does not say it"
    add(parser, "--pixel-size", words, positive, "METRES")
    _options.add_outputs(parser)
    _options.add_csv(parser)
    words = "write the sensed image in the pixels of the reference image, as GeoTIFF"
    add(parser, "--resampled", words)


def check(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    files = ("--csv", options.csv, TABLES), ("--resampled", options.resampled, RASTERS)
    inputs = options.reference, options.sensed, options.points, options.map_points
    _options.check_outputs(parser, options, inputs, *files)
    if options.resampled is not None and not importlib.util.find_spec("rasterio"):
        parser.error("--resampled needs rasterio: pip install rasterio")


def run(options: argparse.Namespace) -> Outcome:
    """Register two images, and report how they lie."""
    if _options.same_file(options.reference, options.sensed):
        raise ValueError(
            f"{options.reference} and {options.sensed} are the same file: two images of"
            " the same place are needed"
        )
    steps = "reading", "registering", "resampling", "reporting"
    with _options.progress(*steps) as begin:
        begin()
        originals = reference, sensed = _read(options)
        if options.offset is None:
            reference, sensed = registration.common_grid(*originals)
        # By how many pixels (column, row) the sensed image is ahead
        offset = np.array(options.offset)
        if options.offset is None:
            offset = registration.offset(reference, sensed)
        settings = _settings(options, originals[0], offset)
        if reference is not originals[0] and "points" in settings:
            on_map = originals[0].map(settings["points"])
            settings["points"] = reference.pixels(on_map)
        begin()
        found, start = _register(reference, sensed, settings, offset)
        model = _model(options, found, offset)
        begin()
        files: dict[Path, str | bytes] = {}
        if options.resampled is not None:
            assert model is not None  # or `_model` had raised
            new = _resampled(reference, sensed, model, options.resampled)
            files[options.resampled] = new
        begin()
        names = (printable(path.name) for path in (options.reference, options.sensed))
        about = "Reference image {}, sensed image {}.".format(*names)
        if sensed is not originals[1]:
            sizes = " x ".join(f"{n:.6g}" for n in np.hypot(*reference.affine()[0]))
            about += (
                f" On one grid, {reference.crs or 'no name'}, of {sizes} map units."
            )
        words: dict[str, Any] = {
            "model": model,
            "start": start,
            "pixel_size": options.pixel_size,
            "settings": settings,
            "about": about,
        }
        if options.csv is not None:
            files[options.csv] = _csv(found, reference)
        both = found, reference, sensed
        text, html = (
            partial(one, *both, **words) for one in (report.text, report.html)
        )
        return _options.outcome(options, text, html, files)


def _read(options: argparse.Namespace) -> tuple[Raster, Raster]:
    """Read both images."""
    nodata, band = options.nodata, options.sensed_band or options.band
    reference = registration.read(options.reference, options.band, nodata=nodata)
    try:
        sensed = registration.read(options.sensed, band, nodata=nodata)
    except ValueError as error:
        message = str(error).replace("band=", "--sensed-band ")
        raise ValueError(message) from None
    if options.pixel_size is not None and reference.pixel_size is not None:
        size = " x ".join(f"{one:g}" for one in reference.pixel_size)
        raise ValueError(
            f"{printable(options.reference)} says that its pixels have {size} m: leave"
            " out --pixel-size"
        )
    return reference, sensed


def _settings(
    options: argparse.Namespace, reference: Raster, offset: np.ndarray
) -> dict[str, Any]:
    """What the registration is asked for, points among it."""
    numbers = "chip", "radius", "threshold", "largest_sd", "smooth"
    asked = {name: getattr(options, name) for name in numbers}
    settings = {name: value for name, value in asked.items() if value is not None}
    settings["refine"] = REFINE[options.refine]
    if options.model == "local":  # also a chip with little weight says something there
        settings.setdefault("largest_sd", HALF)
    if options.offset is not None or reference.transform is not None:
        settings["offset"] = offset
    if options.points is not None:
        settings["points"] = registration.read_points(options.points)
    elif options.map_points is not None:
        settings["points"] = registration.read_points(options.map_points, reference)
    elif options.grid is not None:
        settings["grid"] = options.grid
    else:
        settings["number"] = options.number or NUMBER[options.model]
    return settings


def _register(
    reference: Raster, sensed: Raster, settings: dict[str, Any], offset: np.ndarray
) -> tuple[Registration, Start | None]:
    """Register points that were given, lie on a grid, or are picked in the texture.

    Where it begins is told too; what follows from the images is added to the settings.
    """
    grey, other = reference.values, sensed.values
    _refuse_without_overlap(grey.shape, other.shape, offset)
    chip, start = settings.get("chip", 21), None
    nowhere = False  # whether reduced images, too, have nothing in common
    if "radius" not in settings:
        start = registration.approximate(grey, other, chip, offset=offset)
        nowhere = start is None
    radius = settings.get("radius", 3)
    if start is not None:
        radius = settings["radius"] = start.radius
        if radius == 3 and np.abs(start.range).max() <= NEAR * radius:
            start = None
    expected = np.zeros(2) if start is None else start.typical
    points = _points(grey, other, settings, chip, radius, offset + expected)
    asked = {k: v for k, v in settings.items() if k not in ("number", "grid")}
    asked |= {"points": points}
    if start is not None:
        asked["start"] = settings["start"] = start.shifts(points)
    found = registration.register(grey, other, **asked)
    if "threshold" not in settings and found.accepted.mean() < MANY:
        # In other light or season r is lower: still above what chance gives?
        at = points + offset + asked.get("start", 0.0)
        least = chance(grey, other, points, at, chip, radius)
        if least < THRESHOLD:
            settings["threshold"] = round(least, 2)
            asked["threshold"] = settings["threshold"]
            found = registration.register(grey, other, **asked)
    if not np.any(found.accepted):
        reason = report.reason(found)
        if nowhere:
            reason = (
                f"none of {len(points)} points was accepted, nor do reduced images"
                " agree on any shift up to a quarter of their shorter side."
            )
        why = cause(grey, other) or (
            "Do both images show the same place, in the same band, neither rotated nor"
            " scaled? Are they farther apart? --offset COLUMN ROW says where to begin"
        )
        raise ValueError(f"{reason} {report.unmarked(reference, sensed)}{why}")
    return found, start


def _points(
    grey: np.ndarray,
    other: np.ndarray,
    settings: dict[str, Any],
    chip: int,
    radius: int,
    offset: np.ndarray,
) -> np.ndarray:
    """Points that were given, lie on a grid, or are picked in the texture."""
    if "points" in settings:
        return settings["points"]
    if "grid" in settings:
        return registration.grid(grey.shape, settings["grid"], chip // 2 + radius)
    number = settings["number"]
    points = registration.pick(grey, number, chip, radius, sensed=other, offset=offset)
    if not len(points):
        raise ValueError(
            "there is no texture in what both images show: give points, or a smaller"
            " chip"
        )
    return points


def _refuse_without_overlap(
    reference: tuple[int, ...], sensed: tuple[int, ...], offset: np.ndarray
) -> None:
    """Say that the offset moves the images apart, where it does."""
    size, other = np.array(reference[::-1]), np.array(sensed[::-1])
    if np.any((offset <= -size) | (offset >= other)):
        column, row = offset
        raise ValueError(
            f"with an offset of {column:g} columns and {row:g} rows the images do not"
            f" overlap: they have {size[0]} x {size[1]} and {other[0]} x {other[1]}"
            " pixels. Give another --offset, or images of the same place"
        )


def _model(
    options: argparse.Namespace, found: Registration, offset: np.ndarray
) -> Model | None:
    """One transformation for the whole image; none from too few points."""
    try:
        return registration.fit(found, options.model, offset=offset)
    except ValueError:
        if options.resampled is not None:
            raise
        return None


def _resampled(reference: Raster, sensed: Raster, model: Model, path: Path) -> bytes:
    """Return the sensed image on the grid of the reference, as a file holds it."""
    values = registration.resample(sensed.values, model, reference.grey.shape)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, path.name)
        try:
            registration.write(file, reference.with_values(values))
        except (ValueError, OSError) as error:
            raise type(error)(str(error).replace(str(file), str(path))) from None
        return file.read_bytes()


def _csv(found: Registration, reference: Raster) -> str:
    """Return all points with every digit, with their map coordinates if known."""
    if reference.transform is None:
        return found.csv()
    on_map = [f"{x!r},{y!r}" for x, y in reference.map(found.points).tolist()]
    places, lines = ("x on the map,y on the map", *on_map), []
    for row, place in zip(found.csv().splitlines(), places):
        *at, rest = row.split(",", 3)  # behind number, column and row
        lines.append(",".join([*at, place, rest]))
    return "\n".join([*lines, ""])
