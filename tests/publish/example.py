"""A small executed chapter with all that the real ones hold, made in memory."""

import base64
import io

import matplotlib
from nbformat import NotebookNode
from nbformat.v4 import (
    new_code_cell,
    new_markdown_cell,
    new_notebook,
    new_output,
)

from pgm_book.common.predict import page

matplotlib.use("Agg")
from matplotlib.figure import Figure  # noqa: E402

LONG_LINE = (
    "photo_points = pixel_to_photo(pixel_points, image_size=(4288, 2848), "
    "pixel_size=0.0055)"
)

TITLE = r"""# 1 · Where exactly is this point?

> **Ringkasan.** Bab ini mengubah koordinat piksel (kolom, baris) menjadi koordinat
> foto dalam milimeter. Titik asal berpindah ke pusat citra dan sumbu y berbalik arah.

After this chapter you will be able to

- turn pixel coordinates into photo coordinates, and back,
- say what half a pixel means in micrometres and on the ground,
- find a sign error in a published table.

*45 minutes · Bani 2010, sections 2.3 to 2.5*"""

CONVENTIONS = r"""## Axes and signs

| quantity | here | computer vision |
|:--|:--|:--|
| pixel $(c, r)$ | centre of the pixel | often its corner |
| photo $(x, y)$ | mm, $y$ up | px, $y$ down |
| camera | looks along $-z$ | looks along $+z$ |

> **In a box, too**
>
> | | here | elsewhere |
> |---|---|---|
> | integers | at centres | at corners $c$. |

> **Conventions.** The origin is the centre of the top-left pixel; integers are pixel
> *centres*. Call `pixel_to_photo(pixels, image_size, pixel_size)`."""

EQUATION = r"""## The equation of the source

With $s$ the pixel size and $(C, R)$ the size of the image,

$$
\begin{aligned}
x &= \left(c - \frac{C - 1}{2}\right) s, \\
y &= -\left(r - \frac{R - 1}{2}\right) s.
\end{aligned}
\tag{2.3}
$$

Its inverse is exact: $c = x/s + \tfrac{1}{2}(C - 1)$."""

CODE = f'''\
import numpy as np


def ground_sampling_distance(pixel_size: float, height: float, c: float) -> float:
    """Return the size of a pixel on the ground, in metres."""
    return 1e-3 * pixel_size * height / (1e-3 * c)  # mm to m


pixel_points = np.array([[0.0, 0.0], [2143.5, 1423.5]])
{LONG_LINE}
for number, (x, y) in enumerate(photo_points, start=1):
    print(f"point {{number}}: x = {{x:8.4f}} mm, y = {{y:8.4f}} mm")
assert len(photo_points) == 2 and True is not None'''

PRINTED = """\
point 1: x = -11.7893 mm, y =   7.8292 mm
point 2: x =   0.0000 mm, y =   0.0000 mm
"""

TABLE = """\
<table class="pgm-table">
<caption>Table 4.2, first three points</caption>
<thead><tr><th scope="col">point</th><th scope="col">x (mm)</th>
<th scope="col">y (mm)</th><th scope="col">difference (µm)</th></tr></thead>
<tbody>
<tr><th scope="row">1</th><td>-10.4412</td><td>6.0217</td><td>0.0</td></tr>
<tr><th scope="row">2</th><td>-5.2250</td><td>-3.1108</td><td>0.1</td></tr>
<tr><th scope="row">3</th><td>8.0034</td><td>1.9520</td><td>-0.1</td></tr>
</tbody></table>"""

WIDE_TABLE = f"""## Twenty points, one slide

| point | source | place | printed | ours | verdict | test |
|--:|:--|:--|--:|--:|:--|:--|
{
    chr(10).join(
        f"| {n} | Bani 2010 | Table 4.2 | {n * 1.01:.4f} | {n * 1.01:.4f} "
        "| reproduced | `tests/audit/test_bani2010.py` |"
        for n in range(1, 21)
    )
}"""

EXERCISE = """\
def photo_to_pixel(photo, image_size, pixel_size):
    \"\"\"Return (column, row) of points given in millimetres.\"\"\"
    ### BEGIN SOLUTION
    secret = np.asarray(photo) / pixel_size
    return secret + (np.asarray(image_size) - 1) / 2
    ### END SOLUTION


print(photo_to_pixel(np.zeros(2), (4288, 2848), 0.0055))"""

