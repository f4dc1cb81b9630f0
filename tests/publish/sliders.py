"""What the tests of sliders share: some cells of a lesson in JupyterLab, and its keys.

A test module gives NAME, the notebook, and CELLS, a text that each of its cells holds;
`lesson` and `work` are its fixtures, beside `address` and `lab`.
"""

from pathlib import Path

import nbformat
import pytest

from tests.publish.test_lab import LOADED, address, lab

ROOT = Path(__file__).resolve().parents[2]
SOON = 30_000  # ms; the machine may be busy with other tests
__all__ = ["LOADED", "address", "lab"]


@pytest.fixture(scope="module")
def lesson(request):
    """The notebook; its place tells where the package is."""
    return ROOT / "notebooks" / f"{request.module.NAME}.ipynb"


@pytest.fixture(scope="module")
def work(request, lesson, tmp_path_factory):
    """The folder that the lab opens: the chosen cells of the notebook, not run."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    nbformat.write(chosen(lesson, request.module.CELLS), folder / lesson.name)
    return folder


def chosen(path, texts):
    """A notebook of the cells that hold these texts, not run."""
    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    notebook.cells = [next(c for c in code if text in c.source) for text in texts]
    for cell in notebook.cells:
        cell.outputs, cell.execution_count = [], None
    return notebook


def run(page):
    """Run all cells from the menu."""
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()


def another(page, picture, before):
    """The source of the picture once it is not the one before."""
    for _ in range(SOON // 200):
        page.wait_for_timeout(200)
        if picture.count() and (now := picture.get_attribute("src")) != before:
            return now
    raise AssertionError("the picture does not follow the slider")


def shows(page, picture, wanted):
    """Whether the picture becomes the wanted one, base64, to the last byte."""
    for _ in range(SOON // 200):
        if picture.count():
            source = picture.get_attribute("src")
            if "".join(source.partition("base64,")[2].split()) == wanted:
                return True
        page.wait_for_timeout(200)
    return False


def moved(page, count, keys, cell=-1):
    """Press keys on some of the sliders; return all their values, and the picture.

    The picture of the cell has to change with each key.
    """
    sliders = page.locator(".jupyter-widgets .noUi-handle")
    sliders.nth(count - 1).wait_for(timeout=LOADED)
    assert sliders.count() == count
    picture = page.locator(".jp-Cell").nth(cell).locator(".jp-OutputArea img").first
    picture.wait_for(timeout=LOADED)
    before = picture.get_attribute("src")
    for k, key in keys:
        sliders.nth(k).focus()
        page.keyboard.press(key)
        before = another(page, picture, before)
    values = page.locator(".jupyter-widgets .widget-readout").all_inner_texts()
    return [value.replace("−", "-") for value in values], picture
