"""Figures and tables: what reaches the notebook."""

import base64

import cv2
import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import plot


@pytest.fixture
def published(monkeypatch):
    """Collect what would be shown."""
    shown = []
    monkeypatch.setattr(
        plot.basic, "publish_display_data", lambda *parts: shown.append(parts)
    )
    return shown


def test_figure_carries_its_alt_text_and_is_closed(published):
    fig = plt.figure(figsize=(5, 3))
    plot.show(fig, "A point & a line.", dpi=50)
    data, metadata = published[0]
    assert data["text/plain"] == "A point & a line."
    assert metadata["image/png"] == {"alt": "A point & a line.", "width": 480}
    coded = np.frombuffer(base64.b64decode(data["image/png"]), np.uint8)
    assert cv2.imdecode(coded, cv2.IMREAD_COLOR).shape == (150, 250, 3)
    assert not plt.fignum_exists(fig.number)


def test_with_a_figure_goes_the_size_of_its_smallest_writing(published):
    fig, ax = plt.subplots()
    ax.imshow(np.eye(4))
    ax.scatter([0, 1], [1, 0])
    ax.tick_params(labelsize=11)
    ax.set_title("large", fontsize=20)
    ax.text(1, 1, "$x^2$", fontsize=9.5)  # the raised 2 counts as the formula does
    ax.text(1, 1, "not drawn", fontsize=3, visible=False)
    ax.text(1, 1, "", fontsize=2)
    hidden = fig.add_axes((0.7, 0.7, 0.2, 0.2))
    hidden.tick_params(labelsize=4)
    hidden.set_axis_off()
    plot.show(fig, "Sizes.")
    assert published[0][1]["image/png"]["label"] == 9.5


def test_few_colours_make_a_photo_smaller_and_keep_its_rare_colours(published):
    photo = np.random.default_rng(1).integers(0, 256, (60, 60))
    for colours in (None, 64):
        fig, ax = plt.subplots(figsize=(2, 2))
        ax.imshow(photo, cmap="gray")
        ax.plot(30, 30, "o", color=plot.RED, markersize=12)
        plot.show(fig, "Noise and a dot.", colours=colours)
    full, small = (base64.b64decode(data["image/png"]) for data, _ in published)
    assert len(small) < 0.6 * len(full)
    pixels = cv2.imdecode(np.frombuffer(small, np.uint8), cv2.IMREAD_COLOR)
    pixels = pixels.reshape(-1, 3).astype(int)
    assert len(np.unique(pixels, axis=0)) <= 64
    dot = np.array([int(plot.RED[i : i + 2], 16) for i in (5, 3, 1)])
    assert np.abs(pixels - dot).max(axis=1).min() < 16  # the dot is still red


def test_figure_without_alt_text_is_refused(published):
    fig = plt.figure()
    with pytest.raises(ValueError, match="alt must say in words"):
        plot.show(fig, " ")
    plt.close(fig)
    assert not published


def test_table_has_a_caption_heads_and_escaped_cells(published):
    plot.table(["point", "x (mm)"], [["A<B", 1.5], ["C", "2"]], "Two points")
    (data,) = published[0]
    assert "<caption>Two points</caption>" in data["text/html"]
    assert '<th scope="col">x (mm)</th>' in data["text/html"]
    assert (
        '<th scope="row" class="text" style="text-align: left">A&lt;B</th><td>1.5</td>'
        in data["text/html"]
    )
    assert data["text/plain"] == "Two points\npoint  x (mm)\nA<B    1.5\nC      2"


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("-4.98644", True),
        ("6.10 µm", True),
        ("23.600001 ± 0.000004", True),
        ("40,000", True),
        ("(2.5b)", False),
        ("39,000 to 43,000", False),
        ("x", False),
    ],
)
def test_numbers_are_told_from_words(text, number):
    assert plot.basic._is_number(text) == number


@pytest.mark.parametrize("magnify", [1.0, 50.0])
def test_an_ellipse_reaches_as_far_as_the_variances_allow(magnify, closed):
    """In x to the root of chi-square times the variance of x, and so in y."""
    _, ax = plt.subplots()
    C = np.array([[4.0, 1.5], [1.5, 1.0]])
    ellipse = plot.error_ellipse(ax, (2, -1), C, magnify=magnify)  # 95 per cent
    assert ellipse in ax.patches
    path = ellipse.get_path().transformed(ellipse.get_patch_transform())
    box = path.get_extents()
    half = magnify * np.sqrt(-2 * np.log(0.05) * np.diag(C))
    # Four Bézier curves are a circle up to 3e-4 of its radius
    np.testing.assert_allclose(box.size / 2, half, rtol=3e-4)
    np.testing.assert_allclose((box.min + box.max) / 2, (2, -1), atol=1e-9 * magnify)


# --- Two images on each other ---

EDGE = np.tile(np.arange(60) >= 30, (50, 1)) * 100.0  # dark left, bright from column 30
MOVED = np.roll(EDGE, 2, axis=1)
MOVED[:, :2] = 0


def test_where_both_are_alike_it_is_grey_and_elsewhere_one_colour_is_left():
    red, green, blue = np.moveaxis(plot.basic.composite(EDGE, MOVED), -1, 0)
    assert np.array_equal(red, blue)
    fringe = green > red
    assert set(np.flatnonzero(fringe.any(axis=0))) == {30, 31}
    assert np.array_equal(red[~fringe], green[~fringe])


def test_the_colours_of_the_paper_are_red_and_green():
    red, green, blue = np.moveaxis(plot.basic.composite(EDGE, MOVED, paper=True), -1, 0)
    assert not blue.any()
    assert np.all(green[:, 30] > red[:, 30])


def test_what_is_missing_is_white():
    for again in (
        np.ma.masked_array(EDGE, EDGE < 50),
        np.where(EDGE < 50, np.nan, EDGE),
    ):
        assert np.all(plot.basic.composite(EDGE, again)[:, :30] == 1)


def test_an_overlay_says_which_colour_is_which(closed):
    title = plot.overlay(EDGE, MOVED).axes[0].get_title()
    assert title == "green: reference, magenta: sensed, grey: equal"
    assert "red: sensed" in plot.overlay(EDGE, MOVED, paper=True).axes[0].get_title()
