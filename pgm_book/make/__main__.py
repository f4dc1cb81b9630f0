"""Command line: ``python -m pgm_book.make WHAT [NAME ...]``."""

import argparse
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import nbformat

from pgm_book.make import form
from pgm_book.make.environment import ROOT
from pgm_book.make.errors import PublishError, missing
from pgm_book.make.student import write_copies
from pgm_lab.io.files import save


def main(arguments: list[str] | None = None) -> int:
    """Publish and say what was written; return 1 if something was wrong."""
    parser = argparse.ArgumentParser(
        prog="python -m pgm_book.make", description=__doc__
    )
    parser.add_argument("what", choices=list(PUBLISHERS))
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="01 or 01_pixel_to_photo; all if none"
    )
    parser.add_argument("--notebooks", type=Path, default=ROOT / "notebooks")
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    parser.add_argument(
        "--format", choices=["nbgrader", "otter"], help="of the students' copies"
    )
    options = parser.parse_args(arguments)
    publisher = PUBLISHERS[options.what]
    if options.format:
        if options.what != "student":
            parser.error("--format is for the students' copies")
        publisher = partial(assignments, style=options.format)
    try:
        notebooks = form.choose(options.notebooks, options.names)
        for path in publisher(notebooks, options.build):
            print(path)
    except ModuleNotFoundError as error:
        print(f"publish: {missing(error.name)}", file=sys.stderr)
        return 1
    except (PublishError, ValueError) as error:
        print(f"publish: {error}", file=sys.stderr)
        return 1
    return 0


def slides(notebooks: list[Path], build: Path) -> Iterator[Path]:
    """Write ``build/slides/lecturer`` and ``student``; yield each path when done."""
    from pgm_book.make import sizes
    from pgm_book.make.page import slides_page
    from pgm_book.make.slides import faults, for_slides

    said: dict[Path, list[str]] = {}
    for path in notebooks:
        for audience in ("lecturer", "student"):
            target = build / "slides" / audience / f"{path.stem}.html"
            save({target: slides_page(path, audience)}, overwrite=True)
            yield target
        notebook = nbformat.read(path, as_version=4)
        said[path] = faults(for_slides(notebook, "lecturer", path.stem).cells)
    # All are written before any is refused, since a small label is best looked at.
    form.judge(said, "the slides are written, but they are not fit for a hall:")
    try:
        unreadable = sizes.of_decks(build / "slides" / "lecturer", notebooks)
    except PublishError as error:
        text = f"the sizes on the slides were not measured: {error}"
        print(f"publish: {text}", file=sys.stderr)
        return
    form.judge(
        unreadable,
        "the slides are written, but a hall cannot read all of them:",
        "Make the writing in a figure larger, or leave it more of the slide; "
        "divide what is too much for one slide.",
    )


def handouts(notebooks: list[Path], build: Path) -> Iterator[Path]:
    """Write ``build/handouts/*.pdf``; yield each path as it is done."""
    from pgm_book.make.browser import open_browser
    from pgm_book.make.handouts import faults, for_handouts, print_pdf
    from pgm_book.make.page import handout_page

    pages = {path: handout_page(path) for path in notebooks}
    said = {}
    with open_browser() as browser:
        for path, page in pages.items():
            pdf = print_pdf(browser, page)
            target = build / "handouts" / f"{path.stem}.pdf"
            save({target: pdf}, overwrite=True)
            yield target
            prepared = for_handouts(nbformat.read(path, as_version=4))
            said[path] = faults(pdf, prepared, form.form_of(path))
    form.judge(said, "the handouts are written, but are not fit for paper:")


def assignments(notebooks: list[Path], build: Path, style: str) -> list[Path]:
    """Write the assignments of another grader into ``build/nbgrader`` or ``otter``."""
    from pgm_book.course.assignments import write

    return write(notebooks, build, style)


def sizes(notebooks: list[Path], build: Path) -> Iterator[str]:
    """Yield the lines of a table: what is small, large or too much on each slide."""
    from pgm_book.make.sizes import report

    yield from report(notebooks)


def site(notebooks: list[Path], build: Path) -> Iterator[Path]:
    """Write the site into ``build/site``; yield its first page."""
    from pgm_book.make.site.build import build as build_site

    yield build_site(notebooks, build)


PUBLISHERS = {
    "slides": slides,
    "handouts": handouts,
    "student": write_copies,
    "sizes": sizes,
    "site": site,
}

if __name__ == "__main__":
    sys.exit(main())
