"""A figure that follows sliders, in a running notebook without anybody before it."""

import pytest
from ipywidgets import HTML, IntSlider
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell, new_notebook

from pgm_lab import plot

CELLS = [
    """\
import matplotlib.pyplot as plt
from ipywidgets import IntSlider

from pgm_lab import plot

def draw(height, name):
    if height > 4:
        print("lost at", height)
        return
    fig, ax = plt.subplots(figsize=(1, 1))
    plot.show(fig, f"{name} at {height} m", dpi=20)

height, name = IntSlider(1, 0, 9), IntSlider(7, 0, 9)
plot.interact(draw, height=height, name=name)""",
    "height.value = 3",
    "name.value = 5",
    "height.value = 8",
]


def shown_after(moves):
    """The output of the first cell, below its two sliders, after some moves."""
    notebook = new_notebook(cells=[new_code_cell(cell) for cell in CELLS[: 1 + moves]])
    NotebookClient(notebook, kernel_name="python3", timeout=60).execute()
    *sliders, output = notebook.cells[0].outputs
    assert len(sliders) == 2
    assert all(not cell.outputs for cell in notebook.cells[1:]), "shown elsewhere"
    return output


@pytest.mark.parametrize(
    ("moves", "words"), [(0, "7 at 1 m"), (1, "7 at 3 m"), (2, "5 at 3 m")]
)
def test_the_figure_of_the_cell_follows_its_sliders(moves, words):
    output = shown_after(moves)
    assert output["data"]["text/plain"] == words
    assert "image/png" in output["data"]
    assert output["metadata"]["image/png"]["alt"] == words


def test_what_is_printed_takes_the_place_of_the_figure():
    assert shown_after(3)["data"] == {"text/plain": "lost at 8"}


def test_nothing_waits_for_an_answer():
    """No widget takes outputs: its partner in nbclient loses a message in eight."""
    notebook = new_notebook(cells=[new_code_cell(CELLS[0])])
    client = NotebookClient(notebook, kernel_name="python3", timeout=60)
    models = []
    opened = client.comm_open_handlers["jupyter.widget"]
    client.comm_open_handlers["jupyter.widget"] = lambda message: (
        models.append(message["content"]["data"]["state"]["_model_name"]),
        opened(message),
    )[1]
    client.execute()
    assert "IntSliderModel" in models
    assert "OutputModel" not in models


@pytest.mark.parametrize(
    ("draw", "slider", "message"),
    [
        ("draw", IntSlider(), "draw must be a function"),
        (print, 3, "size must be a widget with a value"),
        (print, None, "size must be a widget with a value"),
        (print, IntSlider, "size must be a widget with a value"),
    ],
)
def test_what_is_no_slider_is_refused(draw, slider, message):
    with pytest.raises(ValueError, match=message):
        plot.interact(draw, size=slider)


def test_every_widget_with_a_value_will_do(capsys):
    plot.interact(lambda text: print(text), text=HTML("<b>7</b>"))
    assert "<b>7</b>" in capsys.readouterr().out
