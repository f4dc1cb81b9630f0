"""Every stored notebook is whole and current; and the guard sees what is not."""

import base64
import json
from pathlib import Path

import nbformat
import pytest
from nbformat import v4

from pgm_book.make import notebooks
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


def renew_hash(notebook):
    notebook.metadata.pgm_lab.code_sha256 = code_sha256(notebook)


def strip_outputs(notebook):
    for cell in notebook.cells[1:]:
        cell.update(outputs=[], execution_count=None)


def skip_a_count(notebook):
    notebook.cells[2].execution_count = 3


def run_out_of_order(notebook):
    notebook.cells[1].execution_count, notebook.cells[2].execution_count = 2, 1


def edit_code(notebook):
    notebook.cells[2].source = "draw(wide=True)"


def delete_a_cell(notebook):
    del notebook.cells[2]


def drop_the_hash(notebook):
    del notebook.metadata["pgm_lab"]


def keep_widget_state(notebook):
    notebook.metadata.widgets = {"application/vnd.jupyter.widget-state+json": {}}


def keep_a_widget(notebook):
    view = {notebooks.WIDGET_VIEW: {"model_id": "1"}, "text/plain": "slider"}
    notebook.cells[1].outputs.append(v4.new_output("display_data", view))


def let_a_widget_take_the_output(notebook):
    notebook.cells[2].source = "import ipywidgets as w\nw.interact(draw, a=1)"
    renew_hash(notebook)


def let_a_widget_take_some_output(notebook):
    notebook.cells[2].source = "out = Output()\nplot.interact(draw, a=slider)"
    renew_hash(notebook)


def change_kernel(notebook):
    notebook.metadata.kernelspec.name = "my-venv"


def drop_kernel(notebook):
    del notebook.metadata["kernelspec"]


def drop_an_id(notebook):
    del notebook.cells[0]["id"]


def store_an_error(notebook):
    notebook.cells[1].outputs = [
        v4.new_output("error", ename="ValueError", evalue="no", traceback=[])
    ]


def store_a_warning(notebook):
    notebook.cells[1].outputs[0].name = "stderr"


def write_a_long_cell(notebook):
    notebook.cells[2].source = "\n".join(["draw()"] * 26)
    renew_hash(notebook)


def empty_a_cell(notebook):
    notebook.cells[2].source = " \n"
    renew_hash(notebook)


def lose_a_marker(notebook):
    cell = notebook.cells[1]
    cell.source = cell.source.replace("### END SOLUTION\n", "")
    renew_hash(notebook)


def swap_the_markers(notebook):
    notebook.cells[1].source = "### END SOLUTION\ny = 2\n    ### BEGIN SOLUTION"
    renew_hash(notebook)


def drop_alt_text(notebook):
    notebook.cells[2].outputs[0].metadata = {}


def blank_alt_text(notebook):
    notebook.cells[2].outputs[0].metadata["image/png"]["alt"] = " "


def show(text):
    def show_text(notebook):
        notebook.cells[1].outputs[0].text = text

    return show_text


def show_in_html(notebook):
    data = {"text/html": ["<p>", "/home/ada/data.csv</p>"], "text/plain": "data"}
    notebook.cells[1].outputs = [v4.new_output("display_data", data)]


def grow(notebook):
    notebook.cells[2].outputs[0].data["image/png"] = "A" * 2_000_001


STALE = "the code changed since its outputs were made: make notebooks"
WAITS = ", which may wait for ever: plot.interact"
COUNTS = "the execution counts do not run from 1 to n: make notebooks"
MARKERS = "cell 2 has solution markers that do not come in pairs"
FOLDER = "cell 2 shows a folder of the machine, "

BREAKS = [
    (strip_outputs, "not every code cell was executed: make notebooks"),
    (skip_a_count, COUNTS),
    (run_out_of_order, COUNTS),
    (edit_code, STALE),
    (delete_a_cell, STALE),
    (drop_the_hash, STALE),
    (keep_widget_state, "it stores widget state"),
    (keep_a_widget, "cell 2 stores a widget, which nobody will see"),
    (let_a_widget_take_the_output, "cell 3 uses interact" + WAITS),
    (let_a_widget_take_some_output, "cell 3 uses Output" + WAITS),
    (change_kernel, "the kernelspec is not python3"),
    (drop_kernel, "the kernelspec is not python3"),
    (drop_an_id, "a cell has no id"),
    (store_an_error, "cell 2 stores an error, ValueError"),
    (store_a_warning, "cell 2 stores a warning or an error message"),
    (write_a_long_cell, "cell 3 has more than 25 lines of code"),
    (empty_a_cell, "cell 3 is empty"),
    (lose_a_marker, MARKERS),
    (swap_the_markers, MARKERS),
    (drop_alt_text, "cell 3 has a figure without alt text"),
    (blank_alt_text, "cell 3 has a figure without alt text"),
    (show("in /home/ada/data.csv"), FOLDER + "/home/a..."),
    (show("'/tmp/ipykernel_1/2.py'"), FOLDER + "/tmp/i..."),
    (show("/Users/ada/data.csv"), FOLDER + "/Users/a..."),
    (show(r"C:\Users\ada\data.csv"), FOLDER + "C:\\Users\\..."),
    (show_in_html, FOLDER + "/home/a..."),
    (grow, "the file is larger than 2 MB"),
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
    show(text)(notebook)
    assert problems(stored(notebook, tmp_path)) == []


def test_execute_stores_outputs_and_hash(tmp_path):
    notebook = good()
    strip_outputs(notebook)
    notebook.cells[2].source = "import pathlib\nprint(y, pathlib.Path.cwd().name)"
    keep_widget_state(notebook)
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
    assert notebooks.chosen([], tmp_path) == [path]
    assert notebooks.chosen(["01_example"], tmp_path) == [path]
    assert notebooks.chosen(["notebooks/01_example.ipynb"], tmp_path) == [path]
    with pytest.raises(SystemExit, match="There is no notebook '02'.*only 01_example"):
        notebooks.chosen(["02"], tmp_path)
