"""Figures of chapter 1 are drawn as the notebook does; their words are true."""

import numpy as np
import pytest

from pgm_book.ch01 import case_figures, figures
from pgm_lab import datasets, simulate

SPOT = simulate.target((10.25, 9.5), diameter=8)
FLOOR = datasets.yellowstone().grey[660:756, 1300:1396].astype(float)
UP = np.array([(0.0, 0), (1, 0), (0, 1), (1, 1), (2, 1)])
NUMBERS = np.array([1.2, 3.0])
FIGURES = [
    (figures.sensor_frames, (), "y axis up"),
    (figures.interior_orientation, (), "perspective centre"),
    (figures.pixel_conventions, (), "(1.8, 1.3) with corners"),
    (figures.ground_frame, (FLOOR, 0.1, [0.2, 0.8]), "pixels of 20, 80 cm"),
    (figures.target_pull, (SPOT, (10.25, 9.5), {"a": (9, 9)}), "a at (9.00, 9.00)"),
    (figures.target_by_hand, (), "window of 21 px moved by 4 px, background 0"),
    (figures.target_precision, (), "no threshold: 0.040 at 4, 0.060 at 6"),
    (figures.mirror, (UP, UP * (1, -1)), "2.0 mm in y"),
    (case_figures.misfits, (UP[:, 0], 1e-6 * np.ones((2, 5, 2))), "20 numbers"),
    (case_figures.left_over, (NUMBERS, NUMBERS.round()), "up to 0.2000 nm"),
    (case_figures.shrunk_image, (np.arange(3.0), [3, 1, 2]), "lowest at 1.0 px"),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), FIGURES, ids=[f[0].__name__ for f in FIGURES]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of, monkeypatch):
    monkeypatch.setattr(figures, "target_sampled", lambda d, _, s: (0.01 * d + s, 0.02))
    monkeypatch.setattr(
        figures, "interact", lambda f, **s: f(*[w.value for w in s.values()])
    )
    assert words in alt_of(draw, *arguments)


def test_precision_of_a_centroid_is_predicted_without_a_threshold():
    simulated, predicted = figures.target_sampled(10, 21)
    # 400 errors: 3.5 per cent, three of them
    assert abs(simulated / predicted - 1) < 0.105
    assert figures.target_sampled(8, 31)[0] > 3 * figures.target_sampled(8, 15)[0]
    assert figures.target_sampled(8, 21)[0] > 3 * figures.target_sampled(8, 21, 3)[0]
