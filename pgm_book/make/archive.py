"""Archives and dates that are the same whenever and wherever they are made.

What is handed out carries the date of the release, so that who makes it again gets the
same bytes and can compare them.
"""

import gzip
import io
import os
import re
import tarfile
import zipfile
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

from pgm_book.make.environment import ROOT

EPOCH = "SOURCE_DATE_EPOCH"  # seconds, of reproducible-builds.org
RELEASED = re.compile(r"^date-released: (\S+)$", re.MULTILINE)
NODE = re.compile(rb"\(node(\d{8})\)")
DATED = re.compile(rb"/(CreationDate|ModDate) \(D:\d{14}[^)]*\)")


def date() -> datetime:
    """Return the date of what is made: SOURCE_DATE_EPOCH, else that of CITATION.cff."""
    if os.environ.get(EPOCH):
        return datetime.fromtimestamp(int(os.environ[EPOCH]), UTC)
    (said,) = RELEASED.findall((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    return datetime.fromisoformat(said).replace(tzinfo=UTC)


def steady(pdf: bytes) -> bytes:
    """Return a PDF of Chromium that is the same whenever it is printed, as long as it.

    It has the date of `date`, and its elements are numbered from 0 in the same order;
    Chromium goes on from some number of its own.
    """
    pdf = DATED.sub(rb"/\1 (D:%s+00'00')" % f"{date():%Y%m%d%H%M%S}".encode(), pdf)
    numbers = {
        old: b"%08d" % new for new, old in enumerate(sorted({*NODE.findall(pdf)}))
    }
    return NODE.sub(lambda found: b"(node%s)" % numbers[found[1]], pdf)


def zipped(files: Mapping[str, bytes]) -> bytes:
    """Return a zip of files, in the order of their names."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            member = zipfile.ZipInfo(name, date().timetuple()[:6])
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system, member.external_attr = 3, 0o100644 << 16  # of Unix
            archive.writestr(member, files[name])
    return made.getvalue()


def tarred(sdist: bytes) -> bytes:
    """Return a .tar.gz anew: in the order of names, with one date and no owner."""
    made, seconds = io.BytesIO(), int(date().timestamp())
    with (
        tarfile.open(fileobj=io.BytesIO(sdist)) as old,
        gzip.GzipFile("", "wb", fileobj=made, mtime=seconds) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as new,
    ):
        for member in sorted(old, key=lambda one: one.name):
            member.mtime, member.pax_headers = seconds, {}
            member.uid = member.gid = 0
            member.uname = member.gname = ""
            member.mode = 0o755 if member.isdir() else 0o644
            new.addfile(member, old.extractfile(member))
    return made.getvalue()


def tree(folder: Path, below: str) -> dict[str, bytes]:
    """Return all files of a folder as they are named below another one."""
    return {
        f"{below}/{path.relative_to(folder).as_posix()}": path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
