"""Read a tagged PDF in the order of its text: words, pictures and headings."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from typing import Any

from pypdf import PageObject, PdfReader

HEADINGS = {f"/H{level}" for level in range(1, 7)}
FIXED_PITCH = 1  # a font's flag: every sign has the same width, as in code


@dataclass(frozen=True)
class Piece:
    """Words of one style, or a picture, on one page; lengths in points."""

    page: int  # from 1
    text: str  # the words, or the description of the picture
    size: float  # height of the writing, or width of the picture
    bottom: float  # height of its lower edge above that of the paper
    kind: str  # text, code, heading, picture; empty for the footer and boxes


@dataclass(frozen=True)
class Printed:
    """A PDF: its pieces in the order of reading, and the heights of its pages."""

    pieces: list[Piece]
    heights: list[float]


@lru_cache(maxsize=1)
def read(pdf: bytes) -> Printed:
    """Return what a tagged PDF shows; the last one is known, however often it is read.

    Lines and backgrounds are not read, and formulas only if they are text.
    """
    reader = PdfReader(BytesIO(pdf))
    order = _order(reader)
    found: list[tuple[int, Piece]] = []
    for number, page in enumerate(reader.pages, start=1):
        found += _pieces(number, page, order)
    found.sort(key=lambda one: one[0])  # stable: within a mark as drawn
    heights = [float(page.mediabox.height) for page in reader.pages]
    return Printed([piece for _, piece in found], heights)


def _order(reader: PdfReader) -> dict[tuple[int, int], tuple[int, str, str]]:
    """Return place, kind and description of each mark, by its page and number."""
    numbers = {
        getattr(page.indirect_reference, "idnum", 0): n
        for n, page in enumerate(reader.pages, 1)
    }
    found: dict[tuple[int, int], tuple[int, str, str]] = {}

    def visit(element: Any, page: int, kind: str, alt: str) -> None:
        if isinstance(element, int):
            found.setdefault((page, element), (len(found), kind, alt))
            return
        if "/Pg" in element:
            page = numbers[element.raw_get("/Pg").idnum]
        if element.get("/S") in HEADINGS:
            kind = "heading"
        alt = str(element.get("/Alt", alt))
        kids = element.get("/MCID", element.get("/K", []))
        for kid in kids if isinstance(kids, list) else [kids]:
            visit(kid.get_object(), page, kind, alt)

    visit(reader.root_object["/StructTreeRoot"], 0, "text", "")
    return found


def _pieces(number: int, page: PageObject, order: dict) -> Iterator[tuple[int, Piece]]:
    """Yield the pieces of a page, each with its place in the order of reading."""
    found: list[tuple[int, Piece]] = []
    marks: list[int | None] = []

    def tagged() -> tuple[int, str, str]:
        mark = next((mark for mark in reversed(marks) if mark is not None), None)
        return order.get((number, mark), (len(order), "", ""))

    def words(text, cm, tm, font, size):
        if text.strip():
            place, kind, _ = tagged()
            kind = "code" if kind == "text" and _fixed(font) else kind
            bottom = tm[4] * cm[1] + tm[5] * cm[3] + cm[5]
            piece = Piece(number, text, size * abs(tm[3] * cm[3]), bottom, kind)
            found.append((place, piece))

    def other(operator, operands, cm, tm):
        if operator in (b"BDC", b"BMC"):
            properties = operands[-1]
            marks.append(
                properties.get("/MCID") if isinstance(properties, dict) else None
            )
        elif operator == b"EMC" and marks:
            marks.pop()
        elif operator == b"Do":
            place, _, alt = tagged()
            bottom = min(cm[5], cm[5] + cm[3])
            found.append((place, Piece(number, alt, abs(cm[0]), bottom, "picture")))

    page.extract_text(visitor_text=words, visitor_operand_before=other)
    return iter(found)


def _fixed(font: dict | None) -> bool:
    """Whether every sign of a font is as wide as the other."""
    for one in (font or {}).get("/DescendantFonts", [font or {}]):
        descriptor = one.get_object().get("/FontDescriptor", {}) if one else {}
        if descriptor.get("/Flags", 0) & FIXED_PITCH:
            return True
    return False
