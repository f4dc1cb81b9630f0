"""Figures of chapter 0: nothing sticks out, and all can be read in the last row."""

import matplotlib.pyplot as plt
import pytest

from pgm_book.ch00 import figures as of_lesson
from pgm_lab import plot
from pgm_lab.plot.basic import smallest_writing

FIGURES = [
    (
        of_lesson.computed_and_printed,
        ((-4.9, -2.5), (-4.9, 2.5), (23.6, 15.8)),
        "computed at x = -4.90, y = -2.50 mm, and printed at x = -4.90, y = 2.50 mm",
    ),
    (of_lesson.two_frames, (), "12 by 8 pixels twice"),
]


@pytest.mark.parametrize(("draw", "arguments", "words"), FIGURES)
def test_figure_says_what_it_shows_and_fits_on_a_slide(draw, arguments, words, figures):
    with plt.rc_context(plot.STYLE):
        draw(*arguments)
        ((fig, alt),) = figures
        fig.draw_without_rendering()  # as when it is saved
    used, (width, height) = fig.get_tightbbox(), fig.get_size_inches()
    assert min(used.x0, used.y0) >= 0 and used.x1 <= width and used.y1 <= height
    assert smallest_writing(fig) >= 13
    assert words in alt
