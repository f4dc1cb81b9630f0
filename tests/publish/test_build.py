"""The command: what it refuses, and that the tests here can fail."""

import shutil

import nbformat
import pytest

from pgm_book.make import page
from pgm_book.make.__main__ import main
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


def test_a_notebook_that_was_not_run_or_has_stray_markers_is_refused(publish, capsys):
    cell = code("forgotten = 1")
    cell.execution_count = None
    assert publish("slides", cell) == 1
    assert "forgotten = 1') has not been run" in capsys.readouterr().err
    assert publish("slides", text("### BEGIN SOLUTION")) == 1
    assert "code cells only" in capsys.readouterr().err


AWAY = "https://example.org"
OUTSIDE = ["../secret.png", "%2e%2e/secret.png", "a/../../secret.png", "link.png"]
REFUSED = {
    "is not in the file": [
        f"![A map]({AWAY}/map.png)",
        "![A map](no_such_file.png)",
        *(f"![A map](<{name}>)" for name in OUTSIDE),
        "![A map](<{folder}/secret.png>)",
    ],
    "no alternative text": [f"![]({PIXEL})", f'<img src="{PIXEL}">'],
    "may not be in a page": [
        f'<iframe src="{AWAY}"></iframe>',
        f'<base href="{AWAY}">',
        f'<meta http-equiv="refresh" content="0; url={AWAY}">',
        f'<form action="{AWAY}"></form>',
        "<script>start()</script>",
        f'<link rel="icon" href="{AWAY}">',
    ],
}


def test_what_cannot_be_published_is_refused_cell_by_cell(publish, tmp_path, capsys):
    """A page loads nothing, and no file from elsewhere goes with it to others."""
    secret = tmp_path / "secret.png"
    secret.write_bytes(b"nobody's business")
    (tmp_path / "notebooks").mkdir()
    (tmp_path / "notebooks" / "link.png").symlink_to(secret)
    cells = {
        complaint: [
            text(one.replace("{folder}", str(tmp_path)), "slide") for one in all_
        ]
        for complaint, all_ in REFUSED.items()
    }
    assert publish("slides", *(cell for some in cells.values() for cell in some)) == 1
    assert not (tmp_path / "build").exists()
    said = capsys.readouterr().err.splitlines()
    for complaint, some in cells.items():
        for cell in some:
            assert [s for s in said if cell.id in s and complaint in s], cell.source


def test_a_picture_beside_the_notebook_is_put_into_the_file(tmp_path):
    svg = '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>'
    (tmp_path / "a map.svg").write_text(svg)
    notebook = example(text("![A map](<a map.svg>)"))
    nbformat.write(notebook, tmp_path / "01_example.ipynb")
    page = slides_page(tmp_path / "01_example.ipynb")
    assert 'alt="A map" src="data:image/svg+xml;base64,' in page


def test_requests_weak_contrast_missing_texts_and_raw_tex_are_found(watched):
    """What the other tests look at can be seen."""
    page = watched.page
    with page.expect_event("requestfailed"):
        page.set_content(f"<script>fetch('{AWAY}/data.json')</script>")
    assert watched.requests == [f"{AWAY}/data.json"] and watched.errors != []
    page.set_content(
        f'<main><p style="color: #aaa; background: #fff">pale</p><img src="{PIXEL}">'
    )
    load_axe(page)
    found = " ".join(axe_violations(page))
    assert "color-contrast" in found and "image-alt" in found
    assert len(bad_images(page)) == 1
    page.set_content("<p>$$x$$, |--|--|, \\frac{1}{2}</p><pre>$a$</pre>")
    assert raw_markup(page) == ["$$", "$$", "|--", "|--", "\\frac{1}{2}"]


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


def test_unknown_names_and_an_empty_folder_are_said(tmp_path, capsys):
    assert main(["student", "--notebooks", str(tmp_path)]) == 1
    assert "no notebook in" in capsys.readouterr().err
    nbformat.write(example(), tmp_path / "01_example.ipynb")
    assert main(["slides", "99", "--notebooks", str(tmp_path)]) == 1
    assert "there are: 01_example" in capsys.readouterr().err
