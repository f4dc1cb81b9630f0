"""The blunder of lesson A1 in JupyterLab: its list and its slider, really moved."""

import matplotlib.pyplot as plt
import nbformat
import pytest
from IPython.utils.capture import capture_output

from pgm_book.chA1 import figures as levelling
from pgm_lab.plot import STYLE, basic
from tests.publish.sliders import LOADED, address, lab, lesson, run, shows, work

NAME = "A1_least_squares_adjustment"
CELLS = ["observed = np.array", "measured = ", "blunder_by_hand"]
__all__ = ["address", "lab", "lesson", "work"]


@pytest.fixture
def drawn(lesson, monkeypatch):
    """A function that returns the picture of a blunder, as the page should show it."""
    notebook = nbformat.read(lesson, as_version=4)
    names: dict = {}
    sources = [c.source for c in notebook.cells if c.cell_type == "code"]
    kept = [s for s in sources if "observed = np.array" in s or "measured = " in s]
    with capture_output(), plt.rc_context():
        for source in kept:
            exec(source, names)
    held: dict = {}
    monkeypatch.setattr(levelling, "interact", lambda f, **_: held.update(draw=f))
    data = (names[n] for n in ("A", "p", "measured"))
    levelling.blunder_by_hand(*data, 0.002, names["lines"])
    shown: list = []
    monkeypatch.setattr(basic, "publish_display_data", lambda d, _: shown.append(d))

    def picture(line, size):
        with plt.rc_context(STYLE):
            held["draw"](line, size)
        assert f"{size:+d} mm in {line}" in shown[-1]["text/plain"]
        return shown[-1]["image/png"]

    return picture


def test_the_list_and_the_slider_draw_the_blunder_anew(lab, drawn):
    page = lab(NAME)
    run(page)
    choice = page.locator(".widget-dropdown select").first
    choice.wait_for(timeout=LOADED)
    choice.scroll_into_view_if_needed()
    image = page.locator(".jp-OutputArea", has=choice).locator("img").last

    def wait_for(line, size):
        wanted = drawn(line, size)
        assert shows(page, image, wanted), f"{size} mm in {line} are not shown"

    wait_for("AB", 20)
    choice.select_option("DE")
    wait_for("DE", 20)
    handle = page.locator(".widget-slider .noUi-handle").first
    handle.click()
    for _ in range(4):  # steps of 2 mm
        page.keyboard.press("ArrowLeft")
    wait_for("DE", 12)
