"""Grade a class: ``python -m pgm_book.course.grade SUBMISSIONS``.

The exercises are those of the notebooks, with the checks that the students had, and
other inputs; the tasks are made from the students' names and a word that they do not
know. A student's code runs in a box (`pgm_book.course.box`), one for each exercise; in
it the book's own function of that exercise does not work. Points are those of a
rubric, a row a property, which the lecturer edits.
"""

import argparse
import contextlib
import csv
import functools
import hashlib
import io
import itertools
import multiprocessing
import os
import queue
import re
import secrets
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import nbformat
from nbformat import NotebookNode
from tqdm import tqdm

from pgm_book import task
from pgm_book.common import checks
from pgm_book.course import box, feedback, intake, library, look
from pgm_book.course.boxed import plain
from pgm_book.make.environment import ROOT
from pgm_book.make.student import tags
from pgm_lab import datasets

HERE = Path(__file__).parent
RUBRIC = HERE / "rubric.csv"
# How lesson 5 asks for what its task defines; without its cell there is no such name.
GIVEN = re.compile(r'globals\(\)\.get\("(\w+)", \.\.\.\)')
TASK = "task"  # the exercise that is a lesson's task
SHORTEST = 12  # characters of a secret
# A right program is off by more than three once in 370 parts, and has one try here.
DEVIATIONS, SLACK = "standard deviations", 4 / 3
COPIES = 3  # of a lesson's notebook that are tried; who guesses hands in a hundred


@dataclass(frozen=True)
class Asked:
    """What a notebook asks: the student's names, the call of the check, the cells."""

    name: str
    names: tuple[str, ...]
    call: str
    answer: str  # the cells' ids
    check: str


@dataclass(frozen=True)
class Exercise:
    """What is graded: a call of a check with a student's names, or a lesson's task."""

    lesson: str
    name: str
    names: tuple[str, ...]  # that the student gives a value
    call: str
    points: dict[str, float]  # by property
    books_own: tuple[str, ...] = ()  # functions that do not work while it is graded
    near: tuple[str, ...] = ()  # functions and modules to look at in an answer

    @property
    def most(self) -> float:
        """All points that it gives."""
        return sum(self.points.values())


@dataclass(frozen=True)
class Mark:
    """What one exercise of one student is worth, and why."""

    lesson: str
    exercise: str
    points: float
    most: float
    properties: tuple[tuple[str, bool | None], ...]
    said: str  # to the student
    remarks: tuple[str, ...]  # to the lecturer


# --- What is graded ---


@functools.cache
def notebooks() -> dict[str, NotebookNode]:
    """Return the solved notebooks by lesson: "1", "1c" for its case, "A1"."""
    names = {
        row["number"]: ROOT / "notebooks" / f"{row['notebook']}.ipynb"
        for row in datasets.rows("chapters.csv")
    }
    return {lesson: nbformat.read(path, 4) for lesson, path in names.items()}


@functools.cache
def code_of(lesson: str) -> tuple[str, ...]:
    """Return the code of a solved notebook, a text a cell."""
    return tuple(c.source for c in notebooks()[lesson].cells if c.cell_type == "code")


def exercises(rubric: Path = RUBRIC) -> list[Exercise]:
    """Return the exercises that a rubric gives points for, in the book's order.

    Raises
    ------
    ValueError
        If the rubric has a row that the book does not have, or a strange number.
    """
    points = _points(rubric)
    others = {
        (row["lesson"], row["exercise"]): [
            tuple(row[column].split()) for column in ("functions", "near")
        ]
        for row in _rows(HERE / "counterparts.csv")
    }
    found = []
    for lesson in notebooks():
        for one in asked_in(notebooks()[lesson]):
            key = lesson, one.name
            if key in points:
                of = points.pop(key)
                found.append(
                    Exercise(*key, one.names, one.call, of, *others.get(key, []))
                )
    if points:
        lesson, name = next(iter(points))
        raise ValueError(f"{rubric}: lesson {lesson} has no exercise {name!r}")
    return found


