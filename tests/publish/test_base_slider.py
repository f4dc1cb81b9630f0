"""The slider of lesson 5, moved in JupyterLab: figure and text follow the base."""

from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from tests.publish.test_lab import RUN, address, lab, run_all  # noqa: F401

ROOT = Path(__file__).resolve().parents[2]
CELLS = [
    "from pgm_lab import plot\n\nplot.precision.base_by_hand()",
    'print("the end")',
]


@pytest.fixture(scope="module")
def lesson() -> Path:
    """The lesson; its package is the one that the lab imports."""
    return ROOT / "notebooks" / "05_intersection.ipynb"


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """A folder with a notebook that has the slider."""
    folder = tmp_path_factory.mktemp("slider") / "work"
    folder.mkdir()
    notebook = new_notebook(cells=[new_code_cell(cell) for cell in CELLS])
    notebook.metadata.kernelspec = {"name": "python3", "display_name": "Python 3"}
    nbformat.write(notebook, folder / "slider.ipynb")
    return folder


def said(notebook):
    """The text of the figure below the slider."""
    *_, output = notebook.cells[0].outputs
    assert "image/png" in output.data
    return output.data["text/plain"]


def test_one_move_of_the_slider_opens_the_base(lab, work):  # noqa: F811
    path = work / "slider.ipynb"
    page = lab("slider")
    before = said(run_all(page, path))
    assert "base 40 m, rays that meet at 19 degrees" in before
    assert "sigma X 7 mm, sigma Z 44 mm" in before
    handle = page.locator(".noUi-handle").first
    handle.focus()
    for _ in range(2):
        page.keyboard.press("ArrowRight")
    for _ in range(RUN // 500):
        page.wait_for_timeout(500)
        page.keyboard.press("Control+s")
        after = said(nbformat.read(path, as_version=4))
        if "base 80 m" in after:
            break
    # Twice the base: X as before, and half of the uncertainty of the height
    assert "base 80 m, rays that meet at 37 degrees" in after
    assert "sigma X 7 mm, sigma Z 22 mm" in after
