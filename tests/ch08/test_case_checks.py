"""Exercise feedback of the case of chapter 8: right answers pass, slips are named."""

import numpy as np
import pytest

from pgm_book.ch08 import case_checks as chapter8c
from pgm_book.common.checks import CheckFailed
from pgm_lab import simulate, stereo
from tests.common.slips import unnamed

STATIONS = np.array([(0.0, 0, 1000), (400, 0, 1000)])
BLANK = np.zeros((60, 90), np.float32)


@pytest.fixture(scope="module")
def flat():
    """A normal pair over flat ground at 20 m, where the disparity is zero."""
    shift = 24.0 * 400 / 980
    origin = np.array([(shift / 2, 1.0), (-shift / 2, 1.0)])
    pair = stereo.NormalPair(BLANK, BLANK, np.eye(3), STATIONS, 24.0, 0.005, origin)
    ground = np.full((60, 60), 20.0, np.float32)
    kind = np.zeros((60, 60), np.uint8)
    land = simulate.Landscape(ground, ground, ground, kind, (-100.0, 300.0), 10.0)
    return pair, [(40, 30), (50, 20), (60, 10)], land


def test_weighted_means_pass_rounded_or_not(capsys):
    chapter8c.weighted((1.50, 1.53))
    chapter8c.weighted([262.97 / 175, 268.33 / 175])
    assert "✓" in capsys.readouterr().out


def test_slips_of_the_weighted_means_are_named():
    slips = [
        ((1.48, 1.51), "more points"),
        ((262.97, 268.33), "divide the sum"),
        ((87.66, 89.44), "not by the locations"),
        ((1.533, 1.503), "exchanged"),
        ((1.71, 1.75), "as often as"),
        (..., "Your turn"),
        (1.5, "two numbers"),
    ]
    assert unnamed(chapter8c.weighted, slips) == []


def test_marks_on_the_ground_pass_and_are_told_in_metres(flat, capsys):
    chapter8c.marks([0.0, 1, -1], *flat)
    said = capsys.readouterr().out
    assert (
        "B: the mark is 0.50 m above" in said and "C: the mark is 0.50 m below" in said
    )
    assert "✓ mine: A on the ground" in said


def test_marks_in_the_air_are_named(flat):
    slips = [
        ([0.0, 8, 0], "8 pixels too large"),
        ([-9, 0, 0], "too small"),
        (..., "Your turn"),
    ]
    assert unnamed(lambda slip: chapter8c.marks(slip, *flat), slips) == []


def test_a_lost_sign_is_named(flat):
    pair, places, land = flat
    moved = pair.origin + np.array([(0, 0), (0.1, 0)])  # twenty pixels of disparity
    shifted = stereo.NormalPair(BLANK, BLANK, np.eye(3), STATIONS, 24.0, 0.005, moved)
    with pytest.raises(CheckFailed, match="sign"):
        chapter8c.marks([-20.0, -20, -20], shifted, places, land)


def test_a_line_has_61_times_fewer_positions(capsys):
    chapter8c.fewer(61)
    assert "✓" in capsys.readouterr().out


def test_slips_of_counting_are_named():
    slips = [
        (30, "both sides"),
        (60, "centre"),
        (3721, "in the square"),
        (1 / 61, "other way round"),
        (7, "count the positions"),
        (..., "Your turn"),
    ]
    assert unnamed(chapter8c.fewer, slips) == []
