"""Checks of the exercises of chapter 1, from pixel to photo."""

from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    call,
    first_slip,
    near,
    report,
    shaken,
    varied,
)
from pgm_lab import frames, simulate

# Image sizes and pixel sizes (mm) of the trials: landscape, portrait, odd
_CAMERAS = [
    ((1936, 1296), (23.6 / 1936, 15.8 / 1296)),
    ((3000, 4000), (0.005, 0.004)),
    ((11, 7), (2.0, 3.0)),
]
# Centre, background, seed of the noise of the targets
_TARGETS = [((10.0, 9.0), 40.0, 40), ((9.0, 12.0), 60.0, 60), ((21.0, 10.0), 20.0, 20)]
_UNITS = ((1e-3, "metres"), (0.1, "centimetres"), (1e3, "micrometres"))
_FACTORS = (1e-6, 1e-3, 0.1, 10, 1e3, 1e6)  # of units taken for millimetres


def _cameras(number: int) -> list:
    """The cameras of a check: those above, or under a secret others like them."""

    def drawn(rng: np.random.Generator) -> list:
        return [
            (
                tuple((2 * rng.integers(1, 9, 2) + size).tolist()),  # odd stays odd
                tuple((rng.uniform(0.8, 1.2, 2) * pixel_size).tolist()),
            )
            for size, pixel_size in _CAMERAS
        ]

    return varied(number, _CAMERAS, drawn)


def pixel_to_photo(function: Callable) -> None:
    """Check the reader's pixel_to_photo(pixels, image_size, pixel_size)."""
    trials = []
    for image_size, pixel_size in _cameras(10):
        centre = frames.image_centre(image_size)
        pixels = centre + [[0, 0], [1, 0], [0, 1], [-3.25, 2.5]]
        photo = call(function, pixels, image_size, pixel_size, shape=(4, 2))
        for decimals in range(2, 8):
            exact = frames.pixel_to_photo(pixels, image_size, pixel_size)
            if not near(photo, exact) and np.array_equal(photo, exact.round(decimals)):
                raise CheckFailed(
                    "pixel_to_photo: right, but rounded: keep all digits."
                )
        photo = photo / pixel_size
        trials.append((photo[0], *(photo[1:] - photo[0]), centre))
    centres, right, down, other, middles = (np.array(t) for t in zip(*trials))
    if near(right[:, 0], 0.0) and near(down[:, 1], 0.0):
        raise CheckFailed(
            "pixel_to_photo: columns and rows are exchanged: a step to the right"
            " changes y. pixels[:, 0] holds the columns."
        )
    unit = np.abs([right[:, 0], down[:, 1]])  # lengths of a step in x and in y
    if near(right[:, 0], -1.0) and near(down[:, 1], 1.0):
        raise CheckFailed(
            "pixel_to_photo: both axes are mirrored: a half turn, which is right for"
            " neither. Rows and y count in opposite directions, columns and x do not."
        )
    millimetres = near(unit, 1.0)
    report(
        "pixel_to_photo",
        [
            (
                "the centre is (0, 0)",
                along_with(near(centres, 0.0), bool(np.all(unit > 0))),
                _centre_hint(centres, middles),
            ),
            ("the units are millimetres", millimetres, _unit_hint(*unit)),
            (
                "x points right",
                along_with(bool(np.all(right[:, 0] > 0)), millimetres),
                "the x axis is flipped: a step to the right must make x greater",
            ),
            (
                "y points up",
                along_with(bool(np.all(down[:, 1] < 0)), millimetres),
                "the y axis is flipped: a step down must make y smaller",
            ),
            (
                "steps add up",
                along_with(near(other, -3.25 * right + 2.5 * down), millimetres),
                "two steps together are not their sum",
            ),
        ],
    )


def _centre_hint(centres: np.ndarray, middles: np.ndarray) -> str:
    offset = np.abs(centres)
    if near(offset, 0.5) or near(offset[:, 0], 0.5) or near(offset[:, 1], 0.5):
        return "the centre of the image is half a pixel off"
    if near(offset, 1.0):
        return "the centre of the image is one pixel off: counting starts at 0"
    if near(offset, np.abs(middles - middles[:, ::-1])):
        return "the two numbers of image_size are exchanged: it is (columns, rows)"
    return "the centre of the image is not at (0, 0)"


def _unit_hint(x: np.ndarray, y: np.ndarray) -> str:
    for factor, unit in _UNITS:
        if near([x / factor, y / factor], 1.0):
            return f"the units are not millimetres, but {unit}"
    if any(near([x * factor, y * factor], 1.0) for factor in _FACTORS):
        return "the units are not millimetres (a power of ten is missing)"
    axis = "y" if near(x, 1.0) else "x" if near(y, 1.0) else "x and y"
    return f"a step of one pixel is not one pixel size long in {axis}"


