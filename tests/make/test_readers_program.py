"""The reader's own program, of the solutions alone: it grows by every lesson and works.

It is made as the reader's is: a lesson takes what it needs out of ``my_pgm.py`` by
`checks.own`, and `checks.keep` puts its functions there. Only definitions are run, not
the lessons; tests/make/test_notebooks.py and nbval run these.
"""

import ast
import contextlib
import linecache
import re

import nbformat
import numpy as np
import pytest

from pgm_book.common import own_program
from pgm_book.make import form
from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import FIRST_LINES
from pgm_lab import camera, datasets, frames, ncc, rotation, simulate

ORDER = ("01", "A1", "02", "03", "04", "05", "06", "07", "08", "09")
LESSONS = [
    name
    for number in ORDER
    for name, kind in form.kinds().items()
    if kind == "lesson" and name.startswith(f"{number}_")
]
LIBRARIES = {"numpy", "pgm_lab", "scipy"}
LONGEST = 600  # lines


def calls(node, *names):
    """Whether a statement is, or assigns, a call of one of these functions."""
    value = getattr(node, "value", None)
    return isinstance(value, ast.Call) and ast.unparse(value.func) in names


def kept_statements(source):
    """What a program grows by: imports, functions, what is taken from it, and kept."""
    return [
        node
        for node in ast.parse(source).body
        if isinstance(node, ast.Import | ast.ImportFrom | ast.FunctionDef)
        or calls(node, "checks.own", "checks.keep")
    ]


