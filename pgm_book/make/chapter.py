"""Begin a chapter: `python tasks.py chapter 10 clouds` writes a lesson and a case.

Both are copies of templates/chapter, in which NUMBER, FILE, TITLE, LOWER and QUESTION
are replaced; they run and pass every test as they are, and are there to be rewritten.
No file that exists is changed but the tables that list the chapters.
"""

import csv
import io
import json
import re
import sys
from pathlib import Path

from pgm_book.make import chapters, house, notebooks
from pgm_lab import datasets
from pgm_lab.io.files import save

ROOT = Path(__file__).resolve().parents[2]
TEMPLATES = ROOT / "pgm_book" / "make" / "templates" / "chapter"
TABLE = ROOT / "data" / "chapters.csv"


def begin(number: str, name: str) -> list[Path]:
    """Write the files of a new chapter, and list it; a ValueError says why it can't."""
    if not re.fullmatch(r"\d+|A\d", number):
        raise ValueError(f"the number must be like 10 or A3; got {number!r}")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise ValueError(f"the name must be like cloud_shadows; got {name!r}")
    rows = datasets.rows("chapters.csv")
    row = next((one for one in rows if one["number"] == number), None)
    file = number.zfill(2)
    written = {
        f"notebooks/{file}_{name}.ipynb": "lesson.ipynb",
        f"notebooks/{file}_case_{name}.ipynb": "case.ipynb",
        f"pgm_book/ch{file}/__init__.py": "package.py",
        f"pgm_book/ch{file}/checks.py": "checks.py",
        f"pgm_book/ch{file}/task.py": "task.py",
        f"pgm_book/ch{file}/predictions.csv": "predictions.csv",
        f"pgm_book/ch{file}/case_predictions.csv": "case_predictions.csv",
        f"tests/ch{file}/__init__.py": "",
        f"tests/ch{file}/test_checks.py": "test_checks.py",
    }
    there = [path for path in written if (ROOT / path).exists()]
    if there or (row and row["notebook"]):
        raise ValueError(
            f"chapter {number} exists already: {there or row['notebook']}. To bring"
            " it into this form, edit its notebook, see CONTRIBUTING.md"
        )
    title = row["title"] if row else name.replace("_", " ").capitalize()
    question = row["question"] if row else "Which question does this chapter answer?"
    words = {"NUMBER": number, "FILE": file, "TITLE": title, "QUESTION": question}
    words["LOWER"] = title[0].lower() + title[1:]
    made = {}
    for path, template in written.items():
        text = (TEMPLATES / template).read_text(encoding="utf-8") if template else ""
        quoted = {word: json.dumps(new)[1:-1] for word, new in words.items()}
        made[ROOT / path] = filled(text, quoted if "ipynb" in path else words)
    save(made)
    stems = [f"{file}_{name}", f"{file}_case_{name}"]
    listed(rows, row, number, title, question, stems)
    return [ROOT / path for path in written]


def filled(text: str, words: dict[str, str]) -> str:
    """Put the words of a chapter in the places of a template."""
    return re.sub("|".join(words), lambda found: words[found[0]], text)


def listed(
    rows: list[dict[str, str]],
    row: dict[str, str] | None,
    number: str,
    title: str,
    question: str,
    stems: list[str],
) -> None:
    """Write the lesson and its case into data/chapters.csv."""
    empty = dict.fromkeys(rows[0], "")
    known = row or empty | {"number": number, "title": title, "question": question}
    lesson = known | {"notebook": stems[0], "minutes": "33", "form": "lesson"}
    case = empty | {
        "number": f"{number}c",
        "notebook": stems[1],
        "title": f"{title}: the case",
        "question": "What do the printed numbers prove?",
        "sources": known["sources"],
        "minutes": "30",
        "form": "case",
    }
    place = rows.index(row) if row else len(rows)
    rows[place : place + bool(row)] = [lesson, case]
    text = io.StringIO()
    writer = csv.DictWriter(text, rows[0], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    save({TABLE: text.getvalue()}, overwrite=True)


def main(arguments: list[str]) -> int:
    """Begin a chapter, execute its notebooks and renew the lists of chapters."""
    if len(arguments) != 2:
        print("python tasks.py chapter NUMBER name, for example: 10 cloud_shadows")
        return 2
    try:
        paths = begin(*arguments)
    except ValueError as error:
        print(f"No chapter was begun: {error}.", file=sys.stderr)
        return 1
    for path in paths:
        print(path.relative_to(ROOT).as_posix())
    house.MAP.write_text(house.drawing(), encoding="utf-8", newline="\n")
    chapters.main()
    # The first chapter shows the list of all.
    return notebooks.main([*(path.stem for path in paths[:2]), "00_start_here"])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
