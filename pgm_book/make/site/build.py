"""Make the source pages of the site anew, and run Sphinx on them."""

import shutil
from collections.abc import Iterable
from pathlib import Path

from pgm_book.make.errors import PublishError
from pgm_book.make.site import (
    api,
    equations,
    glossary,
    guides,
    notebooks,
    sources,
    start,
    verdicts,
)


def build(chapters: Iterable[Path], folder: Path) -> Path:
    """Write the site into ``folder/site``; return its first page."""
    source, site = Path(folder) / "site-source", Path(folder) / "site"
    for made in (source, site):
        shutil.rmtree(made, ignore_errors=True)
    source.mkdir(parents=True)
    write_sources(chapters, source)
    _run_sphinx(source, site)
    return site / "index.html"


def write_sources(chapters: Iterable[Path], source: Path) -> None:
    """Write all pages as Sphinx reads them."""
    pages = {
        "chapters": notebooks.write(list(chapters), source),
        "guides": guides.write(source),
        "verdicts": verdicts.write(source),
        "equations": equations.write(source),
        "glossary": glossary.write(source),
        "reference": api.write(source),
        "proofs": sources.write(source),
    }
    start.write(source, pages)


def _run_sphinx(source: Path, site: Path) -> None:
    """Run Sphinx; a warning of it is an error here."""
    from sphinx.application import Sphinx

    app = Sphinx(
        source,
        Path(__file__).parent,
        site,
        source / ".doctrees",
        "html",
        confoverrides={"html_extra_path": [str(source / "files")]},
        status=None,
    )
    app.build()
    if app.statuscode or app._warncount:
        raise PublishError("the site has the faults listed above.")
    # It depends on the folder, and the site is made anew; and a template of the theme
    for name in (".buildinfo", "_static/webpack-macros.html"):
        (site / name).unlink()
