"""Command line: ``python -m pgm_book.course.quiz`` writes all questions."""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from pgm_book.course import formats
from pgm_book.course.formats import Question
from pgm_book.course.numbers import number_questions, variants
from pgm_book.course.questions import choice_questions, left_out
from pgm_book.make.environment import ROOT
from pgm_lab import datasets
from pgm_lab.io.files import save


def categories(notebooks: Path) -> dict[str, dict[str, list[Question]]]:
    """Return all questions: by lesson or case, and in it by category.

    The predictions and quick questions of a notebook are one category, the variants of
    a question with numbers another, of which a quiz takes one by chance.
    """
    choices = choice_questions(notebooks)
    found: dict[str, dict[str, list[Question]]] = {}
    for row in datasets.rows("chapters.csv"):
        number, of = row["number"], f"{row['number']} {row['title']}"
        here: dict[str, list[Question]] = {}
        if number in choices:
            here[f"{of}/choices"] = list(choices[number])
        for one in number_questions():
            if one.lesson == number:
                here[f"{of}/numbers/{one.title}"] = list(variants(one))
        if here:
            found[number] = here
    return found


def write(notebooks: Path, folder: Path) -> Iterator[Path]:
    """Write the three formats; yield each path as it is done.

    GIFT and Moodle XML hold everything in one file each. A QTI package has no
    categories, so there is one for each lesson and case.
    """
    lessons = categories(notebooks)
    everything = {k: one for here in lessons.values() for k, one in here.items()}
    single = {"pgm_lab.gift.txt": formats.gift, "pgm_lab.moodle.xml": formats.moodle}
    for name, written in single.items():
        save({folder / name: written(everything)}, overwrite=True)
        yield folder / name
    for number, here in lessons.items():
        target = folder / "qti" / f"pgm_lab-{number.zfill(2)}.zip"
        questions = [question for some in here.values() for question in some]
        save({target: formats.qti(number, questions)}, overwrite=True)
        yield target


def main(arguments: list[str] | None = None) -> int:
    """Write the questions and say what was written, and what was left out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--notebooks", type=Path, default=ROOT / "notebooks")
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    options = parser.parse_args(arguments)
    for path in write(options.notebooks, options.build / "quiz"):
        print(path)
    for number, reason in left_out().items():
        print(f"left out: {number}, since {reason}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
