"""Figures of chapter 1: their writing, their alt text, and what they draw."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch01 import case_figures as forty
from pgm_book.ch01 import figures as sensor
from pgm_book.ch01 import figures as target
from pgm_lab import datasets, plot, simulate
from pgm_lab.plot import basic

SPOT = simulate.target((10.25, 9.5), diameter=8)
FLOOR = datasets.yellowstone().grey[660:756, 1300:1396].astype(float)
UP = np.array([(0.0, 0), (1, 0), (0, 1), (1, 1), (2, 1)])
FIGURES = {
    "frames": (sensor.sensor_frames, "y axis up"),
    "interior": (sensor.interior_orientation, "perspective centre"),
    "conventions": (sensor.pixel_conventions, "(1.8, 1.3) with corners"),
    "shrunk": (lambda: sensor.shrunk_image([0, 1, 2], [3, 1, 2]), "lowest at 1.0 px"),
    "ground": (
        lambda: sensor.ground_frame(FLOOR, 0.1, [0.2, 0.8]),
        "pixels of 20, 80 cm",
    ),
    "pull": (
        lambda: target.target_pull(SPOT, (10.25, 9.5), {"a": (9, 9)}),
        "a at (9.00, 9.00)",
    ),
    "by_hand": (target.target_by_hand, "window of 21 px moved by 4 px, background 0"),
    "precision": (target.target_precision, "no threshold: 0.040 at 4, 0.060 at 6"),
    "mirror": (lambda: target.mirror(UP, UP * (1, -1)), "2.0 mm in y"),
    "misfits": (
        lambda: forty.misfits(UP[:, 0], 1e-6 * np.ones((2, 5, 2))),
        "20 numbers",
    ),
    "left_over": (
        lambda: forty.left_over([1.2, 3.0], [1, 2]),
        "listing: up to 0.2000 nm",
    ),
}


@pytest.mark.parametrize("name", FIGURES)
def test_figure_says_what_it_shows(name, monkeypatch):
    said = []
    monkeypatch.setattr(basic, "show", lambda fig, alt, **_: said.append(alt))
    monkeypatch.setattr(target, "target_sampled", lambda d, _, s: (0.01 * d + s, 0.02))
    draw, words = FIGURES[name]
    with plt.rc_context(plot.STYLE):
        if name == "by_hand":
            monkeypatch.setattr(
                target, "interact", lambda f, **s: f(*[w.value for w in s.values()])
            )
        draw()
    plt.close("all")
    assert words in said[0]


def test_precision_of_a_centroid_is_predicted_without_a_threshold():
    simulated, predicted = target.target_sampled(10, 21)
    # 400 errors: 3.5 per cent, three of them
    assert abs(simulated / predicted - 1) < 0.105
    assert target.target_sampled(8, 31)[0] > 3 * target.target_sampled(8, 15)[0]
    assert target.target_sampled(8, 21)[0] > 3 * target.target_sampled(8, 21, 3)[0]
