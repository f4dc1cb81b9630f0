"""A reader's copy in JupyterLab: Run All, predictions that wait, and trust.

JupyterLab drops styles from the stored outputs of a notebook that it does not trust:
one that was neither run nor saved on this machine. A reader's copy stores no outputs.
"""

import shutil

import nbformat
import pytest

from pgm_book.make import work_copy
from pgm_book.make.student import PROGRAM
from tests.publish.lab import RUN, run, scroll_until


@pytest.fixture(scope="module")
def package(lesson):
    """The project in which the lesson was begun."""
    return lesson.parents[1]


@pytest.fixture(scope="module")
def work(lesson, tmp_path_factory):
    """The folder that the lab opens, and in it the solved original under a name."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    work_copy.update(lesson.parent, folder)
    work_copy.begin_program(folder)
    shutil.copy(lesson, folder / "original.ipynb")
    return folder


def run_all(page, path):
    """Run all cells from the menu, and save until the last of them is stored as run."""
    run(page)
    for _ in range(RUN // 500):
        page.wait_for_timeout(500)
        page.keyboard.press("Control+s")
        stored = nbformat.read(path, as_version=4)
        code = [cell for cell in stored.cells if cell.cell_type == "code"]
        if code[-1].execution_count and code[-1].outputs:
            return stored
    raise AssertionError("the last cell was not run")


def prediction(page):
    """Scroll to the prediction; return the outputs of its cell."""
    area = page.locator(".jp-OutputArea", has=page.locator(".pgm-predict"))
    scroll_until(page, area.count)
    area.first.scroll_into_view_if_needed()
    return area.first


def assert_it_waits(area):
    """The result is hidden until a choice is open, and one choice closes the other."""
    result = area.locator(".jp-OutputArea-child").nth(1)
    assert not result.is_visible()
    assert not area.locator(".pgm-shown").is_visible()
    for k in range(2):
        area.locator("summary").nth(k).click()
        result.wait_for(state="visible")
        assert area.locator("details[open]").count() == 1


def test_run_all_of_an_unsolved_copy_and_its_prediction(lab, work):
    page = lab("97_trial")
    stored = run_all(page, work / "97_trial.ipynb")
    outputs = [o for cell in stored.cells for o in cell.get("outputs", [])]
    failed = [o for o in outputs if o.output_type == "error"]
    assert ["".join(one.traceback) for one in failed] == [
        "✗ ground_size returns nothing yet. Your turn!"
    ]
    (using,) = [cell for cell in stored.cells if "checks.own" in cell.source]
    assert using.outputs[0].text.startswith("ground_size: the book's own.")
    assert (work / PROGRAM).read_text(encoding="utf-8") == work_copy.FIRST_LINES
    assert_it_waits(prediction(page))
    # Opened again, it is trusted, because this machine made its outputs.
    assert_it_waits(prediction(lab("97_trial")))


def test_a_notebook_that_is_not_trusted_says_that_nothing_waits(lab):
    area = prediction(lab("original"))
    assert area.locator("style").count() == 0, "if it is kept, all is well without this"
    assert area.locator(".pgm-shown").is_visible()
    assert area.locator(".jp-OutputArea-child").nth(1).is_visible()
    sentence = area.locator("details p").first
    assert not sentence.is_visible()
    area.locator("summary").first.click()
    assert sentence.is_visible()
