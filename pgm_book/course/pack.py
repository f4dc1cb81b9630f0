"""Make the course: a zip for students, one for instructors, a stick for a room.

``make course``, and ``make course WHEELS=windows,linux,macos`` for the stick.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from pgm_book.course import notes, stick
from pgm_book.course.feedback import PAGES
from pgm_book.make import archive, form
from pgm_book.make.environment import ROOT
from pgm_book.make.errors import PublishError
from pgm_book.make.student import FIRST_LINES, PROGRAM, student_copy, tags
from pgm_lab.io.files import save

STUDENTS, INSTRUCTORS = "pgm_lab-course-students", "pgm_lab-course-instructors"
LECTURERS = "pgm_book/course/", "pgm_book/make/"  # not in the students' library
WHEEL_OF = "pgm_lab", "pgm_book", "data"
LICENCES = "LICENSE", "LICENSE-CC-BY-4.0"

Files = dict[str, bytes]


def main(arguments: list[str] | None = None) -> int:
    """Make the zips, and the stick if asked to; say what was written."""
    parser = argparse.ArgumentParser(prog="python tasks.py course", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="lessons; all if none")
    parser.add_argument("--wheels", metavar="SYSTEMS", help="windows,linux,macos")
    parser.add_argument(
        "--pythons",
        metavar="VERSIONS",
        default="{}.{}".format(*sys.version_info),
        help="of the stick, such as 3.12,3.13",
    )
    parser.add_argument("--build", type=Path, default=ROOT / "build")
    options = parser.parse_args(arguments)
    try:
        targets = stick.targets(options.wheels, options.pythons)
        chosen = form.choose(ROOT / "notebooks", options.names)
        for path in course(chosen, options.build, targets):
            print(path, flush=True)
    except (PublishError, ValueError) as error:
        print(f"course: {error}", file=sys.stderr)
        return 1
    return 0


def course(
    notebooks: list[Path], build: Path, targets: list[stick.Target]
) -> Iterator[Path]:
    """Write ``build/course``; yield each zip, and the stick's folder."""
    folder = build / "course"
    wheel, library = wheels()
    students = student_files(notebooks, library)
    yield _zip(folder / f"{STUDENTS}.zip", students)
    publish("slides", notebooks, build)
    publish("handouts", notebooks, build)
    yield _zip(folder / f"{INSTRUCTORS}.zip", instructor_files(notebooks, build, wheel))
    if targets:
        publish("site", notebooks, build)
        room = students | archive.tree(build / "site", "site")
        for made, place in (("slides/student", "slides"), ("handouts", "handouts")):
            room |= published(notebooks, build / made, place)
        yield stick.write(folder / "stick", room, targets)


def _zip(path: Path, files: Files) -> Path:
    """Write files into a zip, in a folder of its name."""
    below = {f"{path.stem}/{name}": content for name, content in files.items()}
    save({path: archive.zipped(below)}, overwrite=True)
    return path


def publish(what: str, notebooks: list[Path], build: Path) -> None:
    """Make decks, handouts or the site, as the command of that name does."""
    names = [path.stem for path in notebooks]
    print(f"Making the {what} ...", flush=True)
    command = [sys.executable, "-m", "pgm_book.make", what, *names]
    command += ["--build", str(build)]
    if subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL).returncode:
        raise PublishError(f"the {what} have faults; they are named above.")


def published(notebooks: list[Path], folder: Path, below: str) -> Files:
    """Return what a folder has of these notebooks; it may have more, of before."""
    stems = {path.stem for path in notebooks}
    made = archive.tree(folder, below)
    return {name: data for name, data in made.items() if Path(name).stem in stems}


# --- The library ---


