"""Turn a notebook into one HTML page that needs nothing else."""

import copy
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import nbformat
from mistune import import_plugin
from nbconvert import HTMLExporter, SlidesExporter
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbformat import NotebookNode

from pgm_book.make import assets, deck, paper, prepare
from pgm_book.make.errors import PublishError
from pgm_book.make.selfcontained import embed_images, problems
from pgm_book.make.student import name

TEMPLATES = Path(__file__).parent / "templates"


def slides_page(path: Path, audience: prepare.Audience = "lecturer") -> str:
    """Return the slides of a notebook as one self-contained HTML page.

    Parameters
    ----------
    path : Path
        An executed notebook.
    audience : "lecturer" or "student"
        Notes, their window and the answers to the quick questions are the lecturer's.
    """
    exporter = SlidesExporter(
        template_name="pgm_slides", extra_template_basedirs=[str(TEMPLATES)]
    )
    files = assets.slides_assets()
    if audience == "student":
        del files["notes_js"]
    stem = Path(path).stem
    prepared = partial(prepare.for_slides, audience=audience, stem=stem)
    return _page(exporter, path, prepared, files)


def handout_page(path: Path) -> str:
    """Return the handout of a notebook as one self-contained HTML page."""
    exporter = HTMLExporter(
        template_name="pgm_handout", extra_template_basedirs=[str(TEMPLATES)]
    )
    return _page(exporter, path, paper.for_handouts, assets.handout_assets())


def _page(exporter: HTMLExporter, path: Path, prepared: Callable, files: dict) -> str:
    """Convert and check; a picture without alt text or out of reach is an error."""
    exporter.register_filter("markdown2html", _markdown)
    path = Path(path)
    notebook = nbformat.read(path, as_version=4)
    _refuse_unexecuted(path, notebook)
    resources = {
        "metadata": {"name": path.stem, "path": str(path.parent)},
        "pgm": {"title": prepare.title(notebook), **files},
    }
    try:
        # A copy, because nbconvert marks the cells of slides in place.
        page, _ = exporter.from_notebook_node(
            prepared(copy.deepcopy(notebook)), resources=resources
        )
    except ValueError as error:
        raise PublishError(f"{path.name}, {error}") from error
    page = embed_images(page, path.parent)
    _refuse_problems(path, notebook, page, own_scripts(files))
    return page


def own_scripts(files: dict) -> list[str]:
    """Return the texts of all scripts that a page of ours may hold."""
    own = [path.read_text(encoding="utf-8") for path in TEMPLATES.rglob("*.js")]
    return own + [text for name, text in files.items() if name.endswith("_js")]


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


def _refuse_unexecuted(path: Path, notebook: NotebookNode) -> None:
    for cell in notebook.cells:
        if cell.cell_type == "code" and cell.source and not cell.execution_count:
            raise PublishError(
                f"{path.name}, {name(cell)} has not been run, so its results would be "
                "missing. Run and save the whole notebook first: make notebooks"
            )


def _refuse_problems(
    path: Path, notebook: NotebookNode, page: str, scripts: list[str]
) -> None:
    cells = {cell.get("id"): cell for cell in notebook.cells}
    lines = []
    for cell, text in problems(page, scripts):
        origin = cells.get(deck.origin(cell or ""))
        lines.append((f"{name(origin)}: " if origin else "") + text)
    if lines:
        raise PublishError(
            "\n  ".join([f"{path.name} cannot be published:", *lines])
            + "\nShow figures with pgm_lab.plot.show(fig, alt), and give pictures in "
            "text an alternative text and a file beside the notebook: ![alt](file). "
            "A page loads nothing: pgm_book/make/allowed.py lists what it may hold."
        )
