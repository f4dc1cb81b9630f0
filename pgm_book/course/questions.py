"""The choice questions of all notebooks, each so that it can stand alone.

A prediction is asked in the text above its cell, a quick question in the cell itself.
What else a reader sees beside it in the notebook, `beside.toml` adds.
"""

import ast
import base64
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import nbformat
from bs4 import BeautifulSoup
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbformat import NotebookNode

from pgm_book.common.predict import choices_of
from pgm_lab import datasets

BESIDE = Path(__file__).with_name("beside.toml")
HEADING = re.compile(r"^#+ +(.+?)(?: · \d+ min)?\n", re.MULTILINE)
NUMBER = re.compile(r'predict\("([^"]+)"\)')
# Display before inline; a dollar that is none of a formula does not occur.
DISPLAYED, INLINE = re.compile(r"\$\$(.+?)\$\$", re.DOTALL), re.compile(r"\$(.+?)\$")


@dataclass(frozen=True)
class Choice:
    """A choice of a question, and what is said to who takes it; plain text."""

    text: str
    right: bool
    feedback: str


@dataclass(frozen=True)
class Picture:
    """A figure that a question speaks of: PNG, and what it shows in words."""

    name: str
    png: bytes
    alt: str


@dataclass(frozen=True)
class ChoiceQuestion:
    """A question with one right choice; its text is Markdown with formulas."""

    number: str  # as in predictions.csv: stable, whatever stands before it
    title: str
    text: str
    choices: tuple[Choice, ...]
    picture: Picture | None = None


def choice_questions(notebooks: Path) -> dict[str, list[ChoiceQuestion]]:
    """Return the questions of each notebook, by its number in ``chapters.csv``."""
    beside = tomllib.loads(BESIDE.read_text(encoding="utf-8"))
    found = {}
    for row in datasets.rows("chapters.csv"):
        if not row["notebook"]:  # to come
            continue
        path = notebooks / f"{row['notebook']}.ipynb"
        asked = list(_asked(nbformat.read(path, as_version=4), beside))
        if asked:
            found[row["number"]] = asked
    return found


def left_out() -> dict[str, str]:
    """Return the predictions that make no sense alone, each with the reason."""
    beside = tomllib.loads(BESIDE.read_text(encoding="utf-8"))
    return {k: one["left_out"] for k, one in beside.items() if "left_out" in one}


def _asked(notebook: NotebookNode, beside: dict) -> Iterator[ChoiceQuestion]:
    """Yield the questions of a notebook in its order."""
    title = text = ""
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            title = [title, *HEADING.findall(cell.source + "\n")][-1]
            text = cell.source if "**Predict" in cell.source else text
        elif "predict" in cell.metadata.get("tags", []):
            quick = _quick(cell.source)
            for number in quick or NUMBER.findall(cell.source):
                extra = beside.get(number, {})
                if "left_out" not in extra:
                    words = quick.get(number) or _alone(text, extra)
                    picture = _picture(notebook, extra.get("cell"))
                    name = words if quick else re.sub(r"[$*`\\]", "", title)
                    yield ChoiceQuestion(number, name, words, _choices(number), picture)


def _quick(source: str) -> dict[str, str]:
    """Return the quick questions of a cell by number, without their "1."."""
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "questions":
            asked = ast.literal_eval(node.value)
            return {k: re.sub(r"^\d+\. ", "", text) for k, text in asked.items()}
    return {}


def _alone(text: str, extra: dict[str, str]) -> str:
    """Return the text of a prediction with what it needs, without heading and call."""
    cut = extra.get("cut", "")
    if cut not in text:
        raise ValueError(f"{BESIDE.name}: {cut!r} does not occur in {text[:60]!r}")
    text = HEADING.sub("", text.replace(cut, ""))
    text = text.replace("**Predict.** ", "").replace("**Predict** ", "Predict ")
    return "\n\n".join(filter(None, [extra.get("before", "").strip(), text.strip()]))


def _choices(number: str) -> tuple[Choice, ...]:
    return tuple(
        Choice(row["choice"], row["right"] == "yes", row["feedback"])
        for row in choices_of(number)
    )


def _picture(notebook: NotebookNode, name: str | None) -> Picture | None:
    """Return the stored figure of the cell with this id."""
    for cell in notebook.cells:
        for output in cell.get("outputs", []) if cell.get("id") == name else []:
            if "image/png" in output.get("data", {}):
                png = base64.b64decode(output.data["image/png"])
                alt = output.metadata["image/png"]["alt"]
                return Picture(f"{name}.png", png, alt)
    if name:
        raise ValueError(f"{BESIDE.name}: cell {name} has no stored figure")
    return None


@cache
def html(markdown: str) -> str:
    r"""Write Markdown as XHTML, its formulas as TeX between ``\(`` and ``\)``.

    Only what all formats allow is left: no styles, classes or names.
    """
    renderer = IPythonRenderer(escape=False, exclude_anchor_links=True)
    page = MarkdownWithMath(renderer).render(markdown)
    page = DISPLAYED.sub(r"\\[\1\\]", page)
    soup = BeautifulSoup(INLINE.sub(r"\\(\1\\)", page), "html.parser")
    for tag in soup.find_all(True):
        tag.attrs = {}
    return soup.decode(formatter="minimal").strip()
