"""What a page and a text say, for the tests of all reports."""

import re
from html.parser import HTMLParser

GREEK = {"σ": "sigma", "ω": "omega", "φ": "phi", "κ": "kappa", "τ": "tau", "ρ": "rho"}


def plain(page):
    """Undo what the page does to formulas and numbers: the text report has them so."""
    page = re.sub(
        " × 10<sup>(−?)([0-9]+)</sup>",
        lambda found: f"e{'-' if found[1] else '+'}{int(found[2]):02d}",
        page,
    )
    page = re.sub("v<sup>T</sup>P", "v'P", page)
    page = re.sub("M<sub>(.)</sub>", lambda found: f"M_{GREEK[found[1]]}", page)
    page = page.replace("<sup>", "^").replace("−", "-").replace("√(", "sqrt(")
    page = re.sub("(<caption>)<span>|</span>(</caption>)", r"\1\2", page)
    page = re.sub("</?su[bp]>", "", page)
    return "".join(GREEK.get(letter, letter) for letter in page)


def joined(text):
    """A text report without its line breaks and columns."""
    return " ".join(text.split())


class Page(HTMLParser):
    """What a reader with a screen reader needs of a page, and its tables.

    `tables` are rows of cells by their caption, the header first.
    """

    VOID = {"meta", "img", "br", "link"}

    def __init__(self, page):
        super().__init__()
        self.elements, self.open, self.text = [], [], []
        self.tables, self.rows = {}, []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("th", "td"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)
        if "caption" in self.open[-2:]:
            self.rows = self.tables.setdefault(data, [])
        elif self.open and self.open[-1] in ("th", "td"):
            self.rows[-1][-1] += data

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]
