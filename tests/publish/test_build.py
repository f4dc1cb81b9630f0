"""The command: what it refuses, and that the tests here can fail."""

import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest

from pgm_book.make import page
from pgm_book.make.__main__ import ROOT, main
from pgm_book.make.browser import find_browser
from pgm_book.make.errors import PublishError
from pgm_book.make.page import slides_page
from tests.publish.example import code, example, figure_output, text
from tests.publish.look import axe_violations, bad_images, load_axe, raw_markup

PIXEL = "data:image/gif;base64,R0lGODlhAQABAIAAAP///wAAACwAAAAAAQABAAACAkQBADs="


@pytest.fixture
def publish(tmp_path):
    """Return a function that publishes the example with more cells at its end."""

    def run(what, *cells):
        folder = tmp_path / "notebooks"
        folder.mkdir(exist_ok=True)
        nbformat.write(example(*cells), folder / "01_example.ipynb")
        build = tmp_path / "build"
        return main([what, "--notebooks", str(folder), "--build", str(build)])

    return run


@pytest.mark.parametrize("what", ["slides", "handouts"])
def test_a_figure_without_alt_text_is_refused(what, publish, capsys):
    cell = code("show_without_words(fig)", figure_output(alt=None))
    assert publish(what, cell) == 1
    message = capsys.readouterr().err
    assert "show_without_words" in message and cell.id in message
    assert "alternative text" in message


def test_a_notebook_that_was_not_run_is_refused(publish, capsys):
    cell = code("forgotten = 1")
    cell.execution_count = None
    assert publish("slides", cell) == 1
    assert "forgotten = 1') has not been run" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("source", "complaint"),
    [
        ("![A map](https://example.org/map.png)", "is not in the file"),
        ("![A map](no_such_file.png)", "is not in the file"),
        (f"![]({PIXEL})", "alternative text"),
        (f'<img src="{PIXEL}">', "alternative text"),
        ('<iframe src="https://example.org"></iframe>', "may not be in a page"),
        ("### BEGIN SOLUTION", "code cells only"),
    ],
)
def test_text_that_cannot_be_published_is_refused(source, complaint, publish, capsys):
    cell = text(source, "slide")
    assert publish("slides", cell) == 1
    message = capsys.readouterr().err
    assert cell.id in message and complaint in message


def test_a_solution_is_not_given_away_by_its_output(small):
    page = slides_page(small, "student")
    assert "your code here" in page
    assert "secret" not in page
    assert "[2143.5 1423.5]" not in page


def test_a_request_at_run_time_is_found(watched):
    page = "<script>fetch('https://example.org/data.json')</script>"
    with watched.page.expect_event("requestfailed"):
        watched.page.set_content(page)
    assert watched.requests == ["https://example.org/data.json"]
    assert watched.errors != []


def test_weak_contrast_and_a_missing_text_are_found(watched):
    watched.page.set_content(
        f'<main><p style="color: #aaa; background: #fff">pale</p><img src="{PIXEL}">'
    )
    load_axe(watched.page)
    found = " ".join(axe_violations(watched.page))
    assert "color-contrast" in found and "image-alt" in found
    assert len(bad_images(watched.page)) == 1


def test_raw_tex_and_tables_are_found(watched):
    watched.page.set_content("<p>$$x$$, |--|--|, \\frac{1}{2}</p><pre>$a$</pre>")
    assert raw_markup(watched.page) == ["$$", "$$", "|--", "|--", "\\frac{1}{2}"]


def test_a_missing_browser_is_said(publish, monkeypatch, capsys):
    monkeypatch.setenv("PGM_BROWSER", "no-such-browser")
    assert publish("handouts") == 1
    assert "PGM_BROWSER names 'no-such-browser'" in capsys.readouterr().err


def test_a_downloaded_browser_comes_before_the_stub_of_ubuntu(monkeypatch):
    there = {"/cache/chrome", "chromium-browser"}
    monkeypatch.setattr(shutil, "which", lambda name: name if name in there else None)
    assert find_browser("/cache/chrome") == "/cache/chrome"
    assert find_browser() == "chromium-browser"
    there.clear()
    with pytest.raises(PublishError, match="playwright install chromium"):
        find_browser("/cache/chrome")


def test_a_missing_package_is_said(publish, monkeypatch, capsys):
    monkeypatch.setattr(page, "MATHJAX", ("no-such-package", "static/"))
    assert publish("slides") == 1
    assert "Python package no-such-package" in capsys.readouterr().err


def test_an_unknown_name_is_said(tmp_path, capsys):
    nbformat.write(example(), tmp_path / "01_example.ipynb")
    assert main(["slides", "99", "--notebooks", str(tmp_path)]) == 1
    assert "there are: 01_example" in capsys.readouterr().err


def test_an_empty_folder_is_said(tmp_path, capsys):
    assert main(["student", "--notebooks", str(tmp_path)]) == 1
    assert "no notebook in" in capsys.readouterr().err


def test_the_command_line(tmp_path):
    nbformat.write(example(), tmp_path / "01_example.ipynb")
    command = [sys.executable, "-m", "pgm_book.make", "student", "01"]
    folders = ["--notebooks", str(tmp_path), "--build", str(tmp_path / "build")]
    result = subprocess.run(
        command + folders, cwd=ROOT, capture_output=True, text=True, check=True
    )
    written = [Path(line).name for line in result.stdout.splitlines()]
    assert written == ["01_example.ipynb", "01_example.ipynb", "my_pgm.py"]
