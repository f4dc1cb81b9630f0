"""What a published page may hold: all that is not listed here is refused.

A list of what is forbidden is never complete, because browsers keep learning new ways
to load a file. So these are the elements, attributes, functions of CSS and addresses
that load nothing, or only what the page itself carries.
"""

import re

ELEMENTS = set(
    # a document and its parts
    "html head title meta style body header footer main nav section article aside div "
    # text
    "h1 h2 h3 h4 h5 h6 p br hr wbr span a em strong b i u s small sub sup mark abbr "
    "cite q dfn var samp kbd code pre del ins time blockquote details summary address "
    "ul ol li dl dt dd figure figcaption img ruby rt rp "
    # tables
    "table caption colgroup col thead tbody tfoot tr td th".split()
)

# `data-cell` is ours. Other data-... attributes are not: reveal.js loads what
# data-src and data-background-image name.
EVERYWHERE = set("class id lang dir title style role tabindex data-cell".split())
ATTRIBUTES = {
    "a": {"href"},
    "col": {"span"},
    "colgroup": {"span"},
    "details": {"open", "name"},
    "img": {"src", "alt", "width", "height"},
    "li": {"value"},
    "meta": {"charset", "name", "content"},
    "ol": {"start", "type", "reversed"},
    "section": {"data-timing"},  # seconds, for the speaker's view
    "style": {"type"},
    "table": {"border"},
    "td": {"colspan", "rowspan", "align", "valign", "headers"},
    "th": {"colspan", "rowspan", "align", "valign", "headers", "scope", "abbr"},
    "time": {"datetime"},
    "tr": {"align", "valign"},
}

# Nothing is loaded before a reader follows a link.
LINK = re.compile(r"(https?:|mailto:|[^:]*$|[^:/?#]*[/?#])", re.IGNORECASE)
PICTURE = re.compile(r"data:image/(png|jpeg|gif|webp|svg\+xml)[;,]", re.IGNORECASE)
STYLE_PICTURE = re.compile(rf"#|{PICTURE.pattern}", re.IGNORECASE)

AT_RULES = {"media", "page", "keyframes", "-webkit-keyframes", "supports"}
FUNCTIONS = set(
    # selectors
    "not is where has nth-child nth-last-child nth-of-type nth-last-of-type lang dir "
    # numbers and texts
    "var calc min max clamp attr counter counters "
    # colours and gradients
    "rgb rgba hsl hsla color-mix light-dark linear-gradient "
    "repeating-linear-gradient radial-gradient "
    # shapes, places and movements
    "inset circle polygon translate translatex translatey translatez translate3d "
    "scale scalex scaley rotate rotatex rotatey rotatez skew matrix perspective "
    "cubic-bezier steps blur brightness contrast opacity "
    # grids
    "repeat minmax fit-content".split()
)

# MathJax lets a formula carry a style of its own, or load more of MathJax.
FORMULA = re.compile(r"\\(style|bbox|mmlToken|require|data|includegraphics)\b")


def attribute(element: str, name: str) -> bool:
    """Whether an element may have this attribute."""
    listed = EVERYWHERE | ATTRIBUTES.get(element, set())
    return name in listed or name.startswith("aria-")


def address(element: str, name: str, value: str) -> bool:
    """Whether an attribute holds no address, or one that loads nothing."""
    # Browsers read over spaces and control characters in an address.
    plain = re.sub(r"[\x00-\x20]", "", value)
    if name == "href":
        return LINK.match(plain) is not None
    if (element, name) == ("img", "src"):
        return PICTURE.match(plain) is not None
    return True