QUESTION = "1. What is half of 12.19 µm?"
ANSWER = "Nobody measures so well."
CHOICES = [
    {"choice": "12.68 µm", "right": "no", "feedback": "That is more, not half."},
    {"choice": "6.10 µm", "right": "yes", "feedback": ANSWER},
]

NOTES = "Ask for a guess *before* running the cell: $y$ up or down?"


def png(width: float = 10, height: float = 4) -> str:
    """Return a matplotlib figure as base64 text."""
    figure = Figure(figsize=(width, height), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot([0, 1, 2, 3], [0, 1, 4, 9], color="#0072B2", label="model")
    left.plot([0, 1, 2, 3], [0.2, 0.9, 4.1, 9], "o", color="#D55E00", label="observed")
    left.set(xlabel="distance (mm)", ylabel="residual (µm)")
    left.legend()
    right.imshow([[0, 1], [2, 3]], cmap="cividis")
    right.set(xlabel="column (px)", ylabel="row (px)")
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=150)
    return base64.b64encode(buffer.getvalue()).decode()


def figure_output(alt: str | None = "Residuals grow with distance", width: int = 800):
    """Return a figure as `pgm_lab.plot.show` publishes it."""
    metadata = {"width": width} | ({"alt": alt} if alt else {})
    return new_output(
        "display_data",
        data={"image/png": png(), "text/plain": alt or "Figure"},
        metadata={"image/png": metadata},
    )


def code(source: str, *outputs, slide: str = "-", tags: tuple = ()) -> NotebookNode:
    """Return an executed code cell."""
    return new_code_cell(
        source,
        outputs=list(outputs),
        execution_count=1,
        metadata={"slideshow": {"slide_type": slide}, "tags": list(tags)},
    )


def text(source: str, slide: str = "-", tags: tuple = ()) -> NotebookNode:
    """Return a text cell."""
    return new_markdown_cell(
        source,
        metadata={"slideshow": {"slide_type": slide}, "tags": list(tags)},
    )


def quick_questions() -> NotebookNode:
    """Return a cell of quick questions, as a lesson has it at its end."""
    asked = new_output("stream", name="stdout", text=QUESTION + "\n")
    choices = new_output("display_data", data={"text/html": page("1.11", CHOICES)})
    return code(
        "checks.predict(number)", asked, choices, slide="skip", tags=["predict"]
    )


def example(*more: NotebookNode) -> NotebookNode:
    """Return the chapter, with `more` cells at its end."""
    too_much = "\n".join(
        f"{n}. A sentence that takes about one line of a slide, more or less."
        for n in range(1, 17)
    )
    return new_notebook(
        metadata={
            "kernelspec": {"name": "python3", "display_name": "Python 3"},
            "language_info": {"name": "python", "pygments_lexer": "ipython3"},
        },
        cells=[
            text(TITLE, "slide"),
            text("Welcome; say where the coffee is.", "notes"),
            code("import setup_that_nobody_wants_to_see", slide="skip"),
            text(CONVENTIONS, "slide"),
            text(EQUATION, "slide"),
            text("Predict the sign of $y$ for the first row.", "fragment"),
            text(NOTES, "notes"),
            text("## Two points by hand", "slide"),
            code(CODE, new_output("stream", name="stdout", text=PRINTED)),
            text("## What half a pixel does", "subslide"),
            code("show(fig, alt)", figure_output(), tags=("hide-input",)),
            text("The residuals grow with distance: a **scale** error."),
            text("## The table of the source", "slide"),
            code(
                "show(table)",
                new_output("display_data", data={"text/html": TABLE}),
                tags=("hide-input",),
            ),
            text(WIDE_TABLE, "slide"),
            text("## Exercise 1 · The way back", "slide"),
            code(
                EXERCISE,
                new_output("stream", name="stdout", text="[2143.5 1423.5]\n"),
                tags=("exercise",),
            ),
            code("checks.photo_to_pixel(photo_to_pixel)", tags=("check",)),
            text("The solution is a secret.", tags=("solution",)),
            text("## Too much for one slide\n\n" + too_much, "slide"),
            text(
                "## Questions\n\n<details><summary>Where is the origin?</summary>\n\n"
                "At the centre of the top-left pixel.\n\n</details>\n\n"
                "[Source](https://example.org/bani2010) · `frames.py`\n\n"
                "```python\npixel_to_photo(pixels, (4288, 2848), 0.0055)\n```",
                "slide",
            ),
            *more,
        ],
    )