def _points(rubric: Path) -> dict[tuple[str, str], dict[str, float]]:
    """Return the points of each property, by lesson and exercise."""
    points: dict[tuple[str, str], dict[str, float]] = {}
    known = {_property(row) for row in _rows(RUBRIC)}
    for number, row in enumerate(_rows(rubric), 2):
        if _property(row) not in known:
            raise ValueError(
                f"{rubric}, line {number}: no check names this property of this"
                f" exercise; copy rows of {RUBRIC.name} and change points only"
            )
        try:
            value = float(row["points"])
            if not 0 <= value < 1e6:
                raise ValueError
            points.setdefault((row["lesson"], row["exercise"]), {})[row["property"]] = (
                value
            )
        except (KeyError, TypeError, ValueError):
            raise ValueError(
                f"{rubric}, line {number}: a row has lesson, exercise, property and"
                " points, a number from 0"
            ) from None
    return points


def _property(row: dict[str, str]) -> tuple[str | None, ...]:
    """Name the property of which a row of a rubric speaks."""
    return row.get("lesson"), row.get("exercise"), row.get("property")


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        return list(csv.DictReader(file))


def asked_in(notebook: NotebookNode) -> Iterator[Asked]:
    """Yield what a notebook asks: tasks, and checks, each with the cell before it."""
    for answer, check in zip(notebook.cells, notebook.cells[1:]):
        if "task" in tags(answer):
            yield Asked(TASK, (), "", answer.id, "")
        if "check" in tags(check):
            call = GIVEN.sub(r"\1", check.source.split("\n")[0])
            used = intake.names_of(call).used
            names = sorted(intake.names_of(answer.source).bound & used, key=call.rindex)
            yield Asked(names[0], tuple(names), call, answer.id, check.id)


# --- One exercise of one student ---


def marked(
    exercise: Exercise,
    submission: intake.Submission,
    place: Path,
    secret: str,
    **how: Any,
) -> Mark:
    """Return the better mark of a student's notebook and program in an exercise.

    `place` has the libraries; `how` goes to the box.
    """
    found = [
        mark
        for cells in _candidates(exercise, submission)
        if (mark := _mark(exercise, submission, cells, place, secret, **how))
    ]
    missing = Mark(
        *(exercise.lesson, exercise.name, 0.0, exercise.most),
        *((), "it is not among what you handed in.", ()),
    )
    return max(found, key=lambda mark: mark.points, default=missing)


def _candidates(
    exercise: Exercise, submission: intake.Submission
) -> Iterable[list[str]]:
    """Yield the cells of each file in which an answer may stand."""
    is_task = exercise.name == TASK
    own = [one for one in submission.notebooks if lesson_of(one) == exercise.lesson]
    book = code_of(exercise.lesson)
    for notebook in own[:COPIES]:
        # Of the book's cells only the statements that the answer needs take time
        parts = [[c] if c not in book else intake.statements(c) for c in notebook.cells]
        cells = tuple(itertools.chain(*parts))
        yield intake.needed(cells, set(exercise.names), is_task)
    if is_task:
        source = submission.tasks.get(exercise.lesson, "")
        start = f'from pgm_book import task\nmine = task.start("{exercise.lesson}")'
        yield [submission.program, start, source] if source else []
    else:
        bound = intake.names_of(submission.program).bound
        yield [submission.program] if bound & set(exercise.names) else []


@functools.lru_cache(1000)
def lesson_of(notebook: intake.Notebook) -> str:
    """Return the lesson to which a student's notebook belongs; "" if to none.

    Files are renamed, so that the names of the cells count, then that of the file.
    """
    alike = {
        lesson: len(
            set(notebook.ids) & {c.id for c in original.cells if c.cell_type == "code"}
        )
        for lesson, original in notebooks().items()
    }
    best = max(alike, key=lambda lesson: alike[lesson])
    if alike[best] > 2:
        return best
    name = Path(notebook.file).name
    rows = datasets.rows("chapters.csv")
    return next((r["number"] for r in rows if name.startswith(r["notebook"])), "")


