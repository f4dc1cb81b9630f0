"""Sketches and figures of chapter 5 say what the numbers do, inside their frame."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch05 import case_figures as ch05_case_figures
from pgm_book.ch05 import figures as ch05_figures
from pgm_lab import plot
from pgm_lab.plot import _labels

PAIR = np.array([(-1.0, 0, 3, 0, -0.3, 0), (1.0, 0, 3, 0, 0.3, 0)])
POINTS = np.array([(0.0, 0, 0), (0.4, 0.3, 0.1), (-0.3, 0.5, 0)])
LADDER = {"as published": 1.5, "as it stands": 0.051, "… + x0, y0, K1": 0.00054}
FIGURES = {
    "one ray": ch05_figures.one_ray,
    "epipolar plane": ch05_figures.epipolar_plane,
    "to the ground": ch05_figures.to_the_ground,
    "meeting": lambda: ch05_figures.meeting(PAIR, POINTS, ["left", "right"]),
    "steps": lambda: ch05_figures.adjustment_steps(
        [1e-9, 1e-6, 1e-3], [1e-8, 1e-11, 1e-7]
    ),
    "clouds": ch05_figures.point_clouds,
    "base": ch05_figures.base_by_hand,
    "heights": lambda: ch05_case_figures.heights(np.outer((1, 2, 4, 8, 16), range(10))),
    "residuals": lambda: ch05_case_figures.residuals(
        np.zeros((2, 3, 2)), np.full((2, 3, 2), 0.05)
    ),
    "ladder": lambda: ch05_case_figures.ladder(LADDER),
    "misprints": lambda: ch05_case_figures.misprints([1e-9, 0.8], ["b11", "b12"]),
}


@pytest.fixture
def shown(monkeypatch):
    """Figures and their texts, as they are shown."""
    figures = []
    monkeypatch.setattr(
        plot.basic, "show", lambda f, alt, **_: figures.append((f, alt))
    )
    monkeypatch.setattr(ch05_figures, "interact", lambda draw, **_: draw(40))
    with plt.style.context(plot.STYLE):
        yield figures
    plt.close("all")


@pytest.mark.parametrize("name", FIGURES)
def test_nothing_sticks_out_and_all_can_be_read_from_the_last_row(name, shown):
    FIGURES[name]()
    ((fig, alt),) = shown
    fig.canvas.draw()
    width, height = fig.get_size_inches()
    used = fig.get_tightbbox()
    assert min(used.x0, used.y0) >= 0 and used.x1 <= width and used.y1 <= height
    flat = [ax for ax in fig.axes if ax.name != "3d"]
    for text in [*fig.texts, *(text for ax in flat for text in ax.texts)]:
        edge = text.get_window_extent()
        assert edge.x0 >= 0 and edge.x1 <= fig.bbox.x1, text.get_text()
        assert edge.y0 >= 0 and edge.y1 <= fig.bbox.y1, text.get_text()
    assert _labels.smallest(fig) >= 13 and width in (7, 10) and height < 8
    assert alt.endswith(".")


def test_the_image_point_of_the_sketch_is_on_the_ray(shown):
    ch05_figures.one_ray()
    ax = shown[0][0].axes[0]
    ray = next(line for line in ax.lines if line.get_linewidth() == 3)
    (x, y, z) = (np.asarray(part) for part in ray.get_data_3d())
    start, way = np.array([x[0], y[0], z[0]]), np.array([np.ptp(x), np.ptp(y), 0])
    dot = next(
        line
        for line in ax.lines
        if line.get_marker() == "o" and line.get_color() == plot.RED
    )
    seen = np.ravel(dot.get_data_3d()) - start
    whole = np.array([x[1], y[1], z[1]]) - start
    assert np.allclose(np.cross(seen, whole), 0, atol=1e-9) and way.any()


def test_the_epipolar_lines_lie_in_the_plane(shown):
    ch05_figures.epipolar_plane()
    ax = shown[0][0].axes[0]
    stations, point = ch05_figures.PAIR[:, :3], np.array([0.25, 0.5, 0.0])
    normal = np.cross(*(stations - point))
    dashed = [line for line in ax.lines if line.get_linestyle() == "--"]
    assert len(dashed) == 2
    for line in dashed:
        ends = np.transpose(line.get_data_3d()) - point
        assert np.allclose(ends @ normal, 0, atol=1e-9)


def test_two_rays_are_best_at_a_right_angle():
    def variances(angle):
        pair = ch05_figures.towards(angle)
        from pgm_lab.camera import Camera, project
        from pgm_lab.orientation import intersect

        image = project(Camera(35.0), pair, np.zeros(3))[:, None]
        return np.diag(intersect(Camera(35.0), pair, image, sigma=1e-3).covariance[0])

    angles = np.arange(60.0, 121, 5)
    total = [variances(angle).sum() for angle in angles]
    assert angles[np.argmin(total)] == 90
    sd = 1000 * np.sqrt(variances(90))
    np.testing.assert_allclose(sd, (0.286, 0.202, 0.286), rtol=0, atol=1e-3)
    # Depth as 1 / sin of half the angle, X as 1 / cos
    x, _, z = np.sqrt(variances(40) / variances(90))
    half = np.radians(20)
    assert np.isclose(z, np.sqrt(0.5) / np.sin(half), rtol=1e-3)
    assert np.isclose(x, np.sqrt(0.5) / np.cos(half), rtol=1e-3)


def test_sigma_of_a_point_midway_between_vertical_photos_follows_the_formula():
    for base in (20.0, 40, 160):
        sx, sz = ch05_figures.vertical_precision(base)
        h, c, sigma = 120.0, 35.0, 0.003
        assert np.isclose(sx, h / c * sigma / np.sqrt(2), rtol=1e-6)
        assert np.isclose(sz, h / base * h / c * np.sqrt(2) * sigma, rtol=1e-6)


def test_the_text_of_the_base_says_what_is_drawn(shown, monkeypatch):
    monkeypatch.setattr(ch05_figures, "interact", lambda draw, **_: draw(80))
    ch05_figures.base_by_hand()
    assert "base 80 m, rays that meet at 37 degrees" in shown[0][1]
    assert "sigma Z 22 mm" in shown[0][1]


def test_the_ladder_and_the_misprints_say_their_numbers(shown):
    ch05_case_figures.ladder(LADDER)
    ch05_case_figures.misprints([1e-9, 0.8], ["b11", "b12"])
    assert "as it stands: 51" in shown[0][1]
    assert "1 agree" in shown[1][1] and "b12 deviate" in shown[1][1]


@pytest.mark.parametrize(
    "draw",
    [
        lambda: ch05_case_figures.heights(np.ones((5, 9))),
        lambda: ch05_case_figures.residuals(np.ones((3, 3, 2)), np.ones((3, 3, 2))),
        lambda: ch05_case_figures.ladder({"a": -1.0}),
        lambda: ch05_figures.meeting(PAIR, POINTS, ["left"]),
    ],
)
def test_what_cannot_be_drawn_is_refused(draw):
    with pytest.raises(ValueError):
        draw()
