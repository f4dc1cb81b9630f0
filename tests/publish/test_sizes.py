"""What a hall can read: small decks with known faults.

The real ones are measured in test_slides.py, where they are open.
"""

import base64
import io
import subprocess
import sys

import nbformat
import pytest
from nbformat.v4 import new_output
from PIL import Image

from pgm_book.make.__main__ import ROOT
from pgm_book.make.browser import offline_context
from pgm_book.make.page import slides_page
from pgm_book.make.sizes import Row, measure, problems, table
from tests.publish.example import code, example, text
from tests.publish.watch import Deck, written

SENTENCE = "A sentence that takes about one line of a slide, more or less. "
INCH = 96


def picture(alt: str, width: float, height: float, dpi: int = 170, label=13):
    """Return a grey figure of inches; `label` is the size of its writing in points."""
    image = Image.new("L", (round(width * dpi), round(height * dpi)), 200)
    buffer = io.BytesIO()
    image.save(buffer, "png")
    metadata = {"alt": alt, "width": width * INCH} | ({"label": label} if label else {})
    return new_output(
        "display_data",
        data={"image/png": base64.b64encode(buffer.getvalue()).decode()},
        metadata={"image/png": metadata},
    )


def figure(*outputs):
    return code("show(figure, alt)", *outputs, tags=("hide-input",))


def notebook(*cells):
    made = example()
    made.cells = [text("# 1 · Sizes", "slide"), *cells]
    return made


FAULTS = notebook(
    text("## Small writing", "slide"),
    figure(picture("tiny", 12, 3, label=8)),
    text("## Few pixels", "slide"),
    figure(picture("coarse", 10, 4, dpi=60)),
    text("## Unknown", "slide"),
    figure(picture("unlabelled", 10, 4, label=None)),
    text("No heading here.", "slide"),
    text("## Long code", "slide"),
    code("\n".join(f"x_{n} = {n}" for n in range(21))),
    text("## Far too much\n\n" + SENTENCE * 50, "slide"),
    text("## Endless\n\n" + "- one more line\n" * 80, "slide"),
    text("## As it should be", "slide"),
    figure(picture("good", 10, 4)),
    text("The errors $e^{x_2}$ grow with `distance`<sup>2</sup>."),
)

PLACES = notebook(
    text("## Above", "slide"),
    text("One line above a wide figure."),
    figure(picture("wide", 10, 3.5)),
    text("## Beside\n\n" + SENTENCE * 3, "slide"),
    figure(picture("square", 8, 8)),
    text("The last word.", "fragment"),
    text("## Full", "slide"),
    figure(picture("alone", 10, 4)),
    text("## Two\n\nOne line.", "slide"),
    figure(picture("left", 5, 5), picture("right", 5, 5)),
)


@pytest.fixture(scope="module")
def opened(browser, tmp_path_factory):
    """Open a notebook as a deck."""
    context = offline_context(browser, viewport={"width": 1280, "height": 720})

    def deck(made) -> Deck:
        folder = tmp_path_factory.mktemp("sizes")
        path = folder / "01_sizes.ipynb"
        nbformat.write(made, path)
        return Deck(context, written(folder, slides_page(path)))

    yield deck
    context.close()


@pytest.fixture(scope="module")
def faults(opened) -> list[Row]:
    return measure(opened(FAULTS).page)


@pytest.fixture(scope="module")
def places(opened) -> dict:
    """Where each figure and its text are, in px of the slide."""
    return opened(PLACES).page.evaluate(
        """() => Object.fromEntries(Reveal.getSlides().flatMap((slide) => {
            const { h, v } = Reveal.getIndices(slide);
            Reveal.slide(h, v);
            const box = (element) => element?.getBoundingClientRect().toJSON();
            const text = box(slide.querySelector("p"));
            return [...slide.querySelectorAll("img")].map(
                (image) => [image.alt, { image: box(image), text }]);
        }))"""
    )


def found(rows: list[Row], title: str) -> set[str]:
    return {row.kind for row in problems(rows) if row.title == title}


@pytest.mark.parametrize(
    "title, kinds",
    [
        ("Small writing", {"figure label"}),
        ("Few pixels", {"enlargement"}),
        ("Unknown", {"figure label"}),
        ("", {"no heading"}),
        ("Long code", {"lines of code"}),
        ("Far too much", {"text"}),
        ("Endless", {"text", "overflow"}),
        ("As it should be", set()),
    ],
)
def test_each_fault_is_found_where_it_is(faults, title, kinds):
    assert found(faults, title) == kinds


def test_a_problem_names_its_slide_and_figure(faults):
    said = "\n".join(str(row) for row in problems(faults))
    assert "slide 2 ('Small writing'): the labels of the figure 'tiny' are " in said
    assert "not known how large the labels of the figure 'unlabelled' are" in said


def test_a_label_is_as_large_as_its_figure_is_shown(faults):
    (row,) = [r for r in faults if r.what == "good" and r.kind == "figure label"]
    enlarged = [r for r in faults if r.what == "good" and r.kind == "enlargement"]
    shown = enlarged[0].value * (1700 + 1) / 1.5
    assert row.value == pytest.approx(13 * INCH / 72 * shown / 960, abs=0.1)


def test_the_table_has_a_line_for_each_thing_and_marks_the_faults(faults):
    lines = list(table(faults))
    assert len(lines) == len(faults)
    assert sum(line[4] == "!" for line in lines) == len(problems(faults))


def test_a_figure_stands_below_or_beside_its_text_or_fills_the_slide(places):
    """Two stand side by side where that makes them larger."""
    wide, square = places["wide"], places["square"]
    assert wide["text"]["bottom"] <= wide["image"]["top"]
    assert square["text"]["right"] < square["image"]["left"]
    assert square["image"]["width"] / (8 * INCH) * 13 * INCH / 72 >= 11.5
    assert places["alone"]["image"]["width"] == pytest.approx(1700 / 1.5, abs=3)
    left, right = places["left"]["image"], places["right"]["image"]
    assert left["right"] < right["left"] and left["top"] == right["top"]


def test_the_command_refuses_a_lesson_and_lists_what_is_none(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "notebooks").mkdir()
    table = "notebook,form\n01_sizes,lesson\n02_sizes,\n"
    (tmp_path / "data" / "chapters.csv").write_text(table, encoding="utf-8")
    small = notebook(text("## Small", "slide"), figure(picture("tiny", 12, 3, label=8)))
    for name in ("01_sizes", "02_sizes"):
        nbformat.write(small, tmp_path / "notebooks" / f"{name}.ipynb")
    folders = ["--notebooks", str(tmp_path / "notebooks"), "--build", str(tmp_path)]
    command = [sys.executable, "-m", "pgm_book.make", "slides", *folders]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 1
    listed, refused = result.stderr.split("a hall cannot read all of them:")
    said = "_sizes.ipynb, slide 2 ('Small'): the labels"
    assert f"02{said}" in listed and f"01{said}" in refused
    assert (tmp_path / "slides" / "lecturer" / "01_sizes.html").is_file()