def _mark(
    exercise: Exercise,
    submission: intake.Submission,
    cells: list[str],
    place: Path,
    secret: str,
    **how: Any,
) -> Mark | None:
    """Run cells in a box and judge what they define; nothing if there are none."""
    if not cells:
        return None
    key = exercise.lesson, exercise.name
    found: tuple[tuple[str, bool | None], ...] = ()
    said, remarks = "", []
    files = {intake.FILE: submission.program.encode("utf-8", "replace")}
    with contextlib.redirect_stdout(io.StringIO()):
        mine = None
        if exercise.name == TASK:
            mine = task.start(exercise.lesson, submission.student, secret)
            folder = f"task_{exercise.lesson.zfill(2)}"
            for name in mine.files:
                files[f"{folder}/{name}"] = (mine.folder / name).read_bytes()
        seed = seed_of(secret, *key, submission.digest().hex())
        with checks.hidden(seed), box.Box(place / "-".join(key), **how) as closed:
            try:
                request = {name: content.hex() for name, content in files.items()}
                errors = closed.ask(box.LOADING, do="load", cells=cells, files=request)
                remarks += [box.named(": ".join(map(str, e[1:3]))) for e in errors][:3]
                judge_task(mine, closed) if mine else judge(exercise, closed)
                found = tuple((text, True) for text in exercise.points)
            except checks.CheckFailed as error:
                found, said = error.properties, str(error)
            except Exception as error:  # whatever a stranger's answer leads to
                said = f"{type(error).__name__}: {str(error)[:300]}"
            remarks += closed.remarks
    if said and box.BOOKS_OWN in remarks:
        found, said = (), "it calls the book's own function; write yours."
    if not said:  # what a right answer came across is of interest if it was refused
        remarks = [one for one in remarks if one in box.REFUSED]
    points = sum(exercise.points.get(text, 0.0) for text, holds in found if holds)
    near = exercise.near if points else ()
    if near and (calls := look.calls_of(cells, {*exercise.names}, near)):
        remark = f"calls {', '.join(calls)}, which may do much of the work"
        said = f"{said} It {remark}: your lecturer will look at that.".strip()
        remarks.insert(0, remark)
    remarks = list(dict.fromkeys(remarks))[:5]
    return Mark(*key, points, exercise.most, found, said, tuple(remarks))


def seed_of(*words: str) -> int:
    """Return a number that words stand for."""
    return int.from_bytes(hashlib.sha256("\n".join(words).encode()).digest()[:8], "big")


def judge(exercise: Exercise, closed: box.Box) -> None:
    """Call the check of an exercise with what is in the box."""
    space = {**_space(exercise.lesson, exercise.call, exercise.names)}
    for name in exercise.names:
        kind = closed.ask(box.CALLING, do="kind", name=name)
        if kind == "function":
            seed = int(checks.chance(0).integers(2**32))  # under the secret
            space[name] = closed.function(name, seed)
        elif kind == "value":
            said = closed.ask(box.CALLING, do="value", name=name)
            space[name] = plain.unpacked(said)
        else:
            raise checks.CheckFailed(f"{name} has no value: its cell stopped.")
    eval(compile(exercise.call, "check", "eval"), space)


def judge_task(mine: task.Task, closed: box.Box) -> None:
    """Judge the result of a task that was handed in in the box."""
    results = closed.ask(box.CALLING, do="handed")
    if not results:
        raise checks.CheckFailed("nothing was handed in for other data.")
    parts = mine.judged(plain.unpacked(results[-1]))
    most = [p.allowed * (SLACK if p.unit == DEVIATIONS else 1) for p in parts]
    wrong = [str(p) for p, allowed in zip(parts, most) if not p.off <= allowed]
    if wrong:
        raise checks.CheckFailed("with other data, " + "; ".join(wrong) + ".")


@functools.cache
def _space(lesson: str, call: str, answers: tuple[str, ...]) -> dict:
    """Return what the call of a check takes from the solved notebook."""
    used = intake.names_of(call).used
    names: dict = {"__name__": "__main__"}
    with plt.rc_context():
        cells = tuple(itertools.chain(*map(intake.statements, code_of(lesson))))
        for cell in intake.needed(cells, used - set(answers)):
            exec(compile(cell, "notebook", "exec"), names)
    return names


# --- A class ---


