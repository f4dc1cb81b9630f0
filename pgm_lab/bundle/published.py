"""The network of Muliawan 2013: nine photos, fifty points, self-calibration."""

from collections.abc import Collection

import numpy as np

from pgm_lab import datasets
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
        All fifty points, even if the chosen photos do not see some.

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
    m = len(data.exteriors)
    kept = np.arange(m) if photos is None else np.unique(list(photos)) - 1
    if not np.isin(kept, np.arange(m)).all():
        raise ValueError(
            f"photos must be numbers from 1 to {m}; got {(kept + 1).tolist()}"
        )
    rays = np.isin(data.photo, kept)
    return Network(
        Camera(*data.interior),
        data.exteriors[kept],
        data.object_points,
        np.searchsorted(kept, data.photo[rays]),
        data.point[rays],
        data.xy[rays],
        data.sigma[rays],
        photo_names=(kept + 1).tolist(),
    )
