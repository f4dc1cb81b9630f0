"""Every stored notebook is whole and current; and the guard sees what is not."""

import base64
import json
from pathlib import Path

import nbformat
import pytest
from nbformat import v4

from pgm_book.make import form, notebooks
from pgm_book.make.errors import PublishError
from pgm_book.make.notebooks import RunFailed, code_sha256, execute, problems

STORED = sorted(notebooks.FOLDER.glob("*.ipynb"))
PNG = base64.b64encode(b"not looked at").decode()


@pytest.mark.parametrize("path", STORED, ids=lambda path: path.stem)
def test_stored_notebook_has_no_problem(path):
    assert problems(path) == []


def good() -> nbformat.NotebookNode:
    """A small notebook as `execute` leaves it: text, a solved exercise, a figure."""
    figure = v4.new_output(
        "display_data",
        {"image/png": PNG, "text/plain": "A parabola."},
        metadata={"image/png": {"alt": "A parabola.", "width": 400}},
    )
    exercise = "### BEGIN SOLUTION\ny = 2\n### END SOLUTION\nprint(y)"
    printed = v4.new_output("stream", name="stdout", text="2\n")
    notebook = v4.new_notebook(
        cells=[
            v4.new_markdown_cell("# A title"),
            v4.new_code_cell(exercise, execution_count=1, outputs=[printed]),
            v4.new_code_cell("draw()", execution_count=2, outputs=[figure]),
        ]
    )
    notebooks.normalize(notebook)
    return notebook


def stored(notebook: dict, folder: Path) -> Path:
    path = folder / "01_example.ipynb"
    path.write_text(json.dumps(notebook), encoding="utf-8")
    return path


def test_what_was_printed_in_pieces_is_stored_as_one():
    notebook = good()
    printed = ("stdout", "one "), ("stdout", "two\n"), ("stderr", "!"), ("stdout", "3")
    pieces = [v4.new_output("stream", name=name, text=text) for name, text in printed]
    figure = notebook.cells[2].outputs[0]
    notebook.cells[1].outputs = [*pieces, figure, pieces[-1].copy()]
    notebooks.normalize(notebook)
    found = [o.get("text", "picture") for o in notebook.cells[1].outputs]
    assert found == ["one two\n", "!", "3", "picture", "3"]


def test_a_good_notebook_has_no_problem(tmp_path):
    assert problems(stored(good(), tmp_path)) == []


STALE = "the code changed since its outputs were made: make notebooks"
COUNTS = "the execution counts do not run from 1 to n: make notebooks"
MARKERS = "cell 2 has solution markers that do not come in pairs"
WIDGET = v4.new_output("display_data", {notebooks.WIDGET_VIEW: {"model_id": "1"}})
ERROR = v4.new_output("error", ename="ValueError", evalue="no", traceback=[])


def strip_outputs(notebook):
    for cell in notebook.cells[1:]:
        cell.update(outputs=[], execution_count=None)


def code(number, source):
    """Write other code into a cell, and run it."""

    def change(notebook):
        notebook.cells[number].source = source
        notebook.metadata.pgm_lab.code_sha256 = code_sha256(notebook)

    return change


def outputs(*new):
    return lambda notebook: notebook.cells[1].update(outputs=list(new))


def prints(text):
    return outputs(v4.new_output("stream", name="stdout", text=text))


def counts(*numbers):
    def change(notebook):
        for cell, number in zip(notebook.cells[1:], numbers):
            cell.execution_count = number

    return change


def alt(text):
    return lambda notebook: (
        notebook.cells[2]
        .outputs[0]
        .update(metadata={"image/png": {"alt": text}} if text else {})
    )


def shown_as_html(text):
    return outputs(v4.new_output("display_data", {"text/html": ["<p>", text]}))


