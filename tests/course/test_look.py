"""What a lecturer may want to look at: unusual code, and answers with one structure."""

import ast
import itertools

import pytest

from pgm_book.course import look

FIRST = """
def rms(values, weights):
    total = 0.0
    for value, weight in zip(values, weights):
        total += weight * value**2
    if total < 1e-12:
        return 0.0
    return (total / sum(weights)) ** 0.5
"""
RENAMED = """
def rms(a, b):
    # my own work
    s = 0.0
    for x, y in zip(a, b):
        s += y * x**2
    if s < 1e-12:
        return 0.0
    return (s / sum(b)) ** 0.5
"""
MANY = """
def rms(v, w):
    return np.sqrt(np.average(v**2, weights=w))

def rms(v, w):
    v, w = np.array(v), np.array(w)
    return (v @ (w * v) / w.sum()) ** 0.5

def rms(v, w):
    n = len(v)
    t = [w[i] * v[i] * v[i] for i in range(n)]
    return math.sqrt(sum(t) / sum(w))

def rms(v, w):
    s = n = 0
    while v:
        s, n = s + v.pop(), n + 1
    return math.sqrt(s / n)

def rms(v, w):
    return float(np.sqrt(np.sum(w * np.square(v)) / np.sum(w)))
"""
OTHERS = [ast.unparse(node) for node in ast.parse(MANY).body]


def answers(*sources):
    return {
        f"student {k}": {"rms": ast.parse(source).body[0]}
        for k, source in enumerate(sources)
    }


def test_one_structure_with_other_names_is_found_and_independent_work_is_not():
    ((a, b, share, names),) = look.near_equal(answers(FIRST, *OTHERS, RENAMED), {})
    assert (a, b) == ("student 0", "student 6") and share == 1 and names == ("rms",)
    assert look.near_equal(answers(*OTHERS), {}) == []


def test_what_the_whole_class_has_is_no_sign():
    made = [FIRST.replace("1e-12", f"1e-{k}") for k in range(12)]
    assert look.near_equal(answers(*made), {}) == []


def test_what_everybody_was_given_is_no_sign():
    made = answers(FIRST, *OTHERS, FIRST)
    assert look.near_equal(made, answers(FIRST)["student 0"]) == []


@pytest.mark.parametrize(
    ("code", "found"),
    [
        ("import numpy as np\nx = np.abs(-1)", []),
        ("import os.path as p", ["imports os"]),
        ("from subprocess import run", ["imports subprocess"]),
        ("np.linalg.inv = f", ["gives np.linalg.inv another value"]),
        (
            "from pgm_book.ch02 import checks as c\nc.line = f",
            ["gives c.line another value"],
        ),
        ("f.__globals__['x'] = 1", ["reads f.__globals__"]),
        ("exec('1')\nopen('x')", ["calls exec", "calls open"]),
        ("result.field = 3", []),
        ("def f(:", ["cannot be read as Python"]),
        ("x" + ".a" * 700 + ".__b", ["reads ... .__b"]),
        (f"(0x{'f' * 5000}).__b", ["reads ... .__b"]),
        (
            "\n".join(f"x.__a{k}" for k in range(99)),
            [f"reads x.__a{k}" for k in range(20)],
        ),
    ],
)
def test_what_no_exercise_asks_for_is_named(code, found):
    assert look.doing(code) == found


def test_pieces_leave_names_out_and_keep_numbers():
    one, other = (look.pieces(ast.parse(code)) for code in (FIRST, RENAMED))
    assert one == other
    assert look.pieces(ast.parse(f"x = y + z * 0x{'f' * 5000}"))
    changed = look.pieces(ast.parse(FIRST.replace("**2", "**3")))
    assert changed != one and not changed.isdisjoint(one)
    for a, b in itertools.combinations(map(ast.parse, OTHERS), 2):
        assert look.pieces(a) != look.pieces(b)
