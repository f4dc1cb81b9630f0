"""Figures on a slide: all of it is inside, and large enough to read."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch00 import figures as ch00_figures
from pgm_book.ch07 import figures as ch07_figures
from pgm_book.program import registration as program_registration
from pgm_lab import plot, simulate
from pgm_lab.plot import _labels

COLUMN, ROW = np.meshgrid(np.arange(60.0), np.arange(60.0))
GREY = simulate.grey_values(simulate.texture(seed=1), np.stack([COLUMN, ROW], axis=-1))
MOVED = np.roll(GREY, (-1, 2), axis=(0, 1))
R = program_registration.best_shift(GREY, MOVED, (30, 30), 21, 3)[2]
CLOUD = (1.25, -0.75) + np.random.default_rng(1).normal(0, 0.05, (50, 2))
TRUE = np.linspace(0, 6, 60)
FIGURES = {
    "changes": lambda: plot.show(ch07_figures.changes(GREY, MOVED, 20), "a"),
    "two_colours": lambda: ch07_figures.two_colours(GREY, MOVED, (30, 30), 41),
    "by_hand": lambda: ch07_figures.fringe_by_hand(GREY, MOVED, (30, 30)),
    "before_and_after": lambda: ch07_figures.before_and_after(GREY, MOVED, GREY),
    "search": lambda: ch07_figures.chip_search(GREY, MOVED, (30, 30)),
    "chip_and_map": lambda: ch07_figures.chip_and_map(GREY, (30, 30), R),
    "places": lambda: plot.show(ch07_figures.chip_places(GREY, [(30, 30)]), "a"),
    "parabola": lambda: plot.show(ch07_figures.chip_parabola(0.5, 0.9, 0.7), "a"),
    "darts": lambda: ch07_figures.darts(
        {"whole pixels": CLOUD, "parabola": CLOUD, "least squares": CLOUD},
        (1.25, -0.75),
    ),
    "beyond": lambda: ch07_figures.beyond(TRUE, np.minimum(TRUE, 3), 1 - TRUE / 9),
    "trial": lambda: ch07_figures.trial(
        TRUE, 1 - TRUE / 9, {"r": 1 - TRUE / 9}, TRUE < 0.9
    ),
    "computed_and_printed": lambda: ch00_figures.computed_and_printed(
        (-4.9, -2.5), (-4.9, 2.5), (23.6, 15.8)
    ),
    "two_frames": ch00_figures.two_frames,
}


@pytest.mark.parametrize("name", FIGURES)
def test_nothing_sticks_out_and_all_can_be_read_from_the_last_row(name, monkeypatch):
    drawn = []
    monkeypatch.setattr(plot.basic, "show", lambda fig, *_, **__: drawn.append(fig))
    monkeypatch.setattr(plot, "show", plot.basic.show)
    monkeypatch.setattr(ch07_figures, "interact", lambda draw, **_: draw(0, 0))
    with plt.style.context(plot.STYLE):
        FIGURES[name]()
    (fig,) = drawn
    fig.draw_without_rendering()  # as when it is saved
    used = fig.get_tightbbox()
    width, height = fig.get_size_inches()
    assert min(used.x0, used.y0) >= 0 and used.x1 <= width and used.y1 <= height
    assert _labels.smallest(fig) >= 13
    plt.close(fig)
