"""What the tests look at in a rendered page, for slides and handouts alike."""

import re
from importlib.resources import files

AXE = files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")

# Why axe-core cannot tell a contrast: something lies over the text.
COVERED = {"bgOverlap", "elmPartiallyObscured", "elmPartiallyObscuring"}


# Without the strokes of formulas: thousands of shapes, hidden from screen readers. What
# passes is looked at as well, but not listed, which takes half of the time.
RUN_AXE = """(rules) => axe.run(
    { exclude: [["mjx-container > svg"]] },
    {
        resultTypes: ["violations", "incomplete"],
        ...(rules.length ? { runOnly: rules } : {}),
    },
)"""


# What fades in has its colours at the end only; what turns for ever has no end.
MOVE_TO_THE_END = """() => document.getAnimations()
    .filter((one) => one.effect.getComputedTiming().endTime < Infinity)
    .forEach((one) => one.finish())"""


def load_axe(page) -> None:
    """Put axe-core into the page, once."""
    if not page.evaluate("Boolean(window.axe)"):
        page.evaluate(AXE)


# Whether an element is in a box that scrolls, where a part of it may be hidden
IN_A_SCROLL = """([selector]) => {
    let box = document.querySelector(selector).parentElement;
    for (; box; box = box.parentElement) {
        const { overflowX, overflowY } = getComputedStyle(box);
        const scrolls = (overflow) => ["auto", "scroll"].includes(overflow);
        if (scrolls(overflowX) && box.scrollWidth > box.clientWidth) return true;
        if (scrolls(overflowY) && box.scrollHeight > box.clientHeight) return true;
    }
    return false;
}"""


def axe_violations(page, *rules: str, scrolled: bool = False) -> list[str]:
    """Say what axe-core finds in the page as shown now, by all rules or the named.

    A contrast that it cannot tell counts too. With `scrolled` it does not in a box that
    scrolls, which hides a part of what it holds: look there after `show_all`.
    """
    page.evaluate(MOVE_TO_THE_END)
    result = page.evaluate(RUN_AXE, list(rules))
    untold = [
        node
        for said in result["incomplete"]
        if said["id"] == "color-contrast"
        for node in said["nodes"]
        if node["any"][0]["data"]["messageKey"] in COVERED
        if not (scrolled and page.evaluate(IN_A_SCROLL, node["target"]))
    ]
    return [
        f"{said['id']}: {node['html'][:150]} {node.get('failureSummary', '')}"
        for said in [*result["violations"], {"id": "color-contrast", "nodes": untold}]
        for node in said["nodes"]
    ]


def show_all(page) -> None:
    """Let no box hide what can be scrolled to, and nothing stay in place above it."""
    page.add_style_tag(
        content="""
        * { overflow: visible !important; position: static !important;
            max-width: none !important; max-height: none !important; }
        html, body { width: max-content !important; }
        """
    )


def lay_out_all(page) -> None:
    """Lay out all slides of a deck one below the other, as each looks when shown.

    Without what reveal.js puts behind a slide, which keeps axe-core from telling any
    contrast.
    """
    page.add_style_tag(
        content="""
        html, body, .reveal, .reveal .slides {
            height: auto !important; overflow: visible !important; }
        .reveal, .reveal > :not(header) {
            position: static !important; transform: none !important; }
        .reveal .backgrounds { display: none !important; }
        .reveal .slides section { display: block !important; opacity: 1 !important;
            inset: auto !important; position: relative !important;
            transform: none !important; visibility: visible !important; }
        """
    )
    page.evaluate(
        """() => document.querySelectorAll(".slides section").forEach((section) => {
            section.hidden = false;
            section.removeAttribute("aria-hidden");
        })"""
    )


def overflow(page) -> int:
    """Return by how many px the contents of the shown slide stick out."""
    return page.evaluate(
        """() => {
            const slide = Reveal.getCurrentSlide();
            return Math.max(slide.scrollHeight - slide.clientHeight,
                            slide.scrollWidth - slide.clientWidth);
        }"""
    )


def raw_markup(page) -> list[str]:
    """Return TeX and table rules that a reader would see; code is neither."""
    text = page.evaluate(
        """() => {
            const body = document.body.cloneNode(true);
            const other = "mjx-container, pre, code, script, style";
            body.querySelectorAll(other).forEach((element) => element.remove());
            return body.textContent;
        }"""
    )
    return re.findall(r"\$\$|\$[^$\n]+\$|\\[a-zA-Z]+.{0,20}|\|[ :]*-{2,}", text)


def has_maths(cells) -> bool:
    """Tell whether a text cell holds a formula."""
    code = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)
    return any(
        "$" in code.sub("", cell.source)
        for cell in cells
        if cell.cell_type == "markdown"
    )


def formulas(page) -> tuple[int, int]:
    """Return the numbers of typeset formulas and of errors in them."""
    return (
        page.locator("mjx-container").count(),
        page.locator("mjx-merror, [data-mml-node='merror']").count(),
    )


def bad_images(page) -> list[str]:
    """Return the images that were not decoded or have no alternative text."""
    return page.evaluate(
        """() => [...document.images]
            .filter((image) => !(image.naturalWidth > 0 && image.alt.trim()))
            .map((image) => image.outerHTML.slice(0, 120))"""
    )