def wheels() -> tuple[Files, Files]:
    """Return the wheel of the project, and the one that students get."""
    with tempfile.TemporaryDirectory() as made:
        clean, out = Path(made, "clean"), Path(made, "out")
        # A copy: setuptools would put what was built before into the wheel, too.
        for name in WHEEL_OF:
            ignored = shutil.ignore_patterns("__pycache__", "*.egg-info")
            shutil.copytree(ROOT / name, clean / name, ignore=ignored)
        for name in ("pyproject.toml", "README.md", *LICENCES):
            shutil.copy(ROOT / name, clean)
        command = [sys.executable, "-m", "build", "--wheel", "--no-isolation"]
        done = subprocess.run(
            [*command, "--outdir", out], cwd=clean, capture_output=True, text=True
        )
        if done.returncode:
            raise PublishError(f"the wheel could not be built:\n{done.stderr}")
        (path,) = out.glob("*.whl")
        with zipfile.ZipFile(path) as opened:
            every = {name: opened.read(name) for name in opened.namelist()}
    return {path.name: archive.zipped(every)}, {
        path.name: archive.zipped(for_students(every))
    }


def for_students(wheel: Files) -> Files:
    """Return what a wheel holds without what makes and grades the course."""
    kept = {n: data for n, data in wheel.items() if not n.startswith(LECTURERS)}
    (record,) = (name for name in kept if name.endswith(".dist-info/RECORD"))
    lines = kept[record].decode().splitlines(keepends=True)
    listed = [line for line in lines if not line.startswith(LECTURERS)]
    return kept | {record: "".join(listed).encode()}


# --- What is in the zips ---


def student_files(notebooks: list[Path], wheel: Files) -> Files:
    """Return the students' files: nothing solved, and all that is needed to begin."""
    copies = {
        f"notebooks/{path.name}": _text(student_copy(nbformat.read(path, 4)))
        for path in notebooks
    }
    program = {f"notebooks/{PROGRAM}": FIRST_LINES.encode()}
    return copies | program | _to_begin(wheel, notebooks, "students")


def instructor_files(notebooks: list[Path], build: Path, wheel: Files) -> Files:
    """Return the instructor's files: solved notebooks, decks, paper, notes and keys."""
    from pgm_book.make.browser import open_browser

    files = {f"notebooks/{path.name}": path.read_bytes() for path in notebooks}
    for folder in ("slides/lecturer", "slides/student", "handouts"):
        files |= published(notebooks, build / folder, folder)
    with open_browser() as browser:
        printed = notes.print_notes(browser, notebooks)
    files |= {f"notes/{name}": pdf for name, pdf in printed.items()}
    for path in notebooks:
        solved = solutions(nbformat.read(path, as_version=4))
        files |= {f"solutions/{path.stem}.py": solved.encode()} if solved else {}
    files["TEACHING.md"] = (ROOT / "TEACHING.md").read_bytes()
    files["truths.py"] = _template("truths.py")
    return files | _to_begin(wheel, notebooks, "instructors")


def _to_begin(wheel: Files, notebooks: list[Path], audience: str) -> Files:
    """Return the start page, what sets up an environment, and the licences."""
    (name,) = wheel
    first = min(path.name for path in notebooks)
    page = PAGES.get_template("start.html.j2").render(
        audience=audience, first=first, wheel=name
    )
    files = {one: (ROOT / one).read_bytes() for one in (*LICENCES, "requirements.txt")}
    return (
        files | wheel | {"START.html": page.encode(), "start.py": _template("start.py")}
    )


def _template(name: str) -> bytes:
    return (Path(__file__).parent / "templates" / name).read_bytes()


def _text(notebook: NotebookNode) -> bytes:
    return (nbformat.writes(notebook) + "\n").encode()


def solutions(notebook: NotebookNode) -> str:
    """Return what is solved in a notebook as one text: exercises and the task."""
    solved = [
        f"# {'The task' if 'task' in tags(cell) else 'Exercise'}\n\n{cell.source}\n"
        for cell in notebook.cells
        if cell.cell_type == "code" and {"exercise", "task", "solution"} & {*tags(cell)}
    ]
    return "\n\n".join(solved)


if __name__ == "__main__":
    sys.exit(main())
