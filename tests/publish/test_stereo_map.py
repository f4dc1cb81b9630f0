"""StereoMap in JupyterLab: real clicks into its canvas, and the file that they give."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from pgm_lab.observations import COLUMNS
from tests.publish.test_lab import LOADED, address, lab, run_all

NAME = "08_stereo_map"
SOON = 20_000  # ms; the machine may be busy with other tests
__all__ = ["address", "lab"]


@pytest.fixture(scope="module")
def lesson():
    """The notebook; its place tells where the package is."""
    return Path(__file__).resolve().parents[2] / "notebooks" / f"{NAME}.ipynb"


@pytest.fixture(scope="module")
def work(lesson, tmp_path_factory):
    """The folder that the lab opens, with a copy of the notebook."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    shutil.copy(lesson, folder)
    return folder


class Screen:
    """What a reader sees of the program, and does with it."""

    def __init__(self, page):
        self.page = page
        self.canvas = page.locator(".jupyter-matplotlib-canvas-div").first
        self.canvas.wait_for(timeout=LOADED)
        self.canvas.scroll_into_view_if_needed()
        self.message = page.locator(".stereo-map-message").first
        self.points = page.locator(".stereo-map-points").first

    def at(self, share):
        """Place of the page at a share of the width and height of the canvas."""
        box = self.canvas.bounding_box()
        return box["x"] + share[0] * box["width"], box["y"] + share[1] * box["height"]

    def click(self, share, answer):
        self.page.mouse.click(*self.at(share))
        self.wait(self.message, answer)

    def press(self, name, where, answer):
        self.page.get_by_role("button", name=name, exact=True).first.click()
        self.wait(where, answer)

    def wait(self, where, text):
        where.filter(has_text=text).wait_for(timeout=SOON)

    def rows(self):
        """Numbers of the points in the table."""
        cells = self.points.locator("tr td:first-child")
        return cells.all_inner_texts()


def test_clicks_measure_keep_undo_and_save(lab, work):
    page = lab(NAME)
    run_all(page, work / f"{NAME}.ipynb")
    screen = Screen(page)
    screen.click((0.12, 0.2), "r = ")  # a field in the left photo
    assert "Found." in screen.message.inner_text()
    assert "Object: X = " in screen.message.inner_text()
    screen.press("Keep", screen.points, "y parallax")
    screen.click((0.16, 0.5), "r = ")
    screen.press("Keep", screen.message, "Kept as point 2.")
    assert screen.rows() == ["1", "2"]
    screen.press("Undo", screen.message, "The last point is gone.")
    assert screen.rows() == ["1"]
    page.mouse.move(*screen.at((0.12, 0.2)))
    page.mouse.wheel(0, -300)  # a zoom: the same click is another pixel now
    screen.press("Save", screen.message, "1 points are saved")
    table = np.loadtxt(work / "my_points.csv", comments="%", delimiter=",")
    assert table.shape == (2, len(COLUMNS))
    assert table[:, 0].tolist() == [1, 1] and table[:, 1].tolist() == [1, 2]
