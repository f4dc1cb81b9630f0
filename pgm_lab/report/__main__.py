"""The command line: python -m pgm_lab.report, from four text files to a report."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pgm_lab import bundle, report
from pgm_lab.bundle._numbers import save
from pgm_lab.camera import LENSES, PARAMETERS

DONE, FAILED = 0, 1  # argparse itself ends with 2 when it is called wrongly
WRITERS = {
    ".html": report.html,
    ".htm": report.html,
    ".txt": report.text,
}


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
    parser = _parser()
    options = parser.parse_args(arguments)
    _check_reports(parser, options)
    try:
        _run(options)
    except (ValueError, OSError, ArithmeticError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        print(f"{parser.prog}: interrupted", file=sys.stderr)
        return FAILED
    return DONE


def _run(options: argparse.Namespace) -> None:
    files = (options.interior, options.exterior, options.points, options.image)
    network = bundle.read(*files, lens=options.lens, sigma=options.sigma)
    settings = {"estimate": options.estimate, "datum": options.datum}
    settings["progress"] = sys.stderr.isatty()
    found: bundle.Bundle | bundle.Snooping
    if options.snoop:
        found = bundle.snoop(network, **settings)
        result = found.result
    else:
        found = result = bundle.adjust(network, **settings)
    if result.status != "converged":
        raise ArithmeticError(
            f"the adjustment did not converge ({result.status} after"
            f" {result.iterations} iterations), so there is nothing to report. Check"
            " start values and ids, and that x points right and y up in the image; or"
            " estimate fewer parameters"
        )
    about = f"From {', '.join(path.name for path in files)}."
    # All of them before the first is written: nothing half done
    pages = [
        WRITERS[path.suffix.lower()](found, about=about) for path in options.report
    ]
    for path, page in zip(options.report, pages):
        save(path, page, overwrite=options.force)
    if hasattr(sys.stdout, "reconfigure"):  # a console without µ shows a ? for it
        sys.stdout.reconfigure(errors="replace")
    print(report.text(found, about=about, short=True))


def _check_reports(
    parser: argparse.ArgumentParser, options: argparse.Namespace
) -> None:
    """Refuse before the work what would go wrong after it."""
    inputs = [options.interior, options.exterior, options.points, options.image]
    seen = {path.resolve() for path in inputs}
    for path in options.report:
        if path.suffix.lower() not in WRITERS:
            parser.error(f"--report {path}: the name must end in {', '.join(WRITERS)}")
        if path.resolve() in seen:
            parser.error(f"--report {path}: an input, or another report, has this name")
        seen.add(path.resolve())
        if not path.parent.is_dir():
            parser.error(f"--report {path}: there is no folder {path.parent}")
        if path.exists() and not options.force:
            parser.error(f"--report {path}: it exists already; --force replaces it")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m pgm_lab.report",
        description="Self-calibrating bundle adjustment of a free network, from four"
        " text files of numbers. White space, commas or semicolons separate columns, %"
        " starts a comment.",
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
        parser.add_argument(name, type=Path, help=columns)
    parser.add_argument(
        "--report",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="write the whole report, as .html or .txt; may be given several times",
    )
    parser.add_argument(
        "--force", action="store_true", help="replace reports that exist already"
    )
    parser.add_argument(
        "--estimate",
        type=_parameters,
        default=PARAMETERS,
        metavar="c,x0,...",
        help="parameters of the camera to estimate, or none; all ten when missing",
    )
    parser.add_argument(
        "--lens",
        choices=LENSES,
        default="backward",
        help="lens model: corrects measured coordinates, or displaces ideal ones",
    )
    parser.add_argument(
        "--datum",
        choices=("inner", "photos"),
        default="inner",
        help="inner constraints on the points, or on the projection centres",
    )
    parser.add_argument(
        "--snoop", action="store_true", help="take out blunders, one ray at a time"
    )
    parser.add_argument(
        "--sigma",
        type=_positive,
        metavar="MM",
        help="standard deviation of all image coordinates, in place of sx and sy",
    )
    return parser


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
        raise argparse.ArgumentTypeError(f"{word!r} is not a number above zero")
    return value


if __name__ == "__main__":
    sys.exit(main())
