"""What is wrong with a handout is read from its PDF, with the page."""

import nbformat
import pytest

from pgm_book.make.handouts import LABEL, faults, for_handouts, print_pdf
from tests.publish.example import code, figure_output, png, text

CHOICES = (
    '<div class="pgm-predict"><details><summary>{}</summary></details>'
    "<details><summary>Farther away</summary></details></div>"
)
NEXT = '<div style="break-before: page"></div>'
FULL = '<p style="height: 150mm">A page that is well used.</p><p>Its last line.</p>'


@pytest.fixture
def pdf(browser):
    """Return a function that prints the inner HTML of a page."""

    def printer(body: str) -> bytes:
        page = f'<!DOCTYPE html><html lang="en" data-ready="yes"><body>{body}</body>'
        return print_pdf(browser, page)

    return printer


def asked() -> nbformat.NotebookNode:
    """A notebook with a prediction and an exercise, as it is printed."""
    data = {"text/html": CHOICES.format("On the truth")}
    choices = nbformat.v4.new_output("display_data", data=data)
    exercise = code("def mean(x):\n    pass  # your code here")
    exercise.metadata.tags = ["exercise"]
    return nbformat.v4.new_notebook(
        cells=[
            text("**Predict.** Where will the middle lie?"),
            code('checks.predict("1.1")', choices),
            text("### Exercise\n\nWrite the mean of some numbers."),
            exercise,
        ]
    )


def figure(width: int) -> str:
    """A figure of so many px, with its description."""
    return (
        f'<figure><img alt="Residuals" style="width: {width}px" '
        f'src="data:image/png;base64,{png()}"></figure>'
    )


EMPTY = nbformat.v4.new_notebook()
QUESTION = "<p>Predict. Where will the middle lie?</p>"
ANSWERS = "<p>On the truth</p><p>Farther away</p>"
TASK = "<p>Exercise</p><p>Write the mean of some numbers.</p>"
CELL = "<pre>def mean(x):\n    pass  # your code here</pre>"


def test_a_handout_without_fault_has_none(pdf):
    body = QUESTION + ANSWERS + FULL + NEXT + TASK + CELL
    assert faults(pdf(body), asked(), "lesson") == []


@pytest.mark.parametrize(("form", "most"), [("lesson", 8), ("case", 6)])
def test_too_many_pages_are_counted(pdf, form, most):
    assert faults(pdf(NEXT.join([FULL] * most)), EMPTY, form) == []
    longer = pdf(NEXT.join([FULL] * (most + 1)))
    assert faults(longer, EMPTY, form) == [
        f"it has {most + 1} pages, a {form} at most {most}"
    ]
    assert faults(longer, EMPTY) == []


def test_a_heading_alone_at_the_foot_is_named(pdf):
    body = '<p style="height: 248mm">Text</p><h2>Alone</h2>' + NEXT + "<p>More</p>"
    (fault,) = faults(pdf(body), EMPTY)
    assert fault == "page 1: the heading 'Alone' stands alone at its foot"


def test_a_heading_whose_text_is_overleaf_is_named_wherever_it_stands(pdf):
    # Lines, and a heading above another, are not what it heads; nor is the footer.
    body = FULL + "<h2>Over</h2><h3>Under</h3><hr>" + NEXT + "<p>More</p>"
    assert faults(pdf(body), EMPTY) == [
        f"page 1: the heading {title!r} stands alone at its foot"
        for title in ("Over", "Under")
    ]


def test_a_heading_with_one_line_or_a_figure_below_it_is_not_alone(pdf):
    for below in ("<p>Text</p>", figure(40)):
        foot = '<p style="height: 225mm">Text</p><h2>Not alone</h2>' + below
        assert faults(pdf(foot + NEXT + "<p>More</p>"), EMPTY) == []


def test_small_text_and_code_are_named_but_not_the_footer(pdf):
    sizes = (
        "<p style='font-size: {}pt'>Words</p><pre style='font-size: {}pt'>x = 1</pre>"
    )
    assert faults(pdf(sizes.format(9, 7.5)), EMPTY) == []
    assert faults(pdf(sizes.format(8.8, 7.2)), EMPTY) == [
        "page 1: the code 'x = 1' is 7.2 pt high, less than 7.5",
        "page 1: the text 'Words' is 8.8 pt high, less than 9",
    ]


def test_a_figure_with_small_labels_is_named(pdf):
    shown = {"alt": "Residuals", "width": 400, "label": 14.0}
    output = nbformat.v4.new_output(
        "display_data", data={"image/png": ""}, metadata={"image/png": shown}
    )
    book = nbformat.v4.new_notebook(cells=[code("show(fig)", output)])
    assert faults(pdf(figure(210)), book) == []
    assert faults(pdf(FULL + NEXT + figure(180)), book) == [
        "page 2: the labels of the figure 'Residuals' are 6.3 pt high, less than 7"
    ]


def test_a_figure_is_printed_no_smaller_than_its_labels_allow():
    output = figure_output()
    output.metadata["image/png"]["label"] = 15.0
    last = for_handouts(nbformat.v4.new_notebook(cells=[code("show()", output)]))
    shown = last.cells[0].outputs[0].metadata["image/png"]
    assert shown.label == pytest.approx(LABEL)
    assert shown.width == pytest.approx(800 * LABEL / 15)


def test_a_page_nearly_empty_is_named_but_the_last(pdf):
    body = FULL + NEXT + "<p>One line</p>" + NEXT + "<p>The end</p>"
    (fault,) = faults(pdf(body), EMPTY)
    assert fault.startswith("page 2: only ")


@pytest.mark.parametrize(
    ("body", "what"),
    [
        (QUESTION + FULL + NEXT + ANSWERS + TASK + CELL, "question"),
        # The words of the first choice also stand above, and do not count.
        (ANSWERS + QUESTION + FULL + NEXT + ANSWERS + TASK + CELL, "question"),
        (QUESTION + ANSWERS + TASK + FULL + NEXT + CELL, "exercise"),
    ],
)
def test_what_belongs_together_and_is_divided_is_named(pdf, body, what):
    (fault,) = faults(pdf(body), asked())
    assert fault.startswith(f"page 1: the {what} ")


def test_an_answer_whose_figure_is_overleaf_is_named(pdf):
    data = {"text/html": "<div><p><strong>1.1</strong> On the truth ✓ Near.</p></div>"}
    said = nbformat.v4.new_output("display_data", data=data)
    shown = figure_output()
    shown.metadata["image/png"]["alt"] = "Residuals"
    book = nbformat.v4.new_notebook(cells=[code("", shown, said, tags=("answer",))])
    answer = "<p>1.1 On the truth ✓ Near.</p>"
    assert faults(pdf(FULL + figure(40) + answer), book) == []
    (fault,) = faults(pdf(FULL + answer + NEXT + figure(40)), book)
    assert fault == "page 1: the answer is divided"
