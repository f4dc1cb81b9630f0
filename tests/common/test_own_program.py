"""What passes its check becomes part of the reader's own program, and nothing else."""

import linecache
import math

import numpy as np
import pytest

from pgm_book.common import checks
from pgm_book.common import own_program as _program
from pgm_book.common.checks import CheckFailed
from pgm_lab import image

HEAD = '"""My program."""\n'
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


MEAN = "def mean_shift(dx):\n    # of all chips\n    return np.mean(dx)"
MEDIAN = 'def mean_shift(dx):\n    """Robust."""\n    return np.median(dx)'


def test_the_source_is_kept_as_typed_with_its_import(program, capsys):
    checks.keep(typed(MEAN))
    text = program.read_text(encoding="utf-8")
    assert text == f"{HEAD}\nimport numpy as np\n\n\n{MEAN}\n"
    said = capsys.readouterr().out
    assert said == "✓ mean_shift is a part of your program now, my_pgm.py.\n"


def test_a_later_pass_replaces_it_and_nothing_else(program):
    checks.keep(typed(MEAN))
    program.write_text(
        program.read_text()
        + "\n\n# mine\nSIZE = 21\n\n\ndef by_hand():\n    return 1\n"
    )
    before = program.read_text()
    checks.keep(typed(MEDIAN))
    assert program.read_text() == before.replace(MEAN, MEDIAN)
    checks.keep(typed(MEDIAN))
    assert program.read_text() == before.replace(MEAN, MEDIAN)
    assert [path.name for path in program.parent.iterdir()] == ["my_pgm.py"]


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        ("return x, 2 * x", [3, 6]),
        ("return [x, 2 * x]", [3, 6]),
        ("return [(x, 1), (2, x)]", [[3, 1], [2, 3]]),
        ("return 2 * x", 6),
    ],
)
def test_an_answer_in_a_list_or_tuple_is_an_array_from_then_on(
    program, answer, expected
):
    checks.keep(typed(f"def place(x):\n    {answer}"))
    found = checks.own("place", max)(3)
    assert isinstance(found, list | tuple) is False
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(
    "answer", ["np.ones(2), x", "[np.ones(2), x]", "np.ones(2), [x]"]
)
def test_parts_of_several_shapes_stay_parts(program, answer):
    checks.keep(typed(f"def parts(x):\n    return {answer}"))
    first, second = checks.own("parts", max)(3)
    assert first.tolist() == [1, 1] and second in (3, [3])


def test_a_tuple_of_two_arrays_of_one_shape_stays_two(program):
    checks.keep(typed("def parts(x):\n    return np.ones(2), np.zeros(2)"))
    assert isinstance(checks.own("parts", max)(3), tuple)


def test_several_functions_stand_below_their_imports(program):
    checks.keep(typed(MEAN))
    cut = typed("def chip(photo, at):\n    return image.cut(photo, at, 21)")
    checks.keep(cut)
    root = typed("def root(x):\n    return sqrt(abs(x))", sqrt=math.sqrt)
    checks.keep(root)
    lines = program.read_text().splitlines()
    assert lines[2:5] == [
        "import numpy as np",
        "import pgm_lab.image as image",
        "from math import sqrt",
    ]
    own = {name: checks.own(name, max) for name in ("mean_shift", "chip", "root")}
    assert own["root"](-9) == 3 and own["mean_shift"]([1, 2]) == 1.5
    assert own["chip"](np.zeros((40, 40)), (20, 20)).shape == (21, 21)


def test_helpers_of_the_notebook_come_along(program):
    source = "def square(x):\n    return x * x\n\n\ndef length(v):\n    "
    checks.keep(typed(source + "return sum(square(x) for x in v) ** 0.5"))
    assert checks.own("length", max)([3, 4]) == 5


def test_decorators_are_replaced_with_their_function(program):
    twice = "def twice(f):\n    return lambda x: 2 * f(x)\n\n\n@twice\ndef one(x):\n"
    space = typed(twice.partition("\n\n\n")[0])
    for answer in ("x", "x + 1"):
        source = f"@twice\ndef one(x):\n    return {answer}"
        text = _program.merged(program.read_text(), [], {"one": source})
        program.write_text(text)
    assert text.count("@twice") == 1 and "x + 1" in text and callable(space)


