"""Exercise feedback: right answers pass, and each slip is named in plain words."""

from functools import partial

import numpy as np
import pytest

from pgm_book.ch01 import checks as chapter1
from pgm_book.ch06 import checks as chapter6
from pgm_book.ch07 import checks as chapter7
from pgm_book.ch08 import checks as chapter8
from pgm_book.chA1 import checks as chapterA1
from pgm_book.common import checks
from pgm_book.common.checks import CheckFailed
from pgm_lab import frames, image
from tests.common.slips import unnamed


def test_right_answers_pass(capsys):
    chapter1.corner((11.8, -7.9))
    chapter1.pixel_to_photo(frames.pixel_to_photo)
    chapter1.photo_to_pixel(frames.photo_to_pixel)
    chapter1.flying_height(lambda gsd, um, c: gsd * c / um * 1000)
    chapter1.centroid(lambda w, b: image.centroid(w, b, sigma=1.0).position)
    assert capsys.readouterr().out.count("✓") == 5


def photo(pixels, size, px, centre=0.5, y=-1, factor=1.0, swap=False):
    """pixel_to_photo with a slip."""
    size = np.array(size)[::-1] if swap else np.array(size)
    return (pixels - (size / 2 - centre)) * np.array(px) * (1, y) * np.array(factor)


def test_slip_in_pixel_to_photo_is_named():
    slips = [
        ({"y": 1}, "y axis is flipped"),
        ({"centre": 0.0}, "half a pixel off"),
        ({"centre": 1.0}, "half a pixel off"),
        ({"centre": -0.5}, "one pixel off: counting starts at 0"),
        ({"centre": 3.0}, r"centre of the image is not at \(0, 0\)"),
        ({"factor": 1e-3}, "units are not millimetres, but metres"),
        ({"factor": 1e3}, "units are not millimetres, but micrometres"),
        ({"factor": 1e6}, "power of ten is missing"),
        ({"factor": 2.0}, "not one pixel size long in x and y"),
        ({"factor": (1.0, 2.0)}, "not one pixel size long in y"),
        ({"factor": (2.0, 1.0)}, "not one pixel size long in x"),
        ({"swap": True}, "two numbers of image_size are exchanged"),
    ]
    assert unnamed(lambda s: chapter1.pixel_to_photo(partial(photo, **s)), slips) == []


def test_both_axes_mirrored_and_a_rounded_answer_are_named():
    with pytest.raises(CheckFailed, match="both axes are mirrored"):
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x, y=1) * (-1, 1))
    with pytest.raises(CheckFailed, match="right, but rounded"):
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x).round(3))


def test_exchanged_columns_and_rows_get_one_complaint():
    with pytest.raises(CheckFailed, match="columns and rows are exchanged") as failed:
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x)[:, ::-1])
    assert "flipped" not in str(failed.value)


def test_steps_that_do_not_add_up_are_named():
    with pytest.raises(CheckFailed, match="not their sum"):
        chapter1.pixel_to_photo(
            lambda p, s, x: photo(p, s, x) + (np.abs(photo(p, s, x)) > 2 * np.array(x))
        )


def test_two_slips_are_both_named():
    with pytest.raises(CheckFailed, match="half a pixel off.*y axis is flipped"):
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x, centre=0.0, y=1))


def test_flipped_x_and_exchanged_pixel_sizes_are_named():
    with pytest.raises(CheckFailed, match="step to the right must make x greater"):
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x) * (-1, 1))
    with pytest.raises(CheckFailed, match="not one pixel size long in"):
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x[::-1]))


def pixel(photo, size, px, y=-1, shift=0.0, power=-1, swap=False, whole=False):
    """photo_to_pixel with a slip."""
    answer = photo * np.power(px, power) * (1, y) + np.array(size) / 2 - 0.5 + shift
    answer = np.round(answer) if whole else answer
    return answer[:, ::-1] if swap else answer


