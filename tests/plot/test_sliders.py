"""A figure that follows sliders, in a running notebook without anybody before it."""

import asyncio
from copy import deepcopy

import pytest
from ipywidgets import HTML
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


@pytest.fixture(scope="module")
def played():
    """The outputs of the first cell after each cell, and the models of the page."""
    notebook = new_notebook(cells=[new_code_cell(cell) for cell in CELLS])
    shown, models = [], []
    client = NotebookClient(
        notebook,
        kernel_name="python3",
        timeout=60,
        on_cell_executed=lambda **_: shown.append(deepcopy(notebook.cells[0].outputs)),
    )
    opened = client.comm_open_handlers["jupyter.widget"]
    client.comm_open_handlers["jupyter.widget"] = lambda message: (
        models.append(message["content"]["data"]["state"]["_model_name"]),
        opened(message),
    )[1]
    asyncio.run(client.async_execute())
    assert all(not cell.outputs for cell in notebook.cells[1:]), "shown elsewhere"
    return shown, models


def test_the_figure_of_the_cell_follows_its_sliders(played):
    said = "7 at 1 m", "7 at 3 m", "5 at 3 m"
    for (*sliders, output), words in zip(played[0][:3], said, strict=True):
        assert len(sliders) == 2
        assert output["data"]["text/plain"] == words
        assert "image/png" in output["data"]
        assert output["metadata"]["image/png"]["alt"] == words


def test_what_is_printed_takes_the_place_of_the_figure(played):
    *sliders, output = played[0][3]
    assert len(sliders) == 2 and output["data"] == {"text/plain": "lost at 8"}


def test_nothing_waits_for_an_answer(played):
    """No widget takes outputs: its partner in nbclient loses a message in eight."""
    assert "IntSliderModel" in played[1]
    assert "OutputModel" not in played[1]


def test_every_widget_with_a_value_will_do(capsys):
    plot.interact(lambda text: print(text), text=HTML("<b>7</b>"))
    assert "<b>7</b>" in capsys.readouterr().out