def test_a_comment_at_the_end_of_a_function_is_a_part_of_it(program):
    checks.keep(typed(MEAN + "\n\n    # of all\n    # chips"))
    checks.keep(typed("def root(x):\n    return x**0.5"))
    program.write_text(program.read_text().replace("def root", "# mine\ndef root"))
    before = program.read_text()
    checks.keep(typed(MEAN + "\n\n    # of all\n    # chips"))
    assert program.read_text() == before
    checks.keep(typed(MEAN))
    assert program.read_text() == before.replace("\n\n    # of all\n    # chips", "")


def test_an_import_names_the_room_and_no_part_of_it(program):
    from pgm_lab.ncc import correlation

    same = typed("def same(a):\n    return correlation(a, a)", correlation=correlation)
    checks.keep(same)
    assert "\nfrom pgm_lab.ncc import correlation\n" in program.read_text()


def test_what_the_notebook_alone_has_is_named(program):
    uses = typed("def far(x):\n    return [x - y for y in chips]", chips=[1.0])
    with pytest.raises(CheckFailed, match="is right, but it uses `chips` of this"):
        checks.keep(uses)
    assert program.read_text() == HEAD


@pytest.mark.parametrize("what", [lambda x: x, np.mean, 3])
def test_only_a_function_of_the_notebook_can_be_kept(program, what):
    with pytest.raises(CheckFailed, match="must be written with `def`"):
        checks.keep(what)
    assert program.read_text() == HEAD


def test_a_function_whose_text_is_lost_is_named(program):
    lost = typed(MEAN)
    linecache.cache.clear()
    with pytest.raises(CheckFailed, match="Run the cell that defines it"):
        checks.keep(lost)


def test_a_file_with_a_mistake_is_left_alone(program, capsys):
    program.write_text("def broken(:\n")
    with pytest.raises(CheckFailed, match="look at its line 1. Nothing was written"):
        checks.keep(typed(MEAN))
    assert program.read_text() == "def broken(:\n"
    assert checks.own("mean_shift", max) is max
    assert "my_pgm.py does not run: SyntaxError" in capsys.readouterr().out


def test_a_name_that_means_something_else_is_named(program):
    program.write_text(HEAD + "\nnp = 3\n")
    with pytest.raises(CheckFailed, match="the name np for something else, in line 3"):
        checks.keep(typed(MEAN))
    program.write_text(HEAD + "\nmean_shift = max\n")
    with pytest.raises(CheckFailed, match="the name mean_shift for something else"):
        checks.keep(typed(MEAN))


def test_the_book_s_own_gives_way_to_the_reader_s(program):
    """Chapter 3 before chapter 2: first the book's NCC, then the reader's."""
    uses = "def best(a, b):\n    return correlation(a, b)"
    from pgm_lab.ncc import correlation

    checks.keep(typed(uses, correlation=correlation))
    assert "from pgm_lab.ncc" in program.read_text()
    checks.keep(typed("def correlation(a, b):\n    return 7"))
    text = program.read_text()
    assert "from pgm_lab.ncc" not in text
    assert checks.own("best", max)(1, 2) == 7
    checks.keep(typed(uses, correlation=checks.own("correlation", max)))
    assert program.read_text() == text


def test_an_empty_file_is_a_program_too(program):
    program.write_text("")
    checks.keep(typed(MEAN))
    assert program.read_text() == f"import numpy as np\n\n\n{MEAN}\n"


def test_without_a_file_nothing_is_read_or_written(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    checks.keep(typed(MEAN))
    assert checks.own("mean_shift", max) is max
    assert list(tmp_path.iterdir()) == []
    said = capsys.readouterr().out
    assert "mean_shift goes into your program, my_pgm.py, where there is one" in said
    assert "mean_shift: the book's own. Yours takes its place" in said


def test_a_change_by_hand_counts_at_once(program):
    checks.keep(typed(MEAN))
    assert checks.own("mean_shift", max)([1, 3]) == 2
    program.write_text(program.read_text().replace("np.mean", "np.sum"))
    assert checks.own("mean_shift", max)([1, 3]) == 4
