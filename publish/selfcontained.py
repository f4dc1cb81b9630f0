"""Check that a page carries everything with it and describes every picture."""

import base64
import mimetypes
import re
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote

from bs4 import BeautifulSoup, Tag

# nbconvert writes this where an output has no alternative text.
_FILLER = "No description has been provided for this image"
_URL = re.compile(r"url\(\s*['\"]?(?!data:|#)([^)'\"]*)")


class Problem(NamedTuple):
    """Something wrong with a page; `cell` is the id of the cell, if in one."""

    cell: str | None
    text: str


def embed_images(html: str, folder: Path) -> str:
    """Put the picture files that a page refers to, below `folder`, into the page."""
    # nbconvert's own option closes a <details> around markdown too early.
    soup = BeautifulSoup(html, "html.parser")
    folder = Path(folder).resolve()
    for image in soup.find_all("img", src=lambda src: src and ":" not in src):
        path = (folder / unquote(str(image["src"]))).resolve()
        if path.is_relative_to(folder) and path.is_file():
            kind = mimetypes.guess_type(path.name)[0]
            data = base64.b64encode(path.read_bytes()).decode()
            image["src"] = f"data:{kind};base64,{data}"
    return str(soup)


def problems(html: str) -> list[Problem]:
    """List what a page would fetch, and its pictures without alternative text."""
    soup = BeautifulSoup(html, "html.parser")
    found = []
    for element in soup.find_all(True):
        found += [Problem(_cell(element), text) for text in _fetches(element)]
        alt = str(element.get("alt", "")).strip()
        if element.name == "img" and alt in ("", _FILLER):
            text = "a picture has no alternative text (alt)"
            found.append(Problem(_cell(element), text))
    return found


def _fetches(element: Tag) -> list[str]:
    """Say what one element would fetch; links that a reader follows are fine."""
    found = []
    for name in ("src", "srcset", "poster", "data"):
        value = str(element.get(name, "data:"))
        if not value.startswith(("data:", "#")):
            found.append(f"<{element.name} {name}={value[:80]!r}> is not in the file")
    if element.name == "link" and element.get("href"):
        found.append(f"<link href={element['href'][:80]!r}> is not in the file")
    css = str(element.get("style", ""))
    if element.name == "style":
        css += element.get_text()
        if "@import" in css:
            found.append("a style sheet uses @import")
    found += [f"a style fetches {url[:80]!r}" for url in _URL.findall(css)]
    return found


def _cell(element: Tag) -> str | None:
    """Return the id of the notebook cell that an element belongs to."""
    parent = element.find_parent(attrs={"data-cell": True})
    return str(parent["data-cell"]) if parent else None
