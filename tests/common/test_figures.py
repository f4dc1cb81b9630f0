"""Parts of figures that lessons share."""

import matplotlib.pyplot as plt

from pgm_book.common import figures


def test_outline_runs_along_the_outer_edges_of_the_pixels(closed):
    _, ax = plt.subplots()
    box = figures.outline(ax, (5, 2), 3)
    assert box in ax.patches
    assert (box.get_xy(), box.get_width()) == ((3.5, 0.5), 3)
