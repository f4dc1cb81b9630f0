"""A release: its versions agree, its sums hold, and two makings are compared."""

import hashlib
import json
import re
import tarfile
import tomllib

import pytest

from pgm_book.make import release
from pgm_book.make.environment import ROOT
from pgm_book.make.errors import PublishError

# The attributes of a deposit that Zenodo documents for software.
ZENODO = {
    "access_right",
    "communities",
    "contributors",
    "creators",
    "description",
    "doi",
    "grants",
    "keywords",
    "language",
    "license",
    "notes",
    "publication_date",
    "references",
    "related_identifiers",
    "title",
    "upload_type",
    "version",
}


def cited(name: str) -> str:
    """A line of CITATION.cff."""
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    return re.search(rf"^ *(?:- )?{name}: \"?(.*?)\"?$", text, re.MULTILINE)[1]


def test_every_file_says_the_same_version():
    assert release.disagreements() == []


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project of version 1.0.0, all of whose files say so."""
    texts = {
        "CITATION.cff": "version: 1.0.0\n",
        "pgm_lab/__init__.py": '__version__ = "1.0.0"\n',
        ".zenodo.json": '{\n  "version": "1.0.0",\n}\n',
        "CHANGELOG.md": "# Changelog\n\n## 1.0.0, 2027-01-31\n",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.setattr(release, "ROOT", tmp_path)
    monkeypatch.setattr(release, "project", lambda: {"version": "1.0.0"})
    return tmp_path


@pytest.mark.parametrize("name", release.SAYS)
def test_another_version_is_named(project, name):
    assert release.disagreements("v1.0.0") == []
    text = (project / name).read_text(encoding="utf-8").replace("1.0.0", "1.0.1")
    (project / name).write_text(text, encoding="utf-8")
    assert release.disagreements("v1.0.0") == [f"{name} says 1.0.1, not 1.0.0"]


def test_what_is_unreleased_gets_no_tag(project):
    path = project / "CHANGELOG.md"
    path.write_text("# Changelog\n\n## Unreleased: the third\n", encoding="utf-8")
    assert release.disagreements() == []
    said = ["CHANGELOG.md says Unreleased, not 1.0.0"]
    assert release.disagreements("v1.0.0") == said
    assert "the tag is v2.0.0, not v1.0.0" in release.disagreements("v2.0.0")


def test_zenodo_gets_what_it_documents_and_what_is_cited():
    deposit = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    assert set(deposit) <= ZENODO
    assert {"title", "description", "upload_type", "creators"} <= set(deposit)
    assert (deposit["upload_type"], deposit["access_right"]) == ("software", "open")
    assert deposit["title"] == cited("title")
    assert deposit["version"] == cited("version")
    assert [one["name"] for one in deposit["creators"]] == [cited("name")]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    licences = re.search(r"^license:\n((?:  - .*\n)+)", citation, re.MULTILINE)[1]
    assert f"- {deposit['license']}\n" in licences
    keywords = re.search(r"^keywords:\n((?:  - .*\n)+)", citation, re.MULTILINE)[1]
    assert deposit["keywords"] == re.findall(r"- (.*)", keywords)
    with open(ROOT / "pyproject.toml", "rb") as file:
        ours = tomllib.load(file)["project"]
    assert deposit["license"] in ours["license"]


def test_the_sums_are_those_that_sha256sum_reads():
    lines = release.sums({"b.zip": b"2", "a.whl": b"1"}).splitlines()
    assert lines[0] == f"{hashlib.sha256(b'1').hexdigest()}  a.whl"
    assert [line.split("  ")[1] for line in lines] == ["a.whl", "b.zip"]


def test_files_that_differ_between_two_makings_are_named():
    release.compare({"a": b"1"}, {"a": b"1"})
    with pytest.raises(PublishError, match="differ: a, c"):
        release.compare({"a": b"1", "b": b"2", "c": b"3"}, {"a": b"2", "b": b"2"})


def test_a_release_has_every_file_and_its_sums(tmp_path):
    """From a folder as the other commands leave it."""
    names = ["dist/p-1.0-py3-none-any.whl", "course/p-students.zip"]
    names += [f"{what}/index.html" for what in release.ZIPPED]
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(name.encode())
    with tarfile.open(tmp_path / "dist" / "p-1.0.tar.gz", "w:gz") as packed:
        packed.add(tmp_path / "course", "p-1.0")
    files = release.collected(tmp_path)
    zips = {f"p-1.0-{what}.zip" for what in release.ZIPPED}
    wanted = {"p-1.0-py3-none-any.whl", "p-1.0.tar.gz", "p-students.zip", *zips}
    assert set(files) == wanted | {release.SUMS}
    del files[release.SUMS]
    assert release.collected(tmp_path)[release.SUMS] == release.sums(files).encode()
