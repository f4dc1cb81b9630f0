"""The target of lesson 1 in JupyterLab: one of its sliders, really moved."""

import matplotlib.pyplot as plt
import pytest
from IPython.utils.capture import capture_output

from pgm_book.ch01 import figures as target
from pgm_lab.plot import STYLE, basic
from tests.publish.sliders import LOADED, address, lab, lesson, run, shows, work

NAME = "01_pixel_to_photo"
CELLS = ["plt.style.use", "target_by_hand()"]
__all__ = ["address", "lab", "lesson", "work"]


@pytest.fixture
def drawn(monkeypatch):
    """A function that returns the picture of a window, as the page should show it."""
    held: dict = {}
    monkeypatch.setattr(target, "interact", lambda f, **_: held.update(draw=f))
    with capture_output():
        target.target_by_hand()
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
    run(page)
    handles = page.locator(".widget-slider .noUi-handle")
    handles.first.wait_for(timeout=LOADED)
    handles.first.scroll_into_view_if_needed()
    image = page.locator(".jp-OutputArea", has=handles.first).locator("img").last

    def wait_for(size, shift, background):
        wanted = drawn(size, shift, background)
        assert shows(page, image, wanted), (
            f"window {size}, {shift}, {background} is not shown"
        )

    wait_for(21, 4, 0)
    handles.nth(1).focus()
    for _ in range(2):
        page.keyboard.press("ArrowLeft")
    wait_for(21, 2, 0)
