"""The target of lesson 1 in JupyterLab: one of its sliders, really moved."""

from pathlib import Path

import matplotlib.pyplot as plt
import nbformat
import pytest
from IPython.utils.capture import capture_output

from pgm_lab.plot import STYLE, basic, target
from tests.publish.test_lab import LOADED, address, lab

NAME = "01_pixel_to_photo"
SOON = 20_000  # ms; the machine may be busy with other tests
__all__ = ["address", "lab"]


@pytest.fixture(scope="module")
def lesson():
    """The notebook; its place tells where the package is."""
    return Path(__file__).resolve().parents[2] / "notebooks" / f"{NAME}.ipynb"


@pytest.fixture(scope="module")
def work(lesson, tmp_path_factory):
    """The folder that the lab opens: the imports, and the cell of the sliders."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    notebook = nbformat.read(lesson, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    notebook.cells = [
        next(cell for cell in code if begin in cell.source)
        for begin in ("plt.style.use", "target.by_hand")
    ]
    nbformat.write(notebook, folder / lesson.name)
    return folder


@pytest.fixture
def drawn(monkeypatch):
    """A function that returns the picture of a window, as the page should show it."""
    held: dict = {}
    monkeypatch.setattr(target, "interact", lambda f, **_: held.update(draw=f))
    with capture_output():
        target.by_hand()
    shown: list = []
    monkeypatch.setattr(basic, "publish_display_data", lambda d, _: shown.append(d))

    def picture(size, shift, background):
        with plt.rc_context(STYLE):
            held["draw"](size, shift, background)
        assert (
            f"moved by {shift} px, background {background}" in shown[-1]["text/plain"]
        )
        return shown[-1]["image/png"]

    return picture


def test_the_sliders_draw_the_window_and_its_centroid_anew(lab, drawn):
    page = lab(NAME)
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()
    handles = page.locator(".widget-slider .noUi-handle")
    handles.first.wait_for(timeout=LOADED)
    handles.first.scroll_into_view_if_needed()
    image = page.locator(".jp-OutputArea", has=handles.first).locator("img").last

    def wait_for(size, shift, background):
        wanted = drawn(size, shift, background)
        for _ in range(SOON // 200):
            if image.count():
                source = image.get_attribute("src")
                if "".join(source.partition("base64,")[2].split()) == wanted:
                    return
            page.wait_for_timeout(200)
        raise AssertionError(f"window {size}, {shift}, {background} is not shown")

    wait_for(21, 4, 0)
    handles.nth(1).focus()
    for _ in range(2):
        page.keyboard.press("ArrowLeft")
    wait_for(21, 2, 0)
