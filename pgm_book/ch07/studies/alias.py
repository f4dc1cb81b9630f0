"""What an alias does to a registration, by the fraction of the shift.

``python -m pgm_book.ch07.studies.alias`` writes results/alias.csv
within a minute; tests/ch07/test_studies.py repeats a part.

A wave of f > 0.5 cycles a pixel looks like one of 1 - f that runs the other way. Moved
back by the shift s, it is not where it was but ahead by a phase of 2 pi s, whatever its
frequency. To first order its share in the slope of the correlation is proportional to
sin(2 pi s): the mean error draws towards whole pixels, most at a quarter, and vanishes
at a half. What alias and ground have in common in a chip is a matter of chance, and by
how much it changes is |1 - exp(2 pi i s)| = 2 |sin(pi s)|: the scatter is largest at a
half. Smoothing both images takes the high frequencies, where most of the alias is.
"""

from collections.abc import Iterator

import numpy as np

from pgm_book.ch07.studies import pairs
from pgm_book.common import study
from pgm_lab import registration

FACTORS = (4, 6, 8)
BLURS = (pairs.ALIASED, 0.5, pairs.BAND_LIMITED)
METHODS = {
    "parabola": {"refine": "parabola"},
    "lsm": {"refine": "lsm", "smooth": 0.0},
    "lsm, smoothed": {"refine": "lsm"},
}
COLUMNS = (
    *("factor", "blur", "method", "fraction", "chips", "accepted"),
    *("mean", "spread", "mean_y"),
)


def rows(factor: int, blur: float, step: int = 1) -> Iterator[tuple]:
    """Rows of the table: fractions of the shift in x, none in y, hardly any noise."""
    for part in range(0, factor, step):
        pair = pairs.pair((part, 0), factor, blur, seed=part, sigma=1.0)
        points = pairs.picked(pair.reference)
        for method, how in METHODS.items():
            found = registration.register(pair.reference, pair.sensed, points, **how)
            good = found.accepted
            x, y = found.dx[good] - pair.shift[0], found.dy[good] - pair.shift[1]
            yield (
                *(factor, blur, method, f"{part / factor:.4f}"),
                *(len(points), f"{good.mean():.2f}"),
                # The spread by the median: a single chip gone astray is another matter
                *(f"{x.mean():.4f}", f"{spread(x):.4f}", f"{y.mean():.4f}"),
            )


def spread(x: np.ndarray) -> float:
    """Robust standard deviation."""
    return registration.accuracy(x, x).spread_x


if __name__ == "__main__":
    every = (row for f in FACTORS for blur in BLURS for row in rows(f, blur))
    study.write("ch07", "alias", COLUMNS, every)
