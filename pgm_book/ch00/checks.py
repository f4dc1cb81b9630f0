"""Check of the first exercise, chapter 0: change one number and run the cell again."""

from numpy.typing import ArrayLike

from pgm_book.common import checks
from pgm_book.common.checks import CheckFailed
from pgm_lab import datasets, frames

WANTED = 10


def tenth(point: object, computed: ArrayLike) -> None:
    """Check that the cell was run anew, with point 10."""
    number = float(checks.numbers("point", point))
    if number != WANTED:
        raise CheckFailed(
            f"point is {number:g}. Write `point = {WANTED}` in the cell above, in"
            " place of its second line, run it, then this one."
        )
    found = checks.numbers("computed", computed, (2,), "two numbers, x and y in mm")
    bani = datasets.bani2010()
    pixel_size = frames.pixel_size_from_sensor(bani.sensor_size, bani.image_size)
    left, right = (
        frames.pixel_to_photo(pixels[WANTED - 1], bani.image_size, pixel_size)
        for pixels in bani.pixels
    )
    report = checks.first_slip(
        found,
        [(right, "computed is point 10 of the right photo: set photo to 0 again")],
        f"computed is not what that cell gives for point {WANTED}: let its other lines"
        " be as they were, run it to its end, then this one",
    )
    checks.report(
        "point 10",
        [("you changed a number and ran its cell; y has the opposite sign here, too",
          checks.near(found, left), report)],
    )  # fmt: skip
