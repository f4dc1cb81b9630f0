"""Archives and PDFs have the same bytes whenever they are made, and one date."""

import io
import os
import tarfile
import zipfile
from datetime import UTC, datetime

from pgm_book.make import archive

PDF = b"/CreationDate (D:%s+00'00')/ID (node000000%s)/Headers [(node000000%s)]"


def test_the_date_is_that_of_the_citation_or_the_one_asked_for(monkeypatch):
    monkeypatch.delenv(archive.EPOCH, raising=False)
    said = (archive.ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"date-released: {archive.date():%Y-%m-%d}\n" in said
    monkeypatch.setenv(archive.EPOCH, "1800000000")
    assert archive.date() == datetime(2027, 1, 15, 8, 0, tzinfo=UTC)


def test_a_pdf_keeps_its_length_and_the_order_of_its_elements(monkeypatch):
    """Whatever the clock and the number that Chromium began with; so xref holds."""
    monkeypatch.setenv(archive.EPOCH, "1800000000")
    first = PDF % (b"20260101120000", b"44", b"45")
    second = PDF % (b"20261231235959", b"17", b"29")
    assert archive.steady(first) == archive.steady(second)
    assert len(archive.steady(first)) == len(first)
    assert archive.steady(first) == PDF % (b"20270115080000", b"00", b"01")


def test_a_zip_has_one_order_and_one_date(monkeypatch):
    monkeypatch.setenv(archive.EPOCH, "1800000000")
    made = archive.zipped({"b/c.txt": b"2", "a.txt": b"1"})
    assert made == archive.zipped({"a.txt": b"1", "b/c.txt": b"2"})
    with zipfile.ZipFile(io.BytesIO(made)) as opened:
        assert opened.namelist() == ["a.txt", "b/c.txt"]
        assert opened.read("b/c.txt") == b"2"
        assert {one.date_time for one in opened.infolist()} == {(2027, 1, 15, 8, 0, 0)}


def test_a_sdist_forgets_who_packed_it_and_when(tmp_path, monkeypatch):
    monkeypatch.setenv(archive.EPOCH, "1800000000")
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "b.py").write_bytes(b"b = 1\n")
    (tmp_path / "p" / "a.py").write_bytes(b"a = 1\n")
    made = set()
    for seconds, name in enumerate(["one", "another"], start=1):
        os.utime(tmp_path / "p" / "a.py", (seconds, seconds))

        def owned(member, name=name):
            member.uname, member.uid = name, len(name)
            return member

        with tarfile.open(tmp_path / "p.tar.gz", "w:gz") as packed:
            packed.add(tmp_path / "p", "p", filter=owned)
        made.add(archive.tarred((tmp_path / "p.tar.gz").read_bytes()))
    (content,) = made
    with tarfile.open(fileobj=io.BytesIO(content)) as opened:
        assert opened.getnames() == ["p", "p/a.py", "p/b.py"]
        assert opened.extractfile("p/a.py").read() == b"a = 1\n"
        assert {(m.mtime, m.uid, m.uname) for m in opened} == {(1800000000, 0, "")}
