"""The first check of the book: the changed number passes, what was left is named."""

import numpy as np
import pytest

from pgm_book.ch00 import checks
from pgm_lab import datasets, frames
from tests.common.slips import unnamed

BANI = datasets.bani2010()
PIXEL_SIZE = frames.pixel_size_from_sensor(BANI.sensor_size, BANI.image_size)
LEFT, RIGHT = (
    frames.pixel_to_photo(pixels, BANI.image_size, PIXEL_SIZE) for pixels in BANI.pixels
)


@pytest.mark.parametrize("computed", [LEFT[9], LEFT[9].tolist(), tuple(LEFT[9])])
def test_the_tenth_point_passes_in_any_container(computed, capsys):
    checks.tenth(10, computed)
    assert capsys.readouterr().out.startswith("✓ point 10: you changed a number")


def test_what_was_left_is_named():
    slips = [
        (1, LEFT[0], "point is 1. Write `point = 10`"),
        (10, LEFT[0], "run it to its end"),
        (10, RIGHT[9], "set photo to 0 again"),
        (10, LEFT[9] * (1, -1), "not what that cell gives"),
        (..., LEFT[9], "Your turn"),
        ("ten", LEFT[9], "one number"),
        (10, np.full(3, 1.0), "two numbers"),
    ]
    assert unnamed(checks.tenth, slips) == []