def test_slip_in_photo_to_pixel_is_named():
    slips = [
        ({"y": 1}, r"rows come back mirrored: this is \(B 2.5b\)"),
        ({"shift": 0.5}, "half a pixel off"),
        ({"shift": -1.0}, "one pixel off"),
        ({"shift": 3.0}, "does not end where it began"),
        ({"power": 1}, "must be divided by the size of a pixel"),
        ({"swap": True}, "columns and rows are exchanged"),
        ({"whole": True}, "do not round"),
    ]
    assert unnamed(lambda s: chapter1.photo_to_pixel(partial(pixel, **s)), slips) == []


def test_slip_with_the_camera_on_the_way_back_is_named():
    slips = [
        (lambda f, s, p: pixel(f, s[::-1], p), "numbers of image_size are exchanged"),
        (lambda f, s, p: pixel(f, s, p[::-1]), "pixel sizes are exchanged"),
        (lambda f, s, p: pixel(f, s, (p[0], p[0])), "another than that in x"),
        (lambda f, s, p: pixel(f, (1, 1), p), "centre of the image is not added"),
        (lambda f, s, p: pixel(f * (-1, 1), s, p), "columns come back mirrored"),
        (lambda f, s, p: pixel(f, s, p).round(3), "do not round"),
        (lambda f, s, p: np.floor(pixel(f, s, p) + 1e-9), "do not round"),
    ]
    assert unnamed(chapter1.photo_to_pixel, slips) == []


@pytest.mark.parametrize("decimals", [5, 7])
def test_rounded_photo_coordinates_do_not_pass(decimals):
    with pytest.raises(CheckFailed, match="rounded"):
        chapter1.pixel_to_photo(lambda p, s, x: photo(p, s, x).round(decimals))


def test_slip_in_the_flying_height_is_named():
    slips = [
        (lambda g, um, c: g * c / um, r"power of ten \(10\^-3\)"),
        (lambda g, um, c: g * um / c * 1000, "twice the principal distance"),
        (lambda g, um, c: c / (g * um), "twice the ground sampling distance"),
        (lambda g, um, c: 2 * g * c / um * 1000, "does not follow from GSD"),
        (lambda g, um, c: round(g * c / um * 1000), "do not round"),
        (lambda g, um, c: 1.02 * g * c / um * 1000, "does not follow from GSD"),
        (lambda g, um, c: -g * c / um * 1000, "must be positive"),
        (lambda g, um, c: 0.0, "must be positive"),
    ]
    assert unnamed(chapter1.flying_height, slips) == []


def weighted(window, background, first=0, swap=False, power=1):
    """Centroid with a slip."""
    rows, columns = np.indices(window.shape) + first
    weight = (window - background) ** power
    answer = np.array([(columns * weight).sum(), (rows * weight).sum()]) / weight.sum()
    return answer[::-1] if swap else answer


def test_slip_in_the_centroid_is_named():
    slips = [
        (lambda w, b: weighted(w, 0.0), "background is still in"),
        (lambda w, b: weighted(w, b, first=1), "one pixel off"),
        (lambda w, b: weighted(w, b, swap=True), "row and column are exchanged"),
        (lambda w, b: weighted(w, b) + 0.3, "missed by 0.3 px"),
        (lambda w, b: weighted(w, b).round(2), "rounded"),
        (lambda w, b: weighted(w, b) + 0.5, "half a pixel off"),
        (lambda w, b: weighted(w, b, power=2), "look at the weights and the sums"),
        (lambda w, b: weighted(w[:, :21], b), "look at the weights and the sums"),
        (lambda w, b: weighted(w, 40.0), "is missed by"),
        (lambda w, b: weighted(np.maximum(w, b), b), "keep them"),
        (lambda w, b: (0, 20) + weighted(w, b) * (1, -1), "row counts upwards"),
    ]
    assert unnamed(chapter1.centroid, slips) == []


