"""What a reader does in JupyterLab: runs all cells, scrolls, moves sliders."""

import time
import urllib.request
from pathlib import Path

import nbformat

LOADED = 60_000  # ms that JupyterLab may take to open
RUN = 120_000  # ms that all cells of a lesson may take
SOON = 30_000  # ms; the machine may be busy with other tests


def chosen(path: Path, texts: list[str]) -> nbformat.NotebookNode:
    """A notebook of the cells that hold these texts, not run."""
    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    notebook.cells = [next(c for c in code if text in c.source) for text in texts]
    for cell in notebook.cells:
        cell.outputs, cell.execution_count = [], None
    return notebook


def wait_for(url, process):
    """Wait until the server answers."""
    for _ in range(300):
        assert process.poll() is None, "JupyterLab does not start"
        try:
            return urllib.request.urlopen(url, timeout=2).close()
        except OSError:
            time.sleep(0.2)
    raise AssertionError("JupyterLab does not answer")


def run(page):
    """Run all cells from the menu."""
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()


def scroll_until(page, there):
    """Scroll down the notebook until something is there."""
    panel = page.locator(".jp-WindowedPanel-outer")
    for _ in range(LOADED // 200):
        if there():
            return
        panel.evaluate("panel => panel.scrollBy(0, 400)")
        page.wait_for_timeout(200)


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
