"""What every drawing has to do: to show all that it draws, and nothing twice over."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.quiver import Quiver

from pgm_lab import bundle, matching, plot
from pgm_lab.report import _figures
from tests.matching import photos
from tests.networks import real

STATUS = ["accepted"] * 45 + [*matching.STATUSES]
MATCHED = photos.result(len(STATUS), STATUS, shift=(-5.0, 1.0))
FIGURES = {
    "lens_curve": plot.bundle.lens_curve,
    "all residual_vectors": plot.bundle.residual_vectors,
    "some residual_vectors": lambda r: plot.bundle.residual_vectors(r, [0, 5]),
    "side_by_side": lambda _: plot.matches.side_by_side(*photos.pair(), MATCHED),
    "parallaxes": lambda _: plot.matches.parallaxes(photos.pair()[0], MATCHED),
    "histograms": lambda _: plot.matches.histograms(MATCHED, threshold=0.7),
    "mean residuals of a report": lambda r: _figures.mean_residuals(r)[0],
}


@pytest.fixture(scope="module")
def result():
    return bundle.adjust(real())


@pytest.fixture(scope="module", params=FIGURES)
def figure(request, result):
    """A figure laid out as in a notebook."""
    with plt.rc_context(plot.STYLE):
        fig = FIGURES[request.param](result)
        for _ in range(2):  # as when it is saved: the layout looks at its own result
            fig.draw_without_rendering()
    yield fig
    plt.close(fig)


def drawn(ax):
    """Points (n, 2), in data units, of all that is drawn by its coordinates."""
    found = [np.empty((0, 2))]
    for line in ax.lines:
        if line.get_transform() == ax.transData:
            found.append(line.get_xydata())
    for patch in ax.patches:
        if patch.get_data_transform() == ax.transData:
            path = patch.get_path().transformed(patch.get_patch_transform())
            found.append(path.vertices)
    for many in ax.collections:
        if isinstance(many, Quiver):
            vectors = np.column_stack([many.U, many.V]) / many.scale
            found += [many.XY, many.XY + vectors]
        else:
            found += [path.vertices for path in many.get_paths()]
    points = np.concatenate(found)
    return points[np.isfinite(points).all(axis=1)]


def words(fig):
    """All texts but the numbers along the axes, which matplotlib chooses."""
    found = list(fig.texts)
    for ax in fig.findobj(Axes):
        found += [*ax.texts, ax.title, ax._left_title, ax.xaxis.label, ax.yaxis.label]
        if ax.get_legend():
            found += ax.get_legend().get_texts()
    return [text for text in found if text.get_text() and text.get_visible()]


def test_all_that_is_drawn_is_inside_the_limits_of_its_axes(figure):
    for ax in figure.axes:
        points = drawn(ax)
        x, y = np.sort(ax.get_xlim()), np.sort(ax.get_ylim())
        rounding = 1e-9 * np.abs([x, y]).max(axis=1)
        low, high = np.transpose([x, y])
        assert np.all(points >= low - rounding) and np.all(points <= high + rounding)
    assert sum(len(drawn(ax)) + len(ax.images) for ax in figure.axes) > 0


def test_all_words_are_inside_the_figure(figure):
    width, height = figure.bbox.size
    for text in words(figure):
        box = text.get_window_extent()
        assert box.x0 > -1 and box.y0 > -1, text.get_text()
        assert box.x1 < width + 1 and box.y1 < height + 1, text.get_text()
