"""What goes wrong on the way from a row of disparities to object points."""

import numpy as np

from pgm_lab.stereo import NormalPair


def slips_of_a_row(
    pair: NormalPair, wanted: np.ndarray
) -> list[tuple[np.ndarray, str]]:
    """Points (n, 3) that a slip leads to, with what to say of it."""
    model = (wanted - pair.stations[0]) @ pair.rotation.T
    return [
        (model, "that is seen from O', in the frame of the photos: turn it and add O'"),
        (wanted - pair.stations[0], "the place of O' has to be added"),
        (pair.stations[0] + model, "the model has to be turned into object space"),
        (
            pair.stations[0] + model @ pair.rotation.T,
            "pair.rotation turns object space into the photos; here: the other way",
        ),
        (
            pair.stations[1] + model @ pair.rotation,
            "stations[1] is O'': the model is seen from O'",
        ),
        (
            (pair.stations[0] + model) @ pair.rotation,
            "the model is turned first, and the place of O' added afterwards",
        ),
        (
            pair.stations[0] + model[:, [1, 0, 2]] @ pair.rotation,
            "x and y are exchanged: x runs along the columns",
        ),
        (
            pair.stations[0] + _without_origin(pair, model) @ pair.rotation,
            "the parallax in mm is more than disparity times pixel size: the two images"
            " begin at different places, and pair.parallax knows it",
        ),
        (
            np.full_like(wanted, np.nan),
            "every row is still NaN: fill points[i], and see that exercise 8.4 has"
            " passed, whose search it needs",
        ),
    ]


def _without_origin(pair: NormalPair, model: np.ndarray) -> np.ndarray:
    """Model points (n, 3) of parallaxes that count from the edges of the images."""
    parallax = -pair.base * pair.c / model[:, 2]
    shift = pair.origin[0, 0] - pair.origin[1, 0]
    return np.asarray(model * (parallax / np.abs(parallax - shift))[:, None])
