"""Feedback on the exercises of chapter 1: right answers pass, each slip is named."""

from functools import partial

import numpy as np
import pytest

from pgm_book.ch01 import checks
from pgm_book.common.checks import CheckFailed
from pgm_lab import frames, image
from tests.common.slips import unnamed


def photo(pixels, size, px, centre=0.5, y=-1, factor=1.0, swap=False):
    """pixel_to_photo with a slip."""
    size = np.array(size)[::-1] if swap else np.array(size)
    return (pixels - (size / 2 - centre)) * np.array(px) * (1, y) * np.array(factor)


def pixel(photo, size, px, y=-1, shift=0.0, power=-1, swap=False, whole=False):
    """photo_to_pixel with a slip."""
    answer = photo * np.power(px, power) * (1, y) + np.array(size) / 2 - 0.5 + shift
    answer = np.round(answer) if whole else answer
    return answer[:, ::-1] if swap else answer


def weighted(window, background, first=0, swap=False, power=1):
    """Centroid with a slip."""
    rows, columns = np.indices(window.shape) + first
    weight = (window - background) ** power
    answer = np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()
    return answer[::-1] if swap else answer


def test_right_answers_pass(capsys):
    checks.pixel_to_photo(frames.pixel_to_photo)
    checks.photo_to_pixel(frames.photo_to_pixel)
    checks.flying_height(lambda gsd, um, c: gsd * c / um * 1000)
    checks.centroid(lambda w, b: image.centroid(w, b, sigma=1.0).position)
    assert capsys.readouterr().out.count("✓") == 4


SLIPS = {
    checks.pixel_to_photo: [
        (partial(photo, y=1), "y axis is flipped"),
        (partial(photo, centre=0.0), "half a pixel off"),
        (partial(photo, centre=1.0), "half a pixel off"),
        (partial(photo, centre=-0.5), "one pixel off: counting starts at 0"),
        (partial(photo, centre=3.0), r"centre of the image is not at \(0, 0\)"),
        (partial(photo, centre=0.50001), r"not at \(0, 0\)"),
        (partial(photo, centre=0.501), r"not at \(0, 0\)"),
        (partial(photo, factor=1e-3), "units are not millimetres, but metres"),
        (partial(photo, factor=1e3), "units are not millimetres, but micrometres"),
        (partial(photo, factor=1e6), "power of ten is missing"),
        (partial(photo, factor=2.0), "not one pixel size long in x and y"),
        (partial(photo, factor=(1.0, 2.0)), "not one pixel size long in y"),
        (partial(photo, factor=(2.0, 1.0)), "not one pixel size long in x"),
        (partial(photo, swap=True), "two numbers of image_size are exchanged"),
        (partial(photo, centre=0.0, y=1), "half a pixel off.*y axis is flipped"),
        (lambda p, s, x: photo(p, s, x, y=1) * (-1, 1), "both axes are mirrored"),
        (lambda p, s, x: photo(p, s, x)[:, ::-1], "columns and rows are exchanged"),
        (lambda p, s, x: photo(p, s, x) * (-1, 1), "right must make x greater"),
        (lambda p, s, x: photo(p, s, x[::-1]), "not one pixel size long in"),
        (lambda p, s, x: photo(p, s, x) + (np.abs(photo(p, s, x)) > 2 * np.array(x)),
         "not their sum"),
        (lambda p, s, x: photo(p, s, x).round(3), "right, but rounded"),
        (lambda p, s, x: photo(p, s, x).round(5), "rounded"),
        (lambda p, s, x: photo(p, s, x).round(7), "rounded"),
    ],
    checks.photo_to_pixel: [
        (partial(pixel, y=1), r"rows come back mirrored: this is \(B 2.5b\)"),
        (partial(pixel, shift=0.5), "half a pixel off"),
        (partial(pixel, shift=-1.0), "one pixel off"),
        (partial(pixel, shift=3.0), "does not end where it began"),
        (partial(pixel, shift=1e-5), "does not end where it began"),
        (partial(pixel, shift=1e-3), "does not end where it began"),
        (partial(pixel, power=1), "must be divided by the size of a pixel"),
        (partial(pixel, swap=True), "columns and rows are exchanged"),
        (partial(pixel, whole=True), "do not round"),
        (lambda f, s, p: pixel(f, s[::-1], p), "numbers of image_size are exchanged"),
        (lambda f, s, p: pixel(f, s, p[::-1]), "pixel sizes are exchanged"),
        (lambda f, s, p: pixel(f, s, (p[0], p[0])), "another than that in x"),
        (lambda f, s, p: pixel(f, (1, 1), p), "centre of the image is not added"),
        (lambda f, s, p: pixel(f * (-1, 1), s, p), "columns come back mirrored"),
        (lambda f, s, p: pixel(f, s, p).round(3), "do not round"),
        (lambda f, s, p: np.floor(pixel(f, s, p) + 1e-9), "do not round"),
    ],
    checks.flying_height: [
        (lambda g, um, c: g * c / um, r"power of ten \(10\^-3\)"),
        (lambda g, um, c: g * um / c * 1000, "twice the principal distance"),
        (lambda g, um, c: c / (g * um), "twice the ground sampling distance"),
        (lambda g, um, c: 2 * g * c / um * 1000, "does not follow from GSD"),
        (lambda g, um, c: round(g * c / um * 1000), "do not round"),
        (lambda g, um, c: 1.02 * g * c / um * 1000, "does not follow from GSD"),
        (lambda g, um, c: -g * c / um * 1000, "must be positive"),
        (lambda g, um, c: 0.0, "must be positive"),
    ],
    checks.centroid: [
        (lambda w, b: weighted(w, 0.0), "background is still in"),
        (lambda w, b: weighted(w, b, first=1), "one pixel off"),
        (lambda w, b: weighted(w, b, swap=True), "row and column are exchanged"),
        (lambda w, b: weighted(w, b) + 0.3, "missed by 0.3 px"),
        (lambda w, b: weighted(w, b) + 1e-3, "missed by"),
        (lambda w, b: weighted(w, b) + 1e-5, "missed by"),
        (lambda w, b: weighted(w, b).round(2), "rounded"),
        (lambda w, b: weighted(w, b) + 0.5, "half a pixel off"),
        (lambda w, b: weighted(w, b, power=2), "look at the weights and the sums"),
        (lambda w, b: weighted(w[:, :21], b), "look at the weights and the sums"),
        (lambda w, b: weighted(w, 40.0), "is missed by"),
        (lambda w, b: weighted(np.maximum(w, b), b), "keep them"),
        (lambda w, b: (0, 20) + weighted(w, b) * (1, -1), "row counts upwards"),
    ],
}  # fmt: skip


@pytest.mark.parametrize("check", SLIPS, ids=lambda check: check.__name__)
def test_each_slip_is_named(check):
    assert unnamed(check, SLIPS[check]) == []


def test_exchanged_columns_and_rows_get_one_complaint():
    with pytest.raises(CheckFailed) as failed:
        checks.pixel_to_photo(lambda p, s, x: photo(p, s, x)[:, ::-1])
    assert "flipped" not in str(failed.value)


def test_message_never_shows_the_answer():
    with pytest.raises(CheckFailed) as failed:
        checks.flying_height(lambda gsd, um, c: 1.0)
    assert "874" not in str(failed.value)
