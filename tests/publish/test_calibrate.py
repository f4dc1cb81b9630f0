"""The lens and the photos of lesson 6 in JupyterLab: real keys change them."""

from pathlib import Path

import nbformat
import pytest

from tests.publish.test_lab import LOADED, address, lab

NAME = "06_self_calibrating_bundle_adjustment"
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
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    shown = [c for c in code if "by_hand(" in c.source or "which_photos(" in c.source]
    notebook.cells = [code[0], *shown]
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


def test_keys_change_the_lens_and_the_list_of_photos(lab):
    page = lab(NAME)
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()
    sliders = page.locator(".jupyter-widgets .noUi-handle")
    sliders.nth(1).wait_for(timeout=LOADED)
    assert sliders.count() == 2
    grid = page.locator(".jp-Cell").nth(1).locator(".jp-OutputArea img").first
    grid.wait_for(timeout=LOADED)
    before = grid.get_attribute("src")
    sliders.nth(1).focus()
    page.keyboard.press("ArrowRight")
    another(page, grid, before)
    values = page.locator(".jupyter-widgets .widget-readout").all_inner_texts()
    assert values == ["3.00", "0.50"]

    network = page.locator(".jp-Cell").last.locator(".jp-OutputArea img").first
    network.wait_for(timeout=LOADED)
    before = network.get_attribute("src")
    page.locator(".jupyter-widgets select").select_option(
        label=["1", "4", "6", "7", "8"]
    )
    another(page, network, before)
