"""What Sphinx makes of the source pages."""

from importlib.metadata import distribution

from docutils import nodes
from sphinx.application import Sphinx

project = "pgm_lab"
author = "the pgm_lab authors"
copyright = "the pgm_lab authors; text and figures CC BY 4.0"
language = "en"
smartquotes = False  # text is found as it was written

extensions = [
    "myst_nb",
    "sphinx_design",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx.ext.mathjax",
    "pgm_book.make.site.api",
    "pgm_book.make.site.links",
    "pgm_book.make.site.verdicts",
]
exclude_patterns = [".doctrees", "files"]
templates_path: list[str] = []

# The notebooks are shown as they were stored.
nb_execution_mode = "off"
nb_code_prompt_show = "Show the code"
nb_code_prompt_hide = "Hide the code"
nb_ipywidgets_js: dict[str, dict] = {}
nb_render_markdown_format = "myst"
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "attrs_inline"]

html_theme = "pydata_sphinx_theme"
html_title = "pgm_lab"
html_static_path = ["static"]
html_favicon = "static/icon.svg"
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_show_sourcelink = False
html_copy_source = False
# Pages opened as files may not read each other, and a summary would be read so.
html_show_search_summary = False
html_context = {"default_mode": "auto"}
# Pages without others below them
html_sidebars: dict[str, list[str]] = {
    page: [] for page in ("index", "glossary", "verdicts", "equations")
}
html_theme_options = {
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
    "show_version_warning_banner": False,
    "search_bar_text": "Search: a term, an equation (M 2.94), a function",
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}

# MathJax comes out of a wheel, in one file that loads nothing.
_mathjax = "sphinx-mathjax-offline/static/mathjax/tex-svg-full.js"
html_static_path.append(
    str(distribution("sphinx-mathjax-offline").locate_file(_mathjax))
)
mathjax_path = "tex-svg-full.js"
mathjax3_config = {"options": {"enableMenu": False}}

autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
default_role = "py:obj"


def setup(app: Sphinx) -> None:
    """Change the formulas of each page once it has been read."""
    app.connect("doctree-read", keep_numbers)


def keep_numbers(_: Sphinx, tree: nodes.document) -> None:
    """Leave a numbered formula as it is: Sphinx would put it into `split`."""
    for formula in tree.findall(nodes.math_block):
        if r"\tag" in formula.astext():
            written = rf"\begin{{equation}}{formula.astext()}\end{{equation}}"
            formula.children = [nodes.Text(written)]
            formula["nowrap"] = formula["no-wrap"] = True