def graded(
    submissions: list[intake.Submission],
    asked: list[Exercise],
    secret: str,
    trusted: bool = False,
    workers: int | None = None,
) -> dict[str, list[Mark]]:
    """Return the marks of each student, with a bar of the progress."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        whole = place / "library"
        whole.mkdir()
        library.write_library(whole)
        for exercise in asked:
            target = place / f"{exercise.lesson}-{exercise.name}"
            library.without(whole, target, exercise.books_own)
        jobs = [(one, asked, place, secret, trusted) for one in submissions]
        with contextlib.ExitStack() as stack:
            spawn = multiprocessing.get_context("spawn")
            # Pools of one, since a pool of several breaks as a whole; no program of
            # the lecturer's lies in the folder.
            free: queue.SimpleQueue[ProcessPoolExecutor] = queue.SimpleQueue()

            def fresh() -> ProcessPoolExecutor:
                pool = ProcessPoolExecutor(1, spawn, os.chdir, (folder,))
                return stack.enter_context(pool)

            def tried(job: tuple) -> list[Mark] | str:
                """Return a student's marks, or why there are none."""
                pool = free.get()
                try:
                    return pool.submit(_student, job).result()
                except BrokenProcessPool:
                    pool = fresh()
                    return "the process that grades was killed twice"
                except Exception as error:  # of the judge's, at a stranger's answer
                    return f"{type(error).__name__}: {str(error)[:300]}"
                finally:
                    free.put(pool)

            count = workers or os.cpu_count() or 1
            for _ in range(count):
                free.put(fresh())
            with ThreadPoolExecutor(count) as threads:
                bar = tqdm(threads.map(tried, jobs), total=len(jobs), unit=" students")
                found = list(bar)
            # Who was lost is tried alone: there may be memory enough then.
            found = [
                tried(job) if isinstance(marks, str) else marks
                for marks, job in zip(found, jobs)
            ]
        return {
            one.student: lost(asked, marks) if isinstance(marks, str) else marks
            for one, marks in zip(submissions, found)
        }


def lost(asked: list[Exercise], why: str) -> list[Mark]:
    """Return the marks of a student whom nobody could grade."""
    said = f"it could not be graded, because {why}."
    return [Mark(e.lesson, e.name, 0.0, e.most, (), said, (said,)) for e in asked]


def _student(job: tuple) -> list[Mark]:
    """Return the marks of one student."""
    submission, asked, place, secret, trusted = job
    return [marked(e, submission, place, secret, trusted=trusted) for e in asked]


def handed_in(
    submissions: list[intake.Submission], asked: list[Exercise]
) -> list[Exercise]:
    """Return the exercises of the lessons from which anything was handed in."""
    lessons = {lesson_of(n) for one in submissions for n in one.notebooks}
    names = set().union(*(intake.names_of(one.program).bound for one in submissions))
    lessons |= {number for one in submissions for number in one.tasks}
    lessons |= {e.lesson for e in asked if names & set(e.names) and e.books_own}
    return [exercise for exercise in asked if exercise.lesson in lessons]


def main(arguments: list[str] | None = None) -> int:
    """Grade a class and write its tables and pages; return 1 if that is refused."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("submissions", help="a folder, or Moodle's zip")
    parser.add_argument("lessons", nargs="*", help="such as 2 2c A1; all, if none")
    parser.add_argument("--rubric", type=Path, default=RUBRIC)
    parser.add_argument("--secret", help="your word for the hidden data; kept if none")
    parser.add_argument("--trusted", action="store_true", help="run without a box")
    parser.add_argument("--to", type=Path, default=ROOT / "build" / "grades")
    options = parser.parse_intermixed_args(arguments)
    why = "" if options.trusted else box.closed()
    if why:
        print(
            f"grade: {why}. Without a box a submission may do on this computer all that"
            " you may. If you trust each of them, say so: TRUSTED=yes (--trusted).",
            file=sys.stderr,
        )
        return 1
    try:
        if not options.submissions:
            raise ValueError("which submissions? make grade SUBMISSIONS=folder")
        submissions = intake.read(Path(options.submissions))
        asked = exercises(options.rubric)
        known = {exercise.lesson for exercise in asked}
        if unknown := set(options.lessons or []) - known:
            raise ValueError(f"lessons: {min(unknown)} is not in the rubric")
        asked = (
            [exercise for exercise in asked if exercise.lesson in options.lessons]
            if options.lessons
            else handed_in(submissions, asked)
        )
        secret = options.secret or kept_secret(options.to)
        if len(secret) < SHORTEST:
            raise ValueError(
                f"secret: {SHORTEST} characters or more, or students who try all words"
                " find the hidden data; without SECRET= a word is drawn for you"
            )
    except (OSError, ValueError) as error:
        print(f"grade: {error}", file=sys.stderr)
        return 1
    marks = graded(submissions, asked, secret, options.trusted)
    written = feedback.write(
        options.to, submissions, asked, marks, [*notebooks().values()], options.trusted
    )
    print(*written, sep="\n")
    return 0


def kept_secret(folder: Path) -> str:
    """Return the word of a folder of grades, so that a second run gives the same."""
    path = folder / "secret.txt"
    if not path.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(secrets.token_hex(8) + "\n", encoding="utf-8")
    return path.read_text(encoding="utf-8").strip()


if __name__ == "__main__":
    sys.exit(main())
