"""Turn a notebook into one HTML page that needs nothing else.

The JavaScript and CSS behind it are read from installed Python packages, pictures
become a part of the page, and its content security policy lets a browser load nothing.
"""

import base64
import copy
import mimetypes
import re
from collections.abc import Callable, Iterator
from functools import partial
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from urllib.parse import unquote

import nbformat
from bs4 import BeautifulSoup, Tag
from mistune import import_plugin
from nbconvert import HTMLExporter, SlidesExporter
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbformat import NotebookNode

from pgm_book.make import handouts, slides
from pgm_book.make.errors import PublishError, missing
from pgm_book.make.student import name

Prepared = Callable[[NotebookNode], NotebookNode]
TEMPLATES = Path(__file__).parent / "templates"

# Two wheels carry the files: neither Node nor a copy in this repository is needed.
REVEAL = ("sphinx-revealjs", "sphinx_revealjs/_static/revealjs/")
MATHJAX = ("sphinx-mathjax-offline", "sphinx-mathjax-offline/static/mathjax/")

# What loads, or leads a reader to another page; the policy refuses the rest.
LOADING = ["script", "iframe", "object", "embed", "link", "base", "meta", "form"]
# nbconvert writes this where an output has no alternative text.
FILLER = "No description has been provided for this image"


def slides_page(path: Path, audience: slides.Audience = "lecturer") -> str:
    """Return the slides of an executed notebook as one self-contained HTML page.

    Notes, their window and the answers to the quick questions are the lecturer's.
    """
    files = {
        "reveal_css": asset(*REVEAL, "dist/reveal.css"),
        "reveal_js": asset(*REVEAL, "dist/reveal.js"),
    }
    if audience == "lecturer":
        files["notes_js"] = asset(*REVEAL, "plugin/notes/notes.js")
    stem = Path(path).stem
    prepared = partial(slides.for_slides, audience=audience, stem=stem)
    return _page(SlidesExporter, "pgm_slides", path, prepared, files)


def handout_page(
    path: Path, prepared: Prepared = handouts.for_handouts, title: str = ""
) -> str:
    """Return the handout of a notebook as one self-contained HTML page.

    `prepared` chooses what else is printed, under another title.
    """
    return _page(HTMLExporter, "pgm_handout", path, prepared, {}, title)


def _page(
    exporter: type[HTMLExporter],
    template: str,
    path: Path,
    prepared: Prepared,
    files: dict[str, str],
    title: str = "",
) -> str:
    """Convert and check; a picture without alt text or out of reach is an error."""
    path = Path(path)
    notebook = nbformat.read(path, as_version=4)
    _refuse_unexecuted(path, notebook)
    files["mathjax_js"] = asset(*MATHJAX, "tex-svg-full.js")
    converter = exporter(
        template_name=template, extra_template_basedirs=[str(TEMPLATES)]
    )
    converter.register_filter("markdown2html", _markdown)
    try:
        # A copy, because nbconvert marks the cells of slides in place.
        ready = prepared(copy.deepcopy(notebook))
    except ValueError as error:
        raise PublishError(f"{path.name}, {error}") from error
    resources = {
        "metadata": {"name": path.stem, "path": str(path.parent)},
        "pgm": {"title": title or slides.title(notebook), **files},
    }
    page, _ = converter.from_notebook_node(ready, resources=resources)
    # nbconvert's own option closes a <details> around markdown too early.
    soup = BeautifulSoup(page, "html.parser")
    _embed_pictures(soup, path.parent)
    _refuse_problems(path, notebook, soup)
    return str(soup)


def asset(package: str, folder: str, file: str) -> str:
    """Return the text of a file that comes with an installed package."""
    try:
        path = distribution(package).locate_file(folder + file)
        return path.read_text(encoding="utf-8")
    except (PackageNotFoundError, FileNotFoundError) as error:
        raise missing(package, f"{file} is missing: it comes with ") from error


def _markdown(source: str) -> str:
    """Return HTML as nbconvert does, and tables in boxes and lists as Jupyter does."""
    renderer = IPythonRenderer(escape=False, exclude_anchor_links=True)
    plugins = [
        *MarkdownWithMath.DEFAULT_PLUGINS,
        "mistune.plugins.table.table_in_quote",
        "mistune.plugins.table.table_in_list",
    ]
    markdown = MarkdownWithMath(renderer, plugins=map(import_plugin, plugins))
    # An empty corner of a table heads nothing.
    return re.sub(r"<th\b[^>]*></th>", "<td></td>", markdown.render(source))


def _embed_pictures(soup: BeautifulSoup, folder: Path) -> None:
    """Put the picture files that a page refers to, below `folder`, into the page."""
    folder = folder.resolve()
    for image in soup.find_all("img", src=lambda src: src and ":" not in src):
        path = (folder / unquote(str(image["src"]))).resolve()
        if path.is_relative_to(folder) and path.is_file():
            kind = mimetypes.guess_type(path.name)[0]
            data = base64.b64encode(path.read_bytes()).decode()
            image["src"] = f"data:{kind};base64,{data}"


def _refuse_unexecuted(path: Path, notebook: NotebookNode) -> None:
    for cell in notebook.cells:
        if cell.cell_type == "code" and cell.source and not cell.execution_count:
            raise PublishError(
                f"{path.name}, {name(cell)} has not been run, so its results would be "
                "missing. Run and save the whole notebook first: make notebooks"
            )


def _refuse_problems(path: Path, notebook: NotebookNode, soup: BeautifulSoup) -> None:
    """Name the cells that would show a picture badly, or load what is elsewhere."""
    cells = {cell.get("id"): cell for cell in notebook.cells}
    lines = []
    for place in soup.find_all(attrs={"data-cell": True}):
        origin = cells.get(slides.origin(str(place["data-cell"])))
        called = f"{name(origin)}: " if origin else ""
        lines += [called + said for said in problems(place)]
    if lines:
        raise PublishError(
            "\n  ".join([f"{path.name} cannot be published:", *lines])
            + "\nShow figures with pgm_lab.plot.show(fig, alt), and give pictures in "
            "text an alternative text and a file beside the notebook: ![alt](file). "
            "A page loads nothing."
        )


def problems(place: Tag) -> Iterator[str]:
    """Say which pictures are not described or not in the page, and what would load."""
    for image in place.find_all("img"):
        if str(image.get("alt", "")).strip() in ("", FILLER):
            yield "a picture has no alternative text (alt)"
        if not str(image.get("src", "")).startswith("data:image/"):
            yield f"the picture {str(image.get('src'))[:80]!r} is not in the file"
    for element in place.find_all(LOADING):
        yield f"<{element.name}> may not be in a page"
