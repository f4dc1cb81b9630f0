"""A class of simulated submissions of lesson 2: right, wrong, lazy, hostile."""

import io
import json
import re
import zipfile
from pathlib import Path

import nbformat

from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import student_copy

LESSON = FOLDER / "02_normalized_cross_correlation.ipynb"

# Of each function one that reads otherwise; lists and tuples come back.
UNUSUAL = """
import math
import numpy


def correlation(a, b):
    p, q = [list(map(float, w.ravel())) for w in (a, b)]
    p, q = [[v - math.fsum(w) / len(w) for v in w] for w in (p, q)]
    dot = lambda u, v: math.fsum(s * t for s, t in zip(u, v))
    return dot(p, q) / math.sqrt(dot(p, p)) / math.sqrt(dot(q, q))


def line(x, y):
    M = numpy.column_stack([numpy.ones(x.size), x.ravel()])
    return list(numpy.linalg.lstsq(M, y.ravel(), rcond=None)[0])


def correlation_map(template, search):
    import cv2
    return cv2.matchTemplate(
        search.astype("float32"), template.astype("float32"), cv2.TM_CCOEFF_NORMED
    )


def search_width(template, left, right):
    return int(template) + 2 + 2 * max(abs(int(v)) for v in right - left)


def peak_of_parabola(before, middle, after):
    a, b, _ = numpy.polyfit([-1, 0, 1], [before, middle, after], 2)
    return (-b / (2 * a),)
"""

WRONG = """
import numpy as np


def correlation(a, b):  # the square
    return np.corrcoef(a.ravel(), b.ravel())[0, 1] ** 2


def line(x, y):  # exchanged
    beta, alpha = np.polyfit(x.ravel(), y.ravel(), 1)
    return beta, alpha


def correlation_map(template, search):  # a row and a column are missing
    rows, columns = np.subtract(search.shape, template.shape)
    h, w = template.shape
    r = np.zeros((rows + 1, columns + 1))
    for i in range(rows):
        for j in range(columns):
            window = search[i : i + h, j : j + w]
            r[i, j] = np.corrcoef(template.ravel(), window.ravel())[0, 1]
    return r


def search_width(template, left, right):  # one side only
    return template + np.abs(right - left).max() + 2


def peak_of_parabola(before, middle, after):  # the sign
    return (after - before) / (2 * (before - 2 * middle + after))
"""

LAZY = """
import numpy as np
from pgm_book import program
from pgm_lab import ncc


def correlation(a, b):
    return ncc.correlation(a, b)


def line(x, y):
    return 0.0, 1.0


def correlation_map(template, search):
    found = getattr(__import__("pgm_lab.ncc").ncc, "correlation" + "_map")
    return found(template, search)


def search_width(template, left, right):
    return 149


def peak_of_parabola(before, middle, after):
    return program.registration.peak_of_parabola(before, middle, after)
"""

PATCHES = """
import numpy as np
from pgm_book.common import checks
from pgm_book.ch02 import checks as chapter2


class Always(float):
    def __eq__(self, other): return True
    def __le__(self, other): return True
    __hash__ = float.__hash__


checks.report = checks.near = lambda *a, **k: True
chapter2.correlation = chapter2.line = print
np.allclose = np.all = np.array_equal = lambda *a, **k: True
np.abs = lambda *a, **k: 0.0


def correlation(a, b): return Always(0.5)
def line(x, y): return Always(1), Always(2)
def correlation_map(template, search): return np.zeros((7, 8))
def search_width(template, left, right): return Always(99)
def peak_of_parabola(before, middle, after): return Always(0)
"""

ENDS = "import os, sys\nsys.exit(0)\n"

HARMS = """
import os
import subprocess
import threading

open("written_at_import.txt", "w").write("here I am")


def correlation(a, b):
    while True:
        pass


def line(x, y):
    while os.fork() >= 0:
        pass


def correlation_map(template, search):
    return "x" * 10**9


def search_width(template, left, right):
    return subprocess.run(["id"], capture_output=True).returncode


def peak_of_parabola(before, middle, after):
    os._exit(0)
"""

READS = """
import glob
import os
import socket


def correlation(a, b):
    from pgm_book.ch02.checks import _r
    return _r(a, b)


def line(x, y):
    from pgm_book.course import grade
    return grade.code_of("2")


def correlation_map(template, search):
    for path in glob.glob("/**/02_*.ipynb", recursive=True):
        return open(path).read()
    raise OSError("no notebook anywhere")


def search_width(template, left, right):
    return len(os.listdir("/home/student/../../work/submissions"))


def peak_of_parabola(before, middle, after):
    return float(socket.create_connection(("192.0.2.1", 80), 1).recv(10))
"""


def notebook(answers: dict[str, str], student: bool = True) -> nbformat.NotebookNode:
    """Return the lesson's copy with other answers, by the function's name."""
    made = nbformat.read(LESSON, as_version=4)
    made = student_copy(made) if student else made
    for cell in made.cells:
        for name, source in answers.items():
            if cell.cell_type == "code" and cell.source.startswith(f"def {name}("):
                cell.source = source
    return made


def write(folder: Path) -> None:
    """Write the class into an empty folder, as several systems deliver it."""
    solved = nbformat.writes(notebook({}, student=False))
    place = {
        "Ani_101_assignsubmission_file_/02_ncc (1).ipynb": solved,
        "Budi/my_pgm.py": UNUSUAL,
        "Citra/my_pgm.py": WRONG,
        "Dewi/my_pgm.py": LAZY,
        "Eko/02_normalized_cross_correlation.ipynb": nbformat.writes(notebook({})),
        "Fajar/my_pgm.py": PATCHES,
        "Gita/my_pgm.py": ENDS + UNUSUAL,
        "Hadi/my_pgm.py": HARMS,
        "Indah/my_pgm.py": READS,
        "=cmd|' calc'!A0/my_pgm.py": "# nothing yet\n",
    }
    for name, text in place.items():
        (folder / name).parent.mkdir(parents=True)
        (folder / name).write_text(text, encoding="utf-8")
    # The outputs of the solved notebook above answers that do nothing
    faked = notebook({}, student=False)
    for cell in faked.cells:
        if cell.cell_type == "code" and cell.source.startswith("def "):
            cell.source = f"{cell.source.splitlines()[0]}\n    return 0.0"
    with zipfile.ZipFile(folder / "Joko.zip", "w") as whole:
        whole.writestr("joko/02.ipynb", nbformat.writes(faked))
        whole.writestr("../../escaped.ipynb", solved)
        link = zipfile.ZipInfo("joko/my_pgm.py")
        link.external_attr = 0o120777 << 16
        whole.writestr(link, "/etc/passwd")
    # A copy of Budi's with other names and texts
    copy = UNUSUAL
    for name, other in {"p": "one", "q": "two", "dot": "inner", "M": "design"}.items():
        copy = re.sub(rf"\b{name}\b", other, copy)
    with zipfile.ZipFile(folder / "Kartika.zip", "w") as whole:
        whole.writestr("my_pgm.py", copy)


def zipped(folder: Path) -> bytes:
    """Return a folder as one zip, as Moodle gives a class."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as whole:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                whole.write(path, path.relative_to(folder).as_posix())
    return held.getvalue()


def as_json(cells: list[str]) -> bytes:
    """Return the least notebook with these cells."""
    made = [{"cell_type": "code", "source": source} for source in cells]
    return json.dumps({"cells": made}).encode()
