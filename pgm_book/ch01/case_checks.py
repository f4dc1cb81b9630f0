"""Checks of the exercises of the case of chapter 1, forty coordinates."""

from collections.abc import Callable

import numpy as np

from pgm_book.common.checks import call, chance, near, report, shaken
from pgm_lab import frames


def size_and_centre(function: Callable) -> None:
    """Check size_and_centre(pixel, mm): pixel size in mm, and the pixel of zero."""
    rng = chance(12)
    found, lines, turned = [], [], []
    # The third is noisy: there the line along the other axis is another one
    cases = (0.0122, 967.5, 1e-6), (0.004, 1999.5, 1e-6), (0.006, 647.5, 0.01)
    for size, centre, noise in shaken(15, cases):
        pixel = centre + rng.uniform(-400, 400, 20)
        mm = size * (pixel - centre) + rng.normal(0, noise, 20)
        found.append(call(function, pixel, mm, shape=(2,)))
        lines.append(np.polyfit(pixel, mm, 1))
        turned.append(np.polyfit(mm, pixel, 1))
    slope, shift = np.transpose(lines)
    right = np.column_stack([slope, -shift / slope])
    slips = [
        (right[:, ::-1], "the two are exchanged: first the size, then the centre"),
        (lines, "that is the line in mm at pixel 0; at which pixel is the line zero?"),
        (right * (1, -1), "the sign of the centre is reversed"),
        (right ** (-1, 1), "that is pixels per millimetre: invert the size"),
        (right * (1000, 1), "the size is in micrometres, not in millimetres"),
        (right * (1e-3, 1), "the size is in metres, not in millimetres"),
        (turned, "the line runs the other way round: fit mm along pixels"),
        (
            1 / np.array(turned) ** (1, -1),
            "the line runs the other way round: fit mm along pixels",
        ),
        (right + (0, 0.5), "the centre is off by half a pixel"),
        (right - (0, 0.5), "the centre is off by half a pixel"),
        *((right.round(k), "right, but rounded: keep all digits") for k in range(2, 7)),
    ]
    # Each of the two numbers by itself: the sizes are small beside the centres
    near_each = (
        (hint, near(np.array(found) / right, np.array(wrong) / right, 1e-7))
        for wrong, hint in slips
    )
    otherwise = "fit a straight line to all twenty points"
    hint = next((hint for hint, same in near_each if same), otherwise)
    done = near(np.array(found) / right, np.ones((3, 2)), 1e-8)
    report("size_and_centre", [("slope and zero of three lines", done, hint)])


def to_table(function: Callable) -> None:
    """Check to_table(photo, image_size, pixel_size), which returns pixels (n, 2)."""
    rng = chance(13)
    sizes = (1936, 1296), (23.6 / 1936, 15.8 / 1296)
    photo = rng.uniform(-6, 6, (12, 2))
    found = call(function, photo, *sizes, shape=(12, 2))
    centre = frames.image_centre(sizes[0])

    def table(decimals: int, digits: int, y: int = 1, half: float = 0.0) -> np.ndarray:
        pixels = photo.round(decimals) / sizes[1] * (1, y) + centre + half
        return pixels.round(digits)

    hints = (
        (table(15, 7), "the millimetres are not rounded to six decimals first"),
        (table(5, 7), "Table 4.2 has five decimals; what made Table 4.1 had six"),
        (table(6, 15), "Table 4.1 has seven decimals: round the pixels, too"),
        (table(6, 7, -1), "the sign of y: (B 2.5b) as printed has a plus"),
        (table(6, 7, -1)[:, ::-1], "columns and rows are exchanged"),
        (table(6, 7, 1, 0.5), "the centre is off by half a pixel"),
        (table(6, 7) - 2 * centre, "the centre is subtracted, not added"),
    )
    right = near(found, table(6, 7), 1e-12)
    slip = (hint for wrong, hint in hints if near(found, wrong, 1e-12))
    hint = next(slip, "round to six decimals, convert by (B 2.5), round to seven")
    report("to_table", [("twelve points with all their digits", right, hint)])
