"""Faults are drawn evenly over the lines, and found again when these have moved."""

import csv
from collections import Counter

import pytest

from pgm_book.make import fault_sites, faults


def found(text, drawing=False):
    """What a line of a module may become."""
    lines = [line.encode() for line in text.splitlines()]
    return {
        (lines[f.line - 1][: f.begin] + f.new.encode() + lines[f.line - 1][f.end :])
        .decode()
        .strip()
        for f in fault_sites.sites(text, drawing)
    }


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("y = a < b", {"y = a <= b", "y = a > b"}),
        ("y = a and not b", {"y = a or not b", "y = a and b"}),
        ("y = a @ b.T", {"y = b.T @ a", "y = a @ b"}),
        ("y = np.sin(a)", {"y = np.cos(a)"}),
        ("y = np.any(a, axis=0)", {"y = np.all(a, axis=0)", "y = np.any(a, axis=1)"}),
        ("y = a[1:]", {"y = a[2:]", "y = a[0:]"}),
        ("y = 0.5", {"y = 5.0", "y = 0.05"}),
        ("y = -a.copy()", {"y = a.copy()", "y = -a"}),
        ("y = _validate.finite(a, 'a')", {"y = a"}),
        ("f(a, b)", {"f(b, a)", "pass"}),
        ("y = a if b else d", {"y = a if True else d", "y = a if False else d"}),
        ("y = 'µm', a - b", {"y = 'µm', a + b"}),
    ],
)
def test_a_line_is_broken_in_the_ways_that_it_allows(line, wanted):
    assert wanted <= found(line)


@pytest.mark.parametrize(
    "text",
    [
        '"""1 < 2"""',
        "def f(a: tuple[int, 2]) -> int: ...",
        "raise ValueError(a + b)",
        "y = f'{a + b}'",
        "__all__ = ['a'] + ['b']",
        "y = np.hypot(a, b)",
        "y = f('name', a)",
        "if TYPE_CHECKING:\n    import a",
    ],
)
def test_what_no_test_should_hold_is_left_alone(text):
    assert not found(text)


def test_of_drawings_the_looks_are_left_alone():
    text = "ax.plot(x + 0.1 * y, fontsize=a - b, clip_on=True)"
    assert found(text, drawing=True) == {"pass"}
    assert len(found(text)) > 4


@pytest.fixture
def root(tmp_path):
    (tmp_path / "pgm_lab" / "room").mkdir(parents=True)
    (tmp_path / "pgm_lab" / "one.py").write_text("a = 1\nb = 2\n")
    big = "".join(f"x{n} = y{n} * z{n}\n" for n in range(50))
    (tmp_path / "pgm_lab" / "room" / "big.py").write_text(big)
    return tmp_path


def test_a_seed_draws_the_same_lines_and_more_of_a_large_module(root):
    rows = faults.draw(1, 20, root)
    assert rows == faults.draw(1, 20, root) != faults.draw(2, 20, root)
    assert len({(row["file"], row["line"]) for row in rows}) == 20
    files = Counter(row["file"] for row in rows)
    assert files["pgm_lab/room/big.py"] >= 18
    assert {row["tests"] for row in rows if "big" in row["file"]} == {
        "tests/room pgm_lab/room/big.py"
    }


def test_a_fault_finds_its_line_after_the_module_has_moved():
    row = {"number": "1", "file": "m.py", "before": "y = x + 1", "after": "y = x - 1"}
    row |= {"occurrence": "2", "line": "4"}
    moved = "import a\n\nif a:\n    y = x + 1\nelse:\n    y = x + 1\n"
    assert faults.put(moved, row) == moved[:-4] + "- 1\n"
    with pytest.raises(ValueError, match="stands 0 times in m.py"):
        faults.put("y = x\n", row)


def test_the_list_has_300_faults_each_with_its_verdict():
    with faults.DRAWN.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, strict=True))
    assert [row["number"] for row in rows] == [str(n + 1) for n in range(300)]
    for row in rows:
        caught = row["verdict"].startswith("killed")
        assert caught or row["verdict"] in ("equivalent", "alive")
        assert caught or row["reason"], f"fault {row['number']}: say why it lives"
