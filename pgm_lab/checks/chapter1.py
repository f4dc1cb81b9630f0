"""Checks of the exercises of chapter 1, from pixel to photo."""

from collections.abc import Callable

import numpy as np

from pgm_lab import frames, simulate
from pgm_lab.checks import call, near, report

# Image sizes and pixel sizes (mm) on which a function is tried: landscape, upright, odd
_CAMERAS = [
    ((1936, 1296), (0.0122, 0.0122)),
    ((3000, 4000), (0.005, 0.004)),
    ((11, 7), (2.0, 3.0)),
]


def corner(answer: object) -> None:
    """Check the photo coordinates of the lower right corner of the sensor, in mm."""
    value = call(lambda: answer, shape=(2,))
    size = frames.pixel_size_from_sensor((23.6, 15.8), (1936, 1296))
    last_pixel = frames.pixel_to_photo((1935, 1295), (1936, 1296), size)
    report(
        "the corner",
        [
            ("x is to the right", value[0] > 0, "it lies to the right of the centre"),
            ("y is down", value[1] < 0, "it lies below the centre, and y points up"),
            (
                "it is where the sensor ends",
                near(value, last_pixel + size * (0.5, -0.5), 1e-6),
                "this is the centre of the last pixel; the sensor ends half a pixel on"
                if near(value, last_pixel, 1e-4)
                else "the sensor does not end there",
            ),
        ],
    )


def pixel_to_photo(function: Callable) -> None:
    """Check the reader's pixel_to_photo(pixels, image_size, pixel_size)."""
    trials = []
    for image_size, pixel_size in _CAMERAS:
        centre = frames.image_centre(image_size)
        pixels = centre + [[0, 0], [1, 0], [0, 1], [-3.25, 2.5]]
        photo = call(function, pixels, image_size, pixel_size, shape=(4, 2))
        step = (photo - photo[0]) / pixel_size
        trials.append((photo[0] / pixel_size, step[1], step[2], step[3]))
    stacked = (np.array(part) for part in zip(*trials, strict=True))
    report("my_pixel_to_photo", _photo_properties(*stacked))


def _photo_properties(centre, right, down, other):
    """What each step in the image does in the photo, in pixels."""
    unit = np.abs(np.concatenate([right, down])).max(axis=0)
    in_millimetres = near(unit, 1.0)
    half = np.isclose(np.abs(centre), 0.5).any()
    return [
        (
            "the centre is (0, 0)",
            near(centre, 0.0),
            "the centre of the image is half a pixel off"
            if half
            else "the centre of the image is not at (0, 0); are columns and rows"
            " exchanged?",
        ),
        (
            "the units are millimetres",
            in_millimetres,
            "the units are not millimetres (a factor of 1000?)"
            if near(unit * 1000, 1.0) or near(unit / 1000, 1.0)
            else "a step of one pixel is not one pixel size long in x and in y",
        ),
        (
            "x points right",
            bool(np.all(right[:, 0] > 0) and np.all(right[:, 1] == 0)),
            "a step to the right must make x greater and leave y alone",
        ),
        (
            "y points up",
            bool(np.all(down[:, 1] < 0) and np.all(down[:, 0] == 0)),
            "the y axis is flipped: a step down must make y smaller",
        ),
        (
            "steps add up",
            near(other, -3.25 * right + 2.5 * down),
            "the function is not linear: two steps together must be their sum",
        ),
    ]


def photo_to_pixel(function: Callable) -> None:
    """Check the reader's photo_to_pixel(photo, image_size, pixel_size)."""
    there_and_back, columns, rows = [], [], []
    for image_size, pixel_size in _CAMERAS:
        pixels = np.array([[0.0, 0.0], [5.0, 2.5], [10.25, 6.0]])
        photo = frames.pixel_to_photo(pixels, image_size, pixel_size)
        back = call(function, photo, image_size, pixel_size, shape=(3, 2))
        there_and_back.append(back - pixels)
        columns.append(near(back[:, 0], pixels[:, 0]))
        mirrored = image_size[1] - 1 - pixels[:, 1]
        rows.append(near(back[:, 1], mirrored))
    error = np.concatenate(there_and_back)
    constant = bool(np.all(np.isclose(np.abs(error), 0.5) | np.isclose(error, 0)))
    if all(rows):
        hint = "rows come back mirrored: this is (2.5b) as printed"
    elif constant:
        hint = "the way back ends half a pixel off"
    else:
        hint = "the way there and back does not end where it began"
    report(
        "my_photo_to_pixel",
        [
            ("columns come back", all(columns), "the columns do not come back"),
            ("pixel to photo to pixel ends where it began", near(error, 0.0), hint),
        ],
    )


def flying_height(function: Callable) -> None:
    """Check the reader's height(gsd_m, pixel_um, c_mm), which answers in metres."""
    cases = np.array([(0.2, 5.49, 24.0), (0.05, 4.0, 35.0), (0.1, 12.0, 153.0)])
    heights = np.array([float(call(function, *case, shape=())) for case in cases])
    expected = frames.flying_height(cases[:, 0], cases[:, 1] / 1000, cases[:, 2])
    ratio = heights / expected
    doubled = float(call(function, 0.4, 5.49, 24.0, shape=()))
    longer = float(call(function, 0.2, 5.49, 48.0, shape=()))
    decade = np.log10(np.abs(ratio) + 1e-300)
    wrong_unit = near(decade, np.round(decade), 1e-6) and near(decade, decade[0], 1e-6)
    report(
        "height",
        [
            (
                "twice the GSD, twice the height",
                near(doubled, 2 * heights[0]),
                "twice the ground sampling distance must need twice the height",
            ),
            (
                "twice the principal distance, twice the height",
                near(longer, 2 * heights[0]),
                "twice the principal distance must allow twice the height",
            ),
            (
                "metres",
                near(ratio, 1.0),
                f"the unit is wrong by a power of ten (10^{decade[0]:.0f})"
                if wrong_unit
                else "the height does not follow from GSD, pixel size and c",
            ),
        ],
    )


def centroid(function: Callable) -> None:
    """Check the reader's centroid(window, background), which answers (column, row)."""
    centres = np.array([[10.3, 8.6], [9.1, 12.4], [14.0, 9.7]])
    errors, windows = [], []
    for centre in centres:
        window = simulate.target(centre, diameter=6.0, shape=(21, 25))
        errors.append(call(function, window, 40.0, shape=(2,)) - centre)
        windows.append(window)
    errors = np.array(errors)
    if near(errors, 0.0, 1e-5):
        hint = ""
    elif near(errors + centres, centres[:, ::-1], 1e-5):
        hint = "row and column are exchanged: the answer is (column, row)"
    elif near(errors, 1.0, 1e-5):
        hint = "one pixel off: the first pixel is number 0 here, not number 1"
    elif near(errors + centres, [_unweighted(window) for window in windows], 1e-5):
        hint = "the background is still in: it pulls towards the middle of the window"
    else:
        hint = f"the centre is missed by up to {np.abs(errors).max():.2f} px"
    report("my_centroid", [("finds three targets to 1e-4 px", not hint, hint)])


def _unweighted(window: np.ndarray) -> np.ndarray:
    """Centroid with the background left in."""
    rows, columns = np.indices(window.shape)
    return np.array([(columns * window).sum(), (rows * window).sum()]) / window.sum()
