"""What passes its check becomes part of the reader's own program, and nothing else."""

import linecache
import math

import numpy as np
import pytest

from pgm_book.common import checks
from pgm_book.common.checks import CheckFailed
from pgm_lab import image
from pgm_lab.ncc import correlation

HEAD = '"""My program."""\n'
MEAN = "def mean_shift(dx):\n    # of all chips\n    return np.mean(dx)"
MEDIAN = 'def mean_shift(dx):\n    """Robust."""\n    return np.median(dx)'
COUNT = iter(range(1000))


@pytest.fixture
def program(tmp_path, monkeypatch):
    """An empty program of a reader in the folder of the notebook."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "my_pgm.py"
    path.write_text(HEAD, encoding="utf-8")
    return path


def typed(source, **known):
    """The last function of a cell, as a kernel defines it."""
    name = f"<cell {next(COUNT)}>"
    linecache.cache[name] = (len(source), None, source.splitlines(True), name)
    space = {"np": np, "image": image, **known}
    exec(compile(source, name, "exec"), space)
    return list(space.values())[-1]


def test_the_source_is_kept_as_typed_with_its_import(program, capsys):
    checks.keep(typed(MEAN))
    text = program.read_text(encoding="utf-8")
    assert text == f"{HEAD}\nimport numpy as np\n\n\n{MEAN}\n"
    said = capsys.readouterr().out
    assert said == "✓ mean_shift is a part of your program now, my_pgm.py.\n"
    program.write_text("")  # an empty file is a program too
    checks.keep(typed(MEAN))
    assert program.read_text() == f"import numpy as np\n\n\n{MEAN}\n"


def test_a_later_pass_replaces_it_and_nothing_else(program):
    checks.keep(typed(MEAN))
    own = "\n\n# mine\nSIZE = 21\n\n\ndef by_hand():\n    return 1\n"
    program.write_text(program.read_text() + own)
    before = program.read_text()
    for _ in range(2):
        checks.keep(typed(MEDIAN))
        assert program.read_text() == before.replace(MEAN, MEDIAN)
    assert [path.name for path in program.parent.iterdir()] == ["my_pgm.py"]


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        ("x, 2 * x", [3, 6]),
        ("[x, 2 * x]", [3, 6]),
        ("[(x, 1), (2, x)]", [[3, 1], [2, 3]]),
        ("2 * x", 6),
    ],
)
def test_an_answer_in_a_list_or_tuple_is_an_array_from_then_on(
    program, answer, expected
):
    checks.keep(typed(f"def place(x):\n    return {answer}"))
    found = checks.own("place", max)(3)
    assert not isinstance(found, list | tuple)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    "answer",
    [
        "np.ones(2), x",
        "[np.ones(2), x]",
        "np.ones(2), [x]",
        "np.ones(2), 0 * np.ones(2)",
    ],
)
def test_parts_of_several_shapes_and_two_arrays_stay_parts(program, answer):
    checks.keep(typed(f"def parts(x):\n    return {answer}"))
    found = checks.own("parts", max)(3)
    assert isinstance(found, list | tuple) and found[0].tolist() == [1, 1]


def test_several_functions_stand_below_their_imports(program):
    checks.keep(typed(MEAN))
    checks.keep(typed("def chip(photo, at):\n    return image.cut(photo, at, 21)"))
    checks.keep(typed("def root(x):\n    return sqrt(abs(x))", sqrt=math.sqrt))
    # An import names the package and no part of it
    checks.keep(
        typed("def r(a):\n    return correlation(a, a)", correlation=correlation)
    )
    assert program.read_text().splitlines()[2:6] == [
        "import numpy as np",
        "import pgm_lab.image as image",
        "from math import sqrt",
        "from pgm_lab.ncc import correlation",
    ]
    own = {name: checks.own(name, max) for name in ("mean_shift", "chip", "root")}
    assert own["root"](-9) == 3 and own["mean_shift"]([1, 2]) == 1.5
    assert own["chip"](np.zeros((40, 40)), (20, 20)).shape == (21, 21)


def test_helpers_of_the_notebook_come_along(program):
    source = "def square(x):\n    return x * x\n\n\ndef length(v):\n    "
    checks.keep(typed(source + "return sum(square(x) for x in v) ** 0.5"))
    assert checks.own("length", max)([3, 4]) == 5


@pytest.mark.parametrize("again", ["half", "checks.own('half', max)"])
def test_a_function_by_another_name_is_asked_for_by_its_own(program, again):
    """Also where it calls itself."""
    half = "def half(x):\n    return x if x < 1 else half(x / 2)\n\n\n"
    checks.keep(typed(half))
    before = program.read_text()
    use = "def quarter(x):\n    return twice(twice(x))"
    with pytest.raises(CheckFailed, match="`twice`, which is `half` in my_pgm.py"):
        checks.keep(typed(f"{half}twice = {again}\n\n\n{use}", checks=checks))
    assert program.read_text() == before


def test_decorators_are_replaced_with_their_function(program):
    twice = "def twice(f):\n    return lambda x: 2 * f(x)\n\n\n@twice\ndef one(x):\n"
    program.write_text(f"{HEAD}\n\n{twice}    return x\n")
    checks.keep(typed("def one(x):\n    return x + 1"))
    text = program.read_text()
    assert "@twice" not in text and "x + 1" in text and "def twice" in text


def test_a_comment_at_the_end_of_a_function_is_a_part_of_it(program):
    comment = "\n\n    # of all\n    # chips"
    checks.keep(typed(MEAN + comment))
    checks.keep(typed("def root(x):\n    return x**0.5"))
    program.write_text(program.read_text().replace("def root", "# mine\ndef root"))
    before = program.read_text()
    checks.keep(typed(MEAN + comment))
    assert program.read_text() == before
    checks.keep(typed(MEAN))
    assert program.read_text() == before.replace(comment, "")


def lost():
    """A function whose text is known no more."""
    function = typed(MEAN)
    linecache.cache.clear()
    return function


USES = "def far(x):\n    return [x - y for y in chips]"


@pytest.mark.parametrize(
    ("program_text", "make", "message"),
    [
        (
            HEAD,
            lambda: typed(USES, chips=[1.0]),
            "is right, but it uses `chips` of this",
        ),
        (HEAD, lambda: lambda x: x, "must be written with `def`"),
        (HEAD, lambda: np.mean, "must be written with `def`"),
        (HEAD, lambda: 3, "must be written with `def`"),
        (HEAD, lost, "Run the cell that defines it"),
        (
            "def broken(:\n",
            lambda: typed(MEAN),
            "look at its line 1. Nothing was written",
        ),
        (
            HEAD + "\nnp = 3\n",
            lambda: typed(MEAN),
            "name np for something else, in line 3",
        ),
        (
            HEAD + "\nmean_shift = max\n",
            lambda: typed(MEAN),
            "name mean_shift for something",
        ),
    ],
)
def test_what_cannot_be_kept_is_named_and_the_file_left_alone(
    program, program_text, make, message
):
    program.write_text(program_text)
    with pytest.raises(CheckFailed, match=message):
        checks.keep(make())
    assert program.read_text() == program_text


def test_the_book_s_own_gives_way_to_the_reader_s(program):
    """Chapter 3 before chapter 2: first the book's NCC, then the reader's."""
    uses = "def best(a, b):\n    return correlation(a, b)"
    checks.keep(typed(uses, correlation=correlation))
    assert "from pgm_lab.ncc" in program.read_text()
    taken = checks.own("correlation", correlation)  # from that import
    checks.keep(typed(uses.replace("best", "other"), correlation=taken))
    assert taken is correlation
    checks.keep(typed("def correlation(a, b):\n    return 7"))
    text = program.read_text()
    assert "from pgm_lab.ncc" not in text
    assert checks.own("best", max)(1, 2) == 7
    checks.keep(typed(uses, correlation=checks.own("correlation", max)))
    assert program.read_text() == text


def test_without_a_file_or_with_a_broken_one_the_book_s_own_is_taken(program, capsys):
    program.write_text("def broken(:\n")
    assert checks.own("mean_shift", max) is max
    assert "my_pgm.py does not run: SyntaxError" in capsys.readouterr().out
    program.unlink()
    checks.keep(typed(MEAN))
    assert checks.own("mean_shift", max) is max
    assert list(program.parent.iterdir()) == []
    said = capsys.readouterr().out
    assert "(mean_shift is kept in my_pgm.py when that file is in" in said
    assert "mean_shift: the book's own. Yours takes its place" in said


def test_a_change_by_hand_counts_at_once(program):
    checks.keep(typed(MEAN))
    assert checks.own("mean_shift", max)([1, 3]) == 2
    program.write_text(program.read_text().replace("np.mean", "np.sum"))
    assert checks.own("mean_shift", max)([1, 3]) == 4
