"""A meadow with a house and two trees: something to look at through a turned camera."""

import numpy as np

from pgm_lab import _validate
from pgm_lab.plot import basic

GROUND = "#D3E3C2"  # of the fields around the meadow, to the horizon

Face = tuple[np.ndarray, str]  # a polygon (k, 3) and its colour


def village() -> list[Face]:
    """Polygons of a meadow 12 m x 12 m with a house and two trees, Y to the north.

    No symmetry hides a wrong rotation: the house stands in the south-west, a tall tree
    in the north-east, a small one in the south-east; a road runs west to east, and in
    the north-west an arrow and the letter N are painted on the grass.

    Returns
    -------
    list of (ndarray (k, 3), str)
        Polygons (X, Y, Z) in metres, Z up from the grass, and their colours.
    """
    faces = []
    for column in range(-6, 6):
        for row in range(-6, 6):
            tile = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
            green = "#C9DDB5" if (row + column) % 2 else "#DCE9CE"
            color = "#CFCFCF" if row == 0 else green
            faces.append((tile + (column, row, 0), color))
    faces += _north_arrow((-2.2, 1.2))
    faces += _house(np.array([-2.6, -2.4, 0.0]), np.array([1.8, 1.3, 1.0]))
    faces += _tree((2.0, 2.4), 0.8, 2.4)
    faces += _tree((2.4, -2.2), 0.5, 1.2)
    return faces


def surroundings(reach: int = 12) -> list[Face]:
    """Fields of 12 m x 12 m around the meadow, and the road that goes on, for a photo.

    They give the ground a scale and a direction as far as the eye can tell. In a
    drawing in space they would leave no room.

    Parameters
    ----------
    reach : int
        Fields to each side, 6 to 200.

    Returns
    -------
    list of (ndarray (k, 3), str)
        Polygons (X, Y, Z) in metres in the frame of `village`, and their colours.

    Raises
    ------
    ValueError
        If reach is no whole number from 6 to 200.
    """
    reach = _validate.whole(reach, "reach", 6, 200)
    field = 12.0 * np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]) - (6, 6, 0)
    places = range(-reach, reach + 1)
    dark = [(i, j) for i in places for j in places if (i + j) % 2]
    faces = [(field + (12 * i, 12 * j, 0), "#C6D8B2") for i, j in dark]
    far = 12.0 * reach + 6
    for west, east in ((-far, -6), (6, far)):
        road = [(west, 0, 0), (east, 0, 0), (east, 1, 0), (west, 1, 0)]
        faces.append((np.array(road), "#CFCFCF"))
    return faces


def _north_arrow(corner: tuple[float, float]) -> list[Face]:
    """An arrow to the north, 1.4 m long, and an N beside it, just above the grass."""
    arrow = [(0.2, 0), (0.35, 0), (0.35, 0.8), (0.55, 0.8), (0.275, 1.4)]
    arrow += [(0, 0.8), (0.2, 0.8)]
    stem = np.array([(0, 0), (0.15, 0), (0.15, 0.8), (0, 0.8)])
    diagonal = [(0, 0.8), (0.45, 0), (0.6, 0), (0.15, 0.8)]
    parts = [arrow, *(stem + (x, 0) for x in (0.75, 1.2)), np.add(diagonal, (0.75, 0))]
    flat = [np.column_stack([np.add(p, corner), np.full(len(p), 0.01)]) for p in parts]
    return [(polygon, basic.BLACK) for polygon in flat]


def _house(corner: np.ndarray, size: np.ndarray) -> list[Face]:
    base = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    low = corner + np.column_stack([base, np.zeros(4)]) * size
    high = corner + np.column_stack([base, np.ones(4)]) * size
    # The ridge runs along x, half the width of the house above the eaves
    ridge = corner + np.array([(0, 0.5, 1), (1, 0.5, 1)]) * size + (0, 0, size[1] / 2)
    walls = [(low[[i, j]], high[[j, i]]) for i, j in ((0, 1), (1, 2), (2, 3), (3, 0))]
    shades = ("#F0DFC0", "#DCC79F", "#F0DFC0", "#DCC79F")
    faces = [(np.concatenate(w), shade) for w, shade in zip(walls, shades)]
    faces += [(np.array([high[1], high[2], ridge[1]]), "#DCC79F")]
    faces += [(np.array([high[3], high[0], ridge[0]]), "#DCC79F")]
    faces += [(np.array([high[0], high[1], ridge[1], ridge[0]]), basic.RED)]
    faces += [(np.array([high[2], high[3], ridge[0], ridge[1]]), "#A84A00")]
    return faces


def _tree(place: tuple[float, float], radius: float, height: float) -> list[Face]:
    turn = np.linspace(0, 2 * np.pi, 9)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(9)])
    rim = np.array([*place, 0.2 * height]) + radius * circle
    top = np.array([*place, height])
    shades = ("#00805F", "#009E73", "#2CB48C", "#009E73")
    return [(np.array([rim[i], rim[i + 1], top]), shades[i // 2]) for i in range(8)]
