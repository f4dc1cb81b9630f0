"""A pair of photos and level ground, small, for tests of answers and figures."""

import numpy as np

from pgm_lab import datasets, simulate, stereo


def normal_pair():
    ortho = datasets.yellowstone().grey[:60, :60].astype(float)
    origin = np.array([(2.0, 0.0), (-4.0, 0.0)])
    stations = np.array([(0.0, 0, 1000), (400.0, 0, 1000)])
    return stereo.NormalPair(ortho, ortho, np.eye(3), stations, 24.0, 0.005, origin)


def level_land():
    flat = np.full((40, 40), 20.0, np.float32)
    return simulate.Landscape(flat, flat, flat, flat, (-200.0, 200.0), 10.0)
