"""The quick questions of a chapter as slides: students get no answers, lecturers do."""

from dataclasses import dataclass
from html import escape

from bs4 import BeautifulSoup, Tag
from nbformat import NotebookNode

from pgm_book.make import deck
from pgm_book.make.student import slide_type, tags

Text = tuple[str, str]  # a source and its slide type


@dataclass(frozen=True)
class Choice:
    """One choice of a question, and the sentence that answers it."""

    text: str
    right: bool
    sentence: str


def slides(cell: NotebookNode, key: bool) -> list[NotebookNode]:
    """Return the slides that a cell of quick questions becomes, else nothing.

    A lesson asks them in a cell tagged ``predict`` that slides skip, each with a
    printed line and its choices: one a slide.

    Parameters
    ----------
    cell : NotebookNode
        An executed cell.
    key : bool
        Whether the answers go with the questions.
    """
    if "predict" not in tags(cell) or slide_type(cell) != "skip":
        return []
    texts = [text for one in _asked(cell) for text in _one_a_slide(*one)]
    return [
        deck.made(cell, *text, number, tag="question")
        for number, text in enumerate(texts)
        if key or text[1] != "fragment"
    ]


def _asked(cell: NotebookNode) -> list[tuple[str, list[Choice]]]:
    """Return the questions that a cell prints, each with the choices below it."""
    found, printed = [], ""
    for output in cell.get("outputs", []):
        if output.output_type == "stream":
            printed = output.text.strip()
            continue
        soup = BeautifulSoup(output.get("data", {}).get("text/html", ""), "html.parser")
        folded = soup.select(".pgm-predict details")
        if printed and folded:
            found.append((printed, [_choice(one) for one in folded]))
        printed = ""
    return found


def _choice(folded: Tag) -> Choice:
    summary, answer = folded.find_all(["summary", "p"])
    mark, _, sentence = answer.get_text().partition(" ")
    return Choice(summary.get_text(), mark == "✓", sentence)


def _one_a_slide(question: str, choices: list[Choice]) -> list[Text]:
    listed = "\n".join(f"<li>{escape(one.text)}</li>" for one in choices)
    asked = f'### {escape(question)}\n\n<ol class="choices" type="A">\n{listed}\n</ol>'
    answers = [
        f"> **✓ {letter}.** {escape(one.sentence)}"
        for letter, one in zip("ABCDE", choices)
        if one.right
    ]
    return [(asked, "subslide"), *((text, "fragment") for text in answers)]
