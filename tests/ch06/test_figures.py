"""Figures of chapter 6 and its case are drawn as the notebooks do; their words hold."""

import numpy as np
import pytest

from pgm_book.ch06 import case_figures, published
from pgm_book.ch06 import figures as of_lesson
from pgm_lab import bundle

NETWORK = published.network()
EXTERIORS, POINTS = NETWORK.exteriors, NETWORK.points


@pytest.fixture(scope="module")
def found():
    return bundle.adjust(NETWORK)


LINE = np.array([0.1331, 3e-4, 3.1e-4])
DRAWN = [
    (of_lesson.ray, (), "the target has 3, the photo 6, the camera 10"),
    (of_lesson.lens_grids, (), "K1 pulls the corners outwards"),
    (of_lesson.zeros, (NETWORK.photo, NETWORK.point), "214 unknowns"),
    (of_lesson.motions, (EXTERIORS, POINTS), "shifts in X, Y and Z, rotations"),
    (
        of_lesson.halves,
        ({"photos 1": (34.5, 0.04), "all": (34.6, 0.01)},),
        "photos 1: 34.500 ± 0.040; all: 34.600 ± 0.010",
    ),
    (
        of_lesson.wrong_control,
        (np.array([0, 1.0]), np.array([0.02, 0.02]), np.array([0.02, 0.35])),
        "up to 1 mm: it shifts the other points by up to 0.35 mm, their standard"
        " deviation stays at 0.02 mm",
    ),
    (
        case_figures.by_photo,
        ({"start": np.array([0.13, 0.2]), "adjusted": np.array([3e-4, 2e-4])},),
        "start 1.3e+02 to 2e+02 µm; adjusted 0.2 to 0.3 µm",
    ),
    (case_figures.steps, ({"sign": LINE, "none": LINE},), "None, short and 2 P1 xy"),
    (
        case_figures.networks,
        ({"A: as taken": (EXTERIORS, POINTS), "B": (EXTERIORS[:5], POINTS)},),
        "A: as taken; B.",
    ),
    (
        case_figures.precisions,
        ({"A": (20.0, 15, 14), "B": (np.nan, 3, 4)},),
        "A: 20, 15, 14; B: nan, 3, 4.",
    ),
    (
        case_figures.scatter,
        ({"c": 1.02, "stations": 0.98}, 2000),
        "2000 simulated networks over the predicted standard deviation, between 0.98",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), DRAWN, ids=[d[0].__name__ for d in DRAWN]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)


def test_result_of_an_adjustment_is_drawn(found, alt_of, figures):
    said = alt_of(of_lesson.curve, found)
    assert "below 1 micrometre up to 6" in said
    assert "24 lie beyond 7 and 9 beyond 8" in said
    red = np.flatnonzero(np.abs(found.standardized).max(axis=1) > 3.28)
    assert (found.network.photo[red] + 1).tolist() == [2, 6, 6, 6, 7, 7]
    assert "six are much longer" in alt_of(case_figures.left_over, found)
    assert len(figures) == 2


def test_photos_are_chosen_from_a_list(monkeypatch, alt_of, found):
    given = {}
    monkeypatch.setattr(of_lesson, "interact", lambda f, photos: given.update(draw=f))
    of_lesson.which_photos(NETWORK)
    sd = 1000 * found.sd_interior[0]
    assert f"the standard deviation of c is {sd:.0f} mic" in alt_of(
        given["draw"], tuple(range(1, 10))
    )
    assert "these photos do not do" in alt_of(given["draw"], (3,))


def test_singular_values_below_the_limit_are_hollow(figures):
    s = np.array([1e5, 1e2, 10.0, 1e-3, 0.0])
    case_figures.kept({"N": s, "scaled": np.array([1.0, 0.5])}, 1.0)
    (ax,) = figures[0][0].axes
    kept, lost, line, scaled, _ = ax.lines
    np.testing.assert_array_equal(kept.get_data(), [(1, 2, 3), (1e5, 1e2, 10)])
    np.testing.assert_array_equal(lost.get_data(), [(4,), (1e-3,)])  # log has no 0
    assert lost.get_markerfacecolor() == "none"
    assert set(line.get_ydata()) == {1.0}
    np.testing.assert_array_equal(scaled.get_ydata(), (1, 0.5))
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["N: 3 of 5 kept", "scaled"]


def test_band_holds_the_standard_deviations_of_so_many_samples(figures):
    case_figures.scatter({"c": 1.1, "X0": 0.9}, 200)
    (ax,) = figures[0][0].axes
    sampled = next(line for line in ax.lines if line.get_label() == "sampled")
    np.testing.assert_allclose(sampled.get_ydata(), (1.1, 0.9))
    (_, low), (_, high) = ax.patches[0].get_bbox().get_points()
    samples = np.random.default_rng(1).normal(size=(20_000, 200))
    expected = np.quantile(samples.std(axis=1, ddof=1), (0.025, 0.975))
    # 20,000 repetitions know such a quantile to 0.001 of the standard deviation
    np.testing.assert_allclose((low, high), expected, atol=0.004)
