"""Checks of the exercises of chapter NUMBER, LOWER."""

from collections.abc import Callable

from pgm_book.common.checks import compare, report
from pgm_lab import frames

CASES = [(0.004, 120.0, 8.0), (0.006, 900.0, 35.0), (0.01, 45.0, 20.0)]


def ground_size(function: Callable[[float, float, float], object]) -> None:
    """Check a function that gives the size of a pixel on the ground."""
    slips = {
        "that is upside down: look at the triangles again": lambda p, H, c: c / (p * H),
        "those are centimetres": lambda p, H, c: 100 * p * H / c,
        "those are millimetres": lambda p, H, c: 1000 * p * H / c,
        "the height and the principal distance are exchanged": lambda p, H, c: (
            p * c / H
        ),
    }
    right = frames.ground_sampling_distance
    otherwise = "the size does not follow from the two triangles"
    holds, hint = compare(function, CASES, right, slips, otherwise)
    report("ground_size", [("in metres, for every camera", holds, hint)])
