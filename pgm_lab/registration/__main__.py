"""The command line: python -m pgm_lab.registration, from two images to a report."""

import argparse
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from pgm_lab import _command, registration
from pgm_lab._command import REPORTS, TABLES, Output, Parser
from pgm_lab.io import geotiff as _geotiff
from pgm_lab.io.files import printable
from pgm_lab.registration.model import NAMES
from pgm_lab.report import registration as report
from pgm_lab.report._registration_case import say
from pgm_lab.report._registration_tables import SETTINGS, csv
from pgm_lab.report._statuses import advice, lost

NUMBER = 100  # points that are picked
RASTERS = (".tif", ".tiff")
STEPS = "reading", "registering", "resampling", "reporting"
NUMBERS = "chip", "radius", "threshold", "largest_sd", "smooth"
REFINE = {"none": None, "parabola": "parabola", "lsm": "lsm"}
NO_MEMORY = (
    "there is not enough memory for these images: cut out the part that both show, or"
    " take fewer points"
)


@dataclass(frozen=True, eq=False)
class Pair:
    """Two images, and by how many pixels the sensed one is ahead."""

    reference: registration.Raster
    sensed: registration.Raster
    offset: np.ndarray


def main(arguments: Sequence[str] | None = None) -> int:
    """Register two images, print a short report, write long ones, a table, an image.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of the command line when missing.

    Returns
    -------
    int
        0: done; 1: a file is wrong or no point was accepted, as the message on the
        error output says. A wrong call raises SystemExit with 2.
    """
    call = parser()
    options = call.parse_args(arguments)
    _check(call, options)
    return _command.run(call.prog, lambda: _in_words_of_a_call(options), NO_MEMORY)


def _in_words_of_a_call(options: argparse.Namespace) -> None:
    """Run, and where an error names an argument of Python, name the option."""
    try:
        _run(options)
    except (ValueError, ImportError) as error:
        words = re.sub(r"\b(band|nodata)=", r"--\1 ", str(error))
        words = words.replace("in offset=(column, row)", "by --offset COLUMN ROW")
        raise ValueError(words) from None


def _run(options: argparse.Namespace) -> None:
    if _command.same(options.reference, options.sensed):
        raise ValueError(
            f"{options.reference} and {options.sensed} are the same file: two images of"
            " the same place are needed"
        )
    watched = sys.stderr.isatty()
    with tqdm(total=len(STEPS), disable=not watched, leave=False, unit="step") as bar:
        bar.set_description(STEPS[0])
        pair = _read(options)
        settings = _settings(options, pair)
        bar.update()
        bar.set_description(STEPS[1])
        found = _register(options, pair, settings)
        model = _model(options, found, pair.offset)
        bar.update()
        bar.set_description(STEPS[2])
        pages: dict[Path, str | bytes] = {}
        if options.resampled is not None:
            pages[options.resampled] = _resampled(pair, model, options.resampled)
        bar.update()
        bar.set_description(STEPS[3])
        names = (printable(path.name) for path in (options.reference, options.sensed))
        words: dict[str, Any] = {
            "model": model,
            "pixel_size": options.pixel_size,
            "settings": settings,
            "about": "Reference image {}, sensed image {}.".format(*names),
        }
        # All of them before the first is written: nothing half done
        both = found, pair.reference, pair.sensed
        for path in options.report:
            write = report.text if path.suffix.lower() == ".txt" else report.html
            pages[path] = write(*both, **words)
        if options.csv is not None:
            pages[options.csv] = csv(found, pair.reference)
        short = report.text(*both, **words, short=True)
        bar.update()
    _command.finish(pages, options.force, short)


def _read(options: argparse.Namespace) -> Pair:
    """Read both images, and how their pixels lie to each other on the map."""
    reference, sensed = (
        registration.read(path, options.band, nodata=options.nodata)
        for path in (options.reference, options.sensed)
    )
    if options.pixel_size is not None and reference.pixel_size is not None:
        size = " x ".join(f"{one:g}" for one in reference.pixel_size)
        raise ValueError(
            f"{printable(options.reference)} says that its pixels have {size} m: leave"
            " out --pixel-size"
        )
    if options.offset is None:
        return Pair(reference, sensed, registration.offset(reference, sensed))
    return Pair(reference, sensed, np.array(options.offset))


def _settings(options: argparse.Namespace, pair: Pair) -> dict[str, Any]:
    """What the registration is asked for, points among it."""
    asked = {name: getattr(options, name) for name in NUMBERS}
    settings = {name: value for name, value in asked.items() if value is not None}
    settings["refine"] = REFINE[options.refine]
    if options.offset is not None or pair.reference.transform is not None:
        settings["offset"] = pair.offset
    if options.points is not None:
        return {"points": registration.read_points(options.points), **settings}
    if options.map_points is not None:
        points = registration.read_points(options.map_points, pair.reference)
        return {"points": points, **settings}
    if options.grid is not None:
        return {"grid": options.grid, **settings}
    return {"number": options.number or NUMBER, **settings}


def _register(
    options: argparse.Namespace, pair: Pair, settings: dict[str, Any]
) -> registration.Registration:
    """Register the points that were given, lie on a grid, or are picked."""
    asked = {k: v for k, v in settings.items() if k not in ("number", "grid")}
    found = registration.register(
        pair.reference.values,
        pair.sensed.values,
        **({"points": _points(pair, settings)} | asked),
    )
    if not np.any(found.accepted):
        raise ValueError(_none(found))
    return found