def grow(name):
    """Run the definitions of a lesson where its reader would, beside ``my_pgm.py``."""
    space = {"__name__": "__main__"}
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    for number, cell in enumerate(notebook.cells):
        if cell.cell_type != "code":
            continue
        file = f"<{name}, cell {number}>"
        lines = cell.source.splitlines(keepends=True)
        linecache.cache[file] = len(cell.source), None, lines, file
        body = ast.Module(kept_statements(cell.source), [])
        exec(compile(body, file, "exec"), space)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the program, and what was said while it grew."""
    here = tmp_path_factory.mktemp("work")
    (here / own_program.FILE).write_text(FIRST_LINES, encoding="utf-8")
    said = {}
    with contextlib.chdir(here):
        for name in LESSONS:
            with open("said.txt", "w+", encoding="utf-8") as out:
                with contextlib.redirect_stdout(out):
                    grow(name)
                out.seek(0)
                said[name] = out.read()
    return here, said


@pytest.fixture(scope="module")
def text(folder):
    return (folder[0] / own_program.FILE).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def mine(folder):
    """The program as a module."""
    with contextlib.chdir(folder[0]):
        return own_program.loaded()


def test_every_lesson_adds_to_the_program_and_all_it_takes_is_there(folder, text):
    _, said = folder
    kept = {
        name: re.findall(r"^✓ (\w+) is a part of your program", words, re.MULTILINE)
        for name, words in said.items()
    }
    assert all(kept.values()), kept
    defined = [n.name for n in ast.parse(text).body if isinstance(n, ast.FunctionDef)]
    assert len(defined) == len(set(defined))
    assert set(defined) >= {name for names in kept.values() for name in names}
    book = [line for words in said.values() for line in words.splitlines()
            if "the book's own" in line]  # fmt: skip
    assert book == [], "a lesson asks for a function that none before it keeps"


def test_it_is_a_program_of_a_few_hundred_lines_and_known_libraries(text):
    assert text.startswith(FIRST_LINES)
    assert len([line for line in text.splitlines() if line.strip()]) < LONGEST
    for node in ast.parse(text).body:
        if own_program.is_import(node):
            names = [node.module] if isinstance(node, ast.ImportFrom) else [
                one.name for one in node.names
            ]  # fmt: skip
            assert {name.partition(".")[0] for name in names} <= LIBRARIES
        else:
            assert isinstance(node, ast.FunctionDef | ast.Expr), ast.unparse(node)


def test_a_later_run_of_every_lesson_changes_nothing(folder, text):
    with contextlib.chdir(folder[0]), contextlib.redirect_stdout(None):
        for name in LESSONS:
            grow(name)
    assert (folder[0] / own_program.FILE).read_text(encoding="utf-8") == text


def test_chapter_1_a_photo_coordinate(mine):
    data = datasets.bani2010()
    pixel_size = frames.pixel_size_from_sensor(data.sensor_size, data.image_size)
    for pixels in data.pixels:
        ours = mine.pixel_to_photo(pixels, data.image_size, pixel_size)
        book = frames.pixel_to_photo(pixels, data.image_size, pixel_size)
        np.testing.assert_allclose(ours, book, rtol=0, atol=1e-12)  # mm
        back = mine.photo_to_pixel(ours, data.image_size, pixel_size)
        np.testing.assert_allclose(back, pixels, rtol=0, atol=1e-9)  # px


def test_chapter_a1_a_straight_line_and_its_blunder(mine):
    x = np.arange(12.0)
    A = np.column_stack([np.ones(12), x])
    observed = 3 + 2 * x + 0.01 * (-1) ** x
    observed[4] += 0.2
    (a, b), v, sigma0, Q = mine.adjust(A, np.full(12, 1e4), observed)
    expected = np.linalg.lstsq(A, observed, rcond=None)[0]
    np.testing.assert_allclose((a, b), expected, rtol=1e-10)
    np.testing.assert_allclose(v, A @ expected - observed, atol=1e-12)
    assert sigma0 == pytest.approx(np.sqrt(1e4 * v @ v / 10))
    np.testing.assert_allclose(Q, np.linalg.inv(1e4 * A.T @ A), rtol=1e-9)
    r = mine.redundancy_numbers(A, np.full(12, 1e4))
    assert r.sum() == pytest.approx(10)
    assert mine.suspect(v, np.full(12, 0.01), r) == 4


def test_chapter_2_a_correlation(mine):
    grey = simulate.texture_pair(
        simulate.texture(seed=4), (40, 50), [0, 1, 0, 0, 0, 1], sigma=2.0
    )[0]
    template, search = grey[12:21, 20:29], grey[5:32, 10:40]
    found = np.asarray(mine.correlation_map(template, search))
    np.testing.assert_allclose(found, ncc.correlation_map(template, search), atol=1e-9)
    assert np.unravel_index(found.argmax(), found.shape) == (7, 10)
    assert mine.correlation(template, 3 * template + 7) == pytest.approx(1)


def test_chapter_3_a_match_to_a_hundredth_of_a_pixel(mine):
    shape = (3.25, 1.0, 0.0, -1.5, 0.0, 1.0)
    left, right = simulate.texture_pair(
        simulate.texture(seed=1), (80, 90), shape, sigma=0.5
    )
    point = 44, 38
    start = [point[0] + 3, 1, 0, point[1] - 2, 0, 1, 0, 1]
    trail, sigma0, Q = mine.match(left, right, point, start, 31)
    truth = np.add(point, (3.25, -1.5))
    assert np.abs(trail[-1][[0, 3]] - truth).max() < 0.01  # px
    assert sigma0 > 0 and Q.shape == (8, 8)


def test_chapter_4_a_rotation_and_its_angles(mine):
    for given in np.random.default_rng(4).uniform(-1.4, 1.4, (20, 3)):
        M = mine.rotation_matrix(*given)
        np.testing.assert_allclose(M, rotation.matrix(*given), rtol=0, atol=1e-14)
        np.testing.assert_allclose(mine.angles(M), given, rtol=0, atol=1e-12)


def test_chapter_5_a_height_by_intersection(mine):
    point, c = np.array([312.0, 140.0, 57.3]), 24.0
    photos = np.array([[100, 120, 1000, 0.02, -0.03, 0.4],
                       [480, 150, 1010, -0.01, 0.04, 0.5]])  # fmt: skip
    directions = []
    for exterior in photos:
        ((x, y),) = mine.project(exterior, point[None], c)
        book = camera.project(camera.Camera(c), exterior, point[None])
        np.testing.assert_allclose([(x, y)], book, rtol=0, atol=1e-10)
        M = mine.rotation_matrix(*exterior[3:])
        directions.append(np.array([x, y, -c]) @ M)
    found = mine.intersection(photos[:, :3], np.array(directions))
    assert found[2] == pytest.approx(57.3, abs=1e-6)  # m


def test_chapter_6_the_camera_of_2013(mine):
    """The principal distance and sigma0 of the free network of 2013, by every line."""
    data = datasets.muliawan2013()
    start = np.array(data.interior, dtype=float), data.exteriors, data.object_points
    rays = data.photo, data.point, data.xy, 0.001  # mm
    found, C, sigma0, points = mine.bundle(*rays, *start)
    assert abs(found[0] - 34.581) < 0.0005 and len(points) == 50
    assert np.sqrt(C[0, 0]) == pytest.approx(0.014, abs=0.0005)
    assert sigma0 == pytest.approx(0.349, abs=0.0005)


def test_chapter_7_and_8_a_shift_and_a_height(mine):
    scene = simulate.texture(seed=1)
    one, other = simulate.texture_pair(scene, (60, 60), (2.0, 1, 0, -1.0, 0, 1))
    dx, dy, r = mine.best_shift(one, other, (30, 30), 21, 3)
    assert (dx, dy) == (2, -1) and r.max() > 0.99
    ((x, y),) = mine.chip_shifts(one, other, [(30, 30)], 21, 3)
    assert np.hypot(x - 2, y + 1) < 0.05
    assert mine.rmse([3.0, -3.0], [4.0, 4.0]) == pytest.approx((3, 4, 5))
    model = mine.model_point(2.0, -1.0, 4.0, 100.0, 24.0)
    np.testing.assert_allclose(model, (50, -25, -600))
