"""The verdicts on published numbers as one table that can be searched and filtered.

`write` puts the page among the sources of the site. The table in it is made when Sphinx
has the address of every function: this module is an extension of Sphinx too.
"""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import Directive
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape
from sphinx.application import Sphinx

from pgm_book.common import ledger
from pgm_book.make.site import api, sources
from pgm_lab import datasets

HERE = Path(__file__).parent
PAGE = "verdicts"

# The mark says the same as the word, for those who cannot distinguish the colours.
MARKS = {"reproduced": "=", "corrected": "≠", "not derivable": "?"}

TEXT = """\
---
html_theme.sidebar_secondary.remove: true
---

# The verdicts

Every number, formula and statement of the four sources that a chapter uses was
recomputed. A row says what is printed, what we get, and links to the test that proves
it. *Reproduced* means that we get what is printed; *corrected*, that something else
follows from the data or the derivation; *not derivable*, that the published information
does not suffice to decide. A correction has a cause where one could be found: the text
of the *author*, the *scan* that we read, or *unclear*. If you wrote one of the sources
and think that a verdict is wrong, open an issue with the row and what you know.

```{verdicts}
```
"""


@dataclass(frozen=True)
class Verdict:
    """A row of the ledger, with a name of its own for links."""

    anchor: str
    row: dict[str, str]

    @cached_property
    def equations(self) -> list[str]:
        """Its equations as docstrings cite them."""
        return ledger.equations(self.row)

    @cached_property
    def functions(self) -> list[str]:
        """Functions that implement the equation, by their names in the reference."""
        named = self.row["code"].split("; ")
        return [api.public_name(n) for n in named if n and not n.startswith("-")]

    @cached_property
    def note(self) -> str:
        """Why an equation has no function."""
        code = self.row["code"]
        return code.removeprefix("-: ") if code.startswith("-") else ""

    @property
    def mark(self) -> str:
        """A sign for the verdict."""
        return MARKS[self.row["verdict"]]


def all_verdicts() -> list[Verdict]:
    """All rows of the ledger, each with an anchor that no other row has."""
    seen: Counter[str] = Counter()
    found = []
    for row in ledger.verdicts():
        name = nodes.make_id(f"{row['source']} {row['place']}")
        seen[name] += 1
        anchor = name if seen[name] == 1 else f"{name}-{seen[name]}"
        found.append(Verdict(anchor, row))
    return found


def write(folder: Path) -> list[str]:
    """Write the page of the verdicts."""
    (folder / f"{PAGE}.md").write_text(TEXT, encoding="utf-8")
    return [PAGE]


class Table(nodes.General, nodes.Element):
    """Placeholder of the table."""


class Verdicts(Directive):
    """``{verdicts}``: the table of all verdicts."""

    def run(self) -> list[nodes.Node]:
        """Keep the place; the addresses are not known before all pages are read."""
        return [Table()]


def fill(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the table in its place, with links to functions, tests and chapters."""
    for place in list(doctree.findall(Table)):
        place.replace_self(nodes.raw("", html(app, page), format="html"))


def html(app: Sphinx, page: str) -> str:
    """The controls, the counts and the table."""
    verdicts = all_verdicts()
    rows = [verdict.row for verdict in verdicts]
    chapters = chapter_pages(app.env.found_docs)

    def address(target: str, anchor: str = "") -> str:
        uri = app.builder.get_relative_uri(page, target)
        return f"{uri}#{anchor}" if anchor else uri

    def function(name: str) -> str | None:
        documented = app.env.get_domain("py").objects.get(name)
        return documented and address(documented.docname, documented.node_id)

    def chapter(number: str) -> str | None:
        return address(chapters[number]) if number in chapters else None

    def test(name: str) -> str:
        return address(*sources.place(name))

    def equation(cited: str) -> str:
        return address("equations", nodes.make_id(cited))

    templates = Environment(
        loader=FileSystemLoader(HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters["breakable"] = breakable
    return templates.get_template("verdicts.html.j2").render(
        verdicts=verdicts,
        marks=MARKS,
        sources=sorted({row["source"] for row in rows}, key=lambda name: name[-4:]),
        kinds=sorted({row["kind"] for row in rows}),
        chapters=sorted({row["chapter"] for row in rows}),
        counts=Counter((row["source"], row["verdict"]) for row in rows),
        links={
            "function": function,
            "chapter": chapter,
            "test": test,
            "equation": equation,
        },
    )


def breakable(name: str, sign: str) -> Markup:
    """A long name that may be broken after each sign."""
    return Markup(f"{sign}<wbr>").join(escape(part) for part in name.split(sign))


def chapter_pages(pages: set[str]) -> dict[str, str]:
    """The page of each chapter; where a chapter has a case, the case."""
    by_name = {page.rpartition("/")[2]: page for page in pages}
    found = {}
    for row in datasets.rows("chapters.csv"):
        if row["notebook"] in by_name:
            number = row["number"]
            found[number.removesuffix("c") if row["form"] == "case" else number] = (
                by_name[row["notebook"]]
            )
    return found


def add_files(app: Sphinx, page: str, *_: object) -> None:
    """Give the pages that prove, and no others, their style and script."""
    if page in (PAGE, "equations") or page.startswith(sources.FOLDER):
        app.add_css_file("ledger.css")
    if page == PAGE:
        app.add_js_file("verdicts.js", loading_method="defer")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the table with Sphinx."""
    app.add_node(Table)
    app.add_directive("verdicts", Verdicts)
    app.connect("doctree-resolved", fill)
    app.connect("html-page-context", add_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
