"""The network of Muliawan 2013: nine photos, fifty points, self-calibration."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from pgm_lab import datasets
from pgm_lab.bundle import Bundle, adjust
from pgm_lab.bundle.network import Network
from pgm_lab.camera import Camera


def network(photos: Collection[int] | None = None) -> Network:
    """Start values and image points as printed, of all photos or of some only.

    Parameters
    ----------
    photos : collection of int, optional
        Numbers of the photos, 1 to 9; all when missing.

    Returns
    -------
    Network
        With a single photo it has no points: see `Network.only`.

    Raises
    ------
    ValueError
        If there is no photo with such a number.

    References
    ----------
    Muliawan 2013, Tables 4.1 to 4.12.

    Examples
    --------
    >>> network().xy.shape, network([1, 4, 7]).xy.shape
    ((450, 2), (150, 2))
    """
    data = datasets.muliawan2013()
    image = data.photo, data.point, data.xy, data.sigma
    camera = (Camera(*data.interior),)
    whole = Network(camera, data.exteriors, data.object_points, *image)
    if photos is None:
        return whole
    m = len(data.exteriors)
    numbers = np.unique(list(photos))
    if not np.isin(numbers, np.arange(m) + 1).all():
        raise ValueError(
            f"photos must be numbers from 1 to {m}; got {numbers.tolist()}"
        )
    return whole.only(numbers - 1)


def wrong_control(found: Bundle, wrong: np.ndarray) -> np.ndarray:
    """RMS standard deviation and RMS shift (2, n) of twenty points, mm.

    The network is put on the ground by seven coordinates of three control points, the
    first of which is wrong by each of `wrong`, in mm.
    """
    control = np.array([0, 9, 30])
    hold = np.array([(0, 0, 0), (0, 0, 0), (np.inf, 0, np.inf)])
    outcome = []
    for mm in wrong:
        given = found.points[control] + np.array([(mm, 0, 0), (0, 0, 0), (0, 0, 0)])
        one = adjust(replace(network(), control=(control, given, hold)))
        shift = (one.points - found.points)[10:30]
        outcome.append([np.sqrt(np.mean(e**2)) for e in (one.sd_points[10:30], shift)])
    return np.transpose(outcome)
