"""Check that a page carries everything with it and describes every picture."""

import base64
import mimetypes
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote

import tinycss2
from bs4 import BeautifulSoup, Tag
from bs4.element import Doctype, PageElement, PreformattedString

from pgm_book.make import allowed

# nbconvert writes this where an output has no alternative text.
_FILLER = "No description has been provided for this image"


class Problem(NamedTuple):
    """Something wrong with a page; `cell` is the id of the cell, if in one."""

    cell: str | None
    text: str


def embed_images(html: str, folder: Path) -> str:
    """Put the picture files that a page refers to, below `folder`, into the page.

    Comments are dropped. What comes back is written anew from the elements that were
    understood here, so that a browser understands the same.
    """
    # nbconvert's own option closes a <details> around markdown too early.
    soup = BeautifulSoup(html, "html.parser")
    folder = Path(folder).resolve()
    for image in soup.find_all("img", src=lambda src: src and ":" not in src):
        path = (folder / unquote(str(image["src"]))).resolve()
        if path.is_relative_to(folder) and path.is_file():
            kind = mimetypes.guess_type(path.name)[0]
            data = base64.b64encode(path.read_bytes()).decode()
            image["src"] = f"data:{kind};base64,{data}"
    for comment in soup.find_all(string=_is_comment):
        comment.extract()
    return str(soup)


def problems(html: str, scripts: Collection[str] = ()) -> list[Problem]:
    """List what a page may not hold, and its pictures without alternative text.

    Parameters
    ----------
    html : str
        The page.
    scripts : collection of str
        The scripts that are our own; every other one is refused.
    """
    soup = BeautifulSoup(html, "html.parser")
    ours = {script.strip() for script in scripts}
    found = []
    for element in soup.find_all(True):
        if element.name == "script":
            texts = _script_problems(element, ours)
        else:
            texts = _element_problems(element)
        found += [Problem(_cell(element), text) for text in texts]
    for text in soup.find_all(string=True):
        found += [Problem(_cell(text), said) for said in _text_problems(text)]
    return found


def _script_problems(element: Tag, ours: set[str]) -> Iterator[str]:
    """Say if a script is not one of ours, to the letter."""
    if element.attrs or element.get_text().strip() not in ours:
        yield "a script may not be in a page"


def _element_problems(element: Tag) -> Iterator[str]:
    """Say what is wrong with one element, without its contents."""
    if element.name not in allowed.ELEMENTS:
        yield f"<{element.name}> may not be in a page"
        return
    for name, value in element.attrs.items():
        value = " ".join(value) if isinstance(value, list) else str(value)
        if not allowed.attribute(element.name, name):
            yield f"<{element.name} {name}={value[:80]!r}> may not be in a page"
        elif not allowed.address(element.name, name, value):
            yield f"<{element.name} {name}={value[:80]!r}> is not in the file"
    yield from _css_problems(str(element.get("style", "")))
    if element.name == "style":
        yield from _css_problems(element.get_text())
    alt = str(element.get("alt", "")).strip()
    if element.name == "img" and alt in ("", _FILLER):
        yield "a picture has no alternative text (alt)"


def _text_problems(text: PageElement) -> Iterator[str]:
    """Say what is wrong with a piece of text that a reader sees."""
    if _is_comment(text):
        yield f"<!{str(text)[:40]!r}> may not be in a page"
    # MathJax leaves code alone.
    formula = allowed.FORMULA.search(text)
    if formula and not text.find_parent(["script", "style", "pre", "code"]):
        yield f"a formula uses {formula.group()}"


def _css_problems(css: str) -> Iterator[str]:
    """Say what a style may not use."""
    yield from _token_problems(tinycss2.parse_component_value_list(css))


def _token_problems(tokens: list) -> Iterator[str]:
    for token in tokens:
        if token.type == "error":
            yield f"a style cannot be read: {token.message}"
        elif token.type == "url" and not allowed.STYLE_PICTURE.match(token.value):
            yield f"a style fetches {token.value[:80]!r}"
        elif token.type == "at-keyword" and token.lower_value not in allowed.AT_RULES:
            yield f"a style uses @{token.value}"
        elif token.type == "function":
            if token.lower_name not in allowed.FUNCTIONS:
                yield f"a style uses {token.name}()"
            yield from _token_problems(token.arguments)
        elif token.type.endswith("block"):
            yield from _token_problems(token.content)


def _is_comment(text) -> bool:
    """Whether a browser may read it in another way than we do: <!-->, <![CDATA[."""
    return isinstance(text, PreformattedString) and not isinstance(text, Doctype)


def _cell(element: PageElement) -> str | None:
    """Return the id of the notebook cell that an element belongs to."""
    parent = element.find_parent(attrs={"data-cell": True})
    return str(parent["data-cell"]) if parent else None
