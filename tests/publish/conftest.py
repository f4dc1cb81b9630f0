"""Make every deck once, and open it with the network cut.

A missing browser or package is a failure here, not a reason to skip.
"""

import os
import random
import socket
import subprocess
import sys
import time
from pathlib import Path

import nbformat
import pytest

from pgm_book.make.browser import offline_context, open_browser
from pgm_book.make.page import slides_page
from pgm_book.make.site.build import build as build_site
from pgm_book.make.slides import for_slides
from tests import trial
from tests.publish.example import example, quick_questions
from tests.publish.lab import LOADED, wait_for
from tests.publish.watch import Deck, Watched, written

ROOT = Path(__file__).resolve().parents[2]
CHAPTERS = {p.stem: p for p in sorted((ROOT / "notebooks").glob("[0-9A-Z]*.ipynb"))}


def pytest_configure(config):
    """Bear with what Sphinx and MyST will have to change one day."""
    old = "ignore::PendingDeprecationWarning:(sphinx|myst_parser)"
    config.addinivalue_line("filterwarnings", old)


@pytest.fixture(scope="session", autouse=True)
def browser():
    """The browser, started before any test is watched for what it leaves behind."""
    with open_browser() as browser:
        yield browser


@pytest.fixture
def watched(browser):
    """An empty page that is watched."""
    context = offline_context(browser)
    yield Watched(context)
    context.close()


@pytest.fixture(scope="session")
def lesson(tmp_path_factory) -> Path:
    """The lesson that the skeleton makes."""
    return trial.lesson(tmp_path_factory.mktemp("project"))


@pytest.fixture(scope="session")
def small(tmp_path_factory) -> Path:
    """A notebook that has a bit of everything."""
    path = tmp_path_factory.mktemp("notebooks") / "01_example.ipynb"
    nbformat.write(example(quick_questions()), path)
    return path


@pytest.fixture(scope="session", params=["example", "lesson", *CHAPTERS])
def chapter(request) -> Path:
    """Each real notebook, the skeleton's, and one that has a bit of everything."""
    made = {"example": "small", "lesson": "lesson"}.get(request.param)
    return request.getfixturevalue(made) if made else CHAPTERS[request.param]


@pytest.fixture(scope="session")
def notebook(chapter):
    return nbformat.read(chapter, as_version=4)


@pytest.fixture(scope="session")
def prepared(chapter, notebook) -> list:
    """The cells of the lecturer's deck."""
    return for_slides(notebook, "lecturer", chapter.stem).cells


@pytest.fixture(scope="session")
def slides_file(chapter, tmp_path_factory) -> Path:
    """The lecturer's deck; the students' is a part of it."""
    return written(tmp_path_factory.mktemp("build"), slides_page(chapter))


@pytest.fixture(scope="session")
def slides(browser, slides_file):
    """The slides in the browser, every fragment shown; each was looked at once."""
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    yield Deck(context, slides_file)
    context.close()


@pytest.fixture(scope="session")
def lesson_decks(browser, lesson, tmp_path_factory):
    """The lecturer's and the students' deck of the skeleton's lesson."""
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    pages = [slides_page(lesson, audience) for audience in ("lecturer", "student")]
    yield [
        Deck(context, written(tmp_path_factory.mktemp("build"), page)) for page in pages
    ]
    context.close()


@pytest.fixture(scope="session")
def site_folder(tmp_path_factory, worker_id) -> Path:
    """The site of all chapters: built by the worker that needs it first, for all."""
    if worker_id == "master":
        return built_site(tmp_path_factory.mktemp("build")).parent
    folder = tmp_path_factory.getbasetemp().parent / "site"
    try:
        folder.mkdir()
    except FileExistsError:
        return other_s_site(folder)
    told = folder / "told.txt"
    try:
        built_site(folder)
    except BaseException as error:
        told.write_text(f"the site was not built: {error}", encoding="utf-8")
        raise
    told.write_text(BUILT, encoding="utf-8")
    return folder / "site"


BUILT = "built"
LONGEST_BUILD = 900  # seconds


def built_site(folder: Path) -> Path:
    """Build the site; Sphinx draws a random number and leaves another state."""
    state = random.getstate()
    try:
        return build_site(CHAPTERS.values(), folder)
    finally:
        random.setstate(state)


def other_s_site(folder: Path) -> Path:
    """Wait for the site that another worker builds."""
    told = folder / "told.txt"
    for _ in range(LONGEST_BUILD):
        words = told.read_text(encoding="utf-8") if told.exists() else ""
        if words:
            assert words == BUILT, words
            return folder / "site"
        time.sleep(1)
    raise AssertionError("the site was not built: its worker does not end")


# --- JupyterLab; a module of tests gives `work`, the folder that it opens ---


@pytest.fixture(scope="module")
def package() -> Path:
    """Where the lab finds the packages."""
    return ROOT


@pytest.fixture(scope="module")
def address(work, package):
    """A JupyterLab that knows no settings and no signatures of this machine."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    private = work.parent / "private"
    folders = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR",
               "JUPYTERLAB_SETTINGS_DIR", "JUPYTERLAB_WORKSPACES_DIR",
               "IPYTHONDIR")  # fmt: skip
    env = os.environ | {name: str(private / name.lower()) for name in folders}
    options = ["--no-browser", "--ip=127.0.0.1", f"--port={port}", "--allow-root"]
    with open(work.parent / "log.txt", "w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *options,
             "--IdentityProvider.token=", "--LabApp.news_url=None"],
            cwd=work, stdout=log, stderr=log, env=env | {"PYTHONPATH": str(package)},
        )  # fmt: skip
    try:
        url = f"http://127.0.0.1:{port}"
        wait_for(f"{url}/api/status", process)
        yield url
    finally:
        process.terminate()
        process.wait(30)


@pytest.fixture(scope="module")
def lab(browser, address):
    """A function that opens a notebook of the folder; only this machine is reached."""
    context = browser.new_context(viewport={"width": 1280, "height": 1000})
    page = context.new_page()

    def only_here(route):
        here = route.request.url.startswith((address, "data:", "blob:"))
        route.continue_() if here else route.abort()

    context.route("**/*", only_here)

    def opened(name):
        page.goto(f"{address}/lab/tree/{name}.ipynb?reset")
        page.locator(".jp-Notebook .jp-Cell").first.wait_for(timeout=LOADED)
        page.get_by_text("| Idle").wait_for(timeout=LOADED)  # its kernel has started
        return page

    yield opened
    context.close()
