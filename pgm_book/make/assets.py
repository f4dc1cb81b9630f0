"""The JavaScript and CSS behind the slides, read from installed Python packages.

Neither Node nor a copy in this repository is needed: two wheels carry the files.
"""

from importlib.metadata import PackageNotFoundError, distribution

from pgm_book.make.errors import PublishError

_REVEAL = ("sphinx-revealjs", "sphinx_revealjs/_static/revealjs/")
_MATHJAX = ("sphinx-mathjax-offline", "sphinx-mathjax-offline/static/mathjax/")


def slides_assets() -> dict[str, str]:
    """Return the texts that a slides file inlines, by their short names."""
    return {
        "reveal_css": _read(*_REVEAL, "dist/reveal.css"),
        "reveal_js": _read(*_REVEAL, "dist/reveal.js"),
        "notes_js": _read(*_REVEAL, "plugin/notes/notes.js"),
        **handout_assets(),
    }


def handout_assets() -> dict[str, str]:
    """Return the texts that a handout page inlines."""
    return {"mathjax_js": _read(*_MATHJAX, "tex-svg-full.js")}


def _read(package: str, folder: str, name: str) -> str:
    try:
        path = distribution(package).locate_file(folder + name)
        return path.read_text(encoding="utf-8")
    except (PackageNotFoundError, FileNotFoundError) as error:
        raise PublishError(
            f"{name} is missing: it comes with the Python package {package}. "
            'Install what publishing needs with: pip install -e ".[publish]"'
        ) from error
