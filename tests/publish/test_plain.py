"""The plain way: `jupyter nbconvert --to slides` in the project's folder."""

import subprocess
import sys

import nbformat
import pytest
from nbconvert import SlidesExporter
from nbconvert.exporters.base import get_export_names, get_exporter

from pgm_book.make import page as pages
from pgm_book.make import plain
from pgm_book.make.page import slides_page
from tests.publish.conftest import CHAPTERS, ROOT
from tests.publish.example import example

LESSON = CHAPTERS["07_pearson_registration"]
METADATA = {"path": str(LESSON.parent), "name": LESSON.stem}


def test_it_makes_the_lecturer_s_slides(tmp_path, monkeypatch):
    """As the README says, where nothing but the clone itself holds `publish`."""
    command = [sys.executable, "-m", "jupyter", "nbconvert", "--to", "slides", LESSON]
    command += ["--output-dir", tmp_path]
    monkeypatch.delenv("PYTHONPATH", raising=False)
    result = subprocess.run(command, cwd=ROOT, capture_output=True)
    assert result.returncode == 0, result.stderr
    (path,) = tmp_path.iterdir()
    assert path.name == "07_pearson_registration.slides.html"
    made = slides_page(LESSON)
    assert path.read_text(encoding="utf-8").strip() == made.strip()


def test_what_it_writes_beside_a_notebook_is_no_part_of_the_project():
    written = LESSON.with_suffix(".slides.html")
    ignored = ["git", "check-ignore", "--quiet", written]
    assert subprocess.run(ignored, cwd=ROOT).returncode == 0


def test_a_notebook_from_elsewhere_gets_nbconvert_s_own_slides(tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT)
    elsewhere = tmp_path / "01_elsewhere.ipynb"
    nbformat.write(example(), elsewhere)
    here, _ = SlidesExporter().from_filename(elsewhere)
    own, _ = SlidesExporter(extra_template_basedirs=[]).from_filename(elsewhere)
    assert here == own


def test_other_formats_do_not_come_past_it(monkeypatch):
    monkeypatch.chdir(ROOT)
    found = [
        name
        for name in get_export_names()
        if str(ROOT / "reveal") in getattr(get_exporter(name)(), "template_paths", [])
    ]
    assert found == ["slides"]


def test_a_missing_package_is_said_in_a_sentence(monkeypatch):
    monkeypatch.setattr(plain.NbConvertApp, "initialized", lambda: True)
    monkeypatch.setattr(pages, "MATHJAX", ("no-such-package", "static/"))
    with pytest.raises(SystemExit, match="package no-such-package.*pip install -e"):
        plain.page(METADATA)
    monkeypatch.setitem(sys.modules, "pgm_book.make.page", None)
    with pytest.raises(
        SystemExit, match="pgm_book.make.page is missing.*pip install -e"
    ):
        plain.page(METADATA)


def test_a_server_survives_what_is_wrong():
    with pytest.raises(OSError, match="no_such_notebook"):
        plain.page(METADATA | {"name": "no_such_notebook"})