def photo_to_pixel(function: Callable) -> None:
    """Check the reader's photo_to_pixel(photo, image_size, pixel_size)."""
    # No half pixel, which rounding moves up or down as it happens
    pixels = shaken(11, np.array([[0.0, 0.0], [5.0, 2.25], [10.25371, 6.14182]]))
    backs, made = [], []
    for image_size, pixel_size in _cameras(12):
        photo = frames.pixel_to_photo(pixels, image_size, pixel_size)
        backs.append(call(function, photo, image_size, pixel_size, shape=(3, 2)))
        centre, steps = frames.image_centre(image_size), photo * (1, -1)
        exact = steps / pixel_size
        from_centre = {
            "rows come back mirrored: this is (B 2.5b) as printed": exact * (1, -1),
            "columns come back mirrored": exact * (-1, 1),
            "millimetres must be divided by the size of a pixel": steps * pixel_size,
            "the centre of the image is not added": exact - centre,
            "the two numbers of image_size are exchanged": exact
            + centre[::-1]
            - centre,
            "the two pixel sizes are exchanged": steps / pixel_size[::-1],
            "the pixel size in y is another than that in x": steps / pixel_size[0],
        }
        made.append({hint: centre + one for hint, one in from_centre.items()})
    back = np.array(backs)
    rounded = "do not round: a point lies between pixel centres, too"
    slips: list[tuple[ArrayLike, str]] = [
        *(([one[hint] for one in made], hint) for hint in made[0]),
        (
            pixels[:, ::-1],
            "columns and rows are exchanged: the answer is (column, row)",
        ),
        *((pixels.round(k), rounded) for k in range(5)),
        (np.trunc(pixels + 1e-9), rounded),
        *((pixels + s, "the way back ends half a pixel off") for s in (0.5, -0.5)),
        *((pixels + s, "the way back ends one pixel off") for s in (1.0, -1.0)),
    ]
    hint = first_slip(back, slips, "the way there and back does not end where it began")
    report(
        "photo_to_pixel",
        [("pixel to photo to pixel ends where it began", near(back, pixels), hint)],
    )


def flying_height(function: Callable) -> None:
    """Check the reader's height(gsd_m, pixel_um, c_mm), which answers in metres."""
    cases = np.array([(0.2, 5.49, 24.0), (0.05, 4.0, 35.0), (0.1, 12.0, 153.0)])
    cases = shaken(13, cases)
    heights = np.array([float(call(function, *case, shape=())) for case in cases])
    expected = frames.flying_height(cases[:, 0], cases[:, 1] / 1000, cases[:, 2])
    ratio = heights / expected
    gsd, pixel, c = cases[0].tolist()
    twice = near(float(call(function, 2 * gsd, pixel, c, shape=())), 2 * heights[0])
    longer = near(float(call(function, gsd, pixel, 2 * c, shape=())), 2 * heights[0])
    if np.any(ratio <= 0):
        raise CheckFailed("height: a height above ground must be positive.")
    if not near(ratio, 1.0) and np.all(np.abs(ratio - 1) < 0.01):
        raise CheckFailed("height: almost; do not round inside the function.")
    decade = np.log10(ratio)
    wrong_unit = near(decade, np.round(decade)) and near(decade, decade[0])
    report(
        "height",
        [
            (
                "twice the GSD, twice the height",
                along_with(twice, longer),
                "twice the ground sampling distance must need twice the height",
            ),
            (
                "twice the principal distance, twice the height",
                along_with(longer, twice),
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

    def drawn(rng: np.random.Generator) -> list:
        return [
            (centre + rng.uniform(-1, 1, 2), rng.uniform(15, 60), rng.integers(2**32))
            for centre, _, _ in _TARGETS
        ]

    found, centres, left_in, clipped = [], [], [], []
    for centre, background, seed in varied(14, _TARGETS, drawn):
        clean = simulate.target(centre, 6.0, (21, 27), background=background)
        window = simulate.photograph(clean, noise=4.0, seed=int(seed))
        found.append(call(function, window, background, shape=(2,)))
        centres.append(scipy.ndimage.center_of_mass(window - background)[::-1])
        left_in.append(scipy.ndimage.center_of_mass(window)[::-1])
        weight = np.maximum(window - background, 0)
        clipped.append(scipy.ndimage.center_of_mass(weight)[::-1])
    answers, expected = np.array(found), np.array(centres)
    upwards = np.column_stack([expected[:, 0], 20 - expected[:, 1]])
    slips: list[tuple[ArrayLike, str]] = [
        (expected[:, ::-1], "row and column are exchanged: it is (column, row)"),
        (expected + 1.0, "one pixel off: the first pixel is number 0, not 1"),
        (expected + 0.5, "half a pixel off: integers are at pixel centres"),
        (upwards, "the row counts upwards; rows count down"),
        (
            left_in,
            "the background is still in: the weights are the grey values above it",
        ),
        (clipped, "weights below zero are noise too: keep them, or the sum is biased"),
        *((expected.round(k), "right, but rounded: keep all digits") for k in range(4)),
    ]
    largest = np.abs(answers - expected).max()
    other = f"a centre is missed by {largest:.2g} px: look at the weights and the sums"
    hint = first_slip(answers, slips, other)
    right = near(answers, expected)
    report("centroid", [("the weighted mean of three noisy targets", right, hint)])
