"""The plain way: `jupyter nbconvert --to slides` in the project's folder."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from publish import assets, plain
from publish.browser import offline_context
from publish.page import slides_page
from tests.publish.conftest import CHAPTERS, ROOT
from tests.publish.watch import Watched

LESSON = CHAPTERS["07_pearson_registration"]
METADATA = {"path": str(LESSON.parent), "name": LESSON.stem}


def nbconvert(kind: str, notebook: Path, output: Path, *options) -> Path:
    """Convert as the README says; return the one file that it writes."""
    command = [shutil.which("jupyter"), "nbconvert", "--to", kind, *options]
    result = subprocess.run(
        [*command, notebook, "--output-dir", output],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    (written,) = output.glob(f"{notebook.stem}.*")
    return written


def test_it_makes_the_lecturer_s_slides_and_they_fetch_nothing(browser, tmp_path):
    path = nbconvert("slides", LESSON, tmp_path)
    assert path.name == "07_pearson_registration.slides.html"
    made = slides_page(LESSON)
    assert path.read_text(encoding="utf-8").strip() == made.strip()

    context = offline_context(browser)
    watched = Watched(context)
    watched.page.goto(path.as_uri())
    watched.wait()
    count = watched.page.locator(".slides > section > section").count()
    assert watched.page.evaluate("Reveal.getTotalSlides()") == count > 10
    assert watched.requests == [path.as_uri()] and watched.errors == []
    context.close()


def test_what_it_writes_beside_a_notebook_is_no_part_of_the_project():
    written = LESSON.with_suffix(".slides.html")
    ignored = ["git", "check-ignore", "--quiet", written]
    assert subprocess.run(ignored, cwd=ROOT).returncode == 0


def test_a_notebook_from_elsewhere_gets_nbconvert_s_own_slides(lesson, tmp_path):
    shutil.copy(lesson, tmp_path / "01_elsewhere.ipynb")
    options = ["--SlidesExporter.extra_template_basedirs=[]"]
    elsewhere = tmp_path / "01_elsewhere.ipynb"
    here = nbconvert("slides", elsewhere, tmp_path / "here")
    own = nbconvert("slides", elsewhere, tmp_path / "own", *options)
    assert here.read_bytes() == own.read_bytes()


@pytest.mark.parametrize("kind", ["html", "script"])
def test_other_formats_do_not_come_past_it(kind, tmp_path, monkeypatch):
    """They work, and do not change, where nothing of `publish` can be imported."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    here = nbconvert(kind, LESSON, tmp_path / "here")
    options = ["--TemplateExporter.extra_template_basedirs=[]"]
    own = nbconvert(kind, LESSON, tmp_path / "own", *options)
    assert here.read_bytes() == own.read_bytes()


def test_a_missing_package_is_said_in_a_sentence(monkeypatch):
    monkeypatch.setattr(plain.NbConvertApp, "initialized", lambda: True)
    monkeypatch.setattr(assets, "_MATHJAX", ("no-such-package", "static/"))
    with pytest.raises(SystemExit, match="package no-such-package.*pip install -e"):
        plain.page(METADATA)
    monkeypatch.setitem(sys.modules, "publish.page", None)
    with pytest.raises(SystemExit, match="publish.page is missing.*pip install -e"):
        plain.page(METADATA)


def test_a_server_survives_what_is_wrong():
    with pytest.raises(OSError, match="no_such_notebook"):
        plain.page(METADATA | {"name": "no_such_notebook"})