BREAKS = [
    (strip_outputs, "not every code cell was executed: make notebooks"),
    (counts(1, 3), COUNTS),
    (counts(2, 1), COUNTS),
    (lambda n: n.cells[2].update(source="draw(wide=True)"), STALE),
    (lambda n: n.cells.pop(), STALE),
    (lambda n: n.metadata.pop("pgm_lab"), STALE),
    (lambda n: n.metadata.update(widgets={}), "it stores widget state"),
    (outputs(WIDGET), "cell 2 stores a widget, which nobody will see"),
    (
        code(2, "import ipywidgets as w\nw.interact(draw, a=1)"),
        "cell 3 uses interact, which may wait for ever: plot.interact",
    ),
    (
        code(2, "out = Output()\nplot.interact(draw, a=slider)"),
        "cell 3 uses Output, which may wait for ever: plot.interact",
    ),
    (lambda n: n.metadata.pop("kernelspec"), "the kernelspec is not python3"),
    (
        lambda n: n.metadata.kernelspec.update(name="my-venv"),
        "the kernelspec is not python3",
    ),
    (lambda n: n.cells[0].pop("id"), "a cell has no id"),
    (outputs(ERROR), "cell 2 stores an error, ValueError"),
    (
        outputs(v4.new_output("stream", name="stderr", text="!")),
        "cell 2 stores a warning or an error message",
    ),
    (code(2, "draw()\n" * 26), "cell 3 has more than 25 lines of code"),
    (code(2, " \n"), "cell 3 is empty"),
    (code(1, "### BEGIN SOLUTION\ny = 2"), MARKERS),
    (code(1, "### END SOLUTION\ny = 2\n    ### BEGIN SOLUTION"), MARKERS),
    (alt(""), "cell 3 has a figure without alt text"),
    (alt(" "), "cell 3 has a figure without alt text"),
    (
        lambda n: n.cells[2].outputs[0].data.update({"image/png": "A" * 2_000_001}),
        "the file is larger than 2 MB",
    ),
    *(
        (shown, f"cell 2 shows a folder of the machine, {folder}...")
        for shown, folder in [
            (prints("in /home/ada/data.csv"), "/home/a"),
            (prints("'/tmp/ipykernel_1/2.py'"), "/tmp/i"),
            (prints("/Users/ada/data.csv"), "/Users/a"),
            (prints(r"C:\Users\ada\data.csv"), "C:\\Users\\"),
            (shown_as_html("/home/ada/data.csv</p>"), "/home/a"),
        ]
    ),
]


@pytest.mark.parametrize(("spoil", "finding"), BREAKS)
def test_each_break_is_found_and_nothing_else(tmp_path, spoil, finding):
    notebook = good()
    spoil(notebook)
    assert problems(stored(notebook, tmp_path)) == [finding]


@pytest.mark.parametrize(
    "text", ["https://example.org/home/ada", "data/home/a.csv", "a /tmp b", "3 /home"]
)
def test_ordinary_text_is_no_folder_of_the_machine(tmp_path, text):
    notebook = good()
    prints(text)(notebook)
    assert problems(stored(notebook, tmp_path)) == []


def test_execute_stores_outputs_and_hash(tmp_path):
    notebook = good()
    strip_outputs(notebook)
    notebook.cells[2].source = "import pathlib\nprint(y, pathlib.Path.cwd().name)"
    notebook.metadata.widgets = {}
    folder = tmp_path / "chapters"
    folder.mkdir()
    path = stored(notebook, folder)
    execute(path)
    assert problems(path) == []
    result = nbformat.read(path, as_version=4)
    assert result.cells[2].outputs[0].text == "2 chapters\n"
    assert "version" not in result.metadata.language_info
    assert path.read_bytes().endswith(b"}\n") and b"\r" not in path.read_bytes()

    first = path.read_bytes()
    execute(path)
    assert path.read_bytes() == first, "running again has to give the same file"


@pytest.mark.slow
def test_of_a_widget_only_what_it_draws_is_stored(tmp_path):
    notebook = good()
    notebook.cells[2].source = (
        "import ipywidgets\nfrom pgm_lab import plot\n\n"
        "def turn(angle):\n    print(angle)\n\n"
        "plot.interact(turn, angle=ipywidgets.IntSlider(2))"
    )
    path = stored(notebook, tmp_path)
    execute(path)
    assert problems(path) == []
    (output,) = nbformat.read(path, as_version=4).cells[2].outputs
    assert output.data == {"text/plain": "2"}


def test_a_failed_run_leaves_the_file_alone(tmp_path):
    notebook = good()
    notebook.cells[2].source = "1 / 0"
    path = stored(notebook, tmp_path)
    before = path.read_bytes()
    with pytest.raises(RunFailed, match="01_example.ipynb was left as it was") as info:
        execute(path)
    assert "1 / 0" in str(info.value)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_names_choose_notebooks(tmp_path):
    path = stored(good(), tmp_path)
    other = path.rename(tmp_path / "02_other.ipynb")
    path = stored(good(), tmp_path)
    assert form.choose(tmp_path, []) == [path, other]
    for name in ("01", "01_example", "notebooks/01_example.ipynb"):
        assert form.choose(tmp_path, [name]) == [path]
    with pytest.raises(PublishError, match="is called '03'.*: 01_example, 02_other"):
        form.choose(tmp_path, ["03"])
