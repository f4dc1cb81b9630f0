"""Links inside the text of a page: terms to the glossary, names to the reference."""

import re

from docutils import nodes
from sphinx.application import Sphinx

from pgm_book.make.site import api
from pgm_lab import datasets

# Words in these are left as they are.
CLOSED = (
    nodes.literal,
    nodes.literal_block,
    nodes.math,
    nodes.math_block,
    nodes.raw,
    nodes.reference,
    nodes.title,
)


def setup(app: Sphinx) -> None:
    """Link the pages once all of them have been read."""
    app.connect("doctree-resolved", link)


def link(app: Sphinx, tree: nodes.document, page: str) -> None:
    """Link the first use of each term in a chapter, and all names of functions."""
    if page.startswith("chapters/"):
        link_terms(app, tree, page)
    if page.startswith(("chapters/", "guides/")):
        link_names(app, tree, page)


def link_terms(app: Sphinx, tree: nodes.document, page: str) -> None:
    """Turn the first use of each term into a link with its meaning."""
    to_glossary = app.builder.get_relative_uri(page, "glossary")
    labels = {
        name: label
        for name, _, kind, _, label, _ in app.env.domains["std"].get_objects()
        if kind == "term"
    }
    left = {row["english"].lower(): row for row in datasets.rows("glossary.csv")}
    longest_first = sorted(left, key=len, reverse=True)
    words = "|".join(map(re.escape, longest_first))
    term = re.compile(rf"(?<![\w-])(?:{words})(?![\w-])", re.IGNORECASE)
    for text in list(tree.findall(nodes.Text)):
        if _inside(text, CLOSED):
            continue
        pieces: list[nodes.Node] = []
        end = 0
        for found in term.finditer(text):
            row = left.pop(found[0].lower(), None)
            if row is None:
                continue
            pieces += [nodes.Text(text[end : found.start()])]
            pieces += [
                nodes.reference(
                    "",
                    found[0],
                    internal=True,
                    refuri=f"{to_glossary}#{labels[row['english']]}",
                    reftitle=f"{row['indonesian']}: {row['meaning']}",
                    classes=["pgm-term"],
                )
            ]
            end = found.end()
        if pieces:
            text.parent.replace(text, [*pieces, nodes.Text(text[end:])])


def link_names(app: Sphinx, tree: nodes.document, page: str) -> None:
    """Turn names of notebooks, and of what the reference describes, into links."""
    known = api.public_names()
    for literal in list(tree.findall(nodes.literal)):
        if _inside(literal, (nodes.reference, nodes.title)):
            continue
        name = literal.astext().partition("(")[0]
        if f"chapters/{name}" in app.env.all_docs:
            target = app.builder.get_relative_uri(page, f"chapters/{name}")
        else:
            full = f"pgm_lab.{name.removeprefix('pgm_lab.')}"
            if full not in known:
                continue
            target = f"{app.builder.get_relative_uri(page, known[full])}#{full}"
        reference = nodes.reference("", "", internal=True, refuri=target)
        literal.replace_self(reference)
        reference += literal


def _inside(node: nodes.Node, kinds: tuple[type[nodes.Node], ...]) -> bool:
    while node.parent is not None:
        node = node.parent
        if isinstance(node, kinds):
            return True
    return False
