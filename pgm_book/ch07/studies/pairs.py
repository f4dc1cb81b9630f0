"""Pairs of ortho images with known truth for the experiments of chapter 7."""

from functools import cache

import numpy as np

from pgm_lab import datasets, matching, simulate

NUMBER = 50  # chips of a pair, as in Brahmantara 2015
CHIP, RADIUS = 21, 3
MARGIN = 30  # px from the edges of the image, further than any chip here is sought
BAND_LIMITED, ALIASED = 0.7, 0.0  # px, blur before the sampling
GAIN, NOISE = 0.9, 15.0


@cache
def scene() -> np.ndarray:
    """The satellite image out of which the pairs are made."""
    return datasets.landsat().grey


def pair(
    shift: tuple[int, int], factor: int, blur: float, seed: int = 0, **change: float
) -> simulate.OrthoPair:
    """Pair with gain 0.9 and a noise of 15 grey values, in 16 bit."""
    how = {"gain": GAIN, "sigma": NOISE, **change}
    return simulate.ortho_pair(
        scene(), shift, factor, blur=blur, dtype=np.uint16, seed=seed, **how
    )


def picked(reference: np.ndarray, number: int = NUMBER) -> np.ndarray:
    """Chips on crossings of roads, as it were: texture in all directions."""
    return matching.pick(reference, number, CHIP, margin=MARGIN)


def random(reference: np.ndarray, number: int = NUMBER, seed: int = 0) -> np.ndarray:
    """Chips anywhere."""
    rows, columns = reference.shape
    highest = columns - MARGIN, rows - MARGIN
    rng = np.random.default_rng([7, seed])
    return rng.integers(MARGIN, highest, (number, 2)).astype(float)


def on_grid(reference: np.ndarray, step: int = CHIP) -> np.ndarray:
    """Chips side by side."""
    at = [np.arange(MARGIN, n - MARGIN, float(step)) for n in reference.shape[::-1]]
    return np.stack(np.meshgrid(*at), axis=-1).reshape(-1, 2)
