"""Publish every chapter once, and open it with the network cut.

A missing browser or package is a failure here, not a reason to skip.
"""

from pathlib import Path

import nbformat
import pytest

from publish.browser import offline_context, open_browser
from tests import trial
from tests.publish.example import example
from tests.publish.watch import Watched, published

ROOT = Path(__file__).resolve().parents[2]
CHAPTERS = {p.stem: p for p in sorted((ROOT / "notebooks").glob("[0-9A-Z]*.ipynb"))}


@pytest.fixture(scope="session")
def browser():
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


@pytest.fixture(scope="session", params=["example", "lesson", *CHAPTERS])
def chapter(request, tmp_path_factory) -> Path:
    """Each real notebook, the skeleton's, and one that has a bit of everything."""
    if request.param == "lesson":
        return request.getfixturevalue("lesson")
    if request.param != "example":
        return CHAPTERS[request.param]
    path = tmp_path_factory.mktemp("notebooks") / "01_example.ipynb"
    nbformat.write(example(), path)
    return path


@pytest.fixture(scope="session")
def notebook(chapter):
    return nbformat.read(chapter, as_version=4)


@pytest.fixture(scope="session")
def decks(chapter, tmp_path_factory) -> list[Path]:
    """The lecturer's slides and the students', by the command."""
    return published("slides", chapter, tmp_path_factory.mktemp("build"))


@pytest.fixture(scope="session")
def slides_file(decks) -> Path:
    return decks[0]


@pytest.fixture(scope="session")
def student_file(decks) -> Path:
    return decks[1]


@pytest.fixture(scope="session")
def slides(browser, slides_file):
    """The slides in the browser, every fragment shown."""
    context = offline_context(browser, viewport={"width": 1280, "height": 720})
    watched = Watched(context)
    watched.page.goto(slides_file.as_uri())
    watched.wait()
    watched.page.evaluate("Reveal.configure({ fragments: false })")
    yield watched
    context.close()


@pytest.fixture(scope="session")
def handout_file(chapter, tmp_path_factory):
    """The PDF, printed by a browser of its own as the command does it."""
    (written,) = published("handouts", chapter, tmp_path_factory.mktemp("build"))
    return written
