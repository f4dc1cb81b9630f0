"""StereoMap in JupyterLab: real clicks into its canvas, and the file that they give."""

import re

import nbformat
import numpy as np
import pytest

from pgm_lab import camera, simulate, stereo_map
from pgm_lab.observations import RAY
from pgm_lab.stereo_map import program
from tests.publish.conftest import CHAPTERS
from tests.publish.lab import SOON, run, scroll_until

NAME = "08_stereo_map"


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """The folder that the lab opens: the notebook as far as the program's cell."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    notebook = nbformat.read(CHAPTERS[NAME], as_version=4)
    (last,) = [
        k for k, cell in enumerate(notebook.cells) if "mine = program" in cell.source
    ]
    notebook.cells = notebook.cells[: last + 1]
    nbformat.write(notebook, folder / f"{NAME}.ipynb")
    return folder


class Screen:
    """What a reader sees of the program, and does with it."""

    def __init__(self, page, share):
        self.page, self.share = page, share
        self.canvas = page.locator(".jupyter-matplotlib-canvas-div").first
        scroll_until(page, self.canvas.count)
        self.canvas.scroll_into_view_if_needed()
        self.message = page.locator(".stereo-map-message").first
        self.points = page.locator(".stereo-map-points").first

    def at(self, pixel):
        """Place of the page where a pixel of the left photo is drawn."""
        x, y = self.share(pixel)
        box = self.canvas.bounding_box()
        return box["x"] + x * box["width"], box["y"] + y * box["height"]

    def click(self, pixel, answer):
        self.page.mouse.click(*self.at(pixel))
        self.wait(self.message, answer)

    def press(self, name, where, answer):
        self.page.get_by_role("button", name=name, exact=True).first.click()
        self.wait(where, answer)

    def wait(self, where, text):
        where.filter(has_text=text).wait_for(timeout=SOON)

    def rows(self, *numbers):
        """Wait until these points are in the table, which comes after the message."""
        sync_api = pytest.importorskip("playwright.sync_api")
        cells = self.points.locator("tr td:first-child")
        sync_api.expect(cells).to_have_text(list(numbers), timeout=SOON)


def left_photo(columns, rows):
    """Where the program draws a pixel, as shares of the canvas from the upper left."""
    blank = camera.Photo(np.eye(rows, columns), camera.Camera(24.0), np.zeros(6), 0.005)
    drawn = program.Program(stereo_map.open_pair(blank, blank))
    figure = drawn.canvas.figure
    figure.draw_without_rendering()
    to_screen = drawn.views[0].ax.transData

    def share(pixel):
        x, y = to_screen.transform(pixel) / (figure.bbox.width, figure.bbox.height)
        return x, 1 - y

    return share


def test_clicks_measure_keep_undo_and_save(lab, work):
    page = lab(NAME)
    run(page)
    screen = Screen(page, left_photo(1200, 800))
    screen.click((340, 230), "r = ")
    assert "Found." in screen.message.inner_text()
    assert "Object: X = " in screen.message.inner_text()
    screen.press("Keep", screen.points, "y parallax")
    screen.click((80, 560), "r = ")
    screen.press("Keep", screen.message, "Kept as point 2.")
    screen.rows("1", "2")
    screen.press("Undo", screen.message, "The last point was removed.")
    screen.rows("1")
    page.mouse.move(*screen.at((340, 230)))
    page.mouse.wheel(0, -300)  # a zoom: what was 60 pixels away is nearer now
    page.wait_for_timeout(1000)
    screen.click((400, 230), "Pixels: left")
    column = re.search(r"left \((\d+\.\d+)", screen.message.inner_text())[1]
    assert 345 < float(column) < 390
    screen.press("Save", screen.message, "1 point is saved")
    table = np.loadtxt(work / "my_points.csv", comments="%", delimiter=",")
    assert table.shape == (2, len(RAY))
    assert table[:, 0].tolist() == [1, 1] and table[:, 1].tolist() == [1, 2]


def test_save_counts_its_points_and_says_how_to_keep_an_old_file(tmp_path):
    pair = simulate.aerial_pair((240, 180))
    session = stereo_map.open_pair(pair.left, pair.right)
    session = stereo_map.add(session, stereo_map.measure(session, (100, 80)))
    path = tmp_path / "points.csv"
    first, second = (program.Program(session, path) for _ in range(2))
    for _ in range(2):  # the program may replace what it wrote itself
        first.buttons["Save"].click()
        assert first.message.value.startswith("1 point is saved in ")
    old = path.read_bytes()
    second.buttons["Save"].click()
    assert "already exists, and is not overwritten" in second.message.value
    assert "write another name beside the button" in second.message.value
    assert path.read_bytes() == old
