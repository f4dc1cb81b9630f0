"""Two photos as files, and results of a matching that was never made."""

from functools import cache

import numpy as np
from PIL import Image

from pgm_lab import matching, simulate

SIZE = (240, 200)
TURNED = (40, 0.95, 0.2, -15, -0.2, 0.95)


@cache
def pair():
    """Two photos (rows, columns) of 8 bit, the right one turned by 12 degrees."""
    texture = simulate.texture(seed=1)
    both = simulate.texture_pair(texture, SIZE[::-1], TURNED, sigma=1.0)
    return [np.clip(np.round(one), 0, 255).astype(np.uint8) for one in both]


def save(folder):
    """Return the photos of `pair` as two files."""
    paths = [folder / "left.png", folder / "right.png"]
    for path, photo in zip(paths, pair()):
        Image.fromarray(photo).save(path)
    return paths


def result(
    n=40, status=None, shift=(-30.0, 1.0), shape=None, size=SIZE, sd=0.04, **more
):
    """A Match of n points on a grid, all accepted unless a status says otherwise."""
    columns = int(np.ceil(np.sqrt(n)))
    place = np.stack(np.divmod(np.arange(n), columns)[::-1], axis=1) + 0.5
    chosen = np.round(place / columns * np.array(size))
    status = np.array(["accepted"] * n if status is None else status, "<U40")
    good = status == "accepted"
    values = {
        "chosen": chosen,
        "points": chosen + shift,
        "covariance": np.tile(sd**2 * np.eye(2), (n, 1, 1)),
        "shape": np.tile(np.eye(2) if shape is None else shape, (n, 1, 1)),
        "r": np.linspace(0.8, 0.99, n),
        "quality": np.linspace(0.6, 0.9, n),
    } | more
    for name in ("points", "covariance", "shape", "quality"):
        values[name] = np.array(values[name], float)
        values[name][~good] = np.nan
    sizes = {"left_size": size, "right_size": size}
    return matching.Match(status=status, **sizes | values)
