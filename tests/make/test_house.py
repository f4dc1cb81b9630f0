"""The imports keep the rules of the house, and its map is drawn from them."""

import re
from xml.etree import ElementTree

import pytest

from pgm_book.make import house


@pytest.fixture(scope="module")
def imports():
    return house.imports()


@pytest.fixture(scope="module")
def broken(imports):
    return house.broken(imports)


@pytest.mark.parametrize("rule", ["book", "lessons", "drawing", "circles"])
def test_the_house_keeps_its_rules(broken, rule):
    """The library never imports the book, no lesson another, what computes no plot."""
    assert broken[rule] == [], "\n".join(broken[rule])


@pytest.fixture
def written(tmp_path):
    """Write modules of a small house; return what breaks its rules."""

    def rules(files):
        for path, text in files.items():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_text(text, encoding="utf-8")
        for folder in {path for path in tmp_path.rglob("*") if path.is_dir()}:
            (folder / "__init__.py").touch()
        return house.broken(house.imports(tmp_path))

    return rules


M3, NCC, LAB = "pgm_book/ch03/m.py", "pgm_lab/ncc/m.py", "pgm_lab/m.py"
BOOK, LESSONS = ("book", "move what it"), ("lessons", "common")
DRAWING, CIRCLES = ("drawing", "return values"), ("circles", "break")
IN_A_FUNCTION = "def g():\n    "


@pytest.mark.parametrize(
    ("file", "line", "rule"),
    [
        (NCC, "import pgm_book.ch03.figures", BOOK),
        (NCC, "from pgm_book.ch03 import figures", BOOK),
        (NCC, "from pgm_book.ch03.figures import f", BOOK),
        (NCC, IN_A_FUNCTION + "import pgm_book", BOOK),
        (M3, "from pgm_book.ch05 import m", LESSONS),
        (M3, "from pgm_book import ch05", LESSONS),
        (M3, "from ..ch05 import m", LESSONS),
        (M3, "from .. import ch05", LESSONS),
        ("pgm_book/ch03/studies/m.py", "import pgm_book.chA1.m", LESSONS),
        (NCC, "import matplotlib.pyplot as plt", DRAWING),
        (LAB, IN_A_FUNCTION + "from IPython import display", DRAWING),
        (LAB, "import numpy, ipywidgets", DRAWING),
        (NCC, "from pgm_lab.lsm import m", CIRCLES),
        (NCC, IN_A_FUNCTION + "from pgm_lab import lsm", CIRCLES),
    ],
)
def test_each_form_of_import_is_found(written, file, line, rule):
    """The line is named, and what to do."""
    found = written(
        {
            "pgm_book/ch03/figures.py": "def f():\n    pass\n",
            "pgm_book/ch05/m.py": "",
            "pgm_book/chA1/m.py": "",
            "pgm_lab/lsm/m.py": "from pgm_lab import ncc\nfrom pgm_lab.ncc import m\n",
            file: f"# A module\n{line}\n",
        }
    )
    kind, said = rule
    places = [one.split()[0] for one in found.pop(kind) if said in one]
    assert f"{file}:{2 + line.count(chr(10))}" in places
    assert not any(found.values())


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("pgm_book/ch03/m.py", "from pgm_book.ch03 import figures"),
        ("pgm_book/ch03/m.py", "from pgm_book.common import show"),
        ("pgm_book/ch03/m.py", "import matplotlib, pgm_lab.ncc"),
        ("pgm_lab/plot/m.py", "import matplotlib"),
        ("pgm_lab/stereo_map/m.py", "import ipywidgets"),
        ("pgm_lab/ncc/m.py", "if TYPE_CHECKING:\n    from pgm_book import ch03"),
        ("pgm_lab/ncc/__main__.py", "from pgm_lab import report"),
        ("pgm_lab/ncc/m.py", "'''import pgm_book'''"),
    ],
)
def test_what_is_allowed_breaks_no_rule(written, file, line):
    found = written(
        {"pgm_book/ch03/figures.py": "", "pgm_lab/ncc/m.py": "", file: line}
    )
    assert not any(found.values())


def test_the_map_in_docs_is_current():
    """It may be late with the sizes, which change with every line."""
    stored = house.MAP.read_text(encoding="utf-8")
    assert house.contents(stored) == house.contents(house.drawing()), (
        "the imports have changed: run `python tasks.py house`"
    )


def test_the_map_shows_lessons_in_a_row_and_imports_downwards(tmp_path, written):
    written(
        {
            "pgm_lab/ground.py": "x = 1\n" * 900,
            "pgm_lab/upper/stairs.py": "from pgm_lab import ground\n",
            "pgm_lab/roof.py": "from pgm_lab import upper, ground\n",
            "pgm_book/ch01/figures.py": "",
            "pgm_book/chA1/figures.py": "",
            "pgm_book/common/a_long_name.py": "",
        }
    )
    svg = ElementTree.fromstring(house.drawing(tmp_path))
    tag = "{http://www.w3.org/2000/svg}"
    boxes = [
        (one.get("class"), float(one.get("y")), float(one.get("height")))
        for one in svg.iter(f"{tag}rect")
        if one.get("class") != "paper"
    ]
    lessons = [y for kind, y, _ in boxes if kind == "lesson"]
    assert len(boxes) == 6 and len(lessons) == 2 and len(set(lessons)) == 1
    assert min(y for _, y, _ in boxes) == lessons[0]  # on top
    paths = [one.get("d") for one in svg.iter(f"{tag}path")]
    assert len(paths) == 2  # not what leads through another room too
    for path in paths:
        heights = [float(y) for y in re.findall(r"[\d.-]+ (-?[\d.]+)", path)]
        assert heights[0] < heights[-1]
    names = [(one.text, float(one.get("x"))) for one in svg.iter(f"{tag}text")]
    assert {"ground", "upper", "stairs", "ch01", "900 lines"} <= {n for n, _ in names}
