"""Publish a chapter as the command does, and watch the page in the browser."""

import subprocess
import sys
from pathlib import Path

from pgm_book.make.__main__ import ROOT

# What each slide has once it is shown: how far it sticks out, and its formulas. Those
# in a fold, and those that wait for a prediction, are looked at once it is open.
LOOK = """() => Reveal.getSlides().map((slide) => {
    const { h, v } = Reveal.getIndices(slide);
    Reveal.slide(h, v);
    const formulas = [...slide.querySelectorAll("mjx-container")]
        .filter((formula) => !formula.closest("aside"))
        .map((formula) => {
            const choice = slide.querySelector(".pgm-predict details");
            const folds = [choice, formula.closest("details")].filter(Boolean);
            folds.forEach((fold) => { fold.open = true; });
            const { height } = formula.getBoundingClientRect();
            folds.forEach((fold) => { fold.open = false; });
            return height;
        });
    return {
        first: slide.querySelector("h1, h2, h3, p, img, pre, table, li")?.tagName,
        overflow: Math.max(slide.scrollHeight - slide.clientHeight,
                           slide.scrollWidth - slide.clientWidth),
        formulas,
    };
})"""


class Watched:
    """A page, what it asked for beyond the file itself, and its errors."""

    def __init__(self, context):
        self.requests: list[str] = []
        self.errors: list[str] = []
        self.page = context.new_page()
        self.page.on("request", self._note)
        self.page.on("requestfailed", self._failed)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._listen)

    def _note(self, request):
        if not request.url.startswith(("data:", "about:", "blob:")):
            self.requests.append(request.url)

    def _failed(self, request):
        # Leaving a page cuts off what it still loads, as its icon: that is no fault.
        if request.failure != "net::ERR_ABORTED":
            self.errors.append(request.url)

    def _listen(self, message):
        if message.type in ("error", "warning"):
            self.errors.append(message.text)

    def wait(self):
        """Wait until formulas are set and, in slides, reveal.js has started."""
        self.page.wait_for_function("document.documentElement.dataset.ready")


class Deck(Watched):
    """A deck that was walked through once with every fragment shown."""

    def __init__(self, context, file: Path):
        super().__init__(context)
        self.page.goto(file.as_uri())
        self.wait()
        self.page.evaluate("Reveal.configure({ fragments: false })")
        self.looks: list[dict] = self.page.evaluate(LOOK)
        self.page.evaluate("Reveal.slide(0, 0)")


def written(folder: Path, page: str) -> Path:
    """Write a page into a folder; return its path."""
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    return path


def published(what: str, chapter: Path, build: Path) -> list[Path]:
    """Publish one chapter by the command; return what it wrote, in its order."""
    before = chapter.read_bytes()
    command = [sys.executable, "-m", "pgm_book.make", what, chapter.stem]
    folders = ["--notebooks", str(chapter.parent), "--build", str(build)]
    result = subprocess.run(command + folders, cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert chapter.read_bytes() == before, "publishing changed the notebook"
    return [Path(line) for line in result.stdout.splitlines()]


def each_slide(page):
    """Go through the slides; yield their numbers, from 1."""
    for index in range(page.evaluate("Reveal.getTotalSlides()")):
        page.evaluate(
            """index => {
                const { h, v } = Reveal.getIndices(Reveal.getSlides()[index]);
                Reveal.slide(h, v);
            }""",
            index,
        )
        yield index + 1
