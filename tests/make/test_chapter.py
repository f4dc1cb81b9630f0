"""The skeleton of a chapter passes the tests at once, and a reader can work in it."""

import shutil

import nbformat
import pytest

from pgm_book.make import chapter, work_copy
from pgm_book.make.student import tags
from tests import kernels, trial

SOLUTION = '''def ground_size(pixel_mm, height_m, c_mm):
    """Mine."""
    return pixel_mm / c_mm * height_m  # the rays'''


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    """A folder in which a lesson and a case were begun, and are not executed yet."""
    folder = tmp_path_factory.mktemp("begun")
    for name in ("data/chapters.csv", "pyproject.toml"):
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copy(chapter.ROOT / name, folder / name)
    with pytest.MonkeyPatch.context() as elsewhere:
        elsewhere.setattr(chapter, "ROOT", folder)
        elsewhere.setattr(chapter, "TABLE", folder / "data" / "chapters.csv")
        chapter.begin("97", "trial")
    return folder


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A copy of the project with a lesson and a case that the command made."""
    folder = tmp_path_factory.mktemp("project")
    trial.begun(folder)
    return folder


EACH = [
    "tests/make/test_form.py::test_no_lesson_and_no_case_has_a_problem",
    "tests/make/test_notebooks.py::test_stored_notebook_has_no_problem",
    "tests/make/test_chapters.py::"
    "test_title_and_minutes_are_those_at_the_head_of_the_notebook",
    "tests/make/test_rerun.py::test_each_cell_can_be_run_again_after_all",
]
ONCE = [
    "tests/make/test_form.py::"
    "test_each_prediction_has_one_right_choice_and_a_sentence_on_each",
    "tests/make/test_notebooks.py::test_stored_notebook_has_no_problem[00_start_here]",
    "tests/make/test_chapters.py::test_the_table_in_readme_is_current",
    "tests/make/test_chapters.py::test_every_notebook_is_listed_once",
    "tests/make/test_house.py::test_the_map_in_docs_is_current",
    "tests/ch97/test_checks.py",
]


@pytest.mark.slow
def test_the_tests_pass_at_once(project):
    """Those that look at what the command wrote or changed."""
    pair = ["97_trial", "97_case_trial"]
    chosen = [
        *ONCE,
        *(f"{test}[{name}]" for test in EACH for name in pair),
        *(f"notebooks/{name}.ipynb" for name in pair),
    ]
    result = trial.run(project, "pytest", "--nbval", "-q", "-p", "no:xdist", *chosen)
    assert result.returncode == 0, result.stdout[-4000:]
    assert not (project / "notebooks" / "my_pgm.py").exists()
    readme = (project / "README.md").read_text(encoding="utf-8")
    assert "**97** [Trial](notebooks/97_trial.ipynb)" in readme


def test_what_was_written_is_well_formed(begun):
    files = [
        *(begun / "pgm_book" / "ch97").glob("*.py"),
        *(begun / "tests" / "ch97").glob("test_*.py"),
        *(begun / "notebooks").glob("97_*.ipynb"),
    ]
    assert len(files) == 6
    for command in (["check"], ["format", "--check"]):
        result = trial.run(begun, "ruff", *command, "--no-cache", *map(str, files))
        assert result.returncode == 0, result.stdout
    for path in files:
        text = path.read_text(encoding="utf-8")
        left = [word for word in ("NUMBER", "FILE", "LOWER", "TITLE") if word in text]
        assert left == [], path.name


def test_the_tables_list_it_and_its_case(begun):
    table = (begun / "data" / "chapters.csv").read_text(encoding="utf-8").splitlines()
    before = (chapter.TABLE).read_text(encoding="utf-8").splitlines()
    assert table[: len(before)] == before
    assert table[-2:] == [
        "97,97_trial,Trial,,Which question does this chapter answer?,,33,lesson,,",
        "97c,97_case_trial,Trial: the case,,What do the printed numbers prove?,,30,"
        "case,,",
    ]


@pytest.mark.parametrize(
    ("number", "name", "why"),
    [
        ("97", "trial", "chapter 97 exists already: .*97_trial"),
        ("97", "another", "chapter 97 exists already: .*ch97/checks.py"),
        ("0", "start", "chapter 0 exists already"),
        ("x", "trial", "the number must be like 10 or A3; got 'x'"),
        ("98", "Wrong name", "the name must be like cloud_shadows; got 'Wrong name'"),
    ],
)
def test_what_cannot_be_begun_is_refused(begun, monkeypatch, number, name, why):
    monkeypatch.setattr(chapter, "ROOT", begun)
    monkeypatch.setattr(chapter, "save", None)  # so that nothing can be written
    with pytest.raises(ValueError, match=why):
        chapter.begin(number, name)


@pytest.fixture
def work(begun, tmp_path):
    """The reader's folder, as `lab` makes it."""
    folder = tmp_path / "work"
    work_copy.update(begun / "notebooks", folder)
    work_copy.begin_program(folder)
    return folder


@pytest.mark.slow
def test_a_reader_works_through_the_lesson(project, work, monkeypatch):
    """Unsolved, solved, and with a slip afterwards, in one kernel."""
    monkeypatch.setenv("PYTHONPATH", str(project))
    program = work / "my_pgm.py"
    with kernels.started(work) as manager:
        printed, errors = run_all(work, manager)
        assert errors == ["ground_size returns nothing yet. Your turn!"]
        assert "ground_size: the book's own. Yours takes its place" in printed
        assert program.read_text(encoding="utf-8") == work_copy.FIRST_LINES

        printed, errors = run_all(work, manager, SOLUTION)
        assert errors == []
        assert "✓ ground_size is a part of your program now, my_pgm.py." in printed
        assert "ground_size: yours, from my_pgm.py." in printed
        kept = work_copy.FIRST_LINES + "\n\n" + SOLUTION + "\n"
        assert program.read_text(encoding="utf-8") == kept

        printed, errors = run_all(work, manager, SOLUTION.replace("*", "+"))
        assert len(errors) == 1 and "two triangles" in errors[0]
        assert "ground_size: yours, from my_pgm.py." in printed
        assert program.read_text(encoding="utf-8") == kept
    alone = "import my_pgm; print(my_pgm.ground_size(0.004, 120, 8))"
    assert trial.run(work, "-c", alone).stdout.startswith("0.06")


def run_all(work, kernel, solution=None):
    """Run the reader's lesson; return what it prints, and the errors it shows."""
    lesson = nbformat.read(work / "97_trial.ipynb", as_version=4)
    if solution:
        (cell,) = [c for c in lesson.cells if "exercise" in tags(c)]
        cell.source = solution
    kernels.run(lesson, work, kernel)
    outputs = [o for cell in lesson.cells for o in cell.get("outputs", [])]
    errors = [o.evalue for o in outputs if o.output_type == "error"]
    return "".join(o.text for o in outputs if o.output_type == "stream"), errors


def test_the_student_s_copy_has_the_derivations_but_not_the_claims(work):
    text = (work / "97_trial.ipynb").read_text(encoding="utf-8")
    for there in ("Derive it: why are the triangles", "Why: the answer", "Your reason"):
        assert there in text
    for gone in ("One assertion for each", "A good answer says", "SOLUTION", "notes"):
        assert gone not in text