def test_slip_in_the_corner_is_named():
    slips = [
        ((-7.9, 11.8), "x and y are exchanged"),
        ((11.8, 7.9), "below the centre"),
        ((-11.8, 7.9), "both axes are mirrored"),
        ((1.18, -0.79), "not millimetres"),
        ((11.793905, -7.893904), "centre of the last pixel"),
        ((11.806095, -7.906096), "half a pixel beyond the sensor"),
        ((11800.0, -7900.0), "not millimetres"),
        ((0.0118, -0.0079), "not millimetres"),
        ((968.0, -648.0), "still in pixels"),
        ((12.0, -8.0), "rounded to millimetres"),
        ((10.0, -8.0), "does not end there"),
        ((11.79992, -7.89912), "but nearly: half its size is exact"),
        ((23.6, -15.8), "half the size"),
        ((-11.8, -7.9), "lower left"),
        (..., "lower_right is still empty"),
        ((1, 2, 3), r"^lower_right must be two numbers, \(x, y\) in mm; got \(3,\)"),
    ]
    assert unnamed(chapter1.corner, slips) == []


def stop(*arguments):
    raise ZeroDivisionError("oops")


def change(pixels, size, px):
    pixels += 1
    return pixels


def test_unfinished_function_gets_a_plain_message():
    slips = [
        (lambda *a: None, "returns nothing yet"),
        (lambda *a: ..., "returns nothing yet"),
        (..., "is not a function yet"),
        (lambda *a: "text", "must return numbers, not str"),
        (lambda *a: [1.0, 2.0], r"must return shape \(4, 2\) here; got \(2,\)"),
        (lambda p, *a: p.T, "use np.column_stack"),
        (stop, "stopped with ZeroDivisionError: oops"),
        (change, "changes its input"),
    ]
    assert unnamed(chapter1.pixel_to_photo, slips) == []


@pytest.mark.parametrize("off", [1e-5, 1e-3])
def test_answers_that_are_nearly_right_do_not_pass(off):
    with pytest.raises(CheckFailed, match="missed by"):
        chapter1.centroid(lambda w, b: weighted(w, b) + off)
    with pytest.raises(CheckFailed, match="does not end where it began"):
        chapter1.photo_to_pixel(lambda f, s, p: pixel(f, s, p, shift=off))
    with pytest.raises(CheckFailed, match=r"not at \(0, 0\)"):
        chapter1.pixel_to_photo(lambda f, s, p: photo(f, s, p, centre=0.5 + off))
    with pytest.raises(CheckFailed, match="does not end there"):
        chapter1.corner((11.8 + off, -7.9))


def test_near_is_relative_to_the_largest_number_and_at_least_to_one():
    assert checks.near(1000.0 + 9e-7, 1000.0) and not checks.near(1000.0 + 2e-6, 1000)
    assert checks.near(9e-10, 0.0) and not checks.near(2e-9, 0.0)


def test_message_never_shows_the_answer():
    with pytest.raises(CheckFailed) as failed:
        chapter1.corner((1.0, -1.0))
    assert "11.8" not in str(failed.value) and "7.9" not in str(failed.value)


def test_a_hint_that_asks_ends_in_its_question_mark():
    for hint, end in (("which way is up?", "up?"), ("y is up", "up.")):
        with pytest.raises(CheckFailed) as failed:
            checks.report("y", [("y points up", False, hint)])
        assert str(failed.value).endswith(end)


@pytest.mark.parametrize(
    ("check", "before"),
    [
        (chapterA1.adjust, "the exercise before this one"),
        (chapter6.adjust, "exercises 6.1 and 6.3"),
        (chapter7.chip_shifts, "exercises 7.2 and 7.4"),
        (chapter8.row_points, "exercises 8.1 and 8.4"),
    ],
)
def test_who_left_an_exercise_out_hears_which(check, before):
    with pytest.raises(CheckFailed, match=f"that it uses: do {before} first"):
        check(lambda *arguments: 1.0 - None)


@pytest.mark.parametrize("dtype", [np.float32, np.float16])
def test_single_precision_is_named_and_taken_only_where_it_will_do(dtype):
    def half(x):
        return dtype(x) / dtype(2)

    with pytest.raises(CheckFailed, match="single precision: work with float64"):
        checks.call(half, 1.5, shape=())
    assert checks.call(half, 1.5, shape=(), single=True) == 0.75


def test_notebook_shows_the_message_without_a_traceback():
    assert CheckFailed("so and so")._render_traceback_() == ["✗ so and so"]