def _points(pair: Pair, settings: dict[str, Any]) -> np.ndarray:
    """Points on a grid, or picked where there is texture and both images have data."""
    window = {name: settings.get(name) for name in ("chip", "radius")}
    defaults = {"chip": 21, "radius": 3}
    chip, radius = (window[name] or defaults[name] for name in ("chip", "radius"))
    grey, sensed = pair.reference.values, pair.sensed.values
    if "points" in settings:
        return settings["points"]
    if "grid" in settings:
        return registration.grid(grey.shape, settings["grid"], chip // 2 + radius)
    points = registration.pick(
        grey, settings["number"], chip, radius, sensed=sensed, offset=pair.offset
    )
    if not len(points):
        raise ValueError(
            "there is no texture in what both images show: give points, or a smaller"
            " chip"
        )
    return points


def _none(found: registration.Registration) -> str:
    """Say that nothing was accepted, why, and what to check."""
    (status, number), *_ = lost(found)
    return (
        f"none of {len(found.points)} points was accepted; most often ({number}) the"
        f' reason is "{say(status)}": {advice(status, say)} Do both images show the'
        " same place, in the same band, neither turned nor scaled? Are they farther"
        " apart than --radius? --offset COLUMN ROW says where to begin"
    )


def _model(
    options: argparse.Namespace, found: registration.Registration, offset: np.ndarray
) -> registration.Model | None:
    """One transformation for the whole image; none from too few points."""
    try:
        return registration.fit(found, options.model, offset=offset)
    except ValueError:
        if options.resampled is not None:
            raise
        return None


def _resampled(pair: Pair, model: registration.Model | None, path: Path) -> bytes:
    """Return the sensed image on the grid of the reference, as a file holds it."""
    assert model is not None  # or `_model` had raised
    values = registration.resample(pair.sensed.values, model, pair.reference.grey.shape)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, path.name)
        try:
            registration.write(file, pair.reference.with_values(values))
        except (ValueError, OSError) as error:
            raise type(error)(str(error).replace(str(file), str(path))) from None
        return file.read_bytes()


def _check(call: Parser, options: argparse.Namespace) -> None:
    """Refuse before the work what would go wrong after it."""
    inputs = [options.reference, options.sensed]
    given = options.points, options.map_points
    inputs += [path for path in given if path is not None]
    outputs = [Output("--report", path, REPORTS) for path in options.report]
    if options.csv is not None:
        outputs.append(Output("--csv", options.csv, TABLES))
    if options.resampled is not None:
        outputs.append(Output("--resampled", options.resampled, RASTERS))
    _command.check_outputs(call, outputs, inputs, options.force)
    if options.resampled is not None and not _geotiff.installed():
        call.error(f"--resampled needs rasterio: {_geotiff.INSTALL}")


def parser() -> Parser:
    """Return the parser of the command line."""
    found = Parser(
        prog="python -m pgm_lab.registration",
        description="How far a sensed image lies off a reference image of the same"
        " place, and how sure that is. GeoTIFF where rasterio is installed; PNG, TIFF"
        " and JPEG without a place on the map; 8 or 16 bit.",
        epilog="Shifts are sensed minus reference, columns to the right and rows down.",
    )
    found.add_argument("reference", type=Path, help="image that is taken as right")
    found.add_argument("sensed", type=Path, help="image that is compared with it")
    where = found.add_mutually_exclusive_group()
    where.add_argument(
        "--points",
        type=Path,
        metavar="FILE",
        help="points of the reference image: column row, one a line",
    )
    where.add_argument(
        "--map-points",
        type=Path,
        metavar="FILE",
        help="the same as x y on its map",
    )
    where.add_argument(
        "--grid", type=_command.whole, metavar="STEP", help=SETTINGS["grid"]
    )
    where.add_argument(
        "--number",
        type=_command.whole,
        metavar="N",
        help=f"{SETTINGS['number']}; {NUMBER} when missing",
    )
    kinds: dict[str, dict] = {
        "chip": {"type": _command.odd, "metavar": "PX"},
        "radius": {"type": _command.whole, "metavar": "PX"},
        "refine": {"choices": tuple(REFINE), "default": "lsm"},
        "threshold": {"type": _command.share, "metavar": "R"},
        "largest_sd": {"type": _command.positive, "metavar": "PX"},
        "smooth": {"type": _command.number, "metavar": "PX"},
        "offset": {"type": _command.number, "nargs": 2, "metavar": ("COLUMN", "ROW")},
    }
    for name, kind in kinds.items():
        option = "--" + name.replace("_", "-")
        found.add_argument(option, dest=name, help=SETTINGS[name], **kind)
    found.add_argument(
        "--model",
        choices=tuple(NAMES),
        default="shift",
        help="what is fitted to the shifts of the points: one shift for all, or scales,"
        " turn and shear too",
    )
    found.add_argument(
        "--band", type=_command.whole, metavar="N", help="band to read, from 1"
    )
    found.add_argument(
        "--nodata",
        type=_command.number,
        metavar="VALUE",
        help="grey value that is no data",
    )
    found.add_argument(
        "--pixel-size",
        type=_command.positive,
        metavar="METRES",
        help="of the reference image, where the file does not say it",
    )
    _command.add_outputs(found)
    _command.add_csv(found)
    found.add_argument(
        "--resampled",
        type=Path,
        metavar="FILE",
        help="write the sensed image in the pixels of the reference image, as GeoTIFF",
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
