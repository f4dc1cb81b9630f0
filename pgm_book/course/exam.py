"""Command line: ``python -m pgm_book.course.exam 7`` writes a paper and its key.

The same seed gives the same paper. Choice questions are those of the lessons, not of
the cases; questions with numbers have those of one of their variants.
"""

import argparse
import base64
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from pgm_book.course import formats
from pgm_book.course.numbers import (
    Chance,
    NumberQuestion,
    Variant,
    number_questions,
    variants,
)
from pgm_book.course.questions import ChoiceQuestion, choice_questions, html
from pgm_book.make.environment import ROOT
from pgm_book.make.errors import PublishError, missing
from pgm_lab.io.files import save

HERE = Path(__file__).parent
STYLES = ("pgm/common.css", "pgm_handout/handout.css")
T = TypeVar("T", ChoiceQuestion, NumberQuestion)

# Of questions that rest on one fact, or whose words give it away, a paper has one.
FACTS = [
    set(row.split())
    for row in (
        "1.1 1.3 1.11, 1.4 1.principal_point, 1.6 1.9, 1.7 1.8 1.13, 2.1 2.5 7.7,"
        "2.3 2.7, 2.6 2.places, 3.2 3.scale_of_window, 3.3 3.8, 3.5 3.11 7.2,"
        "4.3 4.7 4.13, 4.5 4.10, 4.6 4.12, 4.8 5.3 5.7, 5.4 5.9 6.2, 5.8 9.7 9.4,"
        "5.10 8.8, 6.1 6.zeros, 6.3 6.8, 6.4 6.10, 6.6 6.11, 6.9 A1.13,"
        "7.3 7.4 7.8 7.whole_pixels, 8.3 9.3, 8.5 8.sigma_z, 8.6 8.9,"
        "9.1 9.2, 9.8 9.wrong_distance, A1.3 A1.5 A1.12 A1.blunder"
    ).split(",")
]


@dataclass(frozen=True)
class Part:
    """How many questions of a kind a paper has, and what each counts."""

    count: int
    points: int
    minutes: int


CHOICE, NUMBER = Part(20, 2, 2), Part(10, 6, 8)  # two hours, a hundred points


@dataclass(frozen=True)
class Paper:
    """The questions of a paper in their order."""

    seed: str
    choices: list[ChoiceQuestion]
    numbers: list[Variant]

    @property
    def points(self) -> int:
        """What the whole paper counts."""
        return len(self.choices) * CHOICE.points + len(self.numbers) * NUMBER.points

    @property
    def minutes(self) -> int:
        """How long it takes."""
        return len(self.choices) * CHOICE.minutes + len(self.numbers) * NUMBER.minutes


def choose(seed: str, lessons: list[str], notebooks: Path) -> Paper:
    """Choose the questions of a paper, equally many from each lesson.

    Raises
    ------
    ValueError
        If a lesson has no questions with numbers.
    """
    chance = Chance("exam", seed)
    of_lesson: dict[str, list] = {}
    for one in number_questions():
        of_lesson.setdefault(one.lesson, []).append(one)
    asked = choice_questions(notebooks)
    known = [one for one in asked if one in of_lesson]
    lessons = [one.upper() for one in lessons] or known
    unknown = [one for one in lessons if one not in known]
    if unknown:
        raise ValueError(f"no lesson {unknown[0]}; give some of {', '.join(known)}")
    facts: list[set[str]] = []  # that are asked already
    choices = balanced(chance, [asked[one] for one in lessons], CHOICE.count, facts)
    numbers = balanced(chance, [of_lesson[one] for one in lessons], NUMBER.count, facts)
    drawn = [chance.of(variants(one)) for one in numbers]
    shuffled = [_shuffled(chance, one) for one in choices]
    return Paper(seed, shuffled, drawn)


def balanced(
    chance: Chance, groups: list[list[T]], count: int, facts: list[set[str]]
) -> list[T]:
    """Choose from groups in turn until there are enough, in the order of the groups.

    What is asked for a second time is left out; `facts` grows by what is asked.
    """
    left = [chance.order(group) for group in groups]
    taken: list[list[T]] = [[] for _ in groups]
    while sum(map(len, taken)) < count and any(left):
        for k in chance.order(range(len(groups))):
            while left[k] and sum(map(len, taken)) < count:
                one = left[k].pop()
                asked = [row for row in FACTS if name_of(one) in row]
                if not any(row in facts for row in asked):
                    taken[k].append(one)
                    facts += asked
                    break
    return [one for group in taken for one in group]


def name_of(one: ChoiceQuestion | NumberQuestion) -> str:
    """Return what a question is called, such as 1.4 or 1.gsd."""
    if isinstance(one, ChoiceQuestion):
        return one.number
    return f"{one.lesson}.{one.name}"


def _shuffled(chance: Chance, one: ChoiceQuestion) -> ChoiceQuestion:
    order = tuple(chance.order(one.choices))
    return ChoiceQuestion(one.number, one.title, one.text, order, one.picture)


# --- On paper ---


def page(paper: Paper, key: bool) -> str:
    """Return the paper, or its key, as one HTML page that needs nothing else."""
    from pgm_book.make.page import MATHJAX, TEMPLATES, asset

    def text(*parts: str) -> Markup:
        return Markup("\n".join((TEMPLATES / one).read_text("utf-8") for one in parts))

    pages = Environment(
        loader=FileSystemLoader(HERE), autoescape=True, undefined=StrictUndefined
    )
    pages.filters["html"] = lambda markdown: Markup(html(markdown))
    pages.filters["body"] = lambda one: Markup(formats.body(one, _picture(one)))
    return pages.get_template("exam.html.j2").render(
        title=f"Photogrammetry: examination {paper.seed}",
        key=key,
        minutes=paper.minutes,
        points=paper.points,
        choice=CHOICE,
        number=NUMBER,
        choices=paper.choices,
        numbers=paper.numbers,
        formulas=(HERE / "formulas.md").read_text("utf-8"),
        css=text(*STYLES),
        settings=text("pgm/mathjax.js"),
        mathjax=Markup(asset(*MATHJAX, "tex-svg-full.js")),
    )


def _picture(one: ChoiceQuestion) -> str:
    """Return the figure of a question as a data URI."""
    png = one.picture.png if one.picture else b""
    return "data:image/png;base64," + base64.b64encode(png).decode()


def write(paper: Paper, folder: Path, of: str = "") -> Iterable[Path]:
    """Write the paper and its key as PDF; yield each path as it is done.

    `of` stands in the names of a paper that is not of all lessons.
    """
    from pgm_book.make.browser import open_browser
    from pgm_book.make.handouts import print_pdf

    with open_browser() as browser:
        for key in (False, True):
            target = folder / f"exam-{paper.seed}{of}{'-key' * key}.pdf"
            save({target: print_pdf(browser, page(paper, key))}, overwrite=True)
            yield target


def main(arguments: list[str] | None = None) -> int:
    """Write a paper and say where it is; return 1 if something was wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seed", type=int, help="another number gives another paper")
    parser.add_argument("lessons", nargs="*", metavar="LESSON", help="1 to 9, A1")
    parser.add_argument("--notebooks", type=Path, default=ROOT / "notebooks")
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    options = parser.parse_args(arguments)
    try:
        paper = choose(str(options.seed), options.lessons, options.notebooks)
        of = "".join(f"-{lesson}" for lesson in options.lessons)
        for path in write(paper, options.build / "exam", of):
            print(path)
    except ModuleNotFoundError as error:
        print(f"exam: {missing(error.name)}", file=sys.stderr)
        return 1
    except (PublishError, ValueError) as error:
        print(f"exam: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
