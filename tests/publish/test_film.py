"""The start of lesson 3's film in JupyterLab: real keys move and turn it."""

from pathlib import Path

import nbformat
import pytest

from tests.publish.test_lab import LOADED, address, lab

NAME = "03_least_squares_matching"
SOON = 30_000  # ms; the machine may be busy with other tests
__all__ = ["address", "lab"]


@pytest.fixture(scope="module")
def lesson():
    """The notebook; its place tells where the package is."""
    return Path(__file__).resolve().parents[2] / "notebooks" / f"{NAME}.ipynb"


@pytest.fixture(scope="module")
def work(lesson, tmp_path_factory):
    """The folder that the lab opens: the notebook as far as the sliders, not run."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    notebook = nbformat.read(lesson, as_version=4)
    (last,) = [k for k, cell in enumerate(notebook.cells) if "by_hand(" in cell.source]
    code = [c for c in notebook.cells[: last + 1] if c.cell_type == "code"]
    notebook.cells = [code[0], code[1], code[-1]]
    for cell in notebook.cells:
        cell.outputs, cell.execution_count = [], None
    nbformat.write(notebook, folder / lesson.name)
    return folder


def another(page, picture, before):
    """The source of the picture once it is not the one before."""
    for _ in range(SOON // 200):
        page.wait_for_timeout(200)
        if picture.count() and (now := picture.get_attribute("src")) != before:
            return now
    raise AssertionError("the picture does not follow the slider")


def test_keys_on_the_sliders_move_and_turn_the_start_of_the_film(lab):
    page = lab(NAME)
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()
    sliders = page.locator(".jupyter-widgets .noUi-handle")
    sliders.nth(2).wait_for(timeout=LOADED)
    assert sliders.count() == 3
    picture = page.locator(".jp-Cell").last.locator(".jp-OutputArea img").first
    picture.wait_for(timeout=LOADED)
    before = picture.get_attribute("src")
    for k, key in ((0, "ArrowRight"), (2, "ArrowLeft")):
        sliders.nth(k).focus()
        page.keyboard.press(key)
        before = another(page, picture, before)
    values = page.locator(".jupyter-widgets .widget-readout").all_inner_texts()
    assert values == ["−3", "−4", "−1"]
