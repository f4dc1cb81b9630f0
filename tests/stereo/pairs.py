"""Pairs of images whose disparities are known exactly."""

import numpy as np

from pgm_lab import simulate

TEXTURE = simulate.texture(seed=3)


def drawn(columns, rows):
    """Grey values of the texture at (column, row)."""
    points = np.stack(np.broadcast_arrays(columns, rows), -1).astype(float)
    return simulate.grey_values(TEXTURE, points)


def smooth_pair(disparity, shape=(90, 120)):
    """Left and right image of a ground of which d = disparity(column, row)."""
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    x = columns
    for _ in range(60):  # the left column that each right pixel shows
        x = columns + disparity(x, rows)
    return drawn(columns, rows), drawn(x, rows), disparity(columns, rows)


def step_pair(low=4.0, high=12.0, block=(50, 90), shape=(90, 140)):
    """Left and right image of a wall that stands on a plain; truth; what it hides."""
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    first, last = block

    def wall(x):
        return (x >= first) & (x < last)

    # the wall has a texture of its own, so that nothing goes on behind it
    left = np.where(wall(columns), drawn(columns, rows + 500), drawn(columns, rows))
    near = wall(columns + high)
    right = np.where(
        near, drawn(columns + high, rows + 500), drawn(columns + low, rows)
    )
    truth = np.where(wall(columns), high, low)
    hidden = ~wall(columns) & wall(columns - low + high)
    return left, right, truth, hidden


def noisy(image, sigma, seed):
    return image + np.random.default_rng(seed).normal(0, sigma, image.shape)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values, dtype=float))))
